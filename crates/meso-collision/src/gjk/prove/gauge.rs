//! A body's faces in single precision: for most overlapping pairs a point of one body inside the other proves the
//! overlap.

use crate::geometry::{CompactPolyhedron, Facet};
use crate::gjk::body::{Body, Bounds, GROUP};
use crate::gjk::prove::ellipsoid::Ellipsoids;
use crate::lanes::{LANES, least};
use crate::math::Vec3;
use crate::simd::{Wide, widest};

/// Rounding of the single-precision arithmetic on them, as a share of the lengths in it: ten times the loss of a dozen
/// operations.
const ROUNDING: f64 = 1e-5;

/// The faces of a body around its frame's origin, each as normal over offset: the body is where all of these are at
/// most 1.
#[derive(Clone, Debug)]
struct FaceGauge {
    /// x, then y, then z of all faces, each padded with zeros to a multiple of [`LANES`], which changes no maximum.
    faces: Box<[f32]>,
    inner_radius: f64,
}

impl FaceGauge {
    /// Every face a little nearer than it is, by the error of its plane; `None` where the origin is not clearly inside
    /// of all. `radius` is that of the ball about the origin that holds the body, mm.
    fn new(facets: &[Facet], radius: f64) -> Option<Self> {
        let padded = facets.len().next_multiple_of(LANES);
        let (mut faces, mut inner_radius) = (vec![0.0; 3 * padded].into_boxed_slice(), f64::INFINITY);
        for (f, facet) in facets.iter().enumerate() {
            let offset = facet.certain_offset(radius);
            if offset.is_nan() || offset <= ROUNDING * radius {
                return None;
            }
            inner_radius = inner_radius.min(offset);
            let share = facet.plane.normal * (1.0 / offset);
            for axis in 0..3 {
                faces[axis * padded + f] = share[axis] as f32;
            }
        }
        Some(Self { faces, inner_radius })
    }

    /// True when all faces are below `limit` at the point.
    #[inline(always)]
    fn holds(&self, [x, y, z]: [f32; 3], limit: f32) -> bool {
        let padded = self.faces.len() / 3;
        let (nx, rest) = self.faces.split_at(padded);
        let (ny, nz) = rest.split_at(padded);
        // Negated, since `lanes` finds the least of eight.
        let mut low = [0.0_f32; LANES];
        for ((nx, ny), nz) in nx.chunks_exact(LANES).zip(ny.chunks_exact(LANES)).zip(nz.chunks_exact(LANES)) {
            for lane in 0..LANES {
                let below = -(nx[lane] * x + ny[lane] * y + nz[lane] * z);
                low[lane] = if below < low[lane] { below } else { low[lane] };
            }
        }
        // NaN fails every comparison, so it is rejected here.
        least(&low) > -limit && (x + y + z).is_finite()
    }
}

/// A body and its faces.
pub struct Solid {
    body: Body,
    gauge: Option<FaceGauge>,
}

impl Solid {
    /// A solid of these vertices (mm) and facets; the origin of the frame should lie inside, near the middle.
    ///
    /// # Panics
    /// Without vertices.
    ///
    /// ```
    /// use meso_collision::{geometry::convex_hull, gjk::Solid, math::Vec3};
    /// let hull = convex_hull(&[Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()])?;
    /// let solid = Solid::new(hull.vertices(), &hull.facets());
    /// # Ok::<(), meso_collision::geometry::HullError>(())
    /// ```
    pub fn new(vertices: &[Vec3], facets: &[Facet]) -> Self {
        let body = Body::new(vertices).with_facets(facets.iter().copied());
        Self { gauge: FaceGauge::new(facets, body.circumradius()), body }
    }

    /// In the form that pairs are asked about in.
    ///
    /// ```
    /// use meso_collision::{gjk::Solid, math::Vec3};
    /// assert!(Solid::new(&[Vec3::x()], &[]).body().circumradius() >= 1.0);
    /// ```
    #[inline]
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// True only where a point of the other body is inside: of its inner ellipsoid the one that is farthest along
    /// `-axis`, or the vertex that is, or the middle of these. `b_from_a` is the displacement that brings the other's
    /// points into this frame.
    #[inline(always)]
    pub(crate) fn meets(&self, b: (&Bounds, &CompactPolyhedron), axis: &Vec3, b_from_a: &Vec3) -> bool {
        let Some(gauge) = &self.gauge else { return false };
        let (Bounds(bounds), shape) = b;
        let doubt = ROUNDING * (self.body.circumradius() + bounds.circumradius);
        let limit = (1.0 - doubt / gauge.inner_radius) as f32;
        widest(Meets { gauge, bounds, shape, axis, b_from_a, limit })
    }
}

/// The slots of a group, as bits of a height, and marks for those behind the last vertex: 1 from the middle on.
static SLOTS: [u32; GROUP] = {
    let mut slots = [0; GROUP];
    let mut slot = 0;
    while slot < GROUP {
        slots[slot] = slot as u32;
        slot += 1;
    }
    slots
};
static BEYOND: [f32; 2 * GROUP] = {
    let mut beyond = [0.0; 2 * GROUP];
    let mut slot = GROUP;
    while slot < 2 * GROUP {
        beyond[slot] = 1.0;
        slot += 1;
    }
    beyond
};

