//! Mean, scatter, and how many repetitions the mean needs.

use crate::plan;
use meso_study::{Record, Table, ensemble, quantile_975, tabulate};
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
