//! Meshes, decks and tests: which of their options have flags.

use crate::Giver;
use crate::flags::{names, of_schema::Flag};
use crate::given::Options;
use meso_concrete::OutOfRange;
use meso_core::export::abaqus::DeckOptions;
use meso_core::mesh::MeshTable;
use meso_core::trial::{Test, TrialError};

/// Frames that the command keeps of a test that asks for none.
pub const FRAMES: u32 = 5;

impl Options for MeshTable {
    const FLAGS: &'static [Flag] = &[
        Flag::common("method", ""),
        // clap would take other programs' names of it for `--itz` and `--help`.
        Flag::common("element_size_mm", "H|auto").known_as(&["element-size", "size", "mesh-size", "h"]),
        Flag::common("itz", ""),
        Flag::rare("joined", ""),
        Flag::rare("volumes", ""),
        Flag::rare("narrow_gaps", "GAPS"),
        Flag::rare("fit", ""),
        Flag::rare("order", "N"),
        Flag::rare("thin_itz", ""),
        Flag::rare("subsamples", "N"),
        Flag::rare("slabs", "N"),
    ];
}

impl Options for DeckOptions {
    const FLAGS: &'static [Flag] = &[
        Flag::rare("reduced_integration", ""),
        Flag::common("geometry_only", ""),
        Flag::rare("periodic_equations", ""),
        Flag::rare("strain", "E"),
        Flag::rare("friction", "MU"),
        Flag::rare("duration_s", "S"),
        Flag::rare("time_increment_s", "S"),
        Flag::rare("frames", "N"),
        Flag::rare("impact_speed_mm_per_s", "MM_S"),
        Flag::rare("lsdyna_law", "LAW"),
        Flag::rare("with_damage", ""),
    ];
}

impl Options for Test {
    const FLAGS: &'static [Flag] = &[
        Flag::common("friction", "MU"),
        Flag::common("pressure_mpa", "P"),
        Flag::common("strain", "E"),
        Flag::common("law", ""),
        Flag::rare("smoothing", "OVER"),
        Flag::rare("control", "HOW"),
        Flag::common("frames", "N").usually(FRAMES),
        Flag::rare("duration_s", "S"),
        Flag::rare("time_step_s", "S"),
    ];
}

/// A refusal of a deck's test in its giver's spelling: the `kind` of the test, and what that brings by itself, have the name of
/// its option, and a value that the deck lays over the test's own the key of the deck.
pub fn deck_refusal(deck: &DeckOptions, kind: &str, error: &TrialError, giver: Giver<'_>) -> String {
    let TrialError::Value(wrong) = error else { return error.to_string() };
    let named = deck.test().filter(|test| wrong.key == "turns.at" && test.turns.is_empty());
    if let Some(test) = named {
        let value = names::of(&test.kind);
        return giver.refusal(&OutOfRange { key: kind.to_owned(), value, ..wrong.clone() });
    }
    let laid = [
        ("strain", "strain", deck.strain),
        ("friction", "friction", deck.friction),
        ("duration_s", "duration_s", deck.duration_s),
        ("time_step_s", "time_increment_s", deck.time_increment_s),
    ];
    let laid = laid.into_iter().find(|(own, _, value)| *own == wrong.key && value.is_some()).map(|(_, key, _)| key);
    match laid.or((wrong.key == "kind").then_some(kind)) {
        Some(key) => giver.refusal(&OutOfRange { key: key.to_owned(), ..wrong.clone() }),
        None => error.to_string(),
    }
}
