//! `Mesh`: points, cells and the phase of every cell.

use crate::arrays;
use crate::boundary::{accept_in_memory, guard, mesh_error, wrong_type, wrong_value};
use crate::files;
use crate::pickle;
use crate::response::{self, Asked, Meshed, Named, PyResponse};
use crate::run::{Plan, Watch, beside_python, in_stages, listener};
use crate::spec::options;
use crate::tree::plain;
use crate::views::{call_view, cell_type, screenshot_of};
use meso_ask::footing::{self, Footing};
use meso_ask::{Giver, deck_refusal};
use meso_concrete::thousands;
use meso_core::Model;
use meso_core::export::abaqus::{Analysis, DeckOptions};
use meso_core::materials::Materials;
use meso_core::mesh::conforming::Surfaces;
use meso_core::mesh::figures::{MassScaling, QualityReport};
use meso_core::mesh::{Mesh, MeshOptions, MeshTable, PhaseOff, PhaseVolumes, Purpose, Tools, VolumeMesher, figures};
use meso_core::watch::Stage;
use meso_gmsh::Gmsh;
use meso_solve::{Sample, TrialError};
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::ffi::CString;
use std::path::PathBuf;
use std::sync::Arc;

/// A mesh of a packing.
#[pyclass(name = "Mesh", module = "mesocrete", frozen, eq)]
#[derive(Clone)]
pub(crate) struct PyMesh(pub(crate) Arc<Mesh>, pub(crate) Arc<Model>, pub(crate) MeshOptions);

/// By the mesh itself, whatever packing it is of.
impl PartialEq for PyMesh {
    fn eq(&self, other: &Self) -> bool {
        self.0 == other.0
    }
}

/// The options that Python's keywords name; `itz=None` means no ITZ.
pub(crate) fn table(
    method: Option<&Bound<'_, PyAny>>,
    element_size: Option<&Bound<'_, PyAny>>,
    keywords: &Bound<'_, PyDict>,
) -> PyResult<MeshTable> {
    let word = element_size.and_then(|size| size.extract::<&str>().ok()).filter(|word| *word != "auto");
    if let Some(word) = word {
        return Err(wrong_type(format!("element_size is {word:?}; it must be a number, mm, or auto")));
    }
    if element_size.is_some() && keywords.contains("element_size_mm")? {
        return Err(wrong_value("element_size and element_size_mm are two words for one thing; leave one of them out"));
    }
    for (key, value) in [("method", method), ("element_size_mm", element_size)] {
        value.map_or(Ok(()), |value| keywords.set_item(key, value))?;
    }
    if keywords.get_item("itz")?.is_some_and(|itz| itz.is_none()) {
        keywords.set_item("itz", "none")?;
    }
    options(Some(keywords))
}

/// Use of a mesh by Python's `for_test`.
pub(crate) fn purpose(for_test: bool) -> Purpose {
    if for_test { Purpose::Test } else { Purpose::Mesh }
}

/// Meshes `model` with the options that are asked for.
///
/// # Errors
/// A phase far off its volume is an error unless it is accepted.
pub(crate) fn build(
    py: Python<'_>,
    model: Arc<Model>,
    progress: Option<&Bound<'_, PyAny>>,
    asked: MeshTable,
    purpose: Purpose,
    accept_phase_error: bool,
) -> PyResult<PyMesh> {
    let progress = listener(py, progress)?;
    let of = Arc::clone(&model);
    let options = beside_python(py, None, move |watch| footing::options(&asked, purpose, &of.spec, false, watch))?;
    let options = options.map_err(mesh_error)?.for_bodies(&model.aggregates);
    accept_in_memory("the mesh", options.bytes(&model.spec.specimen), "element_size")?;
    let gmsh = gmsh(py)?;
    let of = Arc::clone(&model);
    let footing = Footing { purpose, options: options.clone(), accepts_phase_error: accept_phase_error };
    let built = in_stages(py, progress.as_ref(), Plan::new(&[(Stage::Mesh, 1.0)], Some(1.0)), move |watch| {
        let stops = || !watch.goes_on();
        let gmsh = gmsh.until(&stops);
        let fill = |surfaces: &Surfaces| {
            watch.has_files();
            gmsh.fill(surfaces)
        };
        footing.mesh(&model, &Tools { gmsh: &fill, watch }).map(|(mesh, _)| mesh)
    })?;
    built.map(|mesh| PyMesh(Arc::new(mesh), of, options)).map_err(mesh_error)
}

