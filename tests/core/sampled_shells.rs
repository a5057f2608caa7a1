//! Shells of ellipsoids and of grains with dents, whose volumes are sampled: beside closed forms, and as one of them is proved.

use crate::angle_piece::angle_piece;
use crate::concrete::stones::stone_and_its_dented_twin;
use crate::pack::folder::Folder;
use crate::shells::shelled;
use meso_core::aggregate::Aggregate;
use meso_core::check::{Finding, check};
use meso_core::geometry::{BodyForm, Polyhedron, Round, TriangleMesh};
use meso_core::math::{Rotation, Vec3};
use meso_core::mesh::{self, ItzForm, MeshOptions, Method, Phase, PhaseVolumes, Tools};
use meso_core::specimen::Specimen;
use meso_core::statistics::{Statistics, StatisticsOptions};
use meso_core::voxel_image::{ImageOptions, VoxelImage, Voxels};
use meso_core::{Model, Silent, Spec, pack, page, saved};
use std::f64::consts::PI;

/// Turns faces away from the axes, along which cubes are counted.
fn turned() -> Rotation {
    Rotation::from_euler_angles(0.3, 0.5, 0.2)
}

/// A prism whose section is an L with arms 3 mm wide in a square of 8 mm, 6 mm high.
fn angle() -> Polyhedron {
    let place = |corner: [f64; 3]| (turned() * Vec3::from(corner)).into();
    let Specimen::Mesh { vertices_mm, triangles, .. } = angle_piece([8.0, 3.0, 6.0], place) else { unreachable!() };
    let vertices = vertices_mm.into_iter().map(Vec3::from).collect();
    Polyhedron::of_surface(&TriangleMesh { vertices, triangles })
}

/// Points of the angle deeper than `t` mm: along its inner edge they end in a round.
fn within_angle(t: f64) -> f64 {
    ((8.0 - 2.0 * t).powi(2) - 25.0 + (1.0 - PI / 4.0) * t * t) * (6.0 - 2.0 * t)
}

/// Points of an ellipsoid of semi-axes a, a, c > a deeper than `t` mm, below its least radius of curvature a^2 / c: V - S t +
/// M t^2 - 4/3 pi t^3 (Steiner's formula), where M is the integral of its support function over all directions.
fn within_spheroid(a: f64, c: f64, t: f64) -> f64 {
    let (e, d) = ((1.0 - a * a / (c * c)).sqrt(), (c * c - a * a).sqrt());
    let surface = 2.0 * PI * a * a * (1.0 + c / (a * e) * libm::asin(e));
    let mean = 2.0 * PI * (c + a * a / d * libm::asinh(d / a));
    4.0 / 3.0 * PI * (a * a * c - t.powi(3)) - surface * t + mean * t * t
}

#[test]
fn layers_have_the_volumes_of_closed_forms_to_the_stated_error() {
    let ball = |t: f64| 4.0 / 3.0 * PI * (6.0 - t).powi(3);
    let ellipsoid = |axes: [f64; 3]| Polyhedron::of_round(&Round::of_semi_axes(&Vec3::from(axes)));
    let [convex, twin] = stone_and_its_dented_twin();
    for (name, body, exact) in [
        ("nearly a ball", ellipsoid([6.0, 6.0, 6.0 - 1e-6]), &ball as &dyn Fn(f64) -> f64),
        ("spheroid", ellipsoid([6.0, 4.0, 4.0]), &|t| within_spheroid(4.0, 6.0, t)),
        ("angle", angle(), &within_angle),
        ("twin", twin, &|t| convex.inward_offset(t).unwrap().unwrap().volume()),
    ] {
        let grain = shelled(body, 0.1, &[0.3, 0.05, 0.1, 0.55]);
        let volumes = grain.layer_volumes(0.1).unwrap();
        let depths = [0.1, 0.4, 0.45, 0.55, 1.1];
        assert_eq!(volumes.len(), depths.len());
        for (k, (phase, volume)) in volumes.iter().enumerate() {
            let wanted = exact(depths[k]) - depths.get(k + 1).map_or(0.0, |deeper| exact(*deeper));
            assert!((volume / wanted - 1.0).abs() < 0.01, "{name} {k}: {volume} {wanted}");
            assert_eq!(*phase, if k == 4 { Phase::Aggregate } else { Phase::Own(k as u8) });
        }
        let thick = shelled(grain.body.clone(), 0.1, &[1.0]).layer_volumes(0.1).unwrap();
        let sum: f64 = volumes[..4].iter().map(|(_, volume)| volume).sum();
        assert!((sum / thick[0].1 - 1.0).abs() < 1e-12, "{sum} {thick:?}");
    }
}

