//! Upper bounds on a body in a container: a body that fits nowhere is refused before the work.
//!
//! A body may be far below each bound and still not fit; bodies that pass all of them are tried.

use crate::aggregate::Grain;
use crate::parallel;
use meso_collision::math::{Aabb, Vec3, longest_distance};

/// No body in the container exceeds any of these.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Largest {
    /// Radius of a ball, mm.
    pub ball_radius: f64,
    /// Distance between two points of one component, mm.
    pub length: f64,
    /// Volume of one component, mm3.
    pub volume: f64,
}

/// Relative error of lengths and volumes.
const ROUNDING: f64 = 1e-6;

impl Largest {
    /// Bounds for bodies that keep `gap` mm from the surface.
    #[must_use]
    pub fn less(&self, gap: f64) -> Self {
        Self { ball_radius: self.ball_radius - gap, length: self.length - 2.0 * gap, ..*self }
    }

    /// False for a grain that fits at no position and orientation.
    pub fn admits(&self, grain: &Grain) -> bool {
        let longest = || longest_distance(&grain.body.vertices().collect::<Vec<_>>());
        let beyond = |own: f64, limit: f64| own > limit * (1.0 + ROUNDING);
        let too_long = beyond(2.0 * f64::from(grain.outer_radius), self.length) && beyond(longest(), self.length);
        !(beyond(f64::from(grain.inner_radius), self.ball_radius) || beyond(grain.volume(), self.volume) || too_long)
    }
}

/// The bound is at most this share above the largest ball. A tighter one takes the more cells the flatter the
/// container is.
const ABOVE: f64 = 0.1;
/// Most points evaluated, some microseconds each; where they do not suffice the bound is a looser one.
const MOST_LOOKS: usize = 200_000;

/// Radius of the largest ball in a container within `aabb`, mm, or a little more, by halving the cubes that may hold
/// its centre. The `depth` of a point is its distance to the surface, negative outside.
pub(super) fn ball_radius(aabb: &Aabb, depth: impl Fn(&Vec3) -> f64 + Sync) -> f64 {
    let mut half = aabb.size().max() / 2.0;
    let mut cubes = vec![(aabb.min + aabb.max) / 2.0];
    let (mut largest, mut looks) = (0.0, 0);
    while !cubes.is_empty() {
        looks += cubes.len();
        let depths = parallel::map_each(&cubes, &depth);
        largest = depths.iter().copied().fold(largest, f64::max);
        // The depth of no point of a cube is more than its middle's by more than this.
        let farthest = half * 3f64.sqrt();
        let enough = largest * (1.0 + ABOVE);
        let bounds = cubes.iter().zip(&depths).map(|(cube, depth)| (cube, depth + farthest));
        let open: Vec<(&Vec3, f64)> = bounds.filter(|(_, bound)| *bound > enough).collect();
        if looks + 8 * open.len() > MOST_LOOKS {
            return open.iter().map(|(_, bound)| *bound).fold(enough, f64::max);
        }
        half /= 2.0;
        cubes = open.iter().flat_map(|(cube, _)| eighths(cube, half)).collect();
    }
    largest * (1.0 + ABOVE)
}

/// The middles of the eight parts of a cube, each `half` mm to its sides.
fn eighths(cube: &Vec3, half: f64) -> impl Iterator<Item = Vec3> {
    let side = move |i: u32, axis: u32| if i >> axis & 1 == 1 { half } else { -half };
    (0..8).map(move |i| cube + Vec3::new(side(i, 0), side(i, 1), side(i, 2)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_ball_of_two_is_found_and_little_more() {
        let aabb = Aabb { min: Vec3::zeros(), max: Vec3::new(90.0, 20.0, 30.0) };
        let ball = |point: &Vec3, at: f64, radius: f64| radius - (point - Vec3::new(at, 10.0, 10.0)).norm();
        let found = ball_radius(&aabb, |point| ball(point, 10.0, 7.0).max(ball(point, 71.3, 9.0)));
        assert!((9.0..=9.0 * (1.0 + ABOVE) + 1e-9).contains(&found), "{found}");
        // A slab has a plane full of largest balls, too many to separate.
        let found = ball_radius(&aabb, |point| (2.0 - (point.y - 9.1).abs()).min(point.x).min(90.0 - point.x));
        assert!((2.0..=2.5).contains(&found), "{found}");
    }
}
