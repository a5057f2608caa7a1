//! Pairs of bodies get the exact answer, on every instruction set.

use super::dice::Dice;
use super::isa;
use meso_collision::geometry::convex_hull;
use meso_collision::gjk::{Algorithm, Body};
use meso_collision::math::{Mat3, Rotation, Vec3};
use rayon::prelude::*;

/// Do A and B share a point, with B displaced?
#[derive(Clone, Copy)]
struct Ask<'a> {
    a: &'a Body,
    b: &'a Body,
    b_from_a: Vec3,
}

impl Ask<'_> {
    fn overlaps(&self) -> bool {
        self.a.overlaps(self.b, &self.b_from_a)
    }

    fn by(&self, algorithm: Algorithm) -> bool {
        algorithm.overlap(self.a, self.b, &self.b_from_a)
    }
}

/// Bodies of every kind: with and without bounds, solid and flat, small and large.
fn bodies(dice: &mut Dice) -> Vec<Body> {
    let mut bodies = Vec::new();
    for i in 0..60 {
        let n = if i % 10 == 9 { 50 } else { 20 + dice.below(11) };
        let size = 1.0 + 4.0 * dice.unit();
        let points = dice.body(n, size);
        let radius = points.iter().map(Vec3::norm).fold(0.0, f64::max);
        let body = Body::on_ellipsoid(&points, &Vec3::repeat(radius), &Mat3::identity());
        bodies.push(if i % 7 == 6 { body } else { body.with_inside_of(&convex_hull(&points).unwrap()) });
    }
    bodies.extend((0..10).map(|_| Body::new(&(0..4).map(|_| dice.integers(3)).collect::<Vec<_>>())));
    bodies
}

fn questions<'a>(dice: &mut Dice, bodies: &'a [Body], n: usize) -> Vec<Ask<'a>> {
    let mut one = || {
        let [a, b] = [0, 1].map(|_| &bodies[dice.below(bodies.len())]);
        let reach = a.circumradius() + b.circumradius();
        let x = dice.direction() * (1.05 * reach * dice.unit());
        Ask { a, b, b_from_a: if dice.below(20) == 0 { x.map(f64::round) } else { x } }
    };
    (0..n).map(|_| one()).collect()
}

#[test]
fn headers_and_axes_tell_what_the_search_tells() {
    let mut dice = Dice::new(7);
    let bodies = bodies(&mut dice);
    let asks = questions(&mut dice, &bodies, 20_011);
    let truth: Vec<bool> = asks.iter().map(|ask| ask.by(Algorithm::Enhanced)).collect();
    isa::on_every_one(|isa| assert!(asks.iter().map(Ask::overlaps).eq(truth.iter().copied()), "{isa:?}"));
    let hits = truth.iter().filter(|&&hit| hit).count();
    assert!((6_000..14_000).contains(&hits), "{hits} of 20011 overlap");
    for (ask, hit) in asks.iter().zip(truth).take(3000) {
        assert_eq!(ask.a.separating_axis(ask.b, &ask.b_from_a, 0.0, None).is_none(), hit);
    }
}

/// Pairs at 1e-16 to 1e-2 of their size from touching, on either side.
fn near_touch<'a>(dice: &mut Dice, bodies: &'a [Body], n: usize) -> Vec<Ask<'a>> {
    let mut one = || {
        let [a, b] = [0, 1].map(|_| &bodies[dice.below(bodies.len())]);
        let v = dice.direction();
        let (mut inside, mut outside) = (0.0, 1.01 * (a.circumradius() + b.circumradius()));
        for _ in 0..60 {
            let middle = 0.5 * (inside + outside);
            // Exact arithmetic would decide the last two again and again.
            if middle == inside || middle == outside {
                break;
            }
            *(if a.overlaps(b, &(v * middle)) { &mut inside } else { &mut outside }) = middle;
        }
        let off = dice.decade(-16.0, -2.0) * if dice.below(2) == 0 { 1.0 } else { -1.0 };
        Ask { a, b, b_from_a: v * (inside * (1.0 + off)) }
    };
    (0..n).map(|_| one()).collect()
}

