//! Rings as grains: what a hull would get wrong in packings, meshes, files, images and statistics.

use crate::pack::folder::{Folder, Heard};
use meso_core::export::stl;
use meso_core::geometry::{BodyForm, TriangleMesh};
use meso_core::math::Vec3;
use meso_core::mesh::{self, ItzForm, MeshOptions, Method, PhaseVolumes, Tools, Volumes, figures};
use meso_core::spec::Spec;
use meso_core::statistics::{Statistics, StatisticsOptions};
use meso_core::voxel_image::{ImageOptions, VoxelImage, Voxels};
use meso_core::{Model, Silent, check, pack};
use std::f64::consts::{PI, TAU};

/// Sides of a ring, and of its section.
const SIDES: [usize; 2] = [14, 7];

/// A ring whose axes are put in another order; the orders 3 to 5 mirror it, and turn its triangles round again.
fn ring(order: usize) -> TriangleMesh {
    let axes = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1], [2, 1, 0]][order];
    let corner = |k: usize| {
        let [a, b] = [k / SIDES[1], k % SIDES[1]];
        let [a, b] = [TAU * a as f64 / SIDES[0] as f64, TAU * b as f64 / SIDES[1] as f64];
        let p = [(6.0 + 3.0 * b.cos()) * a.cos(), (6.0 + 3.0 * b.cos()) * a.sin(), 3.0 * b.sin()];
        Vec3::from(axes.map(|axis| p[axis]))
    };
    let at = |a: usize, b: usize| (a % SIDES[0] * SIDES[1] + b % SIDES[1]) as u32;
    let squares = (0..SIDES[0]).flat_map(|a| (0..SIDES[1]).map(move |b| (a, b)));
    let pair = |(a, b)| {
        let [p, q, r, s] = [at(a, b), at(a + 1, b), at(a + 1, b + 1), at(a, b + 1)];
        if order < 3 { [[p, q, r], [p, r, s]] } else { [[p, r, q], [p, s, r]] }
    };
    let triangles = squares.flat_map(pair).collect();
    TriangleMesh { vertices: (0..SIDES[0] * SIDES[1]).map(corner).collect(), triangles }
}

/// A cube of 10 mm with a fin of 1 mm on one side, which is a third of its length.
fn finned() -> TriangleMesh {
    let outline =
        [[0.0, 0.0], [10.0, 0.0], [10.0, 4.5], [15.0, 4.5], [15.0, 5.5], [10.0, 5.5], [10.0, 10.0], [0.0, 10.0]];
    let cap = [[0, 1, 2], [0, 2, 5], [0, 5, 6], [0, 6, 7], [2, 3, 4], [2, 4, 5]];
    let sides = (0..8).flat_map(|k| [[k, (k + 1) % 8, k + 8], [(k + 1) % 8, (k + 1) % 8 + 8, k + 8]]);
    let lids = cap.iter().flat_map(|[a, b, c]| [[*a, *c, *b], [a + 8, b + 8, c + 8]]);
    let vertices = [0.0, 10.0].iter().flat_map(|z| outline.map(|[x, y]| Vec3::new(x, y, *z))).collect();
    TriangleMesh { vertices, triangles: lids.chain(sides).collect() }
}

fn spec(order: usize, rest: &str) -> Spec {
    of_grain(ring(order), rest)
}

fn of_grain(grain: TriangleMesh, rest: &str) -> Spec {
    let TriangleMesh { vertices, triangles } = grain;
    let vertices: Vec<[f64; 3]> = vertices.into_iter().map(<[f64; 3]>::from).collect();
    let grain = format!("{{ vertices = {vertices:?}, faces = {triangles:?} }}");
    let text =
        format!("{rest}\n[grading]\nd_min_mm = 16\nd_max_mm = 24\n[shape]\nkind = 'library'\ngrains = [{grain}]");
    Spec::from_toml(&text).unwrap_or_else(|error| panic!("{error}"))
}

fn packed(rest: &str) -> Model {
    let model = pack(&spec(3, rest), &Silent).unwrap();
    assert!(model.aggregates.len() > 3 && model.aggregates.iter().all(|ring| ring.body.form() == BodyForm::Surface));
    assert_eq!(check::check(&model).findings, []);
    model
}

const CUBE: &str = "fraction = 0.12\nspecimen = { kind = 'cube', side_mm = 40 }";
const PERIODIC: &str = "fraction = 0.12\nspecimen = { kind = 'cube', side_mm = 40, periodic = ['x', 'y', 'z'] }";

