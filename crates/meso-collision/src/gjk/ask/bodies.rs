//! Bodies that are laid out once and asked often, wherever they lie.
//!
//! Each is laid out about a centre of its own, where bounds and searches work best: its points, and the displacement of
//! two centres, are rounded once there, which all certificates allow for. Pairs they leave open are decided from the
//! points as given.

use crate::geometry::convex_hull;
use crate::gjk::ask::cascade::Query;
use crate::gjk::body::Body;
use crate::gjk::error::{GjkError, Operand, check, check_finite};
use crate::gjk::pair::{Found, Originals, Pair};
use crate::gjk::prove::exact::{Decision, ExactPair};
use crate::gjk::scaled::is_ordinary;
use crate::gjk::search::classical::Classical;
use crate::gjk::search::enhanced::Enhanced;
use crate::gjk::search::simplex::Corners;
use crate::math::{Aabb, Vec3};
use crate::simd::dispatch;

/// Convex hulls of points, in one frame.
#[derive(Clone, Debug)]
pub struct Bodies(Vec<Placed>);

/// A body about its centre.
#[derive(Clone, Debug)]
struct Placed {
    body: Body,
    centre: Vec3,
    aabb: Aabb,
    /// As given; those that are no corners of a solid are left out.
    points: Box<[Vec3]>,
    /// Whether searches in floating point can tell anything.
    ordinary: bool,
}

impl Placed {
    fn new(points: &[Vec3]) -> Self {
        let (ordinary, aabb) = (is_ordinary(points), Aabb::around(points));
        if !ordinary {
            let body = Body::bare(points.iter().copied());
            return Self { body, centre: Vec3::zeros(), aabb, points: points.into(), ordinary };
        }
        let Ok(hull) = convex_hull(points) else {
            let centre = points.iter().sum::<Vec3>() / points.len() as f64;
            let local: Vec<Vec3> = points.iter().map(|p| p - centre).collect();
            return Self { body: Body::new(&local), centre, aabb, points: points.into(), ordinary };
        };
        let centre = hull.centroid();
        let local = hull.translated(&-centre);
        let body = Body::new(local.vertices()).with_facets(local.facets());
        Self { body, centre, aabb, points: hull.into_vertices().into(), ordinary }
    }
}

