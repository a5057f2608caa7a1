//! The sequence of a packing's aggregates.

use super::PyPacking;
use crate::aggregate::PyAggregate;
use crate::arrays;
use crate::boundary::{wrong_type, wrong_value};
use crate::tree::type_name;
use meso_concrete::thousands;
use meso_core::Model;
use meso_core::aggregate::Aggregate;
use meso_core::math::longest_distance;
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::{PyList, PySlice, PyTuple};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The aggregates of a packing, in descending volume: a sequence.
#[pyclass(name = "Aggregates", module = "mesocrete", frozen, sequence)]
pub(crate) struct PyAggregates(pub(crate) Arc<Model>);

impl PyAggregates {
    /// The positions of the items that equal `value`.
    fn equal_to(&self, value: &Bound<'_, PyAny>) -> impl Iterator<Item = usize> {
        let value = value.cast::<PyAggregate>().ok().map(|aggregate| aggregate.get().0.clone());
        let same = move |aggregate: &Aggregate| value.as_ref() == Some(aggregate);
        self.0.aggregates.iter().enumerate().filter(move |(_, aggregate)| same(aggregate)).map(|(position, _)| position)
    }

    /// A property of every aggregate.
    fn column<'py>(&self, py: Python<'py>, value: impl Fn(&Aggregate) -> f64 + Sync) -> Bound<'py, PyArray1<f64>> {
        let model = &self.0;
        PyArray1::from_vec(py, py.detach(|| model.aggregates.iter().map(&value).collect()))
    }

    fn at(&self, index: usize) -> PyAggregate {
        PyAggregate::new(self.0.aggregates[index].clone(), &self.0.spec.phases())
    }

    /// The position `index` means, counted from the end where it is negative.
    fn position(&self, index: isize) -> PyResult<usize> {
        let count = self.0.aggregates.len();
        let position = if index < 0 { index.checked_add_unsigned(count) } else { Some(index) };
        let position = position.and_then(|position| usize::try_from(position).ok()).filter(|&i| i < count);
        position.ok_or_else(|| PyIndexError::new_err(format!("aggregate {index} of {count}")))
    }
}

#[pymethods]
impl PyAggregates {
    /// Volumes, mm3: ndarray, shape (n,), float64; so are the other properties of all aggregates.
    #[getter]
    fn volume<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |aggregate| aggregate.body.volume())
    }

    /// Surfaces, mm2.
    #[getter]
    fn area<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |aggregate| aggregate.body.area())
    }

    /// Longest distances of two vertices, mm.
    #[getter]
    fn size<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |aggregate| longest_distance(aggregate.body.vertices()))
    }

    /// Sides of the smallest square holes that they pass, mm.
    #[getter]
    fn sieve_size<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |aggregate| aggregate.body.sieve_size())
    }

    /// Thicknesses of the ITZ shells, mm.
    #[getter]
    fn itz_thickness<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |aggregate| aggregate.itz_thickness_mm)
    }

    /// Indices of the size classes, from the finest: ndarray, shape (n,), int64.
    #[getter]
    fn size_class<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        PyArray1::from_iter(py, self.0.aggregates.iter().map(|aggregate| i64::from(aggregate.class)))
    }

    /// Centres of volume, mm: ndarray, shape (n, 3).
    #[getter]
    fn centroid<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let centroids: Vec<_> = self.0.aggregates.iter().map(|aggregate| aggregate.body.centroid()).collect();
        arrays::from_points(py, &centroids)
    }

    fn __len__(&self) -> usize {
        self.0.aggregates.len()
    }

    fn __getitem__<'py>(&self, py: Python<'py>, key: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        if let Ok(slice) = key.cast::<PySlice>() {
            let range = slice.indices(self.__len__() as isize)?;
            let indices = (0..range.slicelength as isize).map(|i| (range.start + i * range.step) as usize);
            return Ok(
                PyList::new(py, indices.map(|i| Py::new(py, self.at(i))).collect::<PyResult<Vec<_>>>()?)?.into_any()
            );
        }
        if !key.hasattr("__index__")? {
            let given = type_name(key);
            return Err(wrong_type(format!("aggregates are indexed by int or slice, not {given}")));
        }
        // An index that does not fit a machine word is out of range like any other.
        let index =
            key.extract().map_err(|_| PyIndexError::new_err(format!("aggregate {key} of {}", self.__len__())))?;
        Ok(Bound::new(py, self.at(self.position(index)?))?.into_any())
    }

    fn __iter__(&self) -> PyAggregateIterator {
        PyAggregateIterator { aggregates: Self(Arc::clone(&self.0)), next: AtomicUsize::new(0) }
    }

    /// Position of the first aggregate that equals `value`, from `start` on and before `stop`.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Where there is none.
    #[pyo3(signature = (value, start=0, stop=None))]
    fn index(&self, value: &Bound<'_, PyAny>, start: isize, stop: Option<isize>) -> PyResult<usize> {
        let count = self.__len__();
        let from_end = |index: isize| if index < 0 { index.saturating_add_unsigned(count).max(0) } else { index };
        let [start, stop] = [start, stop.unwrap_or(isize::MAX)].map(|index| (from_end(index) as usize).min(count));
        let found = self.equal_to(value).find(|position| (start..stop).contains(position));
        found.ok_or_else(|| wrong_value(format!("{value} is not among the aggregates")))
    }

    /// How many aggregates equal `value`.
    fn count(&self, value: &Bound<'_, PyAny>) -> usize {
        self.equal_to(value).count()
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0.aggregates == other.0.aggregates
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let restore = py.import("operator")?.getattr("attrgetter")?.call1(("aggregates",))?;
        (restore, (PyPacking(Arc::clone(&self.0)),)).into_pyobject(py)
    }

    fn __repr__(&self) -> String {
        format!("<{} aggregates>", thousands(self.__len__()))
    }
}

/// Walks over a packing's aggregates, one copy at a time.
#[pyclass(name = "_AggregateIterator", module = "mesocrete", frozen)]
struct PyAggregateIterator {
    aggregates: PyAggregates,
    next: AtomicUsize,
}

#[pymethods]
impl PyAggregateIterator {
    fn __iter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __next__(&self) -> Option<PyAggregate> {
        let index = self.next.fetch_add(1, Ordering::Relaxed);
        (index < self.aggregates.__len__()).then(|| self.aggregates.at(index))
    }
}