fn volume(model: &Model) -> f64 {
    model.aggregates.iter().map(|ring| ring.body.volume()).sum()
}

#[test]
fn grains_with_parts_thinner_than_two_of_their_itz_are_reported() {
    for (thickness, is_thin) in [(0.3, false), (1.0, true)] {
        let rest = format!(
            "fraction = 0.1\nspecimen = {{ kind = 'cube', side_mm = 50 }}\nitz = {{ thickness_mm = [{thickness}, {thickness}] }}"
        );
        let model = pack(&of_grain(finned(), &rest), &Silent).unwrap();
        let all: Vec<u32> = (0..model.aggregates.len() as u32).collect();
        assert!(all.len() > 2);
        assert_eq!(model.report.itz_thin, if is_thin { all } else { Vec::new() }, "{thickness}");
        assert_eq!(model.report.remarks().len(), usize::from(is_thin));
        assert_eq!(check::check(&model).findings, []);
    }
}

#[test]
fn a_ring_keeps_its_volume_and_is_packed_however_its_axes_lie() {
    // The file torus.stl, whose principal axes were a left-handed frame: its grains had negative volumes without end.
    let relative = ring(0).volume() / 18.0_f64.powi(3);
    for order in 0..6 {
        let spec = spec(order, CUBE);
        let found = spec.shape.grains[0].relative_volume();
        assert!((found / relative - 1.0).abs() < 0.05, "{order}: {found} {relative}");
        assert!((pack(&spec, &Silent).unwrap().report.fraction - 0.12).abs() < 0.02);
    }
}

#[test]
fn a_fitted_lattice_of_rings_has_no_inverted_cells_and_volumes_within_half_a_percent() {
    let model = packed(CUBE);
    let fitted = MeshOptions { method: Method::FITTED, itz: ItzForm::None, ..Default::default() };
    // Chords across a dent add to a ring: 0.4 % at a fifth of the ring's thickness, 0.9 % at a third.
    let chords = MeshOptions { element_size_mm: 1.25, volumes: Some(Volumes::Fitted), ..fitted.clone() };
    assert_fitted(&model, &chords, 0.005);
    for itz in [ItzForm::Smeared, ItzForm::Cohesive] {
        assert_fitted(&model, &MeshOptions { itz, element_size_mm: 2.0, ..fitted.clone() }, 1e-5);
    }
}

#[test]
fn a_solid_itz_of_rings_has_the_volume_of_their_shells() {
    let model = packed(CUBE);
    let options =
        MeshOptions { method: Method::FITTED, itz: ItzForm::Solid, element_size_mm: 1.25, ..Default::default() };
    let mesh = mesh::build(&model, &options, &Tools::default()).unwrap();
    assert_eq!(figures::CellQuality::below(&figures::CellQuality::of_cells(&mesh), 0.0), [0; 0]);
    let shells =
        |ring: &meso_core::aggregate::Aggregate| ring.body.volume() - ring.core_volume(ring.itz_thickness_mm).unwrap();
    let exact: f64 = model.aggregates.iter().map(shells).sum();
    let volumes = PhaseVolumes::of_mesh(&mesh);
    assert!((volumes.itz / exact - 1.0).abs() < 0.05, "{} {exact}", volumes.itz);
    let both = volumes.itz + volumes.aggregate;
    assert!((both / volume(&model) - 1.0).abs() < 0.001, "{both} {}", volume(&model));
}

fn assert_fitted(model: &Model, options: &MeshOptions, tolerance: f64) {
    let mesh = mesh::build(model, options, &Tools::default()).unwrap();
    let cells = figures::CellQuality::of_cells(&mesh);
    assert_eq!(figures::CellQuality::below(&cells, 1.0), [0; 0], "{:?}", options.itz);
    let volumes = PhaseVolumes::of_mesh(&mesh);
    let error = volumes.aggregate / volume(model) - 1.0;
    assert!(error.abs() < tolerance, "{:?}: {error}", options.itz);
    assert!((volumes.total() / 64e3 - 1.0).abs() < 1e-9);
}

