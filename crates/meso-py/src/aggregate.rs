//! `Aggregate` and the sequence of a packing's aggregates.

use crate::arrays;
use crate::boundary::guard;
use crate::packing::PyPacking;
use crate::polyhedron::{PyPolyhedron, offset_error};
use crate::tree::type_name;
use meso_core::Model;
use meso_core::aggregate::{Aggregate, Kind};
use meso_core::geometry::Face;
use numpy::PyArray2;
use pyo3::exceptions::{PyIndexError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyList, PySlice, PyTuple};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// One aggregate, or one void or fibre, at its place in the specimen.
#[pyclass(name = "Aggregate", module = "mesocrete", frozen, eq)]
#[derive(PartialEq)]
pub(crate) struct PyAggregate(pub(crate) Aggregate);

/// The aggregates of a packing, in descending volume: a sequence.
#[pyclass(name = "Aggregates", module = "mesocrete", frozen, sequence)]
pub(crate) struct PyAggregates(pub(crate) Arc<Model>);

#[pymethods]
impl PyAggregate {
    /// Position in the packing, from 0; voids and fibres count on from the last aggregate.
    #[getter]
    fn id(&self) -> u32 {
        self.0.id
    }

    /// What it is: "aggregate", "void" or "fibre".
    #[getter]
    fn phase(&self) -> &'static str {
        self.0.kind.name()
    }

    /// Index of the size class, from the finest; those of voids and of fibres follow the grading's.
    #[getter]
    fn size_class(&self) -> u16 {
        self.0.class
    }

    /// Vertex positions: ndarray, shape (n, 3), float64, mm; a copy.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::from_points(py, self.0.body.vertices())
    }

    /// Vertex indices of every face, counter-clockwise from outside: list of lists of int.
    #[getter]
    fn faces(&self) -> Vec<Vec<u32>> {
        self.0.body.faces().map(Face::to_vec).collect()
    }

    /// Faces cut into triangles: ndarray, shape (m, 3), int64.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        arrays::from_indices(py, self.0.body.triangles().flatten(), 3)
    }

    /// Volume of the outer body, ITZ shell included, mm3.
    #[getter]
    fn volume(&self) -> f64 {
        self.0.body.volume()
    }

    /// Thickness of the ITZ shell, mm.
    #[getter]
    fn itz_thickness(&self) -> f64 {
        self.0.itz_thickness_mm
    }

    /// The outer body as a `Polyhedron`.
    #[getter]
    fn body(&self) -> PyPolyhedron {
        self.0.body.clone().into()
    }

    /// The body inside the ITZ shell, or `None` where the shell takes it all.
    fn core(&self, py: Python<'_>) -> PyResult<Option<PyPolyhedron>> {
        guard(|| {
            let inner = py.detach(|| self.0.core()).map_err(|error| offset_error(&error))?;
            Ok(inner.map(PyPolyhedron::from))
        })
    }

    fn __repr__(&self) -> String {
        let Aggregate { id, class, itz_thickness_mm, body, kind } = &self.0;
        let volume = body.volume();
        if *kind != Kind::Aggregate {
            return format!("Aggregate(id={id}, phase={:?}, volume={volume} mm3)", kind.name());
        }
        format!("Aggregate(id={id}, size_class={class}, volume={volume} mm3, itz_thickness={itz_thickness_mm} mm)")
    }

    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let restore = py.import("mesocrete._mesocrete")?.getattr("_restore_aggregate")?;
        let Aggregate { id, class, itz_thickness_mm, .. } = self.0;
        (restore, (self.body(), id, class, itz_thickness_mm, self.phase())).into_pyobject(py)
    }
}

/// Unpickles an `Aggregate`.
#[pyfunction(name = "_restore_aggregate", signature = (body, id, size_class, itz_thickness, phase="aggregate"))]
pub(crate) fn restore_aggregate(
    body: &PyPolyhedron,
    id: u32,
    size_class: u16,
    itz_thickness: f64,
    phase: &str,
) -> PyResult<PyAggregate> {
    let kind = [Kind::Aggregate, Kind::Void, Kind::Fibre].into_iter().find(|kind| kind.name() == phase);
    let kind =
        kind.ok_or_else(|| PyValueError::new_err(format!("the pickle is damaged: there is no phase {phase:?}")))?;
    let body = body.0.as_ref().clone();
    Ok(PyAggregate(Aggregate { id, kind, class: size_class, itz_thickness_mm: itz_thickness, body }))
}

/// The voids and fibres of a packing, as copies.
pub(crate) fn inclusions(model: &Model) -> Vec<PyAggregate> {
    model.inclusions.iter().cloned().map(PyAggregate).collect()
}

impl PyAggregates {
    /// The positions of what equals `value`.
    fn equal_to(&self, value: &Bound<'_, PyAny>) -> impl Iterator<Item = usize> {
        let value = value.cast::<PyAggregate>().ok().map(|aggregate| aggregate.get().0.clone());
        let same = move |aggregate: &Aggregate| value.as_ref() == Some(aggregate);
        self.0.aggregates.iter().enumerate().filter(move |(_, aggregate)| same(aggregate)).map(|(position, _)| position)
    }

    fn at(&self, index: usize) -> PyAggregate {
        PyAggregate(self.0.aggregates[index].clone())
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
            return Err(PyTypeError::new_err(format!("aggregates are indexed by int or slice, not {given}")));
        }
        // What does not fit a machine word is out of range like any other.
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
        found.ok_or_else(|| PyValueError::new_err(format!("{value} is not among the aggregates")))
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
        format!("<{} aggregates>", self.__len__())
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
