//! Elements and their material laws: strains in, stresses and forces out, eight elements at a time.
//!
//! [`block::Block`] holds some 2,048 elements; [`InstructionSet::step`] moves all of them by one step, and
//! [`InstructionSet::probe`] asks for their states. The laws are generic over [`real::Real`]: one number, a register of
//! numbers, or a tape for other devices. A test, with its plates, masses and time, is the crate `meso-solve`.
//!
//! Units: mm, N, MPa, tonne, s; energies in mJ (N mm).

pub mod bending;
pub mod block;
pub mod face;
pub mod hex;
pub mod lanes;
pub mod law;
pub mod real;
// Unit tests do without: the kernels compile for a minute.
#[cfg(not(test))]
mod steps;
pub mod uniform;

pub use lanes::InstructionSet;
pub use law::LawName;
