//! Files of a case that would overwrite each other are refused. The shared case is study_outputs_lost.toml.

use meso_study::{NameError, Names};

/// Names of a case with a test.
fn of_a_test() -> Names {
    let mut names = Names::default();
    for name in ["model.json", "case.json", "curve.csv", "result.json"] {
        names.claim("the study", name).unwrap();
    }
    names.claim_series("[solve]", "frame_", ".vtu").unwrap();
    names
}

#[test]
fn a_name_that_is_used_already_is_refused() {
    for name in [
        "curve.csv",
        "result.json",
        "model.json",
        "case.json",
        "CURVE.csv",
        "Case.JSON",
        "frame_0009.vtu",
        "frame_9.vtu",
        "frame_+9.vtu",
        "FRAME_0001.VTU",
        "frame_12345678901234567890123.vtu",
    ] {
        let error = of_a_test().claim("outputs", name).unwrap_err();
        assert!(matches!(&error, NameError::Taken { owner, .. } if owner == "outputs"), "{name}: {error}");
    }
    let mut names = of_a_test();
    names.claim("outputs", "a.csv").unwrap();
    let error = names.claim("[mesh] output", "A.csv").unwrap_err().to_string();
    assert!(error.starts_with("[mesh] output has \"A.csv\", which outputs writes, too"), "{error}");
}

#[test]
fn a_series_is_refused_where_it_would_number_another_file() {
    let mut names = of_a_test();
    names.claim("outputs", "a_7.vtu").unwrap();
    assert!(names.claim_series("[mesh] output", "A_", ".vtu").is_err());
    assert!(names.claim_series("[mesh] output", "Frame_", ".vtu").is_err());
    names.claim_series("[mesh] output", "b_", ".vtu").unwrap();
    assert!(names.claim("outputs", "b_0.vtu").is_err());
}

#[test]
fn names_beside_a_series_are_free() {
    let mut names = of_a_test();
    for name in ["frame_.vtu", "frame_1a.vtu", "frame_0001.csv", "frames.vtu", "my_frame_0001.vtu", "ü.csv"] {
        names.claim("outputs", name).unwrap_or_else(|error| panic!("{error}"));
    }
}

#[test]
fn a_name_is_a_bare_one_that_every_file_system_takes() {
    let long = format!("{}.csv", "a".repeat(197));
    for name in [
        "",
        ".",
        "..",
        "/a.csv",
        "../a.csv",
        "b/a.csv",
        "b\\a.csv",
        "C:a.csv",
        "a.csv:b.csv",
        "a\0.csv",
        "a\n.csv",
        "a\u{1b}.csv",
        "a?.csv",
        "a.csv ",
        "a.csv.",
        ".mesocrete-a.tmp",
        ".MESOCRETE-lock",
        &long,
    ] {
        let error = of_a_test().claim("outputs", name).unwrap_err();
        assert!(matches!(error, NameError::Form { .. }), "{name:?}: {error}");
    }
}
