//! Closed surfaces of triangles that need not be convex: proofs that two are apart, that one does not cross
//! itself, and that one in fewer triangles is near.

mod bodies;
mod closed;
mod reduced;
mod self_crossing;

pub use reduced::NotReduced;
pub use self_crossing::SelfCrossing;