fn assert_near_ones_are_exact(seed: u64, n: usize) {
    let mut dice = Dice::new(seed);
    let bodies = bodies(&mut dice);
    let asks = near_touch(&mut dice, &bodies, n);
    assert_all_are_exact(&asks);
}

#[test]
fn near_touching_bodies_get_the_exact_answer() {
    assert_near_ones_are_exact(9, 3_000);
}

/// The answers against exact arithmetic, on every instruction set.
fn assert_all_are_exact(asks: &[Ask<'_>]) {
    let exact: Vec<bool> = asks.iter().map(|ask| ask.by(Algorithm::Exact)).collect();
    isa::on_every_one(|isa| {
        for (i, (ask, exact)) in asks.iter().zip(&exact).enumerate() {
            assert_eq!(ask.overlaps(), *exact, "pair {i}, {isa:?}");
        }
    });
    let (hits, n) = (exact.iter().filter(|&&hit| hit).count(), asks.len());
    assert!((3 * n / 10..7 * n / 10).contains(&hits), "{hits} of {n} overlap");
}

/// Parallel plates and crumbs: the plates are hundreds of times as far across as the displacement at which they touch.
fn plates_and_crumbs(dice: &mut Dice, turn: &Rotation) -> Vec<Body> {
    let mut body = |i: usize| {
        let size = if i.is_multiple_of(2) { Vec3::new(1.0, 1.0, 0.003) } else { Vec3::repeat(0.004) };
        let points: Vec<Vec3> = dice.body(24, 1.0).iter().map(|p| turn * p.component_mul(&size)).collect();
        Body::new(&points).with_inside_of(&convex_hull(&points).unwrap())
    };
    (0..60).map(&mut body).collect()
}

/// Rounding counts by the size of both bodies, not by that of one or by their displacement.
#[test]
fn parallel_plates_get_the_exact_answer_within_the_rounding_of_their_size() {
    let mut dice = Dice::new(11);
    let turn = dice.rotation();
    let bodies = plates_and_crumbs(&mut dice, &turn);
    let mut one = || {
        let [a, b] = [0, 1].map(|_| &bodies[dice.below(bodies.len())]);
        let v = (turn * Vec3::z() + 1e-3 * dice.direction()).normalize();
        let (mut inside, mut outside) = (0.0, 0.1);
        for _ in 0..60 {
            let middle = 0.5 * (inside + outside);
            *(if a.overlaps(b, &(v * middle)) { &mut inside } else { &mut outside }) = middle;
        }
        let off = dice.decade(-17.0, -14.0) * if dice.below(2) == 0 { 1.0 } else { -1.0 };
        Ask { a, b, b_from_a: v * (inside + off) }
    };
    assert_all_are_exact(&(0..2_000).map(|_| one()).collect::<Vec<_>>());
}

/// The ray of the portal search passes a corner of A - B so closely that single precision cannot tell which of the faces
/// around it it meets: it comes to portals that are none in double precision.
#[test]
fn bodies_that_touch_in_a_corner_on_the_line_of_their_centres_get_the_exact_answer() {
    let mut dice = Dice::new(12);
    let points: Vec<Vec<Vec3>> = (0..60).map(|_| dice.body(24, 1.0)).collect();
    let laid_out = |points: &Vec<Vec3>| Body::new(points).with_inside_of(&convex_hull(points).unwrap());
    let bodies: Vec<Body> = points.iter().map(laid_out).collect();
    let farthest = |points: &[Vec3], v: &Vec3| *points.iter().max_by(|p, q| p.dot(v).total_cmp(&q.dot(v))).unwrap();
    let mut one = || {
        let [a, b] = [0, 1].map(|_| dice.below(bodies.len()));
        let v = dice.direction();
        let corner = farthest(&points[a], &v) - farthest(&points[b], &-v);
        let aside = dice.direction() * dice.decade(-9.0, -6.0);
        let off = dice.decade(-12.0, -6.0) * if dice.below(4) == 0 { 1.0 } else { -1.0 };
        Ask { a: &bodies[a], b: &bodies[b], b_from_a: corner * (1.0 + off) + aside }
    };
    assert_all_are_exact(&(0..10_000).map(|_| one()).collect::<Vec<_>>());
}

#[test]
#[ignore = "slow tier: 10^5 pairs of bodies against exact arithmetic"]
fn a_hundred_thousand_near_touching_bodies_get_the_exact_answer() {
    (100..110).for_each(|seed| assert_near_ones_are_exact(seed, 10_000));
}

/// Pairs of each seed, and of each place of touching at 1e-16 to 1e-2 of it: such a place is dear to find.
const PAIRS: usize = 100_000;
const VARIANTS: usize = 100;

fn varied<'a>(dice: &mut Dice, bodies: &'a [Body]) -> Vec<Ask<'a>> {
    let mut asks = Vec::with_capacity(PAIRS);
    for ask in near_touch(dice, bodies, PAIRS / VARIANTS) {
        let off = |dice: &mut Dice| dice.decade(-16.0, -2.0) * if dice.below(2) == 0 { 1.0 } else { -1.0 };
        asks.extend((0..VARIANTS).map(|_| Ask { b_from_a: ask.b_from_a * (1.0 + off(dice)), ..ask }));
    }
    asks
}

