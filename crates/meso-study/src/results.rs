//! Results that a study records of a packing, a mesh and a test.

use meso_pack::packing::Report;
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;

/// The figures of a packing, by the keys of `--summary-json`; no times and no counters of work.
pub fn of_packing(report: &Report) -> Map<String, Value> {
    let Value::Object(mut results) = json!({
        "aggregates": report.aggregates,
        "discarded": report.discarded,
        "fraction": report.fraction,
        "stop_reason": report.stop_reason,
        "target_fraction": report.target_fraction,
    }) else {
        return Map::new();
    };
    for phase in &report.phases {
        results.insert(phase.phase.plural().to_owned(), json!({ "bodies": phase.bodies, "fraction": phase.fraction }));
    }
    results
}

/// The figures of a summary: scalars, tables of these, and lists of tables with a `name`, which become tables by that
/// name. Other lists are left out, and so is `seconds`, which differs from run to run.
pub fn of_summary(summary: &Value) -> Value {
    match summary {
        Value::Object(map) => {
            let kept = map.iter().filter(|(key, _)| *key != "seconds");
            let figures = kept.map(|(key, value)| (key.clone(), of_summary(value)));
            Value::Object(figures.filter(|(_, value)| !value.is_null()).collect())
        }
        Value::Array(items) => {
            let named = |item: &Value| {
                let mut figures = of_summary(item);
                let name = figures.as_object_mut()?.remove("name")?;
                Some((name.as_str()?.to_owned(), figures))
            };
            let tables: Option<Map<String, Value>> = items.iter().map(named).collect();
            tables.filter(|tables| !tables.is_empty()).map_or(Value::Null, Value::Object)
        }
        scalar => scalar.clone(),
    }
}

/// A dotted name that two of the `results` have.
pub(crate) fn repeated(results: &Map<String, Value>) -> Option<String> {
    let mut seen = BTreeSet::new();
    flatten(results).map(|(name, _)| name).find(|name| !seen.insert(name.clone()))
}

/// The scalar results by dotted names.
pub(crate) fn flatten(results: &Map<String, Value>) -> impl Iterator<Item = (String, Value)> {
    let mut flat = Vec::new();
    results.iter().for_each(|(name, value)| flatten_into(&mut flat, name.clone(), value));
    flat.into_iter()
}

fn flatten_into(flat: &mut Vec<(String, Value)>, name: String, value: &Value) {
    match value {
        Value::Object(map) => map.iter().for_each(|(key, inner)| flatten_into(flat, format!("{name}.{key}"), inner)),
        Value::Array(_) | Value::Null => {}
        scalar => flat.push((name, scalar.clone())),
    }
}
