//! gmsh, run as a program of its own in a folder of its own, for conforming meshes.
//!
//! gmsh is under the GPL and is neither linked nor shipped; users who want conforming meshes install it. It ends with
//! this process: [`end_all`] is for signal handlers, and on Linux the kernel sees to it where this process is killed
//! outright (elsewhere gmsh then runs to its end, and everywhere its folder `mesocrete-*` stays in TMPDIR).

mod ends_with_us;
mod running;

pub use running::end_all;

use meso_mesh::conforming::Surfaces;
use meso_mesh::{MeshError, VolumeMesher};
use running::Running;
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::thread;
use std::time::Duration;

/// Interval at which the runner checks whether gmsh is done, or is to stop.
const POLL: Duration = Duration::from_millis(20);
/// End of gmsh's output when it is complete.
const END: &[u8] = b"$EndElements\n";
/// Bytes written to test whether the disk is full: more than a file system reserves for small files.
const PROBE: usize = 1 << 16;

/// How to call gmsh.
pub struct Gmsh {
    program: OsString,
    /// Arguments before gmsh's own.
    first: Vec<OsString>,
}

impl Gmsh {
    /// The program `path`, looked for on the PATH where it is a bare name.
    pub fn program(path: impl AsRef<OsStr>) -> Self {
        Self { program: path.as_ref().to_owned(), first: Vec::new() }
    }

    /// The module `gmsh` of the Python interpreter `python`.
    pub fn python_module(python: impl AsRef<OsStr>) -> Self {
        let script = "import sys, gmsh; gmsh.initialize(sys.argv, run=True); gmsh.finalize()";
        Self { program: python.as_ref().to_owned(), first: vec!["-c".into(), script.into()] }
    }

    /// The program, with the arguments before its own.
    fn command(&self) -> Command {
        let path = Path::new(&self.program);
        let is_bare = path.parent().is_none_or(|folder| folder.as_os_str().is_empty());
        let from_anywhere = if is_bare { None } else { std::path::absolute(path).ok() };
        let mut command = Command::new(from_anywhere.as_deref().unwrap_or(path));
        command.args(&self.first);
        command
    }

    /// This gmsh, which ends where `stop` says so: its errors are [`MeshError::MissingGmsh`], [`MeshError::Stopped`],
    /// [`MeshError::Files`] (a full disk, too), and [`MeshError::Gmsh`] with the output of a gmsh that failed.
    pub fn until<'a>(&'a self, stop: &'a (dyn Fn() -> bool + Sync)) -> Until<'a> {
        Until { gmsh: self, stop }
    }

    fn run_until(&self, surfaces: &Surfaces, stop: &dyn Fn() -> bool) -> Result<Vec<u8>, MeshError> {
        let running = in_new_folder()?;
        let in_folder = |error| files(running.folder(), error);
        let create = |name| running.in_folder(|folder| File::create(folder.join(name)));
        let (mesh, script) = (create("surfaces.msh").map_err(in_folder)?, create("volumes.geo").map_err(in_folder)?);
        write_input(surfaces, mesh, script).map_err(in_folder)?;
        let mut command = self.command();
        command.arg("volumes.geo").args(Surfaces::GMSH_OPTIONS);
        command.args(["-nt", &rayon::current_num_threads().to_string(), "-o", "volumes.msh"]);
        let outcome = self.outcome(&mut command, &running, stop)?;
        let output = std::fs::read(running.folder().join("volumes.msh")).unwrap_or_default();
        if outcome.status.success() && output.ends_with(END) {
            return Ok(output);
        }
        // A full disk ends gmsh in many ways, and another element size does not help.
        running.in_folder(probe_disk).map_err(in_folder)?;
        let what = match (outcome.status.success(), output.is_empty()) {
            (false, _) => format!("gmsh failed ({})", outcome.status),
            (true, true) => "gmsh made no mesh".to_owned(),
            (true, false) => "gmsh's mesh is cut off".to_owned(),
        };
        Err(MeshError::Gmsh(format!("{what}; it said:\n{}", outcome.said)))
    }

