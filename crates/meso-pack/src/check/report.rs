//! Agreement of the report with the spec and the bodies: it is written again from them, and every key compared.

use super::Finding;
use super::taken::{Taken, was_stopped};
use crate::model::{Model, target};
use crate::saved::VERSION;
use meso_place::{Report, StopReason};
use serde_json::Value;

/// Sums over bodies are right to this share, as their order is the file's; every other figure is exact.
const SUMMED: f64 = 1e-12;

/// Finds every figure that differs from the report of a run that took these grains.
pub(super) fn check(model: &Model, taken: Option<&Taken>) -> Vec<Finding> {
    let report = &model.report;
    if !report.is_recorded() {
        return vec![wrong("the file has no report, so target and result are unknown".to_owned())];
    }
    let mut reasons = Vec::new();
    if !is_known(&report.version) {
        reasons.push(format!("its version is {}; this is {VERSION}", report.version));
    }
    if let Some(taken) = taken {
        let right = expected(model, taken);
        differences("", &plain(report), &plain(&right), &mut reasons);
        reasons.extend(stopped(model, taken, &right));
    }
    reasons.into_iter().map(wrong).collect()
}

pub(super) fn wrong(reason: String) -> Finding {
    Finding::Report { reason }
}

/// The report as it must be. Figures that depend on the clock, or count work, are taken from the file.
fn expected(model: &Model, Taken { tally, outcome }: &Taken) -> Report {
    let said = &model.report;
    let bodies = (&model.aggregates[..], &model.inclusions[..]);
    let right = meso_place::report(&target(&model.spec), tally, outcome, bodies, said.seconds);
    let right = Report { version: said.version.clone(), work: said.work, ..right };
    if !was_stopped(model) {
        return right;
    }
    let (strategy, stop_detail) = (said.strategy.clone(), said.stop_detail.clone());
    Report { strategy, stop_detail, discarded: said.discarded, ..right }
}

/// Checks the report of a run that was stopped.
fn stopped(model: &Model, taken: &Taken, right: &Report) -> Vec<String> {
    let said = &model.report;
    if !was_stopped(model) {
        return Vec::new();
    }
    let mut reasons = Vec::new();
    let most = taken.tally.aggregates - model.aggregates.len();
    if said.discarded > most {
        reasons.push(format!("discarded is {}; the spec leaves at most {most}", said.discarded));
    }
    if said.stop_reason == StopReason::TimeLimit && model.spec.placement.time_limit_s.is_none() {
        reasons.push("stop_reason is time-limit; the spec has none".to_owned());
    }
    if !["rearrange", "take-and-place"].contains(&said.strategy.as_str()) {
        reasons.push(format!("strategy is {:?}; there is none of that name", said.strategy));
    }
    let reached = format!("reached {:.5} of ", right.fraction);
    if !said.stop_detail.starts_with(&reached) {
        reasons.push(format!("stop_detail is {:?}; it begins with {reached:?}", said.stop_detail));
    }
    reasons
}

/// True for versions that have been.
fn is_known(version: &str) -> bool {
    let numbers = |version: &str| version.split('.').map(|part| part.parse::<u32>().ok()).collect::<Option<Vec<_>>>();
    numbers(version).is_some_and(|found| found.len() == 3 && found >= vec![0, 1, 0] && Some(found) <= numbers(VERSION))
}

pub(super) fn plain(report: &Report) -> Value {
    serde_json::to_value(report).expect("the keys of a report are strings")
}

/// Names every leaf of the trees that differs.
pub(super) fn differences(path: &str, said: &Value, right: &Value, reasons: &mut Vec<String>) {
    match (said, right) {
        (Value::Object(a), Value::Object(b)) if a.keys().eq(b.keys()) => {
            let dot = if path.is_empty() { "" } else { "." };
            a.iter().zip(b.values()).for_each(|((key, a), b)| differences(&format!("{path}{dot}{key}"), a, b, reasons));
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            (0..).zip(a.iter().zip(b)).for_each(|(i, (a, b)): (usize, _)| {
                differences(&format!("{path}[{i}]"), a, b, reasons);
            });
        }
        _ if said == right || is_summed(path) && agree(said, right) => {}
        _ => reasons.push(format!("{path} is {said}; the file's bodies and spec give {right}")),
    }
}

/// Whether the figure at `path` is a sum over bodies.
fn is_summed(path: &str) -> bool {
    path == "fraction" || path.ends_with("].fraction") || path.starts_with("phases[") && path.ends_with("].volume_mm3")
}

fn agree(said: &Value, right: &Value) -> bool {
    let as_float = |value: &Value| value.as_f64().filter(|_| value.is_f64());
    as_float(said).zip(as_float(right)).is_some_and(|(a, b)| (a - b).abs() <= SUMMED * b.abs())
}
