//! gmsh, run as a program of its own in a folder of its own, for conforming meshes.
//!
//! gmsh is under the GPL and is neither linked nor shipped; whoever wants conforming meshes installs it.

use crate::interrupt;
use meso_core::mesh::MeshError;
use meso_core::mesh::conforming::{GMSH_OPTIONS, Surfaces};
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// How often it is looked whether gmsh is done, or is to stop.
const POLL: Duration = Duration::from_millis(20);

/// What to do without gmsh.
const REMEDY: &str = "conforming meshes need gmsh: install it (Debian: apt install gmsh; PyPI: pip install gmsh) and put it on \
                      the PATH or name it with --gmsh, or take --method lattice";

/// How gmsh is called.
pub struct Gmsh {
    program: OsString,
    /// Come before gmsh's own arguments.
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

    /// The program, wherever it is to run, with what comes before its own arguments.
    fn command(&self) -> Command {
        let path = Path::new(&self.program);
        let is_bare = path.parent().is_none_or(|folder| folder.as_os_str().is_empty());
        let from_anywhere = if is_bare { None } else { std::path::absolute(path).ok() };
        let mut command = Command::new(from_anywhere.as_deref().unwrap_or(path));
        command.args(&self.first);
        command
    }

    /// Finds out whether gmsh is there and runs.
    ///
    /// # Errors
    /// Where it is missing, with the remedy; what it said where it does not run.
    pub fn check(&self) -> Result<(), MeshError> {
        let asked = self.command().arg("--version").output().map_err(|error| self.missing(&error))?;
        if asked.status.success() {
            return Ok(());
        }
        let (program, said) = (Path::new(&self.program).display(), String::from_utf8_lossy(&asked.stderr));
        let (status, said) = (asked.status, said.trim().to_owned());
        Err(MeshError::MissingGmsh(format!("{program} --version failed ({status}); {REMEDY}; it said:\n{said}")))
    }

    /// Fills `surfaces` with tetrahedra; the bytes of gmsh's output.
    ///
    /// # Errors
    /// Where gmsh is missing, with the remedy; what gmsh had to say where it failed.
    pub fn run(&self, surfaces: &Surfaces) -> Result<Vec<u8>, MeshError> {
        self.run_until(surfaces, &|| false)
    }

    /// The same, but ends gmsh and gives up as soon as `stop` says so.
    ///
    /// # Errors
    /// As those of [`run`](Self::run), and the stop.
    pub fn run_until(&self, surfaces: &Surfaces, stop: &dyn Fn() -> bool) -> Result<Vec<u8>, MeshError> {
        let make = || tempfile::Builder::new().prefix("mesocrete-").tempdir();
        let folder = interrupt::hidden(make, tempfile::TempDir::path).map_err(files)?;
        let output = self.fill(surfaces, folder.path(), stop);
        interrupt::forget(folder.path());
        output
    }

    fn fill(&self, surfaces: &Surfaces, folder: &Path, stop: &dyn Fn() -> bool) -> Result<Vec<u8>, MeshError> {
        surfaces.write(File::create(folder.join("surfaces.msh")).map_err(files)?).map_err(files)?;
        std::fs::write(folder.join("volumes.geo"), surfaces.script("surfaces.msh")).map_err(files)?;
        let said = self.call(folder, stop)?;
        std::fs::read(folder.join("volumes.msh"))
            .map_err(|_| MeshError::Gmsh(format!("gmsh made no mesh; it said:\n{said}")))
    }

    /// Runs gmsh in `folder`; what it said.
    fn call(&self, folder: &Path, stop: &dyn Fn() -> bool) -> Result<String, MeshError> {
        // Not through pipes: nobody would empty them meanwhile.
        let saying = File::create(folder.join("said.txt")).map_err(files)?;
        let mut command = self.command();
        command.current_dir(folder).arg("volumes.geo").args(GMSH_OPTIONS);
        command.args(["-nt", &rayon::current_num_threads().to_string(), "-o", "volumes.msh"]);
        command.stdin(Stdio::null()).stderr(saying.try_clone().map_err(files)?).stdout(saying);
        let status = self.wait(&mut command, stop)?;
        let said = std::fs::read(folder.join("said.txt")).map_err(files)?;
        let said = String::from_utf8_lossy(&said).trim().to_owned();
        if status.success() {
            return Ok(said);
        }
        Err(MeshError::Gmsh(format!("gmsh failed ({status}); it said:\n{said}")))
    }

    /// Runs `command` to its end, or ends it when `stop` says so or the user ends this process.
    fn wait(&self, command: &mut Command, stop: &dyn Fn() -> bool) -> Result<ExitStatus, MeshError> {
        let child = command.spawn().map_err(|error| self.missing(&error))?;
        let child = Arc::new(Mutex::new(child));
        let _ends_with_us = interrupt::Running::new(&child);
        loop {
            let mut child = child.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(status) = child.try_wait().map_err(files)? {
                return Ok(status);
            }
            if stop() {
                let _ = child.kill().and_then(|()| child.wait());
                return Err(MeshError::Gmsh("gmsh was stopped".to_owned()));
            }
            drop(child);
            thread::sleep(POLL);
        }
    }

    fn missing(&self, error: &io::Error) -> MeshError {
        let program = Path::new(&self.program).display();
        let why = match error.kind() {
            io::ErrorKind::NotFound => "there is no such program".to_owned(),
            io::ErrorKind::PermissionDenied => "it is no program, or may not be run".to_owned(),
            _ => error.to_string(),
        };
        MeshError::MissingGmsh(format!("{program} cannot be run ({why}); {REMEDY}"))
    }
}

/// What went wrong with the files that gmsh reads and writes.
fn files(error: io::Error) -> MeshError {
    let text = error.to_string();
    let (text, folder) = (text.split(" (os error").next().unwrap_or(&text), std::env::temp_dir());
    MeshError::Gmsh(format!("the files for gmsh in {}: {text}; TMPDIR names another folder for them", folder.display()))
}
