//! `Packing`: the result of `pack`, `load` and `pickle`.

mod aggregates;
mod by_spec;
mod image;
mod imported;
mod table;

pub(crate) use crate::effective::of_labels;
pub(crate) use aggregates::PyAggregates;
pub(crate) use by_spec::pack;
pub(crate) use imported::from_labels;

use crate::aggregate::{PyAggregate, inclusions};
use crate::arrays::{IndexArray, PointArray};
use crate::boundary::{guard, wrong_value};
use crate::mesh::{self, PyMesh};
use crate::pickle;
use crate::run::{Plan, beside_python, in_stages, listener};
use crate::spec::{self, PySpec, options};
use crate::tree::plain;
use crate::views::{call_view, framing, screenshot_of};
use crate::{arrays, files};
use meso_concrete::thousands;
use meso_core::check::Check;
use meso_core::formats::SurfaceOptions;
use meso_core::images::Images;
use meso_core::materials::Materials;
use meso_core::statistics::{Statistics, StatisticsOptions};
use meso_core::voxel_image::Region;
use meso_core::watch::Stage;
use meso_core::{Model, Watch as _, methods};
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use serde::Serialize;
use std::path::PathBuf;
use std::sync::Arc;

/// The output of `mesocrete check --json`.
#[derive(Serialize)]
struct Checked {
    sound: bool,
    #[serde(flatten)]
    check: Check,
}

type SurfaceArrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i64>>);

/// A packed specimen.
#[pyclass(name = "Packing", module = "mesocrete", frozen)]
pub(crate) struct PyPacking(pub(crate) Arc<Model>);

fn named_images(name: &str) -> PyResult<Images> {
    match name {
        "none" => Ok(Images::None),
        "whole" => Ok(Images::Whole),
        "cut" => Ok(Images::Cut),
        _ => Err(wrong_value(format!("images is {name:?}; it must be one of \"none\", \"whole\", \"cut\""))),
    }
}

/// Reads a saved model.
///
/// Parameters
/// ----------
/// path : path-like
///     A `.json` or `.json.gz` that `Packing.write` or the command wrote.
/// progress : bool or callable, optional
///     True shows a bar; a callable is called as `progress(done, total)`, from 0 to 1. When it returns False,
///     the work ends with a `RuntimeError`. The time goes into the proof of the specimen's surface, where it is one.
///
/// Raises
/// ------
/// OSError
///     Where the file cannot be read.
/// ValueError
///     Where it is no model; the message names the fault and its place.
#[pyfunction]
#[pyo3(signature = (path, *, progress=None))]
pub(crate) fn load(py: Python<'_>, path: PathBuf, progress: Option<&Bound<'_, PyAny>>) -> PyResult<PyPacking> {
    guard(|| {
        let progress = listener(py, progress)?;
        let plan = Plan::new(&[(Stage::Read, 1.0)], Some(1.0));
        let model = in_stages(py, progress.as_ref(), plan, move |watch| {
            let model = files::load(&path, watch);
            watch.stage(Stage::Read, 1.0);
            model
        })?;
        Ok(PyPacking(Arc::new(model?)))
    })
}

#[pymethods]
impl PyPacking {
    /// Volume of all aggregates, ITZ shells included, over the specimen's.
    #[getter]
    fn fraction(&self) -> f64 {
        self.0.report.fraction
    }

    /// Seed of the run.
    #[getter]
    fn seed(&self) -> u64 {
        self.0.spec.seed
    }

    /// The spec.
    #[getter]
    fn spec(&self) -> PySpec {
        PySpec(self.0.spec.clone())
    }

    /// The aggregates in descending volume: a sequence of `Aggregate`.
    #[getter]
    fn aggregates(&self) -> PyAggregates {
        PyAggregates(Arc::clone(&self.0))
    }

    /// Voids in descending volume, then fibres: a list of `Aggregate`, empty where the spec asks for none.
    #[getter]
    fn inclusions(&self) -> Vec<PyAggregate> {
        inclusions(&self.0)
    }

