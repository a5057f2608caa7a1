//! Files that the flags of a study's steps name: each lies beside the study, and its content is part of the case.

use crate::commands::test_file;
use serde_json::Value;
use std::path::Path;

/// Flags whose value may be a file that determines the result.
pub(super) const FLAGS: [&str; 4] = ["materials", "phases", "test", "analysis"];
/// Ending of the key with a file's hash.
const HASH: &str = "-sha256";

/// The files that the values of a flag name.
pub(super) fn of<'a>(flag: &'a str, value: &'a Value) -> impl Iterator<Item = &'a str> {
    let values = value.as_array().map_or(std::slice::from_ref(value), Vec::as_slice);
    values.iter().filter_map(Value::as_str).filter(move |text| is_file(flag, text))
}

/// Whether the value of a flag is a file; a test or an analysis has a name or a file.
pub(super) fn is_file(flag: &str, value: &str) -> bool {
    match flag {
        "test" | "analysis" => test_file::is_toml(Path::new(value)),
        _ => FLAGS.contains(&flag),
    }
}

/// The tables that a TEST.toml names beside itself; a file that cannot be read has none here, and fails later.
pub(super) fn tables(flag: &str, file: &Path) -> Vec<String> {
    let is_test = matches!(flag, "test" | "analysis");
    if is_test { test_file::tables(file).unwrap_or_default() } else { Vec::new() }
}

/// The key of a task with the hash of a flag's file.
pub(super) fn hash_key(flag: &str) -> String {
    format!("{flag}{HASH}")
}

/// Whether a key of a task is such a hash.
pub(super) fn is_hash(key: &str) -> bool {
    key.strip_suffix(HASH).is_some_and(|flag| FLAGS.contains(&flag))
}
