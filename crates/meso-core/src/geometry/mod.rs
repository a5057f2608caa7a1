//! Convex bodies: polyhedra, their hulls, offsets and the ellipsoids they are cut from.

mod box_tree;
mod clip;
mod compact;
mod double_double;
pub mod ellipsoid;
mod faces;
mod facet_kernels;
pub mod hull;
mod inradius;
mod integer;
mod integrals;
mod nearest;
pub mod offset;
mod polyhedron;
mod predicates;
mod sieve;
mod triangle_mesh;

pub(crate) use box_tree::BoxTree;
pub use clip::clipped;
pub use compact::CompactPolyhedron;
pub use faces::Face;
pub use hull::{HullBuilder, HullError, affine_dimension, convex_hull, convex_hull_like};
pub use inradius::{Ball, inscribed_ball};
pub(crate) use nearest::nearest_on_triangle;
pub use offset::{OffsetError, inward_offset};
pub use polyhedron::{Facet, MassProperties, Plane, Polyhedron};
pub(crate) use predicates::orient3d;
pub use predicates::{MAX_MAGNITUDE, MIN_MAGNITUDE};
pub use sieve::{principal_axes, sieve_size};
pub use triangle_mesh::{SurfaceError, TriangleMesh};
