//! Memory that a mesh takes, estimated from its options before any of it is taken.
//!
//! Peak memory of the command over the number of cubes of one element size in the specimen. A cube of 50 mm at 30 % was
//! meshed in 125,000 to 2.9 million such cubes, and tested in 31,000 to 244,000. The estimates lie below, so
//! that they refuse nothing that fits: `benches/memory.py`, with figures in `benches/results/memory.csv`.

use super::{Fit, MeshOptions, Method, Order};
use meso_concrete::specimen::Specimen;

/// Bytes per voxel: 76 to 81 were measured.
const VOXEL: f64 = 75.0;
/// Bytes per cube of a plain lattice: 613 were measured.
const PLAIN: f64 = 600.0;
/// Bytes per cube of a fitted lattice: 930 to 1030 were measured, the most with a solid ITZ, with 12.9 to 16 tetrahedra in a
/// cube; without aggregates there are 12.
const FITTED: f64 = 850.0;

/// Bytes per cube of a fitted lattice of second order: 2550 were measured.
const QUADRATIC: f64 = 2300.0;
/// Bytes per voxel in a test: 455 to 477 were measured.
const TESTED_VOXEL: f64 = 420.0;
/// Bytes per cube of a lattice in a test: 5070 were measured at 1.6 mm and 4660 at 1.2 mm, with 15 and 14.3 tetrahedra in a
/// cube; without aggregates there are 12.
const TESTED_LATTICE: f64 = 3800.0;

impl MeshOptions {
    /// Bytes that a mesh of `specimen` takes while it is built and written, roughly and at least.
    ///
    /// The memory of gmsh is not counted: it fills a conforming mesh slab by slab, as its memory allows.
    pub fn bytes(&self, specimen: &Specimen) -> f64 {
        let per_cube = match self.method {
            Method::Voxel { .. } => VOXEL,
            Method::Lattice { order: Order::Quadratic, .. } => QUADRATIC,
            Method::Lattice { fit: Fit::Plain, .. } => PLAIN,
            Method::Lattice { fit: Fit::Fitted, .. } => FITTED,
            Method::Conforming { .. } => return 0.0,
        };
        per_cube * self.cubes(specimen)
    }

    /// Bytes that a test of the mesh takes, the mesh included, roughly and at least.
    pub fn bytes_of_test(&self, specimen: &Specimen) -> f64 {
        let per_cube = match self.method {
            Method::Voxel { .. } => TESTED_VOXEL,
            Method::Lattice { .. } => TESTED_LATTICE,
            Method::Conforming { .. } => return 0.0,
        };
        per_cube * self.cubes(specimen)
    }

    /// Number of cubes of the element size that have the volume of the specimen.
    pub fn cubes(&self, specimen: &Specimen) -> f64 {
        specimen.volume() / self.element_size_mm.powi(3)
    }
}