/// [`Solid::meets`] on wide registers.
struct Meets<'a> {
    gauge: &'a FaceGauge,
    bounds: &'a Ellipsoids,
    shape: &'a CompactPolyhedron,
    axis: &'a Vec3,
    b_from_a: &'a Vec3,
    limit: f32,
}

impl Wide for Meets<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let inner = self.b_from_a - self.bounds.inner_support(self.axis);
        let inner = [inner.x as f32, inner.y as f32, inner.z as f32];
        if self.gauge.holds(inner, self.limit) {
            return true;
        }
        let Some(lowest) = self.lowest() else { return false };
        let mut middle = inner;
        for (middle, lowest) in middle.iter_mut().zip(&lowest) {
            *middle = 0.5 * (*middle + lowest);
        }
        self.gauge.holds(middle, self.limit) || self.gauge.holds(lowest, self.limit)
    }
}

impl Meets<'_> {
    /// The other body's vertex farthest along `-axis`; `None` where it has many.
    #[inline(always)]
    fn lowest(&self) -> Option<[f32; 3]> {
        let Self { shape, axis, b_from_a, .. } = self;
        let len = shape.vertex_count();
        if len > GROUP {
            return None;
        }
        // Lanes behind the last vertex are read and not used.
        let (xs, ys, zs) = (shape.window::<GROUP>(0)?, shape.window::<GROUP>(1)?, shape.window::<GROUP>(2)?);
        let (nx, ny, nz) = (axis.x as f32, axis.y as f32, axis.z as f32);
        let beyond = &BEYOND[GROUP - len..2 * GROUP - len];
        let mut lowest = [f32::INFINITY; LANES];
        let along = xs.chunks_exact(LANES).zip(ys.chunks_exact(LANES)).zip(zs.chunks_exact(LANES));
        let of_slots = SLOTS.chunks_exact(LANES).zip(beyond.chunks_exact(LANES));
        for (((x, y), z), (slots, beyond)) in along.zip(of_slots).take(len.div_ceil(LANES)) {
            for lane in 0..LANES {
                let height = x[lane] * nx + y[lane] * ny + z[lane] * nz;
                let key = f32::from_bits(height.to_bits() & !(GROUP as u32 - 1) | slots[lane]);
                let key = if beyond[lane] > 0.0 { f32::INFINITY } else { key };
                lowest[lane] = if key < lowest[lane] { key } else { lowest[lane] };
            }
        }
        let low = least(&lowest);
        // Infinity would stand for the first one.
        let i = low.to_bits() as usize % GROUP;
        Some([xs[i] + b_from_a.x as f32, ys[i] + b_from_a.y as f32, zs[i] + b_from_a.z as f32])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Polyhedron, convex_hull};
    use crate::gjk;
    use crate::random::Stream;

    fn grain(stream: &mut Stream, points: usize) -> Polyhedron {
        let axes = Vec3::new(4.0, 3.0, stream.uniform(0.5, 3.0));
        let points: Vec<Vec3> = (0..points).map(|_| stream.direction().component_mul(&axes)).collect();
        let narrow = |v: &Vec3| v.map(|x| f64::from(x as f32));
        convex_hull(&points.iter().map(narrow).collect::<Vec<_>>()).expect("solid")
    }

    #[test]
    fn a_point_inside_all_faces_is_an_overlap_and_most_overlaps_have_one() {
        let mut stream = Stream::new(11);
        let (mut met, mut overlapping) = (0, 0);
        for case in 0..4000 {
            // Now and then more vertices than a group has.
            let (a, b) = (grain(&mut stream, 24), grain(&mut stream, if case % 9 == 0 { 48 } else { 26 }));
            let x = stream.direction() * stream.uniform(2.0, 7.0);
            let axis = stream.direction() + x;
            let (solid, bounds) = (Solid::new(a.vertices(), &a.facets()), Solid::new(b.vertices(), &b.facets()));
            let moved: Vec<Vec3> = b.vertices().iter().map(|v| v + x).collect();
            let overlaps = gjk::intersects(a.vertices(), &moved).expect("finite");
            let meets = solid.meets((&bounds.body().bounds(), &CompactPolyhedron::from(b)), &axis, &x);
            assert!(overlaps || !meets, "case {case}");
            (met, overlapping) = (met + u32::from(meets), overlapping + u32::from(overlaps));
        }
        assert!(overlapping > 1000 && 2 * met > overlapping, "{met} of {overlapping}");
    }

    #[test]
    fn faces_around_no_certain_inside_hold_nothing() {
        let corners = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let body = convex_hull(&corners).expect("solid");
        assert!(Solid::new(body.vertices(), &body.facets()).gauge.is_none());
    }

    #[test]
    fn no_number_is_inside_of_nothing() {
        let corners = [[1., 1., 1.], [1., -1., -1.], [-1., 1., -1.], [-1., -1., 1.]].map(Vec3::from);
        let body = convex_hull(&corners).expect("solid");
        let gauge = Solid::new(body.vertices(), &body.facets()).gauge.expect("about the origin");
        assert!(gauge.holds([0.1; 3], 0.99));
        assert!(!gauge.holds([f32::NAN, 0.1, 0.1], 0.99) && !gauge.holds([f32::INFINITY; 3], 0.99));
    }
}
