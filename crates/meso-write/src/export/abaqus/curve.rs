//! The script that goes beside a deck: `abaqus python` writes `curve.csv` with it.

use super::lines::real;
use super::{DeckOptions, supports};
use meso_mesh::cells::Mesh;
use meso_trial::{Loads, RigidSupport};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

const SCRIPT: &str = include_str!("curve.py");

impl DeckOptions {
    /// Where the script of the deck at `deck` is: `name_curve.py` beside `name.inp`.
    pub fn curve_path(deck: &Path) -> PathBuf {
        deck.with_file_name(format!("{}_curve.py", deck.file_stem().unwrap_or_default().to_string_lossy()))
    }
}

/// Writes the script of `mesh`'s deck of a test, which `name` is called, to `out`.
///
/// # Errors
/// Fails with the errors of `out`.
pub(crate) fn write_curve(mesh: &Mesh, options: &DeckOptions, name: &str, mut out: impl Write) -> io::Result<()> {
    let Some(loads) = &options.loads else { return Err(io::Error::other("a deck without a test has no curve")) };
    out.write_all(of_test(mesh, loads, name).as_bytes())
}

/// A deck's name in the script: anything but a plain one would need escapes of Python's.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || "._- ".contains(c) { c } else { '_' }).collect()
}

/// The script of a test.
fn of_test(mesh: &Mesh, loads: &Loads, name: &str) -> String {
    let ends = |is_upper: bool| {
        let counts = |support: &RigidSupport| {
            support.axis == loads.axis && support.force_ratio.is_none() && support.is_upper == is_upper
        };
        let places = loads.supports.iter().enumerate().filter(|(_, support)| counts(support));
        let nodes: Vec<String> = places.map(|(place, _)| supports::reference(mesh, place).to_string()).collect();
        format!("[{}]", nodes.join(", "))
    };
    let whole = SCRIPT.replace("@DECK@", &plain(name));
    let whole = whole.replace("@HEIGHT@", &real(loads.length_mm)).replace("@SECTION@", &real(loads.section_mm2));
    let whole = whole.replace("@LOWER@", &ends(false)).replace("@UPPER@", &ends(true));
    let sense = if loads.presses { "-1.0" } else { "1.0" };
    whole.replace("@AXIS@", &(loads.axis + 1).to_string()).replace("@SENSE@", sense)
}
