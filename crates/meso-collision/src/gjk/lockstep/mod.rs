//! Many pairs side by side: a lane of a register for each.
//!
//! The same steps as [`ellipsoid`](super::ellipsoid) in f64 and [`mpr`](super::mpr) in f32, lane by lane; what f32 leaves
//! open is proved in f64 from the portal it came to. The modules are generic over the instruction set.

mod bounds;
mod open;
mod pending;
mod queue;
mod rank;
mod search;
mod supports;
mod task;
mod vectors;

pub(super) use bounds::Glance;
pub(super) use pending::Pending;
pub(super) use task::{Notes, Search, Undecided};
