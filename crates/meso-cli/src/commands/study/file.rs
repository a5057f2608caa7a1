//! STUDY.toml: the options that vary, and the steps after each packing.

use super::steps::{Given, Steps};
use super::{beside, flag_files};
use crate::commands::test_file;
use crate::failure::Failure;
use crate::inputs;
use meso_core::SpecError;
use meso_core::recipes::Recipe;
use meso_core::spec::{Files, line_of, options_from_toml};
use meso_files::Beside;
use meso_study::{Axis, Case, Keep, Plan, Planning, Sampling, digest};
use serde::Deserialize;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::io;
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

/// A STUDY.toml and its place.
pub(crate) struct StudyFile {
    path: PathBuf,
    /// The text of the file, which has the lines of its options; empty of a study that another command made.
    text: String,
    /// The spec that the axes are laid over, and the folder of the files that it names.
    base: Value,
    folder: PathBuf,
    axes: Vec<Axis>,
    outputs: Vec<String>,
    keep: Keep,
    task: Value,
}

impl StudyFile {
    /// Reads the file, and the spec that it names.
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let (content, text) = inputs::toml(path, |text| Ok((options_from_toml(text)?, text.to_owned())))?;
        Ok(Self { text, ..Self::of(content, path)? })
    }

    /// The study of a tree of values, as if it were the file at `path`.
    pub(crate) fn of_tree(tree: Value, path: &Path) -> Result<Self, Failure> {
        let content = serde_json::from_value(tree).map_err(|error| Failure::Run(error.to_string()))?;
        Self::of(content, path)
    }

    fn of(content: Content, path: &Path) -> Result<Self, Failure> {
        let wrong = |message: String| Failure::Usage(format!("{}: {message}", path.display()));
        let Base { tree: base, folder, specs } = base(&content, path)?;
        let axes = all_axes(specs, &content).map_err(wrong)?;
        let mut task = Map::from_iter([("outputs".to_owned(), json!(content.outputs))]);
        for (name, flags) in [("mesh", content.mesh), ("solve", content.solve), ("effective", content.effective)] {
            task.extend(flags.map(|flags| (name.to_owned(), Value::Object(flags))));
        }
        if let Some(test) = content.test {
            let is_clear = task.get("solve").is_some_and(|solve| solve.get("test").is_none());
            let why = "test is the test of [solve], which must be there, without a test of its own";
            is_clear.then_some(()).ok_or_else(|| wrong(why.to_owned()))?;
            task.insert("test".to_owned(), test_tree(test, path)?);
        }
        for key in axes.iter().flat_map(|axis| &axis.keys) {
            let section = key.split('.').next().unwrap_or_default();
            if ["mesh", "solve", "effective", "test"].contains(&section) && !task.contains_key(section) {
                return Err(wrong(format!("{key} changes [{section}], which is not there; add it")));
            }
        }
        let Content { outputs, model: keep, .. } = content;
        Ok(Self {
            path: path.to_owned(),
            text: String::new(),
            base,
            folder,
            axes,
            outputs,
            keep,
            task: Value::Object(task),
        })
    }

    /// Reads a study from `text` that names no other file; `None` for one that names some, or has very many cases.
    pub(super) fn alone(text: &str) -> Result<Option<Self>, Failure> {
        let wrong = |error: SpecError| Failure::Usage(error.to_string());
        let content: Content = options_from_toml(text).map_err(wrong)?;
        let is_listed = content.spec.as_ref().is_some_and(Value::is_array);
        if is_listed || [&content.spec, &content.test].into_iter().flatten().any(Value::is_string) {
            return Ok(None);
        }
        let study = Self::of(content, Path::new("STUDY.toml"))?;
        let cases = study.axes.iter().map(|axis| axis.rows.len()).fold(1, usize::saturating_mul);
        let mut values = study.task.to_string();
        study.axes.iter().for_each(|axis| values += &format!("{:?}{:?}", axis.keys, axis.rows));
        let names_files =
            ["materials", "phases"].iter().any(|flag| values.contains(flag)) || values.to_lowercase().contains(".toml");
        Ok((cases <= MOST_ALONE && !names_files).then_some(study))
    }

    /// Sets values under `[placement]` of the spec; an axis of the study overrides them.
    pub(crate) fn place(&mut self, values: &[(&str, Option<f64>)]) {
        let listed = self.axes.iter_mut().flat_map(|axis| &mut axis.specs);
        for spec in std::iter::once(&mut self.base).chain(listed) {
            for (key, value) in values.iter().filter_map(|(key, value)| Some((key, (*value)?))) {
                if let Some(spec) = spec.as_object_mut()
                    && let Some(placement) = spec.entry("placement").or_insert_with(|| json!({})).as_object_mut()
                {
                    placement.insert((*key).to_owned(), json!(value));
                }
            }
        }
    }

    /// All cases, every spec validated; `report` hears how far the planning is.
    pub(super) fn plan(&self, report: &mut dyn FnMut(usize, usize)) -> Result<Plan, Failure> {
        self.plan_with(&mut Beside(&self.folder), report)
    }

    /// Plans as [`plan`](Self::plan) does, and refuses a spec that names files.
    pub(super) fn plan_alone(&self) -> Result<Plan, Failure> {
        self.plan_with(&mut NoFiles, &mut |_, _| ())
    }

    fn plan_with(&self, files: &mut dyn Files, report: &mut dyn FnMut(usize, usize)) -> Result<Plan, Failure> {
        let mut completing = Completing { study: &self.path, digests: BTreeMap::new(), report };
        Plan::new_while(&self.base, &self.axes, &self.task, files, &mut completing)
            .map_err(|error| Failure::Usage(format!("{}: {error}", self.path.display())))
    }

    /// The steps of a case, with their flags checked.
    pub(super) fn steps(&self, case: &Case, out: &Path, given: &Given) -> Result<Steps, Failure> {
        Steps::new(case, (&self.outputs, self.keep), &out.join(&case.folder), &self.path, given)
            .map_err(|failure| self.wrong(&failure))
    }

    /// A failure with the file's name, and the line of the option that it begins with.
    pub(super) fn wrong(&self, failure: &Failure) -> Failure {
        let line = self.line(failure.message()).map(|line| format!(" line {line}")).unwrap_or_default();
        Failure::Usage(format!("{}{line}: {}", self.path.display(), failure.message()))
    }

    /// The line of the option that begins a message: `[mesh] subsamples`, which an axis may have set.
    fn line(&self, message: &str) -> Option<usize> {
        let (section, rest) = message.strip_prefix('[')?.split_once("] ")?;
        let key = rest.split(' ').next()?;
        let places = ["", "over.", "zip.", "draw.over."]
            .into_iter()
            .flat_map(|table| [key.to_owned(), key.replace('_', "-")].map(|key| (table, key)));
        places.into_iter().find_map(|(table, key)| line_of(&self.text, &format!("{table}{section}.{key}")))
    }
}

