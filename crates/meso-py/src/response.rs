//! `Mesh.solve` and its result: the curve, figures and fields of a test.

use crate::arrays::{self, IndexArray, PointArray};
use crate::boundary::{guard, wrong_value};
use crate::pickle::{self, Fields};
use crate::run::{Broken, Terms, Watch, beside_python_keeping, beside_python_on, checked_threads, listener};
use crate::spec::options;
use crate::tree;
use crate::views::{call_view, cell_type, framing};
use crate::{effective, files};
use meso_ask::{FramePick, Giver};
use meso_concrete::thousands;
use meso_core::materials::Materials;
use meso_core::mesh::{Mesh, MeshOptions};
use meso_core::specimen::Specimen;
use meso_core::{Model, Watch as _};
use meso_files::Beside;
use meso_gpu::{Choice, DeviceName, Lease};
use meso_solve::results::{self, Outcome, Shooting, ShotFile, Snapshot, Source, TestSeconds, sample_of};
use meso_solve::{Frame, Observer, Response, Row, Run, SolveError, Test, TestKind};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::exceptions::{PyIndexError, PyUserWarning};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};
use serde::Deserialize;
use std::cell::RefCell;
use std::ffi::CString;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Everything that a test gave.
struct Tested {
    mesh: Arc<Mesh>,
    response: Response,
    source: Source,
    frames: Vec<Arc<Snapshot>>,
    /// The end; none of a run that diverged.
    last: Option<Arc<Snapshot>>,
    /// The moments before it that the page shows.
    taken: ShotFile,
    seconds: TestSeconds,
}

impl Tested {
    fn with_outcome<T>(&self, work: impl FnOnce(&Outcome) -> T) -> T {
        let moments: Vec<results::Moment> = self.frames.iter().map(|frame| frame.moment).collect();
        work(&Outcome {
            mesh: &self.mesh,
            response: &self.response,
            source: &self.source,
            frames: &moments,
            taken: &self.taken,
            last: self.last.as_deref(),
            seconds: self.seconds,
        })
    }
}

/// The test of a mesh: stress and strain, energies, figures and fields.
#[pyclass(name = "Response", module = "mesocrete", frozen)]
pub(crate) struct PyResponse(Arc<Tested>);

/// The fields of a moment of a test.
#[pyclass(name = "Frame", module = "mesocrete", frozen)]
pub(crate) struct PyFrame(pub(crate) Arc<Mesh>, pub(crate) Arc<Snapshot>);

/// Keywords of [`solve`].
pub(crate) struct Asked {
    /// The word that named the test; see [`WORDS`].
    word: &'static str,
    test: Test,
    materials: Materials,
    threads: Option<usize>,
    device: Option<Lease>,
}

/// Words for the kind of a test: Python's, and that of a TEST.toml.
const WORDS: [&str; 2] = ["test", "kind"];

/// The kind of a test by the word that gave it, which errors then have.
#[derive(Deserialize)]
struct Asking {
    #[serde(alias = "kind")]
    test: TestKind,
}

impl Asked {
    /// Reads and checks the keywords, before any work.
    pub(crate) fn new(
        (word, kind): (&'static str, Bound<'_, PyAny>),
        materials: Option<&Bound<'_, PyDict>>,
        threads: Option<&Bound<'_, PyAny>>,
        keywords: &Bound<'_, PyDict>,
    ) -> PyResult<Self> {
        let named = PyDict::new(keywords.py());
        named.set_item(word, kind)?;
        let Asking { test: kind } = options(Some(&named))?;
        let (given, materials): (Test, Materials) = (options(Some(keywords))?, options(materials)?);
        let mut test = Test { kind, ..given };
        let taken = test.take_tables(|name| Beside(Path::new("")).text(name));
        taken.map_err(|error| wrong(&error.into(), word))?;
        meso_solve::validate(&materials, &test).map_err(|error| wrong(&error, word))?;
        Ok(Self { word, test, materials, threads: threads.map(checked_threads).transpose()?, device: None })
    }

