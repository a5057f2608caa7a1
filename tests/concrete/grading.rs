//! Curves, classes, size laws, mix designs, recipes.

use crate::pack::folder::{Folder, Heard};
use meso_core::aggregate::{Curve, Form, Grading, SizeLaw, Standard};
use meso_core::recipes;
use meso_core::spec::Spec;

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-12
}

fn grading(text: &str) -> Grading {
    Spec::from_toml(&format!("itz = {{ thickness_mm = [0, 0] }}\n[grading]\n{text}"))
        .unwrap_or_else(|e| panic!("{e}"))
        .grading
}

#[test]
fn normalised_fuller_gives_the_computed_table_1() {
    let grading = Grading::default();
    // (sqrt d - sqrt 5) / (sqrt 20 - sqrt 5), to four digits.
    for (d, share) in
        [(5.0, 0.0), (8.0, 0.2649), (10.0, 0.4142), (12.5, 0.5811), (15.0, 0.7321), (16.0, 0.7889), (20.0, 1.0)]
    {
        assert!((grading.passing(d) - share).abs() < 5e-5, "{d}: {}", grading.passing(d));
    }
    assert_eq!([grading.passing(1.0), grading.passing(30.0)], [0.0, 1.0]);
}

#[test]
fn raw_fuller_leaves_out_what_is_finer() {
    let raw = grading("form = 'raw'");
    assert!(near(raw.passing(5.0), 0.5));
    assert!(near(raw.classes().iter().map(|class| class.share).sum(), 0.5));
}

#[test]
fn the_shares_of_every_normalised_curve_sum_to_1() {
    for text in [
        "curve = { kind = 'fuller', exponent = 0.45 }",
        "curve = { kind = 'bolomey', a = 0.1 }",
        "curve = { kind = 'sieves', sieves_mm = [4, 8, 16, 32], passing = [0.1, 0.4, 0.7, 1] }",
        "curve = { kind = 'standard', name = 'din-1045-2-c32' }",
        "curve = { kind = 'standard', name = 'astm-c33-57' }\nsize_law = 'volume-uniform'",
    ] {
        let classes = grading(text).classes();
        assert!(classes.iter().all(|class| class.share > 0.0), "{text}: {classes:?}");
        assert!(near(classes.iter().map(|class| class.share).sum(), 1.0), "{text}");
    }
}

#[test]
fn bolomey_has_its_fines_from_the_start() {
    let curve = Curve::Bolomey { a: 0.1 };
    assert!(near(curve.passing(0.0, 16.0), 0.1));
    assert!(near(curve.passing(4.0, 16.0), 0.55));
    assert!(near(curve.passing(16.0, 16.0), 1.0));
}

#[test]
fn a_sieve_table_is_met_on_its_sieves_and_linear_in_log_d_between() {
    let curve = Curve::Sieves { sieves_mm: vec![4.0, 8.0, 16.0], passing: vec![0.2, 0.5, 1.0] };
    for (d, share) in [(4.0, 0.2), (8.0, 0.5), (16.0, 1.0), (8.0 * 2f64.sqrt(), 0.75), (2.0, 0.2), (99.0, 1.0)] {
        assert!(near(curve.passing(d, 16.0), share), "{d}: {}", curve.passing(d, 16.0));
    }
}

#[test]
fn shares_retained_after_gbt_14685_become_shares_that_pass() {
    let rows = Standard::Gb5To20.rows();
    assert_eq!(rows[2], (9.5, 20.0, 60.0), "40 to 80 % are retained on 9.5 mm");
    assert_eq!(rows[4], (26.5, 100.0, 100.0), "nothing is retained on 26.5 mm");
}

#[test]
fn every_standard_curve_rises_to_1() {
    for standard in Standard::ALL {
        let points: Vec<_> = standard.points().collect();
        assert!(points.windows(2).all(|w| w[0].0 < w[1].0 && w[0].1 <= w[1].1), "{standard:?}: {points:?}");
        assert_eq!(points.last().unwrap().1, 1.0, "{standard:?}");
    }
}

