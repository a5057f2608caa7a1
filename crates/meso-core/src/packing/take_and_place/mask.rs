//! Where no grain can have its centre any more: one look-up that refuses most attempts.
//!
//! Every voxel keeps an upper bound of how far any of its points is from the nearest placed grain. A candidate whose
//! inscribed ball reaches that far overlaps for certain, so a refusal here is one that the pair tests would have come to.

use crate::geometry::Plane;
use crate::math::{Aabb, Vec3};
use crate::wide::{Wide, widest};
use std::ops::RangeInclusive;

/// No more voxels than this, whatever the sizes: 64 MB.
const MOST_VOXELS: f64 = 64.0e6;
/// Voxels of a row that are worked on together.
const LANES: usize = 8;
/// Rounding of the f32 arithmetic below, as a share of the lengths in it: ten times what a dozen operations lose.
const ROUNDING: f64 = 1e-5;

/// Upper bounds of the distance to the nearest placed grain, by voxel.
pub(super) struct Mask {
    origin: Vec3,
    voxel: f64,
    counts: [usize; 3],
    /// Bounds as multiples of `step`, rounded up.
    bounds: Vec<u8>,
    /// mm.
    step: f64,
}

/// Stands for: no grain as near as could matter.
pub(super) const FAR: u8 = u8::MAX;

impl Mask {
    /// Over `domain` with voxels of about `voxel` mm, for candidates with an inner radius of up to `largest_inner` mm.
    pub(super) fn new(domain: &Aabb, voxel: f64, largest_inner: f64) -> Self {
        let size = domain.size();
        let voxel = voxel.max(libm::cbrt(size.product() / MOST_VOXELS));
        let counts = [0, 1, 2].map(|i| (size[i] / voxel).ceil().max(1.0) as usize);
        let bounds = vec![FAR; counts.iter().product()];
        Self { origin: domain.min, voxel, counts, bounds, step: largest_inner / f64::from(FAR - 1) }
    }

    /// What is kept of the voxel at `point`.
    #[inline]
    pub(super) fn bound(&self, point: &Vec3) -> u8 {
        let (from_origin, per_mm) = (point - self.origin, 1.0 / self.voxel);
        let along = |axis: usize| ((from_origin[axis] * per_mm) as usize).min(self.counts[axis] - 1);
        self.bounds[(along(2) * self.counts[1] + along(1)) * self.counts[0] + along(0)]
    }

    /// True when a grain that holds the ball of `inner_radius` mm about a point of this bound overlaps one placed.
    #[inline]
    pub(super) fn forbids(&self, bound: u8, inner_radius: f64) -> bool {
        bound != FAR && f64::from(bound) * self.step < inner_radius
    }

    /// No point of a voxel is farther from its middle, mm.
    fn half_diagonal(&self) -> f64 {
        0.5 * 3f64.sqrt() * self.voxel
    }

    /// The voxels along `axis` from `low` to `high` mm, as far as there are any.
    fn voxels(&self, axis: usize, low: f64, high: f64) -> RangeInclusive<usize> {
        let at = |x: f64| (((x - self.origin[axis]) / self.voxel) as usize).min(self.counts[axis] - 1);
        at(low)..=at(high)
    }

    /// Takes note of a body at `centre`, for candidates with an inner radius of up to `reach` mm. About its own centre it
    /// has this box, circumradius (mm) and face planes.
    pub(super) fn insert(&mut self, (aabb, circumradius): (&Aabb, f64), planes: &[Plane], centre: &Vec3, reach: f64) {
        // A voxel whose middle is farther away than this has a bound beyond `reach`.
        let reach = reach - self.half_diagonal();
        let near = aabb.grown(reach);
        let Some(mut gauge) = Gauge::new(planes, near.size().norm()) else { return };
        let slack = (self.half_diagonal() * (1.0 + ROUNDING) + gauge.doubt) as f32;
        let ball = (circumradius + reach).max(0.0) * (1.0 + ROUNDING);
        let (low, high) = (near.min + centre, near.max + centre);
        for k in self.voxels(2, low.z, high.z) {
            for j in self.voxels(1, low.y, high.y) {
                let middle = |n: usize, axis: usize| self.origin[axis] + (n as f64 + 0.5) * self.voxel - centre[axis];
                let (y, z) = (middle(j, 1), middle(k, 2));
                // Nor is one of the row farther along than where it leaves the ball.
                let along2 = ball * ball - y * y - z * z;
                if along2 < 0.0 {
                    continue;
                }
                let along = along2.sqrt() + self.voxel;
                let row = self.voxels(0, low.x.max(centre.x - along), high.x.min(centre.x + along));
                let (start, count) = (*row.start(), row.count());
                let first = [middle(start, 0), y, z].map(|x| x as f32);
                let start = (k * self.counts[1] + j) * self.counts[0] + start;
                let (voxel, step) = (self.voxel as f32, self.step as f32);
                let bounds = &mut self.bounds[start..start + count];
                widest(Lower { gauge: &mut gauge, first, voxel, slack, step, bounds });
            }
        }
    }
}

/// The faces of a body around its centre, each as normal over offset: the body is where all of these are at most 1.
struct Gauge {
    /// x, y and z of all faces, each padded with zeros to a multiple of `LANES`, which changes no maximum.
    faces: [Vec<f32>; 3],
    /// What of each a row of points has in common.
    beside: Vec<f32>,
    inner_radius: f32,
    /// What rounding may take off a distance, mm.
    doubt: f64,
}

