//! The folder of a test's results: whole or not at all, and never over others' without `--force`.
//!
//! Frames wait for their names until the test is over. With checkpoints they get them at once, since the next run goes on
//! from the frames that a killed one left. A checkpoint has length and hash of each frame before it.

use crate::failure::Failure;
use crate::outputs::{Target, Unit};
use crate::own_folder::OwnFolder;
use crate::stderr::flag;
use meso_core::mesh::Mesh;
use meso_files::whole;
use meso_solve::results::{Moment, Outcome, ResultFile, ShotFile, Snapshot, Still};
use meso_solve::{Run, checkpoint_note};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufReader, Write};
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
    frames: Vec<Written>,
    /// What all frames have of the mesh.
    still: Still,
    /// The moments that the page shows.
    taken: ShotFile,
    /// Number of frames that could not be written.
    lost: usize,
    /// Keeps other processes out.
    _own: OwnFolder,
}

/// A frame, and the file that it has in the folder.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct Written {
    moment: Moment,
    /// Absent where the frame waits for its name.
    file: Option<Contents>,
}

/// Length and hash of a file.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Contents {
    bytes: u64,
    sha256: String,
}

impl Contents {
    fn of(path: &Path) -> std::io::Result<Self> {
        Ok(Self { bytes: std::fs::metadata(path)?.len(), sha256: meso_files::sha256(path)? })
    }
}

/// Remains of a killed run: its frames, and the engine's state after them.
pub(super) struct Kept {
    pub(super) path: PathBuf,
    pub(super) written: Note,
    pub(super) state: BufReader<File>,
}

/// What a folder has of a test: a checkpoint's note.
#[derive(Default, Serialize, Deserialize)]
pub(super) struct Note {
    frames: Vec<Written>,
    /// The moments that the page shows.
    taken: ShotFile,
}

impl Folder {
    /// Looks at the folder before any work, and makes it where it is not there.
    pub(super) fn open(path: &Path, keeps: bool, resumes: bool, force: bool) -> Result<Self, Failure> {
        let mut folder = Self {
            path: path.to_owned(),
            force: force || resumes,
            keeps: keeps || resumes,
            staged: Unit::default(),
            reserve: Unit::unforced(),
            frames: Vec::new(),
            still: Still::default(),
            taken: ShotFile::default(),
            lost: 0,
            _own: OwnFolder::open(path)?,
        };
        let checkpoint = path.join(CHECKPOINT);
        if checkpoint.exists() && !folder.force {
            let name = checkpoint.display();
            let [resume, force] = ["resume", "force"].map(flag);
            return Err(Failure::Run(format!("{name} exists; {resume} continues from it, {force} starts anew")));
        }
        if resumes && !checkpoint.exists() {
            let name = checkpoint.display();
            let option = flag("checkpoint");
            return Err(Failure::Run(format!("there is no {name} to resume from; a run with {option} writes one")));
        }
        for name in ResultFile::ALL.map(|file| file.name().to_owned()).into_iter().chain(folder.frames_there()?) {
            folder.target(&name)?;
        }
        if resumes {
            // The lock says that the run which left these is dead.
            remove(folder.there(whole::is_unfinished)?.into_iter().map(|name| path.join(name)))?;
        }
        let room = Target::File { shown: path.to_owned(), path: path.join("room") };
        folder.reserve.fill(&room, false, |out| out.write_all(&vec![0; ROOM]))?;
        Ok(folder)
    }

    /// Frames' files that are there.
    fn frames_there(&self) -> Result<Vec<String>, Failure> {
        self.there(|name| Moment::number_of(name).is_some())
    }

    /// Files of one kind that are there.
    fn there(&self, is_of_kind: impl Fn(&str) -> bool) -> Result<Vec<String>, Failure> {
        let fail = |error| Failure::file(&self.path, &error);
        let entries = std::fs::read_dir(&self.path).map_err(fail)?.collect::<Result<Vec<_>, _>>().map_err(fail)?;
        let names = entries.iter().map(|entry| entry.file_name().to_string_lossy().into_owned());
        Ok(names.filter(|name| is_of_kind(name)).collect())
    }

    fn target(&self, name: &str) -> Result<Target, Failure> {
        Target::new(&self.path.join(name), self.force)
    }

