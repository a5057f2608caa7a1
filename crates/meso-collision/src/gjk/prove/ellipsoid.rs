//! An ellipsoid around a body and one inside it, both about the frame's origin: most pairs need no more.
//!
//! With S = R diag(a2, b2, c2) R^T the ellipsoid's support along n is sqrt(n . S n). For two of them, a displacement
//! x of the centres and n = (S_a + S_b)^-1 x, the point S_a n from a's centre is the one both come nearest to.

use crate::geometry::Facet;
use crate::math::{Mat3, Vec3};

/// Room for the rounding of everything this file computes: some hundred operations on well-conditioned matrices.
pub(crate) const SLACK: f64 = 1e-9;

/// Lengths that single precision holds.
const SINGLE: std::ops::Range<f64> = 1e-37..1e37;

/// The header of a body.
///
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct Ellipsoids {
    /// In f32: six entries of S of the ellipsoid around the body, mm2: xx, yy, zz, xy, xz, yz, enlarged by the
    /// rounding; the inner ellipsoid over the outer one, squared, 0 where none is known; and the inradius, rounded
    /// down, NaN where the frame's origin is not known to lie inside.
    pub(crate) row: [f32; 8],
    pub(crate) circumradius: f64,
}

/// The verdict of the spheres or ellipsoids of a pair.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Known {
    /// The bodies are apart by more than the gap along this direction, not of unit length.
    Apart(Vec3),
    /// The bodies share a point.
    Overlap,
    /// Nobody knows; this is a good direction to start from.
    Nothing(Vec3),
}

impl Ellipsoids {
    /// Knows nothing: NaN fails every comparison below.
    pub(crate) fn unknown() -> Self {
        let mut row = [f32::NAN; 8];
        row[6] = 0.0;
        Self { row, circumradius: f64::INFINITY }
    }

    /// Second moments of the points about the origin, mm2.
    pub(crate) fn moments(points: &[Vec3]) -> Mat3 {
        points.iter().map(|p| p * p.transpose()).sum()
    }

    /// The ellipsoid of the shape `s`, enlarged to hold all points; the sphere alone where `s` is too flat or too
    /// extreme.
    pub(crate) fn around(points: &[Vec3], s: &Mat3) -> Self {
        let radius2 = points.iter().map(Vec3::norm_squared).fold(0.0, f64::max);
        let circumradius = radius2.sqrt() * (1.0 + SLACK);
        let unknown = Self { circumradius, ..Self::unknown() };
        // Within these limits neither f32 nor the adjugates below lose anything that SLACK does not cover.
        if !(1e-12..1e12).contains(&radius2) {
            return unknown;
        }
        let s = s + Mat3::identity() * (s.trace() * 1e-4);
        let Some(inverse) = s.try_inverse() else { return unknown };
        let factor = points.iter().map(|p| p.dot(&(inverse * p))).fold(0.0, f64::max) * (1.0 + 1e-6);
        let s = s * factor;
        // f32 moves each entry by 2^-24 of the largest; the diagonal makes up for it, so that the ellipsoid only grows.
        let grown = s + Mat3::identity() * (s.amax() * 1e-6);
        let [xx, yy, zz, xy, xz, yz] =
            [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|(i, j)| grown[(i, j)] as f32);
        Self { row: [xx, yy, zz, xy, xz, yz, 0.0, f32::NAN], ..unknown }
    }

    #[inline(always)]
    fn outer(&self) -> [f32; 6] {
        let [xx, yy, zz, xy, xz, yz, ..] = self.row;
        [xx, yy, zz, xy, xz, yz]
    }

    #[inline(always)]
    fn inner_squared(&self) -> f32 {
        self.row[6]
    }

    /// Radius of a ball about the frame's origin inside the body, mm; NaN where none is known.
    #[inline(always)]
    pub(crate) fn inradius(&self) -> f32 {
        self.row[7]
    }

    /// S of the outer ellipsoid.
    pub(crate) fn matrix(&self) -> Mat3 {
        let [xx, yy, zz, xy, xz, yz] = self.outer().map(f64::from);
        Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }

    /// The point of the inner ellipsoid farthest along the axis.
    #[inline(always)]
    pub(crate) fn inner_support(&self, axis: &Vec3) -> Vec3 {
        let along = times(&self.outer(), axis);
        along * (f64::from(self.inner_squared()) / axis.dot(&along)).sqrt()
    }

