//! Voxel images and sections as arrays of numpy.

use crate::boundary::{guard, wrong_type, wrong_value};
use crate::run::beside_python;
use crate::spec::spec_error;
use meso_core::Model;
use meso_core::voxel_image::{ImageOptions, Quantity, Region, ShareOf, VoxelImage, Voxels};
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
            let image = VoxelImage::new(&model, &options).map_err(|error| spec_error(&error))?;
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
