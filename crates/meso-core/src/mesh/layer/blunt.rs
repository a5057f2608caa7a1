//! Sharp tetrahedra in and under the layer of a lattice are made blunter, one node at a time.
//!
//! The inner ends of rails and the nodes inside the aggregates move to the best place around them. Where that does not
//! help, a rail collapses ([`collapse`]), at last with those around it ([`together`](super::together)): the layer has no
//! thickness there. What is sharper than [`SHARP_DEG`] is worked
//! at, and no more: a layer of 0.1 mm on elements of 2 mm has angles of some 3 degrees of its own.

use super::Thinned;
use super::balance::balance;
use super::collapse::{bury, collapse};
use super::faces::Faces;
use super::flat::Flat;
use super::together::collapse_together;
use crate::math::Vec3;
use crate::mesh::lattice::{Star, Stars, sharpness, sharpness_of, ways};
use crate::mesh::{Mesh, Phase};
use rayon::prelude::*;

/// Tetrahedra with a smaller dihedral angle are made blunter, degrees.
const SHARP_DEG: f64 = 2.0;
/// Rounds of moving nodes and collapsing rails.
const ROUNDS: usize = 5;
/// Rounds of collapsing rails together, and moving nodes.
const LAST_ROUNDS: usize = 3;
/// Turns of moving nodes in a round; each one looks only at what the one before left.
const TURNS: usize = 8;
/// Lengths of the steps tried, in elements.
const STEPS: [f64; 4] = [0.2, 0.07, 0.025, 0.008];

/// What was done for the angles.
pub(crate) struct Blunted {
    /// Inner ends that left the exact offset.
    pub(crate) shifted: usize,
    /// Rails that collapsed.
    pub(crate) collapsed: usize,
}

/// What the work goes by.
pub(super) struct Task {
    /// For every node the outer end of the rail whose inner end it is, or [`NO_RAIL`].
    pub(super) outer: Vec<u32>,
    /// The nodes that stay: the mortar's, the outer ends of rails, and their images.
    fixed: Vec<bool>,
    /// Images on them move together, within these.
    pub(super) faces: Faces,
    /// The sharpness worked at.
    pub(super) limit: f64,
}

pub(super) const NO_RAIL: u32 = u32::MAX;

/// Works on `mesh`, with elements of about `size` mm and what `layer` says of its layer.
pub(crate) fn blunt(mesh: &mut Mesh, layer: &Thinned, size: f64) -> Blunted {
    let rails = layer.rails.as_slice();
    let task = Task::new(mesh, rails);
    let mut suspects: Vec<u32> = (0..mesh.cell_count() as u32).collect();
    let mut shifted = vec![false; mesh.points.len()];
    let mut dead = vec![false; mesh.cell_count()];
    let mut collapsed = 0;
    for _ in 0..ROUNDS {
        if suspects.is_empty() {
            break;
        }
        for _ in 0..TURNS {
            suspects = task.turn(mesh, &suspects, &mut shifted, size);
        }
        let sharp = task.sharper(mesh, &suspects);
        collapsed += collapse(mesh, &task, &sharp, &mut dead);
        suspects.retain(|&cell| !dead[cell as usize]);
    }
    for _ in 0..LAST_ROUNDS {
        let sharp = task.sharper(mesh, &suspects);
        if sharp.is_empty() {
            break;
        }
        collapsed += collapse_together(mesh, &task, &sharp, &mut dead, &mut suspects);
        suspects.retain(|&cell| !dead[cell as usize]);
        suspects.sort_unstable();
        suspects.dedup();
        for _ in 0..TURNS {
            suspects = task.turn(mesh, &suspects, &mut shifted, size);
        }
    }
    if let Some(exact) = layer.exact_mm3 {
        let mut loose = vec![false; mesh.points.len()];
        rails.iter().zip(&layer.loose).for_each(|(rail, is_loose)| loose[rail[0] as usize] = *is_loose);
        balance(mesh, &task, &loose, exact);
    }
    let shifted = rails.iter().filter(|rail| shifted[rail[0] as usize]).count();
    bury(mesh, &dead);
    Blunted { shifted, collapsed }
}

