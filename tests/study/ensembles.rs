//! Mean, scatter, and how many repetitions the mean needs.

use crate::{plan, plan_of};
use meso_study::{Case, Record, Table, ensemble, quantile_975, tabulate};
use serde_json::{Map, json};

/// The ensembles of one figure `x` that the seeds 1 to 4 of two fractions give.
fn groups(x: [[f64; 4]; 2]) -> Table {
    let plan = plan(&[("fraction", json!([0.2, 0.3])), ("seed", json!([1, 2, 3, 4]))]).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let record = |(case, x): (_, &f64)| {
        Record::new(case, "", Ok(Map::from_iter([("x".to_owned(), json!(x))])).into(), folder.path()).unwrap()
    };
    let records: Vec<_> = plan.cases.iter().zip(x.as_flattened()).map(record).collect();
    ensemble(&tabulate(&plan.keys, &records), &plan.keys, "seed")
}

fn number(table: &Table, name: &str, row: usize) -> f64 {
    table.column(name).unwrap().values.json(row).as_f64().unwrap_or(f64::NAN)
}

#[test]
fn mean_and_scatter_are_of_each_combination_of_the_other_axes() {
    let table = groups([[1.0, 2.0, 3.0, 4.0], [10.0, 10.0, 10.0, 10.0]]);
    assert_eq!(table.rows(), 2);
    assert_eq!([number(&table, "fraction", 0), number(&table, "fraction", 1)], [0.2, 0.3]);
    assert_eq!([number(&table, "mean", 0), number(&table, "mean", 1)], [2.5, 10.0]);
    // statistics.stdev([1, 2, 3, 4]); scipy.stats.t.interval(0.95, 3, 2.5, that / 2).
    assert!((number(&table, "std", 0) - 1.290_994_448_735_805_6).abs() < 1e-15);
    assert!((number(&table, "low", 0) - 0.445_739_743_239_121).abs() < 1e-9);
    assert!((number(&table, "high", 0) - 4.554_260_256_760_879).abs() < 1e-9);
}

#[test]
fn the_mean_is_known_once_its_interval_is_one_percent() {
    let table = groups([[99.0, 101.0, 99.0, 101.0], [100.0, 100.0, 100.0, 100.0]]);
    let needed = number(&table, "needed", 0) as u64;
    let cv = number(&table, "cv", 0);
    let half = |n: u64| quantile_975(n - 1) * cv / (n as f64).sqrt();
    assert!(half(needed) <= 0.01 && half(needed - 1) > 0.01, "{needed}");
    assert_eq!(number(&table, "needed", 1), 2.0);
}

/// The ensembles of a figure that `of` some seeds of packings and of materials.
fn pairs(seeds: [&[i64]; 2], of: impl Fn(i64, i64) -> f64) -> Table {
    let axes = [("seed", json!(seeds[0])), ("solve.materials.scatter.seed", json!(seeds[1]))];
    let plan = plan_of(&axes, &json!({ "solve": {} })).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let record = |case: &Case| {
        let seed = |key: &str| case.values.iter().find(|(name, _)| name == key).unwrap().1.as_i64().unwrap();
        let x = of(seed("seed"), seed("solve.materials.scatter.seed"));
        Record::new(case, "", Ok(Map::from_iter([("x".to_owned(), json!(x))])).into(), folder.path()).unwrap()
    };
    let records: Vec<_> = plan.cases.iter().map(record).collect();
    ensemble(&tabulate(&plan.keys, &records), &plan.keys, "seed")
}

#[test]
fn scatter_is_split_between_packings_and_materials_as_an_analysis_of_variance_does() {
    let y = [[10.0, 12.0, 13.0], [14.0, 15.5, 17.0], [13.0, 15.0, 16.0], [18.0, 20.0, 21.5]];
    let table = pairs([&[1, 2, 3, 4], &[1, 2, 3]], |a, b| y[a as usize - 1][b as usize - 1]);
    assert_eq!((table.rows(), number(&table, "n", 0)), (1, 12.0));
    let mean = y.as_flattened().iter().sum::<f64>() / 12.0;
    assert!((number(&table, "mean", 0) - mean).abs() < 1e-12);
    let [a, b, e] = mean_squares(&y);
    let expected = [((a - e) / 3.0).sqrt(), ((b - e) / 4.0).sqrt(), ((a - e) / 3.0 + (b - e) / 4.0 + e).sqrt()];
    let found = ["std_packing", "std_material", "std"].map(|name| number(&table, name, 0));
    assert!(found.iter().zip(expected).all(|(found, expected)| (found / expected - 1.0).abs() < 1e-12), "{found:?}");
    let error = ((2.0 * a * a / 3.0 + 2.0 * e * e / 6.0).sqrt() / 3.0) / (2.0 * expected[0]);
    assert!((number(&table, "std_packing_error", 0) / error - 1.0).abs() < 1e-12);
    assert!(number(&table, "low", 0) < mean && mean < number(&table, "high", 0));
}

