//! Nested shells of grains: volumes, order, proof, and the same labels in images and meshes.

use crate::mesh::voxel::block;
use meso_core::aggregate::{Aggregate, Kind, Shell};
use meso_core::check::{Finding, check};
use meso_core::mesh::{self, ItzForm, MeshOptions, Method, Phase, PhaseVolumes, Tools};
use meso_core::voxel_image::{ImageOptions, VoxelImage, Voxels};
use meso_core::{Model, Silent, Spec, pack, saved};
use std::sync::LazyLock;

/// Recycled concrete: half of the grains have old mortar and, below it, an old ITZ.
const RECYCLED: &str = "fraction = 0.35\nspecimen = { kind = 'cube', side_mm = 50 }\n\
    grading = { d_min_mm = 8, d_max_mm = 16, classes_mm = [8, 16] }\nitz.thickness_mm = [0.2, 0.3]\n\
    [[phases]]\nname = 'recycled'\nshare = 0.5\n\
    [[shape.shells]]\nname = 'old_mortar'\nvolume_share = 0.3\nof = 'recycled'\n\
    [[shape.shells]]\nname = 'old_itz'\nthickness_mm = [0.05, 0.1]\nof = 'recycled'\n";

pub(crate) fn packed(text: &str) -> Model {
    pack(&Spec::from_toml(text).unwrap(), &Silent).unwrap()
}

pub(crate) fn recycled() -> &'static Model {
    static MODEL: LazyLock<Model> = LazyLock::new(|| packed(RECYCLED));
    &MODEL
}

pub(crate) fn shelled(body: meso_core::geometry::Polyhedron, itz: f64, thicknesses: &[f64]) -> Aggregate {
    let shell = |(own, &thickness_mm): (usize, &f64)| Shell { own: own as u8, thickness_mm, outward: false };
    let shells = thicknesses.iter().enumerate().map(shell).collect();
    Aggregate { id: 0, kind: Kind::Aggregate, own: None, class: 0, itz_thickness_mm: itz, shells, body }
}

#[test]
fn layers_of_a_box_have_the_volumes_of_boxes_and_the_phases_of_their_depths() {
    let grain = shelled(block([1.0; 3], [11.0, 13.0, 15.0]), 0.5, &[0.25, 0.75, 1.0]);
    let inside = |t: f64| (10.0 - 2.0 * t) * (12.0 - 2.0 * t) * (14.0 - 2.0 * t);
    let depths = [0.5, 0.75, 1.5, 2.5];
    let volumes = grain.layer_volumes(0.5).unwrap();
    for (k, (phase, volume)) in volumes.iter().enumerate() {
        let within = depths.get(k + 1).map_or(0.0, |depth| inside(*depth));
        assert!((volume / (inside(depths[k]) - within) - 1.0).abs() < 1e-12, "{k}");
        assert_eq!(*phase, if k == 3 { Phase::Aggregate } else { Phase::Own(k as u8) });
        assert_eq!(grain.phase_at(depths[k] + 1e-9), *phase);
    }
    assert_eq!((volumes.len(), grain.phase_at(0.1), grain.phase_at(9.0)), (4, Phase::Own(0), Phase::Aggregate));
}

#[test]
fn a_volume_share_is_met_in_every_grain_and_shells_move_no_body() {
    let model = recycled();
    let plain = packed(RECYCLED.split("[[phases]]").next().unwrap());
    let strip = |grain: &Aggregate| Aggregate { own: None, shells: Vec::new(), ..grain.clone() };
    assert!(model.aggregates.iter().map(strip).eq(plain.aggregates.iter().cloned()));
    for grain in &model.aggregates {
        assert_eq!(grain.shells.len(), if grain.own == Some(0) { 2 } else { 0 });
        if grain.own == Some(0) {
            let volumes = grain.layer_volumes(grain.itz_thickness_mm).unwrap();
            // The grain was turned after its take, and its corners were rounded again.
            let inside: f64 = volumes.iter().map(|(_, volume)| volume).sum();
            assert!((volumes[0].1 / inside - 0.3).abs() < 1e-8, "{volumes:?}");
            assert_eq!((volumes[0].0, volumes[1].0, volumes[2].0), (Phase::Own(1), Phase::Own(2), Phase::Own(0)));
            assert!((0.05..0.1).contains(&grain.shells[1].thickness_mm));
        }
    }
    let report = &model.report;
    let [mortar, itz] = &report.shells[..] else { panic!("two shells") };
    assert_eq!((mortar.phase.as_str(), itz.phase.as_str()), ("old_mortar", "old_itz"));
    let own = model.aggregates.iter().filter(|grain| grain.own == Some(0));
    let inside: f64 = own.map(|grain| grain.core_volume(grain.itz_thickness_mm).unwrap()).sum();
    assert!((mortar.volume_mm3 / inside - 0.3).abs() < 1e-8 && itz.volume_mm3 > 0.0);
    assert_eq!(check(model).findings, []);
}