/// Lowers the bounds of a row of voxels to what the distances of their middles allow, on wide registers.
struct Lower<'a> {
    gauge: &'a mut Gauge,
    /// Middle of the first voxel, from the body's centre, and from one voxel to the next, mm.
    first: [f32; 3],
    voxel: f32,
    /// What a point of a voxel may have beyond its middle, mm.
    slack: f32,
    step: f32,
    bounds: &'a mut [u8],
}

impl Wide for Lower<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (per_step, [x0, y, z]) = (1.0 / self.step, self.first);
        self.gauge.go_to_row(y, z);
        for (number, bounds) in self.bounds.chunks_mut(LANES).enumerate() {
            let mut xs = [0.0_f32; LANES];
            for (lane, x) in xs.iter_mut().enumerate() {
                *x = x0 + (number * LANES + lane) as f32 * self.voxel;
            }
            let distances = self.gauge.distances(&xs, y * y + z * z);
            let mut steps = [0_u8; LANES];
            for (steps, distance) in steps.iter_mut().zip(&distances) {
                // Rounded up; what single precision takes off a few hundred steps is far less than the doubt in the slack.
                let whole = ((distance + self.slack) * per_step).clamp(-1.0, f32::from(FAR - 1));
                *steps = (whole + 1.0) as i32 as u8;
            }
            for (bound, steps) in bounds.iter_mut().zip(&steps) {
                *bound = (*bound).min(*steps);
            }
        }
    }
}

impl Gauge {
    /// `None` where the centre is not clearly inside; `size` is the longest length that will be asked about, mm.
    fn new(planes: &[Plane], size: f64) -> Option<Self> {
        let inner_radius = planes.iter().map(|plane| plane.offset).fold(f64::INFINITY, f64::min);
        if inner_radius <= ROUNDING * size {
            return None;
        }
        let mut faces = [0; 3].map(|_| vec![0.0; planes.len().next_multiple_of(LANES)]);
        for (f, plane) in planes.iter().enumerate() {
            for (axis, along) in faces.iter_mut().enumerate() {
                along[f] = (plane.normal[axis] / plane.offset) as f32;
            }
        }
        let doubt = ROUNDING * size * (1.0 + size / inner_radius);
        let beside = faces[0].clone();
        Some(Self { faces, beside, inner_radius: inner_radius as f32, doubt })
    }

    #[inline(always)]
    fn go_to_row(&mut self, y: f32, z: f32) {
        let [_, ny, nz] = &self.faces;
        for ((beside, ny), nz) in self.beside.iter_mut().zip(ny).zip(nz) {
            *beside = ny * y + nz * z;
        }
    }

    /// Upper bounds of the distances to the body from the points of the row at these x, `beside` the square of its distance
    /// from the x axis; inside of the body negative.
    ///
    /// With g(x) the factor by which the body must grow to reach x: outside, x / g is a point of the body; inside, every
    /// face is at least (1 - g) times the inner radius away.
    #[inline(always)]
    fn distances(&self, xs: &[f32; LANES], beside: f32) -> [f32; LANES] {
        let mut grow = [0.0_f32; LANES];
        for (nx, beside) in self.faces[0].iter().zip(&self.beside) {
            for (grow, x) in grow.iter_mut().zip(xs) {
                let here = nx * x + beside;
                *grow = if here > *grow { here } else { *grow };
            }
        }
        let mut distances = [0.0_f32; LANES];
        for ((distance, &x), &grow) in distances.iter_mut().zip(xs).zip(&grow) {
            let length = (x * x + beside).sqrt();
            *distance = if grow > 1.0 { length * (1.0 - 1.0 / grow) } else { (grow - 1.0) * self.inner_radius };
        }
        distances
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aggregate::random::{Purpose, Stream};
    use crate::geometry::convex_hull;
    use crate::gjk;

    #[test]
    fn what_the_mask_forbids_overlaps() {
        let mut stream = Stream::new(5, Purpose::Sample, 0, 0);
        let domain = Aabb { min: Vec3::zeros(), max: Vec3::repeat(26.0) };
        let mut mask = Mask::new(&domain, 1.0, 3.0);
        let points: Vec<Vec3> = (0..20).map(|_| stream.direction().component_mul(&Vec3::new(9.0, 7.0, 4.0))).collect();
        let (body, centre) = (convex_hull(&points).expect("solid"), Vec3::repeat(13.0));
        let planes: Vec<Plane> = body.planes().collect();
        let circumradius = body.vertices().iter().map(Vec3::norm).fold(0.0, f64::max);
        mask.insert((&body.aabb(), circumradius), &planes, &centre, 3.0);
        let cross = |r: f64| [Vec3::x(), Vec3::y(), Vec3::z()].map(|axis| [axis * r, -axis * r]).concat();
        let (mut forbidden, mut overlapping) = (0, 0);
        for _ in 0..4000 {
            let (point, radius) = (stream.point(&domain.min, &domain.max), stream.uniform(0.5, 3.0));
            // The octahedron holds the ball of its corners' distance over the root of 3.
            let other: Vec<Vec3> = cross(radius * 3f64.sqrt()).iter().map(|v| v + point - centre).collect();
            let overlaps = gjk::intersects(body.vertices(), &other).expect("finite");
            let forbids = mask.forbids(mask.bound(&point), radius);
            assert!(overlaps || !forbids, "{point} with {radius}");
            (forbidden, overlapping) = (forbidden + u32::from(forbids), overlapping + u32::from(overlaps));
        }
        assert!(forbidden > 100 && 3 * forbidden > overlapping, "{forbidden} of {overlapping}");
    }
}
