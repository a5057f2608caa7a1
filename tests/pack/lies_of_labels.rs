//! Lies in the model of a label volume, and in a packing that pretends to be one: each is refused or found.

use super::lies::{as_saved, objection, scale};
use meso_core::import::grains::Roles;
use meso_core::import::volume::Volume;
use meso_core::labelled::{LabelOptions, of_labels};
use meso_core::{Silent, Spec, pack};
use serde_json::{Value, json};

/// Balls by middle and radius, voxels of 0.5 mm in 24 x 24 x 24; one with a hollow, a speck, and two that touch.
const BALLS: [([f64; 3], f64); 5] = [
    ([6.0, 6.0, 6.0], 4.6),
    ([16.0, 7.0, 7.0], 5.4),
    ([8.0, 17.0, 15.0], 5.0),
    ([18.0, 18.0, 18.0], 4.4),
    ([20.5, 2.5, 20.5], 1.5),
];

fn label(at: [f64; 3]) -> i64 {
    let from = |middle: [f64; 3]| (0..3).map(|k| (at[k] - middle[k]).powi(2)).sum::<f64>().sqrt();
    let number = BALLS.iter().position(|(middle, radius)| from(*middle) < *radius);
    number.filter(|_| from(BALLS[1].0) > 1.2).map_or(0, |number| 3 * number as i64 + 1)
}

fn imported() -> Value {
    let at = |i: usize| [i % 24, i / 24 % 24, i / 576].map(|x| x as f64 + 0.5);
    let volume = Volume::new([24; 3], None, (0..24 * 24 * 24).map(|i| label(at(i))).collect::<Vec<_>>()).unwrap();
    let options = LabelOptions {
        voxel_size_mm: Some([0.5; 3]),
        itz_thickness_mm: 0.9,
        least_voxels: 30,
        ..LabelOptions::default()
    };
    as_saved(&of_labels(&volume, &options, &Silent).unwrap())
}

fn packed() -> Value {
    let text = "seed = 2\nfraction = 0.3\nspecimen = { kind = 'cube', side_mm = 12 }\ngrading = { d_min_mm = 3, d_max_mm = 5 }\n\
                itz = { thickness_mm = [0.2, 0.3] }";
    as_saved(&pack(&Spec::from_toml(text).unwrap(), &Silent).unwrap())
}

fn labels(file: &mut Value) -> &mut Value {
    &mut file["report"]["labels"]
}

