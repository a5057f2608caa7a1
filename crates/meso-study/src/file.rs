//! STUDY.toml: the options that vary, and the steps after each packing.

use crate::{Axis, Case, Keep, NamedFiles, Plan, Planning, Sampling, Steps};
use meso_ask::files::{self, Reader};
use meso_ask::{AskError, Giver};
use meso_core::SpecError;
use meso_core::recipes::Recipe;
use meso_core::spec::{Files, NoFiles, line_of, options_from_toml};
use meso_files::Beside;
use serde::Deserialize;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

/// Most cases of a study that is read for its own sake.
const MOST_ALONE: usize = 50;

/// The file's content, unchecked.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Content {
    spec: Option<Value>,
    recipe: Option<String>,
    outputs: Vec<String>,
    model: Keep,
    over: Map<String, Value>,
    zip: Map<String, Value>,
    draw: Option<Sampling>,
    mesh: Option<Map<String, Value>>,
    solve: Option<Map<String, Value>>,
    effective: Option<Map<String, Value>>,
    test: Option<Value>,
}

/// Keys of a STUDY.toml at its top.
const OWN: [&str; 11] =
    ["spec", "recipe", "outputs", "model", "over", "zip", "draw", "mesh", "solve", "effective", "test"];

/// A STUDY.toml and its place.
pub struct StudyFile {
    path: PathBuf,
    /// The text of the file, which has the lines of its options; empty of a study that another command made.
    text: String,
    /// The spec that the axes are laid over, and the folder of the files that it names.
    base: Value,
    folder: PathBuf,
    axes: Vec<Axis>,
    keep: Keep,
    task: Value,
}

impl StudyFile {
    /// Reads the file, and the spec that it names.
    ///
    /// # Errors
    /// Files that cannot be read, and wrong tables.
    pub fn read(path: &Path, read: &Reader<'_>) -> Result<Self, AskError> {
        let (content, text) = files::toml(path, read, |text| Ok((options_from_toml(text)?, text.to_owned())))?;
        Self::of(content, path, text, read)
    }

    fn of(content: Content, path: &Path, text: String, read: &Reader<'_>) -> Result<Self, AskError> {
        let wrong = |message: String| wrong_at(path, &text, &message);
        let Base { tree: base, folder, specs } = base(&content, path, read)?;
        let axes = all_axes(specs, &content).map_err(wrong)?;
        let mut task = Map::from_iter([("outputs".to_owned(), json!(content.outputs))]);
        for (name, flags) in [("mesh", content.mesh), ("solve", content.solve), ("effective", content.effective)] {
            task.extend(flags.map(|flags| (name.to_owned(), Value::Object(flags))));
        }
        if let Some(test) = content.test {
            let is_clear = task.get("solve").is_some_and(|solve| solve.get("test").is_none());
            let why = "test is the test of [solve], which must be there, without a test of its own";
            is_clear.then_some(()).ok_or_else(|| wrong(why.to_owned()))?;
            task.insert("test".to_owned(), test_tree(test, path, read)?);
        }
        let keep = content.model;
        Ok(Self { path: path.to_owned(), text, base, folder, axes, keep, task: Value::Object(task) })
    }

    /// Reads a study from `text` that names no other file; `None` for one that names some, or has very many cases.
    ///
    /// # Errors
    /// Wrong tables.
    pub fn alone(text: &str) -> Result<Option<Self>, AskError> {
        let wrong = |error: SpecError| AskError::Usage(error.to_string());
        let content: Content = options_from_toml(text).map_err(wrong)?;
        let is_listed = content.spec.as_ref().is_some_and(Value::is_array);
        if is_listed || [&content.spec, &content.test].into_iter().flatten().any(Value::is_string) {
            return Ok(None);
        }
        let study = Self::of(content, Path::new("STUDY.toml"), String::new(), &no_file)?;
        let cases = study.axes.iter().map(|axis| axis.rows.len()).fold(1, usize::saturating_mul);
        let mut values = study.task.to_string();
        study.axes.iter().for_each(|axis| values += &format!("{:?}{:?}", axis.keys, axis.rows));
        let names_files =
            ["materials", "phases"].iter().any(|flag| values.contains(flag)) || values.to_lowercase().contains(".toml");
        Ok((cases <= MOST_ALONE && !names_files).then_some(study))
    }

    /// Sets values under `[placement]` of the spec; an axis of the study overrides them.
    pub fn place(&mut self, values: &[(&str, Option<f64>)]) {
        let listed = self.axes.iter_mut().flat_map(|axis| &mut axis.specs);
        std::iter::once(&mut self.base).chain(listed).for_each(|spec| place(spec, values));
    }

    /// All cases, every spec validated; `report` hears how far the planning is.
    ///
    /// # Errors
    /// Combinations that cannot be.
    pub fn plan(&self, report: &mut dyn FnMut(usize, usize)) -> Result<Plan, AskError> {
        self.plan_with(&mut Beside(&self.folder), report)
    }

