//! Convex bodies: polyhedra, their hulls, offsets and the ellipsoids they are cut from.

mod compact;
#[doc(hidden)]
pub mod ellipsoid;
mod exact;
mod faces;
mod hull;
mod measure;
mod offset;
mod plane;
mod polyhedron;
mod sieve;
mod surface;

#[doc(hidden)]
pub use compact::CompactPolyhedron;
#[doc(hidden)]
pub use exact::predicates::orient3d;
pub use faces::Face;
#[doc(hidden)]
pub use hull::HullBuilder;
pub use hull::{HullError, convex_hull};
#[doc(hidden)]
pub use measure::inradius::Ball;
#[doc(hidden)]
pub use measure::principal::principal_axes;
pub use offset::OffsetError;
#[doc(hidden)]
pub use plane::Facet;
pub use plane::Plane;
pub use polyhedron::{MassProperties, Polyhedron};
#[doc(hidden)]
pub use surface::box_tree::BoxTree;
#[doc(hidden)]
pub use surface::clip::clipped;
#[doc(hidden)]
pub use surface::nearest::{ConvexSurface, nearest_on_triangle};

#[doc(hidden)]
pub use surface::triangle_mesh::{SurfaceError, TriangleMesh};
