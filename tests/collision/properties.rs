//! Overlaps, distances, hulls and offsets of drawn bodies against the references in integers.

use super::erosion::Planes;
use super::property::{Share, holds};
use super::reference;
use meso_collision::geometry::{Polyhedron, convex_hull};
use meso_collision::gjk::{self, Algorithm};
use meso_collision::math::Vec3;
use proptest::array::uniform3;
use proptest::collection::vec;
use proptest::prelude::*;
use std::collections::BTreeSet;

type Points = Vec<Vec3>;

/// Fine coordinates are multiples of this up to 1024, so that moving them by whole numbers below 2^30 rounds nothing.
const GRID: f64 = 1.0 / 1024.0;

/// A point of whole coordinates up to `reach`; it shrinks to the origin.
fn whole_point(reach: i32) -> impl Strategy<Value = Vec3> {
    uniform3(-reach..=reach).prop_map(|p| Vec3::from(p.map(f64::from)))
}

/// Points of a small lattice, which repeat, line up and touch.
fn lattice(most: usize) -> impl Strategy<Value = Points> {
    vec(whole_point(3), 1..=most)
}

/// Points of a fine grid, which hardly ever do.
fn fine(most: usize) -> impl Strategy<Value = Points> {
    vec(whole_point(1 << 20).prop_map(|p| p * GRID), 1..=most)
}

fn body(most: usize) -> impl Strategy<Value = Points> {
    prop_oneof![2 => lattice(most), 1 => fine(most)]
}

fn pair(most: usize) -> impl Strategy<Value = (Points, Points)> {
    let lattices = (lattice(most), lattice(most), whole_point(2)).prop_map(|(a, b, by)| (a, moved(&b, &by)));
    prop_oneof![2 => lattices, 1 => (fine(most), fine(most))]
}

fn moved(points: &[Vec3], by: &Vec3) -> Points {
    points.iter().map(|p| p + by).collect()
}

fn scaled(points: &[Vec3], power: i32) -> Points {
    points.iter().map(|p| p.map(|x| libm::scalbn(x, power))).collect()
}

/// The longest distance from the first point, as docs/measured/accuracy.md measures a pair.
fn size(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().chain(b).map(|p| (p - a[0]).norm()).fold(0.0, f64::max)
}

#[test]
fn every_search_gives_the_exact_answer_whichever_body_comes_first() {
    let overlaps = Share::default();
    holds(3000, &pair(8), |(a, b)| {
        let truth = reference::intersects(&a, &b);
        for method in Algorithm::ALL {
            prop_assert_eq!(method.intersects(&a, &b), Ok(truth), "{:?}", method);
            prop_assert_eq!(method.intersects(&b, &a), Ok(truth), "{:?}, swapped", method);
        }
        overlaps.count(truth);
        Ok(())
    });
    assert!((0.3..0.7).contains(&overlaps.get()), "{} of the pairs overlap", overlaps.get());
}

#[test]
fn exact_moves_keep_answers_and_powers_of_two_scale_distances_to_the_last_bit() {
    holds(2000, &(pair(8), whole_point(1 << 20), -60..=60), |((a, b), by, power)| {
        let (answer, distance) = (gjk::intersects(&a, &b)?, gjk::distance(&a, &b)?);
        let (a_there, b_there) = (moved(&a, &by), moved(&b, &by));
        prop_assert_eq!(gjk::intersects(&a_there, &b_there)?, answer);
        prop_assert!((gjk::distance(&a_there, &b_there)? - distance).abs() <= 8e-16 * size(&a, &b));
        let (a_scaled, b_scaled) = (scaled(&a, power), scaled(&b, power));
        prop_assert_eq!(gjk::intersects(&a_scaled, &b_scaled)?, answer);
        prop_assert_eq!(gjk::distance(&a_scaled, &b_scaled)?, libm::scalbn(distance, power));
        Ok(())
    });
}

#[test]
fn a_distance_is_the_exact_one_zero_on_contact_alone_and_no_longer_than_between_two_points() {
    holds(1000, &pair(4), |(a, b)| {
        let distance = gjk::distance(&a, &b)?;
        let truth = if reference::intersects(&a, &b) { 0.0 } else { reference::distance_of_disjoint(&a, &b) };
        prop_assert_eq!(distance == 0.0, truth == 0.0, "{} for {}", distance, truth);
        let rounding = 4e-16 * size(&a, &b);
        prop_assert!((distance - truth).abs() <= rounding, "{} for {}", distance, truth);
        for p in &a {
            prop_assert!(b.iter().all(|q| distance <= (p - q).norm() + rounding), "{} from {}", distance, p);
        }
        Ok(())
    });
}

