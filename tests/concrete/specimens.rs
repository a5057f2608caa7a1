//! Specimens: grains lie wholly inside each of them, by formulas of our own, and volumes are exact.

use crate::angle_piece::angle_piece;
use crate::pack::models::parry_shapes;
use meso_core::check::{Finding, check};
use meso_core::math::Vec3;
use meso_core::mesh::{self, Mesh, MeshOptions, Method, Tools};
use meso_core::packing::{StopReason, Strategy};
use meso_core::specimen::{Built, Specimen};
use meso_core::watch::{Silent, Stage};
use meso_core::{Model, Spec, Watch, pack};
use std::f64::consts::PI;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

/// Packs `specimen` by `strategy`, at a fraction that the strategy reaches easily.
fn packed(specimen: Specimen, strategy: Strategy, wall_gap_mm: f64) -> Model {
    let fraction = if strategy == Strategy::TakeAndPlace { 0.3 } else { 0.45 };
    let mut spec = Spec { fraction, specimen, ..Spec::default() };
    spec.placement.strategy = strategy;
    spec.placement.wall_gap_mm = wall_gap_mm;
    pack(&spec, &Silent).unwrap()
}

fn vertices(model: &Model) -> impl Iterator<Item = &Vec3> {
    model.aggregates.iter().flat_map(|aggregate| aggregate.body.vertices())
}

/// The packings by both strategies, with and without a gap to the walls; `depth` must be at least the gap for every vertex.
fn assert_inside(specimen: &Specimen, depth: impl Fn(&Vec3) -> f64) -> [Model; 3] {
    [(Strategy::TakeAndPlace, 0.0), (Strategy::Rearrange, 0.0), (Strategy::Rearrange, 1.0)].map(|(strategy, gap)| {
        let model = packed(specimen.clone(), strategy, gap);
        let report = &model.report;
        assert_eq!(report.stop_reason, StopReason::TargetReached, "{strategy:?}: {}", report.stop_detail);
        assert_eq!(check(&model).findings, []);
        let shallowest = vertices(&model).map(&depth).fold(f64::INFINITY, f64::min);
        assert!(shallowest >= gap, "{strategy:?} left a vertex at {shallowest}, the gap is {gap}");
        assert!(shallowest < gap + 1.0, "no grain came near the wall: {shallowest}");
        model
    })
}

#[test]
fn grains_lie_inside_a_cylinder() {
    let specimen = Specimen::Cylinder { diameter_mm: 60.0, height_mm: 70.0 };
    assert!((specimen.volume() - PI * 900.0 * 70.0).abs() < 1e-9);
    assert_inside(&specimen, |v| {
        let arm = (v.x - 30.0).hypot(v.y - 30.0);
        (30.0 - arm).min(v.z).min(70.0 - v.z)
    });
}

#[test]
fn grains_lie_inside_a_sphere() {
    let specimen = Specimen::Sphere { diameter_mm: 75.0 };
    assert!((specimen.volume() - PI / 6.0 * 75.0f64.powi(3)).abs() < 1e-9);
    assert_inside(&specimen, |v| 37.5 - (v - Vec3::repeat(37.5)).norm());
}

#[test]
fn grains_lie_inside_a_prism() {
    let specimen = Specimen::Prism { length_mm: 90.0, width_mm: 40.0, depth_mm: 50.0 };
    assert_eq!((specimen.volume(), specimen.aabb().max), (180_000.0, Vec3::new(90.0, 40.0, 50.0)));
    assert_inside(&specimen, |v| v.min().min(90.0 - v.x).min(40.0 - v.y).min(50.0 - v.z));
}

/// A point for every wall of a specimen, where it is so many mm deep.
type Walls = fn(f64) -> Vec<Vec3>;

