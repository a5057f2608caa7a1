//! Same facets: are these still the facets of the hull? Testing every point against every face costs far less than a
//! hull.

use super::cloud::{Cloud, LANES, MOST_POINTS};
use crate::geometry::faces::Faces;
use crate::math::Vec3;
use crate::simd::{Wide, widest};

/// True only when the `faces` are triangles and, over `points`, the facets of their hull: every other point is below each, by
/// more than rounding can hide.
pub(super) fn are_facets(points: &[Vec3], faces: Faces) -> bool {
    let few = faces.byte_triangles().filter(|_| points.len() <= MOST_POINTS);
    few.is_some_and(|triangles| widest(LiesBelow { points, triangles }))
}

/// Whether no point is above a triangle, in vector registers.
struct LiesBelow<'a> {
    points: &'a [Vec3],
    triangles: &'a [[u8; 3]],
}

impl Wide for LiesBelow<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let cloud = Cloud::new(self.points);
        // A loop, as a closure given to `all` would be compiled for narrow registers.
        for corners in self.triangles {
            let plane = cloud.plane(corners.map(usize::from));
            let mut not_below = [0; LANES];
            for group in 0..cloud.groups {
                cloud.heights(group, &plane, &mut not_below);
            }
            // The corners of a face are the three points that rounding may see in its plane.
            if not_below.iter().sum::<u32>() != 3 {
                return false;
            }
        }
        true
    }
}