#[test]
fn a_thickness_follows_the_size_of_its_grain_by_a_share_and_by_rows() {
    const SPHERES: &str = "fraction = 0.3\nspecimen = { kind = 'cube', side_mm = 40 }\nshape.kind = 'sphere'\n\
        grading = { d_min_mm = 4, d_max_mm = 10, classes_mm = [4, 7, 10] }\nitz.thickness_mm = [0.1, 0.1]\n\
        [[shape.shells]]\nname = 'coat'\nsize_share = [0.05, 0.1]\n\
        [[shape.shells]]\nname = 'rim'\nthickness_over_size_mm = [[5, 0.2], [8, 0.5]]\n";
    let model = packed(SPHERES);
    assert!(model.aggregates.len() > 50);
    let (mut least, mut most) = (1.0f64, 0.0f64);
    for grain in &model.aggregates {
        let radius = (grain.body.volume() * 0.75 / std::f64::consts::PI).cbrt();
        let share = grain.shells[0].thickness_mm / (2.0 * radius);
        (least, most) = (least.min(share), most.max(share));
        let along = ((2.0 * radius / 5.0).ln() / 1.6f64.ln()).clamp(0.0, 1.0);
        assert!((grain.shells[1].thickness_mm - 0.2 - 0.3 * along).abs() < 1e-7, "{radius} {:?}", grain.shells);
        let mut outer = radius - 0.1;
        for ((_, volume), thickness) in
            grain.layer_volumes(0.1).unwrap().iter().zip(grain.shells.iter().map(|shell| shell.thickness_mm))
        {
            let ball = |radius: f64| radius.powi(3) * 4.0 / 3.0 * std::f64::consts::PI;
            assert!((volume / (ball(outer) - ball(outer - thickness)) - 1.0).abs() < 1e-9);
            outer -= thickness;
        }
    }
    assert!(0.05 - 1e-7 < least && least < 0.053 && 0.097 < most && most < 0.1 + 1e-7, "{least} {most}");
    assert_eq!(check(&model).findings, []);
}

#[test]
fn shells_are_read_back_equal_and_check_finds_others() {
    let mut bytes = Vec::new();
    saved::write(recycled(), &mut bytes).unwrap();
    let read = saved::read(&bytes).unwrap();
    assert_eq!(read.aggregates, recycled().aggregates);
    let changed = |change: &dyn Fn(&mut Aggregate)| {
        let mut model = read.clone();
        change(model.aggregates.iter_mut().find(|grain| !grain.shells.is_empty()).unwrap());
        check(&model).findings
    };
    let thicker = changed(&|grain| grain.shells[1].thickness_mm *= 1.0 + 1e-12);
    assert!(thicker.iter().any(|finding| matches!(finding, Finding::NotTaken { .. })), "{thicker:?}");
    let without_core = changed(&|grain| grain.shells[1].thickness_mm = 9.0);
    assert!(without_core.iter().any(|finding| matches!(finding, Finding::Itz { .. })), "{without_core:?}");
    let text = String::from_utf8(bytes).unwrap();
    let unsealed = text.split(",\n\"crc32\"").next().unwrap().to_owned() + "}";
    let start = unsealed.find("\"shells_mm\":[").unwrap();
    let end = start + unsealed[start..].find(']').unwrap();
    let one = format!("{}\"shells_mm\":[1.0{}", &unsealed[..start], &unsealed[end..]);
    let said = saved::read(one.as_bytes()).unwrap_err().to_string();
    assert!(said.ends_with("its shells_mm are [1.0]; the spec gives it 2 shells of 0 mm or more"), "{said}");
}

