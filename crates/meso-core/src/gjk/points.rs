//! Questions about plain points: checked, brought to a common scale, searched, proved.

use super::body::Body;
use super::classical::{Classical, Until};
use super::enhanced::Enhanced;
use super::exact::{Decision, ExactPair};
use super::nearest::SubAlgorithm;
use super::pair::{Found, Originals, Pair};
use super::simplex::Corners;
use crate::math::Vec3;
use crate::simd::dispatch;
use std::str::FromStr;

/// Magnitudes of coordinates, other than 0, whose products neither over- nor underflow. Beyond, exact arithmetic answers.
const ORDINARY: std::ops::RangeInclusive<f64> = 1e-60..=1e60;

/// Which of the two bodies an error speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operand {
    /// The first.
    A,
    /// The second.
    B,
    /// The body of this index, of many.
    Many(usize),
}

impl std::fmt::Display for Operand {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::A => f.write_str("a"),
            Self::B => f.write_str("b"),
            Self::Many(index) => write!(f, "bodies[{index}]"),
        }
    }
}

/// Why a question has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GjkError {
    /// A body without points.
    #[error("{body} has no points; a body needs at least one")]
    Empty {
        /// Which body.
        body: Operand,
    },
    /// A coordinate is NaN or infinite.
    #[error("{body}: point {index} has the coordinate {value}; coordinates must be finite")]
    NotFinite {
        /// Which body.
        body: Operand,
        /// Row of the point.
        index: usize,
        /// The coordinate.
        value: f64,
    },
    /// No method has this name.
    #[error("method is {name:?}; accepted are \"enhanced\", \"classical\", \"signed-volumes\" and \"exact\"")]
    UnknownMethod {
        /// The name given.
        name: String,
    },
}

/// The search that proposes an answer. The answer does not depend on it: all are certified.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// The paper's boolean GJK, mended (Sec. 2.3.2).
    #[default]
    Enhanced,
    /// The distance GJK with Johnson's sub-algorithm (Sec. 2.3.1), stopped as soon as the answer is known.
    Classical,
    /// The distance GJK with signed volumes.
    SignedVolumes,
    /// Exact arithmetic from the first step.
    Exact,
}

impl Method {
    /// All methods, the default first.
    pub const ALL: [Self; 4] = [Self::Enhanced, Self::Classical, Self::SignedVolumes, Self::Exact];

    /// The name [`FromStr`] takes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Enhanced => "enhanced",
            Self::Classical => "classical",
            Self::SignedVolumes => "signed-volumes",
            Self::Exact => "exact",
        }
    }
}

impl Method {
    /// The search in floating point from direction `v`.
    pub(crate) fn search(self, pair: Pair<'_>, v: Vec3) -> Found {
        let until = Until::Apart(0.0);
        let classical = |sub_algorithm| dispatch(Classical { pair, v, sub_algorithm, until });
        match self {
            Self::Enhanced => dispatch(Enhanced { pair, v }),
            Self::Classical => classical(SubAlgorithm::Johnson),
            Self::SignedVolumes => classical(SubAlgorithm::SignedVolumes),
            Self::Exact => Found::Undecided(Corners::NONE),
        }
    }
}

impl FromStr for Method {
    type Err = GjkError;

    fn from_str(name: &str) -> Result<Self, GjkError> {
        let found = Self::ALL.into_iter().find(|method| method.name() == name);
        found.ok_or_else(|| GjkError::UnknownMethod { name: name.to_owned() })
    }
}

/// How an answer was proved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Proof {
    /// The witness, in doubles, with a margin that survives rounding.
    Margin,
    /// Exact arithmetic; the witness direction may be a rounded one.
    Exact,
}

/// An answer with its witness.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// The bodies share no point.
    Separated {
        /// Separates them: every point of A lies lower along it than every point of B.
        ///
        /// Under [`Proof::Exact`] the exact direction does; this one is it, rounded.
        direction: Vec3,
        /// How that is known.
        proof: Proof,
    },
    /// The bodies share at least one point.
    Intersecting {
        /// One to four pairs of points, of A and of B: the hull of their differences holds the origin.
        points: Vec<(usize, usize)>,
        /// How that is known.
        proof: Proof,
    },
}

impl Verdict {
    /// True for [`Verdict::Intersecting`].
    pub fn intersects(&self) -> bool {
        matches!(self, Self::Intersecting { .. })
    }
}

/// True when the hulls of `a` and `b` (points in mm, any unit) share a point.
///
/// # Errors
/// A body without points; a coordinate that is not finite.
///
/// ```
/// use meso_core::{gjk, math::Vec3};
/// let segment = [Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0)];
/// let point = [Vec3::new(0.1, 0.0, 0.0)];
/// assert!(gjk::intersects(&segment, &point)?);
/// assert!(!gjk::intersects(&segment, &[Vec3::new(0.1, 1e-30, 0.0)])?);
/// # Ok::<(), gjk::GjkError>(())
/// ```
pub fn intersects(a: &[Vec3], b: &[Vec3]) -> Result<bool, GjkError> {
    intersects_with(Method::default(), a, b)
}

