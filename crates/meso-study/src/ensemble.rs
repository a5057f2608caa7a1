//! Ensemble statistics of repetitions: mean and scatter of every figure, and how many are needed to know the mean.
//!
//! The mean is *known to 1 %* where the half-width of its 95 % confidence interval, `t s / sqrt(n)` with Student's t of
//! n - 1 degrees of freedom, is at most 1 % of it. `s` is the sample's standard deviation. Where packings and fields of
//! strengths have seeds of their own, [`Figure`] has what each of them scatters.

use crate::repetitions::Figure;
use crate::table::{Column, Table, Values};
use serde_json::Value;
use std::collections::BTreeMap;

/// The axis whose cases are repetitions, unless another one is named.
pub const REPLICATE: &str = "seed";
/// Ending of the axis with the seeds of strengths that scatter: its cases are repetitions beside those of [`REPLICATE`].
const MATERIAL: &str = "materials.scatter.seed";

/// One row for each combination of the other axes' values and each figure: `figure`, `n`, `mean`, `std`, `cv`, the `low` and
/// `high` end of the mean's 95 % confidence interval, and `needed`, the repetitions until the mean is known to 1 %: those of
/// packings, unless a field of strengths has seeds, too.
///
/// Where the seeds of strengths that scatter are an axis, too, the scatter from packings and from materials follow, each with
/// its standard error.
///
/// `table` is as [`tabulate`](crate::tabulate) makes it, of axes `keys`; cases that failed have no figures.
pub fn ensemble(table: &Table, keys: &[String], replicate: &str) -> Table {
    let material = keys.iter().find(|key| replicate == REPLICATE && key.ends_with(MATERIAL));
    let is_repeated = |key: &String| key == replicate || Some(key) == material;
    let others: Vec<&Column> =
        keys.iter().filter(|key| !is_repeated(key)).filter_map(|key| table.column(key)).collect();
    // The place of every row's packing and material among all.
    let places = |key: Option<&str>| {
        let mut places = vec![0; table.rows()];
        let column: Vec<&Column> = key.and_then(|key| table.column(key)).into_iter().collect();
        let each = groups(&column, table.rows());
        each.iter().enumerate().for_each(|(place, rows)| rows.iter().for_each(|row| places[*row] = place));
        places
    };
    let pairs = material.map(|material| [places(Some(replicate)), places(Some(material))]);
    let is_axis = |name: &str| keys.iter().any(|key| key == name);
    let figures: Vec<(&str, Vec<Option<f64>>)> = table
        .columns
        .iter()
        .filter(|column| !is_axis(&column.name))
        .filter_map(|column| Some((column.name.as_str(), column.values.numbers()?)))
        .collect();
    let mut rows = Vec::new();
    for group in groups(&others, table.rows()) {
        for (name, numbers) in &figures {
            let figure = match &pairs {
                None => Figure::of(&group.iter().filter_map(|row| numbers[*row]).collect::<Vec<f64>>()),
                Some([packing, material]) => {
                    let own = |row: &usize| numbers[*row].map(|number| (packing[*row], material[*row], number));
                    Figure::of_pairs(&group.iter().filter_map(own).collect::<Vec<_>>())
                }
            };
            rows.push((group[0], *name, figure));
        }
    }
    let first: Vec<usize> = rows.iter().map(|row| row.0).collect();
    let mut columns: Vec<Column> = others.iter().map(|column| pick(column, &first)).collect();
    let number = |name: &str, of: fn(&Figure) -> Option<f64>| Column {
        name: name.to_owned(),
        values: Values::Float(rows.iter().map(|row| of(&row.2)).collect()),
    };
    let whole = |name: &str, of: fn(&Figure) -> Option<i128>| Column {
        name: name.to_owned(),
        values: Values::Integer(rows.iter().map(|row| of(&row.2)).collect()),
    };
    let names = rows.iter().map(|row| Some(row.1.to_owned())).collect();
    columns.extend([
        Column { name: "figure".to_owned(), values: Values::Text(names) },
        whole("n", |figure| Some(figure.n.into())),
        number("mean", |figure| figure.mean),
        number("std", |figure| figure.std),
        number("cv", Figure::cv),
        number("low", |figure| Some(figure.mean? - figure.half_width()?)),
        number("high", |figure| Some(figure.mean? + figure.half_width()?)),
        whole("needed", Figure::needed),
    ]);
    if material.is_some() {
        columns.extend([
            number("std_packing", |figure| Some(figure.parts[0]?[0])),
            number("std_packing_error", |figure| Some(figure.parts[0]?[1])),
            number("std_material", |figure| Some(figure.parts[1]?[0])),
            number("std_material_error", |figure| Some(figure.parts[1]?[1])),
        ]);
    }
    Table { columns }
}

/// The rows with equal values in all `columns`, in the order of each group's first row.
fn groups(columns: &[&Column], rows: usize) -> Vec<Vec<usize>> {
    let mut found: Vec<Vec<usize>> = Vec::new();
    let mut place: BTreeMap<String, usize> = BTreeMap::new();
    for row in 0..rows {
        let values = Value::Array(columns.iter().map(|column| column.values.json(row)).collect());
        let group = *place.entry(values.to_string()).or_insert(found.len());
        if group == found.len() {
            found.push(Vec::new());
        }
        found[group].push(row);
    }
    found
}

fn pick(column: &Column, rows: &[usize]) -> Column {
    fn of<T: Clone>(values: &[T], rows: &[usize]) -> Vec<T> {
        rows.iter().map(|row| values[*row].clone()).collect()
    }
    let values = match &column.values {
        Values::Bool(values) => Values::Bool(of(values, rows)),
        Values::Integer(values) => Values::Integer(of(values, rows)),
        Values::Float(values) => Values::Float(of(values, rows)),
        Values::Text(values) => Values::Text(of(values, rows)),
    };
    Column { name: column.name.clone(), values }
}