#[test]
fn a_picometre_more_than_the_gap_to_a_wall_is_held_and_a_picometre_less_is_not() {
    let cases: [(Specimen, Walls); 5] = [
        (Specimen::cube(64.0), |depth| {
            let low = [0, 1, 2].map(|axis| Vec3::from_fn(|i, _| if i == axis { depth } else { 32.0 }));
            low.into_iter().chain(low.map(|point| Vec3::repeat(64.0) - point)).collect()
        }),
        (Specimen::Cylinder { diameter_mm: 60.0, height_mm: 70.0 }, |depth| {
            let arm = 30.0 - depth;
            let side = Vec3::new(30.0 - 0.6 * arm, 30.0 + 0.8 * arm, 35.0);
            vec![side, Vec3::new(30.0, 30.0, depth), Vec3::new(30.0, 30.0, 70.0 - depth)]
        }),
        (Specimen::Sphere { diameter_mm: 80.0 }, |depth| {
            let arm = 40.0 - depth;
            vec![Vec3::new(40.0 - 0.36 * arm, 40.0 + 0.48 * arm, 40.0 - 0.8 * arm)]
        }),
        (notched(), |depth| {
            let low = [[depth, 20.0, 25.0], [30.0, depth, 25.0], [30.0, 20.0, depth]];
            let high = [[120.0 - depth, 20.0, 25.0], [30.0, 45.0 - depth, 25.0], [30.0, 20.0, 50.0 - depth]];
            let notch = [[58.0 - depth, 20.0, 6.0], [62.0 + depth, 20.0, 6.0], [60.0, 20.0, 12.0 + depth]];
            [low, high, notch].concat().into_iter().map(Vec3::from).collect()
        }),
        (moved_angle_piece(), |depth| {
            let low = [[depth, 60.0, 20.0], [60.0, depth, 20.0], [20.0, 20.0, depth]];
            let high = [[90.0 - depth, 20.0, 20.0], [20.0, 90.0 - depth, 20.0], [20.0, 20.0, 40.0 - depth]];
            let inner = [[35.0 - depth, 60.0, 20.0], [60.0, 35.0 - depth, 20.0]];
            [&low[..], &high, &inner].concat().into_iter().map(Vec3::from).collect()
        }),
    ];
    for (specimen, walls) in cases {
        let container = specimen.container();
        for gap in [0.0, 1.5] {
            assert!(walls(gap).iter().all(|point| (container.depth(point) - gap).abs() < 1e-12), "{specimen:?}");
            let held = |depth: f64| {
                walls(depth).iter().map(|point| container.holds(&[Vec3::zeros()], point, gap)).collect::<Vec<_>>()
            };
            assert!(held(gap + 1e-12).iter().all(|held| *held), "{specimen:?}, gap {gap}: {:?}", held(gap + 1e-12));
            assert!(!held(gap - 1e-12).iter().any(|held| *held), "{specimen:?}, gap {gap}: {:?}", held(gap - 1e-12));
        }
    }
}

#[test]
fn a_convex_polyhedron_is_closed_and_holds_its_own_corners() {
    let turned = |k: usize| {
        // Corners of a box, turned, so that no face has a normal of few digits.
        let (sin, cos) = (0.1 + k as f64).sin_cos();
        let corner = move |i: usize| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 30.0 + axis as f64 } else { 0.0 });
        (0..8).map(corner).map(|[x, y, z]| [cos * x - sin * y, sin * x + cos * y, z + 0.3 * x]).collect::<Vec<_>>()
    };
    for k in 0..40 {
        let container = Specimen::Polyhedron { vertices_mm: turned(k) }.container();
        assert!(container.holds(&container.surface().points, &Vec3::zeros(), 0.0), "{k}");
    }
}

/// A frustum: a square of 80 mm below, one of 50 mm above, 60 mm high; away from the origin in the spec.
fn frustum() -> Specimen {
    let square = |half: f64, z: f64| [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]];
    Specimen::Polyhedron { vertices_mm: [square(40.0, 7.0), square(25.0, 67.0)].concat() }
}

#[test]
fn grains_lie_inside_a_convex_polyhedron_that_begins_at_the_origin() {
    let specimen = frustum();
    assert_eq!(specimen.aabb().min, Vec3::zeros());
    let exact = 60.0 / 3.0 * (80.0 * 80.0 + 80.0 * 50.0 + 50.0 * 50.0);
    assert!((specimen.volume() - exact).abs() < 1e-9);
    // The sides lean inwards by 15 mm on 60.
    let slope = (1.0 + 0.25f64.powi(2)).sqrt();
    let side = |x: f64, z: f64| (40.0 - (x - 40.0).abs() - 0.25 * z) / slope;
    assert_inside(&specimen, |v| side(v.x, v.z).min(side(v.y, v.z)).min(v.z).min(60.0 - v.z) + 1e-12);
}

