//! The record of a case in its folder: `case.json`, written last and as a whole.

use crate::case::Case;
use meso_files::whole::{Keeper, Output, UNFINISHED, Unit};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Name of the record in a case's folder.
pub const RECORD: &str = "case.json";
/// Name of the saved model in a case's folder.
pub const MODEL: &str = "model.json";

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
    /// How it ended.
    pub status: Status,
    /// Why it failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Its results.
    pub results: Map<String, Value>,
    /// Every other file of the folder and its length, bytes.
    pub files: BTreeMap<String, u64>,
}

/// How a case ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// With its results.
    Done,
    /// With an error, which is kept.
    Failed,
}

/// An error of a case, as its record keeps it.
pub type Failed = String;

/// State of a case according to its folder.
#[derive(Clone, Debug, PartialEq)]
pub enum State {
    /// Nothing is there, or what a killed run left.
    Open,
    /// The packing is there; what is done with it has changed.
    Packed,
    /// Done or failed: nothing is left to do.
    Over(Box<Record>),
}

impl Record {
    /// The record of a case whose files are all in `folder`.
    ///
    /// # Errors
    /// Where the folder cannot be read.
    pub fn new(case: &Case, then: &str, ended: Result<Map<String, Value>, Failed>, folder: &Path) -> io::Result<Self> {
        let status = if ended.is_ok() { Status::Done } else { Status::Failed };
        let error = ended.as_ref().err().cloned();
        Ok(Self {
            mesocrete: env!("CARGO_PKG_VERSION").to_owned(),
            case: case.folder.clone(),
            hash: case.hash.clone(),
            then: then.to_owned(),
            values: case.values.iter().cloned().collect(),
            status,
            error,
            results: ended.unwrap_or_default(),
            files: files(folder)?,
        })
    }

    /// Writes the record into `folder`, whole or not at all; `keeper` knows of temporary files.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn save<K: Keeper>(&self, folder: &Path, keeper: K) -> io::Result<()> {
        save(folder, RECORD, Unit::unforced(keeper), |file| {
            serde_json::to_writer_pretty(&mut *file, self)?;
            writeln!(file)
        })
    }
}

impl State {
    /// Looks into a case's `folder`; `then` as in [`Record`]. Files that are not as long as their record says count as
    /// absent: a machine that lost its power may leave such.
    pub fn of(case: &Case, then: &str, folder: &Path) -> Self {
        let Ok(bytes) = std::fs::read(folder.join(RECORD)) else { return Self::Open };
        let Ok(record) = serde_json::from_slice::<Record>(&bytes) else { return Self::Open };
        let is_whole = |name: &str| {
            let length = std::fs::metadata(folder.join(name)).map(|file| file.len());
            record.files.get(name).is_some_and(|wanted| length.is_ok_and(|length| length == *wanted))
        };
        if record.hash != case.hash {
            return Self::Open;
        }
        if record.then == then && record.files.keys().all(|name| is_whole(name)) {
            return Self::Over(Box::new(record));
        }
        if is_whole(MODEL) { Self::Packed } else { Self::Open }
    }

    /// Empties `folder` of what a killed run left, and makes it where it is not there; a packing that counts is kept.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn prepare(&self, folder: &Path) -> io::Result<()> {
        std::fs::create_dir_all(folder)?;
        for name in [RECORD, MODEL] {
            if name == RECORD || *self == Self::Open {
                remove(&folder.join(name))?;
            }
        }
        for entry in std::fs::read_dir(folder)? {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().into_owned();
            if is_unfinished(&name) {
                remove(&entry.path())?;
            }
        }
        Ok(())
    }
}

fn is_unfinished(name: &str) -> bool {
    name.starts_with(UNFINISHED.0) && name.ends_with(UNFINISHED.1)
}

fn remove(path: &Path) -> io::Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Every file in `folder` but the record, and its length.
fn files(folder: &Path) -> io::Result<BTreeMap<String, u64>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let (name, data) = (entry.file_name().to_string_lossy().into_owned(), entry.metadata()?);
        if data.is_file() && name != RECORD && !is_unfinished(&name) {
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
