//! Voxel images and sections as arrays of numpy.

use crate::boundary::{guard, wrong_type, wrong_value};
use crate::run::beside_python;
use crate::spec::spec_error;
use meso_core::voxel_image::{ImageOptions, Quantity, Region, ShareOf, VoxelImage, Voxels};
use meso_core::{Model, SpecError};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::{Error, StrDeserializer};
use std::sync::Arc;

/// Most voxels of an array; larger images belong in files.
const MOST: usize = 1 << 33;

/// The options by their names in Python.
///
/// # Errors
/// `ValueError` for names that are none.
pub(crate) fn options(h: f64, what: &str, of: &str, region: Region) -> PyResult<ImageOptions> {
    let quantity: Quantity = named("what", what, "\"phase\", \"grain\", \"share\", \"distance\"")?;
    let share: ShareOf = named("of", of, "\"aggregate\", \"core\", \"itz\", \"void\", \"fibre\"")?;
    if share != ShareOf::Aggregate && quantity != Quantity::Share {
        return Err(wrong_value(format!("of is {of:?}; it is only for what=\"share\"")));
    }
    Ok(ImageOptions { voxel_size_mm: h, quantity, of: share, region })
}

/// The part of the specimen between two corners.
///
/// # Errors
/// `TypeError` for anything but a pair of triples.
pub(crate) fn region(corners: &Bound<'_, PyAny>) -> PyResult<Region> {
    let pair: PyResult<[[f64; 3]; 2]> = corners.extract();
    pair.map(|[min, max]| Region::Box { min, max }).map_err(|_| {
        let message = format!("box is {corners}; it must be a pair of corners in mm, as in [[0, 0, 0], [50, 50, 50]]");
        wrong_type(message)
    })
}

/// Edge of a voxel, mm: `h`, or the one at which the region has `shape` voxels, (nz, ny, nx) or along its longest side.
///
/// # Errors
/// `TypeError` for both or none, `ValueError` for a shape that cubes cannot have.
pub(crate) fn voxel_size(
    model: &Model,
    region: Region,
    h: Option<f64>,
    shape: Option<&Bound<'_, PyAny>>,
) -> PyResult<f64> {
    let shape = match (h, shape) {
        (Some(h), None) => return Ok(h),
        (None, Some(shape)) => shape,
        _ => return Err(wrong_type("give one of h, the edge of a voxel in mm, and shape, the number of voxels")),
    };
    let size = match region {
        Region::Box { min, max } => [0, 1, 2].map(|axis| max[axis] - min[axis]),
        _ => model.spec.specimen.aabb().size().into(),
    };
    let longest = size.into_iter().fold(0.0, f64::max);
    let wrong = |accepted: String| wrong_value(format!("shape is {shape}; {accepted}"));
    let counts: [i64; 3] = match shape.extract::<i64>() {
        Ok(count) if count > 0 => return Ok(longest / count as f64),
        Ok(_) => return Err(wrong("it must be 1 or more".to_owned())),
        Err(_) => shape.extract().map_err(|_| wrong("it must be an int or a triple (nz, ny, nx)".to_owned()))?,
    };
    let most = counts.into_iter().max().unwrap_or(0);
    let fitting = [2, 1, 0].map(|axis| (size[axis] * most as f64 / longest).ceil() as i64);
    let h = longest / most as f64;
    let fits = |(count, axis): (i64, usize)| (count as f64 * h - size[axis]).abs() <= 1e-6 * h;
    if most > 0 && counts.into_iter().zip([2, 1, 0]).all(fits) {
        return Ok(h);
    }
    let [z, y, x] = fitting;
    Err(wrong(format!(
        "voxels are cubes: the {} x {} x {} mm fit ({z}, {y}, {x}), which shape={most} gives",
        size[0], size[1], size[2]
    )))
}

/// One of the names that serde knows.
fn named<T: for<'de> Deserialize<'de>>(key: &str, name: &str, known: &str) -> PyResult<T> {
    let text: StrDeserializer<'_, Error> = name.into_deserializer();
    T::deserialize(text).map_err(|_| wrong_value(format!("{key} is {name:?}; it must be one of {known}")))
}

/// The axis of that name, and the size of a pixel, mm, of which `px` fit along the longer side of the section.
///
/// # Errors
/// `ValueError` for another axis and for no pixels.
pub(crate) fn pixels(model: &Model, axis: &str, px: i64) -> PyResult<(usize, f64)> {
    let number = ["x", "y", "z"].iter().position(|name| *name == axis);
    let number =
        number.ok_or_else(|| wrong_value(format!("axis is {axis:?}; it must be one of \"x\", \"y\", \"z\"")))?;
    if px < 1 {
        return Err(wrong_value(format!("px is {px}; it must be 1 or more")));
    }
    let mut size = model.spec.specimen.aabb().size();
    size[number] = 0.0;
    Ok((number, size.max() / px as f64))
}

/// The whole image.
///
/// # Errors
/// `ValueError` for options that cannot be met, `KeyboardInterrupt` on Ctrl-C.
pub(crate) fn make<'py>(py: Python<'py>, model: &Arc<Model>, options: ImageOptions) -> PyResult<Bound<'py, PyAny>> {
    guard(|| {
        let model = Arc::clone(model);
        let made = beside_python(py, None, move |watch| -> PyResult<(Voxels, Vec<usize>)> {
            watch.stops_soon();
            let image = VoxelImage::new(&model, &options).map_err(|error| match error.key.as_str() {
                // The keyword of images.
                "voxel_size_mm" => spec_error(&SpecError { key: "h".to_owned(), ..error }),
                _ => spec_error(&error),
            })?;
            let shape = image.shape();
            let voxels: usize = shape.iter().product();
            if voxels > MOST {
                return Err(wrong_value(format!(
                    "the image would have {shape:?} voxels, more than 2^33; take a box or larger voxels, or stream it to a \
                     file: mesocrete image MODEL -o FILE.npy"
                )));
            }
            let mut slabs = image.slabs().take_while(|_| watch.goes_on());
            let mut first = slabs.next().ok_or_else(|| PyKeyboardInterrupt::new_err("stopped"))?;
            reserve(&mut first, voxels);
            Ok((slabs.fold(first, joined), shape))
        })?;
        let (values, shape) = made?;
        match values {
            Voxels::Label(values) => Ok(PyArray1::from_vec(py, values).reshape(shape)?.into_any()),
            Voxels::Id(values) => Ok(PyArray1::from_vec(py, values).reshape(shape)?.into_any()),
            Voxels::Real(values) => Ok(PyArray1::from_vec(py, values).reshape(shape)?.into_any()),
        }
    })
}

/// Takes memory for all `voxels` at once: an array that grows is there twice while it moves.
fn reserve(slab: &mut Voxels, voxels: usize) {
    match slab {
        Voxels::Label(values) => values.reserve_exact(voxels - values.len()),
        Voxels::Id(values) => values.reserve_exact(voxels - values.len()),
        Voxels::Real(values) => values.reserve_exact(voxels - values.len()),
    }
}

/// Two slabs as one; slabs of an image are of one type.
fn joined(mut lower: Voxels, upper: Voxels) -> Voxels {
    match (&mut lower, upper) {
        (Voxels::Label(all), Voxels::Label(more)) => all.extend_from_slice(&more),
        (Voxels::Id(all), Voxels::Id(more)) => all.extend_from_slice(&more),
        (Voxels::Real(all), Voxels::Real(more)) => all.extend_from_slice(&more),
        _ => unreachable!("slabs of an image are of one type"),
    }
    lower
}
