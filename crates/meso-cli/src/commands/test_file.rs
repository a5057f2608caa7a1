//! A TEST.toml, with the tables that lie beside it.

use crate::failure::Failure;
use crate::inputs;
use clap::builder::TypedValueParser;
use clap::{Arg, Command};
use meso_core::spec::options_from_toml;
use meso_files::Beside;
use meso_solve::Test;
use serde_json::Value;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Whether a file is described by its ending: a spec, or a test.
pub(super) fn is_toml(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// The test of a TEST.toml.
pub(super) fn read(path: &Path) -> Result<Test, Failure> {
    with_tables(inputs::toml(path, options_from_toml)?, path)
}

/// The test of the file at `path`, with its tables, which lie beside it.
fn with_tables(mut test: Test, path: &Path) -> Result<Test, Failure> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let taken = test.take_tables(|name| Beside(folder).text(name));
    taken.map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))?;
    Ok(test)
}

/// The test of a TEST.toml for a deck, whose plates keep their speed.
pub(super) fn of_deck(path: &Path) -> Result<Test, Failure> {
    let both = |text: &str| Ok((options_from_toml::<Value>(text)?, options_from_toml::<Test>(text)?));
    let (tree, test) = inputs::toml(path, both)?;
    if tree.get("control").is_some_and(|control| control == "servo") {
        let why = "a deck's plates keep their speed; take \"steady\", or leave it out";
        return Err(Failure::Usage(format!("{}: test.control is servo; {why}", path.display())));
    }
    with_tables(test, path)
}

/// Replaces the names of tables in the tree of the TEST.toml at `path` by their turns and courses.
pub(super) fn take_tables(tree: &mut Value, path: &Path) -> Result<(), Failure> {
    let test: Test = inputs::toml(path, options_from_toml)?;
    if test.tables().is_empty() {
        return Ok(());
    }
    let Test { turns, expansion, .. } = with_tables(test, path)?;
    let value = |taken: serde_json::Result<Value>| taken.map_err(|error| Failure::Run(error.to_string()));
    if let Value::Object(keys) = tree {
        if keys.remove("history").is_some() {
            keys.insert("turns".to_owned(), value(serde_json::to_value(turns))?);
        }
        if let Some(own) = keys.get_mut("expansion") {
            *own = value(serde_json::to_value(expansion))?;
        }
    }
    Ok(())
}

/// Tables that the TEST.toml at `path` names; they lie beside it.
pub(super) fn tables(path: &Path) -> Result<Vec<String>, Failure> {
    Ok(inputs::toml::<Test>(path, options_from_toml)?.tables())
}

/// Parser of a TOML file, which its ending gives away, or of a name.
#[derive(Clone)]
pub(super) struct FileOr<T, P> {
    pub(super) file: fn(PathBuf) -> T,
    pub(super) name: P,
}

impl<T: Clone + Send + Sync + 'static, P: TypedValueParser<Value = T>> TypedValueParser for FileOr<T, P> {
    type Value = T;

    fn parse_ref(&self, command: &Command, arg: Option<&Arg>, value: &OsStr) -> Result<T, clap::Error> {
        let path = Path::new(value);
        if is_toml(path) { Ok((self.file)(path.to_owned())) } else { self.name.parse_ref(command, arg, value) }
    }
}
