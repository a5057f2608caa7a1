//! Where no grain can have its centre any more: one look-up that refuses most attempts.
//!
//! Every voxel keeps an upper bound of how far any of its points is from the nearest placed grain. A candidate whose
//! inscribed ball reaches that far overlaps for certain, so a refusal here is one that the pair tests would have come to.

use crate::geometry::{Plane, Polyhedron};
use crate::math::{Aabb, Vec3};
use crate::wide::{Wide, widest};

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
const FAR: u8 = u8::MAX;

impl Mask {
    /// Over `domain` with voxels of about `voxel` mm, for candidates with an inner radius of up to `largest_inner` mm.
    pub(super) fn new(domain: &Aabb, voxel: f64, largest_inner: f64) -> Self {
        let size = domain.size();
        let voxel = voxel.max(libm::cbrt(size.product() / MOST_VOXELS));
        let counts = [0, 1, 2].map(|i| (size[i] / voxel).ceil().max(1.0) as usize);
        let bounds = vec![FAR; counts.iter().product()];
        Self { origin: domain.min, voxel, counts, bounds, step: largest_inner / f64::from(FAR - 1) }
    }

    /// True when a grain at `point` that holds the ball of `inner_radius` mm about it overlaps one placed.
    #[inline]
    pub(super) fn forbids(&self, point: &Vec3, inner_radius: f64) -> bool {
        let [i, j, k] = self.voxel_of(point);
        let bound = self.bounds[(k * self.counts[1] + j) * self.counts[0] + i];
        bound != FAR && f64::from(bound) * self.step < inner_radius
    }

    /// No point of a voxel is farther from its middle, mm.
    fn half_diagonal(&self) -> f64 {
        0.5 * 3f64.sqrt() * self.voxel
    }

    fn voxel_of(&self, point: &Vec3) -> [usize; 3] {
        [0, 1, 2].map(|i| (((point[i] - self.origin[i]) / self.voxel) as usize).min(self.counts[i] - 1))
    }

    /// Takes note of `body`, about its own centre, at `centre`, for candidates with an inner radius of up to `reach` mm.
    pub(super) fn insert(&mut self, body: &Polyhedron, centre: &Vec3, reach: f64) {
        // A voxel whose middle is farther away than this has a bound beyond `reach`.
        let near = body.aabb().moved(centre).grown(reach - self.half_diagonal());
        let (low, high) = (self.voxel_of(&near.min), self.voxel_of(&near.max));
        let Some(gauge) = Gauge::new(body, near.size().norm()) else { return };
        for k in low[2]..=high[2] {
            for j in low[1]..=high[1] {
                for i in (low[0]..=high[0]).step_by(LANES) {
                    let first = self.origin + Vec3::new(i as f64, j as f64, k as f64).add_scalar(0.5) * self.voxel;
                    let distances = widest(Distances { gauge: &gauge, first: &(first - centre), step: self.voxel });
                    self.lower([i, j, k], &distances, LANES.min(high[0] + 1 - i), gauge.doubt);
                }
            }
        }
    }

    /// Lowers the bounds of `count` voxels from `start` on to what the distances of their middles allow.
    fn lower(&mut self, [i, j, k]: [usize; 3], distances: &[f32; LANES], count: usize, doubt: f64) {
        let half_diagonal = self.half_diagonal() * (1.0 + ROUNDING) + doubt;
        let start = (k * self.counts[1] + j) * self.counts[0] + i;
        for (bound, &distance) in self.bounds[start..start + count].iter_mut().zip(distances) {
            let steps = ((f64::from(distance) + half_diagonal) / self.step).ceil();
            *bound = (*bound).min(steps.clamp(0.0, f64::from(FAR)) as u8);
        }
    }
}

/// The faces of a body around its centre, each as normal over offset: the body is where all of these are at most 1.
struct Gauge {
    faces: Vec<[f32; 3]>,
    inner_radius: f32,
    /// What rounding may take off a distance, mm.
    doubt: f64,
}

/// [`Gauge::distances`] on wide registers.
struct Distances<'a> {
    gauge: &'a Gauge,
    first: &'a Vec3,
    step: f64,
}

impl Wide for Distances<'_> {
    type Output = [f32; LANES];

    #[inline(always)]
    fn run(self) -> [f32; LANES] {
        self.gauge.distances(self.first, self.step)
    }
}

impl Gauge {
    /// `None` where the centre is not clearly inside; `size` is the longest length that will be asked about, mm.
    fn new(body: &Polyhedron, size: f64) -> Option<Self> {
        let planes: Vec<Plane> = body.planes().collect();
        let inner_radius = planes.iter().map(|plane| plane.offset).fold(f64::INFINITY, f64::min);
        if inner_radius <= ROUNDING * size {
            return None;
        }
        let face = |plane: &Plane| (plane.normal / plane.offset).map(|x| x as f32).into();
        let doubt = ROUNDING * size * (1.0 + size / inner_radius);
        Some(Self { faces: planes.iter().map(face).collect(), inner_radius: inner_radius as f32, doubt })
    }

    /// Upper bounds of the distances to the body from the points `first`, and on along x every `step` mm; inside of it
    /// negative.
    ///
    /// With g(x) the factor by which the body must grow to reach x: outside, x / g is a point of the body; inside, every
    /// face is at least (1 - g) times the inner radius away.
    #[inline(always)]
    fn distances(&self, first: &Vec3, step: f64) -> [f32; LANES] {
        let [x0, y, z] = [first.x as f32, first.y as f32, first.z as f32];
        let xs: [f32; LANES] = std::array::from_fn(|i| x0 + i as f32 * step as f32);
        let mut grow = [0.0_f32; LANES];
        for [nx, ny, nz] in &self.faces {
            let beside = ny * y + nz * z;
            for (grow, x) in grow.iter_mut().zip(&xs) {
                let here = nx * x + beside;
                *grow = if here > *grow { here } else { *grow };
            }
        }
        std::array::from_fn(|i| {
            let length = (xs[i] * xs[i] + (y * y + z * z)).sqrt();
            if grow[i] > 1.0 { length * (1.0 - 1.0 / grow[i]) } else { (grow[i] - 1.0) * self.inner_radius }
        })
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
        mask.insert(&body, &centre, 3.0);
        let cross = |r: f64| [Vec3::x(), Vec3::y(), Vec3::z()].map(|axis| [axis * r, -axis * r]).concat();
        let (mut forbidden, mut overlapping) = (0, 0);
        for _ in 0..4000 {
            let (point, radius) = (stream.point(&domain.min, &domain.max), stream.uniform(0.5, 3.0));
            // The octahedron holds the ball of its corners' distance over the root of 3.
            let other: Vec<Vec3> = cross(radius * 3f64.sqrt()).iter().map(|v| v + point - centre).collect();
            let overlaps = gjk::intersects(body.vertices(), &other).expect("finite");
            let forbids = mask.forbids(&point, radius);
            assert!(overlaps || !forbids, "{point} with {radius}");
            (forbidden, overlapping) = (forbidden + u32::from(forbids), overlapping + u32::from(overlaps));
        }
        assert!(forbidden > 100 && 3 * forbidden > overlapping, "{forbidden} of {overlapping}");
    }
}
