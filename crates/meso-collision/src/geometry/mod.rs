//! Bodies: convex polyhedra, their hulls, offsets and the ellipsoids they are cut from; closed surfaces of any shape; balls.

mod compact;
pub mod ellipsoid;
mod exact;
mod faces;
mod hull;
mod measure;
mod offset;
mod plane;
mod polyhedron;
mod round;
mod sieve;
mod surface;

pub use compact::CompactPolyhedron;
pub use exact::predicates::orient3d;
pub use faces::Face;
pub use hull::HullBuilder;
pub use hull::{HullError, convex_hull};
pub use measure::inradius::Ball;
pub use measure::principal::principal_axes;
pub use offset::OffsetError;
pub use plane::Facet;
pub use plane::Plane;
pub use polyhedron::{BodyForm, MassProperties, Polyhedron};
pub use round::Round;
pub use surface::body_surface::BodySurface;
pub use surface::box_tree::BoxTree;
pub use surface::clip::clipped;
pub use surface::nearest::nearest_on_triangle;
pub use surface::triangle_mesh::{SurfaceError, TriangleMesh};
pub use surface::triangles::Triangles;