/// A folder without files.
struct NoFiles;

impl Files for NoFiles {
    fn read(&mut self, name: &str) -> io::Result<Vec<u8>> {
        Err(io::Error::other(format!("{name} is not read here")))
    }

    fn list(&mut self, name: &str) -> io::Result<Vec<String>> {
        self.read(name).map(|_| Vec::new())
    }
}

/// Adds the hash of each file that a task names: the content of the file decides, not its name.
struct Completing<'a> {
    study: &'a Path,
    /// Hashes of the files read so far.
    digests: BTreeMap<PathBuf, String>,
    report: &'a mut dyn FnMut(usize, usize),
}

impl Planning for Completing<'_> {
    fn goes_on(&mut self, planned: usize, cases: usize) -> bool {
        (self.report)(planned, cases);
        true
    }

    fn complete(&mut self, task: &mut Value) -> Result<(), String> {
        for section in ["mesh", "solve", "effective"] {
            for flag in flag_files::FLAGS {
                let files = flag_files::of(flag, &task[section][flag]);
                let hashes = files.map(|file| self.hash_whole(flag, file)).collect::<Result<Vec<_>, _>>()?;
                if !hashes.is_empty() {
                    task[section][flag_files::hash_key(flag)] = hashes.join(" ").into();
                }
            }
        }
        Ok(())
    }
}

/// The tree of a test: a table, or the content of a TEST.toml.
fn test_tree(test: Value, path: &Path) -> Result<Value, Failure> {
    match test {
        Value::String(name) => {
            let file = beside(path, &name);
            let mut tree: Value = inputs::toml(&file, options_from_toml)?;
            test_file::take_tables(&mut tree, &file)?;
            Ok(tree)
        }
        Value::Object(_) => Ok(test),
        other => {
            let why = format!("test is {other}; it must be a [test] table or the name of a TEST.toml");
            Err(Failure::Usage(format!("{}: {why}", path.display())))
        }
    }
}

impl Completing<'_> {
    /// Hash of a flag's file, and of the tables that a TEST.toml names.
    fn hash_whole(&mut self, flag: &str, file: &str) -> Result<String, String> {
        let mut hashes = vec![self.hash(Path::new(file))?];
        let folder = Path::new(file).parent().unwrap_or(Path::new(""));
        for table in flag_files::tables(flag, &beside(self.study, file)) {
            hashes.push(self.hash(&folder.join(table))?);
        }
        Ok(hashes.join("+"))
    }

    fn hash(&mut self, file: &Path) -> Result<String, String> {
        let path = self.study.parent().unwrap_or(Path::new("")).join(file);
        if let Some(known) = self.digests.get(&path) {
            return Ok(known.clone());
        }
        // A pipe or a device would be read without end.
        let bytes = Beside(Path::new("")).read(&path.to_string_lossy()).map_err(|error| error.to_string())?;
        Ok(self.digests.entry(path).or_insert(digest(&bytes)).clone())
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

fn base(content: &Content, path: &Path) -> Result<Base, Failure> {
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    let wrong = |message: String| Failure::Usage(format!("{}: {message}", path.display()));
    let one = |tree: Value, folder: PathBuf| Ok(Base { tree, folder, specs: Vec::new() });
    match (&content.spec, &content.recipe) {
        (Some(_), Some(_)) => Err(wrong("spec and recipe both say what to pack; keep one of the two".to_owned())),
        (Some(Value::String(name)), None) => {
            let (tree, folder) = spec_file(path, name)?;
            one(tree, folder)
        }
        (Some(table @ Value::Object(_)), None) => one(table.clone(), folder),
        (Some(Value::Array(names)), None) => listed(names, path),
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
fn spec_file(study: &Path, name: &str) -> Result<(Value, PathBuf), Failure> {
    let file = beside(study, name);
    let folder = file.parent().unwrap_or(Path::new("")).to_owned();
    Ok((inputs::toml(&file, options_from_toml)?, folder))
}

/// The specs of a list, from one folder: files that they name are looked for there.
fn listed(names: &[Value], path: &Path) -> Result<Base, Failure> {
    let wrong = |message: String| Failure::Usage(format!("{}: {message}", path.display()));
    let (mut specs, mut folders) = (Vec::new(), Vec::new());
    for name in names {
        let file =
            name.as_str().ok_or_else(|| wrong(format!("spec lists {name}; it must list names of SPEC.toml files")))?;
        let (tree, folder) = spec_file(path, file)?;
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
    let is_small = count < meso_study::MOST_CASES;
    (known && is_small).then(|| (from..=to).step_by(step as usize).map(Value::from).collect())
}
