//! Python bindings of mesocrete: thin, frozen views of the core's types.
//!
//! Every class is immutable and shares its data by reference counting, so threads need no locks. Work that takes
//! longer than a moment lets go of the GIL.
#![forbid(unsafe_code)]

mod aggregate;
mod arrays;
mod beside;
mod boundary;
mod command;
mod effective;
mod files;
mod gjk;
mod mesh;
mod packing;
mod pickle;
mod polyhedron;
mod response;
mod run;
mod spec;
mod study;
mod tree;
mod views;

use pyo3::prelude::*;

/// The compiled part of the `mesocrete` package; import that one.
#[pymodule(gil_used = false)]
mod _mesocrete {
    #[pymodule_export]
    use super::aggregate::{PyAggregate, restore_aggregate};
    #[pymodule_export]
    use super::command::run_command;
    #[pymodule_export]
    use super::gjk::{PyBodies, closest_points, distance, intersects, intersects_many, penetration, time_of_impact};
    #[pymodule_export]
    use super::mesh::{PyMesh, restore_mesh};
    #[pymodule_export]
    use super::packing::{PyAggregates, PyPacking, from_labels, load, of_labels, pack, restore_packing};
    #[pymodule_export]
    use super::polyhedron::{PyPolyhedron, convex_hull, restore_polyhedron};
    #[pymodule_export]
    use super::response::{PyFrame, PyResponse, checked_test, restore_frame, restore_response};
    #[pymodule_export]
    use super::run::usual_threads;
    #[pymodule_export]
    use super::spec::{PySpec, all_recipes, concrete_materials, restore_spec};
    #[pymodule_export]
    use super::study::{PyFit, PyLock, PyStudyCase, PyStudyPlan, PyStudyRun, study_case, study_results};
    #[pymodule_export]
    use super::views::colours;
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        // Without numpy, which the command never needs: the package imports it before anything that makes arrays.
        let sequence = module.py().import("collections.abc")?.getattr("Sequence")?;
        sequence.call_method1("register", (module.getattr("Aggregates")?,))?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
