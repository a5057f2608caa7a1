//! The convex hull, proved in exact arithmetic, on everything that breaks hull codes.

use crate::dice::Dice;
use crate::exact::{Big3, cross, dot, exact, in_units, is_zero, minus, ratio};
use crate::solids::{block, coplanar, hard, lower_dimensional, solids};
use meso_collision::geometry::HullBuilder;
use meso_collision::geometry::{Face, HullError, Plane, Polyhedron, convex_hull};
use meso_collision::math::Vec3;
use num_bigint::BigInt;
use std::collections::BTreeSet;

/// Proves that the hull of `points` is right; returns it.
fn proved_hull(points: &[Vec3], name: &str) -> Polyhedron {
    let hull = convex_hull(points).unwrap_or_else(|error| panic!("{name}: {error}"));
    let (vertices, points) = (exact(hull.vertices()), exact(points));
    assert_subsequence(&vertices, &points, name);
    assert_closed(&hull, name);
    for face in hull.faces() {
        assert_supports(&face.to_vec(), &vertices, &points, name);
    }
    assert_volume(&hull, &vertices, name);
    hull
}

/// The vertices are distinct input points, in input order.
fn assert_subsequence(vertices: &[Big3], points: &[Big3], name: &str) {
    let mut rest = points.iter();
    assert!(vertices.iter().all(|v| rest.any(|p| p == v)), "{name}: the vertices are not input points in order");
    assert_eq!(vertices.iter().collect::<BTreeSet<_>>().len(), vertices.len(), "{name}: a vertex twice");
}

/// Every edge once in each direction; Euler's formula; every vertex used.
pub(crate) fn assert_closed(hull: &Polyhedron, name: &str) {
    let mut edges = BTreeSet::new();
    for face in hull.faces() {
        for k in 0..face.len() {
            assert!(edges.insert((face.vertex(k), face.vertex((k + 1) % face.len()))), "{name}: an edge twice");
        }
    }
    assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))), "{name}: not closed");
    assert_eq!(hull.vertices().len() + hull.faces().len(), edges.len() / 2 + 2, "{name}: Euler");
    assert_eq!(
        edges.iter().map(|e| e.0).collect::<BTreeSet<_>>().len(),
        hull.vertices().len(),
        "{name}: unused vertex"
    );
}

/// The face's plane has every input point on or below it and no hull vertex but its own corners in it; the corners
/// turn left, strictly.
fn assert_supports(corners: &[u32], vertices: &[Big3], points: &[Big3], name: &str) {
    let corner = |k: usize| &vertices[corners[k % corners.len()] as usize];
    let turn = |k: usize| cross(&minus(corner(k + 1), corner(k)), &minus(corner(k + 2), corner(k)));
    let normal = turn(0);
    assert!(!is_zero(&normal), "{name}: three corners on a line");
    let height = |p: &Big3| dot(&normal, &minus(p, corner(0)));
    assert!(points.iter().all(|p| height(p) <= BigInt::ZERO), "{name}: a point is outside");
    for (i, vertex) in (0..).zip(vertices) {
        assert_eq!(height(vertex) == BigInt::ZERO, corners.contains(&i), "{name}: not merged, or not plane");
    }
    assert!(
        (0..corners.len()).all(|k| dot(&turn(k), &normal) > BigInt::ZERO),
        "{name}: a corner of 180 degrees or more"
    );
}

/// Within 1e-14 of the exact volume.
fn assert_volume(hull: &Polyhedron, vertices: &[Big3], name: &str) {
    let determinant = |t: [u32; 3]| {
        let [a, b, c] = t.map(|i| minus(&vertices[i as usize], &vertices[0]));
        dot(&a, &cross(&b, &c))
    };
    let six: BigInt = hull.triangles().map(determinant).sum();
    // Coordinates are in units of 2^-300, hence volumes in 2^-900.
    let volume = in_units(hull.volume(), 900) * 6;
    let error: BigInt = &volume - &six;
    let small = error.magnitude() * 100_000_000_000_000_u64 <= *six.magnitude();
    assert!(small, "{name}: relative volume error {:e}", ratio(&volume, &six));
}