    /// The test of `mesh` on the device that `name` means; what its specimen cannot have is refused before any work.
    pub(crate) fn on(self, name: &str, mesh: &Mesh, specimen: &Specimen) -> PyResult<Self> {
        self.test.suits(specimen).map_err(|error| wrong(&error.into(), self.word))?;
        let device = name.parse::<Choice>().and_then(Choice::find).map_err(wrong_value)?;
        if device.is_some() {
            meso_solve::device::accept(mesh.kind).map_err(|error| wrong(&error, self.word))?;
        }
        Ok(Self { device, ..self })
    }
}

/// A named test: its name, or a dict as `Test` returns it, or as a TEST.toml has it.
#[derive(FromPyObject)]
pub(crate) enum Named<'py> {
    #[pyo3(annotation = "str")]
    Name(String),
    #[pyo3(annotation = "dict")]
    Options(Bound<'py, PyDict>),
}

/// The kind of a test, compression unless one is named, after the word that gave it; and its keywords, which those `given`
/// override.
///
/// # Errors
/// `ValueError` for a test that is named twice.
#[allow(clippy::type_complexity, reason = "a word, its value and the others")]
pub(crate) fn kind_of<'py>(
    py: Python<'py>,
    named: Option<Named<'py>>,
    given: Option<&Bound<'py, PyDict>>,
) -> PyResult<((&'static str, Bound<'py, PyAny>), Bound<'py, PyDict>)> {
    let (mut kinds, keywords) = match named {
        Some(Named::Name(name)) => (vec![("test", name.into_pyobject(py)?.into_any())], PyDict::new(py)),
        Some(Named::Options(options)) => (Vec::new(), options.copy()?),
        None => (Vec::new(), PyDict::new(py)),
    };
    let given = given.map_or_else(|| Ok(PyDict::new(py)), |given| given.copy())?;
    for (dict, word) in [&keywords, &given].into_iter().flat_map(|dict| WORDS.map(|word| (dict, word))) {
        if let Some(kind) = dict.get_item(word)? {
            dict.del_item(word)?;
            // None means: as if it were left out.
            kinds.extend((!kind.is_none()).then_some((word, kind)));
        }
    }
    if kinds.len() > 1 {
        let [test, kind] = WORDS;
        return Err(wrong_value(format!("{test} and {kind} are two words for one thing; leave one of them out")));
    }
    keywords.update(given.as_mapping())?;
    let usual = || ("test", PyString::new(py, "compression").into_any());
    Ok((kinds.pop().unwrap_or_else(usual), keywords))
}

impl<'py> Named<'py> {
    /// The test without a specimen.
    ///
    /// # Errors
    /// `ValueError` for values out of their ranges, and unknown keywords.
    pub(crate) fn test(self, py: Python<'py>) -> PyResult<Test> {
        let (kind, keywords) = kind_of(py, Some(self), None)?;
        Ok(Asked::new(kind, None, None, &keywords)?.test)
    }
}

/// A dict of `Test`, whose names and values are checked.
#[pyfunction(name = "_checked_test")]
pub(crate) fn checked_test<'py>(test: Bound<'py, PyDict>) -> PyResult<Bound<'py, PyDict>> {
    guard(|| {
        Named::Options(test.clone()).test(test.py())?;
        Ok(test)
    })
}

/// A keyword has the name of the test's value; the kind has the `word` that gave it.
fn wrong(error: &SolveError, word: &str) -> PyErr {
    wrong_value(match error {
        SolveError::Value(wrong) if wrong.table == "test" && wrong.key == "kind" => format!("{word} {}", wrong.fault()),
        SolveError::Value(wrong) if wrong.table == "test" => format!("{} {}", wrong.key, wrong.fault()),
        _ => error.to_string(),
    })
}

/// A mesh with its origin.
pub(crate) struct Meshed {
    pub(crate) mesh: Arc<Mesh>,
    pub(crate) model: Arc<Model>,
    pub(crate) options: MeshOptions,
}

