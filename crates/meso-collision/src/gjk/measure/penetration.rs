//! Penetration depth of two bodies: the shortest move that parts them, between two certain bounds.
//!
//! The depth is the distance from the origin to the surface of A - B. As in the expanding polytope algorithm (van den
//! Bergen, 2001), a polytope inside A - B grows by supports along the normals of its faces. Here each round adds those
//! of all faces that may be nearest, and the hull of all is made anew, with exact predicates. Its nearest face bounds
//! the depth from below, every support from above.

use crate::geometry::convex_hull;
use crate::gjk::error::{GjkError, Operand, check};
use crate::gjk::measure::top;
use crate::gjk::pair::{Pair, View};
use crate::gjk::scaled::{Scaled, power_to_one, times_power};
use crate::gjk::search::simplex::Vertex;
use crate::math::{Aabb, Vec3};
use crate::simd::{Simd, Vectorized, dispatch};

/// Unit roundoff.
const U: f64 = f64::EPSILON / 2.0;
/// Bound on the rounding error of a point of A - B: coordinates of magnitude 1, shifted once and subtracted once.
const MOVED: f64 = 16.0 * U;
/// Components too small for the hull's predicates.
const NEGLIGIBLE: f64 = 1e-40;
/// Sizes, beside a largest coordinate of 1, below which underflow could show.
const LEAST_SIZE: f64 = 1e-270;

/// How deep two bodies overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penetration {
    /// Moved by this along `direction`, B shares at most points of its surface with A. In the unit of the points.
    pub depth: f64,
    /// No shorter move parts them.
    pub at_least: f64,
    /// Unit vector from A to B.
    pub direction: Vec3,
}

impl Penetration {
    /// The shortest move that parts the hulls of `a` and `b`, or `None` where they share no point.
    ///
    /// The true depth lies between `at_least` and `depth`, which differ by some 1e-14 of the bodies' size.
    ///
    /// # Errors
    /// Fails like [`intersects`](crate::gjk::intersects).
    ///
    /// ```
    /// use meso_collision::{gjk, math::Vec3};
    /// let cube = |x: f64| [0, 1, 2, 3, 4, 5, 6, 7].map(|i| Vec3::new(x + f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)));
    /// let found = gjk::Penetration::of(&cube(0.0), &cube(0.75))?.expect("they overlap");
    /// assert!((found.depth - 0.25).abs() < 1e-14 && found.at_least <= 0.25);
    /// assert_eq!(found.direction, Vec3::x());
    /// # Ok::<(), gjk::GjkError>(())
    /// ```
    pub fn of(a: &[Vec3], b: &[Vec3]) -> Result<Option<Self>, GjkError> {
        check(a, Operand::A)?;
        check(b, Operand::B)?;
        if !Scaled::new(a, b).overlap(crate::gjk::Algorithm::default()) {
            return Ok(None);
        }
        let exponent = power_to_one(a.iter().chain(b));
        if exponent == 0 {
            return Ok(Some(scaled_penetration(a, b)));
        }
        let brought = |points: &[Vec3]| points.iter().map(|p| times_power(p, exponent)).collect::<Vec<_>>();
        let Penetration { depth, at_least, direction } = scaled_penetration(&brought(a), &brought(b));
        // Up and down past the rounding of subnormal numbers.
        let back = |length: f64| libm::scalbn(length, -exponent);
        Ok(Some(Penetration { depth: back(depth).next_up(), at_least: back(at_least).next_down().max(0.0), direction }))
    }
}

/// The depth for coordinates of ordinary magnitudes.
fn scaled_penetration(a: &[Vec3], b: &[Vec3]) -> Penetration {
    let whole = Aabb::around(a.iter().chain(b));
    if whole.size().amax() < LEAST_SIZE {
        return of_boxes(&Aabb::around(a), &Aabb::around(b));
    }
    let scaled = Scaled::new(a, b);
    let Penetration { depth, at_least, direction } = Search::new(&scaled).run();
    let length = 1.0 / scaled.originals.scale;
    Penetration { depth: depth * length, at_least: at_least * length, direction }
}

/// The shortest move along an axis.
fn of_boxes(a: &Aabb, b: &Aabb) -> Penetration {
    let moves =
        (0..3).flat_map(|k| [(a.max[k] - b.min[k], Vec3::ith(k, 1.0)), (b.max[k] - a.min[k], Vec3::ith(k, -1.0))]);
    let shortest = moves.min_by(|p, q| p.0.total_cmp(&q.0));
    let (depth, direction) = shortest.expect("there are six of them");
    Penetration { depth: depth.max(0.0).next_up(), at_least: 0.0, direction }
}

