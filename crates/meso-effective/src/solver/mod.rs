//! Potentials of a network: conjugate gradients with a multigrid cycle.
//!
//! Sums are added up in the order of layers, and layers in the order of voxels, so the number of threads changes no bit.

mod blocks;
mod conjugate;
mod coupled;
mod graph;
mod multigrid;
mod network;
mod stencil;

pub(crate) use conjugate::{Energy, Equations, Solution, solve, solve_equations};
pub(crate) use graph::{Graph, Rows};
pub(crate) use multigrid::Multigrid;
pub(crate) use stencil::{dot, layers_mut};