/// What does not depend on the order of the points: every face as the set of its corners' bits.
fn unordered(hull: &Polyhedron) -> BTreeSet<BTreeSet<[u64; 3]>> {
    let bits = |i: u32| <[f64; 3]>::from(hull.vertices()[i as usize] + Vec3::zeros()).map(f64::to_bits);
    hull.faces().map(|face| face.iter().map(bits).collect()).collect()
}

#[test]
fn hulls_of_every_family_are_proved() {
    let clouds = solids(80);
    assert!(clouds.len() > 390);
    for cloud in clouds {
        proved_hull(&cloud.points, &cloud.name);
    }
}

#[test]
fn small_lattice_sets_are_proved_or_flat() {
    let (mut dice, mut flat, mut merged) = (Dice::new(1), 0, 0);
    for case in 0..4000 {
        let points = dice.lattice(4 + case % 9, 2 + case % 3);
        match convex_hull(&points) {
            Err(HullError::LowerDimensional { .. }) => flat += 1,
            _ => merged += usize::from(proved_hull(&points, "lattice").faces().any(|face| face.len() > 3)),
        }
    }
    assert!(flat > 200 && merged > 1500, "{flat} flat and {merged} merged sets");
}

/// Hard sets, proved; returns how many were flat.
fn prove_hard_sets(seed: u64, sets: usize) -> usize {
    let mut dice = Dice::new(seed);
    let mut flat = 0;
    for kind in 0..sets {
        let cloud = hard(&mut dice, kind);
        match convex_hull(&cloud.points) {
            Err(HullError::LowerDimensional { dimension }) => {
                assert_eq!(exact_dimension(&exact(&cloud.points)), dimension, "{}", cloud.name);
                flat += 1;
            }
            _ => drop(proved_hull(&cloud.points, &cloud.name)),
        }
    }
    flat
}

/// The affine dimension, by elimination.
fn exact_dimension(points: &[Big3]) -> u8 {
    let arms: Vec<Big3> = points.iter().map(|p| minus(p, &points[0])).collect();
    let Some(u) = arms.iter().find(|arm| !is_zero(arm)) else { return 0 };
    let Some(normal) = arms.iter().map(|arm| cross(u, arm)).find(|n| !is_zero(n)) else { return 1 };
    if arms.iter().any(|arm| dot(arm, &normal) != BigInt::ZERO) { 3 } else { 2 }
}

#[test]
fn hard_sets_are_proved_or_flat() {
    let flat = prove_hard_sets(5, 3000);
    assert!((10..1000).contains(&flat), "{flat} flat sets");
}

#[test]
#[ignore = "slow tier"]
fn a_hundred_thousand_hard_sets_are_proved_or_flat() {
    assert!(prove_hard_sets(6, 100_000) > 300);
}

#[test]
fn fewer_than_three_dimensions_are_named() {
    for (dimension, cloud) in lower_dimensional() {
        let error = convex_hull(&cloud.points).expect_err(&cloud.name);
        assert_eq!(error, HullError::LowerDimensional { dimension }, "{}", cloud.name);
    }
}

#[test]
fn order_and_duplicates_do_not_change_the_hull() {
    let mut dice = Dice::new(2);
    for mut cloud in solids(12) {
        let expected = unordered(&convex_hull(&cloud.points).unwrap());
        cloud.points.push(cloud.points[0]);
        cloud.points.push(cloud.points[cloud.points.len() / 2]);
        dice.shuffle(&mut cloud.points);
        assert_eq!(unordered(&convex_hull(&cloud.points).unwrap()), expected, "{}", cloud.name);
    }
}

#[test]
fn powers_of_two_reflections_and_axis_swaps_map_the_hull() {
    let maps: [fn(Vec3) -> Vec3; 4] = [|p| p * 1024.0, |p| p / 64.0, |p| -p, |p| p.yxz()];
    for cloud in solids(6).into_iter().filter(|cloud| !cloud.name.contains("magnitudes")) {
        let hull = convex_hull(&cloud.points).unwrap();
        for map in maps {
            let expected = unordered(&hull.mapped(|v| map(*v)));
            let mapped: Vec<Vec3> = cloud.points.iter().map(|p| map(*p)).collect();
            let hull_of_mapped = convex_hull(&mapped).unwrap();
            assert_eq!(unordered(&hull_of_mapped), expected, "{}", cloud.name);
        }
    }
}

