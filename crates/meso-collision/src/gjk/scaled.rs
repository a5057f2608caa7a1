//! A pair of plain points, brought near the origin and to a size near 1, where searches in floating point work.

use crate::gjk::body::Body;
use crate::gjk::method::Algorithm;
use crate::gjk::pair::{Found, Originals, Pair};
use crate::gjk::prove::exact::{Decision, ExactPair};
use crate::gjk::search::classical::{Classical, Until};
use crate::gjk::search::nearest::SubAlgorithm;
use crate::gjk::search::simplex::Corners;
use crate::math::Vec3;
use crate::simd::dispatch;

/// Magnitudes of coordinates, other than 0, whose products neither over- nor underflow. Beyond, exact arithmetic
/// answers.
const ORDINARY: std::ops::RangeInclusive<f64> = 1e-60..=1e60;

/// True where no product of these coordinates over- or underflows.
pub(crate) fn is_ordinary(points: &[Vec3]) -> bool {
    points.iter().all(|point| point.iter().all(|&value| value == 0.0 || ORDINARY.contains(&value.abs())))
}

/// A pair near the origin and of a size near 1: each coordinate rounded once, by the shift; the scale is a power of
/// two.
pub(crate) struct Scaled<'p> {
    pub(crate) a: Body,
    pub(crate) b: Body,
    pub(crate) originals: Originals<'p>,
    /// From the mean of A's points to the mean of B's.
    towards_b: Vec3,
    /// Whether searches in floating point can tell anything.
    ordinary: bool,
}

impl<'p> Scaled<'p> {
    pub(crate) fn new(a: &'p [Vec3], b: &'p [Vec3]) -> Self {
        Self::beside(a, b, &Vec3::zeros())
    }

    /// The pair where not only itself but also this vector is to be of a size near 1.
    pub(crate) fn beside(a: &'p [Vec3], b: &'p [Vec3], other: &Vec3) -> Self {
        let origin = a[0];
        let size = a.iter().chain(b).map(|p| (p - origin).amax()).fold(other.amax(), f64::max);
        let scale = power_of_two_near_inverse(size);
        let local = |p: &Vec3| (p - origin) * scale;
        let mean = |points: &[Vec3]| points.iter().map(local).sum::<Vec3>() / points.len() as f64;
        Self {
            towards_b: mean(b) - mean(a),
            a: Body::bare(a.iter().map(local)),
            b: Body::bare(b.iter().map(local)),
            originals: Originals { a, b, x: Vec3::zeros(), scale },
            ordinary: is_ordinary(a) && is_ordinary(b),
        }
    }

    pub(crate) fn pair(&self) -> Pair<'_> {
        // Scaled coordinates are at most 1, and two such points at most 2 sqrt(3).
        Pair { a: &self.a, b: &self.b, x: Vec3::zeros(), reach: 4.0, originals: Some(&self.originals) }
    }

    /// The first direction of a search.
    pub(crate) fn start(&self) -> Vec3 {
        if self.towards_b == Vec3::zeros() { Vec3::x() } else { self.towards_b }
    }

    pub(crate) fn search(&self, method: Algorithm) -> Found {
        if self.ordinary { method.search(self.pair(), self.start()) } else { Found::Undecided(Corners::NONE) }
    }

    /// The distance search.
    pub(crate) fn classical(&self, until: Until) -> Found {
        if !self.ordinary {
            return Found::Undecided(Corners::NONE);
        }
        dispatch(Classical { pair: self.pair(), v: self.start(), sub_algorithm: SubAlgorithm::SignedVolumes, until })
    }

    pub(crate) fn overlap(&self, method: Algorithm) -> bool {
        match self.search(method) {
            Found::Apart(_) => false,
            Found::Overlap(_) => true,
            Found::Undecided(corners) => matches!(self.exact().decide(corners.pairs()), Decision::Overlap(_)),
        }
    }

    pub(crate) fn distance(&self) -> f64 {
        match self.classical(Until::Nearest) {
            Found::Overlap(_) => 0.0,
            Found::Apart(_) => unreachable!("a search for the nearest point does not stop at a separation"),
            Found::Undecided(corners) => self.exact().squared_distance(corners.pairs()).0.sqrt(),
        }
    }

    pub(crate) fn closest_points(&self) -> [Vec3; 2] {
        let (Found::Overlap(corners) | Found::Undecided(corners)) = self.classical(Until::Nearest) else {
            unreachable!("a search for the nearest point does not stop at a separation")
        };
        self.exact().closest_points(corners.pairs())
    }

    pub(crate) fn distance_exceeds(&self, gap: f64) -> bool {
        // The scale is a power of two: nothing is rounded, but a gap must not become 0.
        let least = if gap > 0.0 { f64::MIN_POSITIVE } else { 0.0 };
        let scaled = (gap * self.originals.scale).max(least);
        match self.classical(Until::Apart(scaled)) {
            Found::Apart(_) => true,
            Found::Overlap(_) => false,
            Found::Undecided(corners) => self.exact().squared_distance(corners.pairs()).0.exceeds(gap),
        }
    }

    pub(crate) fn exact(&self) -> ExactPair<'p, [Vec3], [Vec3]> {
        ExactPair::new(self.originals.a, self.originals.b, &Vec3::zeros())
    }
}

/// 2^k with size 2^k in 1/2..=1; 1 for sizes that no search is made of.
fn power_of_two_near_inverse(size: f64) -> f64 {
    if !(f64::MIN_POSITIVE..=1e300).contains(&size) {
        return 1.0;
    }
    let exponent = (size.to_bits() >> 52) as i64 - 1022;
    f64::from_bits(((1023 - exponent) as u64) << 52)
}

/// The exponent of the power of two that brings the largest coordinate to 1..2, where that is needed for products not
/// to over- or underflow; else 0.
pub(crate) fn power_to_one<'p>(points: impl IntoIterator<Item = &'p Vec3>) -> i32 {
    let (mut largest, mut ordinary) = (0.0_f64, true);
    for point in points {
        largest = largest.max(point.amax());
        ordinary &= is_ordinary(std::slice::from_ref(point));
    }
    if ordinary { 0 } else { -libm::ilogb(largest) }
}

/// p 2^exponent; underflow is lost.
pub(crate) fn times_power(p: &Vec3, exponent: i32) -> Vec3 {
    p.map(|x| libm::scalbn(x, exponent))
}