/// The doubt about a device that cannot keep the promise, with its remedy.
pub(crate) fn device_doubt(device: &DeviceName) -> Option<String> {
    let check = Giver::Flags.option("check");
    device.warning().map(|text| format!("{text}; `mesocrete devices {check}` measures the difference"))
}

/// Tests a mesh beside Python.
pub(crate) fn solve(
    py: Python<'_>,
    meshed: Meshed,
    asked: Asked,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<PyResponse> {
    let progress = listener(py, progress)?;
    let (threads, word) = (asked.threads, asked.word);
    warn_of(py, &meshed)?;
    let doubt = asked.device.as_ref().and_then(|lease| device_doubt(&lease.device));
    doubt.map_or(Ok(()), |text| warn(py, text))?;
    let response = |tested| PyResponse(Arc::new(tested));
    let tested = beside_python_keeping(py, Terms::of(threads), progress.as_ref(), None, move |watch| {
        watch.stops_soon();
        test(&meshed, &asked, watch)
    });
    match tested {
        Ok(tested) => {
            let tested = tested.map_err(|error| wrong(&error, word))?;
            let fast = tested.response.result.dynamic_before_the_peak();
            fast.map_or(Ok(()), |text| warn(py, text))?;
            Ok(response(tested))
        }
        Err(Broken { error, kept: Some(Ok(tested)) }) => {
            error.value(py).setattr("response", response(tested))?;
            Err(error)
        }
        Err(Broken { error, .. }) => Err(error),
    }
}

/// Faults of the mesh are `UserWarning`s at the caller's line, before the first step.
fn warn_of(py: Python<'_>, Meshed { mesh, model, options }: &Meshed) -> PyResult<()> {
    let (mesh, model, options) = (Arc::clone(mesh), Arc::clone(model), options.clone());
    let faults = beside_python_on(py, None, None, None, move |_| {
        let sample = sample_of(&mesh, &model, &options);
        let flags = sample.flags();
        if flags.is_empty() { String::new() } else { [flags, sample.doubts()].concat().join("; ") }
    })?;
    if faults.is_empty() { Ok(()) } else { warn(py, faults) }
}

/// A `UserWarning` at the caller's line.
fn warn(py: Python<'_>, text: String) -> PyResult<()> {
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &CString::new(text)?, 1)
}

fn test(Meshed { mesh, model, options }: &Meshed, asked: &Asked, watch: &Watch) -> Result<Tested, SolveError> {
    let begun = watch.seconds();
    // Progress is asked for while the test is still prepared.
    watch.reached(0.0, asked.test.strain());
    let mut run = Run::new(sample_of(mesh, model, options), &asked.materials, &asked.test)?;
    if let Some(lease) = &asked.device {
        meso_gpu::attach(&mut run, &lease.device)?;
    }
    watch.keeps_what_it_has();
    let watching =
        Watching { watch, strain: asked.test.strain(), frames: RefCell::default(), shooting: Shooting::default() };
    let response = run.to_end(watch, &watching);
    let last = Snapshot::last(&run, &response.result.ended).map(Arc::new);
    let solve = watch.seconds() - begun;
    let seconds = TestSeconds { solve, total: solve, ..TestSeconds::default() };
    let (taken, frames) = (watching.shooting.taken(), watching.frames.into_inner());
    Ok(Tested { mesh: Arc::clone(mesh), response, source: Source::of(model, options), frames, last, taken, seconds })
}

/// Tells Python how far the test is, and gathers its frames.
struct Watching<'a> {
    watch: &'a Watch,
    strain: f64,
    frames: RefCell<Vec<Arc<Snapshot>>>,
    shooting: Shooting,
}

impl Observer for Watching<'_> {
    fn row(&self, row: &Row, _: f64) {
        self.watch.reached(row.strain, self.strain);
    }

    fn wants(&self, row: &Row) -> bool {
        self.shooting.wants(row)
    }

    fn moment(&self, frame: &Frame) {
        self.shooting.take(frame);
    }

    fn frame(&self, frame: &Frame) {
        self.frames.borrow_mut().push(Arc::new(Snapshot::of(frame)));
    }
}

