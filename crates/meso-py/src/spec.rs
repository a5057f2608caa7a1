//! `Spec`: everything that decides a model.

use crate::beside::Told;
use crate::boundary::{file_error, guard, keyword, wrong_type, wrong_value};
use crate::run::beside_python;
use crate::tree;
use crate::views::call_view;
use meso_core::materials::{LawName, Mix, Rock};
use meso_core::recipes;
use meso_core::spec::{self, Spec, SpecError};
use meso_core::{Silent, Watch};
use pyo3::exceptions::{PyFileNotFoundError, PyTimeoutError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

/// Everything that determines a model; omitted options keep their defaults, the paper's specimen.
///
/// Parameters
/// ----------
/// **options
///     `seed`, `fraction`, and the sections of a SPEC.toml as dicts: `specimen`, `grading`, `shape`, `itz`,
///     `placement`, `voids`, `fibres`, and `mix` instead of `fraction`.
///
/// Raises
/// ------
/// ValueError
///     Names the key, the value and the accepted range.
/// TypeError
///     Where a value has the wrong type.
#[pyclass(name = "Spec", module = "mesocrete", frozen, eq)]
#[derive(Clone, PartialEq)]
pub(crate) struct PySpec(pub(crate) Spec);

/// A spec from a dict-like tree; files that it names are looked for in the working directory.
fn from_value(value: &Value) -> PyResult<Spec> {
    Spec::from_value_with(value, &mut Told::beside(Path::new(""))).map_err(|error| spec_error(&error))
}

/// The exception of a spec that cannot be, or that the time limit left unproved.
pub(crate) fn spec_error(error: &SpecError) -> PyErr {
    let meant = |key: &str| format!("did you mean {key}?");
    let message = error.message.replace(&meant("element_size_mm"), &meant(&keyword("element_size_mm")));
    let text = SpecError { key: keyword(&error.key), message, ..error.clone() }.to_string();
    match (error.is_late, error.is_wrong_type) {
        (true, _) => PyTimeoutError::new_err(text),
        (false, true) => wrong_type(text),
        (false, false) => wrong_value(text),
    }
}

/// Options outside a spec, from Python's keywords; omitted ones keep their defaults.
pub(crate) fn options<T: DeserializeOwned>(keywords: Option<&Bound<'_, PyDict>>) -> PyResult<T> {
    let value = keywords.map_or(Ok(Value::Object(Map::new())), |dict| tree::from_python("", dict.as_any()))?;
    spec::options_from_value(&value).map_err(|error| spec_error(&error))
}

fn read(path: &Path, watch: &dyn Watch, time_limit_s: Option<f64>) -> PyResult<Spec> {
    if let Some(name) = meso_files::missing_recipe(path) {
        return Err(PyFileNotFoundError::new_err(format!("{name} is a recipe and no file: Spec.recipe({name:?})")));
    }
    let bytes = std::fs::read(path).map_err(|error| file_error(path, error))?;
    let name = path.display();
    let not_text = |_| wrong_value(format!("{name}: the file is not UTF-8 text"));
    let text = String::from_utf8(bytes).map_err(not_text)?;
    // Files that a spec names lie beside it.
    let folder = path.parent().unwrap_or(Path::new(""));
    Spec::from_toml_while(&text, &mut Told::beside(folder), watch, time_limit_s).map_err(|error| {
        let error = error.of_limit(time_limit_s, "time_limit");
        let text = format!("{name}: {error}");
        if error.is_late { PyTimeoutError::new_err(text) } else { wrong_value(text) }
    })
}

/// The unresolved tree of a spec as `pack` accepts it, and the folder of the files that it names. Values that follow from
/// others, the classes of usual limits, are left out, so that changes may be laid over it.
pub(crate) fn tree_of(object: Option<&Bound<'_, PyAny>>) -> PyResult<(Value, PathBuf)> {
    let here = PathBuf::new();
    let Some(object) = object else { return Ok((Value::Object(Map::new()), here)) };
    if let Ok(spec) = object.cast::<PySpec>() {
        return Ok((spec.get().unresolved()?, here));
    }
    if object.is_instance_of::<PyDict>() {
        return Ok((tree::from_python("", object)?, here));
    }
    let Some(path) = as_path(object) else { return from_any(Some(object)).map(|_| (Value::Null, here)) };
    // Its errors have lines.
    read(&path, &Silent, None)?;
    let text = std::fs::read_to_string(&path).map_err(|error| file_error(&path, error))?;
    let tree = spec::options_from_toml(&text).map_err(|error| spec_error(&error))?;
    Ok((tree, path.parent().unwrap_or(Path::new("")).to_owned()))
}

/// A spec as `pack` accepts it, read as far as that takes Python.
pub(crate) enum Given {
    Spec(Box<Spec>),
    Tree(Value),
    File(PathBuf),
}

impl Given {
    /// Whether it may have a surface, of which a million triangles take seconds.
    pub(crate) fn may_take_long(&self) -> bool {
        match self {
            Self::Spec(_) => false,
            Self::Tree(tree) => tree["specimen"]["kind"] == "mesh",
            Self::File(_) => true,
        }
    }

    /// The spec; a time limit may take the place of its own.
    pub(crate) fn read(self, watch: &dyn Watch, time_limit_s: Option<f64>) -> PyResult<Spec> {
        match self {
            Self::Spec(spec) => Ok(*spec),
            Self::Tree(tree) => {
                let spec = Spec::from_value_while(&tree, &mut Told::beside(Path::new("")), watch, time_limit_s);
                spec.map_err(|error| spec_error(&error.of_limit(time_limit_s, "time_limit")))
            }
            Self::File(path) => read(&path, watch, time_limit_s),
        }
    }
}

/// Reads a spec as `pack` accepts it; Ctrl-C is heard meanwhile.
pub(crate) fn from_any(object: Option<&Bound<'_, PyAny>>) -> PyResult<Spec> {
    let given = given(object)?;
    match object.filter(|_| given.may_take_long()) {
        Some(object) => read_beside(object.py(), given),
        None => given.read(&Silent, None),
    }
}

fn read_beside(py: Python<'_>, given: Given) -> PyResult<Spec> {
    beside_python(py, None, move |_| given.read(&Silent, None))?
}

/// Nothing, a dict, the path of a SPEC.toml, or a [`PySpec`].
pub(crate) fn given(object: Option<&Bound<'_, PyAny>>) -> PyResult<Given> {
    let Some(object) = object else { return Ok(Given::Spec(Box::default())) };
    if let Ok(spec) = object.cast::<PySpec>() {
        return Ok(Given::Spec(Box::new(spec.get().0.clone())));
    }
    if object.is_instance_of::<PyDict>() {
        return Ok(Given::Tree(tree::from_python("", object)?));
    }
    if let Some(path) = as_path(object) {
        return Ok(Given::File(path));
    }
    let given = tree::type_name(object);
    Err(wrong_type(format!("spec is of type {given}; it must be None, a dict, a path or a mesocrete.Spec")))
}

/// `str` and `os.PathLike`; a number is not a path.
fn as_path(object: &Bound<'_, PyAny>) -> Option<PathBuf> {
    object.extract().ok()
}

impl PySpec {
    fn value(&self) -> PyResult<Value> {
        serde_json::to_value(&self.0).map_err(|error| wrong_value(error.to_string()))
    }

    /// Its tree without values that follow from the rest.
    fn unresolved(&self) -> PyResult<Value> {
        let (mut value, spec) = (self.value()?, &self.0);
        let follows = [
            ("grading", "classes_mm", spec.grading.classes_mm == spec.grading.usual_classes()),
            ("shape", "vertices", spec.shape.vertices == spec.shape.kind.usual_vertices()),
        ];
        for (section, key, _) in follows.into_iter().filter(|(_, _, follows)| *follows) {
            if let Some(section) = value[section].as_object_mut() {
                section.remove(key);
            }
        }
        Ok(value)
    }

    fn section<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        tree::to_python(py, &self.value()?[name])
    }
}