fn notched() -> Specimen {
    Specimen::NotchedPrism {
        length_mm: 120.0,
        width_mm: 45.0,
        depth_mm: 50.0,
        notch_depth_mm: 12.0,
        notch_width_mm: 4.0,
        upper_notch_depth_mm: 0.0,
        notch_at_mm: 0.0,
    }
}

#[test]
fn grains_keep_out_of_a_notch() {
    let specimen = notched();
    assert!((specimen.volume() - (120.0 * 45.0 * 50.0 - 12.0 * 4.0 * 45.0)).abs() < 1e-6);
    let wall = |v: &Vec3| v.min().min(120.0 - v.x).min(45.0 - v.y).min(50.0 - v.z);
    // A vertex is no proof of all: grains could straddle the notch. Their edges are followed, too.
    let notch = |v: &Vec3| (v.z - 12.0).max((v.x - 60.0).abs() - 2.0);
    for (model, gap) in assert_inside(&specimen, wall).into_iter().zip([0.0, 0.0, 1.0]) {
        let nearest = along_edges(&model).map(|v| notch(&v)).fold(f64::INFINITY, f64::min);
        assert!((gap / 2.0f64.sqrt()..gap + 1.5).contains(&nearest), "{}: {nearest}", model.report.strategy);
    }
}

/// Points along all edges of all grains.
fn along_edges(model: &Model) -> impl Iterator<Item = Vec3> {
    let bodies = model.aggregates.iter().map(|aggregate| &aggregate.body);
    let faces = bodies.flat_map(|body| body.faces().map(move |face| (body, face)));
    let edges = faces.flat_map(|(body, face)| {
        let at = move |k: usize| body.vertices()[face.vertex(k % face.len()) as usize];
        (0..face.len()).map(move |k| (at(k), at(k + 1)))
    });
    edges.flat_map(|(a, b)| (0..20).map(move |k| a.lerp(&b, f64::from(k) / 20.0)))
}

#[test]
fn grains_lie_inside_a_dogbone() {
    let specimen = Specimen::Dogbone {
        length_mm: 150.0,
        width_mm: 100.0,
        thickness_mm: 25.0,
        neck_width_mm: 60.0,
        neck_length_mm: 0.0,
        radius_mm: 72.5,
    };
    // van Vliet and van Mier's proportions: arcs 50 mm long, 25 mm of straight ends. The area below an arc of half-angle t is
    // r^2 (t - sin t cos t) / 2 beside the chord's rectangle.
    let (r, angle) = (72.5f64, (50.0f64 / 72.5).asin());
    let cut = 2.0 * (50.0 * 20.0 - (50.0 * r - r * r * (angle + angle.sin() * angle.cos()) / 2.0));
    let exact = (150.0 * 100.0 - 2.0 * cut) * 25.0;
    assert!((specimen.volume() / exact - 1.0).abs() < 2e-4, "{} of {exact}", specimen.volume());
    let side = |v: &Vec3| {
        let x = (v.x - 75.0).abs();
        let low = if x > 50.0 { 0.0 } else { 20.0 - r + (r * r - x * x).sqrt() };
        (v.y - low).min(100.0 - low - v.y)
    };
    // The arcs' chords lie within 0.005 mm, on the side of the specimen; beside an arc the distance is less than across
    // the specimen.
    assert_inside(&specimen, |v| side(v).min(v.z).min(25.0 - v.z).min(v.x).min(150.0 - v.x) + 0.006);
}

/// An L away from the origin.
fn moved_angle_piece() -> Specimen {
    angle_piece([90.0, 35.0, 40.0], |[x, y, z]| [x - 11.0, y + 5.0, z + 3.0])
}

