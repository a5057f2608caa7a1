//! Closest points, penetration depth and time of impact, against the Minkowski difference in whole numbers.

use super::dice::Dice;
use super::families;
use meso_collision::geometry::{Plane, convex_hull};
use meso_collision::gjk::{self, Impact, Penetration};
use meso_collision::math::Vec3;

type Points = Vec<Vec3>;

/// The faces of the hull of all differences, which whole numbers show exactly; `None` where it is flat.
fn difference(a: &[Vec3], b: &[Vec3]) -> Option<Vec<Plane>> {
    let all: Points = a.iter().flat_map(|p| b.iter().map(move |q| p - q)).collect();
    convex_hull(&all).ok().map(|hull| hull.planes().collect())
}

/// Two bodies of whole numbers, which often touch.
fn whole(dice: &mut Dice, apart: f64) -> (Points, Points) {
    let mut body = |n: usize| (0..4 + dice.below(n)).map(|_| dice.integers(6)).collect::<Points>();
    let (a, b) = (body(12), body(20));
    let by = (dice.direction() * (apart * dice.unit())).map(f64::round);
    (a, b.iter().map(|p| p + by).collect())
}

fn scaled(points: &[Vec3], power: i32) -> Points {
    points.iter().map(|p| p.map(|x| libm::scalbn(x, power))).collect()
}

#[test]
fn closest_points_lie_in_their_bodies_and_at_their_distance() {
    for (name, family) in families::ALL.iter().filter(|(name, _)| *name != "fine spheres") {
        for seed in 0..40 {
            let (a, b) = family(&mut Dice::new(7000 + seed));
            let [p, q] = gjk::closest_points(&a, &b).unwrap();
            let distance = gjk::distance(&a, &b).unwrap();
            let size = a.iter().chain(&b).map(Vec3::amax).fold(0.0, f64::max);
            let rounding = 4.0 * f64::EPSILON * size;
            assert!(((p - q).norm() - distance).abs() <= rounding, "{name} {seed}: {p} {q}, {distance:e}");
            for (point, body) in [(p, &a), (q, &b)] {
                assert!(gjk::distance(&[point], body).unwrap() <= rounding, "{name} {seed}: {point}");
            }
            assert!(distance > 0.0 || p == q, "{name} {seed}: one point is shared, {p} {q}");
        }
    }
}

#[test]
fn depths_of_whole_numbers_lie_between_their_bounds() {
    let (mut deep, mut apart, mut widest) = (0, 0, 0.0_f64);
    for seed in 0..600 {
        let mut dice = Dice::new(8000 + seed);
        let (a, b) = whole(&mut dice, 14.0);
        let Some(faces) = difference(&a, &b) else { continue };
        let truth = faces.iter().map(|face| face.offset).fold(f64::INFINITY, f64::min);
        for power in [0, -1070, 1000] {
            let length = libm::scalbn(1.0, power);
            let found = Penetration::of(&scaled(&a, power), &scaled(&b, power)).unwrap();
            let Some(Penetration { depth, at_least, direction }) = found else {
                assert!(truth < 1e-12, "seed {seed}, 2^{power}: {truth}");
                continue;
            };
            let (depth, at_least) = (depth / length, at_least / length);
            // A unit in the last place of a subnormal depth is large.
            let grain = if power < 0 { 0.5 } else { 1e-13 };
            assert!(
                truth >= -1e-14 && at_least <= truth + grain && truth <= depth + grain,
                "seed {seed}: {found:?} {truth}"
            );
            assert!(depth - at_least <= 4.0 * grain + 1e-12, "seed {seed}, 2^{power}: {at_least} to {depth}");
            assert!((direction.norm() - 1.0).abs() < 1e-12);
            if power == 0 {
                widest = widest.max(depth - at_least);
                assert!(at_least <= truth * (1.0 + 1e-15) && truth <= depth * (1.0 + 1e-15));
                let moved = |by: f64| b.iter().map(|p| p + direction * by).collect::<Points>();
                assert!(!gjk::intersects(&a, &moved(depth + 1e-12)).unwrap(), "seed {seed}");
                assert!(at_least < 1e-9 || gjk::intersects(&a, &moved(0.999 * at_least)).unwrap(), "seed {seed}");
            }
        }
        *(if truth > 0.0 { &mut deep } else { &mut apart }) += 1;
    }
    assert!(deep > 150 && apart > 150, "{deep} overlap, {apart} do not");
    assert!(widest < 2e-13, "{widest:e}");
}

