//! Statistics of packings whose figures are known.

use crate::pack::models::box_body;
use meso_core::aggregate::{Aggregate, Kind};
use meso_core::geometry::{Polyhedron, TriangleMesh, convex_hull};
use meso_core::math::{Rotation, Vec3};
use meso_core::specimen::{Periodic, Specimen};
use meso_core::statistics::{Statistics, StatisticsOptions};
use meso_core::{Model, Silent, Spec, pack};
use std::sync::LazyLock;

/// A model of a cube that holds `bodies`.
fn model(side_mm: f64, bodies: Vec<Polyhedron>) -> Model {
    let mut spec = Spec { fraction: 0.05, specimen: Specimen::cube(40.0), ..Spec::default() };
    spec.grading.d_max_mm = 10.0;
    spec.grading.classes_mm = vec![5.0, 10.0];
    let mut model = pack(&spec, &Silent).unwrap();
    model.spec.specimen = Specimen::cube(side_mm);
    model.aggregates = (0..)
        .zip(bodies)
        .map(|(id, body)| Aggregate {
            id,
            kind: Kind::Aggregate,
            own: None,
            class: 0,
            itz_thickness_mm: 0.0,
            shells: Vec::new(),
            body,
        })
        .collect();
    model
}

fn measured(side_mm: f64, bodies: Vec<Polyhedron>) -> Statistics {
    let options = StatisticsOptions { lines: 8_000, points: 100_000, ..StatisticsOptions::default() };
    Statistics::of(&model(side_mm, bodies), &options).unwrap()
}

fn ball(center: Vec3, radius: f64) -> Polyhedron {
    // A spiral of 600 points on the sphere.
    let point = |k: u32| {
        let z = 1.0 - (2.0 * f64::from(k) + 1.0) / 600.0;
        let (sin, cos) = (f64::from(k) * 2.399_963).sin_cos();
        center + radius * Vec3::new(cos * (1.0 - z * z).sqrt(), sin * (1.0 - z * z).sqrt(), z)
    };
    convex_hull(&(0..600).map(point).collect::<Vec<_>>()).unwrap()
}

/// 6 x 6 x 6 balls of 3 mm radius, 10 mm apart, in a cube of 60 mm.
fn balls() -> Vec<Polyhedron> {
    (0..216)
        .map(|k| {
            ball(Vec3::new(f64::from(k % 6), f64::from(k / 6 % 6), f64::from(k / 36)) * 10.0 + Vec3::repeat(5.0), 3.0)
        })
        .collect()
}

/// The figures of [`balls`], which several tests look at.
static OF_BALLS: LazyLock<Statistics> = LazyLock::new(|| measured(60.0, balls()));

fn close(value: f64, expected: f64, relative: f64) -> bool {
    (value / expected - 1.0).abs() < relative
}

#[test]
fn correlations_of_balls_meet_their_limits() {
    let found = &*OF_BALLS;
    let (f, s, c) = (found.fraction, found.specific_surface_per_mm, &found.correlation);
    assert!(close(f, 216.0 * 36.0 * std::f64::consts::PI / 216_000.0, 0.02));
    assert!(close(c.two_point[0], f, 0.02), "S2(0) is {}, f is {f}", c.two_point[0]);
    assert!(close(c.lineal_path[0], f, 0.02));
    assert!(close(c.slope_per_mm, -s / 4.0, 0.02), "slope {}, s {s}", c.slope_per_mm);
    // The mean chord of any set of convex bodies is 4 V / S (Cauchy).
    assert!(close(c.mean_chord_mm, 4.0 * f / s, 0.02));
}

#[test]
fn correlations_of_balls_follow_the_closed_forms() {
    let found = &*OF_BALLS;
    let (f, c) = (found.fraction, &found.correlation);
    for (k, &r) in c.lag_mm.iter().enumerate().filter(|(_, r)| **r <= 3.0) {
        // Pairs within one ball (others are 4 mm off), over the pairs within the cube.
        let in_ball = f * (1.0 - 3.0 * r / 12.0 + r.powi(3) / (16.0 * 27.0));
        // Mean over all directions of the product of (1 - r |u_i| / L), the cube's set covariance.
        let x = r / 60.0;
        let in_cube = 1.0 - 1.5 * x + 2.0 * x * x / std::f64::consts::PI - x.powi(3) / (4.0 * std::f64::consts::PI);
        assert!(close(c.two_point[k], in_ball / in_cube, 0.02), "S2({r}) is {}", c.two_point[k]);
        assert!(close(c.lineal_path[k], in_ball / in_cube, 0.02), "L({r}) is {}", c.lineal_path[k]);
    }
    let beyond = c.lag_mm.iter().position(|r| *r > 6.0).unwrap();
    assert!(c.lineal_path[beyond..].iter().all(|l| *l == 0.0), "no segment is longer than a ball");
}