#[pymethods]
impl PyResponse {
    /// The curve, row by row: a dict of arrays, float64, by the names of `curve.csv`; copies.
    ///
    /// `strain` and `stress_mpa` are positive in the test's own sense; `kinetic`, `internal`, `external`, `friction_work`,
    /// `hourglass` and `dissipated` are energies in mJ.
    #[getter]
    fn curve<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let curve = PyDict::new(py);
        for (column, name) in Row::COLUMNS.into_iter().enumerate() {
            let values = self.0.response.curve.iter().map(|row| row.values()[column]).collect();
            curve.set_item(name, PyArray1::from_vec(py, values))?;
        }
        let (extra, rows) = (&self.0.response.extra, self.0.response.curve.len());
        for (column, name) in extra.names.iter().enumerate() {
            let values = (0..rows).map(|row| extra.row(row)[column]).collect();
            curve.set_item(name, PyArray1::from_vec(py, values))?;
        }
        Ok(curve)
    }

    /// The curve as `curve` has it, or as a frame: `table("pandas")`, `table("polars")`.
    ///
    /// Raises
    /// ------
    /// ImportError
    ///     Where the library is not installed.
    #[pyo3(signature = (frame=None))]
    fn table<'py>(&self, py: Python<'py>, frame: Option<&Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        let framed = framing(py, frame)?;
        framed.call1((self.curve(py)?,))
    }

    /// The figures of the test, as in `result.json`: a dict; a copy.
    #[getter]
    fn result<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let figures = self.0.with_outcome(results::figures);
        tree::to_python(py, &figures.map_err(|error| wrong_value(error.to_string()))?)
    }

    /// The frames that were asked for, in their order: a list.
    #[getter]
    fn frames(&self) -> Vec<PyFrame> {
        let tested = &self.0;
        tested.frames.iter().map(|frame| PyFrame(Arc::clone(&tested.mesh), Arc::clone(frame))).collect()
    }

    /// The end of the test; None where it diverged.
    #[getter]
    fn last(&self) -> Option<PyFrame> {
        self.0.last.as_ref().map(|last| PyFrame(Arc::clone(&self.0.mesh), Arc::clone(last)))
    }

    /// Draws stress over strain with the peak; returns the matplotlib axes (extra `plot`).
    ///
    /// `ax` are axes to draw on; further `options` go to `Axes.plot`.
    #[pyo3(signature = (**options), text_signature = "($self, *, ax=None, **options)")]
    fn plot<'py>(slf: &Bound<'py, Self>, options: Option<&Bound<'py, PyDict>>) -> PyResult<Bound<'py, PyAny>> {
        call_view("plot_response", slf, options)
    }

    /// A frame, by its place in `frames`, or the end, as a PyVista grid with all fields (extra `plot`).
    ///
    /// Raises
    /// ------
    /// IndexError
    ///     Where there is no such frame; ask for `frames` when solving.
    #[pyo3(signature = (frame=None))]
    fn to_pyvista<'py>(&self, py: Python<'py>, frame: Option<isize>) -> PyResult<Bound<'py, PyAny>> {
        let frames = &self.0.frames;
        let found = match frame {
            None => self.0.last.as_ref(),
            Some(place) if place < 0 => frames.len().checked_add_signed(place).and_then(|place| frames.get(place)),
            Some(place) => frames.get(place as usize),
        };
        let found = found.ok_or_else(|| {
            let asked = frame.map_or("the end".to_owned(), |place| place.to_string());
            PyIndexError::new_err(format!("there is no frame {asked}; this test has {}", frames.len()))
        })?;
        let frame = Bound::new(py, PyFrame(Arc::clone(&self.0.mesh), Arc::clone(found)))?;
        call_view("frame_to_pyvista", &frame, None)
    }

    /// Effective diffusivity, conductivity, permeability or stiffness of the cracked specimen in a frame, with its error.
    ///
    /// Cracks are layers of the opening that the frame has, on the mesh of the test. Each axis has given values at its ends;
    /// the other sides are insulated.
    ///
    /// Parameters
    /// ----------
    /// frame : {"peak", "last", "all"}, int or float
    ///     The frame of the largest stress, the end, or all frames; a frame's number from 1; or the strain that it is nearest to.
    /// what : {"diffusivity", "conductivity", "permeability", "stiffness", "all"}
    ///     The property. For all, `phases` has a mapping for each, and a list of four is returned. Stiffness are Young's moduli
    ///     between smooth ends, with which the specimen unloads: `youngs_modulus_mpa` and `error`, along x, y, z.
    /// phases : mapping, optional
    ///     Values of `mortar`, `aggregate`, `itz`, `void`, `fibre`; see `Packing.effective`.
    /// axes : str
    ///     Axes of the gradient, some of x, y, z; each takes a solution.
    /// crack_diffusivity : float, optional
    ///     Diffusivity of what fills the cracks, in the unit of the phases; 200 times the mortar's if omitted.
    /// crack_conductivity : float, optional
    ///     Conductivity of what fills the cracks, W/(m K); 0.6, of water, if omitted.
    /// crack_roughness : float, optional
    ///     Permeability of the cracks over that of smooth ones, whose opening w gives w^2/12; 1 if omitted.
    /// tolerance : float, optional
    ///     Error of the equations, over the result; 1e-9 if omitted.
    /// progress : bool or callable, optional
    ///     True shows a bar; a callable is called as `progress(done, total)`, from 0 to 1. When it returns False,
    ///     the work ends with a `RuntimeError`.
    ///
    /// Returns
    /// -------
    /// Effective
    ///     See `Packing.effective`; it also has `frame`, `strain` and `stress_mpa`. Of all frames, a list.
    ///
    /// Raises
    /// ------
    /// ValueError, TypeError
    ///     Names the option, its value and the accepted range; a test without frames, or without such a one.
    /// RuntimeError
    ///     Where the equations do not converge.
    #[pyo3(signature = (frame=None, what="diffusivity", *, phases=None, axes="xyz", crack_diffusivity=None, crack_conductivity=None, crack_roughness=None, tolerance=None, progress=None), text_signature = "($self, frame=\"peak\", what=\"diffusivity\", *, phases=None, axes=\"xyz\", crack_diffusivity=None, crack_conductivity=None, crack_roughness=None, tolerance=None, progress=None)")]
    #[allow(clippy::too_many_arguments, reason = "keywords of Python")]
    fn effective<'py>(
        &self,
        py: Python<'py>,
        frame: Option<&Bound<'py, PyAny>>,
        what: &str,
        phases: Option<&Bound<'py, PyAny>>,
        axes: &str,
        crack_diffusivity: Option<&Bound<'py, PyAny>>,
        crack_conductivity: Option<&Bound<'py, PyAny>>,
        crack_roughness: Option<&Bound<'py, PyAny>>,
        tolerance: Option<&Bound<'py, PyAny>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let given = [
            ("frame", frame),
            ("phases", phases),
            ("crack_diffusivity", crack_diffusivity),
            ("crack_conductivity", crack_conductivity),
            ("crack_roughness", crack_roughness),
            ("tolerance", tolerance),
        ];
        let ask = effective::asked(&[("what", what), ("axes", axes)], &given)?;
        let Tested { mesh, response, frames, last, .. } = &*self.0;
        // The end needs no frames that were asked for.
        let end: Vec<_> = last.iter().map(Arc::clone).collect();
        let frames = if ask.frame == Some(FramePick::Last) { &end } else { frames };
        effective::in_frames(py, &ask, (response, mesh), frames, progress)
    }

    /// Writes `curve.csv`, `result.json`, `frames.pvd` with a `.vtu` for each frame, and `result.html`, all or none.
    ///
    /// Parameters
    /// ----------
    /// folder : path
    ///     Where they go; made where it is not there.
    /// overwrite : bool
    ///     Whether results that are there already are replaced.
    ///
    /// Raises
    /// ------
    /// OSError
    ///     Where they cannot be written, or are there already.
    #[pyo3(signature = (folder, *, overwrite=true))]
    fn write(&self, py: Python<'_>, folder: PathBuf, overwrite: bool) -> PyResult<()> {
        guard(|| {
            let tested = Arc::clone(&self.0);
            beside_python_on(py, None, None, None, move |watch| {
                tested.with_outcome(|outcome| files::write_results(outcome, &tested.frames, &folder, overwrite, watch))
            })?
        })
    }

    fn __repr__(&self) -> String {
        let headline = self.0.response.result.headline();
        let (rows, frames) = (thousands(self.0.response.curve.len()), self.0.frames.len());
        let flags: String = self.0.response.result.flags.iter().map(|flag| format!(", {flag}")).collect();
        format!("Response({headline}{flags}, {rows} rows, {frames} frames)")
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let restore = py.import("mesocrete._mesocrete")?.getattr("_restore_response")?;
        let Tested { mesh, response, source, frames, last, taken, seconds } = &*self.0;
        let rows = response.curve.iter().flat_map(Row::values).collect();
        let (rows, extra) = (PyArray1::from_vec(py, rows), PyArray1::from_slice(py, &response.extra.values));
        let fields = |frame: &Arc<Snapshot>| pickle::of_snapshot(py, frame);
        let frames = frames.iter().map(fields).collect::<PyResult<Vec<_>>>()?;
        let page = (pickle::json(taken)?, pickle::json(seconds)?);
        let figures = pickle::json(&response.result)?;
        let last = last.as_ref().map(fields).transpose()?;
        let contents =
            (pickle::of_mesh(py, mesh)?, pickle::of_source(source)?, rows, extra, figures, frames, last, page);
        (restore, contents).into_pyobject(py)
    }

    /// HTML for notebooks: the curve beside its figures.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        call_view("response_to_html", slf, None)
    }

    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }
}

