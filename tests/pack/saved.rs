//! The saved model: a written model is read back, and any other file is refused by name.

use crate::pack::models::two_boxes;
use meso_core::saved::{self, ReadError};
use meso_core::specimen::{Built, Specimen};
use meso_core::watch::Stage;
use meso_core::{Spec, Watch, pack};
use serde_json::{Value, json};
use std::sync::Mutex;

fn bytes() -> Vec<u8> {
    let mut bytes = Vec::new();
    saved::write(&two_boxes(), &mut bytes).unwrap();
    bytes
}

fn tree() -> Value {
    serde_json::from_slice(&bytes()).unwrap()
}

fn refusal(tree: &Value) -> String {
    saved::read(tree.to_string().as_bytes()).map(|_| ()).expect_err("this must be refused").to_string()
}

#[test]
fn a_model_is_read_back_bit_for_bit() {
    let model = two_boxes();
    let again = saved::read(&bytes()).unwrap();
    assert_eq!(again, model);
    let bits = |m: &meso_core::Model| -> Vec<u64> {
        m.aggregates.iter().flat_map(|a| a.body.vertices()).flat_map(|v| v.iter().map(|x| x.to_bits())).collect()
    };
    assert_eq!(bits(&again), bits(&model));
}

#[test]
fn every_finite_number_survives_the_file() {
    let numbers = [-0.0, 5e-324, 1e-308, 0.1 + 0.2, 1.0 / 3.0, 149.99999999999997, f64::EPSILON, -1e-60];
    for (i, number) in numbers.into_iter().enumerate() {
        let mut model = two_boxes();
        model.aggregates[0].body = model.aggregates[0].body.mapped(|v| v.map(|x| if x < 1.0 { number } else { x }));
        let mut bytes = Vec::new();
        saved::write(&model, &mut bytes).unwrap();
        let again = saved::read(&bytes).unwrap().aggregates[0].body.vertices()[0].x;
        assert_eq!(again.to_bits(), number.to_bits(), "number {i}");
    }
}

#[test]
fn the_file_has_the_keys_others_rely_on() {
    let tree = tree();
    assert_eq!(tree["mesocrete"], "0.1.0");
    assert_eq!(tree["seed"], 1);
    assert_eq!(tree["specimen"], json!({ "kind": "cube", "side_mm": 150.0 }));
    assert_eq!(tree["spec"]["grading"]["d_max_mm"], 20.0);
    assert_eq!(tree["aggregates"][1]["id"], 1);
    assert_eq!(tree["aggregates"][1]["class"], 0);
    assert_eq!(tree["aggregates"][0]["vertices"].as_array().unwrap().len(), 8);
    assert_eq!(tree["aggregates"][0]["faces"][0], json!([0, 4, 6, 2]));
    assert!(tree["report"].get("seconds").is_none(), "the time it took is not part of the model");
}

#[test]
fn a_file_without_a_report_gets_its_figures_from_the_aggregates() {
    let mut tree = tree();
    tree.as_object_mut().unwrap().remove("report");
    let model = saved::read(tree.to_string().as_bytes()).unwrap();
    assert_eq!(model.report.aggregates, 2);
    assert_eq!(model.report.classes[0].aggregates, 2);
    let volume: f64 = model.aggregates.iter().map(|a| a.body.volume()).sum();
    assert!((model.report.fraction - volume / 150f64.powi(3)).abs() < 1e-15);
}

#[test]
fn an_error_names_the_fault_of_a_file() {
    type Change = fn(&mut Value);
    let cases: [(Change, &str); 25] = [
        (|t| t["mesocrete"] = json!("9.0.0"), "written by mesocrete 9.0.0"),
        (|t| t["mesocrete"] = json!("0.2.0"), "update mesocrete"),
        (|t| t["mesocrete"] = json!("one"), "written by mesocrete one"),
        (|t| t["mesocrete"] = json!(1), "not a saved model"),
        (|t| t["spec"]["fraction"] = json!(45), "its spec is wrong: fraction is 45"),
        (|t| t["spec"]["colour"] = json!(1), "colour is not a known key"),
        (|t| t["seed"] = json!(2), "seed is 2 but spec.seed is 1"),
        (|t| t["specimen"]["side_mm"] = json!(100), "specimen and spec.specimen differ"),
        (|t| t["report"]["aggregates"] = json!(3), "report speaks of 3 aggregates"),
        (|t| t["aggregates"][1]["id"] = json!(0), "aggregate 1: its id is 0"),
        (|t| t["aggregates"][1]["id"] = json!(-1), "not a saved model"),
        (|t| t["aggregates"][0]["class"] = json!(3), "aggregate 0: its class is 3; the spec has 3 classes"),
        (|t| t["aggregates"][0]["itz_thickness_mm"] = json!(-0.1), "itz_thickness_mm is -0.1"),
        (|t| t["aggregates"][0]["itz_thickness_mm"] = json!(null), "not a saved model"),
        (|t| t["aggregates"][0]["vertices"][3][1] = json!(1e300), "aggregate 0: vertex 3 is farther than"),
        (|t| t["aggregates"][0]["vertices"][3] = json!([1, 2]), "not a saved model"),
        (|t| t["aggregates"][0]["vertices"] = json!([]), "0 vertices and 6 faces"),
        (|t| t["aggregates"][0]["faces"] = json!([]), "8 vertices and 0 faces"),
        (|t| t["aggregates"][0]["faces"][2] = json!([0, 1]), "face 2 has 2 corners"),
        (|t| t["aggregates"][0]["faces"][2] = json!([0, 1, 8]), "face 2 names vertex 8; there are 8"),
        (|t| t["aggregates"][0]["faces"][2] = json!([0, 1, 1, 4]), "passes the edge 1-1"),
        (|t| t["aggregates"][0]["faces"][2] = t["aggregates"][0]["faces"][3].clone(), "a second time"),
        (|t| drop(t["aggregates"][0]["faces"].as_array_mut().unwrap().pop()), "on one side only"),
        (
            |t| t["aggregates"][0]["vertices"].as_array_mut().unwrap().push(json!([2, 2, 2])),
            "vertex 8 is the corner of no face",
        ),
        (|t| drop(t.as_object_mut().unwrap().remove("aggregates")), "missing field `aggregates`"),
    ];
    for (change, part) in cases {
        let mut tree = tree();
        change(&mut tree);
        let message = refusal(&tree);
        assert!(message.contains(part), "{message:?} lacks {part:?}");
    }
}