    /// Plans as [`plan`](Self::plan) does, and refuses a spec that names files.
    ///
    /// # Errors
    /// Combinations that cannot be.
    pub fn plan_alone(&self) -> Result<Plan, AskError> {
        self.plan_with(&mut NoFiles, &mut |_, _| ())
    }

    fn plan_with(&self, files: &mut dyn Files, report: &mut dyn FnMut(usize, usize)) -> Result<Plan, AskError> {
        let named = NamedFiles::beside(self.beside());
        let mut completing = Completing { named, report };
        Plan::new_while(&self.base, &self.axes, &self.task, files, &mut completing)
            .map_err(|error| wrong_at(&self.path, &self.text, &error.to_string()))
    }

    /// Whether a file holds a study, and no spec: by its tables.
    pub fn is_study(text: &str) -> bool {
        let tree: Value = options_from_toml(text).unwrap_or_default();
        tree.as_object().is_some_and(|keys| keys.keys().any(|key| OWN.contains(&&**key)))
    }

    /// The packing that a finished case keeps.
    pub fn keep(&self) -> Keep {
        self.keep
    }

    /// The folder of the files that the study names.
    pub fn beside(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// Steps of a case.
    ///
    /// # Errors
    /// See [`Steps::of`].
    pub fn steps(&self, case: &Case, read: &Reader<'_>) -> Result<Steps, AskError> {
        let steps = Steps::of(&case.task, self.keep, self.beside(), &Giver::Section, read);
        steps.map_err(|fault| self.wrong(&fault))
    }

    /// A fault with the file's name, and the line of the option that it begins with.
    pub fn wrong(&self, fault: &AskError) -> AskError {
        wrong_at(&self.path, &self.text, fault.message())
    }
}

/// A fault with the name of a study's file, and the line in its text of the option that it begins with.
fn wrong_at(path: &Path, text: &str, message: &str) -> AskError {
    let line = line(text, message).map(|line| format!("line {line}: ")).unwrap_or_default();
    AskError::Usage(format!("{}: {line}{message}", path.display()))
}

/// The line of the option that begins a message, which an axis may have set: `[mesh] subsamples`, or `fraction` of a case.
fn line(text: &str, message: &str) -> Option<usize> {
    let of_case = message.strip_prefix("case ").and_then(|case| case.split_once(": "));
    let message = of_case.map_or(message, |(_, rest)| rest);
    let (section, rest) = match message.strip_prefix('[') {
        Some(rest) => rest.split_once("] ").map(|(section, rest)| (format!("{section}."), rest))?,
        None => (String::new(), message),
    };
    let key = rest.split(' ').next()?;
    let places = ["", "over.", "zip.", "draw.over.", "spec."]
        .into_iter()
        .flat_map(|table| [key.to_owned(), key.replace('_', "-")].map(|key| (table, key)));
    places.into_iter().find_map(|(table, key)| line_of(text, &format!("{table}{section}{key}")))
}

/// Sets values under `[placement]` of a spec.
pub(crate) fn place(spec: &mut Value, values: &[(&str, Option<f64>)]) {
    for (key, value) in values.iter().filter_map(|(key, value)| Some((key, (*value)?))) {
        if let Some(spec) = spec.as_object_mut()
            && let Some(placement) = spec.entry("placement").or_insert_with(|| json!({})).as_object_mut()
        {
            placement.insert((*key).to_owned(), json!(value));
        }
    }
}

/// Refuses to read a file.
fn no_file(path: &Path) -> Result<String, AskError> {
    Err(AskError::Usage(format!("{} is not read here", path.display())))
}

struct Completing<'a> {
    named: NamedFiles<'a>,
    report: &'a mut dyn FnMut(usize, usize),
}

impl Planning for Completing<'_> {
    fn goes_on(&mut self, planned: usize, cases: usize) -> bool {
        (self.report)(planned, cases);
        true
    }

    fn complete(&mut self, task: &mut Value) -> Result<(), String> {
        self.named.complete(task)
    }
}

/// The tree of a test: a table, or the content of a TEST.toml.
fn test_tree(test: Value, path: &Path, read: &Reader<'_>) -> Result<Value, AskError> {
    match test {
        Value::String(name) => files::test_tree(&beside(path, &name), read),
        Value::Object(_) => Ok(test),
        other => {
            let why = format!("test is {other}; it must be a [test] table or the name of a TEST.toml");
            Err(AskError::Usage(format!("{}: {why}", path.display())))
        }
    }
}

/// The spec that axes are laid over.
struct Base {
    tree: Value,
    /// Folder of the files that it names.
    folder: PathBuf,
    /// Specs of a list, with their names.
    specs: Vec<(Value, Value)>,
}

