//! Convex hull of points, with exact predicates.

use super::Polyhedron;
use crate::math::Vec3;

/// Why points have no solid hull.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HullError {
    /// There are no points.
    #[error("no points were given; a hull needs at least four that do not lie in one plane")]
    Empty,
    /// A coordinate is NaN or infinite.
    #[error("point {index} is not finite")]
    NotFinite {
        /// Row of the point.
        index: usize,
    },
    /// A coordinate is outside {0} and 1e-60 to 1e60.
    #[error("point {index} has a coordinate beyond the accepted magnitudes 1e-60 to 1e60 (or 0)")]
    OutOfRange {
        /// Row of the point.
        index: usize,
    },
    /// The points span less than three dimensions.
    #[error("the points span {dimension} dimension(s), a solid hull needs 3; they lie {}", ["in one point", "on one line", "in one plane"][*dimension as usize])]
    LowerDimensional {
        /// 0: one point, 1: a line, 2: a plane.
        dimension: u8,
    },
}

/// The convex hull of `points` (mm): exact extreme set, outward faces, coplanar triangles merged into polygons.
///
/// # Errors
/// See [`HullError`].
pub fn convex_hull(points: &[Vec3]) -> Result<Polyhedron, HullError> {
    let _ = points;
    todo!("landed by the geometry change")
}
