//! Bodies that are laid out once answer as plain points do, wherever they lie.

use super::dice::Dice;
use super::families;
use super::isa;
use meso_collision::gjk::{self, Algorithm, Bodies, GjkError, Operand};
use meso_collision::math::Vec3;

type Points = Vec<Vec3>;

fn slices(bodies: &[Points]) -> impl Iterator<Item = &[Vec3]> {
    bodies.iter().map(Vec::as_slice)
}

#[test]
fn bodies_of_every_family_answer_as_their_points_do() {
    for (name, family) in families::ALL.iter().filter(|(name, _)| *name != "fine spheres") {
        let (a, b): (Vec<Points>, Vec<Points>) = (0..60).map(|seed| family(&mut Dice::new(6000 + seed))).unzip();
        let truth: Vec<bool> = a.iter().zip(&b).map(|(a, b)| Algorithm::Exact.intersects(a, b).unwrap()).collect();
        let (own, others) = (Bodies::new(slices(&a)).unwrap(), Bodies::new(slices(&b)).unwrap());
        let pairs: Vec<_> = (0..60).map(|i| (i, i, Vec3::zeros())).collect();
        isa::on_every_one(|isa| assert_eq!(own.overlap(&others, &pairs).unwrap(), truth, "{name}, {isa:?}"));
    }
}

/// Grains about places up to `away` from the origin, and pairs of them with shifts that bring them to 1e-16 to 1e-2 of
/// touching.
fn near_touch(dice: &mut Dice, away: f64, n: usize) -> (Vec<Points>, Vec<(u32, u32, Vec3)>) {
    let grains: Vec<Points> = (0..20)
        .map(|_| {
            let at = dice.vector() * away;
            let size = 1.0 + 4.0 * dice.unit();
            dice.body(24, size).iter().map(|p| p + at).collect()
        })
        .collect();
    let pair = |dice: &mut Dice| {
        let [i, j] = [0, 1].map(|_| dice.below(20) as u32);
        let (a, b) = (&grains[i as usize], &grains[j as usize]);
        let middle = |points: &Points| points.iter().sum::<Vec3>() / points.len() as f64;
        let (v, home) = (dice.direction(), middle(a) - middle(b));
        let (mut inside, mut outside) = (0.0, 12.0);
        for _ in 0..40 {
            let far = 0.5 * (inside + outside);
            let there: Points = b.iter().map(|p| p + (home + v * far)).collect();
            *(if gjk::intersects(a, &there).unwrap() { &mut inside } else { &mut outside }) = far;
        }
        let off = dice.decade(-16.0, -2.0) * dice.signed();
        (i, j, home + v * (inside * (1.0 + off)))
    };
    let pairs = (0..n).map(|_| pair(dice)).collect();
    (grains, pairs)
}

/// Whether A and B + shift share a point: both scaled so that all sums are whole, hence exact.
fn exactly(a: &Points, b: &Points, shift: &Vec3) -> bool {
    let whole = |p: &Vec3| p.map(|x| libm::rint(libm::scalbn(x, 40)));
    let (a, b): (Points, Points) = (a.iter().map(whole).collect(), b.iter().map(|p| whole(p) + whole(shift)).collect());
    Algorithm::Exact.intersects(&a, &b).unwrap()
}

#[test]
fn displaced_bodies_get_the_exact_answer_near_touching_at_every_instruction_set() {
    for away in [0.0, 100.0, 1000.0] {
        let (grains, pairs) = near_touch(&mut Dice::new(61), away, 400);
        // On a grid of 2^-40, so that the reference's sums are exact.
        let on_grid = |p: &Vec3| p.map(|x| libm::scalbn(libm::rint(libm::scalbn(x, 40)), -40));
        let grains: Vec<Points> = grains.iter().map(|grain| grain.iter().map(on_grid).collect()).collect();
        let pairs: Vec<_> = pairs.iter().map(|(i, j, shift)| (*i, *j, on_grid(shift))).collect();
        let bodies = Bodies::new(slices(&grains)).unwrap();
        let truth: Vec<bool> =
            pairs.iter().map(|(i, j, shift)| exactly(&grains[*i as usize], &grains[*j as usize], shift)).collect();
        isa::on_every_one(|isa| assert_eq!(bodies.overlap(&bodies, &pairs).unwrap(), truth, "{away} away, {isa:?}"));
        let hits = truth.iter().filter(|hit| **hit).count();
        assert!((120..280).contains(&hits), "{hits} of 400 overlap");
    }
}

