//! Closed surfaces of triangles that need not be convex: proofs that two are apart, that one does not cross
//! itself, and that one in fewer triangles is near.

mod bodies;
mod closed;
mod height_grid;
mod inset;
mod reduced;
mod reduced_hull;
mod self_crossing;
mod skin;

pub use height_grid::{Height, HeightGrid};
pub use reduced::NotReduced;
pub use self_crossing::SelfCrossing;
pub use skin::Skin;
