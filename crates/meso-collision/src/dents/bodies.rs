//! Questions about bodies that may have dents or be round, which the convex answers do not reach.

use crate::geometry::{Polyhedron, Triangles};
use crate::math::Vec3;
use crate::posed::WithTree;

/// Least and most divisions of the box for the volume of an erosion.
const EROSION_HALVINGS: [usize; 2] = [4, 8];
/// The smallest cubes are at most so large, over the volume of the body by its area: 3/8 of a plate's thickness.
const COARSEST: f64 = 0.75;

/// Steps to and fro between two surfaces that bound their distance.
const TURNS: usize = 8;

impl Polyhedron {
    /// How far `x` is from the body, mm, negative inside: see [`WithTree::height`].
    pub fn height(&self, x: &Vec3) -> f64 {
        WithTree::new(self).height(x)
    }

    /// Volume of the points deeper than `thickness` mm in a body with dents, below its [skin](Self::skin), or in an ellipsoid, mm3.
    ///
    /// Cubes count too much at edges, 0.6 % of a body in all. The core's edges are as bent as the body's and shorter, so that the
    /// excess of the body, whose volume is known, tells the core's. The shell is exact to 0.5 % (rms of stones, at most 1.4 %; rings
    /// of 0.8 to 6 mm 0.4 %), and to 4 % where long straight edges lie along the axes.
    pub fn eroded_volume(&self, thickness: f64) -> f64 {
        let aabb = self.aabb();
        let halvings = self.erosion_halvings();
        let levels = [thickness, 0.0];
        let [core, whole] = match self.round() {
            Some(round) => aabb.volumes_above(halvings, |x, _, _: Option<&()>| {
                let (depth, inwards) = (-round.height(x), -round.normal(x));
                (levels.map(|level| (depth - level, inwards)), ())
            }),
            None => {
                let skin = self.skin(thickness);
                aabb.volumes_above(halvings, |x, reach, around| skin.depths_below(x, levels, reach, around))
            }
        };
        let shorter = libm::cbrt(core / whole);
        (core - (whole - self.volume()) * shorter).max(0.0)
    }

    /// Divisions of its box in a walk that measures its erosion; one more where it has caps, whose rims lie along the cubes.
    fn erosion_halvings(&self) -> usize {
        let (size, cube) = (self.aabb().size().max(), COARSEST * self.volume() / self.area());
        let [least, most] = EROSION_HALVINGS;
        let needed = (least..most).find(|halvings| size / f64::from(1 << halvings) <= cube).unwrap_or(most);
        needed + usize::from(self.caps() != 0)
    }
}

impl Triangles {
    /// Distance of two bodies by their surfaces, mm; 0 where they share a point.
    pub fn distance(&self, other: &Self) -> f64 {
        // Two points that are nearest to the other surface in turn bound the distance.
        let (mut at, mut most) = ((self.aabb().min + self.aabb().max) / 2.0, f64::INFINITY);
        for _ in 0..TURNS {
            let Some((over, _)) = other.nearest(&at) else { break };
            let Some((back, distance)) = self.nearest(&over) else { break };
            (at, most) = (back, distance);
        }
        self.distance_below(other, most)
    }
}
