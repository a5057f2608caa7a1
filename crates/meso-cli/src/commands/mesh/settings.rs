//! Outputs that the flags of `mesocrete mesh` ask for.

use super::flags::Args;
use crate::failure::Failure;
use crate::outputs::Target;
use meso_ask::DeckAsk;
use meso_core::export::abaqus::DeckOptions;
use meso_core::formats::MeshFormat;
use std::path::{Path, PathBuf};

impl Args {
    /// Refuses flags that are wrong with any file.
    pub(crate) fn validate(&self) -> Result<(), Failure> {
        let ask = self.meshing.unread();
        ask.accept()?;
        ask.accept_formats(self.formats()?.into_iter())?;
        Ok(())
    }

    fn formats(&self) -> Result<Vec<MeshFormat>, Failure> {
        self.output.iter().map(|path| mesh_format(path)).collect()
    }

    /// Destinations of the meshes, inspected before any work is done.
    pub(super) fn plan(&self, ask: &DeckAsk) -> Result<Vec<(Target, MeshFormat)>, Failure> {
        let formats = self.formats()?;
        let target = |(path, format)| Ok((target(path, format, self.writing.force, ask)?, format));
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
pub(crate) fn target(path: &Path, format: MeshFormat, force: bool, ask: &DeckAsk) -> Result<Target, Failure> {
    if format == MeshFormat::Pvtu {
        // The number of pieces is not known yet, but an existing first one would be in the way.
        Target::new(&MeshFormat::piece_path(path, 0), force)?;
    }
    let target = Target::new(path, force)?;
    if format == MeshFormat::Inp && ask.has_curve() && matches!(target, Target::File { .. }) {
        Target::new(&DeckOptions::curve_path(path), force)?;
    }
    Ok(target)
}
