//! Files that the options of a study's steps name: each lies beside the study, and its content is part of the case.

use crate::digest;
use crate::plan::STEPS;
use meso_ask::AskError;
use meso_ask::files::{is_toml, tables};
use meso_core::spec::Files;
use meso_files::Beside;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Options whose value may be a file that determines the result.
const OPTIONS: [&str; 4] = ["materials", "phases", "test", "analysis"];
/// Ending of the key with a file's hash.
const HASH: &str = "-sha256";

/// The files that the values of an option name.
fn of<'a>(option: &'a str, value: &'a Value) -> impl Iterator<Item = &'a str> {
    let values = value.as_array().map_or(std::slice::from_ref(value), Vec::as_slice);
    values.iter().filter_map(Value::as_str).filter(move |text| is_file(option, text))
}

/// Whether the value of an option is a file; a test or an analysis has a name or a file.
fn is_file(option: &str, value: &str) -> bool {
    match option {
        "test" | "analysis" => is_toml(Path::new(value)),
        _ => OPTIONS.contains(&option),
    }
}

/// Reads the text of a file.
///
/// # Errors
/// A file that cannot be read, and one that is no text.
pub fn read_text(path: &Path) -> Result<String, AskError> {
    Beside(Path::new("")).text(&path.to_string_lossy()).map_err(AskError::Run)
}

/// The files that tasks name, by their hashes.
pub struct NamedFiles<'a> {
    folder: &'a Path,
    /// Hashes of the files read so far.
    digests: BTreeMap<PathBuf, String>,
}

impl<'a> NamedFiles<'a> {
    /// The files in a folder.
    pub fn beside(folder: &'a Path) -> Self {
        Self { folder, digests: BTreeMap::new() }
    }

    /// Adds to a task the hash of each file that it names: the content of the file decides, not its name.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn complete(&mut self, task: &mut Value) -> Result<(), String> {
        for section in STEPS.into_iter().filter(|name| task.get(name).is_some()).collect::<Vec<_>>() {
            for option in OPTIONS {
                let files = of(option, &task[section][option]);
                let hashes = files.map(|file| self.hash_whole(option, file)).collect::<Result<Vec<_>, _>>()?;
                if !hashes.is_empty() {
                    task[section][format!("{option}{HASH}")] = hashes.join(" ").into();
                }
            }
        }
        Ok(())
    }

    /// Hash of an option's file, and of the tables that a TEST.toml names. A file that cannot be read has none here, and fails
    /// later.
    fn hash_whole(&mut self, option: &str, file: &str) -> Result<String, String> {
        let mut hashes = vec![self.hash(Path::new(file))?];
        let folder = Path::new(file).parent().unwrap_or(Path::new(""));
        let is_test = matches!(option, "test" | "analysis");
        let named = if is_test { tables(&self.folder.join(file), &read_text).unwrap_or_default() } else { Vec::new() };
        for table in named {
            hashes.push(self.hash(&folder.join(table))?);
        }
        Ok(hashes.join("+"))
    }

    fn hash(&mut self, file: &Path) -> Result<String, String> {
        let path = self.folder.join(file);
        if let Some(known) = self.digests.get(&path) {
            return Ok(known.clone());
        }
        // A pipe or a device would be read without end.
        let bytes = Beside(Path::new("")).read(&path.to_string_lossy()).map_err(|error| error.to_string())?;
        Ok(self.digests.entry(path).or_insert(digest(&bytes)).clone())
    }
}