#[test]
fn depths_of_grains_are_known_to_a_rounding_of_their_size() {
    for seed in 0..200 {
        let mut dice = Dice::new(8800 + seed);
        let (a, b) = (dice.body(24, 1.0), dice.body(28, 1.0));
        let by = dice.direction() * dice.unit() + Vec3::repeat(if seed % 2 == 0 { 0.0 } else { 40.0 });
        let (a, b): (Points, Points) = if seed % 2 == 0 {
            (a, b.iter().map(|p| p + by).collect())
        } else {
            (a.iter().map(|p| p + by).collect(), b.iter().map(|p| p + by * 0.99).collect())
        };
        let truth = difference(&a, &b).unwrap().iter().map(|face| face.offset).fold(f64::INFINITY, f64::min);
        let Some(found) = Penetration::of(&a, &b).unwrap() else {
            assert!(truth < 1e-13);
            continue;
        };
        // The differences of the reference are rounded, too.
        assert!(found.at_least <= truth + 1e-14 && truth - 1e-14 <= found.depth, "seed {seed}: {found:?}, {truth}");
        assert!(found.depth - found.at_least < 2e-13, "seed {seed}: {found:?}");
    }
}

#[test]
fn bodies_that_touch_or_are_flat_have_no_depth() {
    let square = [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0], [2.0, 2.0]].map(|[x, y]| Vec3::new(x, y, 1.0));
    let inside = square.map(|p| p * 0.5 + Vec3::new(0.3, 0.2, 0.5));
    let point = [Vec3::new(2.0, 2.0, 1.0)];
    for (a, b) in [(&square[..], &inside[..]), (&square[..], &point[..]), (&point[..], &point[..])] {
        let found = Penetration::of(a, b).unwrap().expect("they share a point");
        assert!(found.at_least == 0.0 && found.depth < 1e-14, "{found:?}");
    }
    assert_eq!(Penetration::of(&square, &[Vec3::new(2.5, 2.0, 1.0)]), Ok(None));
}

#[test]
fn numbers_that_no_scale_brings_together_have_a_depth_too() {
    let [low, high] = [-f64::MAX, f64::MAX].map(|x| Vec3::new(x, 0.0, 5e-324));
    let found = Penetration::of(&[low, high], &[Vec3::zeros(), Vec3::new(0.0, 0.0, 5e-324)]).unwrap().unwrap();
    assert!(found.at_least <= 5e-324 && found.depth >= 0.0, "{found:?}");
}

/// The share of the motion after which B first meets A, by the faces of A - B; infinity for never.
fn first_meeting(faces: &[Plane], motion: &Vec3) -> f64 {
    let (mut enters, mut leaves) = (0.0_f64, f64::INFINITY);
    for Plane { normal, offset } in faces {
        // Bodies of whole numbers: speeds within rounding are 0.
        let speed = normal.dot(motion);
        if speed.abs() < 1e-12 {
            leaves = if *offset < -1e-12 { f64::NEG_INFINITY } else { leaves };
        } else if speed < 0.0 {
            enters = enters.max(offset / speed);
        } else {
            leaves = leaves.min(offset / speed);
        }
    }
    if enters <= leaves { enters } else { f64::INFINITY }
}

#[test]
fn moving_bodies_meet_when_their_minkowski_difference_says() {
    let (mut hits, mut misses) = (0, 0);
    for seed in 0..800 {
        let mut dice = Dice::new(9000 + seed);
        let (a, b) = whole(&mut dice, 30.0);
        let motion = dice.integers(30);
        let Some(faces) = difference(&a, &b) else { continue };
        let truth = first_meeting(&faces, &motion);
        for power in [0, -1000, 900] {
            let by = scaled(&[motion], power)[0];
            let found = Impact::of(&scaled(&a, power), &scaled(&b, power), &by).unwrap();
            let Some(found) = found else {
                assert!(truth > 1.0 - 1e-12, "seed {seed}, 2^{power}: at {truth}");
                continue;
            };
            assert!(found.not_before <= truth + 1e-15, "seed {seed}, 2^{power}: {found:?}, {truth}");
            // Rounding may hide a meeting of surfaces only, and lets them part that touch for a moment.
            let Some(by) = found.by else { continue };
            assert!(truth <= by + 1e-15 || by - found.not_before < 1e-12, "seed {seed}: {found:?}, {truth}");
            assert!(by - found.not_before < 1e-11, "seed {seed}: {found:?}");
            if power == 0 {
                let there: Points = b.iter().map(|p| p + motion * by).collect();
                assert!(gjk::distance(&a, &there).unwrap() < 1e-13, "seed {seed}: {found:?}");
            }
        }
        *(if truth <= 1.0 { &mut hits } else { &mut misses }) += 1;
    }
    assert!(hits > 200 && misses > 200, "{hits} hit, {misses} do not");
}

#[test]
fn bodies_that_slide_along_each_other_or_stand_still_meet_as_they_should() {
    let cube = |x: f64, y: f64| {
        [0, 1, 2, 3, 4, 5, 6, 7].map(|i| Vec3::new(x + f64::from(i & 1), y + f64::from(i >> 1 & 1), f64::from(i >> 2)))
    };
    let meets = |x: f64, y: f64, motion: Vec3| Impact::of(&cube(0.0, 0.0), &cube(x, y), &motion).unwrap();
    // Faces in one plane touch when the edges arrive.
    let found = meets(3.0, 1.0, Vec3::new(-4.0, 0.0, 0.0)).unwrap();
    assert!(found.not_before <= 0.5 && found.by.is_none_or(|by| by - found.not_before < 1e-14), "{found:?}");
    assert_eq!(meets(3.0, 1.0 + 1e-9, Vec3::new(-4.0, 0.0, 0.0)), None);
    assert_eq!(meets(3.0, 0.0, Vec3::zeros()), None);
    let touching = meets(1.0, 0.0, Vec3::zeros()).unwrap();
    assert_eq!((touching.not_before, touching.by), (0.0, Some(0.0)));
    assert_eq!(meets(2.0, 0.0, Vec3::new(1.0, 5.0, 0.0)), None);
    assert!(Impact::of(&cube(0.0, 0.0), &cube(2.0, 0.0), &Vec3::repeat(f64::NAN)).is_err());
}

