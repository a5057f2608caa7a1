//! Periodic packings are moved as a whole until no face of the box grazes an aggregate.
//!
//! A slice that a face cuts off, or leaves between itself and an aggregate, is as thick as the aggregate's outermost
//! point is far from the face. The cut's edges are as short as a corner is near. A periodic packing may be translated
//! freely, so `wall_gap_mm` is kept across periodic faces, too, as far as there is space.

use meso_collision::math::Vec3;
use meso_concrete::aggregate::Aggregate;
use meso_concrete::aggregate::grain::snap;
use meso_concrete::parallel;
use meso_concrete::specimen::{Period, Specimen};

/// Corners keep this share of the gap that outermost points keep: there are ten times as many.
const CORNER_SHARE: f64 = 0.02;

/// Translates `bodies`, in a periodic specimen, so that their outermost points keep `gap` mm from its periodic faces,
/// or as much of it as there is space for. Where they do already, nothing moves.
pub fn keep_off_faces(bodies: &mut [&mut Aggregate], specimen: &Specimen, gap: f64) {
    let period = specimen.period();
    if gap == 0.0 || period.is_none() || bodies.is_empty() {
        return;
    }
    let position = |axis| period.along(axis).map_or(0.0, |length| GrazingPlaces::of(bodies, axis, length).best(gap));
    let positions = [0, 1, 2].map(position);
    let shift = -snap(&Vec3::from(positions));
    if shift != Vec3::zeros() {
        parallel::each_mut(bodies, |_, body| body.body = body.body.translated(&wrapped(body, &shift, &period)));
    }
}

/// `shift` and the whole periods that bring the body's middle back into the box.
fn wrapped(body: &Aggregate, shift: &Vec3, period: &Period) -> Vec3 {
    let middle = body.body.centroid() + shift;
    let back = |axis| period.along(axis).map_or(0.0, |length| (middle[axis] / length).floor() * length);
    Vec3::from_fn(|axis, _| shift[axis] - back(axis))
}

/// Positions along an axis, within one period, at which a face would graze something; ascending.
struct GrazingPlaces {
    length: f64,
    /// Outermost points.
    ends: Vec<f64>,
    corners: Vec<f64>,
}

impl GrazingPlaces {
    fn of(bodies: &[&mut Aggregate], axis: usize, length: f64) -> Self {
        let sorted = |positions: &mut dyn Iterator<Item = f64>| {
            let mut positions: Vec<f64> = positions.map(|x| x - (x / length).floor() * length).collect();
            positions.sort_unstable_by(f64::total_cmp);
            positions
        };
        let boxes = bodies.iter().map(|body| body.body.aabb());
        let ends = sorted(&mut boxes.flat_map(|aabb| [aabb.min[axis], aabb.max[axis]]));
        let corners = sorted(&mut bodies.iter().flat_map(|body| body.body.vertices()).map(|vertex| vertex[axis]));
        Self { length, ends, corners }
    }

    /// The position nearest to the origin that keeps `gap` best, midway between two corners; the origin where it
    /// keeps all.
    fn best(&self, gap: f64) -> f64 {
        let next = self.corners.iter().skip(1).copied().chain([self.corners[0] + self.length]);
        let middles = self.corners.iter().zip(next).map(|(corner, next)| (corner + next) / 2.0);
        // Beyond half a period the opposite shift is the shorter one.
        let signed = middles.map(|x| if x > self.length / 2.0 { x - self.length } else { x });
        let rated = [0.0].into_iter().chain(signed).map(|x| (self.kept(x, gap), x));
        let better = |a: (f64, f64), b: (f64, f64)| {
            let nearer = b.0 == a.0 && b.1.abs() < a.1.abs();
            if b.0 > a.0 || nearer { b } else { a }
        };
        rated.reduce(better).map_or(0.0, |(_, x)| x)
    }

    /// The share of `gap` that a face at `x` keeps, 1 at most.
    fn kept(&self, x: f64, gap: f64) -> f64 {
        (self.nearest(&self.ends, x) / gap).min(self.nearest(&self.corners, x) / (CORNER_SHARE * gap)).min(1.0)
    }

    fn nearest(&self, marks: &[f64], x: f64) -> f64 {
        let x = if x < 0.0 { x + self.length } else { x };
        let after = marks.partition_point(|mark| *mark < x);
        let ahead = marks.get(after).copied().unwrap_or(marks[0] + self.length) - x;
        let behind = x - if after > 0 { marks[after - 1] } else { marks[marks.len() - 1] - self.length };
        ahead.min(behind)
    }
}
