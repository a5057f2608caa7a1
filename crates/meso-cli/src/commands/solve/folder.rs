//! The folder of a test's results: whole or not at all, and never over others' without `--force`.
//!
//! Frames wait for their names until the test is over. Where checkpoints are kept they get them at once, since a run that is
//! killed must leave what the next one goes on from.

use crate::failure::Failure;
use crate::outputs::{Target, Unit};
use meso_core::mesh::Mesh;
use meso_solve::Run;
use meso_solve::results::{Moment, Outcome, ResultFile, Snapshot};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

/// Name of the state that a run is resumed from.
pub(super) const CHECKPOINT: &str = "checkpoint.bin";
/// Room that the curve, the figures and the page need at most, bytes. Frames may take all the rest of a disk.
const ROOM: usize = 4 << 20;

/// A folder that results go to.
pub(super) struct Folder {
    path: PathBuf,
    /// Whether files that are there are replaced.
    force: bool,
    /// Whether frames get their names at once.
    keeps: bool,
    staged: Unit,
    /// A file that keeps [`ROOM`] until the results are written, and never gets a name.
    reserve: Unit,
    frames: Vec<Moment>,
    /// Number of frames that could not be written.
    lost: usize,
    /// Whether it was made here; taken away again where nothing comes into it.
    made: Option<Made>,
}

/// A folder that was made here.
struct Made(PathBuf);

impl Drop for Made {
    fn drop(&mut self) {
        // One that holds something stays.
        let _ = std::fs::remove_dir(&self.0);
    }
}

/// Remains of a killed run: its frames, and the engine's state after them.
pub(super) struct Kept {
    pub(super) path: PathBuf,
    pub(super) frames: Vec<Moment>,
    pub(super) state: BufReader<File>,
}

/// First line of a checkpoint.
#[derive(Serialize, Deserialize)]
struct Head {
    frames: Vec<Moment>,
}

impl Folder {
    /// Looks at the folder before any work, and makes it where it is not there.
    pub(super) fn open(path: &Path, keeps: bool, resumes: bool, force: bool) -> Result<Self, Failure> {
        let made = make(path)?;
        let mut folder = Self {
            path: path.to_owned(),
            force: force || resumes,
            keeps: keeps || resumes,
            staged: Unit::default(),
            reserve: Unit::unforced(),
            frames: Vec::new(),
            lost: 0,
            made,
        };
        let checkpoint = path.join(CHECKPOINT);
        if checkpoint.exists() && !folder.force {
            let name = checkpoint.display();
            return Err(Failure::Run(format!("{name} exists; --resume continues from it, --force starts anew")));
        }
        if resumes && !checkpoint.exists() {
            let name = checkpoint.display();
            return Err(Failure::Run(format!("there is no {name} to resume from; a run with --checkpoint writes one")));
        }
        for name in ResultFile::ALL.map(|file| file.name().to_owned()).into_iter().chain(folder.frames_there()?) {
            folder.target(&name)?;
        }
        let room = Target::File { shown: path.to_owned(), path: path.join("room") };
        folder.reserve.fill(&room, false, |out| out.write_all(&vec![0; ROOM]))?;
        Ok(folder)
    }

    /// Frames' files that are there.
    fn frames_there(&self) -> Result<Vec<String>, Failure> {
        let fail = |error| Failure::file(&self.path, &error);
        let entries = std::fs::read_dir(&self.path).map_err(fail)?.collect::<Result<Vec<_>, _>>().map_err(fail)?;
        let names = entries.iter().map(|entry| entry.file_name().to_string_lossy().into_owned());
        Ok(names.filter(|name| Moment::number_of(name).is_some()).collect())
    }

    fn target(&self, name: &str) -> Result<Target, Failure> {
        Target::new(&self.path.join(name), self.force)
    }

