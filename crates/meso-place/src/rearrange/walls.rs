//! The walls bodies are kept inside.

use super::contact::{Points, V};
use super::obstacle;
use crate::task::Task;
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::specimen::Container;

/// The container, moved inwards by the gap.
pub(super) struct Walls<'a> {
    container: &'a dyn Container,
    /// The least distance to its surface, mm, and the part of it that covers rounding.
    gap: f64,
    margin: f64,
    /// The walls of its bounding box, already moved inwards by that; infinitely far where it has none.
    low: Vec3,
    high: Vec3,
}

/// Most steps that bring a body back inside walls that are no box; the next sweep continues.
const MOST_STEPS: usize = 20;
/// A step shorter than this share of the gap's margin ends it.
const SETTLED: f64 = 0.1;

impl<'a> Walls<'a> {
    /// With a `margin` (mm) beyond the gap asked for, so that rounding does not take a body out.
    pub(super) fn new(task: &'a Task, margin: f64) -> Self {
        let gap = task.request.placement.wall_gap_mm + margin;
        let Aabb { min: low, max: high } = task.period.mixed(&Aabb::everywhere(), &task.container.aabb().grown(-gap));
        Self { container: &*task.container, gap, margin, low, high }
    }

    /// The centre of a body, of its box, its `turned` vertices about it and the rim around these, moved inside; false where
    /// that is not done yet.
    pub(super) fn confine(&self, centre: Vec3, own_box: &(V, V), points: (&[f32], f32), radius: f64) -> (Vec3, bool) {
        let (turned, gap) = (points.0, self.gap + f64::from(points.1));
        let mut centre = self.boxed_in(centre, own_box);
        if self.container.is_box() || self.container.is_clear(&centre, radius + self.gap) {
            return (centre, true);
        }
        let (x, yz) = turned.split_at(turned.len() / 3);
        let (y, z) = yz.split_at(x.len());
        let point = |i: usize| Vec3::new(f64::from(x[i]), f64::from(y[i]), f64::from(z[i]));
        let body: Vec<Vec3> = (0..x.len()).map(point).collect();
        let own = Points { x, y, z };
        for _ in 0..MOST_STEPS {
            let inside = self.container.confine(&body, &centre, gap);
            let inside = self.boxed_in(self.clear_of_obstacles(&own, inside, own_box, gap), own_box);
            let step = (inside - centre).norm();
            centre = inside;
            if step < SETTLED * self.margin {
                return (centre, true);
            }
        }
        (centre, false)
    }

    /// The centre after every obstacle near has pushed the body away in turn.
    fn clear_of_obstacles(&self, own: &Points, mut centre: Vec3, (low, high): &(V, V), gap: f64) -> Vec3 {
        let corner = |v: &V| Vec3::from_fn(|i, _| f64::from(v[i])) + centre;
        let near = Aabb { min: corner(low), max: corner(high) }.grown(self.gap);
        let mut obstacles = self.container.obstacles(&near);
        // The nearest first: a wall of several triangles pushes along itself where a farther one of them is asked
        // first.
        obstacles.sort_by_cached_key(|obstacle| obstacle::distance(obstacle.points, &centre).to_bits());
        for obstacle in &obstacles {
            centre += obstacle::push(own, &centre, obstacle, gap);
        }
        centre
    }

    /// The sides on which the walls of the box hold a body back that would have its centre there.
    pub(super) fn holds(&self, centre: &Vec3, (low, high): &(V, V)) -> [i8; 3] {
        [0, 1, 2].map(|i| {
            let below = centre[i] + f64::from(low[i]) < self.low[i];
            let above = centre[i] + f64::from(high[i]) > self.high[i];
            i8::from(above) - i8::from(below)
        })
    }

    fn boxed_in(&self, centre: Vec3, (low, high): &(V, V)) -> Vec3 {
        Vec3::from_fn(|i, _| centre[i].max(self.low[i] - f64::from(low[i])).min(self.high[i] - f64::from(high[i])))
    }
}
