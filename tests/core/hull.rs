//! The convex hull against an exact brute-force reference, and what no hull may violate.

use crate::exact::{Big3, big, cross, dot, exact, is_zero, minus, ratio};
use meso_core::geometry::{HullError, Polyhedron, convex_hull};
use meso_core::math::Vec3;
use num_bigint::BigInt;
use rand_chacha::ChaCha8Rng;
use rand_core::{RngCore, SeedableRng};
use std::collections::BTreeSet;

/// The facets of the hull, each as the set of all points in its plane, by trying every triple of points.
fn brute_facets(points: &[Big3]) -> BTreeSet<Vec<usize>> {
    let mut facets = BTreeSet::new();
    for i in 0..points.len() {
        for j in i + 1..points.len() {
            for k in j + 1..points.len() {
                let normal = cross(&minus(&points[j], &points[i]), &minus(&points[k], &points[i]));
                if let (false, Some(plane)) = (is_zero(&normal), supporting(points, &normal, &points[i])) {
                    facets.insert(plane);
                }
            }
        }
    }
    facets
}

/// The points in the plane through `origin` across `normal`, where all points lie on one side of it.
fn supporting(points: &[Big3], normal: &Big3, origin: &Big3) -> Option<Vec<usize>> {
    let (mut plane, mut below, mut above) = (Vec::new(), false, false);
    for (i, point) in points.iter().enumerate() {
        let height = dot(normal, &minus(point, origin));
        below |= height < BigInt::ZERO;
        above |= height > BigInt::ZERO;
        if below && above {
            return None;
        }
        if height == BigInt::ZERO {
            plane.push(i);
        }
    }
    Some(plane)
}

/// Checks the hull of `points` against brute force, in exact arithmetic throughout.
fn assert_exact_hull(points: &[Vec3], what: &str) -> Polyhedron {
    let hull = convex_hull(points).unwrap_or_else(|error| panic!("{what}: {error}"));
    let mut distinct = exact(points);
    distinct.sort();
    distinct.dedup();
    let facets = brute_facets(&distinct);
    let mut planes = vec![0; distinct.len()];
    facets.iter().flatten().for_each(|&i| planes[i] += 1);
    let extreme = |i: &usize| planes[*i] >= 3;
    let expected: BTreeSet<BTreeSet<&Big3>> =
        facets.iter().map(|f| f.iter().filter(|i| extreme(i)).map(|&i| &distinct[i]).collect()).collect();
    let vertices = exact(hull.vertices());
    let faces: BTreeSet<BTreeSet<&Big3>> =
        hull.faces().map(|f| f.iter().map(|i| &vertices[i as usize]).collect()).collect();
    assert!(faces == expected, "{what}: wrong faces");
    assert_eq!(hull.faces().len(), expected.len(), "{what}: a face twice");
    assert_eq!(vertices.iter().collect::<BTreeSet<_>>().len(), vertices.len(), "{what}: a vertex twice");
    assert_eq!(vertices.len(), planes.iter().filter(|n| **n >= 3).count(), "{what}: vertex count");
    assert_closed_convex(&hull, &vertices, what);
    assert_volume(&hull, &vertices, what);
    hull
}

/// Every edge once in each direction, Euler's formula, and every corner of every face turning left seen from outside.
fn assert_closed_convex(hull: &Polyhedron, vertices: &[Big3], what: &str) {
    let mut edges = BTreeSet::new();
    for face in hull.faces() {
        let (corners, n) = (face.to_vec(), face.len());
        for k in 0..n {
            assert!(edges.insert((corners[k], corners[(k + 1) % n])), "{what}: an edge twice");
            let [a, b, c] = [0, 1, 2].map(|step| &vertices[corners[(k + step) % n] as usize]);
            let normal = cross(&minus(b, a), &minus(c, a));
            assert!(!is_zero(&normal), "{what}: a corner of 180 degrees");
            assert!(vertices.iter().all(|v| dot(&normal, &minus(v, a)) <= BigInt::ZERO), "{what}: not convex");
        }
    }
    assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))), "{what}: not closed");
    assert_eq!(hull.vertices().len() + hull.faces().len(), edges.len() / 2 + 2, "{what}: Euler");
}

fn assert_volume(hull: &Polyhedron, vertices: &[Big3], what: &str) {
    let six: BigInt = hull
        .triangles()
        .map(|t| {
            let [a, b, c] = t.map(|i| minus(&vertices[i as usize], &vertices[0]));
            dot(&a, &cross(&b, &c))
        })
        .sum();
    // |volume - six / 6| <= 1e-14 six / 6, with the volume in the cube of the unit.
    let volume = (big(hull.volume()) << 600) * 6;
    let error: BigInt = &volume - &six;
    let small = error.magnitude() * 100_000_000_000_000_u64 <= *six.magnitude();
    assert!(small, "{what}: relative volume error {:e}", ratio(&volume, &six));
}

fn random(rng: &mut ChaCha8Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

fn points(n: usize, mut coordinate: impl FnMut() -> f64) -> Vec<Vec3> {
    (0..n).map(|_| Vec3::new(coordinate(), coordinate(), coordinate())).collect()
}

#[test]
fn hulls_of_random_points_are_exact() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for case in 0..60 {
        let n = 4 + case % 22;
        assert_exact_hull(&points(n, || random(&mut rng) - 0.5), &format!("random case {case}"));
    }
}

#[test]
fn hulls_of_lattice_points_merge_their_coplanar_triangles() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut merged = 0;
    for case in 0..150 {
        let side = 2 + case as u64 % 4;
        let cloud = points(6 + case % 25, || (rng.next_u64() % side) as f64);
        match convex_hull(&cloud) {
            Err(HullError::LowerDimensional { .. }) => continue,
            _ => {
                let hull = assert_exact_hull(&cloud, &format!("lattice case {case}"));
                merged += usize::from(hull.faces().any(|face| face.len() > 3));
            }
        }
    }
    assert!(merged > 50, "only {merged} cases had anything to merge");
}