#[test]
fn din_lines_have_the_k_values_of_the_handbook() {
    // k: the sum of the shares retained, in percent, on the nine sieves from 0.25 to 63 mm, over 100 (betontechnische-daten.de,
    // Sec. 2.7.2).
    let k = |standard: Standard| standard.points().map(|(_, passing)| 1.0 - passing).sum::<f64>();
    for (standard, expected) in [
        (Standard::DinA8, 3.63),
        (Standard::DinB8, 2.90),
        (Standard::DinC8, 2.27),
        (Standard::DinA16, 4.60),
        (Standard::DinB16, 3.66),
        (Standard::DinC16, 2.75),
        (Standard::DinA32, 5.48),
        (Standard::DinB32, 4.20),
        (Standard::DinC32, 3.30),
    ] {
        assert!((k(standard) - expected).abs() < 1e-9, "{standard:?}: {}", k(standard));
    }
}

#[test]
fn bands_of_the_standards_narrow_to_all_and_do_not_cross() {
    for standard in Standard::ALL {
        let rows = standard.rows();
        assert!(rows.iter().all(|row| 0.0 <= row.1 && row.1 <= row.2 && row.2 <= 100.0), "{standard:?}: {rows:?}");
        assert!(rows.windows(2).all(|w| w[0].1 <= w[1].1 && w[0].2 <= w[1].2), "{standard:?}: {rows:?}");
    }
}

#[test]
fn an_astm_size_of_three_digits_spans_the_sizes_it_is_made_of() {
    // 467 is 4, 6 and 7 together: from the finest of 7 to the coarsest of 4.
    let sieves = |standard: Standard| standard.rows().iter().map(|row| row.0).collect::<Vec<_>>();
    let sizes = [
        (Standard::Astm357, Standard::Astm3),
        (Standard::Astm467, Standard::Astm4),
        (Standard::Astm56, Standard::Astm5),
        (Standard::Astm89, Standard::Astm8),
    ];
    for (whole, coarse) in sizes {
        assert_eq!(sieves(whole).last(), sieves(coarse).last(), "{whole:?}");
    }
    assert_eq!(sieves(Standard::Astm67), [2.36, 4.75, 9.5, 19.0, 25.0]);
    assert_eq!(Standard::Astm7.rows()[2], (9.5, 40.0, 70.0));
}

/// Each size with its nominal limits, mm, from the standard.
#[test]
fn every_size_of_astm_c33_has_its_name_and_nine_tenths_within_its_limits() {
    for (size, d_min, d_max) in [
        ("1", 37.5, 90.0),
        ("2", 37.5, 63.0),
        ("3", 25.0, 50.0),
        ("357", 4.75, 50.0),
        ("4", 19.0, 37.5),
        ("467", 4.75, 37.5),
        ("5", 12.5, 25.0),
        ("56", 9.5, 25.0),
        ("57", 4.75, 25.0),
        ("6", 9.5, 19.0),
        ("67", 4.75, 19.0),
        ("7", 4.75, 12.5),
        ("8", 2.36, 9.5),
        ("89", 1.18, 9.5),
        ("9", 1.18, 4.75),
    ] {
        let name = format!("curve = {{ kind = 'standard', name = 'astm-c33-{size}' }}");
        let curve = grading(&format!("{name}\nd_min_mm = {d_min:?}\nd_max_mm = {d_max:?}")).curve;
        let within = curve.passing(d_max, d_max) - curve.passing(d_min, d_max);
        assert!((0.84..0.96).contains(&within), "{size}: {within}");
    }
}

