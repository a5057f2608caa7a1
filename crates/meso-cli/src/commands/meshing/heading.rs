//! Heading of a deck: the packing, and the command that writes the deck again.

use super::errors::flag;
use crate::commands::names;
use meso_core::Spec;
use meso_core::export::abaqus::{Analysis, DeckOptions, Loading};
use meso_core::export::lsdyna::LsdynaLaw;
use meso_core::mesh::MeshOptions;

/// Characters of a heading's line.
const LINE: usize = 76;

/// The command that gives the same deck. Files and threads change nothing, so it has none.
pub(super) fn command(
    mesh: &MeshOptions,
    deck: &DeckOptions,
    accepts_phase_error: bool,
    has_materials: bool,
    analysis: Vec<String>,
) -> String {
    let mut words = vec!["mesocrete mesh MODEL".to_owned()];
    words.extend(mesh.named().into_iter().map(|(key, value)| match value.as_str() {
        "true" => flag(key),
        value => format!("{} {value}", flag(key)),
    }));
    let switches = [
        ("--reduced-integration", deck.reduced_integration),
        ("--geometry-only", deck.geometry_only),
        ("--periodic-equations", deck.periodic_equations),
        ("--with-damage", deck.with_damage),
        ("--accept-phase-error", accepts_phase_error),
    ];
    words.extend(switches.into_iter().filter(|(_, given)| *given).map(|(flag, _)| flag.to_owned()));
    words.extend(analysis);
    if deck.lsdyna_law != LsdynaLaw::default() {
        words.push(format!("--lsdyna-law {}", names::of(&deck.lsdyna_law)));
    }
    words.extend(has_materials.then(|| "--materials FILE".to_owned()));
    words.join(" ")
}

/// Flags of the analysis.
pub(super) fn analysis(deck: &DeckOptions) -> Vec<String> {
    let mut words = Vec::new();
    if deck.analysis != Analysis::None && !deck.geometry_only {
        words.push(format!("--analysis {}", names::of(&deck.analysis)));
        words.extend(deck.strain.map(|strain| format!("--strain {strain}")));
    }
    if deck.analysis.is_explicit() {
        let Loading { friction, duration_s, time_increment_s, frames, impact_speed_mm_per_s } = deck.loading;
        words.push(format!("--friction {friction} --duration {duration_s:?} --time-increment {time_increment_s:?}"));
        words.push(format!("--frames {frames}"));
        if deck.analysis == Analysis::Impact {
            words.push(format!("--impact-speed {impact_speed_mm_per_s}"));
        }
    }
    words
}

/// Lines that name the packing and the command.
pub(super) fn lines(spec: &Spec, command: &str) -> Vec<String> {
    let packing = format!("packing: seed {}, fraction {} of a {}", spec.seed, spec.fraction, spec.specimen.kind());
    let mut lines = vec![packing];
    let mut line = String::from("command:");
    for word in command.split(' ') {
        if line.len() + 1 + word.len() > LINE {
            lines.push(std::mem::replace(&mut line, String::from("  ")));
        }
        line = line + " " + word;
    }
    lines.push(line);
    lines
}
