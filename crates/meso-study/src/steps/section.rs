//! The options of a step, by the names that a user has for them: flags or keywords.

use meso_ask::flags::of_schema;
use meso_ask::{AskError, Given, Giver, Options, Over};
use meso_core::SpecError;
use meso_core::spec::options_from_value;
use meso_solve::Test;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

/// Options that the study sets itself.
const OWN: [&str; 7] = ["force", "quiet", "threads", "summary_json", "checkpoint", "resume", "help"];
/// Ending of the key with a file's hash.
const HASH: &str = "_sha256";

/// The options of a step that were not taken yet.
pub(super) struct Section<'a> {
    name: &'static str,
    /// Each with its name, as its user spells it.
    values: Vec<(String, Value)>,
    giver: Giver<'static>,
    /// Folder of the files that they name.
    folder: &'a Path,
}

impl<'a> Section<'a> {
    /// The options of the section `name` of a task, if it has this section.
    ///
    /// # Errors
    /// Options that are the study's, and the program gmsh, which no file may name.
    pub(super) fn of(
        task: &Value,
        name: &'static str,
        giver: Giver<'static>,
        folder: &'a Path,
    ) -> Result<Option<Self>, AskError> {
        let Some(options) = task.get(name).and_then(Value::as_object) else { return Ok(None) };
        let mut values: Vec<(String, Value)> = Vec::new();
        for (given, value) in options {
            let key = given.replace('-', "_");
            let wrong = |why: String| Err(AskError::Usage(format!("{} {why}", giver.option(&key))));
            if key == "gmsh" {
                let gmsh = Giver::Flags.option("gmsh");
                return wrong(format!("names a program, which no file may do; remove it, and give {gmsh} PROGRAM"));
            }
            if OWN.contains(&&*key) || (key == "output" && name != "mesh") {
                return wrong("is set by the study; remove it".to_owned());
            }
            if let Some(of) = of_packings(&key).filter(|_| name == "solve") {
                return wrong(format!("is of the packing, which the study makes; give {of}"));
            }
            if values.iter().any(|(other, _)| *other == key) {
                return wrong("is given twice; keep one of the two".to_owned());
            }
            if !key.ends_with(HASH) {
                values.push((key, value.clone()));
            }
        }
        Ok(Some(Self { name, values, giver, folder }))
    }

    /// Takes the options of one kind, whose keys `keys` lists.
    ///
    /// # Errors
    /// A value that its option cannot have, and an option that is given twice.
    pub(super) fn take<T: Options>(&mut self, keys: &[&str]) -> Result<Given<T>, AskError> {
        let mut given = Map::new();
        for (name, value) in std::mem::take(&mut self.values) {
            match T::key_of(&name, keys) {
                Some(key) if given.contains_key(key) => {
                    let option = self.giver.option(key);
                    return Err(AskError::Usage(format!("{option} is given twice; keep one of the two")));
                }
                Some(key) => drop(given.insert(key.to_owned(), value)),
                None => self.values.push((name, value)),
            }
        }
        Given::of(given, self.giver)
    }

    /// Takes the value of an option; a list of one value is this value.
    pub(super) fn value(&mut self, key: &str) -> Option<Value> {
        let place = self.values.iter().position(|(name, _)| name == key)?;
        match self.values.remove(place).1 {
            Value::Array(mut one) if one.len() == 1 => one.pop(),
            value => Some(value),
        }
    }

    /// Takes a switch.
    ///
    /// # Errors
    /// Another value than true and false.
    pub(super) fn switch(&mut self, key: &str) -> Result<bool, AskError> {
        match self.value(key) {
            None => Ok(false),
            Some(Value::Bool(given)) => Ok(given),
            Some(other) => Err(self.wrong(key, &other, "it must be true or false")),
        }
    }

    /// Takes a name, or several.
    ///
    /// # Errors
    /// Other values.
    pub(super) fn names(&mut self, key: &str) -> Result<Vec<String>, AskError> {
        let name = |value: Value| match value {
            Value::String(name) => Ok(name),
            other => Err(self.giver.option(key) + &format!(" is {other}; it must be a name, or a list of names")),
        };
        let place = self.values.iter().position(|(name, _)| name == key);
        let names = match place.map(|place| self.values.remove(place).1) {
            None => Ok(Vec::new()),
            Some(Value::Array(all)) => all.into_iter().map(name).collect(),
            Some(one) => name(one).map(|name| vec![name]),
        };
        names.map_err(AskError::Usage)
    }