/// Ellipsoids, and stones of a scan, with an ITZ of 0.2 mm and shells of these thicknesses.
fn texts(shells: &[(&str, [f64; 2])]) -> [String; 2] {
    ["kind = 'ellipsoid'", "kind = 'harmonics'\npath = 'a.dat'\ntriangles = 160"].map(|shape| {
        let entry = |(name, mm): &(&str, [f64; 2])| format!("\n[[shape.shells]]\nname = '{name}'\nthickness_mm = {mm:?}");
        let entries: String = shells.iter().map(entry).collect();
        format!(
            "fraction = 0.2\nspecimen = {{ kind = 'cube', side_mm = 24 }}\ngrading = {{ d_min_mm = 10, d_max_mm = 13 }}\n\
             itz.thickness_mm = [0.2, 0.2]\nplacement.min_gap_mm = 0.5\n[shape]\n{shape}{entries}"
        )
    })
}

fn spec(text: &str) -> Result<Spec, String> {
    let mut folder = Folder(&[("a.dat", include_bytes!("../concrete/stone.dat"))]);
    Spec::from_toml_with(text, &mut folder).map_err(|error| error.to_string())
}

pub(crate) fn models(shells: &[(&str, [f64; 2])]) -> [Model; 2] {
    texts(shells).map(|text| pack(&spec(&text).unwrap(), &Silent).unwrap())
}

fn labels(model: &Model, voxel_size_mm: f64) -> Vec<u8> {
    let image = VoxelImage::new(model, &ImageOptions { voxel_size_mm, ..ImageOptions::default() }).unwrap();
    let Voxels::Label(labels) = image.layers(0..image.counts()[2]) else { panic!("labels") };
    labels
}

const TWO: [(&str, [f64; 2]); 2] = [("rim", [0.3, 0.5]), ("bond", [0.4, 0.4])];

#[test]
fn report_images_meshes_and_files_have_the_shells() {
    for (model, form) in models(&TWO).into_iter().zip(["round", "dents"]) {
        let is_form = |body: &Aggregate| (body.body.form() == BodyForm::Surface) == (form == "dents");
        assert!(model.aggregates.len() > 2 && model.aggregates.iter().all(is_form));
        assert_eq!(check(&model).findings, []);
        let layers = model.aggregates.iter().flat_map(|body| body.layer_volumes(0.2).unwrap());
        let exact = layers.fold([0.0; 8], |mut sums, (phase, volume)| {
            sums[phase.index()] += volume;
            sums
        });
        let few = StatisticsOptions { lines: 50, points: 500, ..StatisticsOptions::quick() };
        let mut html = Vec::new();
        page::write(&model, &Statistics::of(&model, &few).unwrap(), None, &mut html).unwrap();
        let html = String::from_utf8(html).unwrap();
        assert!([5, 6].iter().all(|label| html.matches(&format!("class=\"p{label}\"")).count() > 5), "{form}");
        assert!(html.contains("shells of rim") && html.contains("class=\"c0\""), "{form}");
        let counted = labels(&model, 0.2).into_iter().fold([0.0; 8], |mut sums, label| {
            sums[usize::from(label)] += 0.008;
            sums
        });
        for phase in [Phase::Own(0), Phase::Own(1), Phase::Aggregate] {
            let (counted, exact) = (counted[phase.index()], exact[phase.index()]);
            assert!((counted / exact - 1.0).abs() < 0.005, "{form} {phase:?}: {counted} {exact}");
        }
        let [rim, bond] = &model.report.shells[..] else { panic!("two shells") };
        assert_eq!((rim.phase.as_str(), bond.phase.as_str()), ("rim", "bond"));
        assert!((rim.volume_mm3 / exact[5] - 1.0).abs() < 1e-12 && (bond.volume_mm3 / exact[6] - 1.0).abs() < 1e-12);
        for (method, element_size_mm, off) in [(Method::VOXEL, 0.4, 0.005), (Method::FITTED, 0.8, 0.07)] {
            let options = MeshOptions { method, element_size_mm, itz: ItzForm::Smeared, ..MeshOptions::default() };
            let mesh = mesh::build(&model, &options, &Tools::default()).unwrap();
            let meshed = PhaseVolumes::of_bodies(&mesh);
            let exact = PhaseVolumes::exact_for(&mesh, &model.aggregates, &model.spec.specimen).unwrap();
            for phase in [Phase::Own(0), Phase::Own(1), Phase::Aggregate] {
                let (meshed, exact) = (meshed.of(phase), exact.of(phase));
                assert!((meshed / exact - 1.0).abs() < off, "{form} {method:?} {phase:?}: {meshed} {exact}");
            }
        }
        let mut bytes = Vec::new();
        saved::write(&model, &mut bytes).unwrap();
        let read = saved::read(&bytes).unwrap();
        assert_eq!(read.aggregates, model.aggregates);
        let changed = |change: &dyn Fn(&mut Model)| {
            let mut model = read.clone();
            change(&mut model);
            check(&model).findings
        };
        let thicker = changed(&|model| model.aggregates[0].shells[1].thickness_mm += 1e-12);
        assert!(thicker.iter().any(|finding| matches!(finding, Finding::NotTaken { .. })), "{thicker:?}");
        let without_core = changed(&|model| model.aggregates[0].shells[1].thickness_mm = 7.0);
        assert!(without_core.iter().any(|finding| matches!(finding, Finding::Itz { .. })), "{without_core:?}");
        let reported = changed(&|model| model.report.shells[0].volume_mm3 *= 1.001);
        assert!(reported.iter().any(|finding| matches!(finding, Finding::Report { .. })), "{reported:?}");
    }
}

