//! The first contact of a body that moves along a line with another: between two certain bounds.
//!
//! Conservative advancement: of a direction v that separates the bodies at time t, it is known until when it does. The
//! direction of their nearest points lasts longest, so it is the one to look at; a step later, the next one. Where no
//! step leads on, the bodies are as near as rounding can show, and exact arithmetic says at which later time they meet.

use crate::gjk::error::{GjkError, Operand, check, check_finite};
use crate::gjk::measure::top;
use crate::gjk::pair::{Found, Originals, Pair};
use crate::gjk::prove::certificate::highest;
use crate::gjk::prove::exact::{Decision, ExactPair};
use crate::gjk::scaled::{Scaled, power_to_one, times_power};
use crate::gjk::search::classical::{Classical, Until};
use crate::gjk::search::nearest::SubAlgorithm;
use crate::gjk::search::simplex::{Corners, Simplex};
use crate::gjk::support::Support;
use crate::math::Vec3;
use crate::simd::dispatch;

const U: f64 = f64::EPSILON / 2.0;
/// Steps after which the bounds are given as they are; six are usual.
const MAX_STEPS: usize = 64;
/// Later times that are tried, each twice as late as the one before, from a rounding on: up to 1e-9 of the motion.
const LATER: i32 = 24;

/// When two bodies meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Before this share of the motion they are apart, for certain.
    pub not_before: f64,
    /// At this share of the motion B shares a point with A, for certain; so the first time is not later. `None` where B
    /// passes A so closely that rounding hides whether they touch.
    pub by: Option<f64>,
    /// Unit vector from A to B that separates them until then. 0 where they share a point at the start.
    pub direction: Vec3,
}

impl Impact {
    /// The first time in 0..=1 at which the hull of `a` and that of `b` + time `motion` share a point; `None` where
    /// they do not meet, for certain.
    ///
    /// The bounds differ by some 1e-14 of bodies and motion, over the speed at which the bodies approach each other.
    ///
    /// # Errors
    /// Fails like [`intersects`](crate::gjk::intersects); and for a motion that is not finite.
    ///
    /// ```
    /// use meso_collision::{gjk, math::Vec3};
    /// let corners = [[3.0, 0.0, 0.0], [5.0, 1.0, 0.0], [5.0, -1.0, 1.0], [5.0, -1.0, -1.0]];
    /// let (point, moving) = ([Vec3::zeros()], corners.map(Vec3::from));
    /// let found = gjk::Impact::of(&point, &moving, &Vec3::new(-4.0, 0.0, 0.0))?.expect("it hits");
    /// assert!(found.not_before <= 0.75 && found.by.is_some_and(|by| by >= 0.75 && by - found.not_before < 1e-13));
    /// assert_eq!(gjk::Impact::of(&point, &moving, &Vec3::new(0.0, -4.0, 0.0))?, None);
    /// # Ok::<(), gjk::GjkError>(())
    /// ```
    pub fn of(a: &[Vec3], b: &[Vec3], motion: &Vec3) -> Result<Option<Self>, GjkError> {
        check(a, Operand::A)?;
        check(b, Operand::B)?;
        check_finite(std::slice::from_ref(motion), Operand::Shifts)?;
        let exponent = power_to_one(a.iter().chain(b).chain([motion]));
        if exponent == 0 {
            return Ok(Flight::new(&Scaled::beside(a, b, motion), motion).run());
        }
        // The times are the same; underflow moves the bodies by less than rounding does.
        let brought = |points: &[Vec3]| points.iter().map(|p| times_power(p, exponent)).collect::<Vec<_>>();
        let (near_a, near_b, near_motion) = (brought(a), brought(b), times_power(motion, exponent));
        let found = Flight::new(&Scaled::beside(&near_a, &near_b, &near_motion), &near_motion).run();
        let meet = |time: &f64| is_overlap(ExactPair::at_time(a, b, motion, *time).decide(&[]));
        Ok(found.map(|impact| Impact { by: impact.by.filter(meet), ..impact }))
    }
}

fn is_overlap(decision: Decision) -> bool {
    matches!(decision, Decision::Overlap(_))
}

/// B on its way past A.
struct Flight<'a> {
    scaled: &'a Scaled<'a>,
    motion: &'a Vec3,
}

/// A direction, and until when it separates the bodies.
struct Separation {
    v: Vec3,
    /// Infinity: for good.
    until: f64,
}

