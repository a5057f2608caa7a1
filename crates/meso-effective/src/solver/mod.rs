//! Potentials of a network of links: conjugate gradients with a multigrid cycle.
//!
//! Sums are added up in the order of layers, and layers in the order of voxels, so the number of threads changes no bit.

mod conjugate;
mod multigrid;
mod stencil;

pub(crate) use conjugate::{Equations, solve, solve_equations};
pub(crate) use multigrid::Multigrid;
pub(crate) use stencil::dot;
