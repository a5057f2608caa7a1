//! Results: CSV and SVG files beside the benches, each with its machine, date and commit.

#[path = "origin.rs"]
mod origin;

use std::path::PathBuf;

/// True with `--quick`: small cases that show that the bench runs, and results in the temporary folder alone.
pub(crate) fn quick() -> bool {
    std::env::args().any(|argument| argument == "--quick")
}

/// The number of things to measure: all, or few with `--quick`.
#[allow(dead_code, reason = "each bench uses its part")]
pub(crate) fn count(all: usize, few: usize) -> usize {
    if quick() { few } else { all }
}

pub(crate) fn folder() -> PathBuf {
    if quick() {
        return std::env::temp_dir().join("mesocrete-quick-benches");
    }
    // Of a bench of `crates/`, or of this folder's own package.
    let package = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    if package.ends_with("benches") { package.join("results") } else { package.join("../../benches/results") }
}

/// Writes a file under `benches/results/`; pictures get their origin as a comment.
pub(crate) fn save(name: &str, text: &str) {
    let origin = if name.ends_with(".svg") { format!("<!-- {} -->\n", origin::stamp()) } else { String::new() };
    std::fs::create_dir_all(folder())
        .and_then(|()| std::fs::write(folder().join(name), format!("{text}{origin}")))
        .expect("benches/results can be written");
}

/// Rows of a CSV file, whose last columns are machine, date and commit.
pub(crate) struct Table {
    text: String,
    stamp: String,
}

#[allow(dead_code, reason = "each bench uses its part")]
impl Table {
    pub(crate) fn new(header: &str) -> Self {
        Self { text: format!("{}\n", Self::header(header)), stamp: origin::stamp() }
    }

    /// The file's first line.
    pub(crate) fn header(header: &str) -> String {
        format!("{header},{}", origin::COLUMNS)
    }

    /// A row that was measured now.
    pub(crate) fn row(&mut self, cells: &[String]) {
        let row = self.stamped(&cells.join(","));
        self.keep(&row);
    }

    /// A row with the last columns.
    pub(crate) fn stamped(&self, row: &str) -> String {
        format!("{row},{}", self.stamp)
    }

    /// A row that has the last columns already.
    pub(crate) fn keep(&mut self, row: &str) {
        self.text += row;
        self.text.push('\n');
    }

    pub(crate) fn save(&self, name: &str) {
        save(name, &self.text);
    }
}
