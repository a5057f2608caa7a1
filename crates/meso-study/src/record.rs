//! The record of a case in its folder: `case.json`, written last and as a whole.

use crate::case::{Case, digest};
use crate::results::repeated;
use meso_files::whole::{Keeper, Output, UNFINISHED, Unit};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Name of the record in a case's folder.
pub const RECORD: &str = "case.json";
/// Names that the saved model of a case may have.
pub const MODELS: [&str; 2] = ["model.json", "model.json.gz"];

/// The packing that a finished case keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Keep {
    /// As `model.json`, so that other work can start from it.
    #[default]
    #[serde(rename = "json")]
    Json,
    /// As `model.json.gz`, in less than half of the space.
    #[serde(rename = "json.gz")]
    JsonGz,
    /// None: other work on the case packs anew.
    #[serde(rename = "none")]
    None,
}

impl Keep {
    /// Name of the saved model while the case is at work.
    pub fn model(self) -> &'static str {
        MODELS[usize::from(self == Self::JsonGz)]
    }

    /// Removes the saved model of a finished case, unless it is kept.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn tidy(self, folder: &Path) -> io::Result<()> {
        if self == Self::None { remove(&folder.join(self.model())) } else { Ok(()) }
    }
}
/// Name of a test's curve in a case's folder.
pub const CURVE: &str = "curve.csv";

/// The result of a case. It holds no times, so that a case has the same record wherever it ran.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Version of mesocrete.
    pub mesocrete: String,
    /// Name of the folder.
    pub case: String,
    /// Hash of the complete spec and task.
    pub hash: String,
    /// Work on the packing beyond the task, e.g. the fingerprint of a Python function; empty for none.
    pub then: String,
    /// The axes' values.
    pub values: Map<String, Value>,
    /// Whether the case has its results.
    pub status: Status,
    /// Why the case failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Warnings of the spec, the mesh and the test.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// The results; empty where the case failed.
    pub results: Map<String, Value>,
    /// Every other file of the folder and its length, bytes.
    pub files: BTreeMap<String, u64>,
    /// SHA-256 of the saved model, which other work may start from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model_sha256: Option<String>,
    /// SHA-256 of the curve of a test, which a fit reads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curve_sha256: Option<String>,
    /// SHA-256 of this record as compact JSON with an empty `sha256`. A damaged record counts as absent.
    #[serde(default)]
    pub sha256: String,
}

/// How a case ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// The case has its results.
    Done,
    /// The case has an error, which is kept.
    Failed,
}

/// An error of a case, as its record keeps it.
pub type Failed = String;

/// Results or failure of a case, and its warnings.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseOutcome {
    /// The results, or the message of the failure.
    pub results: Result<Map<String, Value>, Failed>,
    /// Warnings on the way.
    pub warnings: Vec<String>,
}

/// State of a case according to its folder.
#[derive(Clone, Debug, PartialEq)]
pub enum CaseState {
    /// The folder is empty, or holds the remains of a killed run.
    Open,
    /// The packing is complete; the work on it has changed.
    Packed,
    /// Done or failed: nothing is left to do.
    Over(Box<Record>),
}

impl From<Result<Map<String, Value>, Failed>> for CaseOutcome {
    fn from(results: Result<Map<String, Value>, Failed>) -> Self {
        Self { results, warnings: Vec::new() }
    }
}

impl Record {
    /// The record of a case whose files are all in `folder`.
    ///
    /// Results of which a table could keep only one fail the case.
    ///
    /// # Errors
    /// Where the folder cannot be read.
    pub fn new(case: &Case, then: &str, outcome: CaseOutcome, folder: &Path) -> io::Result<Self> {
        let results = outcome.results.and_then(|results| match repeated(&results) {
            Some(name) => Err(format!("two results have the name {name:?} in the table; rename one of them")),
            None => Ok(results),
        });
        let mut record = Self {
            mesocrete: env!("CARGO_PKG_VERSION").to_owned(),
            case: case.folder.clone(),
            hash: case.hash.clone(),
            then: then.to_owned(),
            values: case.values.iter().cloned().collect(),
            status: if results.is_ok() { Status::Done } else { Status::Failed },
            error: results.as_ref().err().cloned(),
            warnings: case.spec.doubts().into_iter().chain(outcome.warnings).collect(),
            results: results.unwrap_or_default(),
            files: files(folder)?,
            model_sha256: None,
            curve_sha256: None,
            sha256: String::new(),
        };
        let has_curve = record.files.contains_key(CURVE);
        record.model_sha256 = record.model().map(|name| digest_of(folder, name)).transpose()?;
        record.curve_sha256 = has_curve.then(|| digest_of(folder, CURVE)).transpose()?;
        record.sha256 = record.seal();
        Ok(record)
    }