#[test]
fn voxels_and_images_of_rings_leave_their_holes_to_the_mortar() {
    for specimen in [CUBE, PERIODIC] {
        let model = packed(specimen);
        let options = MeshOptions { element_size_mm: 1.0, ..Default::default() };
        let volumes = PhaseVolumes::of_mesh(&mesh::build(&model, &options, &Tools::default()).unwrap());
        let image = VoxelImage::new(&model, &ImageOptions::default()).unwrap();
        let Voxels::Label(phases) = image.layers(0..image.counts()[2]) else { panic!("phases are labels") };
        let inside = phases.iter().filter(|phase| **phase == 1 || **phase == 2).count() as f64;
        for found in [volumes.aggregate + volumes.itz, inside] {
            assert!((found / volume(&model) - 1.0).abs() < 0.03, "{found} {}", volume(&model));
        }
    }
}

#[test]
fn an_stl_of_rings_holds_their_volume_and_every_edge_twice() {
    let model = packed(CUBE);
    let mut bytes = Vec::new();
    stl::write(&model.aggregates, &mut bytes).unwrap();
    let number = |at: usize| f64::from(f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()));
    let corner = |at: usize| Vec3::new(number(at), number(at + 4), number(at + 8));
    let triangles = (84..bytes.len()).step_by(50).map(|at| [12, 24, 36].map(|k| corner(at + k)));
    let corners: Vec<Vec3> = triangles.flatten().collect();
    let surface = TriangleMesh::welded(&corners);
    surface.check_closed().unwrap();
    assert!((surface.volume() / volume(&model) - 1.0).abs() < 1e-5);
    // Faces of a ring are twice as many as its corners: its Euler number is 0.
    assert_eq!(surface.triangles.len(), 2 * surface.vertices.len());
}

#[test]
fn lines_through_rings_meet_their_share_of_the_specimen() {
    let model = packed(CUBE);
    let statistics = Statistics::of(&model, &StatisticsOptions::quick()).unwrap();
    let met = statistics.correlation.two_point[0];
    assert!((met / model.report.fraction - 1.0).abs() < 0.1, "{met} {}", model.report.fraction);
}

/// An OBJ of a ring of more triangles than a grain may have.
fn scanned_ring() -> (String, usize) {
    let [around, across] = [160, 70];
    let corner = |k: usize| {
        let [a, b] = [TAU * (k / across) as f64 / around as f64, TAU * (k % across) as f64 / across as f64];
        format!("v {} {} {}\n", (6.0 + 3.0 * b.cos()) * a.cos(), (6.0 + 3.0 * b.cos()) * a.sin(), 3.0 * b.sin())
    };
    let at = |a: usize, b: usize| 1 + a % around * across + b % across;
    let face = |a: usize, b: usize| {
        let [p, q, r, s] = [at(a, b), at(a + 1, b), at(a + 1, b + 1), at(a, b + 1)];
        format!("f {p} {q} {r}\nf {p} {r} {s}\n")
    };
    let corners: String = (0..around * across).map(corner).collect();
    let faces: String = (0..around).flat_map(|a| (0..across).map(move |b| (a, b))).map(|(a, b)| face(a, b)).collect();
    (corners + &faces, 2 * around * across)
}

#[test]
fn a_scan_is_reduced_to_its_tolerance_and_the_remark_says_what_that_cost() {
    let (scan, triangles) = scanned_ring();
    let read = |rest: &str| {
        let mut files = Heard(Folder(&[("ring.obj", scan.as_bytes())]), Vec::new());
        let text =
            format!("{CUBE}\ngrading = {{ d_min_mm = 16, d_max_mm = 24 }}\nshape = {{ library = 'ring.obj'{rest} }}");
        Spec::from_toml_with(&text, &mut files).map(|spec| (spec.shape.grains[0].clone(), files.1))
    };
    let (grain, remarks) = read("").unwrap();
    let count = grain.dents().unwrap().body.faces().len();
    assert!((300..4000).contains(&count), "{count}");
    let told = format!("ring.obj: {triangles} triangles became {count}, nowhere more than 0.090 mm away (0.5 %");
    assert!(remarks[0].starts_with(&told), "{remarks:?}");
    let exact = 2.0 * PI * PI * 6.0 * 9.0 / 18.0_f64.powi(3);
    // Three times the tolerance in length is in the cube of the length.
    assert!((grain.relative_volume() / exact - 1.0).abs() < 0.02, "{}", grain.relative_volume());
    let (coarse, _) = read(", tolerance = 0.02").unwrap();
    assert!(coarse.dents().unwrap().body.faces().len() * 2 < count);
    let refused = |rest: &str| read(rest).unwrap_err().to_string();
    assert!(refused(", tolerance = 0").contains("raise shape.tolerance"));
    assert!(refused(", tolerance = 0.2").contains("0 to 0.1"));
}