#[test]
fn images_and_meshes_have_the_layers_within_their_resolution() {
    let model = recycled();
    let exact = PhaseVolumes::exact(&model.aggregates, &model.spec.specimen, |grain| grain.itz_thickness_mm).unwrap();
    let image = VoxelImage::new(model, &ImageOptions { voxel_size_mm: 0.25, ..ImageOptions::default() }).unwrap();
    let Voxels::Label(labels) = image.layers(0..image.counts()[2]) else { panic!("labels") };
    for (label, phase, off) in [(5, Phase::Own(0), 0.005), (6, Phase::Own(1), 0.005), (7, Phase::Own(2), 0.02)] {
        let volume = labels.iter().filter(|own| **own == label).count() as f64 * 0.25f64.powi(3);
        assert!((volume / exact.of(phase) - 1.0).abs() < off, "{phase:?} {volume} {}", exact.of(phase));
    }
    for (method, element_size_mm, off) in [(Method::VOXEL, 0.5, 0.02), (Method::FITTED, 1.0, 0.06)] {
        let options = MeshOptions { method, element_size_mm, itz: ItzForm::None, ..MeshOptions::default() };
        let mesh = mesh::build(model, &options, &Tools::default()).unwrap();
        let (volumes, exact) = (
            PhaseVolumes::of_mesh(&mesh),
            PhaseVolumes::exact_for(&mesh, &model.aggregates, &model.spec.specimen).unwrap(),
        );
        for phase in [Phase::Own(0), Phase::Own(1), Phase::Aggregate] {
            assert!((volumes.of(phase) / exact.of(phase) - 1.0).abs() < off, "{phase:?} {volumes:?} {exact:?}");
        }
    }
}

/// Issue 69: images of n equal shells are those of one that is as thick.
#[test]
fn four_shells_have_the_voxels_and_cells_of_one_that_is_as_thick() {
    const PLAIN: &str = "fraction = 0.35\nspecimen = { kind = 'cube', side_mm = 40 }\n\
        grading = { d_min_mm = 8, d_max_mm = 16, classes_mm = [8, 16] }\nitz.thickness_mm = [0.2, 0.3]\n";
    let coated = |names: &[&str]| {
        let thickness = 1.0 / names.len() as f64;
        let entry = |name| format!("[[shape.shells]]\nname = '{name}'\nthickness_mm = [{thickness}, {thickness}]\n");
        packed(&format!("{PLAIN}{}", names.iter().map(entry).collect::<String>()))
    };
    let [one, four] = [coated(&["rim"]), coated(&["a", "b", "c", "d"])];
    // The first phase of a specimen's own is 5.
    let merged = |phases: Vec<u8>| phases.into_iter().map(|phase| phase.min(5)).collect::<Vec<_>>();
    let image = |model: &Model| {
        let image = VoxelImage::new(model, &ImageOptions { voxel_size_mm: 0.5, ..ImageOptions::default() }).unwrap();
        let Voxels::Label(labels) = image.layers(0..image.counts()[2]) else { panic!("labels") };
        labels.to_vec()
    };
    assert!(image(&four).contains(&8) && image(&one) == merged(image(&four)));
    for (method, element_size_mm) in [(Method::VOXEL, 0.5), (Method::FITTED, 1.0)] {
        let options = MeshOptions { method, element_size_mm, itz: ItzForm::Smeared, ..MeshOptions::default() };
        let cells = |model: &Model| {
            let mesh = mesh::build(model, &options, &Tools::default()).unwrap();
            mesh.phase.iter().map(|phase| phase.index() as u8).collect::<Vec<_>>()
        };
        assert!(cells(&one) == merged(cells(&four)), "{method:?}");
    }
}

/// Grains of `kind` in a cube, with `shells`, and the same without.
fn coated(kind: &str, side_mm: u32, shells: &str) -> [Model; 2] {
    let text = format!(
        "fraction = 0.25\nspecimen = {{ kind = 'cube', side_mm = {side_mm} }}\nshape.kind = '{kind}'\n\
         grading = {{ d_min_mm = 4, d_max_mm = 16, classes_mm = [4, 8, 16] }}\nitz.thickness_mm = [0.1, 0.2]\n"
    );
    [packed(&format!("{text}{shells}")), packed(&text)]
}

const COATING: &str = "[[shape.shells]]\nname = 'skin'\nthickness_mm = [0.1, 0.3]\noutward = true\n\
    [[shape.shells]]\nname = 'coat'\nsize_share = [0.01, 0.02]\noutward = true\n\
    [[shape.shells]]\nname = 'rim'\nvolume_share = 0.2\n";

/// Grains are kept in single precision, and those that were turned on a lattice of 2^-30 mm.
const STONE_ROUNDING: f64 = 2e-7;