type Lie = (&'static str, fn(&mut Value));

/// In the entry of an import.
const ENTRY: [Lie; 27] = [
    ("other voxels", |f| labels(f)["voxels"] = json!([1, 2, 3])),
    ("a voxel more", |f| labels(f)["voxels"] = json!([24, 24, 25])),
    ("twice the voxels of half the size along x", |f| {
        labels(f)["voxels"] = json!([48, 24, 24]);
        labels(f)["voxel_size_mm"] = json!([0.5, 0.5, 0.5]);
    }),
    ("voxels of 9 mm", |f| labels(f)["voxel_size_mm"] = json!([9.0, 9.0, 9.0])),
    ("voxels of no size", |f| labels(f)["voxel_size_mm"] = json!([0.5, 0.0, 0.5])),
    ("voxels that go back", |f| labels(f)["voxel_size_mm"] = json!([0.5, 0.5, -0.5])),
    ("voxels a millionth larger", |f| scale(&mut labels(f)["voxel_size_mm"][2], 1.0 + 1e-6)),
    ("twice the fraction", |f| scale(&mut labels(f)["fraction"], 2.0)),
    ("half the fraction", |f| scale(&mut labels(f)["fraction"], 0.5)),
    ("a fraction of half a voxel more", |f| {
        labels(f)["fraction"] = json!(labels(f)["fraction"].as_f64().unwrap() + 0.5 / 13824.0);
    }),
    ("no fraction", |f| labels(f)["fraction"] = json!(0.0)),
    ("a fraction below 0", |f| labels(f)["fraction"] = json!(-0.125)),
    ("a fraction of 2", |f| labels(f)["fraction"] = json!(2.0)),
    ("nearly all dropped", |f| labels(f)["dropped_fraction"] = json!(0.875)),
    ("less than nothing dropped", |f| labels(f)["dropped_fraction"] = json!(-0.125)),
    ("voxels of none dropped", |f| labels(f)["dropped"] = json!(0)),
    ("hollows below nothing", |f| labels(f)["filled_fraction"] = json!(-3.0)),
    ("hollows larger than their grains", |f| labels(f)["filled_fraction"] = json!(0.5)),
    ("hollows of none", |f| labels(f)["filled"] = json!(0)),
    ("hollows without a voxel", |f| labels(f)["filled_fraction"] = json!(0.0)),
    ("more hollows than voxels in them", |f| labels(f)["filled"] = json!(1000)),
    ("a surface at no distance", |f| labels(f)["farthest_mm"] = json!(0.0)),
    ("a surface at less than no distance", |f| labels(f)["farthest_mm"] = json!(-1.0)),
    ("a surface out of the volume", |f| labels(f)["farthest_mm"] = json!(30.0)),
    ("a million pairs of four grains", |f| labels(f)["separated_pairs"] = json!(1_000_000)),
    ("labels from behind", |f| labels(f)["labels"].as_array_mut().unwrap().reverse()),
    ("a label less", |f| drop(labels(f)["labels"].as_array_mut().unwrap().pop())),
];

/// In the rest of an import.
const REST: [Lie; 27] = [
    ("a thin ITZ that is not", |f| f["report"]["itz_thin"] = json!([0])),
    ("all limited", |f| f["report"]["itz_limited"] = json!([0, 1, 2, 3, 4])),
    ("rearranged", |f| f["report"]["strategy"] = json!("rearrange")),
    ("another detail", |f| f["report"]["stop_detail"] = json!("all 9 grains of the label volume")),
    ("jammed", |f| f["report"]["stop_reason"] = json!("jammed")),
    ("interrupted", |f| f["report"]["stop_reason"] = json!("interrupted")),
    ("discarded grains", |f| f["report"]["discarded"] = json!(3)),
    ("Fuller's curve in the report", |f| f["report"]["grading"] = json!("fuller, n = 0.5, normalised, 2 to 6 mm")),
    ("the report's fraction", |f| scale(&mut f["report"]["fraction"], 1.01)),
    ("the report's target", |f| scale(&mut f["report"]["target_fraction"], 1.01)),
    ("another seed", |f| {
        for place in ["seed", "spec", "report"] {
            let value = if place == "seed" { &mut f["seed"] } else { &mut f[place]["seed"] };
            *value = json!(77);
        }
    }),
    ("balls", |f| f["spec"]["shape"] = json!({ "kind": "sphere" })),
    ("more corners", |f| f["spec"]["shape"]["vertices"] = json!([8, 9])),
    ("another fraction of the spec", |f| scale(&mut f["spec"]["fraction"], 1.001)),
    ("another curve", |f| f["spec"]["grading"]["curve"]["passing"][1] = json!(0.001)),
    ("a finer limit", |f| scale(&mut f["spec"]["grading"]["d_min_mm"], 0.9)),
    ("sizes by their axes", |f| f["spec"]["grading"]["size"] = json!("longest-axis")),
    ("a gap", |f| f["spec"]["placement"]["min_gap_mm"] = json!(0.001)),
    ("taken and placed", |f| f["spec"]["placement"]["strategy"] = json!("take-and-place")),
    ("attempts", |f| f["spec"]["placement"]["attempts"] = json!(3)),
    ("a time limit", |f| f["spec"]["placement"]["time_limit_s"] = json!(9.0)),
    ("a thicker ITZ in the spec", |f| f["spec"]["itz"]["thickness_mm"] = json!([1.0, 1.0])),
    ("a range of ITZ", |f| f["spec"]["itz"]["thickness_mm"] = json!([0.0, 0.9])),
    ("no ITZ of a grain", |f| f["aggregates"][0]["itz_thickness_mm"] = json!(0.0)),
    ("a thinner ITZ of a grain", |f| scale(&mut f["aggregates"][2]["itz_thickness_mm"], 0.999)),
    ("another class", |f| {
        let class = f["aggregates"][0]["class"].as_u64().unwrap();
        f["aggregates"][0]["class"] = json!(u64::from(class == 0));
    }),
    ("a grain less", |f| {
        f["aggregates"].as_array_mut().unwrap().pop();
        labels(f)["labels"].as_array_mut().unwrap().pop();
        f["report"]["aggregates"] = json!(f["aggregates"].as_array().unwrap().len());
    }),
];

/// In a packing that has the entry of a label volume.
const PRETENDED: [Lie; 8] = [
    ("nothing else", |_| ()),
    ("a seed", |f| {
        f["seed"] = json!(77);
        f["spec"]["seed"] = json!(77);
        f["report"]["seed"] = json!(77);
    }),
    ("balls", |f| f["spec"]["shape"] = json!({ "kind": "sphere" })),
    ("one ITZ", |f| {
        f["spec"]["itz"]["thickness_mm"] = json!([0.25, 0.25]);
        f["aggregates"].as_array_mut().unwrap().iter_mut().for_each(|a| a["itz_thickness_mm"] = json!(0.25));
    }),
    ("the words of an import", |f| {
        let count = f["aggregates"].as_array().unwrap().len();
        f["report"]["strategy"] = json!("label volume");
        f["report"]["stop_detail"] = json!(format!("all {count} grains of the label volume"));
    }),
    ("another curve", |f| f["spec"]["grading"]["curve"] = json!({ "kind": "fuller", "exponent": 0.4 })),
    ("no gap", |f| f["spec"]["placement"]["min_gap_mm"] = json!(0.0001)),
    ("a fraction", |f| f["spec"]["fraction"] = json!(0.31)),
];

#[test]
fn sixty_lies_about_label_volumes_are_found_and_the_truth_is_not() {
    let (import, mut packing) = (imported(), packed());
    assert_eq!(objection(&import), None, "the import as it was written");
    let entry = &import["report"]["labels"];
    let is_rich = ["separated_pairs", "dropped", "filled"].map(|key| entry[key].as_u64().unwrap() > 0);
    assert_eq!(is_rich, [true; 3], "{entry}");
    packing["report"]["labels"] = entry.clone();
    packing["report"]["labels"]["labels"] = json!(vec![1; packing["aggregates"].as_array().unwrap().len()]);
    let mut idle = Vec::new();
    let believed = |(honest, (name, lie)): (&Value, &Lie)| {
        let mut file = honest.clone();
        lie(&mut file);
        idle.extend((file == import).then_some(*name));
        objection(&file).is_none().then_some(*name)
    };
    let lies: Vec<(&Value, &Lie)> = ENTRY.iter().chain(&REST).map(|lie| (&import, lie)).collect();
    let lies: Vec<(&Value, &Lie)> = lies.into_iter().chain(PRETENDED.iter().map(|lie| (&packing, lie))).collect();
    assert!(lies.len() >= 60);
    let believed: Vec<&str> = lies.into_iter().filter_map(believed).collect();
    assert_eq!((believed, idle), (vec![], vec![]), "lies that are believed, and lies that change nothing");
}

/// In the entry of a drilled core.
const CORE: [Lie; 12] = [
    ("a wider core", |f| scale(&mut labels(f)["core"]["diameter_mm"], 1.01)),
    ("a wider core and specimen", |f| {
        scale(&mut labels(f)["core"]["diameter_mm"], 1.2);
        f["spec"]["specimen"]["diameter_mm"] = labels(f)["core"]["diameter_mm"].clone();
        f["specimen"]["diameter_mm"] = labels(f)["core"]["diameter_mm"].clone();
    }),
    ("a core of no width", |f| labels(f)["core"]["diameter_mm"] = json!(0.0)),
    ("a tenth more voxels", |f| {
        labels(f)["core"]["voxels"] = json!(11 * labels(f)["core"]["voxels"].as_u64().unwrap() / 10);
    }),
    ("no voxels", |f| labels(f)["core"]["voxels"] = json!(0)),
    ("more off than there is", |f| labels(f)["core"]["off_fraction"] = json!(1.5)),
    ("less off than nothing", |f| labels(f)["core"]["off_fraction"] = json!(-0.1)),
    ("pores of half a voxel", |f| {
        let half = 0.5 / labels(f)["core"]["voxels"].as_f64().unwrap();
        labels(f)["core"]["pores_fraction"] = json!(labels(f)["core"]["pores_fraction"].as_f64().unwrap() + half);
    }),
    ("nothing but pores", |f| labels(f)["core"]["pores_fraction"] = json!(1.0)),
    ("no labels outside", |f| labels(f)["core"]["outside"] = json!([])),
    ("no core", |f| drop(labels(f).as_object_mut().unwrap().remove("core"))),
    ("another entry", |f| labels(f)["core"]["height_mm"] = json!(3.0)),
];

#[test]
fn lies_about_a_drilled_core_are_found_and_the_truth_is_not() {
    let at = |i: usize| [i % 24, i / 24 % 24, i / 576].map(|x| x as f64 + 0.5);
    let of = |[x, y, z]: [f64; 3]| {
        let is_pore = (x - 12.0).abs() < 1.0 && (y - 12.0).abs() < 1.0 && z < 3.0;
        let is_core = (x - 12.0).hypot(y - 12.0) < 11.0 && !is_pore;
        if is_core { label([x, y, z]) + 1 } else { 0 }
    };
    let volume = Volume::new([24; 3], None, (0..24 * 24 * 24).map(|i| of(at(i))).collect::<Vec<_>>()).unwrap();
    let roles = Roles { mortar: vec![1], aggregate: Vec::new() };
    let options = LabelOptions { roles, voxel_size_mm: Some([0.5; 3]), outside: vec![0], ..LabelOptions::default() };
    let import = as_saved(&of_labels(&volume, &options, &Silent).unwrap());
    assert_eq!(objection(&import), None, "the import as it was written");
    let core = &import["report"]["labels"]["core"];
    assert!(
        (core["diameter_mm"].as_f64().unwrap() - 11.0).abs() < 0.1 && core["pores_fraction"].as_f64().unwrap() > 0.0
    );
    let believed = |(name, lie): &Lie| {
        let mut file = import.clone();
        lie(&mut file);
        assert!(file != import, "{name} changes nothing");
        objection(&file).is_none().then_some(*name)
    };
    assert_eq!(CORE.iter().filter_map(believed).collect::<Vec<_>>(), Vec::<&str>::new());
}