/// Found by a user's script: from a motion of 1e16 sizes on, `by` was `None` for a cube that flies right through.
#[test]
fn a_motion_far_beyond_the_bodies_size_is_timed_to_their_rounding() {
    let cube = |x: f64| {
        [0, 1, 2, 3, 4, 5, 6, 7].map(|i| Vec3::new(x + f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
    };
    for exponent in [0, 3, 10, 16, 20, 50] {
        let motion = -8.0 * libm::pow(10.0, f64::from(exponent));
        let found = Impact::of(&cube(0.0), &cube(5.0), &Vec3::new(motion, 0.0, 0.0)).unwrap().unwrap();
        let [first, last] = [found.not_before, found.by.unwrap()].map(|time| -time * motion);
        assert!(first <= 4.0 && 4.0 <= last && last - first < 1e-13, "1e{exponent}: {first} to {last}");
    }
}

/// Whether B, displaced by `motion` times `time`, shares a point with A, in integers: bodies of whole numbers, by the normals
/// of all planes that the faces of A - B can have.
fn share_a_point(a: &[Vec3], b: &[Vec3], motion: &Vec3, time: f64) -> bool {
    let whole = |p: &Vec3| [p.x, p.y, p.z].map(|k| k as i128);
    let (a, b, motion): (Vec<_>, Vec<_>, _) =
        (a.iter().map(whole).collect(), b.iter().map(whole).collect(), whole(motion));
    const POWER: u32 = 64;
    let time = (time * libm::exp2(f64::from(POWER))) as i128;
    let minus = |p: &[i128; 3], q: &[i128; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    let sides = |body: &[[i128; 3]]| -> Vec<[i128; 3]> {
        body.iter().enumerate().flat_map(|(i, p)| body[..i].iter().map(move |q| minus(p, q))).collect()
    };
    let sides = [sides(&a), sides(&b)].concat();
    let dot = |p: &[i128; 3], q: &[i128; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let cross = |p: &[i128; 3], q: &[i128; 3]| {
        [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
    };
    sides.iter().enumerate().all(|(i, p)| {
        sides[..i].iter().map(|q| cross(p, q)).all(|n| {
            let range = |body: &[[i128; 3]]| {
                let heights = body.iter().map(|p| dot(p, &n));
                (heights.clone().min().unwrap(), heights.max().unwrap())
            };
            let ((low_a, high_a), (low_b, high_b), by) = (range(&a), range(&b), dot(&motion, &n) * time);
            ((low_b - high_a) << POWER) + by <= 0 && ((high_b - low_a) << POWER) + by >= 0
        })
    })
}

/// The case `toi.py`: in 11 of 1,751 pairs `by` was up to 8e-17 before the true time.
#[test]
fn time_of_impact_is_bounded_from_above_in_rational_arithmetic() {
    let cube = |y: f64| {
        [0, 1, 2, 3, 4, 5, 6, 7].map(|i| {
            Vec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * 16.0 + Vec3::new(0.0, y, 0.0)
        })
    };
    // Eight times the numbers of the case: 0.875 apart, 10 a unit of time.
    let (a, b, motion) = (cube(0.0), cube(23.0), Vec3::new(0.0, -80.0, 0.0));
    let by = Impact::of(&a, &b, &motion).unwrap().unwrap().by.unwrap();
    assert!(share_a_point(&a, &b, &motion, by) && !share_a_point(&a, &b, &motion, 0.0875) && by - 0.0875 < 1e-15);
    let mut dice = Dice::new(12_000);
    let mut pairs = 0;
    while pairs < 1751 {
        let mut body = || (0..4 + dice.below(3)).map(|_| dice.integers(6)).collect::<Points>();
        let (a, b) = (body(), body());
        let shift = dice.integers(20);
        let (b, motion): (Points, _) = (b.iter().map(|p| p + shift).collect(), dice.integers(6) - shift);
        let Ok(Some(Impact { not_before, by: Some(by), .. })) = Impact::of(&a, &b, &motion) else { continue };
        if difference(&a, &b).is_some() && (by == 0.0 || by > 1e-3) {
            assert!(share_a_point(&a, &b, &motion, by), "{a:?} {b:?} {motion:?}: not by {by}");
            assert!(not_before == 0.0 || !share_a_point(&a, &b, &motion, not_before.next_down()), "{not_before}");
            pairs += 1;
        }
    }
}