    /// The checkpoint of the run before this one, with the frames that it was written after.
    pub(super) fn kept(&self) -> Result<Kept, Failure> {
        let path = self.path.join(CHECKPOINT);
        let fail = |error| Failure::file(&path, &error);
        let damaged =
            |why: String| Failure::Run(format!("{}: {why}; {} starts the test anew", path.display(), flag("force")));
        let open = || File::open(&path).map(BufReader::new).map_err(fail);
        let note = checkpoint_note(&mut open()?).map_err(|error| damaged(error.to_string()))?;
        let written: Note = serde_json::from_slice(&note).map_err(|error| damaged(error.to_string()))?;
        for frame in &written.frames {
            let file = self.path.join(frame.moment.file());
            let there = Contents::of(&file).map_err(|error| Failure::file(&file, &error))?;
            if frame.file.as_ref() != Some(&there) {
                let file = file.display();
                return Err(damaged(format!("{file} is not the frame that this checkpoint was written after")));
            }
        }
        Ok(Kept { state: open()?, path, written })
    }

    /// Goes on behind the frames of a killed run; none where a new test starts. Then the checkpoint of another test goes,
    /// and its frames with it.
    pub(super) fn go_on(&mut self, written: Note, is_new: bool) -> Result<(), Failure> {
        (self.frames, self.taken) = (written.frames, written.taken);
        let checkpoint = self.path.join(CHECKPOINT);
        if !is_new || !checkpoint.exists() {
            return Ok(());
        }
        let frames = self.frames_there()?.into_iter().map(|name| self.path.join(name));
        remove(std::iter::once(checkpoint).chain(frames))
    }

    /// The moments that the page shows.
    pub(super) fn taken(&self) -> ShotFile {
        self.taken.clone()
    }

    /// Keeps the moments that the page shows.
    pub(super) fn keep_shots(&mut self, taken: ShotFile) {
        self.taken = taken;
    }

    /// When each frame was taken.
    pub(super) fn frames(&self) -> Vec<Moment> {
        self.frames.iter().map(|frame| frame.moment).collect()
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
        let path = self.path.join(frame.moment.file());
        let target = Target::new(&path, self.force || self.keeps);
        let mut still = std::mem::take(&mut self.still);
        let written = target.and_then(|target| self.write(&target, |out| frame.write(mesh, &mut still, out)));
        self.still = still;
        let contents = |()| self.keeps.then(|| Contents::of(&path)).transpose();
        let file = written.and_then(|()| contents(()).map_err(|error| Failure::file(&path, &error)));
        match file {
            Ok(file) => self.frames.push(Written { moment: frame.moment, file }),
            Err(failure) => {
                self.lost += 1;
                return Err(failure);
            }
        }
        Ok(())
    }

    /// Writes the checkpoint: whole, or the one before it stays.
    pub(super) fn keep(&mut self, run: &Run) -> Result<(), Failure> {
        let target = Target::new(&self.path.join(CHECKPOINT), true)?;
        let note = Note { frames: self.frames.clone(), taken: self.taken.clone() };
        let note = serde_json::to_vec(&note).map_err(|error| Failure::Run(error.to_string()))?;
        let mut unit = Unit::default();
        unit.fill(&target, true, |out| run.save(&note, out))?;
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
        let own: Vec<String> = self.frames.iter().map(|frame| frame.moment.file()).collect();
        let stale = self.frames_there()?.into_iter().filter(|name| !own.contains(name));
        let stale: Vec<PathBuf> = stale.map(|name| self.path.join(name)).collect();
        std::mem::take(&mut self.staged).commit()?;
        let checkpoint = self.path.join(CHECKPOINT);
        let done = if is_complete && checkpoint.exists() { Some(checkpoint) } else { None };
        remove(stale.into_iter().chain(done))?;
        let names = ResultFile::ALL.map(|file| file.name().to_owned()).into_iter().chain(own);
        Ok(names.map(|name| self.path.join(name)).collect())
    }
}

fn remove(paths: impl Iterator<Item = PathBuf>) -> Result<(), Failure> {
    for path in paths {
        std::fs::remove_file(&path).map_err(|error| Failure::file(&path, &error))?;
    }
    Ok(())
}
