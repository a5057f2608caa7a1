//! The ITZ of grains that the sides of a box cut, as those of a label volume: balls, against integrals over the whole balls.

use crate::pack::models::model_of;
use meso_core::aggregate::{Grading, Shell};
use meso_core::geometry::{Polyhedron, TriangleMesh, convex_hull};
use meso_core::math::Vec3;
use meso_core::mesh::{self, ItzForm, Mesh, MeshOptions, Method, Phase, PhaseVolumes, Tools};
use meso_core::specimen::Specimen;
use meso_core::voxel_image::{ImageOptions, Quantity, Region, ShareOf, VoxelImage, Voxels};
use meso_core::{Model, saved};

/// Edge of the box, and radius of the balls, mm.
const SIDE: f64 = 16.0;
const RADIUS: f64 = 6.5;
/// Middles of balls that one, two and three sides cut.
const MIDDLES: [[f64; 3]; 3] = [[-2.5, 8.1, 7.9], [0.6, 15.2, 8.1], [1.3, 0.7, 15.6]];
const THICKNESSES: [f64; 2] = [0.3, 1.0];

/// Points on a ball, on the circles and in the corners where the box cuts it; their hull is the cut ball but for 0.1 %.
fn cut_ball(middle: Vec3) -> Polyhedron {
    let count = 2500;
    let spiral = (0..count).map(|i| {
        let (angle, z) = (f64::from(i) * 2.399_963_229_728_653, (f64::from(i) + 0.5) / f64::from(count) * 2.0 - 1.0);
        Vec3::new((1.0 - z * z).sqrt() * libm::cos(angle), (1.0 - z * z).sqrt() * libm::sin(angle), z)
    });
    let within = |x: &Vec3, margin: f64| x.iter().all(|x| (margin..=SIDE - margin).contains(x));
    let mut points: Vec<Vec3> = spiral.map(|n| middle + n * RADIUS).filter(|x| within(x, 0.02)).collect();
    for (axis, end) in (0..3).flat_map(|axis| [(axis, 0.0), (axis, SIDE)]) {
        let half = RADIUS.powi(2) - (end - middle[axis]).powi(2);
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let circle =
            (0..400).map(|i| std::f64::consts::TAU * f64::from(i) / 400.0).filter(|_| half > 0.0).map(|angle| {
                let mut x = middle;
                (x[axis], x[u], x[v]) =
                    (end, middle[u] + half.sqrt() * libm::cos(angle), middle[v] + half.sqrt() * libm::sin(angle));
                x
            });
        points.extend(circle.filter(|x| within(x, 0.0)));
        for (other_end, sign) in [0.0, SIDE].into_iter().flat_map(|end| [(end, -1.0), (end, 1.0)]) {
            let half = half - (other_end - middle[u]).powi(2);
            let mut x = middle;
            (x[axis], x[u], x[v]) = (end, other_end, middle[v] + sign * half.max(0.0).sqrt());
            points.extend((half > 0.0 && within(&x, 0.0)).then_some(x));
        }
    }
    let corner = |i: usize| Vec3::from_fn(|axis, _| if i >> axis & 1 == 1 { SIDE } else { 0.0 });
    points.extend((0..8).map(corner).filter(|x| (x - middle).norm() < RADIUS));
    let hull = convex_hull(&points).unwrap();
    Polyhedron::of_surface(&TriangleMesh { vertices: hull.vertices().to_vec(), triangles: hull.triangles().collect() })
}

/// A model of a ball as it is read from a file.
fn model(middle: [f64; 3], thickness: f64) -> Model {
    let mut model = model_of(vec![cut_ball(middle.into())]);
    model.spec.specimen = Specimen::cube(SIDE);
    model.spec.grading = Grading { d_max_mm: 15.0, classes_mm: vec![5.0, 10.0, 15.0], ..model.spec.grading };
    model.report.classes.truncate(2);
    model.aggregates[0].itz_thickness_mm = thickness;
    let mut bytes = Vec::new();
    saved::write(&model, &mut bytes).unwrap();
    let read = saved::read(&bytes).unwrap();
    assert!(read.aggregates[0].body.vertices() == model.aggregates[0].body.vertices());
    read
}

/// Volume of a ball within the box, mm3, by its chords.
fn volume(middle: [f64; 3], radius: f64) -> f64 {
    let count = 2000;
    let at = |i: i32| (f64::from(i) + 0.5) * SIDE / f64::from(count);
    let chord = |y: f64, z: f64| {
        let half = (radius.powi(2) - (y - middle[1]).powi(2) - (z - middle[2]).powi(2)).max(0.0).sqrt();
        ((middle[0] + half).clamp(0.0, SIDE) - (middle[0] - half).clamp(0.0, SIDE)).max(0.0)
    };
    let all: f64 = (0..count).flat_map(|j| (0..count).map(move |k| (j, k))).map(|(j, k)| chord(at(j), at(k))).sum();
    all * (SIDE / f64::from(count)).powi(2)
}

fn shell(middle: [f64; 3], thickness: f64) -> f64 {
    volume(middle, RADIUS) - volume(middle, RADIUS - thickness)
}

fn meshed(model: &Model, method: Method, element_size_mm: f64) -> Mesh {
    let options = MeshOptions { method, element_size_mm, itz: ItzForm::Solid, ..Default::default() };
    mesh::build(model, &options, &Tools::default()).unwrap()
}