/// [`intersects`] by a chosen search.
///
/// # Errors
/// As [`intersects`].
pub fn intersects_with(method: Method, a: &[Vec3], b: &[Vec3]) -> Result<bool, GjkError> {
    check(a, Operand::A)?;
    check(b, Operand::B)?;
    Ok(Scaled::new(a, b).overlap(method))
}

/// [`intersects_with`] of `a` against each of many bodies, in their order.
///
/// # Errors
/// As [`intersects`]; the first offending body is named.
pub fn intersects_many<'b>(
    method: Method,
    a: &[Vec3],
    bodies: impl IntoIterator<Item = &'b [Vec3]>,
) -> Result<Vec<bool>, GjkError> {
    check(a, Operand::A)?;
    let answer = |(i, b): (usize, &[Vec3])| check(b, Operand::Many(i)).map(|()| Scaled::new(a, b).overlap(method));
    bodies.into_iter().enumerate().map(answer).collect()
}

/// Whether the hulls of `a` and `b` share a point, with the proof.
///
/// # Errors
/// As [`intersects`].
///
/// ```
/// use meso_core::{gjk::{self, Verdict}, math::Vec3};
/// let a = [Vec3::new(0.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0)];
/// let Verdict::Separated { direction, .. } = gjk::verdict(&a, &[Vec3::new(2.0, 1.0, 0.0)])? else { panic!() };
/// assert!(direction.x > 0.0);
/// # Ok::<(), gjk::GjkError>(())
/// ```
pub fn verdict(a: &[Vec3], b: &[Vec3]) -> Result<Verdict, GjkError> {
    verdict_with(Method::default(), a, b)
}

/// [`verdict`] by a chosen search.
///
/// # Errors
/// As [`intersects`].
pub fn verdict_with(method: Method, a: &[Vec3], b: &[Vec3]) -> Result<Verdict, GjkError> {
    check(a, Operand::A)?;
    check(b, Operand::B)?;
    Ok(Scaled::new(a, b).verdict(method))
}

/// Distance of the hulls of `a` and `b`, in the unit of the points: 0 exactly when they share a point.
///
/// Correctly rounded up to one unit in the last place.
///
/// # Errors
/// As [`intersects`].
///
/// ```
/// use meso_core::{gjk, math::Vec3};
/// let a = [Vec3::new(0.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0)];
/// assert_eq!(gjk::distance(&a, &[Vec3::new(4.0, 4.0, 0.0)])?, 5.0);
/// # Ok::<(), gjk::GjkError>(())
/// ```
pub fn distance(a: &[Vec3], b: &[Vec3]) -> Result<f64, GjkError> {
    check(a, Operand::A)?;
    check(b, Operand::B)?;
    Ok(Scaled::new(a, b).distance())
}

/// True when the hulls of `a` and `b` are more than `gap` (finite, at least 0) apart: what [`distance`] says, mostly
/// without it.
///
/// # Errors
/// As [`intersects`].
pub(crate) fn farther(a: &[Vec3], b: &[Vec3], gap: f64) -> Result<bool, GjkError> {
    check(a, Operand::A)?;
    check(b, Operand::B)?;
    Ok(Scaled::new(a, b).farther(gap))
}

fn check(points: &[Vec3], body: Operand) -> Result<(), GjkError> {
    if points.is_empty() {
        return Err(GjkError::Empty { body });
    }
    for (index, point) in points.iter().enumerate() {
        if let Some(&value) = point.iter().find(|value| !value.is_finite()) {
            return Err(GjkError::NotFinite { body, index, value });
        }
    }
    Ok(())
}

fn is_ordinary(points: &[Vec3]) -> bool {
    points.iter().all(|point| point.iter().all(|&value| value == 0.0 || ORDINARY.contains(&value.abs())))
}

/// A pair near the origin and of a size near 1: each coordinate rounded once, by the shift; the scale is a power of two.
struct Scaled<'p> {
    a: Body,
    b: Body,
    originals: Originals<'p>,
    /// From the mean of A's points to the mean of B's.
    towards_b: Vec3,
    /// Whether searches in floating point can tell anything.
    ordinary: bool,
}

impl<'p> Scaled<'p> {
    fn new(a: &'p [Vec3], b: &'p [Vec3]) -> Self {
        let origin = a[0];
        let size = a.iter().chain(b).map(|p| (p - origin).amax()).fold(0.0, f64::max);
        let scale = power_of_two_near_inverse(size);
        let local = |p: &Vec3| (p - origin) * scale;
        let mean = |points: &[Vec3]| points.iter().map(local).sum::<Vec3>() / points.len() as f64;
        Self {
            towards_b: mean(b) - mean(a),
            a: Body::bare(a.iter().map(local)),
            b: Body::bare(b.iter().map(local)),
            originals: Originals { a, b, scale },
            ordinary: is_ordinary(a) && is_ordinary(b),
        }
    }

