//! What a SPEC.toml may say, and what is answered where it may not.

use meso_core::spec::{Spec, SpecErrorKind};

/// Text, key that the error must name, part of the sentence that must follow.
const REJECTED: &[(&str, &str, &str)] = &[
    // fraction
    ("fraction = 0", "fraction", "is 0; the accepted range is above 0 and below 1"),
    ("fraction = -0.0", "fraction", "is -0;"),
    ("fraction = 1", "fraction", "is 1;"),
    ("fraction = 1.2", "fraction", "is 1.2;"),
    ("fraction = 45", "fraction", "for 45 % write 0.45"),
    ("fraction = 100.0", "fraction", "is 100;"),
    ("fraction = -0.4", "fraction", "is -0.4;"),
    ("fraction = nan", "fraction", "is nan;"),
    ("fraction = -nan", "fraction", "is nan;"),
    ("fraction = inf", "fraction", "is inf;"),
    ("fraction = -inf", "fraction", "is -inf;"),
    ("fraction = 1e308", "fraction", "is 1e308;"),
    ("fraction = '0.4'", "fraction", "is \"0.4\"; it must be a number"),
    ("fraction = ''", "fraction", "it must be a number"),
    ("fraction = ' 5 '", "fraction", "it must be a number"),
    ("fraction = '1,5'", "fraction", "it must be a number"),
    ("fraction = [0.4]", "fraction", "is a list; it must be a number"),
    ("fraction = true", "fraction", "it must be a number"),
    ("fraction = {}", "fraction", "it must be a number"),
    ("fraction = 2025-01-01", "fraction", "no option takes a date"),
    ("fraction = 1,5", "", "not TOML"),
    // seed
    ("seed = -1", "seed", "is -1; it must be a whole number from 0 to 18446744073709551615"),
    ("seed = 18446744073709551616", "seed", "it must be a whole number from 0 to 18446744073709551615"),
    ("seed = 1.5", "seed", "it must be a whole number"),
    ("seed = 'one'", "seed", "it must be a whole number"),
    ("seed = 99999999999999999999999999999999999999999999", "seed", "too large"),
    // specimen
    ("[specimen]\nkind = 'cube'\nside_mm = 0", "specimen.side_mm", "is 0; the accepted range is 0.001 to 1000000"),
    ("[specimen]\nkind = 'cube'\nside_mm = -150", "specimen.side_mm", "is -150;"),
    ("[specimen]\nkind = 'cube'\nside_mm = nan", "specimen.side_mm", "is nan;"),
    ("[specimen]\nkind = 'cube'\nside_mm = inf", "specimen.side_mm", "is inf;"),
    ("[specimen]\nkind = 'cube'\nside_mm = 1e9", "specimen.side_mm", "is 1e9;"),
    ("[specimen]\nkind = 'cube'\nside_mm = 1e-9", "specimen.side_mm", "is 1e-9;"),
    ("[specimen]\nkind = 'cube'\nside_mm = 5e-324", "specimen.side_mm", "is 5e-324;"),
    ("[specimen]\nkind = 'cube'\nside_mm = 'wide'", "specimen.side_mm", "it must be a number"),
    ("[specimen]\nkind = 'cube'\nside = 150", "specimen.side", "did you mean side_mm?"),
    ("[specimen]\nkind = 'cube'", "specimen.side_mm", "is missing"),
    ("[specimen]\nside_mm = 100", "specimen.kind", "is missing"),
    ("[specimen]\nkind = 'cub'\nside_mm = 100", "specimen.kind", "did you mean \"cube\"?"),
    ("[specimen]\nkind = 7", "specimen.kind", "is 7; it must be a name in quotes"),
    ("[specimen]\nkind = 'box'\nsize_mm = [100, 100]", "specimen.size_mm", "a list of length 3"),
    ("[specimen]\nkind = 'box'\nsize_mm = [100, 100, 0]", "specimen.size_mm", "is 0;"),
    ("[specimen]\nkind = 'box'\nsize_mm = [100, 'x', 100]", "specimen.size_mm", "it must be a number"),
    ("[specimen]\nkind = 'box'\nsize_mm = 100", "specimen.size_mm", "it must be a list of length 3"),
    ("specimen = 'cube'", "specimen", "it must be a table"),
    ("[specimen]\nkind = 'cube'\nside_mm = 15", "grading.d_max_mm", "is 20 but the specimen has only 15 of room"),
    // grading
    ("[grading]\nd_min_mm = 25", "grading.d_min_mm", "is 25 but grading.d_max_mm is 20"),
    ("[grading]\nd_min_mm = 20", "grading.d_min_mm", "the smallest size must be below the largest"),
    ("[grading]\nd_min_mm = 0", "grading.d_min_mm", "is 0;"),
    ("[grading]\nd_min_mm = -5", "grading.d_min_mm", "is -5;"),
    ("[grading]\nd_min_mm = nan", "grading.d_min_mm", "is nan;"),
    ("[grading]\nd_max_mm = inf", "grading.d_max_mm", "is inf;"),
    ("[grading]\nd_max_mm = 1e308", "grading.d_max_mm", "is 1e308;"),
    ("[grading]\nd_min_mm = 1e-308", "grading.d_min_mm", "is 1e-308;"),
    ("[grading]\nd_min_mm = '5'", "grading.d_min_mm", "it must be a number"),
    ("[grading]\ndmin_mm = 5", "grading.dmin_mm", "did you mean d_min_mm?"),
    ("[grading]\nseed = 5", "grading.seed", "it belongs at the top, before any [table]"),
    ("d_min_mm = 5", "d_min_mm", "it belongs under [grading]"),
    ("[grading]\nwindows = 5", "grading.windows", "the keys here are"),
    ("[grading]\nexponent = 0", "grading.exponent", "is 0; the accepted range is 0.01 to 10"),
    ("[grading]\nexponent = -0.5", "grading.exponent", "is -0.5;"),
    ("[grading]\nexponent = nan", "grading.exponent", "is nan;"),
    ("[grading]\nclasses_mm = [5, 10, 10, 20]", "grading.classes_mm", "has 10 before 10; the limits must ascend"),
    ("[grading]\nclasses_mm = [20, 15, 10, 5]", "grading.classes_mm", "has 20 before 15; the limits must ascend"),
    ("[grading]\nclasses_mm = [5, 15, 10, 20]", "grading.classes_mm", "has 15 before 10"),
    ("[grading]\nclasses_mm = []", "grading.classes_mm", "has 0 limits"),
    ("[grading]\nclasses_mm = [5]", "grading.classes_mm", "has 1 limits"),
    ("[grading]\nclasses_mm = [5, nan, 20]", "grading.classes_mm", "is nan;"),
    ("[grading]\nclasses_mm = [4, 10, 20]", "grading.classes_mm", "goes from 4 to 20 but the sizes from 5 to 20"),
    ("[grading]\nclasses_mm = 5", "grading.classes_mm", "it must be a list"),
    ("[grading]\nclasses_mm = [5, 'x', 20]", "grading.classes_mm", "it must be a number"),
    ("[grading]\nform = 'Raw'", "grading.form", "did you mean \"raw\"?"),
    ("[grading]\nform = 'normalized'", "grading.form", "did you mean \"normalised\"?"),
    ("[grading]\nform = 1", "grading.form", "a name in quotes"),
    ("[grading]\nsize = 'sive'", "grading.size", "did you mean \"sieve\"?"),
    ("grading = []", "grading", "it must be a table"),
    // shape
    ("[shape]\nvertices = [3, 3]", "shape.vertices", "is [3, 3]; the accepted range is 6"),
    ("[shape]\nvertices = [4, 8]", "shape.vertices", "is [4, 8];"),
    ("[shape]\nvertices = [30, 20]", "shape.vertices", "the fewest come first"),
    ("[shape]\nvertices = [20, 1000000000]", "shape.vertices", "to 1000"),
    ("[shape]\nvertices = [20, 4294967296]", "shape.vertices", "a whole number from 0 to 4294967295"),
    ("[shape]\nvertices = [-20, 30]", "shape.vertices", "a whole number"),
    ("[shape]\nvertices = [20]", "shape.vertices", "a list of length 2"),
    ("[shape]\nvertices = [20, 25, 30]", "shape.vertices", "it must be a list of length 2"),
    ("[shape]\nvertices = 20", "shape.vertices", "a list of length 2"),
    ("[shape]\nvertices = [20.5, 30]", "shape.vertices", "a whole number"),
    (
        "[shape]\nelongation = { law = 'constant', value = 0 }",
        "shape.elongation.value",
        "is 0; the accepted range is 0.05 to 1",
    ),
    ("[shape]\nelongation = { law = 'constant', value = 1.5 }", "shape.elongation.value", "is 1.5;"),
    ("[shape]\nelongation = { law = 'constant', value = nan }", "shape.elongation.value", "is nan;"),
    ("[shape]\nelongation = { law = 'constant' }", "shape.elongation.value", "is missing"),
    ("[shape]\nelongation = { law = 'uniform', min = 0.9, max = 0.5 }", "shape.elongation.min", "is 0.9 but"),
    ("[shape]\nelongation = { law = 'uniform', min = -1, max = 0.5 }", "shape.elongation.min", "is -1;"),
    ("[shape]\nelongation = { law = 'uniform', min = 0.5, max = 1e308 }", "shape.elongation.max", "is 1e308;"),
    ("[shape]\nflatness = { law = 'normal', mean = 2, sd = 0.1, min = 0.4, max = 1 }", "shape.flatness.mean", "is 2;"),
    (
        "[shape]\nflatness = { law = 'normal', mean = 0.7, sd = -0.1, min = 0.4, max = 1 }",
        "shape.flatness.sd",
        "is -0.1;",
    ),
    (
        "[shape]\nflatness = { law = 'normal', mean = 0.7, sd = 1e9, min = 0.7, max = 0.7 }",
        "shape.flatness.sd",
        "is 1e9;",
    ),
    (
        "[shape]\nflatness = { law = 'gamma' }",
        "shape.flatness.law",
        "it must be one of \"normal\", \"uniform\", \"constant\"",
    ),
    ("[shape]\nflatness = { law = 'constant', valeu = 1 }", "shape.flatness.valeu", "did you mean value?"),
    ("[shape]\nflatness = 0.7", "shape.flatness", "it must be a table"),
    ("[shape]\nroundness = 1", "shape.roundness", "the keys here are vertices, elongation, flatness"),
    // itz
    ("[itz]\nthickness_mm = [-0.1, 0.5]", "itz.thickness_mm", "is -0.1;"),
    ("[itz]\nthickness_mm = [0.5, 0.1]", "itz.thickness_mm", "the lower limit comes first"),
    ("[itz]\nthickness_mm = [0.1, nan]", "itz.thickness_mm", "is nan;"),
    ("[itz]\nthickness_mm = [0.1, inf]", "itz.thickness_mm", "is inf;"),
    ("[itz]\nthickness_mm = [0.1, 2.5]", "itz.thickness_mm", "leaves no aggregate: stay below 2.5"),
    ("[itz]\nthickness_mm = 0.3", "itz.thickness_mm", "a list of length 2"),
    ("[itz]\nthickness = [0.1, 0.5]", "itz.thickness", "did you mean thickness_mm?"),
    // placement
    ("[placement]\nattempts = 0", "placement.attempts", "is 0; the accepted range is 1 to"),
    ("[placement]\nattempts = -1", "placement.attempts", "a whole number"),
    ("[placement]\nattempts = 18446744073709551615", "placement.attempts", "a whole number from 0 to 4294967295"),
    ("[placement]\nattempts = 1e3", "placement.attempts", "a whole number"),
    (
        "[placement]\nstrategy = 'fast'",
        "placement.strategy",
        "it must be one of \"auto\", \"take-and-place\", \"rearrange\"",
    ),
    ("[placement]\nstrategy = 'take_and_place'", "placement.strategy", "did you mean \"take-and-place\"?"),
    ("[placement]\nsurplus = -0.1", "placement.surplus", "is -0.1; the accepted range is 0 to 1"),
    ("[placement]\nsurplus = 2.5", "placement.surplus", "is 2.5;"),
    ("[placement]\nmin_gap_mm = -1", "placement.min_gap_mm", "is -1;"),
    ("[placement]\nmin_gap_mm = 200", "placement.min_gap_mm", "is 200 but the specimen is only 150 wide"),
    ("[placement]\nwall_gap_mm = -1", "placement.wall_gap_mm", "is -1;"),
    ("[placement]\nwall_gap_mm = 75", "placement.wall_gap_mm", "the walls leave no room"),
    ("[placement]\nwall_gap_mm = 70", "grading.d_max_mm", "is 20 but the specimen has only 10 of room"),
    ("[placement]\ntime_limit_s = 0", "placement.time_limit_s", "is 0;"),
    ("[placement]\ntime_limit_s = -5", "placement.time_limit_s", "is -5;"),
    ("[placement]\ntime_limit_s = nan", "placement.time_limit_s", "is nan;"),
    ("[placement]\ngap = 1", "placement.gap", "is not a known key"),
    // too much
    (
        "[specimen]\nkind = 'cube'\nside_mm = 1e6\n[grading]\nd_min_mm = 1e-3\nclasses_mm = [1e-3, 20]",
        "itz.thickness_mm",
        "leaves no aggregate",
    ),
    (
        "[specimen]\nkind = 'cube'\nside_mm = 1e6\n[grading]\nd_min_mm = 1\nclasses_mm = [1, 20]\n[itz]\nthickness_mm = [0, 0.1]",
        "grading.d_min_mm",
        "at most 1e7 are accepted",
    ),
    // text
    ("fractoin = 0.4", "fractoin", "did you mean fraction?"),
    ("colour = 'grey'", "colour", "the keys here are seed, fraction, specimen"),
    ("fraction = 0.4\nfraction = 0.5", "fraction", "is given twice"),
    ("fraction = 0.4\nfraction", "", "not TOML"),
    ("[grading\nd_min_mm = 5", "", "not TOML"),
    ("fraction = ", "", "not TOML"),
    ("fraction = 0.4 # a \u{0} byte", "", "not TOML"),
    ("= 4", "", "not TOML"),
    ("\"\" = 4", "\"\"", "is not a known key"),
];