    /// Runs `command` in the folder of `running` until it ends, or `stop` says so.
    fn outcome(&self, command: &mut Command, running: &Running, stop: &dyn Fn() -> bool) -> Result<GmshEnd, MeshError> {
        let in_folder = |error| files(running.folder(), error);
        // Not through pipes: nobody would empty them in the meantime.
        let mut saying = running.in_folder(|folder| open_anew(&folder.join("said.txt"))).map_err(in_folder)?;
        command.current_dir(running.folder()).stdin(Stdio::null());
        command.stderr(saying.try_clone().map_err(in_folder)?).stdout(saying.try_clone().map_err(in_folder)?);
        ends_with_us::arrange(command);
        running.start(command).map_err(|error| self.missing(&error))?;
        let status = wait(running, stop)?;
        let mut said = Vec::new();
        saying.seek(SeekFrom::Start(0)).and_then(|_| saying.read_to_end(&mut said)).map_err(in_folder)?;
        Ok(GmshEnd { status, said: String::from_utf8_lossy(&said).trim().to_owned() })
    }

    fn missing(&self, error: &io::Error) -> MeshError {
        let why = match error.kind() {
            io::ErrorKind::NotFound => "there is no such program".to_owned(),
            io::ErrorKind::PermissionDenied => "it is not a program, or you may not run it".to_owned(),
            _ => error.to_string(),
        };
        self.missing_since(format!("cannot be run ({why})"))
    }

    fn missing_since(&self, why: String) -> MeshError {
        MeshError::MissingGmsh { program: Path::new(&self.program).display().to_string(), why }
    }
}

/// gmsh, which ends where its user stops.
pub struct Until<'a> {
    gmsh: &'a Gmsh,
    stop: &'a (dyn Fn() -> bool + Sync),
}

impl VolumeMesher for Until<'_> {
    fn available(&self) -> Result<(), MeshError> {
        self.gmsh.available()
    }

    fn fill(&self, surfaces: &Surfaces) -> Result<Vec<u8>, MeshError> {
        self.gmsh.run_until(surfaces, self.stop)
    }
}

impl VolumeMesher for Gmsh {
    /// [`MeshError::MissingGmsh`] has the output of a gmsh that does not run.
    fn available(&self) -> Result<(), MeshError> {
        let running = in_new_folder()?;
        let asked = self.outcome(self.command().arg("--version"), &running, &|| false)?;
        if asked.status.success() {
            return Ok(());
        }
        Err(self.missing_since(format!("--version failed ({}), saying {:?}", asked.status, asked.said)))
    }

    fn fill(&self, surfaces: &Surfaces) -> Result<Vec<u8>, MeshError> {
        self.run_until(surfaces, &|| false)
    }
}

/// How gmsh ended.
struct GmshEnd {
    status: ExitStatus,
    said: String,
}

fn in_new_folder() -> Result<Running, MeshError> {
    Running::in_new_folder().map_err(|error| files(&std::env::temp_dir(), error))
}

/// Waits for the process, or ends it when the caller or the user says so.
fn wait(running: &Running, stop: &dyn Fn() -> bool) -> Result<ExitStatus, MeshError> {
    loop {
        if let Some(status) = running.status().map_err(|error| files(running.folder(), error))? {
            return Ok(status);
        }
        if stop() {
            running.end();
            return Err(MeshError::Stopped);
        }
        thread::sleep(POLL);
    }
}

/// A new file to write and then to read.
fn open_anew(path: &Path) -> io::Result<File> {
    File::options().read(true).write(true).create(true).truncate(true).open(path)
}

fn write_input(surfaces: &Surfaces, mesh: File, mut script: File) -> io::Result<()> {
    surfaces.write(mesh)?;
    script.write_all(surfaces.script("surfaces.msh").as_bytes())
}

/// Fails where the disk is full.
fn probe_disk(folder: &Path) -> io::Result<()> {
    let mut file = File::create(folder.join("probe"))?;
    file.write_all(&[0xA5; PROBE])?;
    file.sync_all()
}

fn files(folder: &Path, error: io::Error) -> MeshError {
    MeshError::Files { folder: folder.to_owned(), error }
}
