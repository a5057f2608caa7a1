//! Promises for any text of a STUDY.toml: it is refused with a message, or planned, and nothing panics.

use std::collections::BTreeSet;
use std::path::Path;

/// The files of every case lie in its own folder, each under a name of its own.
pub(crate) fn study(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let cases = match meso_cli::validate_study(text) {
        Ok(cases) => cases,
        Err(message) => {
            assert!(!message.trim().is_empty());
            assert!(!message.contains("mistake in mesocrete"), "{message}");
            return;
        }
    };
    let mut folders = BTreeSet::new();
    for files in cases.iter().filter(|files| !files.is_empty()) {
        let folder = files[0].parent().expect("a folder");
        assert!(folder.components().count() == 1 && folders.insert(folder), "{folder:?}");
        let names: BTreeSet<String> = files.iter().map(|file| name(file)).collect();
        assert_eq!(names.len(), files.len(), "{files:?}");
        assert!(files.iter().all(|file| file.parent() == Some(folder)), "{files:?}");
    }
}

/// A name as file systems without case see it.
fn name(file: &Path) -> String {
    file.file_name().expect("a name").to_string_lossy().to_lowercase()
}
