//! A mesh as its makers see it.

use crate::cells::{CellKind, Mesh, NO_AGGREGATE, NO_BODY, Notes, Phase};
use meso_collision::math::Vec3;
use meso_concrete::aggregate::Aggregate;

/// Cells before they have their aggregates' ids: each knows its body by the index in the list of bodies and their periodic
/// images that the mesh is made of.
pub(super) struct Draft {
    pub(super) kind: CellKind,
    pub(super) points: Vec<Vec3>,
    pub(super) cells: Vec<u32>,
    pub(super) phase: Vec<Phase>,
    /// Index of every cell's body, [`NO_BODY`] in the mortar.
    pub(super) owner: Vec<u32>,
}

impl Draft {
    /// The mesh of `bodies`: only here do indices become ids, which a body and its images share.
    pub(super) fn into_mesh(self, bodies: &[Aggregate], periodic: [bool; 3], notes: Notes) -> Mesh {
        let id = |&owner: &u32| if owner == NO_BODY { NO_AGGREGATE } else { bodies[owner as usize].id };
        let aggregate = self.owner.iter().map(id).collect();
        Mesh { periodic, notes, ..Mesh::of(self.kind, self.points, self.cells, self.phase, aggregate) }
    }
}
