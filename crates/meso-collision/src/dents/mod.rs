//! Closed surfaces of triangles that need not be convex: proofs that two are apart, and that one does not cross itself.

mod bodies;
mod closed;
mod self_crossing;

pub use self_crossing::SelfCrossing;
