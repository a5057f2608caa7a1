//! Convex bodies: polyhedra, their hulls, offsets and the ellipsoids they are cut from.

mod box_tree;
mod clip;
mod compact;
mod double_double;
#[doc(hidden)]
pub mod ellipsoid;
mod faces;
mod facet_kernels;
mod hull;
mod inradius;
mod integer;
mod integrals;
mod nearest;
mod offset;
mod plane;
mod polyhedron;
mod predicates;
mod principal;
mod sieve;
mod sum;
mod tetrahedron;
mod triangle_mesh;

#[doc(hidden)]
pub use box_tree::BoxTree;
#[doc(hidden)]
pub use clip::clipped;
#[doc(hidden)]
pub use compact::CompactPolyhedron;
pub use faces::Face;
#[doc(hidden)]
pub use hull::HullBuilder;
pub use hull::{HullError, convex_hull};
#[doc(hidden)]
pub use inradius::Ball;
#[doc(hidden)]
pub use nearest::{ConvexSurface, nearest_on_triangle};
pub use offset::OffsetError;
#[doc(hidden)]
pub use plane::Facet;
pub use plane::Plane;
pub use polyhedron::{MassProperties, Polyhedron};
#[doc(hidden)]
pub use predicates::orient3d;
#[doc(hidden)]
pub use principal::principal_axes;

#[doc(hidden)]
pub use triangle_mesh::{SurfaceError, TriangleMesh};
