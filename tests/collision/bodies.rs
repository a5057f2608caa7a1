//! The form for packing: bodies in their own frames and a displacement between them.

use super::dice::Dice;
use meso_collision::geometry::convex_hull;
use meso_collision::gjk::Counters;
use meso_collision::gjk::{self, Body, Support};
use meso_collision::math::{Mat3, Vec3};

/// Two bodies on ellipsoids and a displacement at which they may or may not overlap.
fn pair(dice: &mut Dice) -> ([Vec<Vec3>; 2], Vec3) {
    let sizes = [0, 1].map(|_| 20 + dice.below(30));
    let bodies = sizes.map(|n| dice.body(n, 5.0));
    (bodies, dice.direction() * (12.0 * dice.unit()))
}

fn placed(points: &[Vec3], x: &Vec3) -> Vec<Vec3> {
    points.iter().map(|p| p + x).collect()
}

#[test]
fn bodies_overlap_as_their_points_do_and_the_hit_rate_is_fair() {
    let mut hits = 0;
    for seed in 0..2000 {
        let ([a, b], mut x) = pair(&mut Dice::new(seed));
        // Short in binary, so that adding it to the points rounds nothing away that matters: |answers| must agree.
        x = x.map(|v| (v * 1024.0).round() / 1024.0);
        let [a, b] = [a, b].map(|s| s.iter().map(|p| p.map(|v| (v * 1e6).round() / 1048576.0)).collect::<Vec<_>>());
        let truth = gjk::intersects(&a, &placed(&b, &x)).unwrap();
        let axes = Vec3::new(5.0, 5.0, 5.0);
        let plain = [&a, &b].map(|s| Body::new(s));
        let bounded = [&a, &b].map(|s| Body::on_ellipsoid(s, &axes, &Mat3::identity()));
        for [a, b] in [&plain, &bounded] {
            assert_eq!(a.overlaps(b, &x), truth, "seed {seed}");
            assert_eq!(a.separating_axis(b, &x, 0.0, None).is_none(), truth, "seed {seed}");
        }
        hits += u32::from(truth);
    }
    assert!((600..1400).contains(&hits), "{hits} of 2000 overlap");
}

#[test]
fn bodies_nearer_than_the_gap_or_beyond_it_need_no_exact_arithmetic() {
    let (mut counters, mut nearer) = (Counters::default(), 0);
    for seed in 0..1000 {
        let ([a, b], x) = pair(&mut Dice::new(seed));
        let distance = gjk::distance(&a, &placed(&b, &x)).unwrap();
        let (a, b) = (Body::new(&a), Body::new(&b));
        for gap in [0.5 * distance, 1.5 * distance, distance + 1.0] {
            let axis = counters.apart(&a, &b, &x, gap, None);
            assert_eq!(axis.is_some(), gap < distance, "seed {seed}");
            nearer += u32::from(axis.is_none() && distance > 0.0);
        }
    }
    assert_eq!(counters.exact_calls, 0);
    assert!(nearer > 500, "{nearer}");
}

#[test]
fn an_axis_is_found_exactly_when_the_distance_exceeds_the_gap() {
    for seed in 0..500 {
        let ([a, b], x) = pair(&mut Dice::new(seed));
        let distance = gjk::distance(&a, &placed(&b, &x)).unwrap();
        let (body_a, body_b) = (Body::new(&a), Body::new(&b));
        for factor in [0.0, 0.5, 1.0 - 1e-9, 1.0 + 1e-9, 2.0] {
            let gap = distance * factor;
            let axis = body_a.separating_axis(&body_b, &x, gap, None);
            assert_eq!(axis.is_some(), factor < 1.0 && distance > 0.0, "seed {seed}, gap {gap} of {distance}");
            if let Some(axis) = axis {
                assert!((axis.norm() - 1.0).abs() < 1e-15);
                let top = a.iter().map(|p| p.dot(&axis)).fold(f64::NEG_INFINITY, f64::max);
                let bottom = placed(&b, &x).iter().map(|p| p.dot(&axis)).fold(f64::INFINITY, f64::min);
                assert!(bottom - top > gap, "seed {seed}: {} for {gap}", bottom - top);
                assert!(body_a.separating_axis(&body_b, &x, gap, Some(axis)).is_some());
            }
        }
    }
}

#[test]
fn a_body_that_does_not_hold_its_frames_origin_is_not_taken_to() {
    let cube = |at: f64| -> Vec<Vec3> {
        let corners = (0..8).map(|i| Vec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)));
        corners.map(|p| p - Vec3::repeat(0.5) + at * Vec3::x()).collect()
    };
    let (left, right, middle) = (Body::new(&cube(-5.0)), Body::new(&cube(5.0)), cube(0.0));
    let middle = Body::new(&middle).with_inside_of(&convex_hull(&middle).unwrap());
    assert_eq!((left.inradius(), middle.inradius() > 0.4), (0.0, true));
    let zero = Vec3::zeros();
    for (a, b) in [(&left, &right), (&right, &middle), (&middle, &left)] {
        assert!(!a.overlaps(b, &zero));
        assert!(!a.overlaps(b, &Vec3::new(0.1, 0.0, 0.0)));
        assert!(a.separating_axis(b, &zero, 3.0, None).is_some());
    }
    assert!(left.overlaps(&right, &Vec3::new(-9.5, 0.0, 0.0)));
}

#[test]
fn a_remembered_axis_saves_the_search() {
    let ([a, b], _) = pair(&mut Dice::new(1));
    let (a, b) = (Body::new(&a), Body::new(&b));
    let x = Vec3::new(9.7, 1.5, 0.0);
    let axis = a.separating_axis(&b, &x, 0.0, None).expect("far enough apart");
    let mut counters = Counters::default();
    assert!(counters.apart(&a, &b, &x, 0.0, Some(axis)).is_some());
    assert_eq!((counters.pairs, counters.gjk_calls, counters.exact_calls), (1, 0, 0));
}

#[test]
fn a_body_keeps_its_points_in_1216_bytes() {
    let points = Dice::new(3).body(32, 1.0);
    let body = Body::new(&points);
    assert!((0..32).all(|i| body.point(i) == points[i]));
    assert_eq!(size_of::<Body>(), 1216);
}
