//! Voxel mesh: a regular grid of hexahedra, each of the phase of its centre, or as its sub-samples say.
//!
//! A centre is in an aggregate when all face planes have it inside, and in the ITZ when it is also outside the inward
//! offset by the shell's thickness: max_i (n_i . x - d_i) > -t. By default t is at least the voxel's edge, so that along
//! every axis one ITZ voxel or more lies between core and mortar (a shell h thick is crossed over a length of at least h).

use super::cells::{CellKind, Draft, NO_BODY, Phase};
use super::location::{Facets, Label, PointGrid, Scan};
use super::options::MeshOptions;
use super::subsamples::{Claim, settle};
use crate::aggregate::{Aggregate, Kind};
use crate::math::Vec3;
use crate::packing::Specimen;
use rayon::prelude::*;

/// Samples of a voxel along an axis where there are fibres, at least. Few voxels have their centre in a fibre thinner than they
/// are: which ones is chance, and all fibres of a 100 mm cube together were 1.2 % off.
const FIBRE_SAMPLES: u32 = 4;

/// The voxel mesh of `bodies` in `specimen`.
pub(super) fn build(
    bodies: &[Aggregate],
    specimen: &Specimen,
    options: &MeshOptions,
    thin_itz: bool,
    subsamples: u32,
) -> Draft {
    let voxels = Voxels::of(specimen, options.element_size_mm);
    let facets =
        Facets::all(bodies, |a| shell_thickness(a, if thin_itz { 0.0 } else { voxels.spacing.max() }, options));
    let has_fibres = bodies.iter().any(|body| body.kind == Kind::Fibre);
    let labels = voxels.labels(bodies, &facets, subsamples.max(if has_fibres { FIBRE_SAMPLES } else { 1 }) as usize);
    let phase = labels.par_iter().map(|&label| phase_of(label, &facets)).collect();
    let owner = labels.par_iter().map(|label| label.body().unwrap_or(NO_BODY)).collect();
    Draft { kind: CellKind::Hexahedron, points: voxels.points(), cells: voxels.cells(), phase, owner }
}

/// The thickness an aggregate's shell has in a voxel mesh, `least` mm or more; 0 for none.
fn shell_thickness(aggregate: &Aggregate, least: f64, options: &MeshOptions) -> f64 {
    match options.shell_mm(aggregate) {
        0.0 => 0.0,
        thickness => thickness.max(least),
    }
}

fn phase_of(label: Label, facets: &[Facets]) -> Phase {
    match label.body() {
        None => Phase::Mortar,
        Some(_) if label.in_shell() => Phase::Itz,
        Some(body) => facets[body as usize].phase,
    }
}

/// Whole voxels that fill the specimen's box.
struct Voxels {
    min: Vec3,
    max: Vec3,
    spacing: Vec3,
    counts: [usize; 3],
}

impl Voxels {
    fn of(specimen: &Specimen, element_size: f64) -> Self {
        let aabb = specimen.aabb();
        let counts = [0, 1, 2].map(|i| (aabb.size()[i] / element_size).round().max(1.0) as usize);
        let spacing = Vec3::from_fn(|i, _| aabb.size()[i] / counts[i] as f64);
        Self { min: aabb.min, max: aabb.max, spacing, counts }
    }

    fn labels(&self, bodies: &[Aggregate], facets: &[Facets], n: usize) -> Vec<Label> {
        let spacing = self.spacing / n as f64;
        let grid = PointGrid { origin: self.min + spacing / 2.0, spacing, counts: self.counts.map(|c| c * n) };
        let scan = Scan::new(grid, facets);
        let mut labels = vec![Label::MORTAR; self.counts.iter().product()];
        let layers = labels.par_chunks_mut(self.counts[0] * self.counts[1]).enumerate();
        if n == 1 {
            layers.for_each(|(k, layer)| scan.label_layer(k, layer));
        } else {
            let claims: Vec<_> = layers.map(|(k, layer)| self.sample_layer(&scan, grid, n, k, layer)).collect();
            settle(claims.concat(), n * n * n, bodies, &mut labels);
        }
        labels
    }

    /// Labels the voxels of layer `k` whose n x n x n samples agree; the claims on the others.
    fn sample_layer(&self, scan: &Scan, fine: PointGrid, n: usize, k: usize, layer: &mut [Label]) -> Vec<Claim> {
        let mut samples = vec![Label::MORTAR; fine.layer_len() * n];
        for (sub, labels) in samples.chunks_exact_mut(fine.layer_len()).enumerate() {
            scan.label_layer(k * n + sub, labels);
        }
        let first = (k * layer.len()) as u32;
        let (mut claims, mut of_voxel) = (Vec::new(), Vec::with_capacity(n * n * n));
        for (voxel, label) in layer.iter_mut().enumerate() {
            let (i, j) = (voxel % self.counts[0] * n, voxel / self.counts[0] * n);
            of_voxel.clear();
            for row in (0..n * n).map(|r| r / n * fine.layer_len() + (j + r % n) * fine.counts[0] + i) {
                of_voxel.extend_from_slice(&samples[row..row + n]);
            }
            if of_voxel.iter().all(|sample| *sample == of_voxel[0]) {
                *label = of_voxel[0];
            } else {
                of_voxel.sort_unstable();
                claims.extend(Claim::of(first + voxel as u32, &of_voxel));
            }
        }
        claims
    }

    fn points(&self) -> Vec<Vec3> {
        // The last plane takes the box's own coordinate: a rounded multiple would miss the face.
        let at = |axis: usize, i: usize| {
            if i == self.counts[axis] { self.max[axis] } else { self.min[axis] + i as f64 * self.spacing[axis] }
        };
        let [nx, ny, nz] = self.counts.map(|c| c + 1);
        let point = |p: usize| Vec3::new(at(0, p % nx), at(1, p / nx % ny), at(2, p / (nx * ny)));
        (0..nx * ny * nz).into_par_iter().map(point).collect()
    }

    fn cells(&self) -> Vec<u32> {
        let [nx, ny, nz] = self.counts;
        let (row, layer) = (nx as u32 + 1, (nx as u32 + 1) * (ny as u32 + 1));
        let mut cells = vec![0; 8 * nx * ny * nz];
        cells.par_chunks_exact_mut(8).enumerate().for_each(|(c, cell)| {
            let (i, j, k) = ((c % nx) as u32, (c / nx % ny) as u32, (c / (nx * ny)) as u32);
            let a = k * layer + j * row + i;
            let bottom = [a, a + 1, a + 1 + row, a + row];
            cell[..4].copy_from_slice(&bottom);
            cell[4..].copy_from_slice(&bottom.map(|node| node + layer));
        });
        cells
    }
}
