//! Convex bodies: polyhedra, their hulls, offsets and the ellipsoids they are cut from.

pub mod ellipsoid;
pub mod hull;
pub mod offset;
mod polyhedron;

pub use hull::{HullError, convex_hull};
pub use offset::{OffsetError, inward_offset};
pub use polyhedron::{MassProperties, Plane, Polyhedron};
