//! Keys and values that a SPEC.toml may have, and the errors of others.

use crate::bad_specs::REJECTED;
use meso_core::aggregate::SizeDefinition;
use meso_core::materials::{Elastic, Materials, MortarStrength};
#[cfg(feature = "schema")]
use meso_core::recipes::Recipe;
use meso_core::spec::{Spec, options_from_toml};
use meso_core::{Silent, pack};

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
        "line 4: grading.d_min_mm is 5 but d_max_mm is 4; the smallest size must be below the largest"
    );
    assert_eq!(Spec::from_toml("seed = 3\nfractoin = 1").unwrap_err().line, Some(2));
    assert_eq!(Spec::from_toml("seed = 3\n\nx =").unwrap_err().line, Some(3));
    assert_eq!(Spec::from_toml("[itz]\nthickness_mm = [\n 0.1,\n 'a']").unwrap_err().line, Some(2));
}

#[test]
fn an_error_distinguishes_wrong_types_from_wrong_values() {
    let is_wrong_type = |text| Spec::from_toml(text).unwrap_err().is_wrong_type;
    assert!(is_wrong_type("fraction = 'x'"));
    assert!(["fraction = 2", "seed = -1", "sed = 1", "seed 1"].into_iter().all(|text| !is_wrong_type(text)));
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

/// The paper's spec with a target, a specimen and lines of `[placement]`.
fn crowded(fraction: f64, specimen: &str, placement: &str) -> Result<Spec, meso_core::spec::SpecError> {
    Spec::from_toml(&format!("fraction = {fraction}\nspecimen = {{ {specimen} }}\n[placement]\n{placement}"))
}

#[test]
fn gaps_that_leave_no_room_are_named_before_the_work() {
    let cube = "kind = 'cube', side_mm = 61";
    for (fraction, placement, key, part) in [
        (0.4, "wall_gap_mm = 20", "placement.wall_gap_mm", "is 20, which leaves no room for a fraction of 0.4"),
        (0.5, "min_gap_mm = 6", "placement.min_gap_mm", "is 6, which leaves no room for a fraction of 0.5"),
        (0.5, "min_gap_mm = 6\nwall_gap_mm = 3", "placement.min_gap_mm", "lower the gap or the fraction"),
    ] {
        let error = pack(&crowded(fraction, cube, placement).unwrap(), &Silent).unwrap_err();
        assert!(error.key == key && error.message.contains(part), "{error}");
    }
    // A fraction of 0.04 fills the room of 21 mm that a gap of 20 mm leaves; without walls there is no such gap.
    let crowding = |fraction, specimen| crowded(fraction, specimen, "wall_gap_mm = 20").unwrap().crowding();
    assert!(crowding(0.03, cube) < 0.75, "{}", crowding(0.03, cube));
    assert!((crowding(0.4, "kind = 'cube', side_mm = 61, periodic = ['x', 'y', 'z']") - 0.4).abs() < 1e-12);
}

#[test]
fn a_target_beyond_reach_is_doubted_before_the_work() {
    let doubt =
        |fraction, specimen, placement| crowded(fraction, specimen, placement).unwrap().doubts().into_iter().next();
    let paper = "kind = 'cube', side_mm = 150";
    assert_eq!(Spec::default().doubts(), [""; 0]);
    assert_eq!(doubt(0.70, paper, ""), None);
    assert_eq!(doubt(0.50, paper, "min_gap_mm = 0.5"), None);
    assert_eq!(doubt(0.72, "kind = 'cube', side_mm = 60, periodic = ['x', 'y', 'z']", ""), None);
    for (fraction, specimen, placement, part) in [
        (0.85, paper, "", "0.85 is more than this strategy reached in tests, 0.70"),
        (0.65, "kind = 'cube', side_mm = 40", "", "0.65 is more than this strategy reached in tests, 0.61"),
        (0.60, paper, "min_gap_mm = 1", "0.6 with its gaps is as dense as 0.89 without"),
        (0.45, paper, "attempts = 100", "give more attempts, or take the strategy rearrange"),
        (0.45, paper, "strategy = 'rearrange'\nattempts = 100", "attempts count for the strategy take-and-place alone"),
    ] {
        let found = doubt(fraction, specimen, placement).unwrap_or_else(|| panic!("{fraction} {specimen} {placement}"));
        assert!(found.contains(part), "{found}");
    }
}

#[test]
fn materials_that_are_left_out_are_those_usual_of_the_phase() {
    let text = "[fibre]\nyoungs_modulus_mpa = 5e4\n[mortar_strength]\npeak_strain = 0.003";
    let read: Materials = options_from_toml(text).unwrap();
    let usual = Materials::default();
    assert_eq!(read.fibre, Elastic { youngs_modulus_mpa: 5e4, ..usual.fibre });
    assert_eq!(read.mortar_strength, MortarStrength { peak_strain: 0.003, ..usual.mortar_strength });
    assert_eq!(read, Materials { fibre: read.fibre, mortar_strength: read.mortar_strength, ..usual });
    let error = options_from_toml::<Materials>("mortar = { poison_ratio = 0.2 }").unwrap_err();
    assert!(
        error.to_string().contains("mortar.poison_ratio is not a known key; did you mean poisson_ratio"),
        "{error}"
    );
    let error = options_from_toml::<Materials>("itz = { density_t_per_mm3 = 'heavy' }").unwrap_err();
    assert!(error.to_string().contains("itz.density_t_per_mm3 is \"heavy\""), "{error}");
}

#[cfg(feature = "schema")]
#[test]
fn every_key_of_every_recipe_is_explained_and_the_text_reads_back() {
    for recipe in Recipe::ALL {
        let spec = Spec::from_toml(recipe.text).unwrap();
        let text = spec.describe().unwrap();
        assert_eq!(Spec::from_toml(&text).unwrap(), spec, "{}", recipe.name);
        let lines: Vec<&str> = text.lines().collect();
        for (above, line) in lines.iter().zip(&lines[1..]).filter(|(_, line)| line.contains(" = ")) {
            assert!(line.starts_with('#') || above.starts_with("# "), "{}: {line}", recipe.name);
        }
    }
}

/// Hashes of cases are made of this text.
#[cfg(feature = "schema")]
#[test]
fn the_sorted_text_of_a_spec_is_that_of_its_tree_of_values() {
    for recipe in Recipe::ALL {
        let spec = Spec::from_toml(recipe.text).unwrap();
        assert_eq!(spec.sorted_json(), serde_json::to_value(&spec).unwrap().to_string(), "{}", recipe.name);
    }
}

#[cfg(feature = "schema")]
#[test]
fn a_key_of_few_words_names_them_and_a_variant_says_what_it_is() {
    let text = Spec::default().describe().unwrap();
    assert!(text.contains("One of \"auto\", \"take-and-place\", \"rearrange\".\nstrategy = \"auto\"\n"), "{text}");
    assert!(text.contains("# A cube from the origin.\nkind = \"cube\"\n"), "{text}");
}

/// A laboratory's file without `size` was taken as longest axes: 1,171 grains for 220.
#[test]
fn sizes_are_openings_in_tables_and_standards_and_longest_axes_in_formulas() {
    let table = "kind = 'sieves', sieves_mm = [4, 8, 16], passing = [0.3, 0.6, 1]";
    for (curve, size) in [
        (table, SizeDefinition::Sieve),
        ("kind = 'sieves', sieves_mm = [4, 8, 16], passing_percent = [30, 60, 100]", SizeDefinition::Sieve),
        ("kind = 'standard', name = 'din-1045-2-b16'", SizeDefinition::Sieve),
        ("kind = 'fuller', exponent = 0.45", SizeDefinition::LongestAxis),
        ("kind = 'bolomey', a = 0.1", SizeDefinition::LongestAxis),
    ] {
        let spec = |size: &str| {
            let text = format!("[grading]\nd_min_mm = 4\nd_max_mm = 16\ncurve = {{ {curve} }}\n{size}");
            Spec::from_toml(&text).unwrap().grading.size
        };
        assert_eq!(spec(""), size, "{curve}");
        assert_eq!(spec("size = 'sieve'"), SizeDefinition::Sieve, "{curve}");
        assert_eq!(spec("size = 'longest-axis'"), SizeDefinition::LongestAxis, "{curve}");
    }
    // Where no curve is named it is the paper's.
    assert_eq!(Spec::from_toml("seed = 2").unwrap().grading.size, SizeDefinition::LongestAxis);
    // A saved spec says its size, so that an old model stays as it was.
    let mut old = Spec::from_toml(&format!("[grading]\nd_min_mm = 4\nd_max_mm = 16\ncurve = {{ {table} }}")).unwrap();
    old.grading.size = SizeDefinition::LongestAxis;
    let text = old.to_json().unwrap();
    assert_eq!(Spec::from_value(&serde_json::from_str(&text).unwrap()).unwrap(), old);
}