    /// Finds how far the outer ellipsoid must shrink to lie inside every face plane of the solid whose facets these
    /// are.
    pub(crate) fn measure_inside(&mut self, facets: impl IntoIterator<Item = Facet>) {
        let (s, size) = (self.matrix(), self.circumradius);
        let (mut inner_squared, mut inradius) = (f64::INFINITY, f64::INFINITY);
        for facet in facets {
            let (normal, offset) = (facet.plane.normal, facet.certain_offset(size));
            if offset.is_nan() || offset <= 0.0 {
                return;
            }
            inradius = inradius.min(offset);
            inner_squared = inner_squared.min(offset * offset / normal.dot(&(s * normal)));
        }
        // Nothing is known of a body whose radius single precision would round to infinity or to nothing.
        let inradius = if SINGLE.contains(&inradius) { inradius } else { f64::NAN };
        self.row[7] = (inradius * (1.0 - 1e-6)) as f32;
        // Below this the rounding of the axis could count; such flat bodies gain little from an inner ellipsoid.
        self.row[6] =
            if (1e-4..f64::INFINITY).contains(&inner_squared) { (inner_squared * (1.0 - 1e-6)) as f32 } else { 0.0 };
    }

    /// The verdict of the spheres of bodies whose centres lie `x` apart; `None` where they leave it open.
    #[inline(always)]
    pub(crate) fn compare_spheres(&self, other: &Self, x: &Vec3, gap: f64) -> Option<Known> {
        let distance2 = x.norm_squared();
        let reach = self.circumradius + other.circumradius + gap;
        if distance2 > reach * reach * (1.0 + SLACK) {
            return Some(Known::Apart(*x));
        }
        let inside = f64::from(self.inradius()) + f64::from(other.inradius());
        (distance2 < inside * inside * (1.0 - SLACK)).then_some(Known::Overlap)
    }

    /// The verdict of the ellipsoids: apart by more than `gap` (at least 0), overlapping, or neither.
    #[inline(always)]
    pub(crate) fn compare_axis(&self, other: &Self, x: &Vec3, gap: f64) -> Known {
        let (n, determinant) = self.axis(other, x);
        let along = n.dot(x);
        // Both from their matrices: along - q_a would lose a small body beside a large one.
        let (q_a, q_b) = (n.dot(&times(&self.outer(), &n)), n.dot(&times(&other.outer(), &n)));
        if apart(along, q_a, q_b, gap, &n) {
            return Known::Apart(n);
        }
        // The axis is n / determinant: the inner ellipsoids' common point is found without dividing.
        let square = determinant * determinant;
        let common = q_a < f64::from(self.inner_squared()) * square && q_b < f64::from(other.inner_squared()) * square;
        if common { Known::Overlap } else { Known::Nothing(if along > 0.0 { n } else { seldom(x) }) }
    }

    /// (S_a + S_b)^-1 x times the determinant, by the adjugate, and the determinant; NaN where nothing is known.
    #[inline(always)]
    fn axis(&self, other: &Self, x: &Vec3) -> (Vec3, f64) {
        let m: [f64; 6] = std::array::from_fn(|i| f64::from(self.row[i]) + f64::from(other.row[i]));
        let [xx, yy, zz, xy, xz, yz] = m;
        let adjugate = [
            yy * zz - yz * yz,
            xx * zz - xz * xz,
            xx * yy - xy * xy,
            xz * yz - xy * zz,
            xy * yz - xz * yy,
            xy * xz - yz * xx,
        ];
        let determinant = xx * adjugate[0] + xy * adjugate[3] + xz * adjugate[4];
        (symmetric_times(&adjugate, x), determinant)
    }
}

impl Facet {
    /// How far the facet's plane is from the frame's origin for certain, mm, of a body within `radius` mm of it.
    ///
    /// Its normal is known to the rounding of its cross products over its area: of slivers little is certain.
    pub(crate) fn certain_offset(&self, radius: f64) -> f64 {
        let share = 64.0 * f64::EPSILON * self.corners as f64 * radius * radius / self.area;
        self.plane.offset - radius * (share + SLACK)
    }
}

/// Returns the vector, by a call: else the compiler chooses by masks, whose making the search would wait for.
#[cold]
#[inline(never)]
fn seldom(x: &Vec3) -> Vec3 {
    *x
}

/// along > sqrt(q_a) + sqrt(q_b) + gap |n|, certainly; without roots where there is no gap.
#[inline(always)]
fn apart(along: f64, q_a: f64, q_b: f64, gap: f64, n: &Vec3) -> bool {
    if gap != 0.0 {
        return along > (q_a.sqrt() + q_b.sqrt() + gap * n.norm()) * (1.0 + SLACK);
    }
    let rest = along * along * (1.0 - SLACK) - (q_a + q_b);
    along > 0.0 && rest > 0.0 && rest * rest > 4.0 * q_a * q_b * (1.0 + SLACK)
}

#[inline(always)]
fn times(s: &[f32; 6], n: &Vec3) -> Vec3 {
    symmetric_times(&s.map(f64::from), n)
}

#[inline(always)]
fn symmetric_times(&[xx, yy, zz, xy, xz, yz]: &[f64; 6], v: &Vec3) -> Vec3 {
    Vec3::new(xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z)
}
