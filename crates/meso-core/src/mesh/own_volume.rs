//! Corrects the volume of every aggregate in a fitted mesh: chords cut its corners off, and parted gaps cells.
//!
//! The nodes between an aggregate and the mortar move along the surface's normals, all of one aggregate by one distance: its
//! missing volume over the area that moves, some hundredths of a millimetre. Nodes of cells that would get too flat move half
//! as far, and the next round distributes the rest. Nodes on the specimen's sides, and between more than two materials, stay.

use super::cells::{Mesh, NO_AGGREGATE, Phase};
use super::interface::{self, Owners};
use super::quality::{cell_volume, stable_length};
use super::sides::Sides;
use super::tet::dihedral_cosines;
use crate::aggregate::Aggregate;
use crate::math::Vec3;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Times that the missing volumes are shared out.
const ROUNDS: usize = 6;
/// Volumes are right when this share of them all is missing.
const CLOSE: f64 = 1e-4;
/// The most that a node moves in a round, over the element size.
const STEP: f64 = 0.05;
/// No cell gets a sharper angle than this, degrees, unless it has one already.
const SHARPEST_DEG: f64 = 9.0;
/// A round leaves cells whose stable length is below a tenth of the element size this share of it.
const KEPT: f64 = 0.97;
/// Halvings of a node's displacement before it stays.
const HALVINGS: usize = 3;

/// Moves the interface nodes of `mesh`, of tetrahedra, until every aggregate has the volume that its body has.
pub(super) fn restore(mesh: &mut Mesh, bodies: &[Aggregate], element_size_mm: f64) {
    let exact: BTreeMap<u32, f64> = bodies.iter().map(|body| (body.id, body.body.volume())).collect();
    let surface = Surface::of(mesh);
    for _ in 0..ROUNDS {
        let missing = missing(mesh, &exact);
        if missing.values().map(|volume| volume.abs()).sum::<f64>() < CLOSE * exact.values().sum::<f64>() {
            return;
        }
        let mut displacements = surface.displacements(mesh, &missing, STEP * element_size_mm);
        surface.shorten(mesh, &mut displacements, element_size_mm / 10.0);
        mesh.points.par_iter_mut().zip(&displacements).for_each(|(point, displacement)| *point += displacement);
    }
}

/// The volume that every aggregate lacks in `mesh`, mm3.
fn missing(mesh: &Mesh, exact: &BTreeMap<u32, f64>) -> BTreeMap<u32, f64> {
    let mut missing = exact.clone();
    let cells = mesh.cells().zip(&mesh.phase).zip(&mesh.aggregate);
    for ((cell, _), id) in cells.filter(|((_, phase), _)| **phase == Phase::Aggregate) {
        *missing.get_mut(id).expect("a cell's aggregate is a body") -= cell_volume(mesh.kind, cell, &mesh.points);
    }
    missing
}

/// What may move.
struct Surface {
    /// For every node the aggregate whose surface it slides off, [`NO_AGGREGATE`] where it stays.
    owner: Vec<u32>,
    /// The aggregates' faces that have such nodes, with their aggregates.
    faces: Vec<([u32; 3], u32)>,
    /// The cells that have such nodes.
    cells: Vec<u32>,
}

impl Surface {
    fn of(mesh: &Mesh) -> Self {
        let (owners, sides) = (Owners::of(mesh.by_aggregate()), Sides::of(mesh));
        let between = owners.bodies(|node| owners.are_several(node) && sides.on(node) == 0);
        let mut owner = vec![NO_AGGREGATE; mesh.points.len()];
        for owners in between.chunk_by(|a, b| a.0 == b.0).filter(|owners| owners.len() == 1) {
            owner[owners[0].0 as usize] = owners[0].1;
        }
        let moves = |node: &u32| owner[*node as usize] != NO_AGGREGATE;
        let cores = interface::faces(mesh.by_aggregate())
            .into_iter()
            .filter(|face| mesh.phase[face.cell as usize] == Phase::Aggregate);
        let faces = cores.map(|face| ([0, 1, 2].map(|i| face.nodes[i]), mesh.aggregate[face.cell as usize]));
        let faces = faces.filter(|(nodes, _)| nodes.iter().any(moves)).collect();
        let cells =
            (0..).zip(mesh.cells()).filter(|(_, cell)| cell.iter().any(moves)).map(|(number, _)| number).collect();
        Self { owner, faces, cells }
    }

    /// The displacement of every node, `most` mm at most.
    fn displacements(&self, mesh: &Mesh, missing: &BTreeMap<u32, f64>, most: f64) -> Vec<Vec3> {
        // The gradient of the aggregate's volume by the node's position: a third of the area vectors around it.
        let mut normals = vec![Vec3::zeros(); mesh.points.len()];
        for (nodes, id) in &self.faces {
            let [a, b, c] = nodes.map(|node| mesh.points[node as usize]);
            let third = (b - a).cross(&(c - a)) / 6.0;
            nodes
                .iter()
                .filter(|node| self.owner[**node as usize] == *id)
                .for_each(|node| normals[*node as usize] += third);
        }
        let mut areas: BTreeMap<u32, f64> = BTreeMap::new();
        for (normal, owner) in normals.iter().zip(&self.owner).filter(|(_, owner)| **owner != NO_AGGREGATE) {
            *areas.entry(*owner).or_default() += normal.norm();
        }
        let distance = |id: u32| (missing[&id] / areas[&id]).clamp(-most, most);
        let displacement = |(normal, owner): (&Vec3, &u32)| match normal.norm() {
            0.0 => Vec3::zeros(),
            length => normal * (distance(*owner) / length),
        };
        normals.par_iter().zip(&self.owner).map(displacement).collect()
    }

    /// Halves the displacements of the nodes whose cells would get too flat, at last to zero.
    fn shorten(&self, mesh: &Mesh, displacements: &mut [Vec3], short: f64) {
        let mut watched = self.cells.clone();
        for halving in 0.. {
            let after = |node: &u32| mesh.points[*node as usize] + displacements[*node as usize];
            let is_flat = |number: &&u32| {
                let cell = &mesh.cells[4 * **number as usize..][..4];
                let [before, after] =
                    [[0, 1, 2, 3].map(|i| mesh.points[cell[i] as usize]), [0, 1, 2, 3].map(|i| after(&cell[i]))];
                before != after && flattens(before, after, short)
            };
            let flat: Vec<u32> = watched.par_iter().filter(is_flat).copied().collect();
            if flat.is_empty() {
                return;
            }
            let mut nodes: Vec<u32> =
                flat.iter().flat_map(|&cell| mesh.cells[4 * cell as usize..][..4].to_vec()).collect();
            nodes.sort_unstable();
            nodes.dedup();
            let share = if halving < HALVINGS { 0.5 } else { 0.0 };
            nodes.iter().for_each(|&node| displacements[node as usize] *= share);
            // Elsewhere nothing has changed.
            let has_shortened = |cell: &&u32| {
                mesh.cells[4 * **cell as usize..][..4].iter().any(|node| nodes.binary_search(node).is_ok())
            };
            watched = self.cells.par_iter().filter(has_shortened).copied().collect();
        }
    }
}

/// Whether a tetrahedron gets worse than it may.
fn flattens(before: [Vec3; 4], after: [Vec3; 4], short: f64) -> bool {
    let sharpest = libm::cos(SHARPEST_DEG.to_radians());
    let ([_, was], [_, is]) = (dihedral_cosines(before), dihedral_cosines(after));
    let (length, now) = (stable_length(before), stable_length(after));
    is > sharpest.max(was) || now < short.min(KEPT * length)
}