#[test]
fn stones_within_coatings_are_the_grains_without_and_meet_the_grading() {
    for kind in ["polyhedron", "crushed", "sphere"] {
        let [model, plain] = coated(kind, 80, COATING);
        let in_order = |model: &Model| {
            let mut stones: Vec<_> =
                model.aggregates.iter().map(|grain| (grain.class, grain.graded().volume())).collect();
            stones.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
            stones
        };
        let (stones, bare) = (in_order(&model), in_order(&plain));
        assert!(stones.len() > 100 && stones.len() == bare.len(), "{kind} {} {}", stones.len(), bare.len());
        let off = stones.iter().zip(&bare).map(|(a, b)| (a.1 / b.1 - 1.0).abs()).fold(0.0, f64::max);
        assert!(off < STONE_ROUNDING, "{kind} {off:e}");
        for class in &model.report.classes {
            assert!((class.fraction / class.target_fraction - 1.0).abs() < 0.01, "{kind} {class:?}");
        }
        for grain in &model.aggregates {
            let layers: Vec<f64> = grain.layers().map(|(depth, _)| depth).collect();
            let coating = grain.itz_thickness_mm + grain.shells[0].thickness_mm + grain.shells[1].thickness_mm;
            assert_eq!(layers[2], coating);
            let volumes = grain.layer_volumes(grain.itz_thickness_mm).unwrap();
            assert!((volumes[2].1 / grain.graded().volume() - 0.2).abs() < 1e-6, "{kind} {volumes:?}");
        }
        let report = &model.report;
        let bodies: f64 = model.aggregates.iter().map(|grain| grain.body.volume()).sum();
        let whole = report.coated_fraction.unwrap();
        assert!((whole * report.specimen.volume_mm3 / bodies - 1.0).abs() < 1e-12 && whole > 1.1 * report.fraction);
        assert_eq!((plain.report.coated_fraction, check(&model).findings), (None, vec![]), "{kind}");
        let mut bytes = Vec::new();
        saved::write(&model, &mut bytes).unwrap();
        assert_eq!(saved::read(&bytes).unwrap().aggregates, model.aggregates);
        for bare in &plain.aggregates {
            let again = bare.body.outward_offset(0.7).unwrap().inward_offset(0.7).unwrap().unwrap();
            assert!((again.volume() / bare.body.volume() - 1.0).abs() < 1e-12, "{kind}");
        }
    }
}

#[test]
fn layers_of_tetrahedra_and_voxels_have_the_coatings() {
    let coat = "[[shape.shells]]\nname = 'coat'\nthickness_mm = [0.4, 0.6]\noutward = true\n";
    let [model, _] = coated("polyhedron", 40, coat);
    let exact = PhaseVolumes::exact(&model.aggregates, &model.spec.specimen, |grain| grain.itz_thickness_mm).unwrap();
    let stones: f64 = model.aggregates.iter().map(|grain| grain.graded().volume()).sum();
    assert!((exact.of(Phase::Aggregate) / stones - 1.0).abs() < 1e-9 && exact.of(Phase::Own(0)) > 0.2 * stones);
    for (method, element_size_mm, itz, off) in
        [(Method::VOXEL, 0.5, ItzForm::None, 0.02), (Method::FITTED, 2.0, ItzForm::Solid, 0.1)]
    {
        let options = MeshOptions { method, element_size_mm, itz, ..MeshOptions::default() };
        let mesh = mesh::build(&model, &options, &Tools::default()).unwrap();
        let exact = PhaseVolumes::exact_for(&mesh, &model.aggregates, &model.spec.specimen).unwrap();
        let volumes = PhaseVolumes::of_mesh(&mesh);
        for phase in [Phase::Own(0), Phase::Aggregate] {
            assert!(
                (volumes.of(phase) / exact.of(phase) - 1.0).abs() < off,
                "{method:?} {phase:?} {volumes:?} {exact:?}"
            );
        }
    }
}

#[test]
fn take_and_place_fills_its_classes_with_stones_of_a_phase() {
    let shells = format!(
        "placement.strategy = 'take-and-place'\n[[phases]]\nname = 'slag'\nshare = 0.5\n{}",
        COATING.replace("\n[[", "\nof = 'slag'\n[[")
    );
    let [model, plain] = coated("polyhedron", 80, &shells);
    let slag = &model.report.own_phases[0];
    assert!(model.report.fraction >= 0.99 * plain.report.fraction, "{:?}", model.report.stop_detail);
    assert!((slag.fraction / slag.target_fraction - 1.0).abs() < 0.05, "{slag:?}");
    assert_eq!(check(&model).findings, []);
}

