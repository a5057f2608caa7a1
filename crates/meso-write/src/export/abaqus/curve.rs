//! The script that goes beside a deck: `abaqus python` writes `curve.csv` with it.

use super::lines::real;
use super::{Analysis, DeckOptions};
use meso_collision::math::Aabb;
use meso_mesh::cells::Mesh;
use meso_mesh::figures::PhaseVolumes;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

const SCRIPT: &str = include_str!("curve.py");

impl DeckOptions {
    /// Where the script of the deck at `deck` is: `name_curve.py` beside `name.inp`.
    pub fn curve_path(deck: &Path) -> PathBuf {
        deck.with_file_name(format!("{}_curve.py", deck.file_stem().unwrap_or_default().to_string_lossy()))
    }
}

/// Writes the script of `mesh`'s deck, which `name` is called, to `out`.
///
/// # Errors
/// Fails with the errors of `out`.
pub(crate) fn write_curve(mesh: &Mesh, options: &DeckOptions, name: &str, mut out: impl Write) -> io::Result<()> {
    let height = Aabb::around(&mesh.points).size().z;
    let section = options.section_mm2.unwrap_or_else(|| PhaseVolumes::of_mesh(mesh).total() / height);
    let sense = if options.analysis == Analysis::Tension { "1.0" } else { "-1.0" };
    // Anything but a plain name would need escapes of Python's.
    let plain = |c: char| if c.is_ascii_alphanumeric() || "._- ".contains(c) { c } else { '_' };
    let script = SCRIPT
        .replace("@DECK@", &name.chars().map(plain).collect::<String>())
        .replace("@HEIGHT@", &real(height))
        .replace("@SECTION@", &real(section))
        .replace("@TOP@", &(mesh.points.len() + 2).to_string())
        .replace("@SENSE@", sense);
    out.write_all(script.as_bytes())
}
