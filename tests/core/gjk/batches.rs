//! Eight at a time, the answers are those of one at a time.

use super::families::Dice;
use meso_core::geometry::convex_hull;
use meso_core::gjk::{Ask, Body, apart, clear_many, overlap, overlap_many};
use meso_core::math::{Mat3, Vec3};

/// Bodies of every kind: with and without bounds, solid and flat, small and large.
fn bodies(dice: &mut Dice) -> Vec<Body> {
    let mut bodies = Vec::new();
    for i in 0..60 {
        let n = if i % 10 == 9 { 50 } else { 20 + dice.below(11) as usize };
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
        let [a, b] = [0, 1].map(|_| &bodies[dice.below(bodies.len() as u64) as usize]);
        let reach = a.circumradius() + b.circumradius();
        let x = dice.direction() * (1.05 * reach * dice.unit());
        Ask { a, b, b_from_a: if dice.below(20) == 0 { x.map(f64::round) } else { x } }
    };
    (0..n).map(|_| one()).collect()
}

#[test]
fn many_answers_are_the_single_ones() {
    let mut dice = Dice::new(7);
    let bodies = bodies(&mut dice);
    let asks = questions(&mut dice, &bodies, 20_011);
    let single: Vec<bool> = asks.iter().map(|q| overlap(q.a, q.b, &q.b_from_a)).collect();
    assert_eq!(overlap_many(&asks), single);
    let hits = single.iter().filter(|&&hit| hit).count();
    assert!((6_000..14_000).contains(&hits), "{hits} of 20011 overlap");
    for (ask, hit) in asks.iter().zip(single).take(3000) {
        assert_eq!(apart(ask.a, ask.b, &ask.b_from_a, 0.0, None).is_none(), hit);
    }
}

#[test]
fn an_attempt_is_clear_when_all_its_pairs_are_apart() {
    let mut dice = Dice::new(8);
    let bodies = bodies(&mut dice);
    let asks = questions(&mut dice, &bodies, 5_000);
    let mut ends = vec![0, 0];
    while *ends.last().unwrap() < 5_000 {
        ends.push((ends.last().unwrap() + dice.below(5) as u32).min(5_000));
    }
    let mut start = 0;
    for (i, clear) in clear_many(&asks, &ends).into_iter().enumerate() {
        let attempt = &asks[start..ends[i] as usize];
        assert_eq!(clear, attempt.iter().all(|q| !overlap(q.a, q.b, &q.b_from_a)), "attempt {i}");
        start = ends[i] as usize;
    }
}