/// Asserts an error of at most 1 %.
fn assert_near(found: f64, expected: f64, what: &str, case: ([f64; 3], f64)) {
    let error = found / expected - 1.0;
    assert!(error.abs() < 0.01, "{what} of {case:?}: {error}");
}

#[test]
fn voxels_images_and_exact_volumes_have_no_itz_at_a_cut() {
    let voxels = Method::Voxel { thin_itz: true, subsamples: 3 };
    for case @ (middle, thickness) in MIDDLES.into_iter().flat_map(|middle| THICKNESSES.map(|t| (middle, t))) {
        let (model, expected) = (model(middle, thickness), shell(middle, thickness));
        let exact = PhaseVolumes::exact(&model.aggregates, &model.spec.specimen, |a| a.itz_thickness_mm).unwrap();
        assert_near(exact.itz, expected, "the exact volume", case);
        let mesh = meshed(&model, voxels, 0.32);
        assert_near(PhaseVolumes::of_mesh(&mesh).itz, expected, "voxels", case);
        let options =
            ImageOptions { voxel_size_mm: 1.0, quantity: Quantity::Share, of: ShareOf::Itz, region: Region::Whole };
        let image = VoxelImage::new(&model, &options).unwrap();
        let Voxels::Real(shares) = image.layers(0..image.counts()[2]) else { panic!("shares are reals") };
        assert_near(shares.iter().map(|share| f64::from(*share)).sum(), expected, "shares", case);
    }
}

#[test]
fn fitted_layers_reach_the_sides_and_have_the_volume_of_the_whole_balls_shell_in_the_box() {
    for case @ (middle, thickness) in MIDDLES.into_iter().flat_map(|middle| THICKNESSES.map(|t| (middle, t))) {
        let (model, expected) = (model(middle, thickness), shell(middle, thickness));
        for size in [2.0, 1.0] {
            let mesh = meshed(&model, Method::FITTED, size);
            let volumes = PhaseVolumes::of_mesh(&mesh);
            assert_near(volumes.itz, expected, "the layer", case);
            assert_near(volumes.total(), SIDE.powi(3), "everything", case);
            assert_eq!((mesh.notes.closed_side_gaps, mesh.notes.closed_side_gap_aggregates), (0, 0), "{case:?}");
            // Every node lies in the box, those on its sides exactly.
            let off = |x: f64| x.min(SIDE - x);
            let is_flat = |x: f64| off(x) == 0.0 || off(x) > 1e-3;
            assert!(mesh.points.iter().all(|point| point.iter().all(|x| off(*x) >= 0.0 && is_flat(*x))), "{case:?}");
            let [itz, core] = [RADIUS, RADIUS - thickness].map(|radius| area_in_sides(middle, radius));
            assert_sides(&mesh, itz - core, case);
        }
    }
}

#[test]
fn shells_below_a_layer_reach_the_sides_and_have_their_volumes() {
    let (middle, depths) = (MIDDLES[1], [0.3, 0.8, 1.2]);
    let mut model = model(middle, depths[0]);
    model.aggregates[0].shells =
        [(0, 0.5), (1, 0.4)].map(|(own, thickness_mm)| Shell { own, thickness_mm, outward: false }).into();
    let mesh = meshed(&model, Method::FITTED, 1.0);
    let volumes = PhaseVolumes::of_mesh(&mesh);
    let within = depths.map(|depth| shell(middle, depth));
    for (phase, expected) in
        [(Phase::Itz, within[0]), (Phase::Own(0), within[1] - within[0]), (Phase::Own(1), within[2] - within[1])]
    {
        assert_near(volumes.of(phase), expected, "the layer", (middle, expected));
    }
    assert_near(volumes.total(), SIDE.powi(3), "everything", (middle, 0.0));
    assert!(mesh.points.iter().all(|point| point.iter().all(|x| (0.0..=SIDE).contains(x))));
    let [itz, core] = [RADIUS, RADIUS - depths[0]].map(|radius| area_in_sides(middle, radius));
    assert_sides(&mesh, itz - core, (middle, depths[0]));
}

/// Area of a ball's sections in the sides of the box, mm2.
fn area_in_sides(middle: [f64; 3], radius: f64) -> f64 {
    let count = 4000;
    let of_side = |axis: usize, end: f64| {
        let half = radius.powi(2) - (end - middle[axis]).powi(2);
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let chord = |i: i32| {
            let x = (f64::from(i) + 0.5) * SIDE / f64::from(count);
            let half = (half - (x - middle[u]).powi(2)).max(0.0).sqrt();
            (middle[v] + half).clamp(0.0, SIDE) - (middle[v] - half).clamp(0.0, SIDE)
        };
        (0..count).map(chord).sum::<f64>() * SIDE / f64::from(count)
    };
    (0..3).map(|axis| of_side(axis, 0.0) + of_side(axis, SIDE)).sum()
}

/// Asserts that the layer's cells have the area `expected` in the sides of the box, within 5 %.
fn assert_sides(mesh: &Mesh, expected: f64, case: ([f64; 3], f64)) {
    let mut area = 0.0;
    for (cell, face) in mesh.outer_faces() {
        if mesh.phase[cell as usize] == Phase::Itz {
            let nodes = mesh.cell(cell as usize);
            let [a, b, c] = [0, 1, 2].map(|i| mesh.points[nodes[mesh.kind.faces()[face][i]] as usize]);
            area += (b - a).cross(&(c - a)).norm() / 2.0;
        }
    }
    assert!((area / expected - 1.0).abs() < 0.05, "{case:?}: {area} of {expected} mm2 in the sides");
}
