//! `from_labels`: the grains of a label volume as a packing.

use super::PyPacking;
use crate::boundary::{accept_in_memory, guard, wrong_value};
use crate::effective::{spacing, volume};
use crate::files;
use crate::run::{Plan, in_stages, listener};
use meso_ask::{Giver, labels_refusal};
use meso_core::import::grains::{Roles, SmoothOptions};
use meso_core::labelled::{LabelOptions, of_labels};
use meso_core::watch::Stage;
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use std::ffi::CString;
use std::path::PathBuf;
use std::sync::Arc;

/// The grains of a label volume, as a CT scan leaves them after segmentation, as a packing in a box.
///
/// Every connected part of a label is a grain: a smooth closed surface with the volume of its voxels, apart from all
/// others. Grains that the volume's faces cut end at the box.
///
/// Parameters
/// ----------
/// labels : array_like of int, shape (nz, ny, nx), or path-like
///     One integer a grain or a phase; or a file (.tif, .npy, .vti).
/// voxel_size : float or sequence of three float, optional
///     Edge of a voxel, mm; three are along x, y, z. Without, the file's, or else 1.
/// array : str, optional
///     Array of a .vti that has the labels. Without, its scalars, of the cells or else of the points.
/// mortar : sequence of int, optional
///     Labels of the mortar, 0 without. Ids of `Packing.voxelize` take (-1,).
/// aggregate : sequence of int
///     Labels that are the aggregates' phase together, such as core and ITZ; all others are then mortar.
/// outside : sequence of int
///     Labels outside a drilled core, which stands along z: its cylinder is the specimen, not the whole box.
/// least_voxels : int
///     Smaller grains are mortar.
/// largest_grain : float
///     Largest share of the volume that a grain may have; a larger one is asked about, since it may be mortar.
/// gap : float
///     Gap between grains that are nearer, mm, so that elements of this size keep mortar between them; at least half a voxel.
/// itz_thickness : float
///     Thickness of the ITZ of every grain, mm.
/// tolerance : float
///     Root mean square error of merged triangles, in voxels.
/// smoothing : float
///     Width of the blur that smooths surfaces, in voxels.
/// step : float
///     Distance of the points between which a surface is found, in voxels; at most 1 on grains of fewer than 12 along an axis.
/// progress : bool or callable, optional
///     True shows a bar; a callable is called as `progress(done, total)`, from 0 to 1. When it returns False,
///     the work ends with a `RuntimeError`.
///
/// Returns
/// -------
/// Packing
///     `report()["labels"]` has the label of every aggregate, and how far surfaces are from the voxels.
///
/// Raises
/// ------
/// ValueError, TypeError
///     Names the option, its value and the accepted range; a volume without grains, or with one that fills it.
/// OSError
///     Where the file cannot be read.
#[pyfunction]
#[pyo3(signature = (labels, voxel_size=None, *, array=None, mortar=None, aggregate=vec![], outside=vec![], least_voxels=64, largest_grain=0.2, gap=0.0, itz_thickness=0.0,
    tolerance=0.2, smoothing=1.0, step=2.0, progress=None))]
#[pyo3(
    text_signature = "(labels, voxel_size=None, *, array=None, mortar=None, aggregate=(), outside=(), least_voxels=64, largest_grain=0.2, gap=0.0, itz_thickness=0.0, tolerance=0.2, smoothing=1.0, step=2.0, progress=None)"
)]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn from_labels(
    py: Python<'_>,
    labels: &Bound<'_, PyAny>,
    voxel_size: Option<&Bound<'_, PyAny>>,
    array: Option<&str>,
    mortar: Option<Vec<i64>>,
    aggregate: Vec<i64>,
    outside: Vec<i64>,
    least_voxels: i64,
    largest_grain: f64,
    gap: f64,
    itz_thickness: f64,
    tolerance: f64,
    smoothing: f64,
    step: f64,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<PyPacking> {
    guard(|| {
        if mortar.is_some() && !aggregate.is_empty() {
            let why = "all labels beside the aggregate's are mortar; leave one of them out";
            return Err(wrong_value(format!("mortar and aggregate are both given: {why}")));
        }
        let least_voxels = usize::try_from(least_voxels).map_err(|_| {
            wrong_value(format!("least_voxels is {least_voxels}; it must be a whole number, not below 0"))
        })?;
        let options = LabelOptions {
            voxel_size_mm: voxel_size.map(|size| spacing(Some(size))).transpose()?,
            roles: Roles { mortar: mortar.unwrap_or_else(|| vec![0]), aggregate },
            outside,
            least_voxels,
            largest_grain,
            gap_mm: gap,
            itz_thickness_mm: itz_thickness,
            surfaces: SmoothOptions { step, smoothing, tolerance },
        };
        options.validate().map_err(|error| wrong_value(Giver::Keywords.refusal(&error)))?;
        let volume = match labels.extract::<PathBuf>() {
            Ok(path) => files::volume(&path, array)?,
            Err(_) if array.is_some() => {
                return Err(wrong_value("array is for a .vti; leave it out with an array of numpy"));
            }
            Err(_) => volume(labels)?,
        };
        let is_sized = options.voxel_size_mm.is_some() || labels.extract::<PathBuf>().is_err();
        warn(py, volume.size_remark(is_sized).into_iter().chain(volume.array_note.clone()))?;
        accept_in_memory("from_labels", LabelOptions::bytes(volume.counts), "labels")?;
        let progress = listener(py, progress)?;
        let plan = Plan::new(&[(Stage::Take, 1.0)], Some(1.0));
        let model = in_stages(py, progress.as_ref(), plan, move |watch| {
            watch.stops_soon();
            let model = of_labels(&volume, &options, watch);
            model.map_err(|error| labels_refusal(&error, &options, Giver::Keywords))
        })?;
        Ok(PyPacking(Arc::new(model.map_err(wrong_value)?)))
    })
}

/// Warns at the caller's line.
fn warn(py: Python<'_>, remarks: impl IntoIterator<Item = String>) -> PyResult<()> {
    let category = py.get_type::<PyUserWarning>();
    remarks.into_iter().try_for_each(|remark| PyErr::warn(py, &category, &CString::new(remark)?, 1))
}