#[test]
fn grains_lie_inside_a_closed_surface_that_is_not_convex() {
    let specimen = moved_angle_piece();
    assert!((specimen.volume() - (90.0 * 35.0 + 35.0 * 55.0) * 40.0).abs() < 1e-6);
    let side = |v: &Vec3| 35.0 - v.x.min(v.y);
    let depth = |v: &Vec3| v.min().min(90.0 - v.x).min(90.0 - v.y).min(40.0 - v.z) + 1e-12;
    let [_, model, _] = assert_inside(&specimen, depth);
    let nearest = along_edges(&model).map(|v| side(&v)).fold(f64::INFINITY, f64::min);
    assert!((0.0..1.0).contains(&nearest), "{nearest}");
    let surface = specimen.container().surface();
    let points: Vec<_> = surface.points.iter().map(|p| parry3d_f64::math::Vector::new(p.x, p.y, p.z)).collect();
    let mesh = parry3d_f64::shape::TriMesh::new(points, surface.triangles().collect()).unwrap();
    let here = parry3d_f64::math::Pose::IDENTITY;
    for (id, grain) in parry_shapes(&model).iter().enumerate() {
        assert!(!parry3d_f64::query::intersection_test(&here, &mesh, &here, grain).unwrap().intersecting, "{id}");
    }
}

#[test]
fn voxels_of_specimens_that_are_not_convex_have_their_volume() {
    for specimen in [moved_angle_piece(), notched()] {
        let model = packed(specimen.clone(), Strategy::TakeAndPlace, 0.0);
        let mesh = mesh::build(&model, &MeshOptions { element_size_mm: 1.0, ..Default::default() }, &Tools::default())
            .unwrap();
        let volume = mesh::PhaseVolumes::of_mesh(&mesh).total();
        assert!((volume / specimen.volume() - 1.0).abs() < 0.005, "{volume} of {}", specimen.volume());
    }
}

#[test]
fn a_vertex_outside_a_curved_or_leaning_wall_is_found() {
    let mut model = packed(Specimen::Cylinder { diameter_mm: 60.0, height_mm: 70.0 }, Strategy::Rearrange, 0.0);
    let outermost = |v: &Vec3| (v.x - 30.0).hypot(v.y - 30.0);
    let farthest = |body: &meso_core::geometry::Polyhedron| body.vertices().iter().map(outermost).fold(0.0, f64::max);
    let aggregates = &mut model.aggregates;
    let near =
        (0..aggregates.len()).max_by(|&a, &b| farthest(&aggregates[a].body).total_cmp(&farthest(&aggregates[b].body)));
    let near = near.unwrap();
    let outwards = aggregates[near].body.centroid() - Vec3::new(30.0, 30.0, 35.0);
    let step = Vec3::new(outwards.x, outwards.y, 0.0).normalize() * 1.5;
    aggregates[near].body = aggregates[near].body.translated(&step);
    assert!(check(&model).findings.contains(&Finding::Outside { aggregate: near as u32 }));
}

#[test]
fn voxels_and_lattices_fill_a_cylinder_and_nothing_else() {
    let model = packed(Specimen::Cylinder { diameter_mm: 40.0, height_mm: 30.0 }, Strategy::Rearrange, 0.0);
    for method in [Method::VOXEL, Method::PLAIN, Method::FITTED] {
        let mesh =
            mesh::build(&model, &MeshOptions { method, element_size_mm: 2.0, ..Default::default() }, &Tools::default())
                .unwrap();
        let volume = mesh::PhaseVolumes::of_mesh(&mesh).total();
        let exact = model.spec.specimen.volume();
        assert!((volume / exact - 1.0).abs() < 0.02, "{method:?}: {volume} of {exact}");
        for cell in mesh.cells().zip(&mesh.owner).filter(|(_, id)| **id == Mesh::NO_BODY).map(|(cell, _)| cell) {
            let centre = cell.iter().map(|&node| mesh.points[node as usize]).sum::<Vec3>() / cell.len() as f64;
            assert!((centre.x - 20.0).hypot(centre.y - 20.0) <= 20.0 + 1e-9);
        }
        let mut used = vec![false; mesh.points.len()];
        mesh.cells.iter().for_each(|&node| used[node as usize] = true);
        assert!(used.iter().all(|used| *used), "no node is left without cells");
    }
}

/// 64 cubes of an edge length (mm), 3 mm apart, as one closed surface.
fn cubes(edge: f64) -> Specimen {
    cubed_cubes(4, edge)
}

