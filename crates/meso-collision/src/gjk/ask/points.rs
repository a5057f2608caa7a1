//! Questions about plain points: checked, brought to a common scale, searched, proved.

use crate::gjk::error::{GjkError, Operand, check};
use crate::gjk::method::Algorithm;
use crate::gjk::pair::Found;
use crate::gjk::prove::exact::Decision;
use crate::gjk::scaled::Scaled;
use crate::math::{Aabb, Vec3};

/// An answer with its witness.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// The bodies share no point.
    Separated {
        /// Separates them: every point of A lies lower along it than every point of B.
        ///
        /// Where `is_exact`, the exact direction does; this one is it, rounded.
        direction: Vec3,
        /// Whether exact arithmetic proved it. Otherwise this witness did, with a margin that survives rounding.
        is_exact: bool,
    },
    /// The bodies share at least one point.
    Intersecting {
        /// One to four pairs of points, of A and of B: the hull of their differences holds the origin.
        points: Vec<(usize, usize)>,
        /// Whether exact arithmetic proved it. Otherwise this witness did, with a margin that survives rounding.
        is_exact: bool,
    },
}

impl Verdict {
    /// True for [`Verdict::Intersecting`].
    ///
    /// ```
    /// use meso_collision::{gjk::Algorithm, math::Vec3};
    /// assert!(!Algorithm::Exact.verdict(&[Vec3::x()], &[Vec3::y()])?.intersects());
    /// # Ok::<(), meso_collision::gjk::GjkError>(())
    /// ```
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
/// use meso_collision::{gjk, math::Vec3};
/// let segment = [Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0)];
/// let point = [Vec3::new(0.1, 0.0, 0.0)];
/// assert!(gjk::intersects(&segment, &point)?);
/// assert!(!gjk::intersects(&segment, &[Vec3::new(0.1, 1e-30, 0.0)])?);
/// # Ok::<(), gjk::GjkError>(())
/// ```
pub fn intersects(a: &[Vec3], b: &[Vec3]) -> Result<bool, GjkError> {
    Algorithm::default().intersects(a, b)
}

impl Algorithm {
    /// [`intersects`] by this search.
    ///
    /// # Errors
    /// Fails like [`intersects`].
    ///
    /// ```
    /// use meso_collision::{gjk::Algorithm, math::Vec3};
    /// let [a, b] = [0.0, 2.0].map(|x| [Vec3::new(x, 0.0, 0.0), Vec3::new(x + 1.0, 0.0, 0.0)]);
    /// for method in Algorithm::ALL {
    ///     assert!(!method.intersects(&a, &b)?);
    /// }
    /// # Ok::<(), meso_collision::gjk::GjkError>(())
    /// ```
    pub fn intersects(self, a: &[Vec3], b: &[Vec3]) -> Result<bool, GjkError> {
        check(a, Operand::A)?;
        check(b, Operand::B)?;
        Ok(Scaled::new(a, b).overlap(self))
    }

    /// [`Algorithm::intersects`] of `a` with each of many bodies, in their order; most are told apart by their boxes.
    ///
    /// To ask about the same bodies more than once, make [`Bodies`](crate::gjk::Bodies) of them.
    ///
    /// # Errors
    /// Fails like [`intersects`]; the first offending body is named.
    ///
    /// ```
    /// use meso_collision::{gjk::Algorithm, math::Vec3};
    /// let [a, b] = [0.0, 2.0].map(|x| [Vec3::new(x, 0.0, 0.0), Vec3::new(x + 1.0, 0.0, 0.0)]);
    /// assert_eq!(Algorithm::default().intersects_many(&a, [&a[..], &b])?, [true, false]);
    /// # Ok::<(), meso_collision::gjk::GjkError>(())
    /// ```
    pub fn intersects_many<'b>(
        self,
        a: &[Vec3],
        bodies: impl IntoIterator<Item = &'b [Vec3]>,
    ) -> Result<Vec<bool>, GjkError> {
        check(a, Operand::A)?;
        let around_a = Aabb::around(a);
        let answer = |(i, b): (usize, &[Vec3])| {
            check(b, Operand::Many(i))?;
            // Coordinates are compared and not computed with, so boxes that are apart prove it.
            Ok(around_a.intersects(&Aabb::around(b)) && Scaled::new(a, b).overlap(self))
        };
        bodies.into_iter().enumerate().map(answer).collect()
    }