#[test]
fn the_hull_of_a_hull_is_itself() {
    for cloud in solids(6) {
        let hull = convex_hull(&cloud.points).unwrap();
        assert_eq!(convex_hull(hull.vertices()).unwrap(), hull, "{}", cloud.name);
    }
}

#[test]
fn a_hull_like_another_is_the_hull_whether_its_faces_stay_or_not() {
    let (mut stay, mut change) = (0, 0);
    for cloud in solids(20) {
        let hull = convex_hull(&cloud.points).unwrap();
        let size = hull.vertices().iter().map(Vec3::norm).fold(0.0, f64::max);
        for share in [0.0, 1e-12, 1e-3, 0.3] {
            let moved: Vec<Vec3> =
                hull.vertices().iter().map(|v| v.map(|x| x + share * size * (1e3 * x).sin())).collect();
            let like = HullBuilder::moved(&hull.clone().into(), &moved);
            assert_eq!(like, convex_hull(&moved), "{} moved by {share}", cloud.name);
            let same = like.is_ok_and(|like| like.faces().map(Face::to_vec).eq(hull.faces().map(Face::to_vec)));
            *(if same { &mut stay } else { &mut change }) += 1;
        }
    }
    assert!(stay > 20 && change > 20, "{stay} kept their faces, {change} did not");
}

#[test]
fn a_builder_gives_the_same_hulls_whatever_it_built_before() {
    let mut builder = HullBuilder::default();
    for cloud in solids(6) {
        assert_eq!(builder.build(&cloud.points), convex_hull(&cloud.points), "{}", cloud.name);
        let _ = builder.build(&[Vec3::zeros(); 5]);
    }
}

#[test]
fn wrapping_and_growing_give_the_same_hull() {
    let mut dice = Dice::new(11);
    for vertices in (4..=96).step_by(4) {
        let grain = dice.grain(vertices);
        // With a point inside it the hull is grown.
        let inside = grain.iter().sum::<Vec3>() / grain.len() as f64;
        let more: Vec<Vec3> = grain.iter().copied().chain([inside]).collect();
        assert_eq!(convex_hull(&grain), convex_hull(&more), "{vertices} vertices");
    }
}

#[test]
fn planes_and_areas_are_those_of_the_faces_one_by_one() {
    let mut dice = Dice::new(12);
    for vertices in [4, 7, 24, 30, 300] {
        let hull = convex_hull(&dice.grain(vertices)).unwrap();
        let planes: Vec<Plane> = hull.planes().collect();
        assert_eq!(planes.len(), hull.faces().len());
        let mut area = 0.0;
        for (plane, face) in planes.iter().zip(hull.faces()) {
            let [a, b, c] = [0, 1, 2].map(|k| hull.vertices()[face.vertex(k) as usize]);
            let normal = (b - a).cross(&(c - a));
            area += normal.norm() / 2.0;
            assert!((plane.normal - normal.normalize()).norm() < 1e-14);
            assert!([a, b, c].iter().all(|corner| plane.normal.dot(corner) <= plane.offset));
        }
        assert!((hull.area() - area).abs() <= 1e-13 * area);
    }
}

#[test]
fn a_hundred_thousand_points_take_no_time_to_speak_of() {
    let mut dice = Dice::new(3);
    let sphere: Vec<Vec3> = (0..100_000).map(|_| dice.direction()).collect();
    assert!(convex_hull(&sphere).unwrap().vertices().len() > 99_990);
    let mut plane: Vec<Vec3> = (0..30_000).map(|k| Vec3::new(f64::from(k % 173), f64::from(k / 173), 0.0)).collect();
    assert_eq!(convex_hull(&plane), Err(HullError::LowerDimensional { dimension: 2 }));
    plane.push(Vec3::new(40.0, 60.0, 70.0));
    assert_eq!(convex_hull(&plane).unwrap().faces().len(), 6);
    let disc: Vec<Vec3> = (0..20_000).map(|_| dice.direction()).map(|d| Vec3::new(d.x, d.y, 0.0)).collect();
    let cone = [disc, vec![Vec3::new(0.0, 0.0, 1.0), Vec3::new(0.0, 0.0, -1e-9)]].concat();
    assert!(convex_hull(&cone).is_ok());
}