#[test]
fn impossible_specs_are_rejected_by_key_value_and_way_out() {
    for &(text, key, part) in REJECTED {
        let error = Spec::from_toml(text).expect_err(text);
        assert_eq!(error.key, key, "{text:?} gave {error}");
        assert!(error.message.contains(part), "{text:?} gave {error}");
        assert!(!error.to_string().contains('\n'), "{text:?} gave {error}");
    }
}

#[test]
fn an_empty_spec_is_the_papers_specimen() {
    let spec = Spec::from_toml("").unwrap();
    assert_eq!(spec, Spec::default());
    assert_eq!((spec.fraction, spec.seed), (0.5, 1));
}

#[test]
fn a_byte_order_mark_and_crlf_are_read() {
    let spec = Spec::from_toml("\u{feff}fraction = 0.4\r\nseed = 0x10\r\n").unwrap();
    assert_eq!((spec.fraction, spec.seed), (0.4, 16));
}

#[test]
fn the_whole_range_of_seeds_is_read() {
    assert_eq!(Spec::from_toml("seed = 18446744073709551615").unwrap().seed, u64::MAX);
    let value = serde_json::json!({ "seed": u64::MAX });
    assert_eq!(Spec::from_value(&value).unwrap().seed, u64::MAX);
}

#[test]
fn errors_name_the_line() {
    let text = "seed = 3\n\n[grading]\nd_min_mm = 5\nd_max_mm = 4\n";
    let error = Spec::from_toml(text).unwrap_err();
    assert_eq!(error.line, Some(4));
    assert_eq!(
        error.to_string(),
        "line 4: grading.d_min_mm is 5 but grading.d_max_mm is 4; the smallest size must be below the largest"
    );
    assert_eq!(Spec::from_toml("seed = 3\nfractoin = 1").unwrap_err().line, Some(2));
    assert_eq!(Spec::from_toml("seed = 3\n\nx =").unwrap_err().line, Some(3));
    assert_eq!(Spec::from_toml("[itz]\nthickness_mm = [\n 0.1,\n 'a']").unwrap_err().line, Some(2));
}

