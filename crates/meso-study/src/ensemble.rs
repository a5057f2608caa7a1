//! Ensemble statistics of repetitions: mean and scatter of every figure, and how many are needed to know the mean.
//!
//! The mean is *known to 1 %* where the half-width of its 95 % confidence interval, `t s / sqrt(n)` with Student's t of
//! n - 1 degrees of freedom, is at most 1 % of it. `s` is the sample's standard deviation.

use crate::student::quantile_975;
use crate::table::{Column, Table, Values};
use serde_json::Value;
use std::collections::BTreeMap;

/// The axis whose cases are repetitions, unless another one is named.
pub const REPLICATE: &str = "seed";
/// Share of the mean to which it is to be known.
const KNOWN: f64 = 0.01;
/// More repetitions than anybody runs.
const MOST: u64 = 1_000_000_000;

/// One row for each combination of the other axes' values and each figure: `figure`, `n`, `mean`, `std`, `cv`, the `low` and
/// `high` end of the mean's 95 % confidence interval, and `needed`, the repetitions until the mean is known to 1 %.
///
/// `table` is as [`tabulate`](crate::tabulate) makes it, of axes `keys`; cases that failed have no figures.
pub fn ensemble(table: &Table, keys: &[String], replicate: &str) -> Table {
    let others: Vec<&Column> =
        keys.iter().filter(|key| *key != replicate).filter_map(|key| table.column(key)).collect();
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
            let sample: Vec<f64> = group.iter().filter_map(|row| numbers[*row]).collect();
            rows.push((group[0], *name, Figure::of(&sample)));
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

/// Mean and scatter of a sample.
struct Figure {
    n: u64,
    mean: Option<f64>,
    std: Option<f64>,
}

impl Figure {
    fn of(sample: &[f64]) -> Self {
        let n = sample.len();
        let mean = (n > 0).then(|| sample.iter().sum::<f64>() / n as f64);
        let squares = mean.map(|mean| sample.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>());
        let std = squares.filter(|_| n > 1).map(|squares| (squares / (n - 1) as f64).sqrt());
        Self { n: n as u64, mean, std }
    }

    /// Standard deviation over the mean.
    fn cv(&self) -> Option<f64> {
        Some(self.std? / self.mean?.abs()).filter(|cv| cv.is_finite())
    }

    /// Half of the mean's 95 % confidence interval.
    fn half_width(&self) -> Option<f64> {
        Some(quantile_975(self.n.checked_sub(1).filter(|degrees| *degrees > 0)?) * self.std? / (self.n as f64).sqrt())
    }

    /// The smallest number of repetitions of this scatter whose mean is known.
    fn needed(&self) -> Option<i128> {
        let cv = self.cv()?;
        let is_known = |n: u64| quantile_975(n - 1) * cv <= KNOWN * (n as f64).sqrt();
        // The interval narrows with n, so that halving finds the first.
        let (mut low, mut high) = (2, MOST);
        if !is_known(high) {
            return None;
        }
        while low < high {
            let middle = low + (high - low) / 2;
            (low, high) = if is_known(middle) { (low, middle) } else { (middle + 1, high) };
        }
        Some(low.into())
    }
}