/// Polyhedra of 5 to 20 mm, a fraction of 0.45 and coatings of this thickness, which make bodies of 1.2 to 3 times the stones.
fn thickly_coated(thickness_mm: f64, more: &str) -> Spec {
    let text = format!(
        "fraction = 0.45\nspecimen = {{ kind = 'cube', side_mm = 60 }}\nitz.thickness_mm = [0, 0]\n{more}\n\
         [[shape.shells]]\nname = 'coat'\nthickness_mm = [{thickness_mm}, {thickness_mm}]\noutward = true\n"
    );
    Spec::from_toml(&text).unwrap()
}

#[test]
fn a_fraction_is_judged_with_its_coatings() {
    for (kind, thickness_mm) in [("sphere", 0.3), ("rounded", 0.3), ("crushed", 0.2)] {
        let mut spec = thickly_coated(thickness_mm, &format!("shape.kind = '{kind}'"));
        spec.fraction = 0.25;
        let (foreseen, placed) = (spec.crowding(), pack(&spec, &Silent).unwrap().report.coated_fraction.unwrap());
        // Mitred edges of polyhedra take more than the ball's growth.
        let most = if kind == "sphere" { 0.01 } else { 0.1 };
        assert!((-0.01..most).contains(&(placed / foreseen - 1.0)) && foreseen > 0.28, "{kind} {placed} {foreseen}");
    }
    let refused = |spec: &Spec| pack(spec, &Silent).map(|model| model.report.fraction).unwrap_err();
    let error = refused(&thickly_coated(2.0, ""));
    assert!(
        error.key == "fraction" && error.message.contains("is 0.45, which leaves no room for the coatings"),
        "{error}"
    );
    assert!(error.message.contains("take thinner outward shape.shells or a lower fraction"), "{error}");
    let error = refused(&thickly_coated(0.5, "placement.min_gap_mm = 2.5"));
    assert!(
        error.key == "placement.min_gap_mm" && error.message.contains("lower the gap, the coatings or the"),
        "{error}"
    );
    let doubt = |spec: &Spec| spec.doubts().into_iter().next();
    let dense = doubt(&thickly_coated(0.75, "")).unwrap();
    assert!(
        dense.contains("0.45 with its coatings is as dense as 0.") && dense.contains("thinner outward shape."),
        "{dense}"
    );
    assert_eq!(doubt(&thickly_coated(0.1, "")), None);
    // Of a phase that is a tenth of the stones.
    let tenth = thickly_coated(2.0, "").to_json().unwrap().replace("\"outward\"", "\"of\":\"slag\",\"outward\"");
    let mut tenth: serde_json::Value = serde_json::from_str(&tenth).unwrap();
    tenth["phases"] = serde_json::json!([{ "name": "slag", "share": 0.1 }]);
    assert!((0.45..0.7).contains(&Spec::from_value(&tenth).unwrap().crowding()));
}

#[test]
fn a_specimen_is_as_wide_as_the_coated_grains() {
    let in_box = |sides: &str, thickness_mm: f64| {
        let text = format!(
            "fraction = 0.2\nspecimen = {{ kind = 'box', size_mm = [60, 60, 21]{sides} }}\nitz.thickness_mm = [0, 0]\n\
             [[shape.shells]]\nname = 'coat'\nthickness_mm = [{thickness_mm}, 3]\noutward = true\n"
        );
        Spec::from_toml(&text).map_err(|error| error.to_string())
    };
    assert!(in_box("", 0.4).is_ok() && in_box(", periodic = ['z']", 0.4).is_ok());
    let error = in_box("", 0.6).unwrap_err();
    assert!(
        error.contains("grading.d_max_mm is 20, with coatings 21.2 but the specimen has only 21 mm of room"),
        "{error}"
    );
    assert!(error.contains("thinner coatings"), "{error}");
    let error = in_box(", periodic = ['z']", 0.6).unwrap_err();
    assert!(error.contains("makes aggregates up to 21.2 long, and the specimen is periodic after 21"), "{error}");
}

