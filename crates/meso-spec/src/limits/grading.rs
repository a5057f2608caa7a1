//! Sizes, curves and classes that cannot be.

use super::{Checked, MAX_LENGTH_MM, within};
use crate::SpecError;
use crate::messages::number;
use meso_concrete::aggregate::{Curve, Grading};

/// Checks a grading whose sizes are at least this long.
pub(super) fn grading(grading: &Grading, least_mm: f64) -> Checked {
    size("grading.d_min_mm", grading.d_min_mm, least_mm)?;
    size("grading.d_max_mm", grading.d_max_mm, least_mm)?;
    let (low, high) = (number(grading.d_min_mm), number(grading.d_max_mm));
    if grading.d_min_mm >= grading.d_max_mm {
        let message = format!("is {low} but d_max_mm is {high}; the smallest size must be below the largest");
        return Err(SpecError::value("grading.d_min_mm", message));
    }
    curve(grading, least_mm)?;
    classes(&grading.classes_mm, [grading.d_min_mm, grading.d_max_mm], least_mm)
}

fn size(key: &str, mm: f64, least_mm: f64) -> Checked {
    within(key, mm, least_mm, MAX_LENGTH_MM)
}

fn curve(grading: &Grading, least_mm: f64) -> Checked {
    match &grading.curve {
        Curve::Fuller { exponent } => return within("grading.curve.exponent", *exponent, 0.01, 10.0),
        Curve::Bolomey { a } => return within("grading.curve.a", *a, 0.0, 0.5),
        Curve::Sieves { sieves_mm, passing } => sieve_table(sieves_mm, passing, least_mm)?,
        Curve::Standard { .. } => {}
    }
    covered(grading, &grading.curve.sieves().unwrap_or_default())
}

/// Sieves ascend, shares do not fall, and there are as many of the ones as of the others.
fn sieve_table(sieves: &[f64], passing: &[f64], least_mm: f64) -> Checked {
    const SIEVES: &str = "grading.curve.sieves_mm";
    const PASSING: &str = "grading.curve.passing";
    if sieves.len() < 2 || sieves.len() > 1000 {
        return Err(SpecError::value(SIEVES, format!("has {} sieves; it takes 2 to 1000", sieves.len())));
    }
    if sieves.len() != passing.len() {
        let message = format!("has {} shares for {} sieves; give one for each", passing.len(), sieves.len());
        return Err(SpecError::value(PASSING, message));
    }
    sieves.iter().try_for_each(|&sieve| size(SIEVES, sieve, least_mm))?;
    ascending(SIEVES, "sieves", sieves)?;
    if let Some(share) = passing.iter().find(|share| **share > 1.0) {
        let message = format!("has {}; shares are from 0 to 1: for 100 % write 1", number(*share));
        return Err(SpecError::value(PASSING, message));
    }
    passing.iter().try_for_each(|&share| within(PASSING, share, 0.0, 1.0))?;
    match passing.windows(2).find(|pair| pair[0] > pair[1]) {
        Some(pair) => {
            let message = format!("falls from {} to {}; more passes a wider sieve", number(pair[0]), number(pair[1]));
            Err(SpecError::value(PASSING, message))
        }
        None => Ok(()),
    }
}

/// A table has no data outside its sieves, nor where no volume lies.
fn covered(grading: &Grading, sieves: &[f64]) -> Checked {
    let (first, last) = (sieves[0], sieves[sieves.len() - 1]);
    for (key, size) in [("grading.d_min_mm", grading.d_min_mm), ("grading.d_max_mm", grading.d_max_mm)] {
        if size < first || size > last {
            let [size, first, last] = [size, first, last].map(number);
            let message = format!("is {size} but the curve's sieves go from {first} to {last} mm; stay within them");
            return Err(SpecError::value(key, message));
        }
    }
    let shares = [grading.d_min_mm, grading.d_max_mm].map(|d| grading.curve.passing(d, grading.d_max_mm));
    if shares[0] >= shares[1] {
        let message = format!("has no volume between {} and {} mm", number(grading.d_min_mm), number(grading.d_max_mm));
        return Err(SpecError::value("grading.curve", message));
    }
    Ok(())
}

/// The class limits ascend strictly from the smallest size to the largest.
fn classes(limits: &[f64], range: [f64; 2], least_mm: f64) -> Checked {
    const KEY: &str = "grading.classes_mm";
    if limits.len() < 2 || limits.len() > 1000 {
        return Err(SpecError::value(KEY, format!("has {} limits; it takes 2 to 1000", limits.len())));
    }
    limits.iter().try_for_each(|&limit| size(KEY, limit, least_mm))?;
    ascending(KEY, "limits", limits)?;
    let ends = [limits[0], limits[limits.len() - 1]];
    if ends != range {
        let [first, last] = ends.map(number);
        let [low, high] = range.map(number);
        let message = format!(
            "goes from {first} to {last} but the sizes from {low} to {high}; it must begin at d_min_mm and end at d_max_mm"
        );
        return Err(SpecError::value(KEY, message));
    }
    Ok(())
}

pub(super) fn ascending(key: &str, what: &str, values: &[f64]) -> Checked {
    match values.windows(2).find(|pair| pair[0] >= pair[1]) {
        Some(pair) => {
            let message = format!("has {} before {}; the {what} must ascend", number(pair[0]), number(pair[1]));
            Err(SpecError::value(key, message))
        }
        None => Ok(()),
    }
}