    /// The specimen's bounding box: lowest and highest corner, mm.
    #[getter]
    fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        let aabb = self.0.spec.specimen.aabb();
        (aabb.min.into(), aabb.max.into())
    }

    /// The result: a dict with the keys of `--summary-json` but `seconds`, so that equal runs compare equal.
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let report = plain(py, &self.0.report)?;
        report.cast::<PyDict>()?.del_item("seconds")?;
        Ok(report)
    }

    /// A paragraph for the methods section of a paper, with the figures of this packing and what to cite, as `report --cite`.
    ///
    /// `mesh` of this packing and `materials`, as `Mesh.solve` takes them, add a sentence each.
    #[pyo3(signature = (mesh=None, materials=None))]
    fn cite(&self, mesh: Option<PyRef<'_, PyMesh>>, materials: Option<&Bound<'_, PyDict>>) -> PyResult<String> {
        if mesh.as_ref().is_some_and(|mesh| mesh.1 != self.0) {
            return Err(wrong_value("mesh is of another packing; pass packing.mesh(...) of this one"));
        }
        let mesh = mesh.map(|mesh| methods::of_mesh(&mesh.0, &mesh.2, &self.0));
        let materials = materials.map(|given| options::<Materials>(Some(given))).transpose()?;
        let further: Vec<String> = mesh.into_iter().chain(materials.map(|of| methods::of_materials(&of))).collect();
        Ok(methods::paragraph(&self.0, &further))
    }

    /// Cost of the result: the counters of `work` in `--summary-json`, and `seconds`, a dict of wall times by stage; a
    /// new dict.
    #[getter]
    fn work<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let work = plain(py, &self.0.report.work)?;
        work.cast::<PyDict>()?.set_item("seconds", plain(py, &self.0.report.seconds)?)?;
        Ok(work)
    }

    /// Every aggregate, void and fibre as a row: a dict of arrays of one length, or a frame of pandas or polars.
    ///
    /// `table("pandas")` is a `pandas.DataFrame`, `table("polars")` a `polars.DataFrame`.
    ///
    /// Columns: `id`, `class` (int64), `phase` (str), `size_mm` (longest distance of two vertices), `sieve_size_mm`,
    /// `volume_mm3`, `area_mm2`, `sphericity` (Wadell), `centroid_x_mm`, `centroid_y_mm`, `centroid_z_mm`,
    /// `itz_thickness_mm` (float64), `vertices`, `faces` (int64). They are those of the `.csv`, and the sieve size.
    ///
    /// Raises
    /// ------
    /// ImportError
    ///     Where the library is not installed.
    #[pyo3(signature = (frame=None))]
    fn table<'py>(&self, py: Python<'py>, frame: Option<&Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        let framed = framing(py, frame)?;
        framed.call1((table::of(py, &self.0)?,))
    }

    /// Writes the packing, whole or not at all; the extension names the format.
    ///
    /// `.json` is the saved model and `.json.gz` the same, compressed; `.step` has an editable solid per aggregate; `.vtu`,
    /// `.vtp`, `.stl`, `.ply`, `.obj` and `.glb` hold the surfaces, `.csv` one row per aggregate, `.html` the page of
    /// `mesocrete report`, `.inp` an Abaqus deck of the default mesh (`mesh()` has the options).
    ///
    /// Parameters
    /// ----------
    /// path : path
    ///     Where to.
    /// overwrite : bool
    ///     Whether to replace a file that is there.
    /// compress : bool
    ///     Whether to compress the data of a `.vtu` or `.vtp`.
    /// images : {"none", "whole", "cut"}
    ///     Aggregates that cross a face of a periodic specimen, where surfaces are written: each once, every image that
    ///     reaches in, or these cut at the faces, so that opposite faces match.
    /// mortar : bool
    ///     Whether a `.step` has the mortar, too: a solid with a cavity per aggregate.
    /// named_solids : bool
    ///     Whether an `.stl` is text, each aggregate a solid with its name.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     For an extension that names no format; the message lists them.
    /// OSError
    ///     Where the file cannot be written, or exists and `overwrite` is False.
    #[pyo3(signature = (path, *, overwrite=true, compress=false, images="none", mortar=false, named_solids=false))]
    #[allow(clippy::too_many_arguments, reason = "keywords of one call")]
    fn write(
        &self,
        py: Python<'_>,
        path: PathBuf,
        overwrite: bool,
        compress: bool,
        images: &str,
        mortar: bool,
        named_solids: bool,
    ) -> PyResult<()> {
        let model = Arc::clone(&self.0);
        let surfaces = SurfaceOptions { compress, images: named_images(images)?, mortar, named_solids };
        guard(|| beside_python(py, None, move |watch| files::write_model(&model, &path, overwrite, surfaces, watch))?)
    }

    /// The specimen's surface: points (n, 3), mm, and triangles (m, 3), counter-clockwise from outside.
    ///
    /// Exact for planes; curved walls are polygons within 1e-3 of their size.
    fn specimen_surface<'py>(&self, py: Python<'py>) -> PyResult<(PointArray<'py>, IndexArray<'py>)> {
        let surface = self.0.spec.specimen.container().surface();
        Ok((arrays::from_points(py, &surface.points)?, arrays::from_indices(py, surface.triangles().flatten(), 3)?))
    }

    /// Proves, independently of how it was packed, that nothing overlaps and everything lies inside.
    ///
    /// Parameters
    /// ----------
    /// progress : bool or callable, optional
    ///     True shows a bar; a callable is called as `progress(done, total)`, from 0 to 1. When it returns False,
    ///     the work ends with a `RuntimeError`.
    ///
    /// Returns
    /// -------
    /// dict
    ///     `sound` (bool), `aggregates`, `pairs_tested`, `fraction` (recomputed), `findings`, a list of what is wrong, and
    ///     `not_checked`, properties that a check of the model alone cannot prove.
    #[pyo3(signature = (*, progress=None))]
    fn check<'py>(&self, py: Python<'py>, progress: Option<&Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        guard(|| {
            let (model, progress) = (Arc::clone(&self.0), listener(py, progress)?);
            let plan = Plan::new(&[(Stage::Prove, 1.0)], Some(1.0));
            let check = in_stages(py, progress.as_ref(), plan, move |watch| Check::of(&model, watch))?;
            plain(py, &Checked { sound: check.is_sound(), check })
        })
    }

    /// Measures grading, shape, orientation, wall effect, gaps and correlation functions of the aggregates, and counts
    /// voids and fibres under `phases`.
    ///
    /// Parameters
    /// ----------
    /// progress : bool or callable, optional
    ///     True shows a bar; a callable is called as `progress(done, total)`, from 0 to 1. When it returns False,
    ///     the work ends with a `RuntimeError`.
    /// **options
    ///     How much is sampled, and how finely: `seed`, `lines`, `lag_mm`, `lags`, `points`, `layer_mm`.
    ///
    /// Returns
    /// -------
    /// dict
    #[pyo3(signature = (*, progress=None, **options))]
    fn statistics<'py>(
        &self,
        py: Python<'py>,
        progress: Option<&Bound<'py, PyAny>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        guard(|| {
            let (model, options) = (Arc::clone(&self.0), spec::options::<StatisticsOptions>(options)?);
            options.validate().map_err(|error| spec::spec_error(&error))?;
            let progress = listener(py, progress)?;
            let plan = Plan::new(&[(Stage::Measure, 1.0)], Some(1.0));
            let measured =
                in_stages(py, progress.as_ref(), plan, move |watch| Statistics::watched(&model, &options, watch))?;
            plain(py, &measured.map_err(|error| wrong_value(error.to_string()))?)
        })
    }

    /// Effective diffusivity, conductivity, permeability or stiffness, with its error, on exact voxels or on tetrahedra.
    ///
    /// Parameters
    /// ----------
    /// what : {"diffusivity", "conductivity", "permeability", "stiffness", "all"}
    ///     The property. All are diffusivity, conductivity and stiffness. For all, `phases` has a mapping for each, and a list of three is returned.
    /// voxel_size : float, optional
    ///     Edge of a voxel, mm; by default an eighth of the smallest grain. The error follows from voxels of twice the size.
    /// method : {"voxel", "lattice"}
    ///     Division into voxels, or into tetrahedra whose faces follow the aggregates.
    /// element_size : float, optional
    ///     Edge of the tetrahedra, mm; a quarter of the smallest grain if omitted.
    /// phases : mapping, optional
    ///     Values of `mortar`, `aggregate`, `itz`, `void`, `fibre`; omitted ones keep their defaults: for diffusivity 1, 0,
    ///     the mortar's, 0, 0, for conductivity 1.5, 3, the mortar's, 0.025, 50 W/(m K), for permeability 1e-11, 0, the
    ///     mortar's, 0, 0 mm2. For stiffness, each phase has a mapping of `youngs_modulus_mpa`, `poisson_ratio`, `eigenstrain`.
    /// eigenstrain : mapping, optional
    ///     Strains without stress of the phases by name, for stiffness: shrinkage is negative.
    /// axes : str
    ///     Axes of the gradient, some of x, y, z; each takes a solution. Stiffness always has all.
    /// boundary : {"fixed", "uniform-gradient", "uniform-flux"}
    ///     Conditions at walls: given values at the ends of the gradient and insulated sides; in tetrahedra also a uniform
    ///     gradient, an upper estimate, or a uniform flux, a lower one.
    /// tolerance : float, optional
    ///     Error of the equations, over the result; 1e-9, and 1e-12 for stiffness, if omitted.
    /// progress : bool or callable, optional
    ///     True shows a bar; a callable is called as `progress(done, total)`, from 0 to 1. When it returns False,
    ///     the work ends with a `RuntimeError`.
    ///
    /// Returns
    /// -------
    /// Effective
    ///     A dict whose keys are attributes, too: the content of `effective.json` but `seconds`. It has `tensor`, `error`,
    ///     `fine`, `coarse` (rows of mean flux, columns of gradients, None where not asked for), `bounds`, `phases`, `boundary`,
    ///     `voxels` and `voxel_size_mm` or `elements` and `element_size_mm`, `iterations`, `solver_error`, `warnings`.
    ///     Stiffness has 6 x 6 entries in MPa in the order xx, yy, zz,
    ///     yz, zx, xy, and `isotropic`, `isotropic_error`, `expansion`, `expansion_error`.
    ///
    /// Raises
    /// ------
    /// ValueError, TypeError
    ///     Names the option, its value and the accepted range; a specimen that is no box; tetrahedra
    ///     also take a cylinder along z.
    /// RuntimeError
    ///     Where the equations do not converge.
    #[pyo3(signature = (what="diffusivity", *, voxel_size=None, method="voxel", element_size=None, phases=None, eigenstrain=None, axes="xyz", boundary="fixed", tolerance=None, progress=None))]
    #[allow(clippy::too_many_arguments, reason = "keywords of Python")]
    fn effective<'py>(
        &self,
        py: Python<'py>,
        what: &str,
        voxel_size: Option<&Bound<'py, PyAny>>,
        method: &str,
        element_size: Option<&Bound<'py, PyAny>>,
        phases: Option<&Bound<'py, PyAny>>,
        eigenstrain: Option<&Bound<'py, PyAny>>,
        axes: &str,
        boundary: &str,
        tolerance: Option<&Bound<'py, PyAny>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let names = [("what", what), ("method", method), ("axes", axes), ("boundary", boundary)];
        let ask = crate::effective::asked(
            &names,
            &[
                ("voxel_size_mm", voxel_size),
                ("element_size_mm", element_size),
                ("phases", phases),
                ("eigenstrain", eigenstrain),
                ("tolerance", tolerance),
            ],
        )?;
        crate::effective::compute(py, &self.0, &ask, progress)
    }

    /// Phases, ids, shares or distances at every voxel of the specimen, or of a box in it.
    ///
    /// Voxel (k, j, i) has its centre at (i + 0.5, j + 0.5, k + 0.5) h from the lower corner of the specimen's bounding
    /// box, or of `box`. It lies in a body if its centre lies in the closed polyhedron.
    ///
    /// Parameters
    /// ----------
    /// h : float, optional
    ///     Edge of a voxel, mm; along periodic axes it must divide the specimen's length. Give `h` or `shape`.
    /// what : {"phase", "grain", "share", "distance"}
    ///     "phase": uint8, 0 mortar, 1 ITZ, 2 aggregate, 3 void, 4 fibre, 255 outside the specimen. "grain": int32, the id
    ///     of the aggregate, void or fibre, -1 in the mortar, -2 outside. "share": float32, the share of the voxel's
    ///     volume, exact to rounding; see `of`. "distance": float32, mm to the nearest surface of an aggregate, void or
    ///     fibre, negative inside, NaN outside the specimen.
    /// box : pair of triples, optional
    ///     Lower and upper corner of the part that is shown, mm, in the specimen's bounding box.
    /// shape : int or triple, optional
    ///     Number of voxels along the longest side, or (nz, ny, nx); `h` follows from it. Voxels are cubes.
    /// of : {"aggregate", "core", "itz", "void", "fibre"}
    ///     Whose share: of aggregates with their ITZ shells (as the packing's fraction counts them), of aggregates
    ///     without, of the shells alone, of voids or of fibres. Cores and shells of ellipsoids and of grains with dents are
    ///     sampled, to 0.01 of a voxel.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (nz, ny, nx), C order
    ///
    /// Raises
    /// ------
    /// ValueError, TypeError
    ///     Names the option, its value and the accepted range. Images of more than 2^33 voxels are left to
    ///     `mesocrete image`, which streams them.
    #[pyo3(signature = (h=None, what="phase", r#box=None, *, shape=None, of="aggregate"))]
    fn voxelize<'py>(
        &self,
        py: Python<'py>,
        h: Option<f64>,
        what: &str,
        r#box: Option<&Bound<'py, PyAny>>,
        shape: Option<&Bound<'py, PyAny>>,
        of: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let region = r#box.map_or(Ok(Region::Whole), image::region)?;
        let h = image::voxel_size(&self.0, region, h, shape)?;
        image::make(py, &self.0, image::options(h, what, of, region)?)
    }

    /// Phases, ids, shares or distances on a plane normal to an axis, pixel by pixel.
    ///
    /// Parameters
    /// ----------
    /// axis : {"x", "y", "z"}
    ///     The axis that the plane is normal to.
    /// at : float, optional
    ///     Position of the plane on it, mm; by default the middle of the specimen.
    /// x, y, z : float, optional
    ///     One of them instead of `axis` and `at`, as in `section(y=50)`.
    /// px : int
    ///     Pixels along the longer side of the section; they are square.
    /// what, of
    ///     As for `voxelize`; shares are those of cubic voxels.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (rows, columns)
    ///     [y, x] across z, [z, x] across y, [z, y] across x; the first row is the lowest, as with
    ///     `matplotlib.pyplot.imshow(..., origin="lower")`.
    ///
    /// Raises
    /// ------
    /// ValueError, TypeError
    ///     Names the option, its value and the accepted range.
    #[pyo3(signature = (axis=None, at=None, px=512, what="phase", *, of="aggregate", x=None, y=None, z=None))]
    #[expect(clippy::too_many_arguments, reason = "keywords of a Python method")]
    fn section<'py>(
        &self,
        py: Python<'py>,
        axis: Option<&str>,
        at: Option<f64>,
        px: i64,
        what: &str,
        of: &str,
        x: Option<f64>,
        y: Option<f64>,
        z: Option<f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let places: Vec<(&str, f64)> =
            [("x", x), ("y", y), ("z", z)].into_iter().filter_map(|(axis, at)| Some((axis, at?))).collect();
        let (axis, at) = match (axis, at, places.as_slice()) {
            (Some(axis), at, []) => (axis, at),
            (None, None, [(axis, at)]) => (*axis, Some(*at)),
            _ => return Err(PyTypeError::new_err("section takes one plane: section(\"y\", at=50) or section(y=50)")),
        };
        let (axis, h) = image::pixels(&self.0, axis, px)?;
        let aabb = self.0.spec.specimen.aabb();
        let at = at.unwrap_or((aabb.min[axis] + aabb.max[axis]) / 2.0);
        image::make(py, &self.0, image::options(h, what, of, Region::Section { axis, at })?)
    }

    /// Meshes the packing.
    ///
    /// Parameters
    /// ----------
    /// method : str, optional
    ///     Method of meshing; "voxel" is the default.
    /// element_size : float or "auto", optional
    ///     Edge length of the elements, mm; default 2. "auto" tries sizes on a small cube of the packing, and takes the
    ///     largest that keeps every phase within 5 %.
    /// for_test : bool, optional
    ///     Whether options that are not given are those of `mesocrete solve` with a model: a lattice with a smeared ITZ,
    ///     aggregates of exact volume that mortar separates, and split narrow gaps. `Mesh.solve` then gives the command's
    ///     curve.
    /// accept_phase_error : bool, optional
    ///     Whether a mesh may have a phase more than 10 % off its exact volume, which is an error otherwise. A test of such
    ///     a mesh warns before its first step, and its results carry a flag.
    /// progress : bool or callable, optional
    ///     True shows a bar; a callable is called as `progress(done, total)`, from 0 to 1. When it returns False,
    ///     meshing stops with a `RuntimeError`.
    /// **options
    ///     The other options of `mesocrete mesh`, e.g. `itz="cohesive"`. Where `itz` is not given, the mesh has the ITZ
    ///     if its elements resolve it: voxels thicker than the thinnest shell cannot. None means "none". Where `volumes` is
    ///     not given, meshes that follow grains other than convex polyhedra have their exact volumes.
    ///
    /// Raises
    /// ------
    /// ValueError, TypeError
    ///     Names the option, its value and the accepted range; or the phase that the elements are too coarse for.
    /// MemoryError
    ///     Where the mesh would take more memory than is free.
    #[pyo3(signature = (*, method=None, element_size=None, for_test=false, accept_phase_error=false, progress=None, **options))]
    #[expect(clippy::too_many_arguments, reason = "they are Python's keywords")]
    fn mesh(
        &self,
        py: Python<'_>,
        method: Option<&Bound<'_, PyAny>>,
        element_size: Option<&Bound<'_, PyAny>>,
        for_test: bool,
        accept_phase_error: bool,
        progress: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyMesh> {
        guard(|| {
            let keywords = options.map_or_else(|| Ok(PyDict::new(py)), |options| options.copy())?;
            let asked = mesh::table(method, element_size, &keywords)?;
            mesh::build(py, Arc::clone(&self.0), progress, asked, mesh::purpose(for_test), accept_phase_error)
        })
    }

    /// The bodies' outer surfaces as PyVista polygons (needs the extra `plot`); `images` as for `write`.
    #[pyo3(signature = (**options))]
    fn to_pyvista<'py>(slf: &Bound<'py, Self>, options: Option<&Bound<'py, PyDict>>) -> PyResult<Bound<'py, PyAny>> {
        call_view("packing_to_pyvista", slf, options)
    }

    /// Shows the bodies, coloured by size class, inside the specimen's edges (needs the extra `plot`).
    ///
    /// Parameters
    /// ----------
    /// cut : str or pair, optional
    ///     "z", or ("z", 30.0) in mm: takes the part beyond a plane away, and shows the phases on the plane.
    /// itz : bool
    ///     Whether the cut shows the ITZ. Without a cut the bodies are translucent around their cores.
    /// screenshot : path or True, optional
    ///     Writes the picture to this path, off screen. True returns it as an array, shape (rows, columns, 3), uint8.
    /// plotter : pyvista.Plotter, optional
    ///     Adds everything to this plotter and returns it; nothing is shown.
    /// **options
    ///     `legend=False` leaves the names of the colours and the scale out. `window_size`, `off_screen`, `notebook`, `background` and `cpos` go to the plotter, all others, such as
    ///     `color` or `scalars`, to `pyvista.Plotter.add_mesh`.
    #[pyo3(
        signature = (**options),
        text_signature = "($self, *, cut=None, itz=False, screenshot=None, plotter=None, **options)"
    )]
    fn plot<'py>(slf: &Bound<'py, Self>, options: Option<&Bound<'py, PyDict>>) -> PyResult<Bound<'py, PyAny>> {
        call_view("plot_packing", slf, options)
    }

    /// Writes the picture of `plot` to `path`, off screen, with the same options.
    #[pyo3(signature = (path, **options), text_signature = "($self, path, **options)")]
    fn screenshot<'py>(
        slf: &Bound<'py, Self>,
        path: Bound<'py, PyAny>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        screenshot_of("plot_packing", slf, path, options)
    }

    /// Draws the grading asked for and the one reached; returns the matplotlib axes (extra `plot`).
    #[pyo3(signature = (**options))]
    fn plot_grading<'py>(slf: &Bound<'py, Self>, options: Option<&Bound<'py, PyDict>>) -> PyResult<Bound<'py, PyAny>> {
        call_view("plot_grading", slf, options)
    }

    /// Points, faces in VTK's padded form, and the id of every face's body, for `to_pyvista`.
    fn _surfaces<'py>(&self, py: Python<'py>, images: &str) -> PyResult<SurfaceArrays<'py>> {
        let shown = named_images(images)?.of(&self.0.bodies(), &self.0.spec.specimen);
        let (mut points, mut faces, mut owners) = (Vec::new(), Vec::new(), Vec::new());
        for aggregate in &shown {
            let first = points.len() as i64;
            points.extend_from_slice(aggregate.body.vertices());
            for face in aggregate.body.faces() {
                faces.push(face.len() as i64);
                faces.extend(face.iter().map(|i| first + i64::from(i)));
                owners.push(i64::from(aggregate.id));
            }
        }
        Ok((arrays::from_points(py, &points)?, PyArray1::from_vec(py, faces), PyArray1::from_vec(py, owners)))
    }

    fn __len__(&self) -> usize {
        self.0.aggregates.len()
    }

    /// Same spec and, bit for bit, the same aggregates, voids and fibres; how long it took does not count.
    fn __eq__(&self, other: &Self) -> bool {
        let (own, other) = (&self.0, &other.0);
        own.spec == other.spec && own.aggregates == other.aggregates && own.inclusions == other.inclusions
    }

    fn __repr__(&self) -> String {
        let (spec, report) = (&self.0.spec, &self.0.report);
        let (count, kind) = (thousands(self.0.aggregates.len()), spec.specimen.kind());
        format!("Packing({count} aggregates in a {kind}, fraction={:.4}, seed={})", report.fraction, spec.seed)
    }

    /// A section through the middle and the figures, for notebooks.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        call_view("packing_to_html", slf, None)
    }

    /// The exact section across an axis as the text of an SVG.
    fn _section_svg(&self, py: Python<'_>, axis: usize, at: f64) -> PyResult<String> {
        guard(|| {
            let model = Arc::clone(&self.0);
            let drawn = beside_python(py, None, move |_| {
                let mut svg = Vec::new();
                meso_core::page::section(&model, axis.min(2), at, &mut svg).map(|()| svg)
            })?;
            Ok(String::from_utf8_lossy(&drawn?).into_owned())
        })
    }

    /// Sizes and the share of the aggregates' volume that the grading asks to pass them.
    fn _asked_curve(&self) -> (Vec<f64>, Vec<f64>) {
        let grading = &self.0.spec.grading;
        let (low, high) = (grading.d_min_mm, grading.d_max_mm);
        let sizes: Vec<f64> = (0..=100).map(|i| low * (high / low).powf(f64::from(i) / 100.0)).collect();
        let asked = sizes.iter().map(|&size| grading.passing(size)).collect();
        (sizes, asked)
    }

    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let restore = py.import("mesocrete._mesocrete")?.getattr("_restore_packing")?;
        (restore, pickle::of_model(py, &self.0)?).into_pyobject(py)
    }
}

/// Unpickles a `Packing`: the bytes of a saved model, which names its version, and the report with its seconds.
#[pyfunction(name = "_restore_packing")]
pub(crate) fn restore_packing(py: Python<'_>, model: &[u8], report: &str) -> PyResult<PyPacking> {
    arrays::load_numpy(py)?;
    guard(|| Ok(PyPacking(Arc::new(pickle::to_model(py, model, report)?))))
}
