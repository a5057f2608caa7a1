//! One tidy table, as CSV.

use crate::plan;
use meso_study::{Record, Table, Values, of_summary, tabulate};
use serde_json::{Map, Value, json};

/// The table of two cases: one with these results, one that failed.
fn table(results: Value) -> Table {
    let plan = plan(&[("seed", json!([1, 2])), ("fraction", json!([0.2]))]).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let ended = [Ok(results.as_object().unwrap().clone()), Err("no, \"no\"\nroom".to_owned())];
    let cases = plan.cases.iter().zip(ended);
    let records: Vec<_> =
        cases.map(|(case, ended)| Record::new(case, "", ended.into(), folder.path()).unwrap()).collect();
    tabulate(&plan.keys, &records)
}

#[test]
fn columns_are_the_case_its_values_and_its_results() {
    let table = table(json!({ "fraction": 0.2, "aggregates": 12, "solve": { "peak_mpa": 31, "list": [1, 2] } }));
    let names: Vec<_> = table.columns.iter().map(|column| column.name.as_str()).collect();
    let results = ["aggregates", "result.fraction", "solve.peak_mpa"];
    assert_eq!(names, [&["case", "seed", "fraction", "status"][..], &results, &["warnings", "error"]].concat());
    assert_eq!(table.column("seed").unwrap().values, Values::Integer(vec![Some(1), Some(2)]));
    assert_eq!(table.column("solve.peak_mpa").unwrap().values, Values::Integer(vec![Some(31), None]));
    let status = Values::Text(["done", "failed"].map(|word| Some(word.to_owned())).to_vec());
    assert_eq!(table.column("status").unwrap().values, status);
}

#[test]
fn csv_quotes_separators_and_leaves_missing_values_empty() {
    let table = table(json!({ "x": 0.1, "ok": true }));
    let mut csv = Vec::new();
    table.write_csv(&mut csv).unwrap();
    let csv = String::from_utf8(csv).unwrap();
    let mut lines = csv.lines();
    assert_eq!(lines.next().unwrap(), "case,seed,fraction,status,ok,x,warnings,error");
    assert!(lines.next().unwrap().ends_with(",1,0.2,done,true,0.1,,"));
    assert!(csv.ends_with(",2,0.2,failed,,,,\"no, \"\"no\"\"\nroom\"\n"), "{csv}");
}

#[test]
fn summaries_lose_their_times_and_lists_of_names_become_tables() {
    let summary = json!({
        "peak_mpa": 31.5, "seconds": { "solve": 1.0 }, "warnings": ["a"],
        "phases": [{ "name": "mortar", "volume_fraction": 0.6 }, { "name": "ITZ", "volume_fraction": 0.1 }],
    });
    let expected = json!({
        "peak_mpa": 31.5, "phases": { "mortar": { "volume_fraction": 0.6 }, "ITZ": { "volume_fraction": 0.1 } },
    });
    assert_eq!(of_summary(&summary), expected);
}

/// The shared case then_results.py: 2^63 became a float, and of `seed` and `result.seed` one was lost.
#[test]
fn large_whole_numbers_stay_exact() {
    let large = json!({ "n": 1_u64 << 63, "m": -5, "x": 0.5 });
    let table = table(large);
    assert_eq!(table.column("n").unwrap().values, Values::Integer(vec![Some(1 << 63), None]));
    assert_eq!(table.column("n").unwrap().values.json(0), json!(1_u64 << 63));
}

/// The values of one result in several cases.
fn column(values: &[Value]) -> Values {
    let seeds: Vec<usize> = (0..values.len()).collect();
    let plan = plan(&[("seed", json!(seeds))]).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let record = |(case, value): (_, &Value)| {
        Record::new(case, "", Ok(Map::from_iter([("v".to_owned(), value.clone())])).into(), folder.path()).unwrap()
    };
    let records: Vec<_> = plan.cases.iter().zip(values).map(record).collect();
    tabulate(&plan.keys, &records).column("v").unwrap().values.clone()
}

#[test]
fn a_column_has_the_narrowest_type_that_keeps_every_value() {
    let (odd, even) = ((1_u64 << 53) + 1, 1_u64 << 53);
    assert_eq!(
        column(&[json!(u64::MAX), json!(i64::MIN)]),
        Values::Integer(vec![Some(u64::MAX.into()), Some(i64::MIN.into())])
    );
    assert_eq!(column(&[json!(even), json!(0.5)]), Values::Float(vec![Some(9_007_199_254_740_992.0), Some(0.5)]));
    let texts = |words: [&str; 2]| Values::Text(words.map(|word| Some(word.to_owned())).to_vec());
    assert_eq!(column(&[json!(odd), json!(0.5)]), texts(["9007199254740993", "0.5"]));
    assert_eq!(column(&[json!(true), json!(1)]), texts(["true", "1"]));
    assert_eq!(column(&[json!("a"), json!(2)]), texts(["a", "2"]));
}

#[test]
fn results_named_like_other_columns_keep_columns_of_their_own() {
    let names = |results| -> Vec<String> {
        let table = table(results);
        let unique: std::collections::BTreeSet<_> = table.columns.iter().map(|column| &column.name).collect();
        assert_eq!(unique.len(), table.columns.len());
        table.columns.iter().skip(4).map(|column| column.name.clone()).collect()
    };
    assert_eq!(
        names(json!({ "seed": 1, "result.seed": 2 })),
        ["result.seed", "result.result.seed", "warnings", "error"]
    );
    assert_eq!(names(json!({ "seed": 1, "result": { "seed": 2 } })).len(), 4);
    assert_eq!(names(json!({ "case": 1, "status": 2, "warnings": 3, "error": 4 })).len(), 6);
    assert_eq!(names(json!({ "seed": 1, "result.seed": 2, "result.result.seed": 3 })).len(), 5);
    assert_eq!(names(json!({ "fraction": 1, "result.fraction": true, "x.y": "z" })).len(), 5);
}
