//! The file names of one case: each is used once, on every file system.
//!
//! Steps of a case write into one folder. A name that two of them use would be overwritten or, among the numbered frames of
//! a test, deleted as stale. Names count without case, as on Windows and macOS.

use meso_files::whole::UNFINISHED;
use std::collections::BTreeMap;

/// Longest name, bytes: file systems take 255, and temporary names are longer than the final ones.
const LONGEST: usize = 200;
/// Characters that Windows refuses in a name, or reads as a path or a stream.
const FOREIGN: [char; 9] = ['/', '\\', ':', '*', '?', '"', '<', '>', '|'];

/// Names claimed so far, each with its owner, e.g. `outputs` or `[solve]`.
#[derive(Clone, Debug, Default)]
pub struct Names {
    single: BTreeMap<String, String>,
    /// Owner of the numbered names between a prefix and a suffix.
    series: BTreeMap<(String, String), String>,
}

/// A name that a step cannot use.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// Not the bare name of a file.
    #[error("{owner} has {name:?}; it must be the name of a file in the case's folder: no path, none of {}, at most {LONGEST} bytes", FOREIGN.iter().collect::<String>())]
    Form {
        /// The step that uses the name.
        owner: String,
        /// The name.
        name: String,
    },
    /// Used already.
    #[error("{owner} has {name:?}, which {other} writes, too; give each file its own name (capitals do not count)")]
    Taken {
        /// The step that uses the name.
        owner: String,
        /// The name.
        name: String,
        /// The step that used it before.
        other: String,
    },
}

impl Names {
    /// Gives `name` to `owner`.
    ///
    /// # Errors
    /// [`NameError`] for a name that is not a bare file name, or that another step uses.
    pub fn claim(&mut self, owner: &str, name: &str) -> Result<(), NameError> {
        if !is_plain(name) {
            return Err(NameError::Form { owner: owner.to_owned(), name: name.to_owned() });
        }
        let folded = name.to_lowercase();
        let in_series = || self.series.iter().find(|((prefix, suffix), _)| is_numbered(&folded, prefix, suffix));
        if let Some(other) = self.single.get(&folded).or_else(|| Some(in_series()?.1)) {
            return Err(taken(owner, name, other));
        }
        self.single.insert(folded, owner.to_owned());
        Ok(())
    }

    /// Gives all names of `prefix`, a whole number and `suffix` to `owner`, e.g. `frame_0001.vtu`.
    ///
    /// # Errors
    /// [`NameError::Taken`] where another step uses one of them.
    pub fn claim_series(&mut self, owner: &str, prefix: &str, suffix: &str) -> Result<(), NameError> {
        let key = (prefix.to_lowercase(), suffix.to_lowercase());
        let inside = self.single.iter().find(|(name, _)| is_numbered(name, &key.0, &key.1));
        if let Some((name, other)) = inside {
            return Err(taken(owner, name, other));
        }
        match self.series.insert(key, owner.to_owned()) {
            Some(other) => Err(taken(owner, &format!("{prefix}0{suffix}"), &other)),
            None => Ok(()),
        }
    }
}

fn taken(owner: &str, name: &str, other: &str) -> NameError {
    NameError::Taken { owner: owner.to_owned(), name: name.to_owned(), other: other.to_owned() }
}

/// Whether `name` is a file's bare name, and not one of our temporary files.
fn is_plain(name: &str) -> bool {
    let is_path = ["", ".", ".."].contains(&name) || name.chars().any(|c| c.is_control() || FOREIGN.contains(&c));
    // Windows drops these from the end.
    let is_cut = name.ends_with(['.', ' ']);
    !is_path && !is_cut && name.len() <= LONGEST && !name.to_lowercase().starts_with(UNFINISHED.0)
}

fn is_numbered(name: &str, prefix: &str, suffix: &str) -> bool {
    let number = name.strip_prefix(prefix).and_then(|rest| rest.strip_suffix(suffix));
    // Rust reads "+5" as a number, too.
    let digits = number.map(|number| number.strip_prefix('+').unwrap_or(number));
    digits.is_some_and(|digits| !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit()))
}
