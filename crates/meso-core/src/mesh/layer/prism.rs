//! The prisms between interface triangles and their images, cut into the layer's tetrahedra.

use super::periodic::Ties;
use super::settle::{LayerCell, StepsBack};
use crate::math::Vec3;
use crate::mesh::cells::Phase;
use crate::mesh::interface::{Copies, InterfaceFace};
use crate::mesh::tet::TetMesh;
use rayon::prelude::*;

/// Tetrahedra with their phases, in a specimen that may repeat itself.
pub(in crate::mesh) struct Layered {
    pub(in crate::mesh) mesh: TetMesh,
    pub(in crate::mesh) phase: Vec<Phase>,
    /// The directions in which the specimen repeats itself.
    pub(in crate::mesh) periodic: [bool; 3],
}

/// The prism between an interface triangle and its image; diagonals start at the lowest place, so neighbours match, and
/// the opposite faces of a periodic box.
pub(super) fn prism(mesh: &TetMesh, face: &InterfaceFace, copies: &Copies, ties: &Ties) -> [LayerCell; 3] {
    let owner = mesh.owner[face.cell as usize];
    let [a, b, c, _] = face.nodes;
    let p = |node: u32| -> Vec3 { mesh.position(node) };
    let area = (p(b) - p(a)).cross(&(p(c) - p(a))).norm() / 2.0;
    let mut rails = [a, b, c].map(|node| [copies.of(owner, node), node]);
    let rank = |node: u32| (ties.place(node), node);
    let turns = [(a, b), (b, c), (a, c)].iter().filter(|(first, second)| rank(*first) > rank(*second)).count();
    rails.sort_unstable_by_key(|rail| rank(rail[1]));
    let [[a, d], [b, e], [c, f]] = rails;
    [([a, b, c, f], rails[2]), ([a, e, b, f], rails[1]), ([a, d, e, f], rails[0])].map(|(nodes, rail)| {
        let [i, j, k, l] = nodes;
        // Positive when the rails are in an even order, since the face is counter-clockwise from outside.
        let nodes = if turns % 2 == 0 { nodes } else { [j, i, k, l] };
        LayerCell { nodes, rail, owner, area }
    })
}

/// Adds the layer's cells, and takes back the copies that did not move, with the cells on their rails; the rails that are left.
pub(super) fn append(layered: &mut Layered, layer: &[LayerCell], copies: &Copies, back: &StepsBack) -> Vec<[u32; 2]> {
    let Layered { mesh, phase, .. } = layered;
    let mut rails = Vec::new();
    for cell in layer.iter().filter(|cell| !back.is_pinched(cell.rail[0])) {
        mesh.push(cell.nodes, cell.owner);
        phase.push(Phase::Itz);
    }
    let mut number: Vec<u32> = (0..mesh.points.len() as u32).collect();
    let mut next = (mesh.points.len() - copies.iter().len()) as u32;
    for (_, node, copy) in copies.iter() {
        if back.is_pinched(copy) {
            number[copy as usize] = node;
        } else {
            mesh.points[next as usize] = mesh.points[copy as usize];
            number[copy as usize] = next;
            rails.push([next, node]);
            next += 1;
        }
    }
    mesh.points.truncate(next as usize);
    mesh.cells.par_iter_mut().flatten().for_each(|node| *node = number[*node as usize]);
    rails
}