    /// A file that an option names.
    pub(super) fn file(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// The refusal of a value.
    pub(super) fn wrong(&self, key: &str, value: &Value, why: &str) -> AskError {
        AskError::Usage(format!("{} is {value}; {why}", self.giver.option(key)))
    }

    /// The refusal of an option that must be there.
    pub(super) fn missing(&self, key: &str, remedy: &str) -> AskError {
        AskError::Usage(format!("{} is missing; {remedy}", self.giver.option(key)))
    }

    /// An error in a value of an option.
    pub(super) fn fault(&self, error: &SpecError) -> AskError {
        AskError::Usage(format!("{} {}", self.giver.option(&error.key), error.message))
    }

    /// Reads the value of an option.
    ///
    /// # Errors
    /// A value that it cannot have.
    pub(super) fn read<T: DeserializeOwned>(&self, key: &str, value: &Value) -> Result<T, AskError> {
        let at = |error: SpecError| if error.key.is_empty() { key.to_owned() } else { format!("{key}.{}", error.key) };
        let wrong = |error: SpecError| self.fault(&SpecError { key: at(error.clone()), ..error });
        options_from_value(value).map_err(wrong)
    }

    /// Reads a table of a test, whose kind Python calls the test.
    ///
    /// # Errors
    /// A value that it cannot have.
    pub(super) fn test(&self, key: &str, mut table: Value) -> Result<Test, AskError> {
        if let Some(options) = table.as_object_mut()
            && let Some(kind) = options.remove("test")
            && options.insert("kind".to_owned(), kind).is_some()
        {
            let option = self.giver.option(key);
            let why = "test and kind are two words for one thing; leave one of them out";
            return Err(AskError::Usage(format!("{option} names its test twice: {why}")));
        }
        self.read(key, &table)
    }

    /// Takes all options as one request, whose keys `keys` lists; `file` is an option whose text is the name of a file.
    ///
    /// # Errors
    /// Unknown options, and values that they cannot have.
    pub(super) fn all<T: DeserializeOwned>(mut self, keys: &[&str], file: &str) -> Result<T, AskError> {
        let mut options = Map::new();
        for (name, value) in std::mem::take(&mut self.values) {
            match keys.iter().find(|key| of_schema::means(key, &name)) {
                Some(key) if *key == file => {
                    let named = value.as_str().map(|name| self.file(name).to_string_lossy().into_owned());
                    options.insert(file.to_owned(), named.map_or(value, Value::from));
                }
                Some(key) => drop(options.insert((*key).to_owned(), value)),
                None => self.values.push((name, value)),
            }
        }
        let read = options_from_value(&Value::Object(options)).map_err(|error| self.fault(&error));
        self.end(keys)?;
        read
    }

    /// Refuses an option that no step has.
    ///
    /// # Errors
    /// The first option that was not taken, and one that is spelled like it.
    pub(super) fn end(self, keys: &[&str]) -> Result<(), AskError> {
        let Some((name, _)) = self.values.first() else { return Ok(()) };
        let near = meso_core::spec::nearest(name, keys).map(|near| self.giver.option(near));
        let near = near.map(|near| format!("did you mean {near}? ")).unwrap_or_default();
        let (option, verb) = (self.giver.option(name), self.name);
        Err(AskError::Usage(format!("{option} is not known; {near}mesocrete {verb} --help lists the options")))
    }
}

/// Where a study has an option of packings.
fn of_packings(name: &str) -> Option<String> {
    let key = Over::key_of(name, &[])?;
    let own = match key {
        "seed" | "fraction" => key.to_owned(),
        _ => format!("placement.{key}"),
    };
    let flag = ["min_gap_mm", "time_limit_s"].contains(&key).then(|| Giver::Flags.option(key) + ", or ");
    Some(format!("{}{own} in its spec or in [over]", flag.unwrap_or_default()))
}