impl<'a> Flight<'a> {
    fn new(scaled: &'a Scaled<'a>, motion: &'a Vec3) -> Self {
        Self { scaled, motion }
    }

    fn run(&self) -> Option<Impact> {
        let (mut time, mut direction) = (0.0, Vec3::zeros());
        for _ in 0..MAX_STEPS {
            let Some(v) = self.separating(time) else { break };
            let Separation { v, until } = self.lasting(v, time);
            if until > 1.0 {
                return None;
            }
            direction = if direction == Vec3::zeros() || until > time { v } else { direction };
            if until <= time {
                break;
            }
            time = until;
        }
        Some(Impact { not_before: time, by: self.later(time), direction })
    }

    /// The direction of the bodies' nearest points at this time, from A to B; `None` where they share one.
    fn separating(&self, time: f64) -> Option<Vec3> {
        let x = self.motion * time;
        let originals = Originals { x, ..self.scaled.originals };
        let pair = self.pair(&x, &originals);
        let v = self.scaled.start() + pair.x;
        let v = if v == Vec3::zeros() { Vec3::x() } else { v };
        let search = Classical { pair, v, sub_algorithm: SubAlgorithm::SignedVolumes, until: Until::Nearest };
        let corners = match dispatch(search) {
            Found::Overlap(_) => return None,
            Found::Apart(v) => return Some(v),
            Found::Undecided(corners) => corners,
        };
        let v = towards_b(&pair, &corners);
        // Nearer than this the sign of v itself is in doubt.
        if v.norm() > 1e-13 * pair.reach {
            return Some(v);
        }
        let exact = ExactPair::new(originals.a, originals.b, &x);
        match exact.decide(corners.pairs()) {
            Decision::Overlap(_) => None,
            Decision::Apart(v) => Some(v.direction()),
        }
    }

    fn pair<'p>(&'p self, x: &Vec3, originals: &'p Originals<'p>) -> Pair<'p> {
        let x = x * self.scaled.originals.scale;
        Pair { x, reach: 4.0 + x.x.abs() + x.y.abs() + x.z.abs(), originals: Some(originals), ..self.scaled.pair() }
    }

    /// Until when `v` separates the bodies, where it does at `time`: B's lowest point over A's highest at the start,
    /// over the speed at which B comes down.
    fn lasting(&self, v: Vec3, time: f64) -> Separation {
        let (a, b) = (&self.scaled.a, &self.scaled.b);
        let above = -top(a, &v) - top(b, &-v);
        let speed = highest(&(-self.motion * self.scaled.originals.scale), &v);
        let until = if speed > 0.0 {
            above / speed * (1.0 - 8.0 * U)
        } else if above > time * speed * (1.0 - 8.0 * U) {
            f64::INFINITY
        } else {
            0.0
        };
        Separation { v: v.normalize(), until }
    }

    /// The first of some times from this one on at which the bodies share a point. The displacement is rounded in the
    /// search, and not in the proof: a rounded one can be beyond the true one.
    fn later(&self, time: f64) -> Option<f64> {
        // The rounding of the bodies' own coordinates: of a motion far beyond their size that of the motion says
        // nothing.
        let extent = extent(&self.scaled.a).max(extent(&self.scaled.b));
        let step = U * (time + 4.0 * extent / (self.motion.amax() * self.scaled.originals.scale));
        let later = (0..LATER).map(|k| (time + step * f64::from(1 << k)).min(1.0));
        std::iter::once(time).chain(later).find(|time| self.separating(*time).is_none() && self.meet(*time))
    }

    /// True when the bodies share a point at this time, for certain.
    fn meet(&self, time: f64) -> bool {
        let Originals { a, b, .. } = self.scaled.originals;
        is_overlap(ExactPair::at_time(a, b, self.motion, time).decide(&[]))
    }
}

/// The largest magnitude of a coordinate.
fn extent(body: &impl Support) -> f64 {
    (0..body.len()).map(|i| body.point(i).amax()).fold(0.0, f64::max)
}

/// The direction opposite to the point of the simplex nearest the origin.
fn towards_b(pair: &Pair<'_>, corners: &Corners) -> Vec3 {
    let [first, rest @ ..] = corners.pairs() else { return pair.x };
    let mut simplex = Simplex::point(pair.vertex(*first));
    rest.iter().for_each(|of| simplex.add(pair.vertex(*of)));
    -SubAlgorithm::SignedVolumes.reduce(&mut simplex)
}
