//! Many pairs side by side: a lane of a register for each.
//!
//! The same steps as [`ellipsoid`](super::ellipsoid) in f64 and [`mpr`](super::mpr) in f32, lane by lane. The modules are
//! generic over the instruction set.

mod bounds;
mod pending;
mod search;
mod supports;
mod vectors;

pub(super) use bounds::Glance;
pub(super) use pending::Pending;
pub(super) use search::{Search, Undecided};