#[pymethods]
impl PyFrame {
    /// Mean axial strain, positive in the test's sense.
    #[getter]
    fn strain(&self) -> f64 {
        self.1.moment.strain
    }

    /// Stress of the curve's latest row, MPa, positive in the test's sense.
    #[getter]
    fn stress_mpa(&self) -> f64 {
        self.1.moment.stress_mpa
    }

    /// Time in the test, s.
    #[getter]
    fn time_s(&self) -> f64 {
        self.1.moment.time_s
    }

    /// Displacement of every node against the lower plate: ndarray, shape (n, 3), float32, mm; a copy.
    #[getter]
    fn displacement<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        rows(py, &self.1.displacement)
    }

    /// Stress in every cell, xx yy zz xy yz zx: ndarray, shape (m, 6), float32, MPa; tension is positive; a copy.
    #[getter]
    fn stress<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        rows(py, &self.1.stress)
    }

    /// Share of its stiffness that every cell has lost, 0 to 1: ndarray, shape (m,), float32; a copy.
    #[getter]
    fn damage<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        PyArray1::from_slice(py, &self.1.damage)
    }

    /// Damage in tension, 0 to 1: ndarray, shape (m,), float32; a copy.
    #[getter]
    fn damage_tension<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        PyArray1::from_slice(py, &self.1.tension)
    }

    /// Damage in compression, 0 to 1: ndarray, shape (m,), float32; a copy.
    #[getter]
    fn damage_compression<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        PyArray1::from_slice(py, &self.1.compression)
    }

    /// Opening of the crack in every cell: ndarray, shape (m,), float32, mm; a copy.
    #[getter]
    fn crack_opening_mm<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        PyArray1::from_slice(py, &self.1.opening_mm)
    }

    /// Strain of the cracks in every cell, xx yy zz xy yz zx: ndarray, shape (m, 6), float32; openings over the width of the
    /// band, along the cracks' normals; a copy.
    #[getter]
    fn crack_strain<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        rows(py, &self.1.crack_strain)
    }

    /// Share of the stiffness with which every cell unloads, 0 to 1: ndarray, shape (m,), float32; a copy.
    #[getter]
    fn stiffness_left<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        PyArray1::from_slice(py, &self.1.stiffness_left)
    }

    /// Factor of the strengths in every cell, 1 where they do not scatter: ndarray, shape (m,), float32; a copy.
    #[getter]
    fn strength_factor<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        let (cells, own) = (self.0.cell_count(), &self.1.strength);
        if own.is_empty() { PyArray1::from_vec(py, vec![1.0; cells]) } else { PyArray1::from_slice(py, own) }
    }

    /// Phase of every cell of the mesh: ndarray, shape (m,), uint8; 0 mortar, 1 ITZ, 2 aggregate, 4 fibre, 5 on the packing's own; a copy.
    #[getter]
    fn phase<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u8>> {
        PyArray1::from_vec(py, self.0.phase.iter().map(|phase| phase.number()).collect())
    }

    /// Id of the aggregate or fibre every cell of the mesh belongs to, -1 in the mortar: ndarray, shape (m,), int64; a copy.
    #[getter]
    fn aggregate<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        arrays::from_ids(py, self.0.ids())
    }

    /// Points, cells and the VTK type of the cells, for `to_pyvista`.
    fn _mesh<'py>(&self, py: Python<'py>) -> PyResult<(PointArray<'py>, IndexArray<'py>, &'static str)> {
        let mesh = &self.0;
        let cells = arrays::from_indices(py, mesh.cells.iter().copied(), mesh.kind.nodes())?;
        Ok((arrays::from_points(py, &mesh.points)?, cells, cell_type(mesh.kind)))
    }

    fn __repr__(&self) -> String {
        format!("Frame(strain {:.5}, {:.2} MPa)", self.strain(), self.stress_mpa())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let restore = py.import("mesocrete._mesocrete")?.getattr("_restore_frame")?;
        let Self(mesh, fields) = self;
        (restore, (pickle::of_mesh(py, mesh)?, pickle::of_snapshot(py, fields)?)).into_pyobject(py)
    }

    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }
}

