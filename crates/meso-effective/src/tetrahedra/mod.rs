//! Diffusivity, conductivity and stiffness on a lattice of linear tetrahedra whose faces follow the aggregates.
//!
//! Unknowns are the nodes' deviations from a mean gradient or strain; images across a periodic axis share one. A second mesh of
//! twice the element size gives the error. Sums are added up by runs of cells and rows, so the number of threads changes no bit.

mod cracked;
mod domain;
mod flux;
mod meshed;
mod solid;
mod uniform;
mod unloading;

pub use cracked::{CrackValues, Cracked, effective_in_cracks};
pub use flux::effective_in_tetrahedra;
pub use solid::stiffness_in_tetrahedra;
pub use unloading::{Unloading, moduli_in_cracks};