    /// The checkpoint of the run before this one.
    pub(super) fn kept(&self) -> Result<Kept, Failure> {
        let path = self.path.join(CHECKPOINT);
        let fail = |error| Failure::file(&path, &error);
        let mut state = BufReader::new(File::open(&path).map_err(fail)?);
        let mut head = Vec::new();
        state.read_until(b'\n', &mut head).map_err(fail)?;
        let Ok(Head { frames }) = serde_json::from_slice(&head) else {
            return Err(Failure::Run(format!(
                "{} is not a checkpoint, or it is damaged; --force starts the test anew",
                path.display()
            )));
        };
        match frames.iter().map(|frame| self.path.join(frame.file())).find(|file| !file.is_file()) {
            Some(missing) => Err(Failure::Run(format!("{} is missing; the run cannot be resumed", missing.display()))),
            None => Ok(Kept { path, frames, state }),
        }
    }

    /// Goes on behind `frames`.
    pub(super) fn go_on(&mut self, frames: Vec<Moment>) {
        self.frames = frames;
    }

    pub(super) fn frames(&self) -> &[Moment] {
        &self.frames
    }

    /// What is said in the end of frames that could not be written.
    pub(super) fn lost(&self) -> Result<(), Failure> {
        let (lost, all) = (self.lost, self.lost + self.frames.len());
        let message =
            || Failure::Run(format!("{lost} of {all} frames could not be written; all other results are whole"));
        if lost == 0 { Ok(()) } else { Err(message()) }
    }

    /// Writes a frame. Where that fails, those before it stay.
    pub(super) fn add(&mut self, mesh: &Mesh, frame: &Snapshot) -> Result<(), Failure> {
        let target = Target::new(&self.path.join(frame.moment.file()), self.force || self.keeps);
        let written = target.and_then(|target| self.write(&target, |out| frame.write(mesh, out)));
        match written {
            Ok(()) => self.frames.push(frame.moment),
            Err(_) => self.lost += 1,
        }
        written
    }

    /// Writes the checkpoint: whole, or the one before it stays.
    pub(super) fn keep(&mut self, run: &Run) -> Result<(), Failure> {
        let target = Target::new(&self.path.join(CHECKPOINT), true)?;
        let head = Head { frames: self.frames.clone() };
        let mut unit = Unit::default();
        unit.fill(&target, true, |out| {
            serde_json::to_writer(&mut *out, &head)?;
            writeln!(out)?;
            run.save(out)
        })?;
        unit.commit()
    }

    fn write(
        &mut self,
        target: &Target,
        write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    ) -> Result<(), Failure> {
        if !self.keeps {
            return self.staged.fill(target, self.force, write);
        }
        let mut unit = Unit::default();
        unit.fill(target, true, write)?;
        unit.commit()
    }

    /// Writes the results, which wait for their names.
    pub(super) fn fill(&mut self, outcome: &Outcome) -> Result<(), Failure> {
        self.reserve = Unit::default();
        for file in ResultFile::ALL {
            let target = self.target(file.name())?;
            self.staged.fill(&target, self.force, |out| file.write(outcome, out))?;
        }
        Ok(())
    }

    /// Gives everything its name, and takes away what other runs left; what there is.
    pub(super) fn commit(mut self, is_complete: bool) -> Result<Vec<PathBuf>, Failure> {
        let own: Vec<String> = self.frames.iter().map(Moment::file).collect();
        let stale = self.frames_there()?.into_iter().filter(|name| !own.contains(name));
        let stale: Vec<PathBuf> = stale.map(|name| self.path.join(name)).collect();
        std::mem::take(&mut self.staged).commit()?;
        let checkpoint = self.path.join(CHECKPOINT);
        let done = if is_complete && checkpoint.exists() { Some(checkpoint) } else { None };
        for path in stale.iter().chain(&done) {
            std::fs::remove_file(path).map_err(|error| Failure::file(path, &error))?;
        }
        drop(self.made.take());
        let names = ResultFile::ALL.map(|file| file.name().to_owned()).into_iter().chain(own);
        Ok(names.map(|name| self.path.join(name)).collect())
    }
}

/// Makes the folder, if it is not there; it must have a place.
fn make(path: &Path) -> Result<Option<Made>, Failure> {
    match std::fs::metadata(path) {
        Ok(kind) if kind.is_dir() => Ok(None),
        Ok(_) => Err(Failure::Run(format!("{} is not a folder; name a folder for the results", path.display()))),
        Err(_) => {
            std::fs::create_dir(path).map_err(|error| Failure::file(path, &error))?;
            Ok(Some(Made(path.to_owned())))
        }
    }
}
