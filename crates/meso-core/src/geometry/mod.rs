//! Convex bodies: polyhedra, their hulls, offsets and the ellipsoids they are cut from.

mod box_tree;
mod clip;
mod compact;
mod double_double;
pub(crate) mod ellipsoid;
mod faces;
mod facet_kernels;
pub(crate) mod hull;
mod inradius;
mod integer;
mod integrals;
mod nearest;
mod offset;
mod plane;
mod polyhedron;
mod predicates;
pub(crate) mod sieve;
mod sum;
mod triangle_mesh;

pub(crate) use box_tree::BoxTree;
pub(crate) use clip::clipped;
pub(crate) use compact::CompactPolyhedron;
pub use faces::Face;
pub(crate) use hull::HullBuilder;
pub use hull::{HullError, convex_hull};
#[doc(hidden)]
pub use inradius::Ball;
pub(crate) use nearest::{ConvexSurface, nearest_on_triangle};
pub use offset::OffsetError;
pub(crate) use plane::Facet;
pub use plane::Plane;
pub use polyhedron::{MassProperties, Polyhedron};
pub(crate) use predicates::orient3d;
pub(crate) use sieve::principal_axes;
#[doc(hidden)]
pub use triangle_mesh::{SurfaceError, TriangleMesh};