fn rows<'py, const N: usize>(py: Python<'py>, values: &[[f32; N]]) -> PyResult<Bound<'py, PyArray2<f32>>> {
    PyArray1::from_slice(py, values.as_flattened()).reshape([values.len(), N])
}

/// Unpickles a `Frame`.
#[pyfunction(name = "_restore_frame")]
pub(crate) fn restore_frame(py: Python<'_>, mesh: &Bound<'_, PyTuple>, fields: Fields<'_>) -> PyResult<PyFrame> {
    arrays::load_numpy(py)?;
    guard(|| {
        let mesh = pickle::to_mesh(mesh)?;
        let fields = pickle::to_snapshot(&mesh, fields)?;
        Ok(PyFrame(Arc::new(mesh), Arc::new(fields)))
    })
}

/// Unpickles a `Response`: its mesh and source, rows and further columns of its curve, its figures, frames, end and shots.
#[pyfunction(name = "_restore_response")]
#[expect(clippy::too_many_arguments, reason = "the contents of a pickle")]
pub(crate) fn restore_response(
    py: Python<'_>,
    mesh: &Bound<'_, PyTuple>,
    source: (String, u64, f64, String),
    rows: PyReadonlyArray1<'_, f64>,
    extra: PyReadonlyArray1<'_, f64>,
    figures: &str,
    frames: Vec<Fields<'_>>,
    last: Option<Fields<'_>>,
    page: (String, String),
) -> PyResult<PyResponse> {
    arrays::load_numpy(py)?;
    guard(|| {
        let mesh = pickle::to_mesh(mesh)?;
        let fields = |fields| pickle::to_snapshot(&mesh, fields).map(Arc::new);
        let tested = Tested {
            response: pickle::to_response(&rows, &extra, figures)?,
            source: pickle::to_source(source)?,
            frames: frames.into_iter().map(fields).collect::<PyResult<_>>()?,
            last: last.map(fields).transpose()?,
            taken: pickle::from_json(&page.0)?,
            seconds: pickle::from_json(&page.1)?,
            mesh: Arc::new(mesh),
        };
        Ok(PyResponse(Arc::new(tested)))
    })
}