/// Mean squares of rows, columns and the rest, by their definition.
fn mean_squares(y: &[[f64; 3]; 4]) -> [f64; 3] {
    let mean = y.as_flattened().iter().sum::<f64>() / 12.0;
    let row = |i: usize| y[i].iter().sum::<f64>() / 3.0;
    let column = |j: usize| (0..4).map(|i| y[i][j]).sum::<f64>() / 4.0;
    let of_rows = (0..4).map(|i| 3.0 * (row(i) - mean).powi(2)).sum::<f64>() / 3.0;
    let of_columns = (0..3).map(|j| 4.0 * (column(j) - mean).powi(2)).sum::<f64>() / 2.0;
    let rest = |i: usize, j: usize| (y[i][j] - row(i) - column(j) + mean).powi(2);
    [of_rows, of_columns, (0..12).map(|k| rest(k / 3, k % 3)).sum::<f64>() / 6.0]
}

/// Normal numbers of a known scatter, drawn by splitmix64 and the sum of twelve.
fn normal(seed: u64) -> f64 {
    let uniform = |k: u64| {
        let mut z = (seed * 12 + k + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..12).map(uniform).sum::<f64>() - 6.0
}

#[test]
fn the_scatters_of_many_packings_and_materials_are_those_they_were_drawn_with() {
    let seeds: Vec<i64> = (1..=40).collect();
    let table = pairs([&seeds, &seeds], |a, b| {
        let [of_packing, of_material, rest] = [a, 1000 + b, 10_000 + 100 * a + b].map(|seed| normal(seed as u64));
        100.0 + of_packing + 3.0 * of_material + 0.5 * rest
    });
    for (name, expected) in [("std_packing", 1.0), ("std_material", 3.0), ("std", 3.2_f64)] {
        let found = number(&table, name, 0);
        // 40 seeds know a standard deviation to 11 %.
        assert!((found / expected - 1.0).abs() < 0.3, "{name} {found}");
    }
    let error = number(&table, "std_material_error", 0) / number(&table, "std_material", 0);
    assert!((error / (0.5_f64 / 39.0).sqrt() - 1.0).abs() < 0.1, "{error}");
    // Repetitions have packings and materials of their own.
    let needed = number(&table, "needed", 0);
    let cv = number(&table, "cv", 0);
    assert!((needed / (1.96 * cv / 0.01).powi(2) - 1.0).abs() < 0.1, "{needed}");
}

#[test]
fn one_seed_of_two_has_all_the_scatter() {
    let table = pairs([&[5], &[1, 2, 3, 4]], |_, b| b as f64);
    assert_eq!(number(&table, "std_material", 0), number(&table, "std", 0));
    assert!(number(&table, "std_packing", 0).is_nan());
    let table = pairs([&[1, 2, 3, 4], &[5]], |a, _| a as f64);
    assert_eq!(number(&table, "std_packing", 0), number(&table, "std", 0));
    assert!(number(&table, "std_material", 0).is_nan());
    // Scatter of the material alone, in every packing.
    let table = pairs([&[1, 2, 3], &[1, 2, 3, 4]], |_, b| b as f64);
    assert_eq!(number(&table, "std_packing", 0), 0.0);
    assert!((number(&table, "std_material", 0) - 1.290_994_448_735_805_6).abs() < 1e-12);
}

#[test]
fn quantiles_equal_students_t() {
    // scipy.stats.t.ppf(0.975, n).
    for (degrees, expected) in [
        (1, 12.706_204_736_174_694),
        (2, 4.302_652_729_749_462),
        (3, 3.182_446_305_283_707_8),
        (4, 2.776_445_105_197_793_4),
        (9, 2.262_157_162_798_205),
        (30, 2.042_272_456_301_238),
        (999, 1.962_341_461_133_449_2),
        (1000, 1.962_339_080_826_407_4),
        (1_000_000, 1.959_966_356_814_107),
    ] {
        let found = quantile_975(degrees);
        assert!((found / expected - 1.0).abs() < 1e-9, "{degrees}: {found} {expected}");
    }
}
