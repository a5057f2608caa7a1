//! Errors of meshes and decks, with options named by their flags.

use crate::failure::Failure;
use meso_concrete::OutOfRange;
use meso_core::export::abaqus::DeckOptions;
use meso_core::mesh::MeshError;
use meso_solve::TrialError;

/// Turns an error of meshing into a failure; wrong options are wrong usage.
pub(crate) fn wrong_mesh(error: &MeshError) -> Failure {
    let text = error.message(flag);
    match error {
        MeshError::Option(wrong) => wrong_option(wrong),
        MeshError::MissingGmsh { .. } => {
            Failure::Run(format!("{text} and put it on the PATH or name it with --gmsh, or take --method lattice"))
        }
        MeshError::PhaseError { .. } => Failure::Run(format!("{text}; --accept-phase-error accepts it")),
        MeshError::NearTouching { .. } => {
            Failure::Run(format!("{text}; `mesocrete pack --method conforming` leaves such gaps by itself"))
        }
        _ => Failure::Run(text),
    }
}

/// Turns a value out of its range into wrong usage, by the name of its flag.
pub(crate) fn wrong_option(error: &OutOfRange) -> Failure {
    Failure::Usage(format!("{} {}", flag(&error.key), error.fault()))
}

/// Turns an error of a deck's test into wrong usage: a value that was laid over the test's own has its flag.
pub(super) fn wrong_test(error: &TrialError, deck: &DeckOptions) -> Failure {
    let TrialError::Value(wrong) = error else { return Failure::Usage(error.to_string()) };
    let flag = match wrong.key.as_str() {
        "strain" if deck.strain.is_some() => "--strain",
        "friction" if deck.friction.is_some() => "--friction",
        "duration_s" if deck.duration_s.is_some() => "--duration",
        "time_step_s" if deck.time_increment_s.is_some() => "--time-increment",
        "kind" => "--analysis",
        _ => return Failure::Usage(error.to_string()),
    };
    Failure::Usage(format!("{flag} {}", wrong.fault()))
}

/// The flag of an option: `--element-size-mm` of `element_size_mm`. Flags drop the unit suffix `_s`; values of
/// `[materials]` have no flag.
pub(crate) fn flag(key: &str) -> String {
    if key.contains('.') {
        return key.to_owned();
    }
    format!("--{}", key.strip_suffix("_s").unwrap_or(key).replace('_', "-"))
}