#[test]
fn all_overlapping_pairs_are_found() {
    let mut dice = Dice::new(62);
    let grains: Vec<Points> = (0..80)
        .map(|_| {
            let at = dice.vector() * 6.0;
            dice.body(12, 1.5).iter().map(|p| p + at).collect()
        })
        .collect();
    let mut truth = Vec::new();
    for i in 0..80 {
        truth.extend(
            (i + 1..80).filter(|&j| gjk::intersects(&grains[i], &grains[j]).unwrap()).map(|j| [i as u32, j as u32]),
        );
    }
    assert_eq!(Bodies::new(slices(&grains)).unwrap().overlapping(), truth);
    assert!((50..1500).contains(&truth.len()), "{}", truth.len());
}

#[test]
fn a_place_is_clear_when_every_body_is_farther_than_the_gap() {
    let mut dice = Dice::new(63);
    let grains: Vec<Points> = (0..30)
        .map(|_| {
            let at = dice.vector() * 8.0;
            dice.body(14, 1.0).iter().map(|p| p + at).collect()
        })
        .collect();
    let (bodies, own) = (Bodies::new(slices(&grains)).unwrap(), dice.body(20, 1.2));
    let shifts: Points = (0..300).map(|_| dice.vector() * 6.0).collect();
    let one = Bodies::new([own.as_slice()]).unwrap();
    for gap in [0.0, 0.4] {
        let clear = bodies.clear(&one, 0, &shifts, gap).unwrap();
        for (shift, clear) in shifts.iter().zip(&clear) {
            let there: Points = own.iter().map(|p| p + shift).collect();
            let far = grains.iter().all(|grain| gjk::distance(grain, &there).unwrap() > gap);
            assert_eq!(*clear, far, "{shift}, gap {gap}");
        }
        let count = clear.iter().filter(|clear| **clear).count();
        assert!((30..280).contains(&count), "{count} of 300 are clear");
    }
}

#[test]
fn numbers_of_any_magnitude_make_bodies() {
    for power in [-1074, -300, 300, 1000] {
        let at = |x: f64| {
            [0, 1, 2, 3, 4, 5, 6, 7].map(|i| {
                Vec3::new(x + f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2))
                    .map(|v| libm::scalbn(v, power))
            })
        };
        let bodies = Bodies::new([&at(0.0)[..], &at(1.0), &at(3.0)]).unwrap();
        assert_eq!(bodies.overlapping(), [[0, 1]], "2^{power}");
        let shift = Vec3::new(libm::scalbn(-1.0, power), 0.0, 0.0);
        assert_eq!(
            bodies.overlap(&bodies, &[(1, 2, shift), (1, 2, Vec3::zeros())]),
            Ok(vec![true, false]),
            "2^{power}"
        );
        assert_eq!(bodies.clear(&bodies, 2, &[shift, -2.0 * shift], 0.0), Ok(vec![false, true]), "2^{power}");
    }
}

#[test]
fn empty_bodies_and_infinite_shifts_are_named() {
    let point = [Vec3::zeros()];
    assert_eq!(Bodies::new([&point[..], &[]]).unwrap_err(), GjkError::Empty { body: Operand::Many(1) });
    let bodies = Bodies::new([&point[..]]).unwrap();
    let error = bodies.overlap(&bodies, &[(0, 0, Vec3::zeros()), (0, 0, Vec3::repeat(f64::INFINITY))]).unwrap_err();
    assert_eq!(error.to_string(), "shifts: point 1 has the coordinate inf; coordinates must be finite");
}