impl Task {
    fn new(mesh: &Mesh, rails: &[[u32; 2]]) -> Self {
        let mut outer = vec![NO_RAIL; mesh.points.len()];
        let mut fixed = vec![false; mesh.points.len()];
        for &[inner, end] in rails {
            outer[inner as usize] = end;
            fixed[end as usize] = true;
        }
        for (cell, _) in mesh.cells().zip(&mesh.phase).filter(|(_, phase)| **phase == Phase::Mortar) {
            cell.iter().for_each(|&node| fixed[node as usize] = true);
        }
        let faces = Faces::of(mesh);
        let stays =
            |node: u32| !faces.is_matched(node) || faces.images(node).iter().any(|&image| fixed[image as usize]);
        let on_faces: Vec<u32> =
            (0..fixed.len() as u32).filter(|&node| faces.flat(node) != Flat::SPACE && stays(node)).collect();
        on_faces.into_iter().for_each(|node| fixed[node as usize] = true);
        Self { outer, fixed, faces, limit: sharpness_of(SHARP_DEG) }
    }

    /// Moves the nodes of those `suspects` that are too sharp; returns the cells around these nodes.
    fn turn(&self, mesh: &mut Mesh, suspects: &[u32], shifted: &mut [bool], size: f64) -> Vec<u32> {
        let sharp = self.sharper(mesh, suspects);
        let nodes = self.nodes(mesh, &sharp);
        let stars = stars(mesh, &nodes);
        for &node in &nodes {
            if self.better(mesh, node, &stars, size) {
                self.faces.images(node).into_iter().for_each(|image| shifted[image as usize] = true);
            }
        }
        let mut around: Vec<u32> = nodes.iter().flat_map(|&node| stars.cells(node)).copied().chain(sharp).collect();
        around.par_sort_unstable();
        around.dedup();
        around
    }

    /// Those of `cells` that are too sharp; mortar is not the layer's.
    fn sharper(&self, mesh: &Mesh, cells: &[u32]) -> Vec<u32> {
        let sharp = |cell: &&u32| {
            let nodes = tetrahedra(mesh)[**cell as usize];
            mesh.phase[**cell as usize] != Phase::Mortar
                && sharpness(nodes.map(|node| mesh.points[node as usize])) > self.limit
        };
        cells.par_iter().filter(sharp).copied().collect()
    }

    /// The nodes of `cells` that may move, and their images, ascending.
    pub(super) fn nodes(&self, mesh: &Mesh, cells: &[u32]) -> Vec<u32> {
        let all = cells.iter().flat_map(|&cell| tetrahedra(mesh)[cell as usize]);
        let free = all.filter(|&node| !self.fixed[node as usize]);
        let mut nodes: Vec<u32> = free.flat_map(|node| self.faces.images(node)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// Moves the node and its images to the best place around it; false where it is there already, or none of their cells
    /// is too sharp.
    fn better(&self, mesh: &mut Mesh, node: u32, stars: &Stars, size: f64) -> bool {
        let x = mesh.points[node as usize];
        let images = self.faces.images(node);
        let mut all: Vec<(u32, Star)> =
            images.iter().map(|&image| (image, star(mesh, image, stars.cells(image)))).collect();
        let mut best = (all.iter_mut().map(|(_, star)| star.sharpest_first()).fold(-1.0, f64::max), x);
        if best.0 <= self.limit {
            return false;
        }
        for length in STEPS {
            for way in ways() {
                let place = x + self.faces.flat(node).along(&way) * (length * size);
                let worst = |(image, star): &(u32, Star)| star.worst(&self.faces.put(*image, &place), best.0);
                let worst = all.iter().map(worst).fold(-1.0, f64::max);
                if worst < best.0 {
                    best = (worst, place);
                }
            }
        }
        images.iter().for_each(|&image| mesh.points[image as usize] = self.faces.put(image, &best.1));
        best.1 != x
    }
}

/// The cells' nodes.
pub(super) fn tetrahedra(mesh: &Mesh) -> &[[u32; 4]] {
    mesh.cells.as_chunks().0
}

/// The cells around `nodes`.
pub(super) fn stars(mesh: &Mesh, nodes: &[u32]) -> Stars {
    let mut wanted = vec![false; mesh.points.len()];
    nodes.iter().for_each(|&node| wanted[node as usize] = true);
    Stars::new(tetrahedra(mesh), &wanted)
}

/// The star of `node` from `cells` around it.
pub(super) fn star(mesh: &Mesh, node: u32, cells: &[u32]) -> Star {
    let place = |node: u32| -> Vec3 { mesh.points[node as usize] };
    Star::of_cells(node, cells.iter().map(|&cell| (tetrahedra(mesh)[cell as usize], cell)), place)
}
