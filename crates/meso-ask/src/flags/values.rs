//! Parsers of numbers on the command line; each names the accepted range.

use std::fmt::Display;
use std::str::FromStr;

/// A number; ranges are the spec's business.
pub fn number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| "it must be a number, with a point for the decimals".to_owned())
}

/// A time between two actions.
pub fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds| (0.0..=1e9).contains(seconds));
    seconds.ok_or_else(|| "it must be a number of seconds from 0 to 1e9".to_owned())
}

/// A seed.
pub fn seed(text: &str) -> Result<u64, String> {
    whole(text, 0, u64::MAX)
}

/// A number of things, at least one.
pub fn count(text: &str) -> Result<u32, String> {
    whole(text, 1, u32::MAX)
}

/// A number of packings, each of which is tested many times.
pub fn packings(text: &str) -> Result<u32, String> {
    whole(text, 1, 10_000)
}

/// A whole number; ranges are the options' business.
pub fn whole_number(text: &str) -> Result<u32, String> {
    text.parse().map_err(|_| "it must be a whole number, not below 0".to_owned())
}

/// A number of threads.
pub fn threads(text: &str) -> Result<u16, String> {
    whole(text, 1, 1024)
}

fn whole<T: FromStr + PartialOrd + Display + Copy>(text: &str, low: T, high: T) -> Result<T, String> {
    match text.parse() {
        Ok(value) if value >= low && value <= high => Ok(value),
        _ => Err(format!("it must be a whole number from {low} to {high}")),
    }
}
