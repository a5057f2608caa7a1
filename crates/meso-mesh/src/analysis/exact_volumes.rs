//! Exact volumes of the aggregates.
//!
//! In a fitted mesh chords cut corners off the aggregates, and parted gaps cells: [`restore`] gives them their volume back. The
//! nodes between an aggregate and the mortar move along the surface's normals, all of one aggregate by one distance: its
//! missing volume over the area that moves, some hundredths of a millimetre. Nodes of cells that would get too flat move half
//! as far, and the next round distributes the rest. Nodes on the specimen's sides, and between more than two materials, stay.

use crate::body_images::BodyImages;
use crate::cells::{Mesh, NO_BODY, Owners, Sides, faces, owned_volumes};
use crate::tet::{ascending, cos2_of, dihedral_cosines, min_dihedral_cos2, stable_length};
use meso_collision::math::Vec3;
use meso_concrete::parallel;

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
pub(crate) fn restore(mesh: &mut Mesh, bodies: &BodyImages, element_size_mm: f64) {
    let exact = exact(bodies);
    let surface = MovingSurface::of(mesh);
    for _ in 0..ROUNDS {
        let missing = missing(mesh, &exact);
        if missing.iter().map(|volume| volume.abs()).sum::<f64>() < CLOSE * exact.iter().sum::<f64>() {
            return;
        }
        let mut displacements = surface.displacements(mesh, &missing, STEP * element_size_mm);
        surface.shorten(mesh, &mut displacements, element_size_mm / 10.0);
        parallel::each_short_mut(&mut mesh.points, |node, point| *point += displacements[node]);
    }
}

/// Volume of every body that is in the specimen, mm3.
fn exact(bodies: &BodyImages) -> Vec<f64> {
    let last = |body: u32| bodies.images(body).last().map_or(0.0, |body| body.body.volume());
    (0..bodies.id_of.len() as u32).map(last).collect()
}

/// The volume that every aggregate lacks in `mesh`, mm3.
fn missing(mesh: &Mesh, exact: &[f64]) -> Vec<f64> {
    let mut missing = exact.to_vec();
    owned_volumes(mesh.by_owner(), |cell, volume| {
        if mesh.phase[cell].is_aggregate() {
            missing[mesh.owner[cell] as usize] -= volume;
        }
    });
    missing
}

/// The nodes that may move, with their faces and cells.
struct MovingSurface {
    /// For every node the aggregate whose surface it slides off, [`NO_BODY`] where it stays.
    owner: Vec<u32>,
    /// The aggregates' faces that have such nodes, with their aggregates.
    faces: Vec<([u32; 3], u32)>,
    /// The cells that have such nodes.
    cells: Vec<u32>,
}

impl MovingSurface {
    fn of(mesh: &Mesh) -> Self {
        let (owners, sides) = (Owners::of(mesh.by_owner()), Sides::of(mesh));
        let moving = |node: u32| owners.beside_mortar(node).filter(|_| sides.on(node) == 0).unwrap_or(NO_BODY);
        let owner: Vec<u32> = (0..mesh.points.len() as u32).map(moving).collect();
        let moves = |node: &u32| owner[*node as usize] != NO_BODY;
        let cores = faces(mesh.by_owner()).into_iter().filter(|face| mesh.phase[face.cell as usize].is_aggregate());
        let faces = cores.map(|face| ([0, 1, 2].map(|i| face.nodes[i]), mesh.owner[face.cell as usize]));
        let faces = faces.filter(|(nodes, _)| nodes.iter().any(moves)).collect();
        let cells =
            (0..).zip(mesh.cells()).filter(|(_, cell)| cell.iter().any(moves)).map(|(number, _)| number).collect();
        Self { owner, faces, cells }
    }

    /// The displacement of every node, `most` mm at most.
    fn displacements(&self, mesh: &Mesh, missing: &[f64], most: f64) -> Vec<Vec3> {
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
        let mut areas = vec![0.0; missing.len()];
        for (normal, owner) in normals.iter().zip(&self.owner).filter(|(_, owner)| **owner != NO_BODY) {
            areas[*owner as usize] += normal.norm();
        }
        let distance = |id: u32| (missing[id as usize] / areas[id as usize]).clamp(-most, most);
        parallel::map_short(normals.len(), |node| match normals[node].norm() {
            0.0 => Vec3::zeros(),
            length => normals[node] * (distance(self.owner[node]) / length),
        })
    }

    /// Halves the displacements of the nodes whose cells would get too flat, at last to zero.
    fn shorten(&self, mesh: &Mesh, displacements: &mut [Vec3], short: f64) {
        let mut watched = self.cells.clone();
        let mut has_changed = vec![false; displacements.len()];
        let clear = cos2_of(SHARPEST_DEG + CLEARLY_DEG);
        let corners = |cell: u32| mesh.by_owner().cell(cell as usize);
        for halving in 0.. {
            let after = |node: &u32| mesh.points[*node as usize] + displacements[*node as usize];
            let is_flat = |number: &u32| {
                let cell = corners(*number);
                let [before, after] =
                    [[0, 1, 2, 3].map(|i| mesh.points[cell[i] as usize]), [0, 1, 2, 3].map(|i| after(&cell[i]))];
                before != after && flattens(before, after, short, clear)
            };
            let flat = parallel::pick(&watched, is_flat);
            if flat.is_empty() {
                return;
            }
            let nodes = ascending(flat.iter().flat_map(|&cell| corners(cell)).copied());
            let share = if halving < HALVINGS { 0.5 } else { 0.0 };
            nodes.iter().for_each(|&node| displacements[node as usize] *= share);
            nodes.iter().for_each(|&node| has_changed[node as usize] = true);
            watched = parallel::pick(&self.cells, |&cell| corners(cell).iter().any(|&node| has_changed[node as usize]));
            nodes.iter().for_each(|&node| has_changed[node as usize] = false);
        }
    }
}

/// Angles this much above [`SHARPEST_DEG`] are above it whatever the rounding, degrees.
const CLEARLY_DEG: f64 = 1e-3;

/// Whether a tetrahedron gets worse than it may. Below the measure `clear` its angles are clearly not too sharp.
fn flattens(before: [Vec3; 4], after: [Vec3; 4], short: f64, clear: f64) -> bool {
    let is_sharp = || {
        let sharpest = libm::cos(SHARPEST_DEG.to_radians());
        let ([_, was], [_, is]) = (dihedral_cosines(before), dihedral_cosines(after));
        is > sharpest.max(was)
    };
    let now = stable_length(after);
    min_dihedral_cos2(after) >= clear && is_sharp() || now < short && now < KEPT * stable_length(before)
}
