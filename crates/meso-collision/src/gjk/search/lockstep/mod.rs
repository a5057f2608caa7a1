//! Many pairs side by side: a lane of a register for each.
//!
//! Runs the steps of [`ellipsoid`](crate::gjk::prove::ellipsoid) in f64 and [`mpr`](crate::gjk::search::mpr) in f32,
//! lane by lane; pairs that f32 leaves open are proved in f64 from the portal it came to. The modules are generic over
//! the instruction set.

mod bounds;
mod open;
mod pending;
mod queue;
mod rank;
mod search;
mod supports;
mod task;
mod vectors;

pub(crate) use bounds::Glance;
pub(crate) use pending::Pending;
pub(crate) use task::{Notes, Search, Undecided};
