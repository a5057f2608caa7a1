//! Stresses at the voxels, for viewers.

use super::equations::Elastic;
use crate::field::Place;
use meso_concrete::parallel;
use std::io::{self, Write};

/// Names of strains and stresses in the order of this crate.
pub(crate) const COMPONENTS: [&str; 6] = ["xx", "yy", "zz", "yz", "zx", "xy"];
/// Components in VTK's order of a symmetric tensor: xx, yy, zz, xy, yz, xz.
pub(crate) const OF_VTK: [usize; 6] = [0, 1, 2, 5, 3, 4];

/// Mean stress of every voxel for a unit of mean strain, MPa.
#[derive(Clone, Debug, PartialEq)]
pub struct StressField {
    /// Component of the mean strain: 0 to 5 for xx, yy, zz, yz, zx, xy.
    pub strain: usize,
    /// Voxels along x, y, z.
    pub counts: [usize; 3],
    /// Lower corner, mm.
    pub origin_mm: [f64; 3],
    /// Edges of a voxel, mm.
    pub spacing_mm: [f64; 3],
    /// Stresses xx, yy, zz, xy, yz, xz, x fastest.
    pub stress: Vec<[f32; 6]>,
}

impl StressField {
    /// The stresses of displacements `u` and a mean strain.
    pub(super) fn new(elastic: &Elastic<'_>, u: &[f64], mean: &[f64; 6], strain: usize) -> Self {
        let grid = elastic.grid;
        let [nx, ny, nz] = grid.counts;
        let state = elastic.state(u, mean);
        let mut stress = vec![[0.0; 6]; nx * ny * nz];
        parallel::chunks_mut(&mut stress, nx * ny, |k, layer| {
            for (number, to) in layer.iter_mut().enumerate() {
                let stress = state.mean_stress([number % nx, number / nx, k]);
                *to = OF_VTK.map(|row| stress[row] as f32);
            }
        });
        Self { strain, counts: grid.counts, origin_mm: grid.origin.into(), spacing_mm: grid.spacing.into(), stress }
    }

    /// Writes VTK image data (`.vti`) for ParaView and PyVista.
    ///
    /// # Errors
    /// Fails with the errors of `out`.
    pub fn write_vti(&self, out: impl Write) -> io::Result<()> {
        let Self { counts, origin_mm, spacing_mm, stress, .. } = self;
        let place = Place { counts: *counts, origin_mm: *origin_mm, spacing_mm: *spacing_mm };
        place.write_vti("Tensors=\"stress\"", &[("stress", 6, stress.as_flattened())], out)
    }
}

/// Von Mises' stress of stresses xx, yy, zz, xy, yz, xz.
pub(crate) fn von_mises(stress: &[f32]) -> f32 {
    let [xx, yy, zz, xy, yz, xz] = std::array::from_fn(|i| stress[i]);
    let square = |a: f32| a * a;
    let normal = square(xx - yy) + square(yy - zz) + square(zz - xx);
    (normal / 2.0 + 3.0 * (square(xy) + square(yz) + square(xz))).sqrt()
}
