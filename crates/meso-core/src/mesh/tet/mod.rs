//! One tetrahedral mesh, for lattices, for gmsh's output and for the ITZ's layer, and what makes its angles larger.
//!
//! Operators propose and change nothing: [`Star`] where a node should go, [`swap`] and [`contract`] other cells in the same
//! volume. A driver applies: [`Topology`] keeps the cells around the nodes up to date, [`improve`] works from the poor cells on
//! within a budget. What a node may do is asked of its [`Constraint`].

mod constraint;
mod contract;
mod improve;
mod incidence;
mod quality;
mod star;
mod swap;
mod tetrahedra;
mod topology;

pub(super) use constraint::{Constraint, best_position, directions, smoothed};
pub(super) use contract::{contraction, insertion};
pub(super) use improve::{Improver, ascending, improve};
pub(super) use incidence::Incidence;
pub(super) use quality::{
    INVERTED, cos2_of, dihedral_cosines, face_vectors, min_dihedral_cos2, shortest_altitude, volume,
};
pub(super) use star::Star;
pub(super) use swap::{ON_MM, are_coplanar, swapped};
#[cfg(test)]
pub(super) use swap::{edge_removal, face_swap};
pub(super) use tetrahedra::{DROPPED, TetMesh, oriented};
#[cfg(test)]
pub(super) use topology::Replacement;
pub(super) use topology::{NEW, Topology};
