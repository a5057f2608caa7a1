//! The records of a study in one file, in place of a folder for each case.
//!
//! Whoever ends a case appends its record in one piece, while it has the study's folder alone. A line that a kill or a full disk
//! has torn counts as absent. At the end the lines are put in an order that no process decides.

use crate::case::Case;
use crate::record::{CaseState, RECORD, Record, save};
use meso_files::whole::{Keeper, Unit};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, BufRead, BufReader, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::Path;

/// Name of the file, with one record a line.
pub const RECORDS: &str = "records.jsonl";

/// How the cases of a study are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StudyLayout {
    /// A folder for each case, with its files and its record.
    Folders,
    /// One file with the records of all cases; the other files of a finished case are removed.
    Table,
}

/// How much of the records has been read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Seen {
    file: u64,
    bytes: u64,
}

impl StudyLayout {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Folders, Self::Table];

    /// The word that users have for it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Folders => "folders",
            Self::Table => "table",
        }
    }

    /// The layout of a word.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|layout| layout.name() == name)
    }

    /// The layout of the study in a folder.
    pub fn of(out: &Path) -> Self {
        if out.join(RECORDS).is_file() { Self::Table } else { Self::Folders }
    }

    /// Makes `out` a study of this layout; false where one of the other has begun.
    pub(crate) fn begin(self, out: &Path) -> io::Result<bool> {
        if self == Self::Table && Self::of(out) == Self::Folders {
            for entry in std::fs::read_dir(out)? {
                if entry?.path().join(RECORD).is_file() {
                    return Ok(false);
                }
            }
            OpenOptions::new().create(true).append(true).open(out.join(RECORDS))?;
        }
        Ok(self == Self::of(out))
    }
}

/// Tells the whole records of `out` that were not `seen`, from the oldest to the newest.
pub(crate) fn read(out: &Path, seen: &mut Seen, tell: &mut dyn FnMut(Record)) -> io::Result<()> {
    let file = match File::open(out.join(RECORDS)) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        file => file?,
    };
    // Another file in its place has another order.
    let number = number(&file.metadata()?);
    if seen.file != number {
        *seen = Seen { file: number, bytes: 0 };
    }
    let mut lines = BufReader::new(file);
    lines.seek(SeekFrom::Start(seen.bytes))?;
    let mut line = Vec::new();
    while lines.read_until(b'\n', &mut line)? > 0 && line.ends_with(b"\n") {
        seen.bytes += line.len() as u64;
        Record::sound(&line).map(&mut *tell);
        line.clear();
    }
    Ok(())
}

/// State of a case by the records that were not `seen`.
pub(crate) fn state(case: &Case, then: &str, out: &Path, mut seen: Seen) -> io::Result<CaseState> {
    let mut state = CaseState::Open;
    let mut look = |record: Record| {
        if record.hash == case.hash && record.then == then {
            state = CaseState::Over(Box::new(record));
        }
    };
    read(out, &mut seen, &mut look)?;
    Ok(state)
}

/// Appends a record; no other process writes meanwhile.
pub(crate) fn append(out: &Path, record: &Record) -> io::Result<()> {
    let mut file = OpenOptions::new().read(true).append(true).open(out.join(RECORDS))?;
    let mut last = [b'\n'];
    if file.seek(SeekFrom::End(0))? > 0 {
        file.seek(SeekFrom::End(-1))?;
        file.read_exact(&mut last)?;
    }
    let torn: &[u8] = if last == [b'\n'] { b"" } else { b"\n" };
    file.write_all(&[torn, &serde_json::to_vec(record)?, b"\n"].concat())
}

/// Puts the records in the order of their cases, the newest of each; no other process writes meanwhile.
pub(crate) fn tidy(out: &Path, keeper: impl Keeper) -> io::Result<()> {
    let mut lines = BTreeMap::new();
    let line = |record: &Record| serde_json::to_vec(record).unwrap_or_default();
    read(out, &mut Seen::default(), &mut |record| {
        lines.insert((record.case.clone(), record.hash.clone(), record.then.clone()), line(&record));
    })?;
    let text = lines.into_values().flat_map(|line| [line, b"\n".to_vec()]).flatten().collect::<Vec<u8>>();
    let is_tidy = std::fs::read(out.join(RECORDS))? == text;
    if is_tidy { Ok(()) } else { save(out, RECORDS, Unit::new(keeper), |file| file.write_all(&text)) }
}

/// Number of a file, by which another one under its name is known.
#[cfg(unix)]
fn number(file: &Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::ino(file)
}

/// Files have no number here: after another process has put the records in order, a case may be done once more.
#[cfg(not(unix))]
fn number(_: &Metadata) -> u64 {
    1
}