#[test]
fn classes_come_from_what_is_asked() {
    assert_eq!(grading("d_min_mm = 5").classes_mm, [5.0, 10.0, 15.0, 20.0]);
    assert_eq!(grading("d_max_mm = 40").classes_mm, [5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0]);
    assert_eq!(grading("d_min_mm = 4\nd_max_mm = 18").classes_mm, [4.0, 5.6, 8.0, 11.2, 16.0, 18.0]);
    let din = "curve = { kind = 'standard', name = 'din-1045-2-a16' }\nd_min_mm = 3\nd_max_mm = 16";
    assert_eq!(grading(din).classes_mm, [3.0, 4.0, 8.0, 16.0]);
    assert_eq!(grading("classes_mm = [5, 7, 20]").classes_mm, [5.0, 7.0, 20.0]);
}

#[test]
fn size_laws_keep_to_the_class_and_to_their_mean() {
    for law in [SizeLaw::Uniform, SizeLaw::VolumeUniform] {
        assert!(near(law.size(5.0, 10.0, 0.0), 5.0) && near(law.size(5.0, 10.0, 1.0), 10.0));
        let steps = 100_000;
        let sizes = (0..steps).map(|i| law.size(5.0, 10.0, (f64::from(i) + 0.5) / f64::from(steps)));
        let mean = sizes.map(|d| d * d * d).sum::<f64>() / f64::from(steps);
        assert!((mean / law.mean_cube(5.0, 10.0) - 1.0).abs() < 1e-6, "{law:?}: {mean}");
    }
}

#[test]
fn volume_uniform_puts_equal_volume_into_equal_ratios_of_size() {
    let steps = 200_000;
    let (mut lower, mut upper) = (0.0, 0.0);
    for i in 0..steps {
        let d = SizeLaw::VolumeUniform.size(4.0, 16.0, (f64::from(i) + 0.5) / f64::from(steps));
        *(if d < 8.0 { &mut lower } else { &mut upper }) += d * d * d;
    }
    assert!((lower / upper - 1.0).abs() < 1e-4, "{lower} {upper}");
}

#[test]
fn a_mix_design_gives_the_fraction_that_is_coarse() {
    let mix =
        "[mix]\ncement_kg_per_m3 = 315\nwater_kg_per_m3 = 180\nair = 0.02\n[grading]\nd_min_mm = 5\nd_max_mm = 20\n";
    // 1 - 0.1 - 0.18 - 0.02 = 0.7 is aggregate; Fuller leaves half of it above 5 of 20 mm.
    assert!(near(Spec::from_toml(mix).unwrap().fraction, 0.35));
    let raw = Spec::from_toml(&format!("{mix}form = 'raw'\n")).unwrap();
    assert!(near(raw.fraction, 0.7) && raw.grading.form == Form::Raw);
}

#[test]
fn a_sieve_table_is_read_from_a_file_that_the_caller_opens() {
    let text = "[grading]\ncurve = { kind = 'sieves', file = 'stone.csv' }\nd_min_mm = 4\nd_max_mm = 16\n";
    let read = |csv: &'static str| Spec::from_toml_with(text, &mut Folder(&[("stone.csv", csv.as_bytes())]));
    let spec = read("# from the quarry\r\nsieve_mm, passing_percent\r\n16, 100\r\n4, 10\r\n\r\n8, 45\r\n").unwrap();
    let expected = Curve::Sieves { sieves_mm: vec![4.0, 8.0, 16.0], passing: vec![0.1, 0.45, 1.0] };
    assert_eq!(spec.grading.curve, expected);
    assert_eq!(read("sieve_mm,passing\n4,0.1\n8,0.45\n16,1\n").unwrap().grading.curve, expected);
    // As spreadsheets write them where a comma stands before the decimals.
    assert_eq!(read("\u{feff}Sieve_mm;Passing\r\n4;0,1\r\n8;0,45\r\n16;1\r\n").unwrap().grading.curve, expected);
    assert_eq!(read("\"sieve_mm\"\tpassing\n4\t0.1\n8\t0,45\n16\t1\n").unwrap().grading.curve, expected);
    for (csv, part) in [
        ("sieve_mm,passing_percent\n4,0.1\n16,1\n", "no number is above 1: these are shares"),
        ("sieve_mm,passing\n4;0.1\n", "it has no two columns"),
        (
            "sieve_mm,passing\n4,0.1\n8,0.05\n16,1\n",
            "line 2: 0.1 at 4 mm after 0.05 at 8 mm, but more passes a wider sieve",
        ),
        ("", "it has no two columns"),
    ] {
        let error = read(csv).unwrap_err().to_string();
        assert!(error.contains(part), "{csv:?}: {error}");
    }
    let error = Spec::from_toml(text).unwrap_err().to_string();
    assert!(error.contains("line 2: grading.curve.file is \"stone.csv\": files cannot be read here"), "{error}");
}