fn base(content: &Content, path: &Path, read: &Reader<'_>) -> Result<Base, AskError> {
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    let wrong = |message: String| AskError::Usage(format!("{}: {message}", path.display()));
    let one = |tree: Value, folder: PathBuf| Ok(Base { tree, folder, specs: Vec::new() });
    match (&content.spec, &content.recipe) {
        (Some(_), Some(_)) => Err(wrong("spec and recipe both say what to pack; keep one of the two".to_owned())),
        (Some(Value::String(name)), None) => {
            let (tree, folder) = spec_file(path, name, read)?;
            one(tree, folder)
        }
        (Some(table @ Value::Object(_)), None) => one(table.clone(), folder),
        (Some(Value::Array(names)), None) => listed(names, path, read),
        (Some(other), None) => {
            let accepted = "it must be a [spec] table, the name of a SPEC.toml or a list of names";
            Err(wrong(format!("spec is {other}; {accepted}")))
        }
        (None, Some(name)) => {
            let recipe = Recipe::named(name).map_err(wrong)?;
            one(options_from_toml(recipe.text).map_err(|error| wrong(error.to_string()))?, folder)
        }
        (None, None) => one(Value::Object(Map::new()), folder),
    }
}

/// A SPEC.toml beside the study, and its folder.
fn spec_file(study: &Path, name: &str, read: &Reader<'_>) -> Result<(Value, PathBuf), AskError> {
    let file = beside(study, name);
    let folder = file.parent().unwrap_or(Path::new("")).to_owned();
    Ok((files::toml(&file, read, options_from_toml)?, folder))
}

/// The specs of a list, from one folder: files that they name are looked for there.
fn listed(names: &[Value], path: &Path, read: &Reader<'_>) -> Result<Base, AskError> {
    let wrong = |message: String| AskError::Usage(format!("{}: {message}", path.display()));
    let (mut specs, mut folders) = (Vec::new(), Vec::new());
    for name in names {
        let file =
            name.as_str().ok_or_else(|| wrong(format!("spec lists {name}; it must list names of SPEC.toml files")))?;
        let (tree, folder) = spec_file(path, file, read)?;
        specs.push((name.clone(), tree));
        folders.push(folder);
    }
    let Some(folder) = folders.first().cloned() else {
        return Err(wrong("spec lists no file; give at least one".to_owned()));
    };
    if folders.iter().any(|other| *other != folder) {
        return Err(wrong("spec lists files of several folders; move them into one".to_owned()));
    }
    Ok(Base { tree: Value::Object(Map::new()), folder, specs })
}

/// The axes of listed specs, `[over]`, `[zip]` and `[draw]`, in this order.
fn all_axes(specs: Vec<(Value, Value)>, content: &Content) -> Result<Vec<Axis>, String> {
    let mut all: Vec<Axis> = (!specs.is_empty()).then(|| Axis::of_specs(specs)).into_iter().collect();
    all.extend(lists("over", "", &content.over)?.into_iter().map(|(key, values)| Axis::new(key, values)));
    if !content.zip.is_empty() {
        all.push(Axis::zipped(lists("zip", "", &content.zip)?).map_err(|error| error.to_string())?);
    }
    if let Some(draw) = &content.draw {
        all.push(Axis::drawn(draw, &all).map_err(|error| error.to_string())?);
    }
    Ok(all)
}

/// The lists in a table of `[over]` or `[zip]`, and whole numbers `{ from = 1, to = 20 }`; other tables are parts of a
/// dotted key.
fn lists(section: &str, prefix: &str, table: &Map<String, Value>) -> Result<Vec<(String, Vec<Value>)>, String> {
    let mut found = Vec::new();
    for (name, value) in table {
        let key = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
        match value {
            Value::Array(values) => found.push((key, values.clone())),
            Value::Object(range) if range.contains_key("from") => {
                let values = range_values(range).ok_or_else(|| {
                    format!("{section}.{key} is {value}; a range is {{ from = 1, to = 20 }}, whole numbers, with a step if need be")
                })?;
                found.push((key, values));
            }
            Value::Object(inner) => found.extend(lists(section, &key, inner)?),
            other => {
                return Err(format!(
                    "{section}.{key} is {other}; give a list, e.g. [{other}], or {{ from = 1, to = 20 }}"
                ));
            }
        }
    }
    Ok(found)
}

fn range_values(range: &Map<String, Value>) -> Option<Vec<Value>> {
    let known = range.keys().all(|key| ["from", "to", "step"].contains(&key.as_str()));
    let (from, to) = (range.get("from")?.as_i64()?, range.get("to")?.as_i64()?);
    let step = range.get("step").map_or(Some(1), Value::as_u64).filter(|step| *step > 0)?;
    let count = usize::try_from(to.checked_sub(from)?).ok()? / usize::try_from(step).ok()?;
    let is_small = count < crate::MOST_CASES;
    (known && is_small).then(|| (from..=to).step_by(step as usize).map(Value::from).collect())
}

/// A path relative to the folder that a file lies in.
fn beside(file: &Path, name: &str) -> PathBuf {
    file.parent().unwrap_or(Path::new("")).join(name)
}
