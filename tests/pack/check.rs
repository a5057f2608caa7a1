//! The check finds planted faults, and nothing else.

use crate::pack::models::{box_body, model_of};
use meso_core::Model;
use meso_core::check::{Check, Finding, check};
use meso_core::geometry::Polyhedron;
use meso_core::math::Vec3;
use meso_core::specimen::{Periodic, Specimen};

/// A model whose boxes are all as long as their class asks (5 to 10 mm along the diagonal) and reported rightly.
fn sound(bodies: Vec<Polyhedron>) -> Model {
    let mut model = model_of(bodies);
    // Its grains are taken again, and compared; few are enough.
    model.spec.fraction = 0.01;
    let volume: f64 = model.aggregates.iter().map(|a| a.body.volume()).sum();
    model.report.fraction = volume / model.spec.specimen.volume();
    model
}

fn cube(x: f64, y: f64, z: f64) -> Polyhedron {
    box_body([x, y, z], [x + 4.0, y + 4.0, z + 4.0])
}

/// Findings in the bodies. Models made by hand have no seed, and their reports fit none.
fn findings(model: &Model) -> Vec<Finding> {
    let by_hand = |finding: &Finding| matches!(finding, Finding::NotTaken { .. } | Finding::Report { .. });
    check(model).findings.into_iter().filter(|finding| !by_hand(finding)).collect()
}

#[test]
fn a_sound_model_has_no_findings() {
    let model = sound(vec![cube(0.0, 0.0, 0.0), cube(4.0 + 4e-15, 0.0, 0.0), cube(146.0, 146.0, 146.0)]);
    let Check { aggregates, pairs_tested, fraction, .. } = check(&model);
    assert_eq!((aggregates, pairs_tested), (3, 0));
    assert!((fraction - 192.0 / 150f64.powi(3)).abs() < 1e-15);
    assert_eq!(findings(&model), []);
}

#[test]
fn touching_in_one_point_is_an_overlap() {
    let model = sound(vec![cube(0.0, 0.0, 0.0), cube(4.0, 4.0, 4.0)]);
    assert_eq!(findings(&model), [Finding::Overlap { a: 0, b: 1 }]);
}

#[test]
fn one_ulp_of_a_gap_is_apart() {
    let model = sound(vec![cube(0.0, 0.0, 0.0), cube(4.0f64.next_up(), 4.0, 4.0)]);
    assert_eq!(findings(&model), []);
}

#[test]
fn every_pair_of_a_lattice_is_met() {
    let cubes = |n: usize, step: f64| {
        let places = (0..n * n * n).map(move |i| [i % n, i / n % n, i / (n * n)].map(|k| k as f64 * step));
        sound(places.map(|[x, y, z]| cube(x, y, z)).collect())
    };
    let touching = check(&cubes(10, 4.0));
    // Each pair of neighbours, diagonal ones too, is met once: (28^3 - 1000) / 2 for 10 cubes a side.
    let overlaps = touching.findings.iter().filter(|finding| matches!(finding, Finding::Overlap { .. }));
    assert_eq!(overlaps.count(), (28usize.pow(3) - 1000) / 2);
    assert_eq!(findings(&cubes(10, 4.0001)), []);
}

#[test]
fn bodies_of_very_different_size_are_met() {
    let model = sound(vec![box_body([10.0; 3], [100.0; 3]), cube(97.0, 50.0, 50.0), cube(1.0, 1.0, 1.0)]);
    let found = findings(&model);
    assert!(found.contains(&Finding::Overlap { a: 0, b: 1 }), "{found:?}");
    assert!(matches!(found[1..], [Finding::Size { aggregate: 0, .. }]), "90 mm are too much for its class: {found:?}");
}

#[test]
fn a_gap_that_is_too_small_is_found_with_its_size() {
    let mut model = sound(vec![cube(0.0, 0.0, 0.0), cube(4.25, 0.0, 0.0), cube(0.0, 0.0, 4.5)]);
    model.spec.placement.min_gap_mm = 0.5;
    assert_eq!(findings(&model), [Finding::Gap { a: 0, b: 1, distance_mm: 0.25 }]);
}

#[test]
fn a_check_finds_a_gap_that_is_one_ulp_too_small() {
    let mut model = sound(vec![cube(0.0, 0.0, 0.0), cube(4.5f64.next_down(), 0.0, 0.0), cube(0.0, 0.0, 4.5)]);
    model.spec.placement.min_gap_mm = 0.5;
    let found = findings(&model);
    assert!(matches!(found[..], [Finding::Gap { a: 0, b: 1, .. }]), "{found:?}");
}

#[test]
fn a_body_too_near_its_own_image_is_found() {
    let mut model = sound(vec![box_body([0.0625, 0.0, 0.0], [149.9375, 4.0, 4.0])]);
    model.spec.specimen = Specimen::Cube { side_mm: 150.0, periodic: Periodic([true, false, false]) };
    model.spec.placement.min_gap_mm = 0.5;
    let found = findings(&model);
    assert!(found.contains(&Finding::Gap { a: 0, b: 0, distance_mm: 0.125 }), "{found:?}");
}

#[test]
fn a_body_that_is_farther_from_a_periodic_box_than_half_its_length_is_found() {
    for (x, is_found) in [(-4.0, false), (-4.1, true), (73.0, false), (150.0, false), (150.1, true), (298.0, true)] {
        let mut model = sound(vec![cube(x, 20.0, 20.0)]);
        model.spec.specimen = Specimen::Cube { side_mm: 150.0, periodic: Periodic([true, false, false]) };
        assert_eq!(findings(&model) == [Finding::Outside { aggregate: 0 }], is_found, "{x}: {:?}", findings(&model));
    }
}