#[test]
fn a_spec_says_how_it_read_a_sieve_table_and_which_share_of_the_curve_it_models() {
    let csv = "Sieve (mm);Sand;Gravel\n16;100;100\n8;100;40\n4;90;10\n1;20;0\n";
    let spec = |keys: &str| {
        let text =
            format!("[grading]\ncurve = {{ kind = 'sieves', file = 'a.csv'{keys} }}\nd_min_mm = 4\nd_max_mm = 8\n");
        let mut files = Heard(Folder(&[("a.csv", csv.as_bytes())]), Vec::new());
        Spec::from_toml_with(&text, &mut files).map(|spec| (spec, files.1)).map_err(|error| error.to_string())
    };
    let (read, remarks) = spec(", blend = { Sand = 40, Gravel = 60 }").unwrap();
    assert!(near(read.grading.curve.passing(4.0, 16.0), 0.42) && near(read.grading.curve.passing(8.0, 16.0), 0.64));
    let [remark] = &remarks[..] else { panic!("{remarks:?}") };
    assert!(remark.ends_with("4 to 8 mm is 22 % of the curve, 36 % is coarser and 42 % finer"), "{remark}");
    let (_, remarks) = spec(", column = 'Sand' }\nsize = 'longest-axis'\n#").unwrap();
    assert!(remarks[0].ends_with("; grading.size takes its openings as longest axes"), "{remarks:?}");
    assert!(near(spec(", column = 'Sand'").unwrap().0.grading.curve.passing(4.0, 16.0), 0.9));
    for (keys, part) in [
        ("", "can be the grading; name one beside file"),
        (", blend = { Sand = 0.4, Gravel = 0.5 }", "line 2: grading.curve.blend sums to 0.9"),
        (", column = true", "grading.curve.column is true; it must be a heading in quotes"),
        (", column = 2, means = 'passed'", "grading.curve.means is \"passed\"; it must be one of \"passing\""),
        (", column = 2, sheet = 'a'", "only Python reads sheets"),
    ] {
        let reason = spec(keys).unwrap_err();
        assert!(reason.contains(part), "{keys}: {reason}");
    }
}

#[test]
fn every_recipe_is_a_spec_that_can_be() {
    for recipe in recipes::Recipe::ALL {
        let spec = Spec::from_toml(recipe.text).unwrap_or_else(|error| panic!("{}: {error}", recipe.name));
        assert!(recipe.title().len() > 20 && recipe.text.starts_with("# "), "{} has no title", recipe.name);
        assert!(spec.estimated_aggregates() < 1e5, "{} is too large to start from", recipe.name);
    }
    assert_eq!(Spec::from_toml(recipes::Recipe::find("paper").unwrap().text).unwrap(), Spec::default());
}

#[test]
fn classes_that_nobody_named_are_of_5_mm_up_to_100_mm_and_then_the_standards_sieves() {
    let classes = |d_max_mm: f64| Grading { d_max_mm, ..Grading::default() }.usual_classes();
    assert_eq!(classes(100.0), (1..=20).map(|k| f64::from(k) * 5.0).collect::<Vec<_>>());
    assert_eq!(classes(120.0), [5.0, 5.6, 8.0, 11.2, 16.0, 22.4, 31.5, 45.0, 63.0, 120.0]);
}