impl Bodies {
    /// Bodies of one or more points each: solid, flat, segments or points, in any unit.
    ///
    /// # Errors
    /// A body without points; a coordinate that is not finite. The first offending body is named.
    ///
    /// ```
    /// use meso_collision::{gjk::Bodies, math::Vec3};
    /// let cube = |x: f64| [0, 1, 2, 3, 4, 5, 6, 7].map(|i| Vec3::new(x + f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)));
    /// let row = Bodies::new([&cube(0.0)[..], &cube(1.0), &cube(2.5)])?;
    /// assert_eq!(row.overlapping(), [[0, 1]]);
    /// let moved = [(1, 2, Vec3::zeros()), (1, 2, Vec3::new(-0.5, 0.0, 0.0))];
    /// assert_eq!(row.overlap(&row, &moved)?, [false, true]);
    /// # Ok::<(), meso_collision::gjk::GjkError>(())
    /// ```
    pub fn new<'p>(bodies: impl IntoIterator<Item = &'p [Vec3]>) -> Result<Self, GjkError> {
        let placed = |(i, points): (usize, &[Vec3])| check(points, Operand::Many(i)).map(|()| Placed::new(points));
        Ok(Self(bodies.into_iter().enumerate().map(placed).collect::<Result<_, _>>()?))
    }

    /// Number of bodies.
    ///
    /// ```
    /// use meso_collision::{gjk::Bodies, math::Vec3};
    /// assert_eq!(Bodies::new([&[Vec3::x()][..], &[Vec3::y()]])?.len(), 2);
    /// # Ok::<(), meso_collision::gjk::GjkError>(())
    /// ```
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// True without bodies.
    ///
    /// ```
    /// use meso_collision::gjk::Bodies;
    /// assert!(Bodies::new([])?.is_empty());
    /// # Ok::<(), meso_collision::gjk::GjkError>(())
    /// ```
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The points of a body, as given; of a solid its corners alone.
    ///
    /// ```
    /// use meso_collision::{gjk::Bodies, math::Vec3};
    /// assert_eq!(Bodies::new([&[Vec3::x(), Vec3::y()][..]])?.points(0), [Vec3::x(), Vec3::y()]);
    /// # Ok::<(), meso_collision::gjk::GjkError>(())
    /// ```
    pub fn points(&self, body: usize) -> &[Vec3] {
        &self.0[body].points
    }

    /// For each (i, j, shift): do our body i and the `others`' body j, displaced by `shift`, share a point? Exactly,
    /// for points and shift as given.
    ///
    /// # Errors
    /// A shift that is not finite.
    ///
    /// # Panics
    /// When there is no such body.
    ///
    /// ```
    /// use meso_collision::{gjk::Bodies, math::Vec3};
    /// let points = [0.0, 1.0, 3.0].map(|x| [Vec3::new(x, 0.0, 0.0), Vec3::new(x + 1.0, 0.0, 0.0)]);
    /// let row = Bodies::new(points.iter().map(|body| &body[..]))?;
    /// assert_eq!(row.overlap(&row, &[(0, 2, Vec3::new(-2.0, 0.0, 0.0)), (0, 2, Vec3::zeros())])?, [true, false]);
    /// # Ok::<(), meso_collision::gjk::GjkError>(())
    /// ```
    pub fn overlap(&self, others: &Self, pairs: &[(u32, u32, Vec3)]) -> Result<Vec<bool>, GjkError> {
        let shifts: Vec<Vec3> = pairs.iter().map(|pair| pair.2).collect();
        check_finite(&shifts, Operand::Shifts)?;
        let mut answers = vec![false; pairs.len()];
        let asks: Vec<Ask<'_>> = pairs.iter().map(|pair| self.ask(others, pair)).collect();
        let near: Vec<usize> = (0..asks.len()).filter(|&i| asks[i].boxes_touch(0.0)).collect();
        let near_asks: Vec<Ask<'_>> = near.iter().map(|&i| asks[i]).collect();
        for (i, overlap) in near.into_iter().zip(answer(&near_asks)) {
            answers[i] = overlap;
        }
        Ok(answers)
    }

    /// All pairs that share a point, each as ascending numbers, in ascending order.
    ///
    /// ```
    /// use meso_collision::{gjk::Bodies, math::Vec3};
    /// let points = [0.0, 1.0, 3.0].map(|x| [Vec3::new(x, 0.0, 0.0), Vec3::new(x + 1.0, 0.0, 0.0)]);
    /// let row = Bodies::new(points.iter().map(|body| &body[..]))?;
    /// assert_eq!(row.overlapping(), [[0, 1]]);
    /// # Ok::<(), meso_collision::gjk::GjkError>(())
    /// ```
    pub fn overlapping(&self) -> Vec<[u32; 2]> {
        let mut order: Vec<u32> = (0..self.0.len() as u32).collect();
        let aabb = |i: u32| &self.0[i as usize].aabb;
        order.sort_by(|&i, &j| aabb(i).min.x.total_cmp(&aabb(j).min.x).then(i.cmp(&j)));
        let mut pairs = Vec::new();
        for (k, &i) in order.iter().enumerate() {
            let beside = order[k + 1..].iter().take_while(|&&j| aabb(j).min.x <= aabb(i).max.x);
            pairs.extend(beside.filter(|&&j| aabb(i).intersects(aabb(j))).map(|&j| [i.min(j), i.max(j)]));
        }
        pairs.sort_unstable();
        let asks: Vec<Ask<'_>> = pairs.iter().map(|&[i, j]| self.ask(self, &(i, j, Vec3::zeros()))).collect();
        pairs.into_iter().zip(answer(&asks)).filter_map(|(pair, overlap)| overlap.then_some(pair)).collect()
    }

    /// At which of these shifts the `others`' body `body` is more than `gap` (at least 0) away from all bodies:
    /// placement attempts.
    ///
    /// # Errors
    /// A shift that is not finite.
    ///
    /// # Panics
    /// When there is no such body, or the gap is negative or not finite.
    ///
    /// ```
    /// use meso_collision::{gjk::Bodies, math::Vec3};
    /// let points = [0.0, 1.0, 3.0].map(|x| [Vec3::new(x, 0.0, 0.0), Vec3::new(x + 1.0, 0.0, 0.0)]);
    /// let row = Bodies::new(points.iter().map(|body| &body[..]))?;
    /// let shifts = [5.0, 0.5].map(|x| Vec3::new(x, 0.0, 0.0));
    /// assert_eq!(row.clear(&row, 0, &shifts, 0.25)?, [true, false]);
    /// # Ok::<(), meso_collision::gjk::GjkError>(())
    /// ```
    pub fn clear(&self, others: &Self, body: u32, shifts: &[Vec3], gap: f64) -> Result<Vec<bool>, GjkError> {
        assert!(gap >= 0.0 && gap.is_finite(), "the gap is {gap}; it must be finite and at least 0");
        check_finite(shifts, Operand::Shifts)?;
        let is_clear = |shift: &Vec3| {
            let asks = (0..self.0.len() as u32).map(|i| self.ask(others, &(i, body, *shift)));
            asks.filter(|ask| ask.boxes_touch(gap)).all(|ask| ask.is_apart(gap))
        };
        Ok(shifts.iter().map(is_clear).collect())
    }

    fn ask<'b>(&'b self, others: &'b Self, &(i, j, shift): &(u32, u32, Vec3)) -> Ask<'b> {
        Ask { a: &self.0[i as usize], b: &others.0[j as usize], shift }
    }
}