#[pymethods]
impl PySpec {
    #[new]
    #[pyo3(signature = (table=None, /, **options))]
    fn new(table: Option<&Bound<'_, PyDict>>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        guard(|| match (table, options.filter(|options| !options.is_empty())) {
            (Some(_), Some(_)) => Err(wrong_type("Spec takes a dict or keywords; give one of the two")),
            (table, options) => from_any(table.or(options).map(|dict| dict.as_any())).map(Self),
        })
    }

    /// Reads the text of a SPEC.toml.
    #[staticmethod]
    fn from_toml(text: &str) -> PyResult<Self> {
        guard(|| Spec::from_toml(text).map(Self).map_err(|error| spec_error(&error)))
    }

    /// Reads a SPEC.toml.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        guard(|| read_beside(py, Given::File(path)).map(Self))
    }

    /// A specimen of the paper or of a standard, by its name in `recipes()`.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     For another name; the message lists them.
    #[staticmethod]
    fn recipe(name: &str) -> PyResult<Self> {
        guard(|| {
            let recipe = recipes::Recipe::named(name).map_err(wrong_value)?;
            Spec::from_toml(recipe.text).map(Self).map_err(|error| spec_error(&error))
        })
    }

    /// Seed of all randomness.
    #[getter]
    fn seed(&self) -> u64 {
        self.0.seed
    }

    /// Volume of the aggregates over the specimen's, 0 to 1.
    #[getter]
    fn fraction(&self) -> f64 {
        self.0.fraction
    }

    /// Specimen to fill; a copy.
    #[getter]
    fn specimen<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.section(py, "specimen")
    }

    /// Sizes; a copy.
    #[getter]
    fn grading<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.section(py, "grading")
    }

    /// Shapes; a copy.
    #[getter]
    fn shape<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.section(py, "shape")
    }

    /// Interfacial transition zone; a copy.
    #[getter]
    fn itz<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.section(py, "itz")
    }

    /// Placement; a copy.
    #[getter]
    fn placement<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.section(py, "placement")
    }

    /// Spherical voids, None where there are none; a copy.
    #[getter]
    fn voids<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.section(py, "voids")
    }

    /// Straight fibres, None where there are none; a copy.
    #[getter]
    fn fibres<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.section(py, "fibres")
    }

    /// Everything as a dict that `Spec(**it)` takes back.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        tree::to_python(py, &self.value()?)
    }

    /// Everything as the text of a SPEC.toml.
    fn to_toml(&self) -> PyResult<String> {
        toml::to_string(&self.0).map_err(|error| wrong_value(error.to_string()))
    }

    /// The text of a SPEC.toml with the meaning of each key above it: `print(spec.describe())`.
    fn describe(&self) -> PyResult<String> {
        self.0.describe().map_err(|error| wrong_value(error.to_string()))
    }

    /// A spec with `changes` laid over this one; sections are merged key by key.
    #[pyo3(signature = (**changes))]
    fn replace(&self, changes: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        guard(|| {
            let mut value = self.unresolved()?;
            let changes = changes.map_or(Ok(Value::Object(Map::new())), |dict| tree::from_python("", dict.as_any()));
            Spec::overlay(&mut value, changes?);
            from_value(&value).map(Self)
        })
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let dict = self.to_dict(py)?;
        let fields = dict.cast::<PyDict>()?.iter().map(|(key, value)| Ok(format!("{key}={}", value.repr()?)));
        Ok(format!("Spec({})", fields.collect::<PyResult<Vec<_>>>()?.join(", ")))
    }

    /// HTML for notebooks: the text of the SPEC.toml.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        call_view("spec_to_html", slf, None)
    }

    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let restore = py.import("mesocrete._mesocrete")?.getattr("_restore_spec")?;
        (restore, (self.to_dict(py)?,)).into_pyobject(py)
    }
}