#[test]
fn far_points_of_a_real_packing_are_independent() {
    let mut spec = Spec { fraction: 0.35, specimen: Specimen::cube(100.0), ..Spec::default() };
    spec.grading.classes_mm = vec![5.0, 10.0];
    spec.grading.d_max_mm = 10.0;
    let found = Statistics::of(&pack(&spec, &Silent).unwrap(), &StatisticsOptions::default()).unwrap();
    let far: Vec<f64> = found
        .correlation
        .lag_mm
        .iter()
        .zip(&found.correlation.two_point)
        .filter(|(r, _)| **r > 20.0)
        .map(|(_, s)| *s)
        .collect();
    let mean = far.iter().sum::<f64>() / far.len() as f64;
    // The wall effect makes the inside denser than the whole: the limit is a little above f^2.
    assert!(close(mean, found.fraction * found.fraction, 0.1), "{mean} against {}", found.fraction * found.fraction);
    assert!(close(found.correlation.slope_per_mm, -found.specific_surface_per_mm / 4.0, 0.02));
    assert!(found.orientation.eigenvalues.iter().all(|e| (e - 1.0 / 3.0).abs() < 0.06), "{:?}", found.orientation);
    let wall = &found.wall_effect.fraction;
    assert!(wall[0] < 0.5 * wall[10], "at the wall {}, inside {}", wall[0], wall[10]);
}

/// Where nothing ends at a wall, the curves themselves meet their limits: S2(0) = L(0) = f, slopes of -s/4, S2 -> f^2.
#[test]
fn correlations_of_a_periodic_packing_meet_their_limits() {
    let grading = "grading = { d_min_mm = 4, d_max_mm = 12 }";
    let text = "fraction = 0.5\nspecimen = { kind = 'box', size_mm = [40, 45, 50], periodic = ['x', 'y', 'z'] }\n";
    let model = pack(&Spec::from_toml(&format!("{text}{grading}")).unwrap(), &Silent).unwrap();
    let found = Statistics::of(&model, &StatisticsOptions::default()).unwrap();
    let (f, slope) = (found.fraction, -found.specific_surface_per_mm / 4.0);
    let c = &found.correlation;
    assert!(close(c.slope_per_mm, slope, 0.01), "slope {}, -s/4 {slope}", c.slope_per_mm);
    assert!(close(c.mean_chord_mm, -f / slope, 0.01), "mean chord {}, 4 f / s {}", c.mean_chord_mm, -f / slope);
    let far = &c.two_point[40..60];
    assert!(close(far.iter().sum::<f64>() / 20.0, f * f, 0.02), "{far:?} against {}", f * f);
    let near = Statistics::of(&model, &StatisticsOptions { lag_mm: 0.01, lags: 2, ..StatisticsOptions::default() })
        .unwrap()
        .correlation;
    for curve in [&near.two_point, &near.lineal_path] {
        assert!(close(curve[0], f, 0.01), "{} at 0, f is {f}", curve[0]);
        assert!(close((curve[1] - curve[0]) / 0.01, slope, 0.01), "{curve:?}, -s/4 {slope}");
    }
}

#[test]
fn nearest_distances_of_a_lattice_are_its_gaps() {
    let found = OF_BALLS.nearest_distance_mm.unwrap();
    // A polyhedral ball lacks up to 0.03 mm of the sphere.
    assert!(found.min >= 4.0 && found.max < 4.1, "{found:?}");
    let two = [[10.0, 30.0], [46.0, 30.0]].map(|[x, y]| ball(Vec3::new(x, y, 30.0), 3.0));
    let far = measured(60.0, two.to_vec()).nearest_distance_mm.unwrap();
    assert!(far.min == far.max && (30.0..30.1).contains(&far.min), "{far:?}");
    assert_eq!(measured(60.0, vec![ball(Vec3::repeat(30.0), 3.0)]).nearest_distance_mm, None);
}

/// Images two sizes of an aggregate off were looked at, no others: the nearest was another one, or none.
#[test]
fn the_nearest_aggregate_may_be_an_image_far_beyond_a_face() {
    let nearest = |x: &[f64]| {
        let mut model = model(100.0, x.iter().map(|&x| ball(Vec3::new(x, 50.0, 50.0), 3.0)).collect());
        model.spec.specimen = Specimen::Cube { side_mm: 100.0, periodic: Periodic([true, false, false]) };
        Statistics::of(&model, &StatisticsOptions { lines: 0, points: 0, ..StatisticsOptions::default() })
            .unwrap()
            .nearest_distance_mm
            .unwrap()
    };
    // 48 mm apart in the box, 40 mm across its face.
    let two = nearest(&[20.0, 74.0]);
    assert!((40.0..40.1).contains(&two.min) && (40.0..40.1).contains(&two.max), "{two:?}");
    let one = nearest(&[50.0]);
    assert!((94.0..94.1).contains(&one.mean), "its own image: {one:?}");
}

