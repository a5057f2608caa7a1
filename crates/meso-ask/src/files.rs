//! Files that an option names: materials, tests and the tables beside them. The front reads them.

use crate::AskError;
use meso_core::SpecError;
use meso_core::materials::Materials;
use meso_core::spec::options_from_toml;
use meso_core::trial::Test;
use serde_json::Value;
use std::path::Path;

/// Reads the text of a file.
pub type Reader<'a> = dyn Fn(&Path) -> Result<String, AskError> + 'a;

/// Whether the value of an option is a file: a spec, or a test.
pub fn is_toml(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// Reads a TOML file by `parse`, whose errors are named with the file.
///
/// # Errors
/// Those of `read` and of `parse`.
pub fn toml<T>(
    path: &Path,
    read: &Reader<'_>,
    parse: impl FnOnce(&str) -> Result<T, SpecError>,
) -> Result<T, AskError> {
    parse(&read(path)?).map_err(|error| AskError::Usage(format!("{}: {error}", path.display())))
}

/// The materials of a file.
///
/// # Errors
/// A file that cannot be read, and unknown values.
pub fn materials(path: &Path, read: &Reader<'_>) -> Result<Materials, AskError> {
    toml(path, read, options_from_toml).map(|file: MaterialsFile| file.materials)
}

/// A file of material values.
#[derive(Default, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
struct MaterialsFile {
    materials: Materials,
}

/// The test of a TEST.toml, with the tables that lie beside it.
///
/// # Errors
/// A file that cannot be read, and unknown values.
pub fn test(path: &Path, read: &Reader<'_>) -> Result<Test, AskError> {
    let test = toml(path, read, options_from_toml)?;
    with_tables(test, path, read)
}

/// The tree of a TEST.toml, with turns, courses and speeds where it names tables.
///
/// # Errors
/// As [`test`].
pub fn test_tree(path: &Path, read: &Reader<'_>) -> Result<Value, AskError> {
    let mut tree: Value = toml(path, read, options_from_toml)?;
    let test: Test = toml(path, read, options_from_toml)?;
    if test.tables().is_empty() {
        return Ok(tree);
    }
    let Test { turns, expansion, supports, .. } = with_tables(test, path, read)?;
    let value = |taken: serde_json::Result<Value>| taken.map_err(|error| AskError::Run(error.to_string()));
    if let Value::Object(keys) = &mut tree {
        if keys.remove("history").is_some() {
            keys.insert("turns".to_owned(), value(serde_json::to_value(turns))?);
        }
        if let Some(own) = keys.get_mut("expansion") {
            *own = value(serde_json::to_value(expansion))?;
        }
        if let Some(own) = keys.get_mut("supports") {
            *own = value(serde_json::to_value(supports))?;
        }
    }
    Ok(tree)
}

/// Names of the tables that lie beside a TEST.toml.
///
/// # Errors
/// As [`test`].
pub fn tables(path: &Path, read: &Reader<'_>) -> Result<Vec<String>, AskError> {
    Ok(toml::<Test>(path, read, options_from_toml)?.tables())
}

fn with_tables(mut test: Test, path: &Path, read: &Reader<'_>) -> Result<Test, AskError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let taken = test.take_tables(|name| read(&folder.join(name)).map_err(|fault| fault.message().to_owned()));
    taken.map_err(|error| AskError::Usage(format!("{}: {error}", path.display())))?;
    Ok(test)
}
