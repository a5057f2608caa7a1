//! Axes of several options at once: lists that run side by side, and random draws.
//!
//! A draw depends on its seed, its option and its number alone. So a longer random study keeps the cases of a shorter one,
//! and a further option changes no other. A Latin hypercube [1] divides each range into as many strata as there are cases,
//! and takes one value from each. A nested one keeps the cases of a shorter one: each doubling of the cases halves the strata
//! and takes one value from each half that is empty.
//!
//! [1] M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21 (2), 1979, 239-245.

use crate::case::digest;
use crate::plan::{Axis, MOST_CASES, PlanError};
use meso_concrete::aggregate::random::{Draw, Stream};
use serde::Deserialize;
use serde_json::{Map, Value};

/// Option that numbers the cases of a draw, unless it is an axis itself.
const SEED: &str = "seed";

/// How values are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Design {
    /// Each value alone, uniform over its range.
    #[default]
    Random,
    /// One value from each of as many strata as there are cases, in random order.
    LatinHypercube,
    /// A Latin hypercube of every power of two of cases, which keeps the cases of a shorter one.
    NestedHypercube,
}

/// A table `[draw]` of a study.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sampling {
    /// Number of cases.
    pub cases: usize,
    /// How values are drawn.
    #[serde(default)]
    pub design: Design,
    /// Seed of the draws, not of the packings.
    #[serde(default)]
    pub seed: u64,
    /// From an option's dotted key to its range `{ low, high }` or the list of its values; nested tables are parts of a key.
    #[serde(default)]
    pub over: Map<String, Value>,
}

/// Values of one option.
enum Law<'a> {
    Real { low: f64, high: f64 },
    Whole { low: i64, high: i64 },
    Choice(&'a [Value]),
}

impl Axis {
    /// Lists of equal length whose values change together.
    ///
    /// # Errors
    /// [`PlanError::Uneven`] for lists of different lengths.
    pub fn zipped(lists: Vec<(String, Vec<Value>)>) -> Result<Self, PlanError> {
        let count = lists.first().map_or(0, |(_, values)| values.len());
        if let Some((key, values)) = lists.iter().find(|(_, values)| values.len() != count) {
            return Err(PlanError::Uneven(lists[0].0.clone(), count, key.clone(), values.len()));
        }
        let rows = (0..count).map(|row| lists.iter().map(|(_, values)| values[row].clone()).collect()).collect();
        Ok(Self { keys: lists.into_iter().map(|(key, _)| key).collect(), rows, specs: Vec::new() })
    }

    /// The cases of a draw; each has a seed of its own, counted from 0, unless `seed` is one of the options or of `taken`.
    ///
    /// # Errors
    /// [`PlanError::Range`] for a range that is none, [`PlanError::NoCases`] and [`PlanError::TooMany`].
    pub fn drawn(draw: &Sampling, taken: &[Axis]) -> Result<Self, PlanError> {
        match draw.cases {
            0 => return Err(PlanError::NoCases),
            1..=MOST_CASES => (),
            _ => return Err(PlanError::TooMany(draw.cases)),
        }
        let mut lists = Vec::new();
        for (key, value) in leaves("", &draw.over) {
            let law = Law::of(value).ok_or_else(|| PlanError::Range(key.clone(), value.to_string()))?;
            let values = shares(draw, &key).into_iter().map(|share| law.at(share)).collect();
            lists.push((key, values));
        }
        let is_seed = |key: &String| key == SEED;
        if !lists.iter().map(|(key, _)| key).chain(taken.iter().flat_map(|axis| &axis.keys)).any(is_seed) {
            lists.push((SEED.to_owned(), (0..draw.cases).map(Value::from).collect()));
        }
        Self::zipped(lists)
    }
}

/// The options of nested tables by their dotted keys; a list and a table with `low` are values.
fn leaves<'a>(prefix: &str, table: &'a Map<String, Value>) -> Vec<(String, &'a Value)> {
    let mut found = Vec::new();
    for (name, value) in table {
        let key = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
        match value {
            Value::Object(inner) if !inner.contains_key("low") => found.extend(leaves(&key, inner)),
            leaf => found.push((key, leaf)),
        }
    }
    found
}

/// Shares in [0, 1) of the range of option `key`, one per case.
fn shares(draw: &Sampling, key: &str) -> Vec<f64> {
    let number = u64::from_str_radix(&digest(key.as_bytes())[..10], 16).expect("hexadecimal digits");
    let mut stream = Stream::new(draw.seed, Draw::Sample, 0, number);
    let single: Vec<f64> = (0..draw.cases).map(|_| stream.unit()).collect();
    match draw.design {
        Design::Random => single,
        Design::NestedHypercube => nested(&single, |level| Stream::new(draw.seed, Draw::Sample, level, number)),
        Design::LatinHypercube => {
            let mut strata: Vec<usize> = (0..draw.cases).collect();
            shuffle(&mut strata, &mut stream);
            let within = |(stratum, share): (usize, f64)| (stratum as f64 + share) / draw.cases as f64;
            strata.into_iter().zip(single).map(within).collect()
        }
    }
}

/// Mixes by Fisher and Yates.
fn shuffle(strata: &mut [usize], stream: &mut Stream) {
    for last in (1..strata.len()).rev() {
        strata.swap(last, (stream.unit() * (last + 1) as f64) as usize);
    }
}

/// Shares of a nested hypercube; each level of strata has a stream of its own, and `single` a share within each stratum.
fn nested(single: &[f64], stream: impl Fn(u16) -> Stream) -> Vec<f64> {
    // Rounding must not carry a share into the next stratum.
    let within =
        |stratum: usize, case: usize, strata: usize| (stratum as f64 + single[case].min(1.0 - 1e-9)) / strata as f64;
    let mut shares = vec![within(0, 0, 1)];
    for level in 1.. {
        if shares.len() >= single.len() {
            break;
        }
        let strata = 1_usize << level;
        let mut is_taken = vec![false; strata];
        shares.iter().for_each(|share| is_taken[(share * strata as f64) as usize] = true);
        let mut empty: Vec<usize> = (0..strata).filter(|stratum| !is_taken[*stratum]).collect();
        shuffle(&mut empty, &mut stream(level));
        let wanted = single.len() - shares.len();
        for stratum in empty.into_iter().take(wanted) {
            shares.push(within(stratum, shares.len(), strata));
        }
    }
    shares
}

impl<'a> Law<'a> {
    /// The law of a list or of a range; `None` for anything else.
    fn of(value: &'a Value) -> Option<Self> {
        let range = match value {
            Value::Array(values) => return (!values.is_empty()).then_some(Self::Choice(values)),
            Value::Object(range) if range.len() == 2 => range,
            _ => return None,
        };
        let (low, high) = (range.get("low")?, range.get("high")?);
        match (low.as_i64(), high.as_i64()) {
            (Some(low), Some(high)) => (low <= high).then_some(Self::Whole { low, high }),
            _ => {
                let (low, high) = (low.as_f64()?, high.as_f64()?);
                (low <= high && (high - low).is_finite()).then_some(Self::Real { low, high })
            }
        }
    }

    /// The value at a share in [0, 1) of the range.
    fn at(&self, share: f64) -> Value {
        match *self {
            Self::Real { low, high } => (low + (high - low) * share).into(),
            Self::Whole { low, high } => {
                let count = (i128::from(high) - i128::from(low) + 1) as f64;
                low.saturating_add((share * count) as i64).min(high).into()
            }
            Self::Choice(values) => values[((share * values.len() as f64) as usize).min(values.len() - 1)].clone(),
        }
    }
}
