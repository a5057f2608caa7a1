//! Elements: displacements in, forces out, eight elements at a time.

pub(crate) mod bending;
pub(crate) mod face;
pub(crate) mod hex;
pub(crate) mod tet;
pub(crate) mod uniform;
