//! Convex bodies: polyhedra, their hulls, offsets and the ellipsoids they are cut from.

pub mod ellipsoid;
mod faces;
pub mod hull;
pub mod offset;
mod polyhedron;
mod predicates;

pub use faces::Face;
pub use hull::{HullBuilder, HullError, affine_dimension, convex_hull};
pub use offset::{OffsetError, inward_offset};
pub use polyhedron::{MassProperties, Plane, Polyhedron};
pub use predicates::{MAX_MAGNITUDE, MIN_MAGNITUDE};