#[test]
#[ignore = "slow tier: 10^7 pairs of bodies at every instruction set, minutes of processor time"]
fn ten_million_pairs_of_bodies_get_the_answer_of_double_precision_at_every_instruction_set() {
    let seeds: Vec<u64> = (200..200 + crate::slow::pairs(10_000_000).div_ceil(PAIRS as u64)).collect();
    let mut hits = 0;
    // A choice of instructions holds for all threads, so they take the same one at the same time.
    for seeds in seeds.chunks(10) {
        let begun = seeds.iter().map(|&seed| {
            let mut dice = Dice::new(seed);
            let bodies = bodies(&mut dice);
            (dice, bodies)
        });
        let (dice, bodies): (Vec<Dice>, Vec<Vec<Body>>) = begun.unzip();
        let asks: Vec<_> =
            dice.into_par_iter().zip(&bodies).map(|(mut dice, bodies)| varied(&mut dice, bodies)).collect();
        // The search in double precision from the start, certified or exact, is compared by the other tests with
        // references.
        let in_f64 = |ask: &Ask<'_>| ask.by(Algorithm::Enhanced);
        let truth: Vec<Vec<bool>> = asks.par_iter().map(|asks| asks.iter().map(in_f64).collect()).collect();
        isa::on_every_one(|isa| {
            asks.par_iter().zip(&truth).zip(seeds).for_each(|((asks, truth), seed)| {
                assert!(asks.iter().map(Ask::overlaps).eq(truth.iter().copied()), "seed {seed}, {isa:?}");
            });
        });
        hits += truth.iter().flatten().filter(|&&hit| hit).count();
    }
    let pairs = PAIRS * seeds.len();
    assert!((3 * pairs / 10..7 * pairs / 10).contains(&hits), "{hits} of {pairs} overlap");
}

#[test]
fn a_gap_is_exceeded_or_not_to_the_last_bit() {
    let cube = [-1.0, 1.0].map(|x| [-1.0, 1.0].map(|y| [-1.0, 1.0].map(|z| Vec3::new(x, y, z))));
    let points: Vec<Vec3> = cube.into_iter().flatten().flatten().collect();
    let body = Body::new(&points).with_inside_of(&convex_hull(&points).unwrap());
    let is_clear = |x: f64| body.separating_axis(&body, &Vec3::new(0.1, x, -0.2), 0.25, None).is_some();
    let apart = [2.25, 2.25 + 4.0 * f64::EPSILON, 2.0, 9.0, 0.0].map(is_clear);
    assert_eq!(apart, [false, true, false, true, false]);
}