#[test]
fn three_shells_have_the_voxels_and_cells_of_one_that_is_as_thick() {
    let ones = models(&[("rim", [0.9, 0.9])]);
    let threes = models(&["a", "b", "c"].map(|name| (name, [0.3, 0.3])));
    // The first phase of a specimen's own is 5.
    let merged = |phases: Vec<u8>| phases.into_iter().map(|phase| phase.min(5)).collect::<Vec<_>>();
    for (one, three) in ones.iter().zip(&threes) {
        let all = labels(three, 0.4);
        assert!((5..8).all(|label| all.contains(&label)) && labels(one, 0.4) == merged(all));
        for method in [Method::VOXEL, Method::FITTED] {
            let options = MeshOptions { method, element_size_mm: 0.8, itz: ItzForm::Smeared, ..MeshOptions::default() };
            let cells = |model: &Model| {
                let mesh = mesh::build(model, &options, &Tools::default()).unwrap();
                mesh.phase.iter().map(|phase| phase.index() as u8).collect::<Vec<_>>()
            };
            let cells = (cells(one), cells(three));
            assert!(cells.1.contains(&7) && cells.0 == merged(cells.1), "{method:?}");
        }
    }
}

#[test]
fn shells_that_leave_no_core_are_refused() {
    for text in texts(&[("rim", [3.0, 4.0])]) {
        let said = pack(&spec(&text).unwrap(), &Silent).unwrap_err().to_string();
        assert!(
            said.contains("leave no core in ") && said.contains("take thinner shells, volume_share, round"),
            "{said}"
        );
    }
}

#[test]
fn a_volume_share_is_met_to_the_error_of_sampled_volumes() {
    for text in texts(&[("rim", [0.0, 0.0]), ("crust", [0.1, 0.2])]) {
        let text = text.replace("thickness_mm = [0.0, 0.0]", "volume_share = 0.3");
        let spheroids = text.replace(
            "'ellipsoid'",
            "'ellipsoid'\nelongation = { law = 'constant', value = 0.7 }\n\
                                      flatness = { law = 'constant', value = 1.0 }",
        );
        let model = pack(&spec(&spheroids).unwrap(), &Silent).unwrap();
        assert!(model.aggregates.len() > 2);
        for grain in &model.aggregates {
            let volumes = grain.layer_volumes(0.2).unwrap();
            // The grain was turned after its take, and cubes are counted along the axes.
            let inside: f64 = volumes.iter().map(|(_, volume)| volume).sum();
            assert!((volumes[0].1 / inside - 0.3).abs() < 0.003, "{volumes:?}");
            if let BodyForm::Round(round) = grain.body.form() {
                let axes = round.semi_axes();
                let within = |t| within_spheroid(axes[1], axes[0], t);
                let share = 1.0 - within(0.2 + grain.shells[0].thickness_mm) / within(0.2);
                assert!((share - 0.3).abs() < 0.001, "{share}");
            }
        }
        assert_eq!(check(&model).findings, []);
    }
}
