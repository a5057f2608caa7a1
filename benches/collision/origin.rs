//! Where and when a figure was measured, and of which commit.

use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

/// The columns that every table ends with.
pub(crate) const COLUMNS: &str = "machine,date,commit";

/// Their values for this run.
pub(crate) fn stamp() -> String {
    format!("{},{},{}", machine(), date(), commit())
}

fn machine() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let of = |key: &str| text.lines().find(|line| line.starts_with(key)).and_then(|line| line.split_once(": "));
    let [name, family, model] =
        ["model name", "cpu family", "model\t"].map(|key| of(key).map_or("unknown", |(_, value)| value.trim()));
    let threads = std::thread::available_parallelism().map_or(0, usize::from);
    format!("{} family {family} model {model} {threads} threads", name.replace(',', " "))
}

fn commit() -> String {
    let git = |args: &[&str]| Command::new("git").args(args).output().ok().map(|output| output.stdout);
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).trim().to_owned();
    match git(&["rev-parse", "--short", "HEAD"]).map(text) {
        Some(commit) if !commit.is_empty() => commit,
        _ => "unknown".into(),
    }
}

/// Today, UTC: days since 1970 to a date, after Howard Hinnant's `civil_from_days`.
fn date() -> String {
    let days = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_secs() / 86_400);
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
    let month = if shifted_month < 10 { shifted_month + 3 } else { shifted_month - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    format!("{year}-{month:02}-{day:02}")
}