/// gmsh for conforming meshes: this Python's module, else the program. It runs in a process of its own either way.
pub(crate) fn gmsh(py: Python<'_>) -> PyResult<Gmsh> {
    let found = py.import("importlib.util")?.call_method1("find_spec", ("gmsh",))?;
    let python: Option<PathBuf> = py.import("sys")?.getattr("executable")?.extract()?;
    Ok(match python {
        Some(python) if !found.is_none() => Gmsh::python_module(python),
        _ => Gmsh::program("gmsh"),
    })
}

#[pymethods]
impl PyMesh {
    /// Node positions: ndarray, shape (n, 3), float64, mm; a copy.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::from_points(py, &self.0.points)
    }

    /// Node indices of every cell, in the order of Abaqus and VTK: ndarray, shape (m, nodes), int64; a copy.
    #[getter]
    fn cells<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        arrays::from_indices(py, self.0.cells.iter().copied(), self.0.kind.nodes())
    }

    /// The cells' shape, by its name in meshio: "tetra", "tetra10" or "hexahedron".
    #[getter]
    fn cell_type(&self) -> &'static str {
        cell_type(self.0.kind)
    }

    /// Phase of every cell: ndarray, shape (m,), uint8; 0 mortar, 1 ITZ, 2 aggregate, 4 fibre, 5 on the packing's own; a copy.
    #[getter]
    fn phase<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u8>> {
        PyArray1::from_vec(py, self.0.phase.iter().map(|phase| phase.number()).collect())
    }

    /// Id of the aggregate or fibre every cell belongs to, -1 in the mortar: ndarray, shape (m,), int64; a copy.
    #[getter]
    fn aggregate<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        arrays::from_ids(py, self.0.ids())
    }

    /// Volume of every phase in the mesh, mm3: a dict with the keys `aggregate`, `itz`, `mortar`, and `fibre` where
    /// there are fibres.
    fn volumes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        guard(|| {
            let mesh = Arc::clone(&self.0);
            plain(py, &beside_python(py, None, move |_| PhaseVolumes::of_mesh(&mesh))?)
        })
    }

    /// Zero-thickness cohesive elements, the aggregate side's face and then the nodes over it, counter-clockwise seen
    /// from outside the aggregate: ndarray, shape (k, 6 or 8), int64; a copy. Empty unless `itz="cohesive"`.
    #[getter]
    fn cohesive<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        arrays::from_indices(py, self.0.cohesive.iter().copied(), 2 * self.0.kind.faces()[0].len())
    }

    /// Id of the aggregate below every cohesive element: ndarray, shape (k,), int64.
    #[getter(_cohesive_aggregate)]
    fn cohesive_aggregate<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        arrays::from_ids(py, self.0.cohesive_owner.iter().map(|&owner| self.0.id(owner)))
    }

    /// Decisions of the builder, and how often it took each: gaps closed, ITZ thinned; a dict.
    #[getter]
    fn notes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.0.notes)
    }

    /// The worst cells, a histogram of smallest dihedral angles, the cells below 8 degrees (`bad_cells`), the stable
    /// time step that the default materials allow, the phases' volumes (`volumes_mm3`) against the exact ones
    /// (`exact_volumes_mm3`), and how far the interface nodes lie from the aggregates' surfaces: a dict.
    ///
    /// Pairs are (value, index of the cell); `interface_distance` has of the nodes where aggregates meet other
    /// materials how many there are (`nodes`), how many lie on none of the surfaces that meet there (`off`) and how
    /// far from the nearest one (`rms_mm`, `max_mm`); `joined` of them close a gap, and their distances from the surface
    /// beyond it are `joined_rms_mm` and `joined_max_mm`.
    fn quality<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        guard(|| {
            let (mesh, model) = (Arc::clone(&self.0), Arc::clone(&self.1));
            let of =
                move |_: &Watch| QualityReport::of(&mesh, &model.bodies(), &model.spec.specimen, &Materials::default());
            plain(py, &beside_python(py, None, of)?)
        })
    }

    /// The mass that explicit dynamics in steps of `time_step_s` seconds takes, with the default materials: a dict of
    /// `time_step_s`, `factor` (scaled mass over the mesh's own) and `phases`, a list of dicts of `phase`,
    /// `elements`, `scaled` (share of them whose own step is shorter), `factor`, `shortest_step_s` and `mass_t`.
    #[pyo3(signature = (time_step_s=5e-7))]
    fn mass_scaling<'py>(&self, py: Python<'py>, time_step_s: f64) -> PyResult<Bound<'py, PyAny>> {
        guard(|| {
            if !(time_step_s > 0.0 && time_step_s.is_finite()) {
                return Err(wrong_value(format!("time_step_s is {time_step_s}; it must be a positive number")));
            }
            let mesh = Arc::clone(&self.0);
            let of = move |_: &Watch| MassScaling::of(&mesh, &Materials::default(), time_step_s);
            plain(py, &beside_python(py, None, of)?)
        })
    }

    /// The cells whose smallest dihedral angle lies below `degrees`, as indices: ndarray, int64.
    fn bad_cells<'py>(&self, py: Python<'py>, degrees: f64) -> PyResult<Bound<'py, PyArray1<i64>>> {
        guard(|| {
            let mesh = Arc::clone(&self.0);
            let bad = beside_python(py, None, move |_| {
                figures::CellQuality::below(&figures::CellQuality::of_cells(&mesh), degrees)
            })?;
            Ok(PyArray1::from_vec(py, bad.into_iter().map(|cell| cell as i64).collect()))
        })
    }

    /// Writes the mesh, whole or not at all; the extension names the format.
    ///
    /// Parameters
    /// ----------
    /// path : path
    ///     `.inp`, `.k`, `.cdb`, `.vtu`, `.msh`, `.pvtu` with its pieces `name_0.vtu`, ... beside it, or `.xdmf` with its `.h5` (through meshio and h5py, the extra `mesh`).
    /// overwrite : bool
    ///     Whether a file that is there already is replaced.
    /// compress : bool
    ///     Whether the data of a `.vtu` are compressed.
    /// test : str or dict, optional
    ///     A named test, a dict as `Test` returns it, or one of the keys of a TEST.toml: the deck then has its supports and loads (docs/decks.md).
    /// **deck
    ///     Contents of an `.inp` or a `.k` besides the mesh: `geometry_only`, `reduced_integration`, `periodic_equations` (booleans),
    ///     `with_damage`, `allow_joined`, `analysis` ("none", "elastic", the name of a test, and "striker" in a `.k`), `lsdyna_law`, `frames`, `impact_speed_mm_per_s`,
    ///     `heading` (a list), `materials` (a dict; absent values keep their illustrative defaults). `strain`, `friction`, `duration_s` and `time_increment_s` are laid over the test's own.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     For an extension that names no mesh format, and for options that a deck cannot have; the message lists the accepted ones.
    /// OSError
    ///     Where the file cannot be written.
    #[pyo3(signature = (path, *, overwrite=true, compress=false, test=None, **deck))]
    fn write(
        slf: &Bound<'_, Self>,
        path: PathBuf,
        overwrite: bool,
        compress: bool,
        test: Option<Named<'_>>,
        deck: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        guard(|| {
            let keys = deck.map_or(0, |deck| deck.len()) + usize::from(test.is_some());
            let (mesh, mut deck) = (Arc::clone(&slf.get().0), options::<DeckOptions>(deck)?);
            let spec = &slf.get().1.spec;
            let named = if test.is_some() { "test" } else { "analysis" };
            if let Some(test) = test.map(|named| named.test(slf.py())).transpose()? {
                if deck.analysis != Analysis::None {
                    return Err(wrong_value("analysis and test are two words for one thing; leave one of them out"));
                }
                deck.analysis = test.into();
            }
            files::check_deck(&mesh, &deck, &path, keys > 0, compress)?;
            if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("xdmf")) {
                files::accept_free(&[&path, &path.with_extension("h5")], overwrite)?;
                let options = PyDict::new(slf.py());
                options.set_item("path", path)?;
                return call_view("write_xdmf", slf, Some(&options)).map(drop);
            }
            let asked = deck.clone();
            let wrong = |error: TrialError| wrong_value(deck_refusal(&asked, named, &error, Giver::Keywords));
            deck.suits(&spec.specimen).map_err(wrong)?;
            deck.load(&Sample::of(&mesh, &spec.specimen, &slf.get().2)).map_err(wrong)?;
            let model = &slf.get().1;
            let exact = PhaseVolumes::exact_for(&mesh, &model.bodies(), &spec.specimen);
            if deck.heading.is_empty() {
                let meshed = PhaseVolumes::of_bodies(&mesh);
                let off = exact.and_then(|exact| PhaseOff::between(&meshed, &exact, spec.specimen.volume()));
                deck.head(spec, &slf.get().2, off.is_some_and(|off| !off.is_accepted()));
            }
            for doubt in deck.doubts(&mesh, exact.as_ref()) {
                PyErr::warn(slf.py(), &slf.py().get_type::<PyUserWarning>(), &CString::new(doubt)?, 1)?;
            }
            beside_python(slf.py(), None, move |watch| {
                files::write_mesh(&mesh, &deck, &path, overwrite, compress, watch)
            })?
        })
    }

    /// Tests the specimen, and returns its curve, figures and fields.
    ///
    /// Parameters
    /// ----------
    /// test : str or dict
    ///     A named test of docs/tests.md: "compression", "tension", "triaxial", "biaxial", "cyclic", "splitting", "bending", "four-point", "shear" or "expansion"; or one of `Test` or a dict of the keys of a TEST.toml, whose values further keywords override.
    /// friction : float
    ///     Coulomb's coefficient between plates and specimen in compression.
    /// strain : float, optional
    ///     Mean axial strain at the end; 0.005 in compression, 0.0005 in tension.
    /// law : str, optional
    ///     The law of mortar and ITZ; aggregates and fibres are elastic.
    /// materials : dict, optional
    ///     The `[materials]` of a deck; absent values keep their illustrative defaults.
    /// frames : int
    ///     Moments, evenly over the strain, whose fields are kept in `Response.frames`.
    /// threads : int, optional
    ///     All cores when absent. It changes the time, never the result.
    /// device : str
    ///     What takes the steps: "cpu", "gpu" (the first that there is), "cuda:N" or "opencl:N"; the results are the same bytes.
    /// progress : bool or callable, optional
    ///     True shows a bar. A callable is called about 25 times a second as `progress(strain, target)`; when it returns False, the test stops, and the
    ///     curve so far is returned.
    /// **options
    ///     `duration_s`, `time_step_s`, `control`, `ramp`, `rows`, `smoothing`, `hourglass`, `interface`: see docs/solve.md. `pressure_mpa`, `stress_ratio`,
    ///     `strip_mm`, `span_mm`, `turns`, `supports`, `gauges`, `expansion`: see docs/tests.md.
    ///
    /// Returns
    /// -------
    /// Response
    ///     Also of a test that was stopped or diverged: `result["ended"]` says so, and the curve is valid until there.
    ///
    /// Warns
    /// -----
    /// UserWarning
    ///     Before the first step, where a phase of the mesh is more than 10 % off its exact volume, or aggregates share nodes.
    ///     After the last, where the test was not quasi-static before its peak.
    ///
    /// Raises
    /// ------
    /// ValueError, TypeError
    ///     For values that cannot be and for a mesh without faces for the plates or of second order, before any step.
    /// KeyboardInterrupt
    ///     On Ctrl-C, within 0.5 s on meshes of moderate size. Its attribute `response` is the test so far; it has none
    ///     where the first step was not yet taken, or after a second Ctrl-C.
    #[pyo3(
        signature = (test=None, *, materials=None, threads=None, device="cpu", progress=None, **options),
        text_signature = "($self, test='compression', *, materials=None, threads=None, device='cpu', progress=None, **options)"
    )]
    #[allow(clippy::too_many_arguments, reason = "keywords of Python")]
    fn solve(
        slf: &Bound<'_, Self>,
        test: Option<Named<'_>>,
        materials: Option<&Bound<'_, PyDict>>,
        threads: Option<&Bound<'_, PyAny>>,
        device: &str,
        progress: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyResponse> {
        guard(|| {
            let (kind, keywords) = response::kind_of(slf.py(), test, options)?;
            let asked = Asked::new(kind, materials, threads, &keywords)?;
            let PyMesh(mesh, model, made) = slf.get().clone();
            let asked = asked.on(device, &mesh, &model.spec.specimen)?;
            response::solve(slf.py(), Meshed { mesh, model, options: made }, asked, progress)
        })
    }

    /// The mesh as a PyVista unstructured grid (needs the extra `plot`).
    fn to_pyvista<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        call_view("mesh_to_pyvista", slf, None)
    }

    /// Shows the mesh by phase (needs the extra `plot`).
    ///
    /// Parameters
    /// ----------
    /// cut : str or pair, optional
    ///     "z", or ("z", 30.0) in mm: cuts the mesh at a plane and shows the phases there. None shows the whole mesh, as
    ///     `phases` do without a cut.
    /// phases : sequence of str, optional
    ///     Shows only these: "mortar", "itz", "aggregate", "fibre".
    /// screenshot : path or True, optional
    ///     Writes the picture to this path, off screen. True returns it as an array, shape (rows, columns, 3), uint8.
    /// plotter : pyvista.Plotter, optional
    ///     Adds everything to this plotter and returns it; nothing is shown.
    /// **options
    ///     `legend=False` leaves the names of the colours and the scale out. `window_size`, `off_screen`, `notebook`, `background` and `cpos` go to the plotter, all others, such as
    ///     `scalars` or `opacity`, to `pyvista.Plotter.add_mesh`.
    #[pyo3(
        signature = (**options),
        text_signature = "($self, *, cut='y', phases=None, screenshot=None, plotter=None, **options)"
    )]
    fn plot<'py>(slf: &Bound<'py, Self>, options: Option<&Bound<'py, PyDict>>) -> PyResult<Bound<'py, PyAny>> {
        call_view("plot_mesh", slf, options)
    }

    /// Writes the picture of `plot` to `path`, off screen, with the same options.
    #[pyo3(signature = (path, **options), text_signature = "($self, path, **options)")]
    fn screenshot<'py>(
        slf: &Bound<'py, Self>,
        path: Bound<'py, PyAny>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        screenshot_of("plot_mesh", slf, path, options)
    }

    /// The mesh as a meshio mesh with a cell set per phase (needs the extra `mesh`).
    fn to_meshio<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        call_view("mesh_to_meshio", slf, None)
    }

    /// Number of cells.
    fn __len__(&self) -> usize {
        self.0.cell_count()
    }

    fn __repr__(&self) -> String {
        let (points, cells) = (thousands(self.0.points.len()), thousands(self.0.cell_count()));
        format!("Mesh({points} points, {cells} cells of type {})", self.cell_type())
    }

    /// HTML for notebooks: sizes and phases as a table.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        call_view("mesh_to_html", slf, None)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let restore = py.import("mesocrete._mesocrete")?.getattr("_restore_mesh")?;
        let Self(mesh, model, options) = self;
        let contents = (pickle::of_mesh(py, mesh)?, pickle::of_model(py, model)?, pickle::json(options)?);
        (restore, contents).into_pyobject(py)
    }

    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }
}

/// Unpickles a `Mesh`: its arrays, its packing and its options.
#[pyfunction(name = "_restore_mesh")]
pub(crate) fn restore_mesh(
    py: Python<'_>,
    state: &Bound<'_, PyTuple>,
    packing: (Vec<u8>, String),
    options: &str,
) -> PyResult<PyMesh> {
    arrays::load_numpy(py)?;
    guard(|| {
        let (bytes, report) = packing;
        let model = pickle::to_model(py, &bytes, &report)?;
        let table: MeshTable = pickle::from_json(options)?;
        let options = table.resolve(Purpose::Mesh, &model.spec.itz).map_err(mesh_error)?;
        Ok(PyMesh(Arc::new(pickle::to_mesh(state)?), Arc::new(model), options))
    })
}
