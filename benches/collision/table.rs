//! Results: CSV and SVG files beside the benches.

use std::path::PathBuf;

pub(crate) fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../benches/results")
}

/// Writes a file under `benches/results/`.
pub(crate) fn save(name: &str, text: &str) {
    std::fs::create_dir_all(folder())
        .and_then(|()| std::fs::write(folder().join(name), text))
        .expect("benches/results can be written");
}

/// Rows of a CSV file.
pub(crate) struct Table(String);

impl Table {
    pub(crate) fn new(header: &str) -> Self {
        Self(format!("{header}\n"))
    }

    pub(crate) fn row(&mut self, cells: &[String]) {
        self.0 += &cells.join(",");
        self.0.push('\n');
    }

    pub(crate) fn save(&self, name: &str) {
        save(name, &self.0);
    }
}