#[test]
fn wrong_types_and_wrong_values_are_told_apart() {
    let kind = |text| Spec::from_toml(text).unwrap_err().kind;
    assert_eq!(kind("fraction = 'x'"), SpecErrorKind::WrongType);
    assert_eq!(kind("fraction = 2"), SpecErrorKind::Value);
    assert_eq!(kind("seed = -1"), SpecErrorKind::Value);
    assert_eq!(kind("sed = 1"), SpecErrorKind::UnknownKey);
    assert_eq!(kind("seed 1"), SpecErrorKind::Syntax);
}

#[test]
fn a_tree_of_values_reads_as_toml_does() {
    let text = "fraction = 0.4\n[specimen]\nkind = 'box'\nsize_mm = [100, 50.5, 60]\n[placement]\nattempts = 100\n";
    let value = serde_json::json!({
        "fraction": 0.4,
        "specimen": { "kind": "box", "size_mm": [100, 50.5, 60] },
        "placement": { "attempts": 100, "time_limit_s": null },
    });
    assert_eq!(Spec::from_value(&value).unwrap(), Spec::from_toml(text).unwrap());
}

#[test]
fn a_spec_written_as_json_is_read_back_the_same() {
    let mut spec = Spec { seed: u64::MAX, fraction: 0.1 + 0.2, ..Spec::default() };
    spec.placement.time_limit_s = Some(1.0 / 3.0);
    assert_eq!(Spec::from_value(&serde_json::to_value(&spec).unwrap()).unwrap(), spec);
}

#[test]
fn deep_nesting_and_long_texts_end_in_an_error() {
    assert!(Spec::from_toml(&format!("a = {}", "[".repeat(100_000))).is_err());
    assert!(Spec::from_toml(&format!("{} = 1", vec!["a"; 100_000].join("."))).is_err());
    assert!(Spec::from_toml(&"x".repeat(10_000_000)).unwrap_err().to_string().len() < 300);
}

#[test]
fn the_estimate_of_the_papers_specimen_is_near_the_counted_12_685() {
    let estimate = Spec::default().estimated_aggregates();
    assert!((10_000.0..16_000.0).contains(&estimate), "{estimate}");
}
