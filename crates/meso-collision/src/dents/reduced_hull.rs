//! A convex body of fewer corners, within the given one and nowhere farther from its surface than a stated distance.
//!
//! Corners are chosen in the order of quickhull (C. B. Barber, D. P. Dobkin, H. Huhdanpaa, The quickhull algorithm for convex
//! hulls, 1996): those come next that are farthest from the hull of the chosen ones. The hull of corners is convex, and holds
//! no point outside of the given body. A distance from a convex body is a convex function, so that the corners that are left
//! out are the farthest points.

use crate::geometry::{HullError, Polyhedron, Triangles, convex_hull};
use crate::math::Vec3;

impl Polyhedron {
    /// The hull of some of this convex body's vertices, nowhere more than `distance` mm within it.
    ///
    /// # Errors
    /// Where the body is flat beyond the precision of its coordinates.
    pub fn reduced_hull(&self, distance: f64) -> Result<Self, HullError> {
        let mut corners = Corners::new(self.vertices());
        let mut hull = corners.hull()?;
        let mut most = corners.measure(&hull, 0.0);
        while most > distance {
            let level = (most * NEXT_LEVEL).max(distance);
            most = corners.measure(&hull, level);
            while most > level {
                corners.choose(level);
                hull = corners.hull()?;
                most = corners.measure(&hull, level);
            }
        }
        Ok(hull)
    }
}

/// Corners are chosen down to this share of the largest distance, then that is measured anew: a corner that comes early
/// makes others needless.
const NEXT_LEVEL: f64 = 0.7;

/// The vertices of a body, some of them chosen.
struct Corners<'a> {
    vertices: &'a [Vec3],
    is_chosen: Vec<bool>,
    /// Distance of every vertex from an earlier hull, which bounds that from the last one, and the nearest triangle.
    far: Vec<(f64, u32)>,
}

impl<'a> Corners<'a> {
    /// Four vertices that span a volume are chosen.
    fn new(vertices: &'a [Vec3]) -> Self {
        let mut corners =
            Self { vertices, is_chosen: vec![false; vertices.len()], far: vec![(f64::INFINITY, 0); vertices.len()] };
        let first = corners.take_farthest(|v| v.x);
        let second = corners.take_farthest(|v| (v - first).norm_squared());
        let third = corners.take_farthest(|v| (second - first).cross(&(v - first)).norm_squared());
        let normal = (second - first).cross(&(third - first));
        corners.take_farthest(|v| normal.dot(&(v - first)).abs());
        corners
    }

    /// Chooses the vertex of the largest value, the first one of equals.
    fn take_farthest(&mut self, value: impl Fn(&Vec3) -> f64) -> Vec3 {
        let values = self.vertices.iter().map(value).enumerate();
        let better = |best: (usize, f64), next: (usize, f64)| if next.1 > best.1 { next } else { best };
        let (farthest, _) = values.fold((0, f64::NEG_INFINITY), better);
        self.is_chosen[farthest] = true;
        self.vertices[farthest]
    }

    fn hull(&self) -> Result<Polyhedron, HullError> {
        let chosen = self.vertices.iter().zip(&self.is_chosen).filter(|(_, is_chosen)| **is_chosen);
        convex_hull(&chosen.map(|(vertex, _)| *vertex).collect::<Vec<_>>())
    }

    /// Measures the vertices that may be farther than `level` from the hull; the largest distance that one may have.
    fn measure(&mut self, hull: &Polyhedron, level: f64) -> f64 {
        let facets = facets(hull);
        let mut most = 0.0_f64;
        for ((vertex, far), is_chosen) in self.vertices.iter().zip(&mut self.far).zip(&self.is_chosen) {
            if far.0 > level {
                *far = if *is_chosen {
                    (0.0, 0)
                } else {
                    facets.nearest_triangle(vertex).map_or((0.0, 0), |(t, d)| (d, t))
                };
            }
            most = most.max(far.0);
        }
        most
    }

    /// Chooses the farthest vertex above each triangle that has some farther than `level`.
    fn choose(&mut self, level: f64) {
        let mut above: Vec<(u32, f64, usize)> = Vec::new();
        above.extend(self.far.iter().enumerate().filter(|(_, far)| far.0 > level).map(|(i, far)| (far.1, far.0, i)));
        above.sort_unstable_by(|p, q| p.0.cmp(&q.0).then(q.1.total_cmp(&p.1)).then(p.2.cmp(&q.2)));
        above.dedup_by_key(|corner| corner.0);
        above.iter().for_each(|corner| self.is_chosen[corner.2] = true);
    }
}

fn facets(hull: &Polyhedron) -> Triangles {
    Triangles::new(hull.triangles().map(|t| t.map(|i| hull.vertices()[i as usize])).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    /// Points on an ellipsoid, all of them corners of its hull.
    fn egg(count: usize) -> Polyhedron {
        let mut stream = Stream::new(5);
        let mut point = || Vec3::from_fn(|_, _| stream.uniform(-1.0, 1.0));
        let points = (0..count).map(|_| point().normalize().component_mul(&Vec3::new(10.0, 7.0, 5.0)));
        convex_hull(&points.collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn a_reduced_hull_lies_within_the_body_as_near_as_stated_and_has_few_corners() {
        let given = egg(20_000);
        for distance in [0.4, 0.1, 0.02] {
            let reduced = given.reduced_hull(distance).unwrap();
            // A ball of the longest radius whose facets, all of one size, are as deep has 2.4 r / d corners.
            let (count, of_a_ball) = (reduced.vertices().len() as f64, 2.4 * 10.0 / distance);
            assert!(count < 2.0 * of_a_ball && count > 0.5 * of_a_ball, "{count} corners for {distance}");
            assert!(reduced.vertices().iter().all(|corner| given.vertices().contains(corner)));
            let surface = facets(&reduced);
            let farthest = given.vertices().iter().map(|v| -surface.depth(v)).fold(0.0, f64::max);
            assert!(farthest <= distance && farthest > 0.5 * distance, "{farthest}");
            let lost = given.volume() - reduced.volume();
            assert!(lost > 0.0 && lost < distance * given.area(), "{lost}");
        }
        assert_eq!(given.reduced_hull(0.0).unwrap().vertices().len(), given.vertices().len());
    }

    #[test]
    fn a_block_keeps_its_corners() {
        let block: Vec<Vec3> =
            (0..8).map(|k| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64 * 2.0, (k >> 2) as f64)).collect();
        let block = convex_hull(&block).unwrap();
        assert_eq!(block.reduced_hull(0.1).unwrap(), block);
    }
}
