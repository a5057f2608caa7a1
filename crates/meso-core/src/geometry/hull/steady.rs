//! Are these still the facets? One look at every point from every face, which is far less than to build a hull.

use super::cloud::{Cloud, LANES, MOST_POINTS};
use crate::geometry::{Face, NarrowPolyhedron};
use crate::math::Vec3;
use crate::wide::{Wide, widest};

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
        let cloud = Cloud::new(self.points);
        // The corners of a face are the three that rounding may see in its plane.
        self.like.faces().flat_map(Face::triangles).all(|corners| {
            let plane = cloud.plane(corners.map(|i| i as usize));
            let mut not_below = [0; LANES];
            for group in 0..cloud.groups {
                cloud.heights(group, &plane, &mut not_below);
            }
            not_below.iter().sum::<u32>() == 3
        })
    }
}
