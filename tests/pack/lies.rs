//! Lies in a saved model: each is refused by the reader or found by the check.

use meso_core::check::{Finding, check};
use meso_core::spec::Spec;
use meso_core::{Model, Silent, pack, saved};
use serde_json::{Value, json};

const SPEC: &str = r#"
    fraction = 0.3
    specimen = { kind = "cube", side_mm = 30 }
    grading = { d_max_mm = 16, classes_mm = [5, 10, 16] }
    placement = { min_gap_mm = 0.05, wall_gap_mm = 0.1 }
    [voids]
    fraction = 0.01
    diameter_mm = [2, 3]
    [fibres]
    fraction = 0.002
    diameter_mm = 0.5
    length_mm = 8
"#;

/// A model as its file has it.
pub(super) fn as_saved(model: &Model) -> Value {
    let mut bytes = Vec::new();
    saved::write(model, &mut bytes).unwrap();
    serde_json::from_slice(&bytes).unwrap()
}

fn honest() -> Value {
    as_saved(&pack(&Spec::from_toml(SPEC).unwrap(), &Silent).unwrap())
}

/// Why the file is not believed; `None` where it is.
pub(super) fn objection(file: &Value) -> Option<String> {
    let model = match saved::read(file.to_string().as_bytes()) {
        Ok(model) => model,
        Err(error) => return Some(error.to_string()),
    };
    check(&model).findings.first().map(ToString::to_string)
}

pub(super) fn scale(value: &mut Value, factor: f64) {
    *value = json!(value.as_f64().unwrap() * factor);
}

fn one_ulp_up(value: &mut Value) {
    *value = json!(value.as_f64().unwrap().next_up());
}

fn add(value: &mut Value, more: i64) {
    *value = json!(value.as_i64().unwrap() + more);
}

fn drop_key(value: &mut Value, key: &str) {
    value.as_object_mut().unwrap().remove(key).unwrap();
}

/// Keeps the first `count` aggregates, and renumbers the inclusions.
fn keep(file: &mut Value, count: usize) {
    file["aggregates"].as_array_mut().unwrap().truncate(count);
    let inclusions = file["inclusions"].as_array_mut().unwrap();
    (count..).zip(inclusions).for_each(|(id, body)| body["id"] = json!(id));
}

/// Moves every corner of a body.
fn shift(body: &mut Value, by: [f64; 3]) {
    for vertex in body["vertices"].as_array_mut().unwrap() {
        (0..3).for_each(|k| vertex[k] = json!(vertex[k].as_f64().unwrap() + by[k]));
    }
}