/// Which of the pairs share a point.
fn answer(asks: &[Ask<'_>]) -> Vec<bool> {
    asks.iter().map(|ask| !ask.is_apart(0.0)).collect()
}

/// A question about two bodies, B displaced.
#[derive(Clone, Copy)]
struct Ask<'a> {
    a: &'a Placed,
    b: &'a Placed,
    shift: Vec3,
}

impl Ask<'_> {
    fn is_ordinary(&self) -> bool {
        self.a.ordinary && self.b.ordinary && is_ordinary(std::slice::from_ref(&self.shift))
    }

    /// False only where the boxes are more than `gap` apart along an axis.
    fn boxes_touch(&self, gap: f64) -> bool {
        let (a, b, shift) = (&self.a.aabb, &self.b.aabb, &self.shift);
        // Rounded outwards: a sum is off by half an ulp.
        let (down, up) = (|p: f64, q: f64| (p + q).next_down(), |p: f64, q: f64| (p + q).next_up());
        (0..3).all(|k| down(b.min[k], shift[k]) <= up(a.max[k], gap) && a.min[k] <= up(up(b.max[k], shift[k]), gap))
    }

    /// From A's centre to B's, rounded once: two differences would cost digits where they cancel.
    fn displacement(&self) -> Vec3 {
        Vec3::from_fn(|k, _| {
            let (difference, lost) = two_sum(self.b.centre[k], -self.a.centre[k]);
            let (sum, lost_again) = two_sum(difference, self.shift[k]);
            sum + (lost + lost_again)
        })
    }

    /// Whether the bodies are more than `gap` apart: by their bounds and a search in single precision first.
    fn is_apart(&self, gap: f64) -> bool {
        if !self.is_ordinary() {
            return self.is_farther(gap);
        }
        let query = Query { a: &self.a.body, b: &self.b.body, x: self.displacement(), gap };
        query.apart_or(|_| self.is_farther(gap))
    }

    /// Whether the bodies are more than `gap` apart, from the points as given.
    fn is_farther(&self, gap: f64) -> bool {
        let corners = match self.search(gap) {
            Found::Apart(_) => return true,
            Found::Overlap(_) => return false,
            Found::Undecided(corners) => corners,
        };
        let exact = ExactPair::new(&self.a.points[..], &self.b.points[..], &self.shift);
        if gap == 0.0 {
            return matches!(exact.decide(corners.pairs()), Decision::Apart(_));
        }
        exact.squared_distance(corners.pairs()).0.exceeds(gap)
    }

    fn search(&self, gap: f64) -> Found {
        if !self.is_ordinary() {
            return Found::Undecided(Corners::NONE);
        }
        let (a, b, x) = (&self.a.body, &self.b.body, self.displacement());
        let originals = Originals { a: &self.a.points, b: &self.b.points, x: self.shift, scale: 1.0 };
        let reach = a.circumradius() + b.circumradius() + x.x.abs() + x.y.abs() + x.z.abs();
        let pair = Pair { a, b, x, reach, originals: Some(&originals) };
        let v = if x == Vec3::zeros() { Vec3::x() } else { x };
        if gap == 0.0 { dispatch(Enhanced { pair, v }) } else { dispatch(Classical::beyond(pair, v, gap)) }
    }
}

/// a + b, rounded, and the rounding error (D. E. Knuth).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}