/// `n` by `n` by `n` of them.
fn cubed_cubes(n: u32, edge: f64) -> Specimen {
    let (mut vertices_mm, mut triangles) = (Vec::new(), Vec::new());
    for cube in 0..n.pow(3) {
        let mut surface = Specimen::cube(edge).container().surface();
        let place = Vec3::from([1, n, n * n].map(|step| f64::from(cube / step % n))) * (edge + 3.0);
        surface.points.iter_mut().for_each(|point| *point += place);
        triangles.extend(surface.triangles().map(|t| t.map(|corner| corner + vertices_mm.len() as u32)));
        vertices_mm.extend(surface.points.into_iter().map(<[f64; 3]>::from));
    }
    Specimen::Mesh { vertices_mm, triangles, built: Built::default() }
}

/// A cube of 20 mm with one of 6 mm in its middle, or beside it, whose triangles are turned round where it is a hollow.
fn nested(at: f64, hollow: bool) -> Specimen {
    let (outer, mut inner) = (Specimen::cube(20.0).container().surface(), Specimen::cube(6.0).container().surface());
    inner.points.iter_mut().for_each(|point| *point += Vec3::new(at, 7.0, 7.0));
    let inner_triangles = inner.triangles().map(|[a, b, c]| if hollow { [a, c, b] } else { [a, b, c] });
    let triangles = outer.triangles().chain(inner_triangles.map(|t| t.map(|corner| corner + 8))).collect();
    let vertices_mm = outer.points.into_iter().chain(inner.points).map(<[f64; 3]>::from).collect();
    Specimen::Mesh { vertices_mm, triangles, built: Built::default() }
}

/// Records all stages; its clock advances by a hundredth of a second at every question.
#[derive(Default)]
struct Diary {
    told: Mutex<Vec<(Stage, f64)>>,
    asked: AtomicU32,
}

impl Watch for Diary {
    fn stage(&self, stage: Stage, share: f64) {
        self.told.lock().unwrap().push((stage, share));
    }

    fn seconds(&self) -> f64 {
        f64::from(self.asked.fetch_add(1, Ordering::Relaxed)) / 100.0
    }
}

/// A spec of 12,000 triangles, which are proved anew: no copy of it was.
fn of_many_triangles() -> Spec {
    let text = "fraction = 0.02\n[grading]\nd_min_mm = 3\nd_max_mm = 5";
    Spec { specimen: cubed_cubes(10, 8.0), ..Spec::from_toml(text).unwrap() }
}

#[test]
fn the_proof_of_a_surface_is_a_stage_before_the_others_and_changes_nothing() {
    let diary = Diary::default();
    let model = pack(&of_many_triangles(), &diary).unwrap();
    assert!(model.aggregates == pack(&of_many_triangles(), &Silent).unwrap().aggregates);
    let told = diary.told.into_inner().unwrap();
    let reading = told.iter().take_while(|(stage, _)| *stage == Stage::Read).count();
    assert!(told[reading..].iter().all(|(stage, _)| *stage != Stage::Read) && told[reading].0 == Stage::Take);
    assert_eq!(told[reading - 1].1, 1.0);
    // A share of the triangles after every 1,024.
    let within = told[..reading].iter().filter(|(_, share)| (0.41..0.8).contains(share)).count();
    assert!((10..=12).contains(&within), "{:?}", &told[..reading]);
}

#[test]
fn a_time_limit_ends_the_proof_of_a_surface_and_says_how_far_it_came() {
    let mut spec = of_many_triangles();
    spec.placement.time_limit_s = Some(0.05);
    let diary = Diary::default();
    let error = pack(&spec, &diary).unwrap_err();
    assert!(error.is_late, "{error}");
    let text = error.to_string();
    let start = "placement.time_limit_s is 0.05, which was over before the specimen's surface was proved: ";
    let percent =
        text.strip_prefix(start).and_then(|rest| rest.split_once(" % of its 12000 triangles were; allow more"));
    let percent: u32 = percent.unwrap_or_else(|| panic!("{text}")).0.parse().unwrap();
    assert!((10..90).contains(&percent), "{text}");
    // Without a clock there is no limit.
    assert!(pack(&spec, &Silent).is_ok());
}