/// Wet-screened concrete: the same seed without the top class.
#[test]
fn the_grains_of_a_class_do_not_depend_on_the_classes_above_it() {
    let volumes = |fraction: f64, sieves: &str, passing: &str, d_max_mm: u32| {
        let model = packed(&format!(
            "fraction = {fraction}\nspecimen = {{ kind = 'cube', side_mm = 50 }}\n\
             grading = {{ d_min_mm = 5, d_max_mm = {d_max_mm}, curve = {{ kind = 'sieves', sieves_mm = {sieves}, \
             passing = {passing} }} }}"
        ));
        let fine = model.aggregates.iter().filter(|grain| grain.class == 0);
        let mut volumes: Vec<f64> = fine.map(|grain| grain.body.volume()).collect();
        volumes.sort_by(f64::total_cmp);
        volumes
    };
    let (whole, twin) = (volumes(0.4, "[5, 10, 20]", "[0, 0.5, 1]", 20), volumes(0.2, "[5, 10]", "[0, 1]", 10));
    assert!(twin.len() > 50 && whole.len() == twin.len());
    assert!(whole.iter().zip(&twin).all(|(a, b)| (a / b - 1.0).abs() < 1e-8));
}

#[test]
fn shells_that_cannot_be_are_refused_by_name_before_any_grain_is_placed() {
    const PLAIN: &str = "fraction = 0.3\nspecimen = { kind = 'cube', side_mm = 60 }\n";
    for (entries, said) in [
        ("name = 'rim'", "shape.shells give rim none or several thicknesses; give one of thickness_mm, size_share, "),
        ("name = 'rim'\nthickness_mm = [1, 1]\nvolume_share = 0.2", "none or several thicknesses"),
        (
            "name = 'rim'\nsize_share = [0.1, 0.6]",
            "shape.shells.size_share is 0.6; the accepted range is 0.0001 to 0.5",
        ),
        (
            "name = 'rim'\nsize_share = [0.1, 0.41]",
            "reaches 2.55 with the ITZ, but the smallest of these grains is 5 thick at most; stay below 2.5",
        ),
        ("name = 'rim'\nthickness_over_size_mm = []", "thickness_over_size_mm has no rows; give sizes and thicknesses"),
        ("name = 'rim'\nthickness_over_size_mm = [[9, 1], [5, 1]]", "has 9 before 5; the sizes must ascend"),
        (
            "name = 'rim'\nthickness_over_size_mm = [[5, 1], [10, 4.5]]",
            "reaches 5 with the ITZ, but one of these grains is 10 thick at most; stay below 5 in all",
        ),
        // Both rows leave a core, and sizes between them do not; 2.4 + 5.41 ln(d / 5) is farthest beyond d / 2 at 10.82.
        (
            "name = 'rim'\nthickness_over_size_mm = [[5, 1.9], [20, 9.4]]",
            "with the ITZ, but one of these grains is 10.82",
        ),
        (
            "name = 'rim'\nvolume_share = 1.0",
            "shape.shells.volume_share of rim is 1; the accepted range is above 0 and below 1",
        ),
        ("name = 'rim'\nthickness_mm = [2, 1]", "shape.shells.thickness_mm is [2, 1]; the lower limit comes first"),
        (
            "name = 'rim'\nthickness_mm = [1, 3]",
            "reaches 3.5 with the ITZ, but the smallest of these grains is 5 thick at most",
        ),
        ("name = 'itz'\nthickness_mm = [1, 1]", "shape.shells.name is \"itz\"; this name has a meaning of its own"),
        (
            "name = 'rim'\nthickness_mm = [1, 1]\nof = 'brick'",
            "of rim is \"brick\"; it must be the name of an entry of [[phases]]",
        ),
        (
            "name = 'a'\nvolume_share = 0.6\n[[shape.shells]]\nname = 'b'\nvolume_share = 0.5",
            "add up to 1.1; below 1 a core is left",
        ),
        (
            "name = 'a'\nthickness_mm = [1, 1]\n[[shape.shells]]\nname = 'b'\nthickness_mm = [1, 1]\noutward = true",
            "shape.shells.outward of b follows a shell within the stone; outward ones come first",
        ),
        (
            "name = 'a'\nvolume_share = 0.2\noutward = true",
            "shape.shells.outward of a needs thickness_mm, size_share or thickness_over_size_mm, and convex polyhedra or spheres",
        ),
    ] {
        let error = Spec::from_toml(&format!("{PLAIN}[[shape.shells]]\n{entries}")).unwrap_err().to_string();
        assert!(error.contains(said), "{entries}: {error}");
    }
    let thick = format!("{PLAIN}[[shape.shells]]\nname = 'rim'\nthickness_mm = [1.5, 1.9]");
    let said = pack(&Spec::from_toml(&thick).unwrap(), &Silent).unwrap_err().to_string();
    assert!(said.contains("leave no core in ") && said.contains("take thinner shells, volume_share"), "{said}");
}
