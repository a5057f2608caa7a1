//! Self-crossing of a surface of triangles: the exact test of every triangle against its neighbours in space.

use super::closed::{is_beside, seen};
use crate::geometry::{TriangleMesh, Triangles};
use crate::gjk;
use crate::math::Vec3;
use crate::stop;
use robust::orient2d;

/// A surface whose triangles are compared with each other.
#[derive(Clone, Copy, Debug)]
pub struct SelfCrossing<'a> {
    /// The surface.
    pub mesh: &'a TriangleMesh,
    /// Its triangles, in their order.
    pub facets: &'a Triangles,
}

impl SelfCrossing<'_> {
    /// The first pair of triangles, by their numbers, that cross each other, or touch where they are not neighbours.
    pub fn find(&self) -> Option<[[Vec3; 3]; 2]> {
        (0..self.mesh.triangles.len() as u32).find_map(|a| self.of(a))
    }

    /// The triangle `a` and the first one after it that crosses it, if there is one.
    pub fn of(&self, a: u32) -> Option<[[Vec3; 3]; 2]> {
        stop::point();
        let crosses = |&b: &u32| b > a && self.cross(a, b);
        self.facets.around(a).filter(crosses).min().map(|b| [a, b].map(|t| *self.facets.of(t)))
    }

    /// True where two triangles share more than their common corners or edge.
    fn cross(&self, a: u32, b: u32) -> bool {
        let [p, q] = [a, b].map(|t| &self.mesh.triangles[t as usize]);
        let meets = |points: &[Vec3], t: u32| gjk::intersects(points, self.facets.of(t)).unwrap_or(true);
        match p.iter().filter(|i| q.contains(i)).count() {
            0 => meets(self.facets.of(a), b),
            // The corner or edge opposite to the shared one, against the whole other triangle.
            common @ (1 | 2) => {
                let (own, other) = (self.opposite(a, b), self.opposite(b, a));
                let (own, other) = (&own[..3 - common], &other[..3 - common]);
                let part = is_beside(other, self.facets.of(a)) || is_beside(own, self.facets.of(b));
                let part = part || self.part_in_a_view(a, b, other) || self.part_in_a_view(b, a, own);
                !part && (meets(own, b) || meets(other, a))
            }
            _ => true,
        }
    }

    /// The corners of a triangle that another has not come first.
    fn opposite(&self, of: u32, other: u32) -> [Vec3; 3] {
        let (own, other) = (&self.mesh.triangles[of as usize], &self.mesh.triangles[other as usize]);
        let (mut corners, mut found) = (*self.facets.of(of), 0);
        for corner in (0..3).filter(|&corner| !other.contains(&own[corner])) {
            corners.swap(found, corner);
            found += 1;
        }
        corners
    }

    /// True when an edge of `a` parts it from `b`, seen along an axis: the edge's line passes through all corners that
    /// the two share, and those of `b` alone, `others`, lie strictly beyond it. This separates neighbours in one plane.
    fn part_in_a_view(&self, a: u32, b: u32, others: &[Vec3]) -> bool {
        let (own, corners) = (&self.mesh.triangles[a as usize], self.facets.of(a));
        let is_shared = |corner: usize| self.mesh.triangles[b as usize].contains(&own[corner]);
        let parts = |[from, to, rest]: [usize; 3], axis: usize| {
            let turn = |point: &Vec3| orient2d(seen(&corners[from], axis), seen(&corners[to], axis), seen(point, axis));
            let side = turn(&corners[rest]);
            side != 0.0 && others.iter().all(|point| turn(point) * side < 0.0)
        };
        let passes =
            |&[from, to, _]: &[usize; 3]| usize::from(is_shared(from)) + usize::from(is_shared(to)) == 3 - others.len();
        let edges = [[0, 1, 2], [1, 2, 0], [2, 0, 1]];
        edges.into_iter().filter(passes).any(|edge| (0..3).any(|axis| parts(edge, axis)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::orient3d;
    use crate::random::Stream;

    /// Triangles on a grid of 4 x 4 x 2 points, so that many lie in one plane.
    #[test]
    fn neighbours_that_a_view_parts_meet_nowhere_else() {
        let mut stream = Stream::new(7);
        let (mut parted, mut in_one_plane) = (0, 0);
        for trial in 0..20_000 {
            let mut point = || Vec3::new(4.0, 4.0, 2.0).map(|n| stream.uniform(0.0, n).floor());
            let vertices: Vec<Vec3> = (0..5).map(|_| point()).collect();
            let second = if trial % 2 == 0 { [0, 3, 4] } else { [1, 0, 3] };
            let mesh = TriangleMesh { vertices, triangles: vec![[0, 1, 2], second] };
            let facets = mesh.facets();
            let surface = SelfCrossing { mesh: &mesh, facets: &facets };
            let (own, others) = (surface.opposite(0, 1), surface.opposite(1, 0));
            let count = 2 - trial % 2;
            if surface.part_in_a_view(0, 1, &others[..count]) {
                let meets = |points: &[Vec3], t: u32| gjk::intersects(points, surface.facets.of(t)).unwrap();
                assert!(!meets(&own[..count], 1) && !meets(&others[..count], 0), "{surface:?}");
                parted += 1;
                let [a, b, c] = surface.facets.of(0);
                in_one_plane += usize::from(others[..count].iter().all(|point| orient3d(a, b, c, point) == 0.0));
            }
        }
        assert!(parted > 4000 && in_one_plane > 400, "{parted} {in_one_plane}");
    }
}
