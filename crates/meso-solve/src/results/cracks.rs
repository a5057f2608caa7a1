//! The cracked cells' surface as triangles that a page can hold.

use super::snapshot::Snapshot;
use meso_collision::math::{Aabb, Vec3};
use meso_mesh::{CellKind, Mesh};
use std::collections::BTreeMap;

/// A crack that is open less than this is not shown, mm.
const LEAST_MM: f32 = 0.01;
/// Nor one that is open less than this share of the widest: distributed cracks would hide the one that splits the specimen.
const LEAST_SHARE: f32 = 0.2;
/// Most cells that are shown: with four faces each and three bytes a corner the page stays below 15 MB.
const MOST_CELLS: usize = 120_000;

/// Triangles around the cells with the widest cracks.
pub(super) struct Cracks {
    /// Openings from which on cells are shown, mm, and the widest.
    pub(super) openings_mm: [f32; 2],
    /// Cells that are shown.
    pub(super) cells: usize,
    /// Over the longest side of the mesh, 0 to 65,535 along each axis.
    pub(super) corners: Vec<[u16; 3]>,
    /// Opening at every corner, 0 to 255 of the widest.
    pub(super) openings: Vec<u8>,
    /// Corners of the triangles.
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Cracks {
    /// The cracks of a moment; none where no crack is open enough.
    pub(super) fn of(mesh: &Mesh, snapshot: &Snapshot) -> Option<Self> {
        let opening = &snapshot.opening_mm;
        let least = least_shown(opening);
        let shown: Vec<usize> = (0..opening.len()).filter(|&cell| opening[cell] >= least).collect();
        let widest = shown.iter().map(|&cell| opening[cell]).fold(0.0, f32::max);
        if shown.is_empty() {
            return None;
        }
        let aabb = Aabb::around(&mesh.points);
        let mut cracks = Self {
            openings_mm: [least, widest],
            cells: shown.len(),
            corners: Vec::new(),
            openings: Vec::new(),
            triangles: Vec::new(),
        };
        let mut numbers = BTreeMap::new();
        for (cell, face) in outside(mesh, &shown) {
            let share = (255.0 * opening[cell] / widest) as u8;
            let corners: Vec<u32> = face
                .iter()
                .map(|&node| *numbers.entry(node).or_insert_with(|| cracks.corner(mesh, node, &aabb)))
                .collect();
            for &corner in &corners {
                let there = &mut cracks.openings[corner as usize];
                *there = share.max(*there);
            }
            cracks.triangles.extend((2..corners.len()).map(|i| [corners[0], corners[i - 1], corners[i]]));
        }
        Some(cracks)
    }

    fn corner(&mut self, mesh: &Mesh, node: u32, aabb: &Aabb) -> u32 {
        let place: Vec3 = (mesh.points[node as usize] - aabb.min) / aabb.size().max();
        self.corners.push([0, 1, 2].map(|axis| (65_535.0 * place[axis]).round() as u16));
        self.openings.push(0);
        self.openings.len() as u32 - 1
    }
}

/// The opening from which on cells are shown.
fn least_shown(opening: &[f32]) -> f32 {
    let widest = opening.iter().copied().fold(0.0, f32::max);
    let least = LEAST_MM.max(LEAST_SHARE * widest);
    let mut open: Vec<f32> = opening.iter().copied().filter(|&w| w >= least).collect();
    if open.len() <= MOST_CELLS {
        return least;
    }
    let (_, most, _) = open.select_nth_unstable_by(MOST_CELLS, |a, b| b.total_cmp(a));
    // The next wider one, so that cells of one opening are all shown or all left out.
    most.next_up()
}

/// The faces that only one of `cells` has, with that cell.
fn outside(mesh: &Mesh, cells: &[usize]) -> Vec<(usize, Vec<u32>)> {
    let nodes = mesh.kind.nodes();
    let of_cell = |&cell: &usize| {
        let corners = &mesh.cells[cell * nodes..][..nodes];
        mesh.kind.faces().iter().map(move |face| (cell, face.iter().map(|&i| corners[i]).collect::<Vec<u32>>()))
    };
    let mut faces: Vec<([u32; 4], usize, Vec<u32>)> =
        cells.iter().flat_map(of_cell).map(|(cell, face)| (key(mesh.kind, &face), cell, face)).collect();
    faces.sort_unstable();
    let single = faces.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1);
    single.map(|same| (same[0].1, same[0].2.clone())).collect()
}

/// A key that both cells at a face share.
fn key(kind: CellKind, face: &[u32]) -> [u32; 4] {
    let mut key = [u32::MAX; 4];
    debug_assert!(face.len() == kind.faces()[0].len());
    key[..face.len()].copy_from_slice(face);
    key.sort_unstable();
    key
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::{Moment, Snapshot};
    use meso_concrete::specimen::Specimen;
    use meso_mesh::{ItzForm, MeshOptions, Method, Tools};

    fn moment(mesh: &Mesh, openings: &[(usize, f32)]) -> Snapshot {
        let mut opening_mm = vec![0.0; mesh.cell_count()];
        openings.iter().for_each(|&(cell, opening)| opening_mm[cell] = opening);
        Snapshot {
            moment: Moment::default(),
            displacement: Vec::new(),
            stress: Vec::new(),
            damage: Vec::new(),
            tension: Vec::new(),
            compression: Vec::new(),
            opening_mm,
        }
    }

    #[test]
    fn open_cells_show_their_outside_alone() {
        let options =
            MeshOptions { method: Method::VOXEL, element_size_mm: 2.0, itz: ItzForm::None, ..MeshOptions::default() };
        let mesh = meso_mesh::build((&[], &Specimen::cuboid([4.0, 2.0, 8.0])), &options, &Tools::default()).unwrap();
        assert_eq!(mesh.cell_count(), 8);
        // Two neighbours and a third one whose crack is hardly open.
        let cracks = Cracks::of(&mesh, &moment(&mesh, &[(0, 0.05), (1, 0.1), (7, 0.001)])).unwrap();
        assert_eq!((cracks.cells, cracks.triangles.len(), cracks.corners.len()), (2, 2 * 10, 12));
        assert_eq!(cracks.openings_mm, [LEAST_SHARE * 0.1, 0.1]);
        assert_eq!(cracks.openings.iter().filter(|&&share| share == 255).count(), 8);
        let highest = cracks.corners.iter().map(|corner| corner[2]).max();
        assert_eq!(highest, Some(65_535 / 4 + 1), "2 of 8 mm");
        assert!(Cracks::of(&mesh, &moment(&mesh, &[])).is_none());
    }

    #[test]
    fn the_widest_cracks_are_shown_where_there_are_too_many() {
        let openings: Vec<f32> = (0..MOST_CELLS + 10).map(|i| 0.05 + 1e-6 * i as f32).collect();
        let least = least_shown(&openings);
        let shown = openings.iter().filter(|&&opening| opening >= least).count();
        assert!((MOST_CELLS - 100..=MOST_CELLS).contains(&shown), "{shown}");
    }
}
