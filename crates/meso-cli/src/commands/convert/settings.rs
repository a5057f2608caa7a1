//! Outputs that the flags of `mesocrete convert` ask for.

use super::flags::{Args, known};
use crate::failure::Failure;
use crate::outputs::Target;
use meso_core::formats::Format;
use std::path::Path;

impl Args {
    /// Refuses flags that are wrong with any file.
    pub(crate) fn validate(&self) -> Result<(), Failure> {
        let formats = self.output.iter().map(|path| format(path, self)).collect::<Result<Vec<_>, _>>()?;
        let for_one = [(self.mortar, "--mortar", Format::Step), (self.named_solids, "--named-solids", Format::Stl)];
        match for_one.into_iter().find(|(given, _, format)| *given && !formats.contains(format)) {
            Some((_, flag, format)) => {
                let extension = format.extension();
                let message = format!("{flag} applies to .{extension} files alone; give -o a name that ends so");
                Err(Failure::Usage(message))
            }
            None => Ok(()),
        }
    }
}

pub(super) fn plan(path: &Path, args: &Args) -> Result<(Target, Format), Failure> {
    Ok((Target::new(path, args.writing.force)?, format(path, args)?))
}

/// The format that an output's name asks for.
fn format(path: &Path, args: &Args) -> Result<Format, Failure> {
    let format = if path == Path::new("-") { Some(args.format) } else { Format::from_path(path) };
    format.ok_or_else(|| {
        let meshes = " (a mesh for finite elements: mesocrete mesh)";
        Failure::Usage(format!(
            "{}: unknown format; the extension must be one of {}{meshes}",
            path.display(),
            known(".")
        ))
    })
}
