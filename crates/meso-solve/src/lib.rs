//! Crushes a mesh: explicit dynamics of mesoscale concrete between rigid plates.
//!
//! Units as everywhere: mm, N, MPa, tonne, s; energies in mJ (N mm).

pub mod law;
pub mod point;
pub mod real;
