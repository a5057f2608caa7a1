//! Are these still the facets? One look at every point from every face, which is far less than to build a hull.

use super::surface::error_bound;
use crate::geometry::{Face, NarrowPolyhedron};
use crate::math::{Aabb, Vec3};
use crate::wide::{Wide, widest};

/// No more points than this are looked at: the work grows with their square.
const MOST_POINTS: usize = 64;
/// Points looked at together.
const LANES: usize = 8;

/// True only when the faces of `like` are triangles and, over `points` in place of its vertices, the facets of their hull:
/// every other point is below each, by more than rounding can hide.
pub(super) fn are_facets(points: &[Vec3], like: &NarrowPolyhedron) -> bool {
    let few = points.len() <= MOST_POINTS && like.faces().all(|face| face.len() == 3);
    few && widest(LiesBelow { points, like })
}

/// Whether no point is above a face, on wide registers.
struct LiesBelow<'a> {
    points: &'a [Vec3],
    like: &'a NarrowPolyhedron,
}

impl Wide for LiesBelow<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        Cloud::new(self.points).lies_below(self.like)
    }
}

/// Points about the middle of their box, one array per coordinate, padded with a point inside.
struct Cloud {
    x: [f64; MOST_POINTS],
    y: [f64; MOST_POINTS],
    z: [f64; MOST_POINTS],
    /// Used of these, a multiple of [`LANES`].
    len: usize,
    error_bound: f64,
}

impl Cloud {
    #[inline(always)]
    fn new(points: &[Vec3]) -> Self {
        let aabb = Aabb::around(points);
        let middle = (aabb.min + aabb.max) * 0.5;
        let inside = points.iter().sum::<Vec3>() / points.len() as f64 - middle;
        let [mut x, mut y, mut z] = [inside.x, inside.y, inside.z].map(|value| [value; MOST_POINTS]);
        for (i, point) in points.iter().enumerate() {
            (x[i], y[i], z[i]) = (point.x - middle.x, point.y - middle.y, point.z - middle.z);
        }
        Self { x, y, z, len: points.len().next_multiple_of(LANES), error_bound: error_bound(&aabb) }
    }

    #[inline(always)]
    fn lies_below(&self, faces: &NarrowPolyhedron) -> bool {
        // The corners of a face are the three that rounding may see in its plane.
        faces.faces().flat_map(Face::triangles).all(|corners| self.not_below(corners) == 3)
    }

    /// How many points are not certainly below the plane of `corners`.
    #[inline(always)]
    fn not_below(&self, corners: [u32; 3]) -> u32 {
        let [a, b, c] = corners.map(|i| Vec3::new(self.x[i as usize], self.y[i as usize], self.z[i as usize]));
        let normal = (b - a).cross(&(c - a));
        let offset = normal.dot(&c);
        let mut count = [0; LANES];
        for start in (0..self.len).step_by(LANES) {
            for (lane, count) in count.iter_mut().enumerate() {
                let i = start + lane;
                let height = normal.x * self.x[i] + normal.y * self.y[i] + normal.z * self.z[i] - offset;
                *count += u32::from(height >= -self.error_bound);
            }
        }
        count.iter().sum()
    }
}