type Lie = (&'static str, fn(&mut Value));

const REPORT: [Lie; 37] = [
    ("fraction a millionth higher", |f| scale(&mut f["report"]["fraction"], 1.0 + 1e-6)),
    ("fraction by 1e-11", |f| scale(&mut f["report"]["fraction"], 1.0 + 1e-11)),
    ("fraction of 7", |f| f["report"]["fraction"] = json!(7)),
    ("target of the report", |f| f["report"]["target_fraction"] = json!(0.9)),
    ("target of the report by one ulp", |f| one_ulp_up(&mut f["report"]["target_fraction"])),
    ("volume of the specimen by one ulp", |f| one_ulp_up(&mut f["report"]["specimen"]["volume_mm3"])),
    ("target of a class", |f| scale(&mut f["report"]["classes"][0]["target_fraction"], 0.5)),
    ("fraction of a class", |f| scale(&mut f["report"]["classes"][1]["fraction"], 3.0)),
    ("fractions of two classes exchanged", |f| {
        let first = f["report"]["classes"][0]["fraction"].clone();
        f["report"]["classes"][0]["fraction"] = f["report"]["classes"][1]["fraction"].take();
        f["report"]["classes"][1]["fraction"] = first;
    }),
    ("aggregates of a class", |f| f["report"]["classes"][0]["aggregates"] = json!(1)),
    ("aggregates moved between classes", |f| {
        add(&mut f["report"]["classes"][0]["aggregates"], 1);
        add(&mut f["report"]["classes"][1]["aggregates"], -1);
    }),
    ("lower limit of a class", |f| f["report"]["classes"][0]["d_min_mm"] = json!(4.0)),
    ("upper limit of a class", |f| f["report"]["classes"][1]["d_max_mm"] = json!(16.5)),
    ("a class left out", |f| drop(f["report"]["classes"].as_array_mut().unwrap().pop())),
    ("classes in another order", |f| f["report"]["classes"].as_array_mut().unwrap().reverse()),
    ("number of aggregates", |f| add(&mut f["report"]["aggregates"], 1)),
    ("discarded aggregates", |f| add(&mut f["report"]["discarded"], 5)),
    ("more aggregates discarded than numbers", |f| f["report"]["discarded"] = json!(u64::MAX)),
    ("kind of the specimen", |f| f["report"]["specimen"]["kind"] = json!("cylinder")),
    ("volume of the specimen", |f| f["report"]["specimen"]["volume_mm3"] = json!(1.0)),
    ("volume of the specimen by 1e-9", |f| scale(&mut f["report"]["specimen"]["volume_mm3"], 1.0 + 1e-9)),
    ("another curve", |f| f["report"]["grading"] = json!("fuller, raw, n = 0.5, 5 to 16 mm")),
    ("another strategy", |f| f["report"]["strategy"] = json!("take-and-place")),
    ("a strategy that is not", |f| f["report"]["strategy"] = json!("not recorded in the file")),
    ("another seed", |f| f["report"]["seed"] = json!(2)),
    ("jammed when it was not", |f| f["report"]["stop_reason"] = json!("jammed")),
    ("attempts exhausted when there were none", |f| f["report"]["stop_reason"] = json!("attempts-exhausted")),
    ("a time limit when there was none", |f| f["report"]["stop_reason"] = json!("time-limit")),
    ("an unknown reason", |f| f["report"]["stop_reason"] = json!("bored")),
    ("another detail", |f| f["report"]["stop_detail"] = json!("reached 0.9 of 0.9, every class as graded")),
    ("a stop with another detail", |f| {
        f["report"]["stop_reason"] = json!("interrupted");
        f["report"]["stop_detail"] = json!("reached 0.9 of 0.9");
    }),
    ("a limited ITZ that was not", |f| f["report"]["itz_limited"] = json!([0])),
    ("fraction of the voids", |f| scale(&mut f["report"]["phases"][0]["fraction"], 2.0)),
    ("volume of the voids", |f| scale(&mut f["report"]["phases"][0]["volume_mm3"], 1.0 + 1e-9)),
    ("target of the fibres", |f| scale(&mut f["report"]["phases"][1]["target_fraction"], 2.0)),
    ("number of fibres", |f| add(&mut f["report"]["phases"][1]["bodies"], -1)),
    ("no phases", |f| drop_key(&mut f["report"], "phases")),
];

const FILE: [Lie; 27] = [
    ("no report", |f| drop_key(f, "report")),
    ("an empty report", |f| f["report"] = Value::Null),
    ("no report and three aggregates", |f| {
        drop_key(f, "report");
        keep(f, 3);
    }),
    ("a report without its aggregates", |f| drop_key(&mut f["report"], "aggregates")),
    ("an unknown key", |f| f["colour"] = json!(1)),
    ("an unknown key of the report", |f| f["report"]["colour"] = json!(1)),
    ("an unknown key of a class", |f| f["report"]["classes"][0]["colour"] = json!(1)),
    ("an unknown key of the report's specimen", |f| f["report"]["specimen"]["colour"] = json!(1)),
    ("an unknown counter", |f| f["report"]["work"]["colour"] = json!(1)),
    ("an unknown key of a phase", |f| f["report"]["phases"][0]["colour"] = json!(1)),
    ("an unknown key of an aggregate", |f| f["aggregates"][0]["colour"] = json!(1)),
    ("an unknown key of a fibre", |f| f["inclusions"][0]["colour"] = json!(1)),
    ("an unknown key of the spec", |f| f["spec"]["colour"] = json!(1)),
    ("an unknown key of the specimen", |f| f["specimen"]["colour"] = json!(1)),
    ("an unknown key of the spec's placement", |f| f["spec"]["placement"]["colour"] = json!(1)),
    ("a version that never was", |f| {
        f["mesocrete"] = json!("0.0.1");
        f["report"]["version"] = json!("0.0.1");
    }),
    ("a version of two numbers", |f| f["mesocrete"] = json!("0.1")),
    ("a version and more", |f| f["mesocrete"] = json!("0.1.0 ")),
    ("a report of a later version", |f| f["report"]["version"] = json!("0.1.1")),
    ("a report of no version", |f| f["report"]["version"] = json!("new")),
    ("another seed", |f| {
        f["seed"] = json!(2);
        f["spec"]["seed"] = json!(2);
        f["report"]["seed"] = json!(2);
    }),
    ("another specimen", |f| {
        f["specimen"]["side_mm"] = json!(31.0);
        f["spec"]["specimen"]["side_mm"] = json!(31.0);
    }),
    ("an aggregate less", |f| {
        let count = f["aggregates"].as_array().unwrap().len();
        keep(f, count - 1);
    }),
    ("an aggregate twice", |f| {
        let mut last = f["aggregates"].as_array().unwrap().last().unwrap().clone();
        add(&mut last["id"], 1);
        f["aggregates"].as_array_mut().unwrap().push(last);
    }),
    ("a fibre less", |f| drop(f["inclusions"].as_array_mut().unwrap().pop())),
    ("no inclusions", |f| drop_key(f, "inclusions")),
    ("ids that jump", |f| add(&mut f["aggregates"][4]["id"], 1)),
];

const SPEC_LIES: [Lie; 19] = [
    ("asked for 0.9", |f| f["spec"]["fraction"] = json!(0.9)),
    ("asked for 0.9, and the report says so", |f| {
        f["spec"]["fraction"] = json!(0.9);
        f["report"]["target_fraction"] = json!(0.9);
    }),
    ("asked for less than there is", |f| {
        f["spec"]["fraction"] = json!(0.1);
        f["report"]["target_fraction"] = json!(0.1);
        (0..2).for_each(|c| scale(&mut f["report"]["classes"][c]["target_fraction"], 1.0 / 3.0));
    }),
    ("asked for one ulp more", |f| one_ulp_up(&mut f["spec"]["fraction"])),
    ("a class limit one ulp up", |f| one_ulp_up(&mut f["spec"]["grading"]["classes_mm"][1])),
    ("another curve", |f| f["spec"]["grading"]["curve"]["exponent"] = json!(0.4)),
    ("a raw curve", |f| f["spec"]["grading"]["form"] = json!("raw")),
    ("other class limits", |f| f["spec"]["grading"]["classes_mm"] = json!([5.0, 11.0, 16.0])),
    ("sieve sizes", |f| f["spec"]["grading"]["size"] = json!("sieve")),
    ("another law of sizes", |f| f["spec"]["grading"]["size_law"] = json!("volume-uniform")),
    ("another shape", |f| f["spec"]["shape"]["vertices"] = json!([8, 9])),
    ("a thicker ITZ", |f| f["spec"]["itz"]["thickness_mm"] = json!([0.5, 0.9])),
    ("a range of the ITZ that holds all", |f| f["spec"]["itz"]["thickness_mm"] = json!([0.0, 0.6])),
    ("a larger gap", |f| f["spec"]["placement"]["min_gap_mm"] = json!(0.5)),
    ("a larger gap to the walls", |f| f["spec"]["placement"]["wall_gap_mm"] = json!(1.0)),
    ("the other strategy", |f| f["spec"]["placement"]["strategy"] = json!("take-and-place")),
    ("larger voids", |f| f["spec"]["voids"]["diameter_mm"] = json!([3.0, 4.0])),
    ("longer fibres", |f| f["spec"]["fibres"]["length_mm"] = json!(9.0)),
    ("no voids asked for", |f| drop_key(&mut f["spec"], "voids")),
];

const BODIES: [Lie; 17] = [
    ("no ITZ", |f| f["aggregates"][0]["itz_thickness_mm"] = json!(0.0)),
    ("an ITZ thicker than asked", |f| f["aggregates"][0]["itz_thickness_mm"] = json!(0.75)),
    ("an ITZ within the range that was not drawn", |f| f["aggregates"][0]["itz_thickness_mm"] = json!(0.25)),
    ("an ITZ one ulp thicker", |f| {
        one_ulp_up(&mut f["aggregates"][0]["itz_thickness_mm"]);
    }),
    ("no ITZ at all", |f| {
        f["aggregates"].as_array_mut().unwrap().iter_mut().for_each(|a| a["itz_thickness_mm"] = json!(0.0));
    }),
    ("another class", |f| f["aggregates"][0]["class"] = json!(0)),
    ("two bodies in one place", |f| {
        f["aggregates"][1]["vertices"] = f["aggregates"][0]["vertices"].clone();
        f["aggregates"][1]["faces"] = f["aggregates"][0]["faces"].clone();
    }),
    ("out of the specimen", |f| shift(&mut f["aggregates"][0], [30.0, 0.0, 0.0])),
    ("onto a neighbour", |f| shift(&mut f["aggregates"][0], [3.0, 3.0, 3.0])),
    ("inside out", |f| {
        for face in f["aggregates"][0]["faces"].as_array_mut().unwrap() {
            face.as_array_mut().unwrap().reverse();
        }
    }),
    ("a face less", |f| drop(f["aggregates"][0]["faces"].as_array_mut().unwrap().pop())),
    ("a corner inwards by a nanometre", |f| {
        let vertex = &mut f["aggregates"][0]["vertices"][0];
        let middle = [15.0; 3];
        (0..3).for_each(|k| {
            let x = vertex[k].as_f64().unwrap();
            vertex[k] = json!(x + 1e-3 * (middle[k] - x).signum());
        });
    }),
    ("a corner far off", |f| f["aggregates"][0]["vertices"][0][0] = json!(1e7)),
    ("a mirrored body", |f| {
        for vertex in f["aggregates"][0]["vertices"].as_array_mut().unwrap() {
            vertex[0] = json!(30.0 - vertex[0].as_f64().unwrap());
        }
    }),
    ("a void that is a fibre", |f| f["inclusions"][0]["phase"] = json!("fibre")),
    ("a void larger by a thousandth", |f| {
        for vertex in f["inclusions"][0]["vertices"].as_array_mut().unwrap() {
            (0..3).for_each(|k| scale(&mut vertex[k], 1.001));
        }
    }),
    ("a void as an aggregate", |f| {
        let mut void = f["inclusions"].as_array_mut().unwrap().remove(0);
        drop_key(&mut void, "phase");
        void["class"] = json!(0);
        void["itz_thickness_mm"] = json!(0.1);
        f["aggregates"].as_array_mut().unwrap().push(void);
    }),
];

#[test]
fn ninety_lies_are_found_and_the_truth_is_not() {
    let honest = honest();
    assert_eq!(objection(&honest), None, "the file as it was written");
    let lies: Vec<Lie> = [&REPORT[..], &FILE, &SPEC_LIES, &BODIES].concat();
    assert!(lies.len() >= 90, "{}", lies.len());
    let believed = |(name, lie): &Lie| {
        let mut file = honest.clone();
        lie(&mut file);
        assert_ne!(file, honest, "{name} changes nothing");
        objection(&file).is_none().then_some(*name)
    };
    let believed: Vec<&str> = lies.iter().filter_map(believed).collect();
    assert_eq!(believed, [""; 0]);
}

/// Whether one of the findings in a file says so.
fn is_said(file: &Value, part: &str) -> bool {
    let model = saved::read(file.to_string().as_bytes()).unwrap();
    check(&model).findings.iter().any(|finding| finding.to_string().contains(part))
}

#[test]
fn a_report_that_is_gone_is_named_as_such() {
    let mut file = honest();
    drop_key(&mut file, "report");
    assert!(is_said(&file, "the file has no report"));
}

#[test]
fn a_body_larger_by_a_millionth_is_no_grain_of_the_spec() {
    let mut file = honest();
    let vertices = file["aggregates"][0]["vertices"].as_array_mut().unwrap();
    let middle = [0, 1, 2]
        .map(|k| vertices.iter().map(|vertex| vertex[k].as_f64().unwrap()).sum::<f64>() / vertices.len() as f64);
    for vertex in vertices {
        for (k, middle) in middle.iter().enumerate() {
            vertex[k] = json!(middle + (vertex[k].as_f64().unwrap() - middle) * (1.0 + 1e-6));
        }
    }
    assert!(is_said(&file, "body 0 is not one of the grains") && !is_said(&file, "body 1 is not one of the grains"));
}

#[test]
fn a_grain_that_lies_in_two_places_was_taken_once() {
    let mut model = saved::read(honest().to_string().as_bytes()).unwrap();
    model.inclusions.clear();
    let mut copy = model.aggregates[0].clone();
    copy.id = model.aggregates.len() as u32;
    let twice = Finding::NotTaken { body: copy.id };
    assert!(!check(&model).findings.contains(&twice));
    model.aggregates.push(copy);
    assert!(check(&model).findings.contains(&twice));
}

#[test]
fn a_stopped_run_discards_no_more_than_the_spec_has_grains_left() {
    let mut file = honest();
    file["report"]["stop_reason"] = json!("interrupted");
    assert!(!is_said(&file, "discarded is"));
    file["report"]["discarded"] = json!(1_000_000);
    assert!(is_said(&file, "discarded is 1000000; the spec leaves at most "));
}

#[test]
fn a_packing_that_was_stopped_or_fell_short_is_sound() {
    for placement in [
        r#"{ strategy = "take-and-place", attempts = 3 }"#,
        r#"{ strategy = "take-and-place", attempts = 500, surplus = 0.1 }"#,
        r#"{ strategy = "rearrange", min_gap_mm = 0.2 }"#,
    ] {
        for seed in 1..4 {
            let text = format!(
                "seed = {seed}\nfraction = 0.45\nspecimen = {{ kind = \"cube\", side_mm = 40 }}\nitz = {{ thickness_mm = [0.0, 2.0] }}\nplacement = {placement}\n"
            );
            let model = pack(&Spec::from_toml(&text).unwrap(), &Silent).unwrap();
            let mut bytes = Vec::new();
            saved::write(&model, &mut bytes).unwrap();
            let again = saved::read(&bytes).unwrap();
            assert_eq!(check(&again).findings, [], "{text}");
        }
    }
}