    fn pair(&self) -> Pair<'_> {
        // Scaled coordinates are at most 1, and two such points at most 2 sqrt(3).
        Pair { a: &self.a, b: &self.b, x: Vec3::zeros(), reach: 4.0, originals: Some(&self.originals) }
    }

    /// The first direction of a search.
    fn start(&self) -> Vec3 {
        if self.towards_b == Vec3::zeros() { Vec3::x() } else { self.towards_b }
    }

    fn search(&self, method: Method) -> Found {
        if self.ordinary { method.search(self.pair(), self.start()) } else { Found::Undecided(Corners::NONE) }
    }

    /// The distance search.
    fn classical(&self, until: Until) -> Found {
        if !self.ordinary {
            return Found::Undecided(Corners::NONE);
        }
        dispatch(Classical { pair: self.pair(), v: self.start(), sub_algorithm: SubAlgorithm::SignedVolumes, until })
    }

    fn overlap(&self, method: Method) -> bool {
        match self.search(method) {
            Found::Apart(_) => false,
            Found::Overlap(_) => true,
            Found::Undecided(corners) => matches!(self.exact().decide(corners.pairs()), Decision::Overlap(_)),
        }
    }

    fn verdict(&self, method: Method) -> Verdict {
        match self.search(method) {
            Found::Apart(direction) => Verdict::Separated { direction, proof: Proof::Margin },
            Found::Overlap(corners) => intersecting(corners.pairs(), Proof::Margin),
            Found::Undecided(corners) => match self.exact().decide(corners.pairs()) {
                Decision::Overlap(pairs) => intersecting(&pairs, Proof::Exact),
                Decision::Apart(v) => Verdict::Separated { direction: v.direction(), proof: Proof::Exact },
            },
        }
    }

    fn distance(&self) -> f64 {
        match self.classical(Until::Nearest) {
            Found::Overlap(_) => 0.0,
            Found::Apart(_) => unreachable!("a search for the nearest point does not stop at a separation"),
            Found::Undecided(corners) => self.exact().squared_distance(corners.pairs()).0.sqrt(),
        }
    }

    fn farther(&self, gap: f64) -> bool {
        // The scale is a power of two: nothing is rounded, but what is left of a gap must not be nothing.
        let least = if gap > 0.0 { f64::MIN_POSITIVE } else { 0.0 };
        let scaled = (gap * self.originals.scale).max(least);
        match self.classical(Until::Apart(scaled)) {
            Found::Apart(_) => true,
            Found::Overlap(_) => false,
            Found::Undecided(corners) => self.exact().squared_distance(corners.pairs()).0.exceeds(gap),
        }
    }

    fn exact(&self) -> ExactPair<'p, [Vec3], [Vec3]> {
        ExactPair::new(self.originals.a, self.originals.b, &Vec3::zeros())
    }
}

fn intersecting(pairs: &[(u32, u32)], proof: Proof) -> Verdict {
    Verdict::Intersecting { points: pairs.iter().map(|&(a, b)| (a as usize, b as usize)).collect(), proof }
}

/// 2^k with size 2^k in 1/2..=1; 1 for sizes that no search is made of.
fn power_of_two_near_inverse(size: f64) -> f64 {
    if !(f64::MIN_POSITIVE..=1e300).contains(&size) {
        return 1.0;
    }
    let exponent = (size.to_bits() >> 52) as i64 - 1022;
    f64::from_bits(((1023 - exponent) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_are_farther_than_all_that_is_less_than_their_distance() {
        let tetrahedron = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vec3::from);
        let mut apart = 0;
        for at in 0..9_u32.pow(3) {
            let place =
                Vec3::new(f64::from(at % 9), f64::from(at / 9 % 9), f64::from(at / 81)) * 0.15 - Vec3::repeat(0.1);
            for scale in [1.0, 1e-20, 1e20] {
                let a = tetrahedron.map(|p| p * scale);
                let b = tetrahedron.map(|p| (place - p * 0.7) * scale);
                let distance = distance(&a, &b).unwrap();
                apart += u32::from(distance > 0.0);
                assert_eq!(farther(&a, &b, 0.0), Ok(distance > 0.0));
                assert_eq!(farther(&a, &b, distance * (1.0 - 1e-15)), Ok(distance > 0.0));
                assert_eq!(farther(&a, &b, distance * (1.0 + 1e-15)), Ok(false));
            }
        }
        assert!((900..1900).contains(&apart), "{apart}");
    }
}
