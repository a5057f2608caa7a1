//! Outputs that the flags of `mesocrete mesh` ask for.

use super::flags::Args;
use crate::commands::meshing::Meshing;
use crate::failure::Failure;
use crate::outputs::Target;
use meso_ask::Giver;
use meso_core::export::abaqus::DeckOptions;
use meso_core::formats::MeshFormat;
use meso_core::{Silent, Spec};
use meso_study::{NameError, Names};
use std::path::{Path, PathBuf};

impl Args {
    /// Sets who gave the options.
    pub(crate) fn given_by(&mut self, giver: Giver<'static>) {
        self.meshing.given_by(giver);
    }

    /// Refuses flags that are wrong with any file.
    pub(crate) fn validate(&self) -> Result<(), Failure> {
        self.meshing.validate()?;
        // A file of a test is read by `check`.
        if self.meshing.has_test_file() { self.formats().map(drop) } else { self.accept_formats() }
    }

    fn accept_formats(&self) -> Result<(), Failure> {
        self.meshing.accept_formats(self.formats()?.into_iter())
    }

    /// Refuses flags that do not suit packings of `spec`, before one is packed.
    pub(crate) fn check(&self, spec: &Spec) -> Result<(), Failure> {
        self.accept_formats()?;
        let writes_deck = self.formats()?.into_iter().any(MeshFormat::is_deck);
        self.meshing.settings(spec, writes_deck).map(drop)
    }

    /// Sets the gaps that the mesh needs and `spec` leaves open.
    pub(crate) fn leave_room(&self, spec: &mut Spec) -> Result<(), Failure> {
        self.meshing.leave_room(spec, &Silent).map(drop)
    }

    /// The files that are asked for.
    pub(crate) fn outputs(&self) -> &[PathBuf] {
        &self.output
    }

    /// Claims the name of every file that the mesh is written to.
    pub(crate) fn claim(&self, owner: &str, names: &mut Names) -> Result<(), Failure> {
        for path in &self.output {
            let mut claim = |path: &Path| names.claim(owner, &path.file_name().unwrap_or_default().to_string_lossy());
            claim(path).map_err(wrong_name)?;
            match mesh_format(path)? {
                MeshFormat::Inp if self.meshing.has_curve() => {
                    claim(&DeckOptions::curve_path(path)).map_err(wrong_name)?;
                }
                MeshFormat::Pvtu => {
                    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
                    names.claim_series(owner, &format!("{stem}_"), ".vtu").map_err(wrong_name)?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn formats(&self) -> Result<Vec<MeshFormat>, Failure> {
        self.output.iter().map(|path| mesh_format(path)).collect()
    }

    /// Destinations of the meshes, inspected before any work is done.
    pub(super) fn plan(&self) -> Result<Vec<(Target, MeshFormat)>, Failure> {
        let formats = self.formats()?;
        let target = |(path, format)| Ok((target(path, format, self.writing.force, &self.meshing)?, format));
        self.output.iter().map(PathBuf::as_path).zip(formats).map(target).collect()
    }
}

/// The format that an output's extension names; standard output takes a deck.
fn mesh_format(path: &Path) -> Result<MeshFormat, Failure> {
    let format = if path == Path::new("-") { Some(MeshFormat::Inp) } else { MeshFormat::from_path(path) };
    format.ok_or_else(|| {
        let known = MeshFormat::ALL.map(|format| format!(".{}", format.extension())).join(", ");
        let message = format!("{}: unknown mesh format; the extension must be one of {known}", path.display());
        Failure::Usage(message)
    })
}

/// Destination of a mesh, inspected before any work is done.
pub(crate) fn target(path: &Path, format: MeshFormat, force: bool, meshing: &Meshing) -> Result<Target, Failure> {
    if format == MeshFormat::Pvtu {
        // The number of pieces is not known yet, but an existing first one would be in the way.
        Target::new(&MeshFormat::piece_path(path, 0), force)?;
    }
    let target = Target::new(path, force)?;
    if format == MeshFormat::Inp && meshing.has_curve() && matches!(target, Target::File { .. }) {
        Target::new(&DeckOptions::curve_path(path), force)?;
    }
    Ok(target)
}

fn wrong_name(error: NameError) -> Failure {
    Failure::Usage(error.to_string())
}
