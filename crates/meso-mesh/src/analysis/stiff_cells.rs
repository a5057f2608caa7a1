//! Stiff cells: no cell of an aggregate asks for a shorter time step than mortar does.
//!
//! Waves are 1.5 times as fast in aggregates, so a flat cell of theirs would set the step of the whole mesh. Where one is
//! flatter than every cell of mortar allows, by the materials' defaults, it becomes mortar itself: a few cells in millions, of
//! some thousandths of a cubic millimetre.

use super::joined::become_mortar;
use crate::cells::{CellKind, Mesh, Phase};
use crate::materials::Materials;
use crate::tet::stable_length;
use meso_concrete::parallel;

/// Gives the mortar the aggregates' cells that would ask for a shorter step than it does, and counts them.
pub(crate) fn spare_stiff(mesh: &mut Mesh) {
    let stiff = stiff_cells(mesh);
    mesh.notes.stiff_cells = stiff.len();
    mesh.notes.stiff_mm3 = stiff.iter().map(|&cell| mesh.volume(cell)).sum();
    become_mortar(mesh, &stiff);
}

/// The cells of aggregates whose stable step is shorter than that of all mortar, ascending; none where there is no mortar.
fn stiff_cells(mesh: &Mesh) -> Vec<usize> {
    if mesh.kind != CellKind::Tetrahedron {
        // Boxes are all alike. Tetrahedra get their middle nodes later.
        return Vec::new();
    }
    let materials = Materials::default();
    let corners = |cell: usize| [0, 1, 2, 3].map(|i| mesh.points[mesh.by_owner().cell(cell)[i] as usize]);
    let steps = parallel::map_short(mesh.cell_count(), |cell| {
        stable_length(corners(cell)) / materials.elastic(mesh.phase[cell], &mesh.phases).wave_speed_mm_per_s()
    });
    let of_mortar = steps.iter().zip(&mesh.phase).filter(|(_, phase)| **phase == Phase::Mortar);
    let shortest = of_mortar.map(|(step, _)| *step).reduce(f64::min).unwrap_or(0.0);
    let is_stiff = |cell: &usize| mesh.phase[*cell].is_aggregate() && steps[*cell] < shortest;
    (0..steps.len()).filter(is_stiff).collect()
}