/// Unpickles a `Spec`.
#[pyfunction(name = "_restore_spec")]
pub(crate) fn restore_spec(options: &Bound<'_, PyDict>) -> PyResult<PySpec> {
    guard(|| from_any(Some(options.as_any())).map(PySpec))
}

/// The specimens that `Spec.recipe` knows: a dict of names and titles.
#[pyfunction(name = "recipes")]
pub(crate) fn all_recipes(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    recipes::Recipe::ALL.iter().try_for_each(|recipe| dict.set_item(recipe.name, recipe.title()))?;
    Ok(dict)
}

/// A mean strength, MPa, or the class or mortar of a concrete.
#[derive(Deserialize)]
#[serde(untagged, expecting = "a number or a text")]
enum Fcm {
    Mpa(f64),
    Class(String),
}

/// Keywords of [`concrete_materials`].
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Concrete {
    fcm: Option<Fcm>,
    mortar: Option<Fcm>,
    rock: Option<Rock>,
    fraction: f64,
    law: LawName,
}

/// The `[materials]` of a concrete by its mean strength or by its mortar's, MPa, with a rock and a share of aggregates.
#[pyfunction(name = "_concrete_materials")]
#[pyo3(signature = (**given))]
pub(crate) fn concrete_materials<'py>(
    py: Python<'py>,
    given: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    guard(|| {
        let Concrete { fcm, mortar, rock, fraction, law } = self::options(given)?;
        let refused = |error: &meso_concrete::OutOfRange| wrong_value(format!("{} {}", error.key, error.fault()));
        let mix = match (fcm, mortar) {
            (Some(Fcm::Mpa(fcm_mpa)), None) => Mix { fcm_mpa, rock, fraction, law },
            (Some(Fcm::Class(class)), None) => Mix::parse(class.trim(), rock, fraction, law).map_err(|error| {
                wrong_value(format!("fcm {error}; a number is the mean strength in MPa, 38 for C30"))
            })?,
            (None, Some(Fcm::Mpa(mpa))) => Mix::of_mortar(mpa, rock, fraction, law).map_err(|error| refused(&error))?,
            (None, Some(Fcm::Class(class))) => {
                let class = class.trim();
                if !class.starts_with(['M', 'm']) {
                    let message = "is no mortar, as \"M40\" of 40 MPa; for_concrete takes a class of concrete";
                    return Err(wrong_value(format!("mortar {class:?} {message}")));
                }
                Mix::parse(class, rock, fraction, law).map_err(|error| wrong_value(format!("mortar {error}")))?
            }
            _ => return Err(wrong_value("give the concrete's mean strength or the mortar's, not both")),
        };
        let sourced = mix.materials().map_err(|error| refused(&error))?;
        tree::plain(py, &sourced.materials)
    })
}