/// A polytope in A - B that grows.
struct Search<'a> {
    pair: Pair<'a>,
    points: Vec<Vec3>,
    /// The pair of points whose difference each point is.
    of: Vec<(u32, u32)>,
    depth: f64,
    direction: Vec3,
}

impl<'a> Search<'a> {
    fn new(scaled: &'a Scaled<'_>) -> Self {
        Self { pair: scaled.pair(), points: Vec::new(), of: Vec::new(), depth: f64::INFINITY, direction: Vec3::x() }
    }

    fn run(mut self) -> Penetration {
        for i in 0..27 {
            let v = Vec3::new(f64::from(i % 3) - 1.0, f64::from(i / 3 % 3) - 1.0, f64::from(i / 9) - 1.0);
            if v != Vec3::zeros() {
                self.ask(&v);
            }
        }
        loop {
            let Ok(hull) = convex_hull(&self.points) else { return self.flat() };
            let near = |offset: f64| offset < self.depth - U;
            let normals: Vec<Vec3> = hull.planes().filter(|p| near(p.offset)).map(|p| p.normal).collect();
            // All of them, without short-circuit.
            if !normals.iter().fold(false, |fresh, normal| fresh | self.ask(normal)) {
                let inside = hull.contains(&Vec3::zeros());
                let triangles = hull.triangles().map(|t| certain_distance(t.map(|i| hull.vertices()[i as usize])));
                let at_least = if inside { triangles.fold(f64::INFINITY, f64::min) - MOVED } else { 0.0 };
                return self.found(at_least.max(0.0));
            }
        }
    }

    fn found(&self, at_least: f64) -> Penetration {
        Penetration { depth: self.depth, at_least, direction: self.direction }
    }

    /// A - B has no volume, or next to none: the depth is that across it.
    fn flat(mut self) -> Penetration {
        let first = self.points[0];
        let far = |measure: &dyn Fn(&Vec3) -> f64| {
            let far = self.points.iter().max_by(|p, q| measure(p).total_cmp(&measure(q)));
            far.expect("there is one") - first
        };
        let u = far(&|p| (p - first).norm_squared());
        let v = far(&|p| u.cross(&(p - first)).norm_squared());
        let across = u.cross(&v);
        let across = if across == Vec3::zeros() { u.cross(&Vec3::ith(u.iamin(), 1.0)) } else { across };
        let across = if across == Vec3::zeros() { Vec3::x() } else { across.normalize() };
        self.ask(&across);
        self.ask(&-across);
        self.found(0.0)
    }

    /// Takes the support along `v`; true where it is a new point.
    fn ask(&mut self, v: &Vec3) -> bool {
        if !v.iter().all(|x| x.is_finite()) {
            return false;
        }
        let (Vertex { w, of }, separation) = dispatch(SupportAlong { pair: self.pair, v: *v });
        let norm = v.norm();
        if -separation < (self.depth + 1e-12) * norm {
            let extent = top(self.pair.a, v) + top(self.pair.b, &-v);
            let depth = extent.max(0.0) / norm * (1.0 + 8.0 * U);
            if depth < self.depth {
                (self.depth, self.direction) = (depth, v / norm);
            }
        }
        let fresh = !self.of.contains(&of);
        if fresh {
            self.of.push(of);
            self.points.push(w.map(|x| if x.abs() < NEGLIGIBLE { 0.0 } else { x }));
        }
        fresh
    }
}

/// The support of a pair along `v`.
struct SupportAlong<'a> {
    pair: Pair<'a>,
    v: Vec3,
}

impl Vectorized for SupportAlong<'_> {
    type Output = (Vertex, f64);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> (Vertex, f64) {
        self.pair.support(simd, &self.v)
    }
}

/// A lower bound of a triangle's distance from the origin: its plane's, or where rounding hides the plane of a sliver,
/// that of its longest edge less its width.
fn certain_distance([a, b, c]: [Vec3; 3]) -> f64 {
    let (u, v) = (b - a, c - a);
    let (normal, sides) = (u.cross(&v), u.norm() * v.norm());
    let (area, reach) = (normal.norm(), a.norm());
    let plane = normal.dot(&a).abs() / area - (8.0 * U * sides / area + 8.0 * U) * reach;
    let edges = [(a, b), (b, c), (c, a)];
    let (p, q) = edges
        .into_iter()
        .max_by(|e, f| (e.1 - e.0).norm_squared().total_cmp(&(f.1 - f.0).norm_squared()))
        .expect("three");
    let along = q - p;
    let share = (-p.dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
    let width = (area + 8.0 * U * sides) / along.norm();
    let edge = (p + along * share).norm() - 32.0 * U * (reach + along.norm()) - width;
    // NaN, of a triangle without area, is not the larger one.
    edge.max(plane)
}