    /// Reads the record in `folder`; `None` where it is missing, torn or damaged.
    fn read(folder: &Path) -> Option<Self> {
        Self::sound(&std::fs::read(folder.join(RECORD)).ok()?)
    }

    /// Reads a record; `None` where it is torn or damaged.
    pub(crate) fn sound(bytes: &[u8]) -> Option<Self> {
        let record: Self = serde_json::from_slice(bytes).ok()?;
        (record.sha256 == record.seal()).then_some(record)
    }

    /// The record of a case whose files are not kept.
    pub(crate) fn without_files(self) -> Self {
        let mut record = Self { files: BTreeMap::new(), model_sha256: None, curve_sha256: None, ..self };
        record.sha256 = record.seal();
        record
    }

    /// Hash of all other fields.
    fn seal(&self) -> String {
        let bare = Self { sha256: String::new(), ..self.clone() };
        digest(serde_json::to_string(&bare).expect("a record is a tree of values").as_bytes())
    }

    /// Writes the record into `folder`, whole or not at all; `keeper` removes temporary files after a signal.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn save<K: Keeper>(&self, folder: &Path, keeper: K) -> io::Result<()> {
        save(folder, RECORD, Unit::unforced(keeper), |file| {
            serde_json::to_writer_pretty(&mut *file, self)?;
            writeln!(file)
        })
    }

    /// Name of the saved model among the files.
    pub fn model(&self) -> Option<&'static str> {
        MODELS.into_iter().find(|name| self.files.contains_key(*name))
    }

    /// Whether the saved model in `folder` is the recorded one, byte for byte.
    pub(crate) fn has_model(&self, folder: &Path) -> bool {
        self.model().is_some_and(|name| digest_of(folder, name).ok() == self.model_sha256)
    }

    /// Whether the curve in `folder` is the recorded one, byte for byte.
    pub fn has_curve(&self, folder: &Path) -> bool {
        self.curve_sha256.is_some() && digest_of(folder, CURVE).ok() == self.curve_sha256
    }
}

fn digest_of(folder: &Path, name: &str) -> io::Result<String> {
    Ok(digest(&std::fs::read(folder.join(name))?))
}

impl CaseState {
    /// Looks into a case's `folder`; `then` is the field of [`Record`]. Files that are shorter or longer than recorded count
    /// as absent: a power failure may leave such.
    pub fn of(case: &Case, then: &str, folder: &Path) -> Self {
        let Some(record) = Record::read(folder).filter(|record| record.hash == case.hash) else { return Self::Open };
        let is_whole = |(name, length): (&String, &u64)| {
            std::fs::metadata(folder.join(name)).is_ok_and(|file| file.len() == *length)
        };
        if record.then == then && record.files.iter().all(is_whole) {
            return Self::Over(Box::new(record));
        }
        if record.has_model(folder) { Self::Packed } else { Self::Open }
    }

    /// Makes `folder` where it is missing, and removes the record and the remains of a killed run; a packing that counts is
    /// kept.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn prepare(&self, folder: &Path) -> io::Result<()> {
        std::fs::create_dir_all(folder)?;
        remove(&folder.join(RECORD))?;
        if *self == Self::Open {
            MODELS.iter().try_for_each(|name| remove(&folder.join(name)))?;
        }
        for entry in std::fs::read_dir(folder)? {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().into_owned();
            if is_hidden(&name) && name.ends_with(UNFINISHED.1) {
                remove(&entry.path())?;
            }
        }
        Ok(())
    }
}

/// Whether a file is one of our temporary files or locks.
fn is_hidden(name: &str) -> bool {
    name.starts_with(UNFINISHED.0)
}

/// Opens the failed cases of a folder again.
///
/// # Errors
/// Errors of the file system.
pub(crate) fn reopen_failed(cases: &Path) -> io::Result<()> {
    let entries = match std::fs::read_dir(cases) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        entries => entries?,
    };
    for entry in entries {
        let folder = entry?.path();
        if Record::read(&folder).is_some_and(|record| record.status == Status::Failed) {
            remove(&folder.join(RECORD))?;
        }
    }
    Ok(())
}

fn remove(path: &Path) -> io::Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Every file in `folder` but the record and hidden ones, and its length.
fn files(folder: &Path) -> io::Result<BTreeMap<String, u64>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let (name, data) = (entry.file_name().to_string_lossy().into_owned(), entry.metadata()?);
        if data.is_file() && name != RECORD && !is_hidden(&name) {
            found.insert(name, data.len());
        }
    }
    Ok(found)
}

/// Writes a file into `out` as the only one of `unit`, whole or not at all.
pub(crate) fn save<K: Keeper>(
    out: &Path,
    name: &str,
    mut unit: Unit<K>,
    write: impl FnOnce(&mut BufWriter<Output<'_, K>>) -> io::Result<()>,
) -> io::Result<()> {
    unit.fill(&out.join(name), true, write)?;
    unit.commit().map_err(|(_, error)| error)
}
