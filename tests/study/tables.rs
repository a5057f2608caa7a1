//! One tidy table, as CSV.

use crate::plan;
use meso_study::{Record, Table, Values, of_summary, tabulate};
use serde_json::{Value, json};

/// The table of two cases: one with these results, one that failed.
fn table(results: Value) -> Table {
    let plan = plan(&[("seed", json!([1, 2])), ("fraction", json!([0.2]))]).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let ended = [Ok(results.as_object().unwrap().clone()), Err("no, \"no\"\nroom".to_owned())];
    let cases = plan.cases.iter().zip(ended);
    let records: Vec<_> = cases.map(|(case, ended)| Record::new(case, "", ended, folder.path()).unwrap()).collect();
    tabulate(&plan.keys, &records)
}

#[test]
fn columns_are_the_case_its_values_and_its_results() {
    let table = table(json!({ "fraction": 0.2, "aggregates": 12, "solve": { "peak_mpa": 31, "list": [1, 2] } }));
    let names: Vec<_> = table.columns.iter().map(|column| column.name.as_str()).collect();
    let results = ["aggregates", "result.fraction", "solve.peak_mpa"];
    assert_eq!(names, [&["case", "seed", "fraction", "status"][..], &results, &["error"]].concat());
    assert_eq!(table.column("seed").unwrap().values, Values::Integer(vec![Some(1), Some(2)]));
    assert_eq!(table.column("solve.peak_mpa").unwrap().values, Values::Integer(vec![Some(31), None]));
    let status = Values::Text(["done", "failed"].map(|word| Some(word.to_owned())).to_vec());
    assert_eq!(table.column("status").unwrap().values, status);
}

#[test]
fn csv_quotes_what_needs_it_and_leaves_empty_what_is_not_there() {
    let table = table(json!({ "x": 0.1, "ok": true }));
    let mut csv = Vec::new();
    table.write_csv(&mut csv).unwrap();
    let csv = String::from_utf8(csv).unwrap();
    let mut lines = csv.lines();
    assert_eq!(lines.next().unwrap(), "case,seed,fraction,status,ok,x,error");
    assert!(lines.next().unwrap().ends_with(",1,0.2,done,true,0.1,"));
    assert!(csv.ends_with(",2,0.2,failed,,,\"no, \"\"no\"\"\nroom\"\n"), "{csv}");
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