#[test]
fn the_vertices_of_a_hull_are_the_extreme_points_and_it_holds_all_others() {
    let solid = Share::default();
    holds(2000, &body(9), |points| {
        let hull = convex_hull(&points).ok();
        prop_assert_eq!(hull.is_none(), is_flat(&points));
        solid.count(hull.is_some());
        let Some(hull) = hull else { return Ok(()) };
        for (i, p) in points.iter().enumerate() {
            let others: Points = points.iter().copied().filter(|q| q != p).collect();
            let is_vertex = hull.vertices().contains(p);
            prop_assert_eq!(is_vertex, !reference::intersects(&[*p], &others), "point {}", i);
            prop_assert!(hull.contains(p), "point {} is outside", i);
        }
        Ok(())
    });
    assert!((0.3..0.9).contains(&solid.get()), "{} of the sets are solid", solid.get());
}

/// Whether all points lie in one plane: every tetrahedron with the first of them has no volume.
fn is_flat(points: &[Vec3]) -> bool {
    let arms: Vec<[i128; 3]> = points.iter().map(|p| on_grid(&(p - points[0])).map(i128::from)).collect();
    let volume = |[a, b, c]: [&[i128; 3]; 3]| -> i128 {
        (0..3).map(|k| a[k] * (b[(k + 1) % 3] * c[(k + 2) % 3] - b[(k + 2) % 3] * c[(k + 1) % 3])).sum()
    };
    arms.iter().all(|a| arms.iter().all(|b| arms.iter().all(|c| volume([a, b, c]) == 0)))
}

#[test]
fn a_hull_has_the_same_faces_for_any_order_of_its_points() {
    holds(2000, &(body(12), vec(any::<u8>(), 12)), |(points, keys)| {
        let mut shuffled: Vec<(u8, Vec3)> = keys.into_iter().zip(points.clone()).collect();
        shuffled.sort_by_key(|(key, _)| *key);
        let shuffled: Points = shuffled.into_iter().map(|(_, p)| p).collect();
        let [faces, again] = [points, shuffled].map(|points| convex_hull(&points).map(|hull| faces(&hull)));
        prop_assert_eq!(faces, again);
        Ok(())
    });
}

fn on_grid(p: &Vec3) -> [i64; 3] {
    <[f64; 3]>::from(p / GRID).map(|x| x as i64)
}

/// Every face as the set of its corners.
fn faces(hull: &Polyhedron) -> BTreeSet<BTreeSet<[i64; 3]>> {
    let corner = |i: u32| on_grid(&hull.vertices()[i as usize]);
    hull.faces().map(|face| face.iter().map(corner).collect()).collect()
}

#[test]
fn an_offset_is_the_body_within_all_planes_moved_inwards_and_has_its_vertices_on_three_of_them() {
    let left = Share::default();
    holds(400, &(vec(whole_point(4), 4..=7), 0..=24_u8), |(points, thickness)| {
        let Ok(body) = convex_hull(&points) else { return Ok(()) };
        let thickness = f64::from(thickness) / 16.0;
        let expected = Planes::of(&body).eroded_volume(thickness);
        let core = body.inward_offset(thickness)?;
        prop_assert_eq!(core.is_none(), expected == 0.0, "{} mm3 are left", expected);
        left.count(core.is_some());
        let Some(core) = core else { return Ok(()) };
        prop_assert!(thickness > 0.0 || core == body);
        prop_assert!((core.volume() / expected - 1.0).abs() <= 1e-9, "{} for {}", core.volume(), expected);
        for vertex in core.vertices() {
            let heights = || body.planes().map(|plane| plane.height(vertex) + thickness);
            prop_assert!(heights().all(|height| height < 1e-13), "{} is outside", vertex);
            prop_assert!(heights().filter(|height| height.abs() < 1e-13).count() >= 3, "{} is inside", vertex);
        }
        Ok(())
    });
    assert!((0.2..0.8).contains(&left.get()), "of {} something is left", left.get());
}
