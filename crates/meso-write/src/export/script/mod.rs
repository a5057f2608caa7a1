//! The script that goes beside a deck of a test and writes `curve.csv`: `abaqus python` runs that of an `.inp`.

use super::abaqus::lines::real;
use super::abaqus::{Analysis, DeckOptions, supports};
use super::lsdyna;
use meso_mesh::cells::Mesh;
use meso_trial::{Loads, RigidSupport};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

const ODB: &str = concat!(include_str!("odb.py"), include_str!("common.py"));
const BINOUT: &str = concat!(include_str!("binout.py"), include_str!("common.py"));

impl DeckOptions {
    /// Whether a deck of a test has a script beside it.
    pub(crate) fn has_script(&self) -> bool {
        self.has_curve() && !matches!(self.analysis, Analysis::Striker)
    }

    /// Where the script of the deck at `deck` is: `name_curve.py` beside `name.inp`, `name_binout.py` beside `name.k`.
    pub fn curve_path(deck: &Path) -> PathBuf {
        let is_k = deck.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("k"));
        let end = if is_k { "binout" } else { "curve" };
        deck.with_file_name(format!("{}_{end}.py", deck.file_stem().unwrap_or_default().to_string_lossy()))
    }
}

/// Writes the script of `mesh`'s deck of a test, a `.k` or an `.inp`, which `name` is called, to `out`.
///
/// # Errors
/// Fails with the errors of `out`.
pub(crate) fn write(is_k: bool, mesh: &Mesh, options: &DeckOptions, name: &str, mut out: impl Write) -> io::Result<()> {
    let Some(loads) = &options.loads else { return Err(io::Error::other("a deck without a test has no curve")) };
    let script = if is_k { binout(loads) } else { odb(mesh, loads) };
    // The script of a `.k` opens its deck; Python takes the escapes of JSON.
    let script = script.replace("\"@DECK@\"", &serde_json::to_string(name)?);
    let whole = script.replace("@DECK@", &plain(name));
    let whole = whole.replace("@HEIGHT@", &real(loads.length_mm)).replace("@SECTION@", &real(loads.section_mm2));
    out.write_all(whole.replace("@AXIS@", &(loads.axis + 1).to_string()).as_bytes())
}

/// How the script of the deck with this name opens.
pub(crate) fn opening(name: &str) -> String {
    let first = ODB.split("@DECK@").next().unwrap_or_default();
    format!("{first}{}, from the job's results.\n", plain(name))
}

/// A deck's name in words: Python 2 takes ASCII alone.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || "._- ".contains(c) { c } else { '_' }).collect()
}

/// The supports at an end that the stress and the strain are taken at, with their places among all.
fn ends(loads: &Loads, is_upper: bool) -> impl Iterator<Item = (usize, &RigidSupport)> {
    loads.supports.iter().enumerate().filter(move |(_, support)| {
        support.axis == loads.axis && support.force_ratio.is_none() && support.is_upper == is_upper
    })
}

/// A list of Python.
fn list(items: impl Iterator<Item = String>) -> String {
    format!("[{}]", items.collect::<Vec<_>>().join(", "))
}

/// The script that reads an `.odb`.
fn odb(mesh: &Mesh, loads: &Loads) -> String {
    let nodes = |is_upper| list(ends(loads, is_upper).map(|(place, _)| supports::reference(mesh, place).to_string()));
    let whole = ODB.replace("@LOWER@", &nodes(false)).replace("@UPPER@", &nodes(true));
    whole.replace("@SENSE@", if loads.presses { "-1.0" } else { "1.0" })
}

/// The script that reads a `binout`.
fn binout(loads: &Loads) -> String {
    let lower = ends(loads, false).map(|(place, _)| {
        let (file, number) = lsdyna::force_of(loads, place);
        format!("(\"{file}\", {number})")
    });
    let whole = BINOUT.replace("@LOWER@", &list(lower));
    let whole = whole.replace("@LEAD@", &real(loads.lead_s)).replace("@DURATION@", &real(loads.duration_s));
    whole.replace("@PATH@", &list(loads.path_mm.iter().map(|&mm| real(mm))))
}
