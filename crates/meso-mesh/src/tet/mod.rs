//! One tetrahedral mesh, for lattices, for gmsh's output and for the ITZ's layer, and the operators that make its angles larger.
//!
//! Operators propose and change nothing: [`Star`] where a node should go, [`operators`] other cells in the same volume. A driver
//! applies: [`Topology`] keeps the cells around the nodes up to date, [`improve()`] works from the poor cells on within a budget.
//! The moves of a node are limited by its [`Constraint`].

mod improve;
mod operators;
mod tetrahedra;
mod topology;

pub(crate) use crate::cells::volume;
pub(crate) use improve::{
    Constraint, Improver, Star, ascending, best_position, directions, eight_cos2, improve, smoothed,
};
pub(crate) use operators::{ON_MM, are_coplanar, contraction, edges, insertion, swapped};
#[cfg(test)]
pub(crate) use operators::{edge_removal, face_swap};
pub(crate) use tetrahedra::{
    INVERTED, TetMesh, centroid, cos2_of, dihedral_cosines, face_vectors, min_dihedral_cos2, oriented,
    shortest_altitude, stable_length,
};
#[cfg(test)]
pub(crate) use topology::Replacement;
pub(crate) use topology::{Incidence, NEW, Topology};
