//! One case: the complete spec, its hash and the name of its folder.

use meso_pack::Spec;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};

/// Characters of a folder's name before the hash.
const LONGEST_LABEL: usize = 100;
/// Digits of the hash in a folder's name. With 64 bits, two of a million cases agree once in 37 million studies.
const SHORT_HASH: usize = 16;

/// One combination of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Name of the case's folder: its values and the first digits of its hash.
    pub folder: String,
    /// SHA-256, in hexadecimal digits, of version, complete spec and task as JSON with sorted keys.
    pub hash: String,
    /// The axes' values, in the axes' order.
    pub values: Vec<(String, Value)>,
    /// The complete spec.
    pub spec: Spec,
    /// The steps after the packing.
    pub task: Value,
}

impl Case {
    pub(crate) fn new(values: &[(&str, &Value)], spec: Spec, task: Value, texts: &mut SpecTexts) -> Self {
        let version = env!("CARGO_PKG_VERSION");
        let whole = format!(r#"{{"mesocrete":"{version}","spec":{},"task":{task}}}"#, texts.of(&spec));
        let hash = digest(whole.as_bytes());
        let folder = folder(values, &hash);
        let values = values.iter().map(|(key, value)| ((*key).to_owned(), (*value).clone())).collect();
        Self { folder, hash, values, spec, task }
    }
}

/// Texts of specs, one after the other. Two that differ in their seeds have one text but for these.
#[derive(Default)]
pub(crate) struct SpecTexts {
    /// The spec before, and its text up to the seed and from there on.
    last: Option<(Spec, [String; 2])>,
}

impl SpecTexts {
    fn of(&mut self, spec: &Spec) -> String {
        if let Some((last, [before, behind])) = &mut self.last {
            last.seed = spec.seed;
            if last == spec {
                return format!("{before}{}{behind}", spec.seed);
            }
        }
        let text = spec.sorted_json();
        let seed = format!("\"seed\":{}", spec.seed);
        self.last = text.split_once(&seed).map(|(before, behind)| {
            (spec.clone(), [before.to_owned() + &seed[..r#""seed":"#.len()], behind.to_owned()])
        });
        text
    }
}

/// SHA-256 of `bytes` in hexadecimal digits.
pub fn digest(bytes: &[u8]) -> String {
    let digit = |half: u8| char::from(b"0123456789abcdef"[usize::from(half)]);
    Sha256::digest(bytes).iter().flat_map(|byte| [digit(byte >> 4), digit(byte & 15)]).collect()
}

/// `seed-3_fraction-0.4_1a2b3c4d5e6f7a8b`: the name depends only on the case, so a longer axis keeps existing folders.
fn folder(values: &[(&str, &Value)], hash: &str) -> String {
    let labels = values.iter().map(|(key, value)| format!("{}-{}", last(key), label(value)));
    let mut name: String = labels.collect::<Vec<_>>().join("_").chars().take(LONGEST_LABEL).collect();
    if !name.is_empty() {
        name.push('_');
    }
    name + &hash[..SHORT_HASH]
}

fn last(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}

/// A value in letters that every file system accepts.
fn label(value: &Value) -> String {
    let text = match value {
        Value::String(text) => text.clone(),
        // A section gives its variant and a list its length; the hash separates the rest.
        Value::Object(map) => map.get("kind").and_then(Value::as_str).unwrap_or("table").to_owned(),
        Value::Array(items) => format!("list{}", items.len()),
        scalar => scalar.to_string(),
    };
    let allowed = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '+');
    text.chars().map(|c| if allowed(c) { c } else { '-' }).collect()
}