#[test]
fn one_ulp_outside_the_specimen_is_found() {
    let model = sound(vec![cube(0.0, 0.0, 146.0), box_body([50.0; 3], [53.0, 54.0, 150f64.next_up()])]);
    assert!(findings(&model).contains(&Finding::Outside { aggregate: 1 }));
    assert!(!findings(&model).contains(&Finding::Outside { aggregate: 0 }));
}

#[test]
fn the_gap_to_the_walls_is_looked_at() {
    let mut model = sound(vec![cube(1.0, 1.0, 1.0), cube(50.0, 0.999, 50.0)]);
    model.spec.placement.wall_gap_mm = 1.0;
    assert_eq!(findings(&model), [Finding::Outside { aggregate: 1 }]);
}

fn not_convex(change: impl Fn(usize, &Vec3) -> Vec3) -> String {
    let body = cube(50.0, 50.0, 50.0);
    let vertices: Vec<Vec3> = body.vertices().iter().enumerate().map(|(i, v)| change(i, v)).collect();
    let body = Polyhedron::from_parts(vertices, body.faces().map(|face| face.to_vec()));
    let found = findings(&sound(vec![body]));
    let Some(Finding::NotConvex { aggregate: 0, reason }) = found.first() else { panic!("{found:?}") };
    reason.clone()
}

#[test]
fn faces_that_are_bent_or_seen_from_inside_are_found() {
    assert!(not_convex(|i, v| if i == 5 { v - Vec3::x() * 0.1 } else { *v }).contains("is not flat"));
    assert!(not_convex(|i, v| if i == 7 { v - Vec3::x() * 1e-9 } else { *v }).contains("outside"));
    assert!(not_convex(|i, v| if i == 7 { v - Vec3::x() * 1e-12 } else { *v }).contains("outside"), "signs are exact");
    assert!(not_convex(|i, v| if i == 7 { v + Vec3::repeat(1e-9) } else { *v }).contains("is not flat"));
    assert!(not_convex(|_, v| Vec3::new(-v.x, v.y, v.z)).contains("outside"), "a reflected body is inside out");
    assert!(not_convex(|_, v| Vec3::new(v.x, v.y, 0.0)).contains("no volume"));
}

#[test]
fn an_open_or_doubled_surface_is_found() {
    let body = cube(50.0, 50.0, 50.0);
    let faces: Vec<_> = body.faces().map(|face| face.to_vec()).collect();
    let with = |faces: Vec<Vec<u32>>| findings(&sound(vec![Polyhedron::from_parts(body.vertices().to_vec(), faces)]));
    assert!(with(faces[1..].to_vec())[0].to_string().contains("one side only"));
    let doubled = [&faces[..], &faces[..1]].concat();
    assert!(with(doubled)[0].to_string().contains("twice in one direction"));
}

#[test]
fn a_shell_that_takes_the_whole_aggregate_is_found() {
    let mut model = sound(vec![cube(0.0, 0.0, 0.0), cube(10.0, 0.0, 0.0)]);
    model.aggregates[1].itz_thickness_mm = 2.0;
    let found = findings(&model);
    let of_1 = |finding: &Finding| matches!(finding, Finding::Itz { aggregate: 1, .. });
    assert!(found.len() == 2 && found.iter().all(of_1), "no core, and thicker than asked: {found:?}");
}

#[test]
fn an_aggregate_in_the_wrong_class_is_found() {
    let mut model = sound(vec![cube(0.0, 0.0, 0.0)]);
    model.aggregates[0].class = 1;
    assert!(matches!(findings(&model)[..], [Finding::Size { aggregate: 0, .. }]));
}

#[test]
fn a_size_ten_nanometres_beyond_its_class_is_found() {
    // The diagonal of a box is its longest axis; sizes are right to the single precision of the vertices, 2e-6 mm.
    let is_found = |length: f64| {
        let model = sound(vec![box_body([50.0; 3], [50.0 + 0.48 * length, 50.0 + 0.6 * length, 50.0 + 0.64 * length])]);
        findings(&model).iter().any(|finding| matches!(finding, Finding::Size { aggregate: 0, .. }))
    };
    assert_eq!([5.0 + 1e-6, 10.0 - 1e-6].map(is_found), [false; 2]);
    assert_eq!([5.0 - 1e-5, 10.0 + 1e-5].map(is_found), [true; 2]);
}

#[test]
fn an_itz_outside_the_range_asked_for_is_found() {
    for (thickness, is_sound) in [(0.1, true), (0.5, true), (0.1 - 1e-12, false), (0.5 + 1e-12, false), (0.0, false)] {
        let mut model = sound(vec![cube(0.0, 0.0, 0.0)]);
        model.aggregates[0].itz_thickness_mm = thickness;
        assert_eq!(findings(&model).is_empty(), is_sound, "{thickness}: {:?}", findings(&model));
    }
}

#[test]
fn bodies_that_no_seed_gives_are_found() {
    let model = sound(vec![cube(0.0, 0.0, 0.0)]);
    assert!(check(&model).findings.contains(&Finding::NotTaken { body: 0 }));
}

#[test]
fn a_model_of_nothing_has_no_bodies_to_find() {
    assert_eq!(findings(&sound(Vec::new())), []);
}
