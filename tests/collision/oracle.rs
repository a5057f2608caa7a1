//! parry as an independent witness, outside its tolerance.

use super::dice::Dice;
use meso_collision::gjk;
use meso_collision::math::Vec3;
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query;
use parry3d_f64::shape::ConvexPolyhedron;

#[test]
fn parry_agrees_on_ten_thousand_pairs_outside_its_tolerance() {
    let mut dice = Dice::new(2025);
    let (mut hits, mut asked) = (0, 0);
    while asked < 10_000 {
        let sizes = [0, 1].map(|_| 20 + dice.below(11));
        let radii = [0, 1].map(|_| 2.5 + 7.5 * dice.unit());
        let [a, b] = [0, 1].map(|i| dice.body(sizes[i], radii[i]));
        let x = dice.direction() * (16.0 * dice.unit());
        let shapes = [&a, &b].map(|s| ConvexPolyhedron::from_convex_hull(&points(s)).expect("a solid"));
        let at = Pose::translation(x.x, x.y, x.z);
        let placed: Vec<Vec3> = b.iter().map(|p| p + x).collect();
        let answer = gjk::intersects(&a, &placed).unwrap();
        // Its band: the answer must not hang on a millionth of the size either way.
        let [closer, farther] =
            [0.999_999, 1.000_001].map(|f| gjk::intersects(&a, &b.iter().map(|p| p + x * f).collect::<Vec<_>>()));
        if closer != farther {
            continue;
        }
        let theirs = query::intersection_test(&Pose::IDENTITY, &shapes[0], &at, &shapes[1]).unwrap().intersecting;
        assert_eq!(answer, theirs, "a = {a:?}\nb = {placed:?}");
        if !answer && asked % 10 == 0 {
            let theirs = query::distance(&Pose::IDENTITY, &shapes[0], &at, &shapes[1]).unwrap().distance;
            let distance = gjk::distance(&a, &placed).unwrap();
            assert!((distance - theirs).abs() < 1e-6, "{distance} against {theirs}");
        }
        asked += 1;
        hits += u32::from(answer);
    }
    assert!((3_000..7_000).contains(&hits), "{hits} of 10000 overlap: the sample is lopsided");
}

fn points(body: &[Vec3]) -> Vec<Vector> {
    body.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect()
}