    /// Whether the hulls of `a` and `b` share a point, with the proof.
    ///
    /// # Errors
    /// Fails like [`intersects`].
    ///
    /// ```
    /// use meso_collision::{gjk::{Algorithm, Verdict}, math::Vec3};
    /// let a = [Vec3::new(0.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0)];
    /// let verdict = Algorithm::default().verdict(&a, &[Vec3::new(2.0, 1.0, 0.0)])?;
    /// let Verdict::Separated { direction, .. } = verdict else { panic!() };
    /// assert!(direction.x > 0.0);
    /// # Ok::<(), meso_collision::gjk::GjkError>(())
    /// ```
    pub fn verdict(self, a: &[Vec3], b: &[Vec3]) -> Result<Verdict, GjkError> {
        check(a, Operand::A)?;
        check(b, Operand::B)?;
        Ok(proved(&Scaled::new(a, b), self))
    }
}

fn proved(pair: &Scaled<'_>, method: Algorithm) -> Verdict {
    match pair.search(method) {
        Found::Apart(direction) => Verdict::Separated { direction, is_exact: false },
        Found::Overlap(corners) => intersecting(corners.pairs(), false),
        Found::Undecided(corners) => match pair.exact().decide(corners.pairs()) {
            Decision::Overlap(pairs) => intersecting(&pairs, true),
            Decision::Apart(v) => Verdict::Separated { direction: v.direction(), is_exact: true },
        },
    }
}

fn intersecting(pairs: &[(u32, u32)], is_exact: bool) -> Verdict {
    Verdict::Intersecting { points: pairs.iter().map(|&(a, b)| (a as usize, b as usize)).collect(), is_exact }
}

/// Distance of the hulls of `a` and `b`, in the unit of the points: 0 exactly when they share a point.
///
/// Correctly rounded up to one unit in the last place.
///
/// # Errors
/// Fails like [`intersects`].
///
/// ```
/// use meso_collision::{gjk, math::Vec3};
/// let a = [Vec3::new(0.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0)];
/// assert_eq!(gjk::distance(&a, &[Vec3::new(4.0, 4.0, 0.0)])?, 5.0);
/// # Ok::<(), gjk::GjkError>(())
/// ```
pub fn distance(a: &[Vec3], b: &[Vec3]) -> Result<f64, GjkError> {
    check(a, Operand::A)?;
    check(b, Operand::B)?;
    Ok(Scaled::new(a, b).distance())
}

/// A point of A's hull and one of B's that are nearest each other; where the hulls share any point, one of these,
/// twice.
///
/// Each coordinate is the exact one, rounded once. Parallel faces and edges have many such pairs; which one is found
/// depends on the points alone.
///
/// # Errors
/// Fails like [`intersects`].
///
/// ```
/// use meso_collision::{gjk, math::Vec3};
/// let segment = [Vec3::new(0.0, 0.0, 0.0), Vec3::new(4.0, 0.0, 0.0)];
/// let points = gjk::closest_points(&segment, &[Vec3::new(3.0, 2.0, 0.0)])?;
/// assert_eq!(points, [Vec3::new(3.0, 0.0, 0.0), Vec3::new(3.0, 2.0, 0.0)]);
/// # Ok::<(), gjk::GjkError>(())
/// ```
pub fn closest_points(a: &[Vec3], b: &[Vec3]) -> Result<[Vec3; 2], GjkError> {
    check(a, Operand::A)?;
    check(b, Operand::B)?;
    Ok(Scaled::new(a, b).closest_points())
}

/// True when the hulls of `a` and `b` are more than `gap` (finite, at least 0) apart: agrees with [`distance`], mostly
/// without computing it.
pub(crate) fn distance_exceeds(a: &[Vec3], b: &[Vec3], gap: f64) -> Result<bool, GjkError> {
    check(a, Operand::A)?;
    check(b, Operand::B)?;
    Ok(Scaled::new(a, b).distance_exceeds(gap))
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
                assert_eq!(distance_exceeds(&a, &b, 0.0), Ok(distance > 0.0));
                assert_eq!(distance_exceeds(&a, &b, distance * (1.0 - 1e-15)), Ok(distance > 0.0));
                assert_eq!(distance_exceeds(&a, &b, distance * (1.0 + 1e-15)), Ok(false));
            }
        }
        assert!((900..1900).contains(&apart), "{apart}");
    }
}