#[test]
fn a_block_in_the_middle_shows_where_the_wall_effect_ends() {
    let wall = measured(40.0, vec![box_body([10.0; 3], [30.0; 3])]).wall_effect;
    assert_eq!(wall.depth_mm.len(), 20);
    assert!(wall.fraction[..10].iter().all(|f| *f == 0.0) && wall.fraction[10..].iter().all(|f| *f == 1.0), "{wall:?}");
    assert_eq!(wall.points.iter().sum::<u64>(), 100_000);
}

#[test]
fn shapes_and_orientation_of_turned_blocks_are_theirs() {
    let turn = Rotation::from_euler_angles(0.4, -0.7, 1.1);
    let at = |k: i32| Vec3::new(f64::from(k % 3), f64::from(k / 3 % 3), f64::from(k / 9)) * 20.0 + Vec3::repeat(10.0);
    let brick = box_body([-4.0, -2.0, -1.0], [4.0, 2.0, 1.0]).rotated(&turn);
    let found = measured(60.0, (0..27).map(|k| brick.translated(&at(k))).collect());
    let mean = |d: Option<meso_core::statistics::Distribution>| d.unwrap().mean;
    assert!(close(mean(found.shapes.length_mm), 8.0, 1e-9));
    assert!(close(mean(found.shapes.elongation), 0.5, 1e-9) && close(mean(found.shapes.flatness), 0.5, 1e-9));
    assert!(close(mean(found.shapes.krumbein_sphericity), (8.0_f64 / 64.0).cbrt(), 1e-9));
    let wadell = std::f64::consts::PI.cbrt() * (6.0 * 64.0_f64).powf(2.0 / 3.0) / 112.0;
    assert!(close(mean(found.shapes.wadell_sphericity), wadell, 1e-9));
    assert_eq!((found.shapes.zingg.blade, found.shapes.zingg.equant), (27, 0));
    assert!((found.orientation.eigenvalues[2] - 1.0).abs() < 1e-9, "all point the same way");
    let longest = turn * Vec3::x();
    assert!((found.orientation.tensor[0][1] - longest.x * longest.y).abs() < 1e-9);
}

#[test]
fn convexity_is_the_share_of_the_hull() {
    // An upright prism over an L of three squares beside a block: 3 of 3.5 squares of its hull.
    let outline = [[0.0, 0.0], [20.0, 0.0], [20.0, 10.0], [10.0, 10.0], [10.0, 20.0], [0.0, 20.0]];
    let vertices = [5.0, 15.0].into_iter().flat_map(|z| outline.map(|[x, y]| Vec3::new(x, y, z))).collect();
    let ends = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
    let sides = (0..6).flat_map(|i| [[i, (i + 1) % 6, (i + 1) % 6 + 6], [i, (i + 1) % 6 + 6, i + 6]]);
    let below = ends.map(|[a, b, c]| [a, c, b]).into_iter();
    let triangles = below.chain(ends.map(|t| t.map(|i| i + 6))).chain(sides).collect();
    let angle = Polyhedron::of_surface(&TriangleMesh { vertices, triangles });
    let convexity = measured(40.0, vec![angle, box_body([25.0; 3], [35.0; 3])]).shapes.convexity.unwrap();
    assert!(close(convexity.min, 6.0 / 7.0, 1e-12) && convexity.max == 1.0, "{convexity:?}");
}

#[test]
fn balls_are_equant_and_nearly_spheres() {
    let shapes = &OF_BALLS.shapes;
    assert_eq!(shapes.zingg.equant, 216);
    assert!(shapes.wadell_sphericity.unwrap().min > 0.99);
    assert!(close(shapes.sieve_size_mm.unwrap().mean, 6.0, 0.02));
}

#[test]
fn statistics_do_not_depend_on_the_number_of_threads() {
    let model = model(60.0, balls().into_iter().take(36).collect());
    let options = StatisticsOptions { lines: 100, points: 2_000, ..StatisticsOptions::default() };
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Statistics::of(&model, &options).unwrap())
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn absurd_options_are_bounded() {
    let model = model(60.0, vec![ball(Vec3::repeat(30.0), 10.0)]);
    for (lag_mm, layer_mm) in
        [(1e-300, 1e-300), (0.0, 0.0), (-1.0, -1.0), (f64::NAN, f64::NAN), (f64::INFINITY, f64::INFINITY)]
    {
        let options = StatisticsOptions {
            lines: 3,
            points: 50,
            lag_mm,
            layer_mm,
            lags: u32::MAX,
            ..StatisticsOptions::default()
        };
        let found = Statistics::of(&model, &options).unwrap();
        assert!(found.correlation.lag_mm.len() <= 10_001 && found.wall_effect.depth_mm.len() <= 1000);
        assert!(!found.correlation.lag_mm.is_empty());
    }
}

#[test]
fn an_empty_packing_has_statistics_too() {
    let found = measured(40.0, Vec::new());
    assert_eq!((found.fraction, found.shapes.length_mm, found.nearest_distance_mm), (0.0, None, None));
    assert!(found.correlation.two_point.iter().all(|s| *s == 0.0));
}
