//! Separation of two bodies, at least one of which is a ball or an ellipsoid.
//!
//! A direction n separates A from B by n . (b - a) - h_A(n) - h_B(-n), with the support functions h of the bodies about
//! their centres a and b; for an ellipsoid x = a + A u that is h(n) = |A^T n|. So every direction proves a lower bound of
//! the distance, rounding included, and the best direction reaches it. Balls need none: their centres decide.

use crate::geometry::{Round, Triangles};
use crate::gjk;
use crate::math::{Aabb, Mat3, Vec3};

/// The other body of a pair.
#[derive(Clone, Copy, Debug)]
pub enum Other<'a> {
    /// The convex hull of points, mm.
    Hull(&'a [Vec3]),
    /// A ball or an ellipsoid.
    Round(Round),
    /// The inside of a closed, connected surface.
    Surface(&'a Triangles),
}

impl Round {
    /// True when the bodies are proved more than `gap` mm apart.
    pub fn is_apart(&self, other: &Other, gap: f64) -> bool {
        match (self.radius(), other) {
            (_, Other::Surface(surface)) => self.is_clear_of(surface, gap),
            (Some(radius), Other::Hull(points)) => {
                gjk::distance_exceeds(&[*self.centre()], points, upwards(gap + radius)).unwrap_or(false)
            }
            (_, Other::Round(second)) => match [self.radius(), second.radius()] {
                [Some(radius), Some(other)] => {
                    let least = upwards(gap + radius + other);
                    (second.centre() - self.centre()).norm_squared() > upwards(least * least)
                }
                _ => two_ellipsoids(self, second, gap) > gap,
            },
            (None, Other::Hull(points)) => hull_beyond(self, points, gap) > gap,
        }
    }

    /// Distance of two bodies, mm, to 1e-9 of their size; 0 where they share a point.
    pub fn distance(&self, other: &Other) -> f64 {
        let distance = match (self.radius(), other) {
            (_, Other::Surface(surface)) => self.distance_to_surface(surface),
            (Some(radius), Other::Hull(points)) => {
                gjk::distance(&[*self.centre()], points).map_or(0.0, |distance| distance - radius)
            }
            (None, Other::Hull(points)) => hull_beyond(self, points, f64::INFINITY),
            (_, Other::Round(second)) => two_ellipsoids(self, second, f64::INFINITY),
        };
        distance.max(0.0)
    }

    /// No triangle comes within the gap, and the surface does not enclose the body.
    fn is_clear_of(&self, surface: &Triangles, gap: f64) -> bool {
        let near = surface.meeting(self.reach_box(gap)).map(|t| surface.of(t));
        !surface.contains(self.centre()) && near.into_iter().all(|triangle| self.is_apart(&Other::Hull(triangle), gap))
    }

    fn distance_to_surface(&self, surface: &Triangles) -> f64 {
        if surface.contains(self.centre()) {
            return 0.0;
        }
        let most = surface.nearest(self.centre()).map_or(f64::INFINITY, |(_, distance)| distance);
        let near = surface.meeting(self.reach_box(most)).map(|t| self.distance(&Other::Hull(surface.of(t))));
        near.fold(most, f64::min)
    }

    fn reach_box(&self, gap: f64) -> Aabb {
        let aabb = self.aabb();
        aabb.grown(upwards(gap) + 4.0 * f64::EPSILON * aabb.min.abs().sup(&aabb.max.abs()).max())
    }
}

/// A number that is no less than the exact result of the few operations that `x` comes from.
fn upwards(x: f64) -> f64 {
    x * (1.0 + 8.0 * f64::EPSILON)
}

/// Relative error of a separation along a direction: some forty roundings.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// A search ends where a bound is this share of the bodies' size below the best possible one.
const CONVERGED: f64 = 1e-12;
/// Most steps of a search; two ellipsoids take five.
const MOST_STEPS: usize = 40;

/// A proved lower bound of the distance of two ellipsoids, mm: the first one above `enough`, or the best.
///
/// Newton's method for the largest separation f over unit directions n. The gradient of f is the vector g between the
/// two support points, its Hessian -(H_A + H_B), H = (M - M n n^T M / h^2) / h with M = A A^T. On the sphere the step
/// within the tangent plane solves (H_A + H_B + f) d = g.
fn two_ellipsoids(a: &Round, b: &Round, enough: f64) -> f64 {
    let x = b.centre() - a.centre();
    let shapes = [a.shape(), b.shape()];
    let size = x.norm() + shapes[0].trace().sqrt() + shapes[1].trace().sqrt();
    let separation = |n: &Vec3| n.dot(&x) - a.reach(n) - b.reach(n);
    let start = (shapes[0] + shapes[1]).try_inverse().map_or(x, |inverse| inverse * x);
    let Some(mut n) = start.try_normalize(0.0) else { return f64::NEG_INFINITY };
    let mut best = separation(&n);
    for _ in 0..MOST_STEPS {
        if best - ROUNDING * size > enough {
            break;
        }
        let gradient = x - a.farthest(&n) - b.farthest(&n);
        let tangential = gradient - n * n.dot(&gradient);
        let curvature = hessian(&shapes[0], &n) + hessian(&shapes[1], &n);
        // Along n the step is none.
        let system = curvature + Mat3::identity() * best.max(0.0) + n * n.transpose() * size;
        let Some(step) = system.try_inverse().map(|inverse| inverse * tangential) else { break };
        let tried = (0..HALVINGS).map(|halving| (n + step / f64::from(1 << halving)).normalize());
        let Some((next, value)) = tried.map(|n| (n, separation(&n))).find(|(_, value)| *value > best) else { break };
        let gained = value - best;
        (n, best) = (next, value);
        if gained < CONVERGED * size {
            break;
        }
    }
    best - ROUNDING * size
}

/// Halvings of a step that goes too far.
const HALVINGS: u32 = 12;

/// Second derivatives of the support function of an ellipsoid with M = A A^T.
fn hessian(shape: &Mat3, n: &Vec3) -> Mat3 {
    let along = shape * n;
    let height = n.dot(&along).sqrt();
    (shape - along * along.transpose() / (height * height)) / height
}

/// A proved lower bound of the distance of an ellipsoid from the hull of `points`, mm: the first one above `enough`, or
/// the best.
///
/// The ellipsoid's own axes make it a unit ball: the point of the hull that is nearest to its centre there gives the first
/// direction, which decides whether they meet. The distance is that of the origin from the differences of points of both,
/// of which a hull is known that grows by one support point each step.
fn hull_beyond(round: &Round, points: &[Vec3], enough: f64) -> f64 {
    let arms: Vec<Vec3> = points.iter().map(|point| point - round.centre()).collect();
    let size = arms.iter().map(Vec3::norm).fold(0.0, f64::max) + round.shape().trace().sqrt();
    let lowest = |n: &Vec3| arms.iter().min_by(|p, q| n.dot(p).total_cmp(&n.dot(q))).copied().unwrap_or_default();
    let separation = |n: &Vec3| n.dot(&lowest(n)) - round.reach(n) - ROUNDING * size;
    let nearest =
        |points: &[Vec3]| gjk::closest_points(&[Vec3::zeros()], points).map_or(Vec3::zeros(), |found| found[1]);
    let unit: Vec<Vec3> = arms.iter().map(|arm| round.unit_arm(arm)).collect();
    let Some(mut n) = round.normal_of_unit(&nearest(&unit)).try_normalize(0.0) else { return f64::NEG_INFINITY };
    let mut best = separation(&n);
    let mut differences = Vec::new();
    for _ in 0..MOST_STEPS {
        if best > enough {
            break;
        }
        differences.push(lowest(&n) - round.farthest(&n));
        let point = nearest(&differences);
        let Some(next) = point.try_normalize(0.0) else { break };
        n = next;
        best = best.max(separation(&n));
        // The distance is no more than that of the known differences.
        if point.norm() <= enough && enough.is_finite() || point.norm() - best < CONVERGED * size {
            break;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Polyhedron;
    use crate::math::Rotation;
    use crate::random::Stream;

    fn ellipsoid(stream: &mut Stream, centre: Vec3) -> Round {
        let axes = Vec3::from_fn(|_, _| stream.uniform(0.3, 2.0));
        let body = Polyhedron::of_round(&Round::of_semi_axes(&axes));
        let turn =
            Rotation::from_euler_angles(stream.uniform(0.0, 6.0), stream.uniform(0.0, 3.0), stream.uniform(0.0, 6.0));
        body.rotated(&turn).translated(&centre).round().unwrap()
    }

    /// Distance of two convex bodies by alternating projections, from above.
    fn alternating(a: &Round, b: &Round) -> f64 {
        let mut x = *b.centre();
        let mut least = f64::INFINITY;
        for _ in 0..2000 {
            let p = if a.contains(&x) { x } else { a.nearest(&x) };
            let last = x;
            x = if b.contains(&p) { p } else { b.nearest(&p) };
            least = least.min((x - p).norm());
            if (x - last).norm() < 1e-9 {
                break;
            }
        }
        least
    }

    #[test]
    fn distances_of_ellipsoids_are_those_of_alternating_projections() {
        let mut stream = Stream::new(5);
        let (mut apart, mut meeting) = (0, 0);
        for _ in 0..60 {
            let a = ellipsoid(&mut stream, Vec3::zeros());
            let centre = Vec3::from_fn(|_, _| stream.uniform(-2.2, 2.2));
            let b = ellipsoid(&mut stream, centre);
            let (found, expected) = (a.distance(&Other::Round(b)), alternating(&a, &b));
            assert!((found - expected).abs() < 2e-3, "{found} {expected}");
            assert_eq!(a.is_apart(&Other::Round(b), 0.0), found > 0.0);
            if found > 0.0 {
                assert!(a.is_apart(&Other::Round(b), found * (1.0 - 1e-9) - 1e-9), "{found}");
                assert!(!a.is_apart(&Other::Round(b), found + 1e-9), "{found}");
            }
            apart += u32::from(found > 0.0);
            meeting += u32::from(found == 0.0);
        }
        assert!(apart > 15 && meeting > 15, "{apart} {meeting}");
    }

    #[test]
    fn distances_of_ellipsoids_and_hulls_are_between_their_circumscribed_and_inscribed_hulls() {
        let mut stream = Stream::new(6);
        let (mut apart, mut meeting) = (0, 0);
        for _ in 0..400 {
            let a = ellipsoid(&mut stream, Vec3::zeros());
            let centre = Vec3::from_fn(|_, _| stream.uniform(-2.2, 2.2));
            let hull: Vec<Vec3> = (0..8).map(|_| centre + Vec3::from_fn(|_, _| stream.uniform(-1.0, 1.0))).collect();
            let found = a.distance(&Other::Hull(&hull));
            let most = gjk::distance(Polyhedron::of_ends(&a.ends()).vertices(), &hull).unwrap();
            let around: Vec<Vec3> = a.circumscribed().iter().map(|v| v + a.centre()).collect();
            let least = gjk::distance(&around, &hull).unwrap();
            assert!(found >= least - 1e-9 && found <= most + 1e-9, "{least} {found} {most}");
            assert_eq!(a.is_apart(&Other::Hull(&hull), 0.0), found > 0.0);
            if found > 0.0 {
                assert!(a.is_apart(&Other::Hull(&hull), found - 1e-6), "{found}");
                assert!(!a.is_apart(&Other::Hull(&hull), found + 1e-6), "{found}");
            }
            apart += u32::from(found > 0.0);
            meeting += u32::from(found == 0.0);
        }
        assert!(apart > 100 && meeting > 100, "{apart} {meeting}");
    }

    #[test]
    fn balls_that_touch_share_a_point_and_balls_a_step_of_the_lattice_apart_do_not() {
        let lattice = 1.0 / f64::from(1 << 30);
        let at =
            |x: f64| Polyhedron::of_round(&Round::ball(2.5)).translated(&Vec3::new(x, 700.0, 0.0)).round().unwrap();
        assert!(!at(100.0).is_apart(&Other::Round(at(105.0)), 0.0));
        assert!(at(100.0).is_apart(&Other::Round(at(105.0 + lattice)), 0.0));
        assert!(at(100.0).is_apart(&Other::Round(at(105.5)), 0.5 - lattice));
        let corner =
            [Vec3::new(102.5 + lattice, 700.0, 0.0), Vec3::new(110.0, 700.0, 3.0), Vec3::new(110.0, 703.0, 0.0)];
        assert!(at(100.0).is_apart(&Other::Hull(&corner), 0.0));
        assert!(!at(100.0 + lattice).is_apart(&Other::Hull(&corner), 0.0));
    }

    #[test]
    fn a_round_body_within_a_surface_or_around_it_is_not_apart_from_it() {
        let cube = |half: f64| {
            let corners: Vec<Vec3> =
                (0..8).map(|i| Vec3::from_fn(|k, _| if i >> k & 1 == 1 { half } else { -half })).collect();
            crate::geometry::convex_hull(&corners).unwrap().surface()
        };
        for body in [Round::ball(1.0), Round::of_semi_axes(&Vec3::new(1.5, 1.0, 0.8))] {
            assert!(!body.is_apart(&Other::Surface(&cube(5.0)), 0.0));
            assert!(!body.is_apart(&Other::Surface(&cube(0.1)), 0.0));
            let beside = Polyhedron::of_round(&body).translated(&Vec3::new(0.0, 0.0, 6.5)).round().unwrap();
            assert!(beside.is_apart(&Other::Surface(&cube(5.0)), 0.4));
            let distance = beside.distance(&Other::Surface(&cube(5.0)));
            assert!((distance - (1.5 - body.aabb().max.z)).abs() < 1e-9, "{distance}");
        }
    }

    #[test]
    fn heights_chords_and_boxes_of_an_ellipsoid_agree_with_its_points() {
        let mut stream = Stream::new(8);
        for _ in 0..300 {
            let body = ellipsoid(&mut stream, Vec3::new(3.0, -2.0, 1.0));
            let point = body.centre() + Vec3::from_fn(|_, _| stream.uniform(-3.0, 3.0));
            let nearest = body.nearest(&point);
            let normal = body.normal_of_unit(&body.unit_arm(&(nearest - body.centre()))).normalize();
            let arm = point - nearest;
            assert!((arm.cross(&normal)).norm() < 1e-6, "the arm is normal to the surface");
            assert!((arm.dot(&normal) - body.height(&point)).abs() < 1e-6);
            let direction = Vec3::from_fn(|_, _| stream.uniform(-1.0, 1.0));
            if let Some((from, to)) = body.chord(&point, &direction) {
                for at in [from, to] {
                    assert!(body.height(&(point + direction * at)).abs() < 1e-6);
                }
            }
            let top = body.farthest(&Vec3::z()) + body.centre();
            assert!((top.z - body.aabb().max.z).abs() < 1e-9);
        }
    }

    #[test]
    fn areas_and_volumes_of_round_bodies_are_those_of_the_formulas() {
        let oblate = Round::of_semi_axes(&Vec3::new(2.0, 2.0, 1.0));
        let e = 0.75_f64.sqrt();
        let area = std::f64::consts::TAU * 4.0 * (1.0 + (1.0 - e * e) / e * e.atanh());
        assert!((oblate.area() / area - 1.0).abs() < 1e-3, "{} {area}", oblate.area());
        assert!((oblate.volume() - 16.0 / 3.0 * std::f64::consts::PI).abs() < 1e-12);
        let body = Polyhedron::of_round(&oblate);
        assert_eq!((body.vertices().len(), body.faces().len()), (162, 320));
        let facets = body.faceted();
        assert!((facets.volume() / body.volume() - 1.0).abs() < 1e-12);
        let within = crate::geometry::convex_hull(body.vertices()).unwrap().volume() / body.volume();
        assert!((within - 0.9662).abs() < 1e-4, "{within}");
    }

    #[test]
    fn facets_of_a_ball_differ_from_it_by_the_shares_that_the_documents_state() {
        let ball = Round::ball(1.0);
        let body = Polyhedron::of_round(&ball);
        let facets = body.faceted();
        let corner = facets.vertices().iter().map(Vec3::norm).fold(0.0, f64::max);
        let plane = facets.planes().map(|plane| plane.offset).fold(1.0, f64::min);
        assert!((corner - 1.0115).abs() < 1e-4 && (plane - 0.9936).abs() < 1e-4, "{corner} {plane}");
        let around = ball.circumscribed().iter().map(Vec3::norm).fold(0.0, f64::max);
        assert!((around - 1.0181).abs() < 1e-4, "{around}");
    }
}
