//! The script that goes beside a deck: `abaqus python` writes `curve.csv` with it.

use super::lines::real;
use super::{Analysis, DeckOptions, supports};
use meso_collision::math::Aabb;
use meso_mesh::cells::Mesh;
use meso_mesh::figures::PhaseVolumes;
use meso_trial::{Loads, RigidSupport};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

const SCRIPT: &str = include_str!("curve.py");
/// The script's constants and its function `curve` for a test with supports of its own.
const OF_TEST: &str = include_str!("curve_of_test.py");
/// The functions between which that stands.
const PLACE: [&str; 2] = ["def curve(odb):", "def at_node("];

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
    if let Some(loads) = &options.loads {
        return out.write_all(of_test(mesh, loads, name).as_bytes());
    }
    let height = Aabb::around(&mesh.points).size().z;
    let section = options.section_mm2.unwrap_or_else(|| PhaseVolumes::of_mesh(mesh).total() / height);
    let sense = if options.analysis == Analysis::Tension { "1.0" } else { "-1.0" };
    let script = SCRIPT
        .replace("@DECK@", &plain(name))
        .replace("@HEIGHT@", &real(height))
        .replace("@SECTION@", &real(section))
        .replace("@TOP@", &(mesh.points.len() + 2).to_string())
        .replace("@SENSE@", sense);
    out.write_all(script.as_bytes())
}

/// A deck's name in the script: anything but a plain one would need escapes of Python's.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || "._- ".contains(c) { c } else { '_' }).collect()
}

/// The script of a test with supports of its own.
fn of_test(mesh: &Mesh, loads: &Loads, name: &str) -> String {
    let ends = |is_upper: bool| {
        let counts = |support: &RigidSupport| {
            support.axis == loads.axis && support.force_ratio.is_none() && support.is_upper == is_upper
        };
        let places = loads.supports.iter().enumerate().filter(|(_, support)| counts(support));
        let nodes: Vec<String> = places.map(|(place, _)| supports::reference(mesh, place).to_string()).collect();
        format!("[{}]", nodes.join(", "))
    };
    let [before, behind] = PLACE.map(|place| SCRIPT.find(place).expect("the script has its functions"));
    let whole = format!("{}{OF_TEST}{}", &SCRIPT[..before], &SCRIPT[behind..]);
    let whole = whole.replace("TOP_NODE = @TOP@\n", "").replace("@DECK@", &plain(name));
    let whole = whole.replace("@HEIGHT@", &real(loads.length_mm)).replace("@SECTION@", &real(loads.section_mm2));
    let whole = whole.replace("@LOWER@", &ends(false)).replace("@UPPER@", &ends(true));
    let sense = if loads.presses { "-1.0" } else { "1.0" };
    whole.replace("@AXIS@", &(loads.axis + 1).to_string()).replace("@SENSE@", sense)
}
