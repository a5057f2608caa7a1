//! Errors of meshes and decks, with options as their user spells them.

use super::flags::{DeckFlags, MeshFlags};
use super::settings::Meshing;
use crate::failure::Failure;
use meso_ask::{Giver, deck_refusal};
use meso_concrete::OutOfRange;
use meso_core::mesh::MeshError;
use meso_solve::TrialError;

impl MeshFlags {
    /// Turns an error of meshing into a failure; wrong options are wrong usage.
    pub(crate) fn wrong(&self, error: &MeshError) -> Failure {
        let giver = self.given.giver();
        wrong_mesh(error, giver)
    }
}

/// Turns an error of meshing into a failure, with the options of a `giver`.
pub(super) fn wrong_mesh(error: &MeshError, giver: Giver<'_>) -> Failure {
    let text = error.message(|key| giver.option(key));
    match error {
        MeshError::Option(wrong) => Failure::Usage(giver.refusal(wrong)),
        MeshError::MissingGmsh { .. } => {
            Failure::Run(format!("{text} and put it on the PATH or name it with --gmsh, or take --method lattice"))
        }
        MeshError::PhaseError { .. } => {
            Failure::Run(format!("{text}; {} accepts it", giver.option("accept_phase_error")))
        }
        MeshError::NearTouching { .. } => {
            Failure::Run(format!("{text}; `mesocrete pack --method conforming` leaves such gaps by itself"))
        }
        _ => Failure::Run(text),
    }
}

impl Meshing {
    /// Turns a value of a deck out of its range into wrong usage.
    pub(crate) fn wrong_option(&self, error: &OutOfRange) -> Failure {
        Failure::Usage(self.deck.given.refusal(error))
    }
}

impl DeckFlags {
    /// Turns an error of a deck's test into wrong usage.
    pub(super) fn wrong_test(&self, error: &TrialError) -> Failure {
        Failure::Usage(deck_refusal(&self.given.options, "analysis", error, self.given.giver()))
    }
}
