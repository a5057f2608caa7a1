//! gmsh, run as a program of its own in a folder of its own, for conforming meshes.
//!
//! gmsh is under the GPL and is neither linked nor shipped; whoever wants conforming meshes installs it.

use meso_core::mesh::MeshError;
use meso_core::mesh::conforming::{GMSH_OPTIONS, Surfaces};
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io;
use std::path::Path;
use std::process::Command;

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

    /// Finds out whether gmsh is there.
    ///
    /// # Errors
    /// Where it is missing, with the remedy.
    pub fn check(&self) -> Result<(), MeshError> {
        let asked = Command::new(&self.program).args(&self.first).arg("--version").output();
        asked.map(drop).map_err(|error| self.missing(&error))
    }

    /// Fills `surfaces` with tetrahedra; the bytes of gmsh's output.
    ///
    /// # Errors
    /// Where gmsh is missing, with the remedy; what gmsh had to say where it failed.
    pub fn run(&self, surfaces: &Surfaces) -> Result<Vec<u8>, MeshError> {
        let files = |error: io::Error| MeshError::Gmsh(format!("the files for gmsh: {error}"));
        let folder = tempfile::Builder::new().prefix("mesocrete-").tempdir().map_err(files)?;
        surfaces.write(File::create(folder.path().join("surfaces.msh")).map_err(files)?).map_err(files)?;
        std::fs::write(folder.path().join("volumes.geo"), surfaces.script("surfaces.msh")).map_err(files)?;
        let said = self.call(folder.path())?;
        std::fs::read(folder.path().join("volumes.msh"))
            .map_err(|_| MeshError::Gmsh(format!("gmsh made no mesh; it said:\n{said}")))
    }

    /// Runs gmsh in `folder`; what it said.
    fn call(&self, folder: &Path) -> Result<String, MeshError> {
        let mut command = Command::new(&self.program);
        command.current_dir(folder).args(&self.first).arg("volumes.geo").args(GMSH_OPTIONS);
        command.args(["-nt", &rayon::current_num_threads().to_string(), "-o", "volumes.msh"]);
        let output = command.output().map_err(|error| self.missing(&error))?;
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8_lossy(&said).trim().to_owned();
        if output.status.success() {
            return Ok(said);
        }
        Err(MeshError::Gmsh(format!("gmsh failed ({}); it said:\n{said}", output.status)))
    }

    fn missing(&self, error: &io::Error) -> MeshError {
        let program = Path::new(&self.program).display();
        let why = match error.kind() {
            io::ErrorKind::NotFound => "there is no such program".to_owned(),
            io::ErrorKind::PermissionDenied => "it is no program, or may not be run".to_owned(),
            _ => error.to_string(),
        };
        MeshError::MissingGmsh(format!(
            "{program} cannot be run ({why}); conforming meshes need gmsh: install it (Debian: apt install gmsh; PyPI: \
             pip install gmsh) and put it on the PATH or name it with --gmsh, or take --method lattice"
        ))
    }
}