#[test]
fn numbers_too_large_for_a_double_are_refused() {
    let text = String::from_utf8(bytes()).unwrap().replacen("10.333333333333334", "1e999", 1);
    assert!(matches!(saved::read(text.as_bytes()), Err(ReadError::Damaged)));
    let text = text.split(",\n\"crc32\"").next().unwrap().to_owned() + "}\n";
    assert!(matches!(saved::read(text.as_bytes()), Err(ReadError::NotAModel(_))));
}

/// The bar of 500 flipped bits in every file that is read back.
#[test]
fn no_flipped_bit_of_a_saved_model_is_read_in_silence() {
    let model = two_boxes();
    let mut compressed = Vec::new();
    saved::write_compressed(&model, &mut compressed).unwrap();
    let mut refused = [0; 2];
    for (whole, refused) in [bytes(), compressed].iter().zip(&mut refused) {
        for bit in 0..8 * whole.len() {
            let mut flipped = whole.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            match saved::read(&flipped) {
                // A gzip header has bytes that say nothing of the model: its time, its system.
                Ok(again) => assert!(again == model && flipped[..2] == [0x1f, 0x8b], "bit {bit} of byte {}", bit / 8),
                Err(_) => *refused += 1,
            }
        }
        assert!(*refused > 7 * whole.len(), "{refused} of {}", 8 * whole.len());
    }
}

#[test]
fn files_without_a_checksum_and_files_that_other_programs_wrote_again_are_read() {
    let text = String::from_utf8(bytes()).unwrap();
    let (bare, seal) = text.rsplit_once(",\n\"crc32\": \"").unwrap();
    assert_eq!(seal.len(), "01234567\"}\n".len());
    let moved = text.replacen("\"class\":0", "\"class\":1", 1);
    assert!(saved::read(moved.as_bytes()).unwrap_err().to_string().contains("its checksum does not fit"));
    let again: Value = serde_json::from_str(&moved).unwrap();
    for text in [format!("{bare}}}\n"), text.trim_end().to_owned(), text.replace('\n', "\r\n"), again.to_string()] {
        saved::read(text.as_bytes()).unwrap_or_else(|error| panic!("{error}"));
    }
}

#[test]
fn a_torn_or_nested_file_is_refused() {
    let whole = bytes();
    for end in (0..whole.len() - 2).step_by(7) {
        assert!(saved::read(&whole[..end]).is_err(), "{end} of {} bytes were read", whole.len());
    }
    assert!(saved::read("[".repeat(100_000).as_bytes()).is_err());
    assert!(saved::read(b"").is_err());
    assert!(saved::read(&[0xff; 64]).is_err());
}

#[test]
fn no_changed_byte_makes_reading_panic() {
    let whole = bytes();
    for i in 0..whole.len() {
        for byte in [b'-', b'9', b'"', b']', 0] {
            let mut torn = whole.clone();
            torn[i] = byte;
            let _ = saved::read(&torn);
        }
    }
}

/// Writes down how far reading is. Its clock is past every limit.
struct Late(Mutex<Vec<f64>>);

impl Watch for Late {
    fn stops(&self) -> bool {
        true
    }

    fn stage(&self, stage: Stage, share: f64) {
        assert_eq!(stage, Stage::Read);
        self.0.lock().unwrap().push(share);
    }

    fn seconds(&self) -> f64 {
        1e9
    }

    fn began(&self) -> f64 {
        0.0
    }
}

#[test]
fn whoever_waits_hears_of_the_surface_and_no_time_limit_of_the_packing_counts() {
    let mut spec = Spec { fraction: 0.1, ..Spec::default() };
    let corners = [[0.0, 0.0, 0.0], [150.0, 0.0, 0.0], [0.0, 150.0, 0.0], [0.0, 0.0, 150.0]];
    let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let (vertices_mm, triangles, built) = (corners.to_vec(), faces.to_vec(), Built::default());
    spec.specimen = Specimen::Mesh { vertices_mm, triangles, built };
    spec.placement.time_limit_s = Some(100.0);
    let model = pack(&spec, &meso_core::Silent).unwrap();
    let mut bytes = Vec::new();
    saved::write(&model, &mut bytes).unwrap();
    let late = Late(Mutex::default());
    assert_eq!(saved::read_while(&bytes, &late).unwrap().aggregates, model.aggregates);
    let shares = late.0.into_inner().unwrap();
    assert!(shares.is_sorted() && shares.first() < shares.last() && shares.last() == Some(&1.0), "{shares:?}");
}
