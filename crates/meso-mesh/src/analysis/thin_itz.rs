//! An ITZ without a layer of its own: cohesive elements of no thickness, or the mortar's cells at the aggregates.

use crate::cells::{InterfaceFace, Mesh, Phase, complete, copies, faces};

/// Parts the aggregates from the mortar and from each other, and joins them by zero-thickness cohesive elements; fibres are
/// bonded.
///
/// Node order as Abaqus wants COH3D6 and COH3D8: the bottom face, here the aggregate's, then the top face's nodes over
/// them. The bottom face is counter-clockwise seen from the top, so that its normal, the thickness direction, points out
/// of the aggregate. Between two aggregates the bottom is that of the lower id.
pub(crate) fn add_cohesive(mesh: &mut Mesh) {
    let mut faces = faces(mesh.by_owner());
    faces.retain(|face| mesh.phase[face.cell as usize] != Phase::Fibre);
    let copies = copies(mesh.by_owner(), &faces, Some(kept(mesh)));
    copies.part(&mut mesh.points, mesh.kind.nodes(), &mut mesh.cells, &mesh.owner);
    faces.retain(|face| mesh.owner[face.cell as usize] < mesh.owner[face.behind as usize]);
    let join = |face: &InterfaceFace| {
        let [inside, outside] = [face.cell, face.behind].map(|cell| mesh.owner[cell as usize]);
        let own = |aggregate: u32| face.nodes().iter().map(move |&node| (aggregate, node));
        let nodes = own(inside).chain(own(outside));
        nodes.map(|(aggregate, node)| copies.of(aggregate, node)).collect::<Vec<u32>>()
    };
    mesh.cohesive = faces.iter().flat_map(join).collect();
    mesh.cohesive_owner = faces.iter().map(|face| mesh.owner[face.cell as usize]).collect();
    if mesh.periodic != [false; 3] {
        complete(mesh);
    }
}

/// Whether mortar or fibres have a node: they keep the original.
fn kept(mesh: &Mesh) -> Vec<bool> {
    let mut kept = vec![false; mesh.points.len()];
    let keeps = |phase: &Phase| matches!(phase, Phase::Mortar | Phase::Fibre);
    for (cell, _) in mesh.cells().zip(&mesh.phase).filter(|(_, phase)| keeps(phase)) {
        cell.iter().for_each(|&node| kept[node as usize] = true);
    }
    kept
}

/// Smears the ITZ over the mortar's cells that have a face on an aggregate, all its corners on the surface of this one.
///
/// Their phase is the ITZ, and they still belong to no aggregate. Fibres are bonded to the mortar and have no ITZ. Decks and
/// the solver read these phases, so that both have the ITZ in the same cells.
pub(crate) fn smear_itz(mesh: &mut Mesh) {
    let owners = mesh.owners(|cell| mesh.phase[cell].is_aggregate());
    for (cell, phase) in mesh.cells.chunks_exact(mesh.kind.nodes()).zip(&mut mesh.phase) {
        let lies_on_one = |face: &&[usize]| owners.have_one_in_common(face.iter().map(|&corner| cell[corner]));
        if *phase == Phase::Mortar && mesh.kind.faces().iter().any(lies_on_one) {
            *phase = Phase::Itz;
        }
    }
}
