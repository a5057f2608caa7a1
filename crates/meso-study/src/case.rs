//! One case: the complete spec, its hash and the name of its folder.

use meso_pack::Spec;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
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
    pub(crate) fn new(values: &[(&str, &Value)], spec: Spec, task: Value) -> Self {
        let spec_tree = serde_json::to_value(&spec).expect("a spec is a tree of values");
        let whole = json!({ "mesocrete": env!("CARGO_PKG_VERSION"), "spec": spec_tree, "task": task });
        let hash = digest(whole.to_string().as_bytes());
        let folder = folder(values, &hash);
        let values = values.iter().map(|(key, value)| ((*key).to_owned(), (*value).clone())).collect();
        Self { folder, hash, values, spec, task }
    }
}

/// SHA-256 of `bytes` in hexadecimal digits.
pub fn digest(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
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
