//! Results that a study records of a packing, a mesh, a test and effective properties.

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
    let phases = report.phases.iter().map(|of| (of.phase.plural(), of.bodies, of.fraction));
    let own = report.own_phases.iter().map(|of| (of.phase.as_str(), of.aggregates, of.fraction));
    let shells = report.shells.iter().map(|of| (of.phase.as_str(), of.aggregates, of.fraction));
    let figures = |(name, bodies, fraction): (&str, usize, f64)| {
        (name.to_owned(), json!({ "bodies": bodies, "fraction": fraction }))
    };
    results.extend(phases.chain(own).chain(shells).map(figures));
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

/// The figures of effective properties, by property: those of a summary, and the entries of tensor, error and expansion by their
/// axes, as in `diffusivity.tensor.xx` and `stiffness.tensor.xx_yy`.
pub fn of_effective(found: &Value) -> Value {
    let all = found.as_array().map_or(std::slice::from_ref(found), Vec::as_slice);
    Value::Object(all.iter().filter_map(of_property).collect())
}

fn of_property(found: &Value) -> Option<(String, Value)> {
    let name = found["what"].as_str()?.to_owned();
    let mut figures = of_summary(found);
    let columns = figures.as_object_mut()?;
    columns.remove("what");
    for key in ["tensor", "error", "expansion", "expansion_error"] {
        columns.extend(found.get(key).map(|entries| (key.to_owned(), by_axes(entries))));
    }
    Some((name, figures))
}

/// Entries by the names of their axes; a symmetric 6 x 6 tensor has its upper part.
fn by_axes(entries: &Value) -> Value {
    let rows = entries.as_array().map_or(&[][..], Vec::as_slice);
    let names = if rows.len() == 3 { &["x", "y", "z"][..] } else { &["xx", "yy", "zz", "yz", "zx", "xy"] };
    let mut named = Map::new();
    for (i, (row, name)) in rows.iter().zip(names).enumerate() {
        let Some(row) = row.as_array() else {
            named.insert((*name).to_owned(), row.clone());
            continue;
        };
        let (first, between) = if names.len() == 3 { (0, "") } else { (i, "_") };
        let entries = row.iter().zip(names).skip(first).filter(|(value, _)| !value.is_null());
        named.extend(entries.map(|(value, other)| (format!("{name}{between}{other}"), value.clone())));
    }
    Value::Object(named)
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