#[test]
fn a_full_lattice_of_a_hundred_thousand_points_is_a_cube() {
    let at = |k: usize| Vec3::new((k % 47) as f64, (k / 47 % 47) as f64, (k / 2209) as f64);
    let hull = convex_hull(&(0..47 * 47 * 47).map(at).collect::<Vec<_>>()).unwrap();
    assert_eq!((hull.vertices().len(), hull.faces().len(), hull.volume()), (8, 6, 46.0 * 46.0 * 46.0));
}

#[test]
fn a_body_contains_its_vertices_and_nothing_one_ulp_off_its_faces() {
    for cloud in solids(6).into_iter().filter(|cloud| !cloud.name.contains("sphere")) {
        let hull = convex_hull(&cloud.points).unwrap();
        assert!(cloud.points.iter().all(|p| hull.contains(p)), "{}", cloud.name);
    }
    let cube = convex_hull(&block([1.0; 3])).unwrap();
    assert!(cube.contains(&Vec3::new(1.0, 0.3, -0.7)));
    assert!(!cube.contains(&Vec3::new(1.0_f64.next_up(), 0.3, -0.7)));
}

#[test]
fn centroids_of_thin_and_far_bodies_are_inside_them() {
    for cloud in solids(24).into_iter().filter(|cloud| !cloud.name.contains("magnitudes")) {
        let hull = convex_hull(&cloud.points).unwrap();
        let centroid = hull.centroid();
        // Inside, but for the rounding of its coordinates.
        let slack = hull.vertices().iter().map(Vec3::amax).fold(0.0, f64::max) * 4.0 * f64::EPSILON;
        let outside = hull.planes().map(|p| p.normal.dot(&centroid) - p.offset).fold(f64::NEG_INFINITY, f64::max);
        assert!(outside <= slack, "{}: {outside:e} outside", cloud.name);
    }
}

#[test]
fn empty_clouds_and_coordinates_out_of_range_are_named() {
    let with = |x: f64| [block([1.0; 3]), vec![Vec3::new(0.0, x, 0.0)]].concat();
    assert_eq!(convex_hull(&[]), Err(HullError::Empty));
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(convex_hull(&with(x)), Err(HullError::NotFinite { index: 8 }));
    }
    for x in [1e61, -1e90, 1e-61, 5e-324] {
        assert_eq!(convex_hull(&with(x)), Err(HullError::OutOfRange { index: 8 }));
    }
    for x in [0.0, -0.0, 1e-60, -1e-60] {
        assert_eq!(convex_hull(&with(x)).unwrap().vertices().len(), 8);
    }
}

#[test]
fn the_faces_of_known_solids_are_counted() {
    let count = |points: &[Vec3]| {
        let hull = convex_hull(points).unwrap();
        (hull.vertices().len(), hull.faces().len())
    };
    assert_eq!(count(&block([1.0, 2.0, 3.0])), (8, 6));
    for cloud in coplanar(&mut Dice::new(4)).iter().filter(|cloud| cloud.name.contains("box")) {
        assert_eq!(count(&cloud.points), (8, 6), "{}", cloud.name);
    }
}

#[test]
fn points_in_a_plane_along_the_axes_span_two_dimensions() {
    for axis in 0..3 {
        let square = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
        let points = square.map(|[u, v]| {
            let mut point = Vec3::repeat(3.0);
            (point[(axis + 1) % 3], point[(axis + 2) % 3]) = (u, v);
            point
        });
        assert!(matches!(convex_hull(&points), Err(HullError::LowerDimensional { dimension: 2 })), "{axis}");
    }
}