#[test]
fn pieces_of_a_surface_on_the_wrong_side_of_others_are_refused() {
    assert_eq!(nested(7.0, true).check().unwrap().volume(), 8000.0 - 216.0);
    assert_eq!(nested(27.0, false).check().unwrap().volume(), 8000.0 + 216.0);
    for wrong in [nested(7.0, false), nested(27.0, true)] {
        let error = wrong.check().unwrap_err().to_string();
        assert!(error.starts_with("a component of its surface, at (") && error.contains("or remove it"), "{error}");
    }
}

#[test]
fn a_class_that_fits_into_no_component_of_a_surface_is_named_before_the_work() {
    for (edge, class) in [(5.0, "10-15 mm"), (8.0, "15-20 mm")] {
        let spec = Spec { fraction: 0.3, specimen: cubes(edge), ..Spec::default() };
        let error = pack(&spec, &Silent).unwrap_err();
        assert_eq!(error.key, "grading.classes_mm");
        assert!(error.message.contains(class) && error.message.contains("fits into the specimen"), "{error}");
        // Cubes hold no ball wider than they are, nor a line longer than their diagonal.
        assert!(error.message.contains(&format!("longer than {:.2}", edge * 3f64.sqrt() + 0.005)), "{error}");
        assert!(spec.doubts()[0].contains("more than this strategy reached in tests"), "{:?}", spec.doubts());
    }
}

#[test]
fn grains_too_large_for_a_specimen_in_pieces_are_left_out_and_reported() {
    let mut spec = Spec { fraction: 0.2, specimen: cubes(10.0), ..Spec::default() };
    for strategy in [Strategy::TakeAndPlace, Strategy::Rearrange] {
        spec.placement.strategy = strategy;
        spec.placement.attempts = (strategy == Strategy::TakeAndPlace).then_some(200);
        let model = pack(&spec, &Silent).unwrap();
        assert_eq!(check(&model).findings, []);
        let detail = &model.report.stop_detail;
        assert!(model.report.aggregates > 50 && detail.ends_with("grains are too large for the specimen"), "{detail}");
    }
}

#[test]
fn the_surface_of_every_specimen_is_closed_and_encloses_nearly_its_volume() {
    let kinds = [
        Specimen::cuboid([30.0, 40.0, 50.0]),
        Specimen::Cylinder { diameter_mm: 60.0, height_mm: 70.0 },
        Specimen::Sphere { diameter_mm: 75.0 },
        frustum(),
        notched(),
        moved_angle_piece(),
        Specimen::Dogbone {
            length_mm: 150.0,
            width_mm: 100.0,
            thickness_mm: 40.0,
            neck_width_mm: 60.0,
            neck_length_mm: 20.0,
            radius_mm: 30.0,
        },
    ];
    for specimen in kinds {
        let (container, surface) = (specimen.container(), specimen.container().surface());
        let six: f64 = surface
            .triangles()
            .map(|t| t.map(|i| surface.points[i as usize]))
            .map(|[a, b, c]| a.dot(&b.cross(&c)))
            .sum();
        assert!((six / 6.0 / container.volume() - 1.0).abs() < 2e-3, "{}: {}", specimen.kind(), six / 6.0);
        let mut edges: Vec<(u32, u32)> = Vec::new();
        for face in &surface.faces {
            edges.extend((0..face.len()).map(|k| (face[k], face[(k + 1) % face.len()])));
        }
        edges.sort_unstable();
        assert!(edges.iter().all(|&(a, b)| edges.binary_search(&(b, a)).is_ok()), "{} is open", specimen.kind());
        assert!(container.depth(&(container.aabb().max * 2.0)).is_sign_negative());
        assert!(container.contains(&(container.aabb().max * 0.25)));
    }
}

#[test]
fn a_surface_that_changes_after_its_proof_is_proved_anew() {
    let mut specimen = moved_angle_piece();
    let mut spec = Spec { specimen: specimen.clone(), ..Spec::default() };
    spec.validate().unwrap();
    let Specimen::Mesh { vertices_mm, .. } = &mut specimen else { unreachable!("it is a surface of triangles") };
    vertices_mm.iter_mut().for_each(|vertex| vertex[0] = -vertex[0]);
    spec.specimen = specimen;
    let error = spec.validate().unwrap_err().to_string();
    assert!(error.contains("counter-clockwise"), "{error}");
}
