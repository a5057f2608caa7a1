//! Concrete before it is packed: grains, the specimens that they fill, and the images of periodic ones.
//!
//! It also holds the tools that packing, meshing and writing share: who watches and when to stop, parallel loops.
//! Units: mm, mm3, radians; fractions from 0 to 1.

// No environment, clock, file, print or mathematics of the platform: the list is in `crates/clippy.toml`.
#![cfg_attr(not(test), deny(clippy::disallowed_methods, clippy::disallowed_types, clippy::disallowed_macros))]

pub mod aggregate;
pub mod images;
pub mod import;
mod out_of_range;
pub mod own_tables;
pub mod parallel;
mod parts;
mod phase;
mod physical_range;
mod printable;
mod room;
mod short;
pub mod specimen;
pub mod stop;
mod thousands;
pub mod watch;

pub use out_of_range::{OutOfRange, Ranges, exceeds, written};
pub use parts::{Parts, mark_caps};
pub use phase::{Phase, PhaseNames};
pub use physical_range::PhysicalRange;
pub use printable::printable;
pub use room::Room;
pub use short::short;
pub use thousands::thousands;
