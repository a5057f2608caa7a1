//! The ITZ smeared over the mortar next to the aggregates: cells of mortar with a face on one.

use super::cells::{Mesh, NO_AGGREGATE, Phase};
use super::interface;

/// Gives the mortar's cells that share a face with an aggregate's the phase ITZ; they belong to no aggregate still.
pub(super) fn name(mesh: &mut Mesh) {
    for face in interface::faces(mesh.by_aggregate()) {
        let [inside, outside] = [face.cell, face.behind].map(|cell| cell as usize);
        if mesh.phase[inside] == Phase::Aggregate && mesh.aggregate[outside] == NO_AGGREGATE {
            mesh.phase[outside] = Phase::Itz;
        }
    }
}
