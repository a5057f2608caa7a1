//! The ITZ as zero-thickness cohesive elements between every aggregate and what it meets; fibres are bonded.

use super::interface::{self, InterfaceFace};
use super::separate::separate;
use super::{Mesh, NO_AGGREGATE, Phase};

/// Parts the aggregates from the mortar and from each other, and joins them by cohesive elements.
///
/// Node order as Abaqus wants COH3D6 and COH3D8: the bottom face, here the aggregate's, then the top face's nodes over
/// them. The bottom face is counter-clockwise seen from the top, so that its normal, the thickness direction, points out
/// of the aggregate. Between two aggregates the bottom is that of the lower id.
pub(super) fn add(mesh: &mut Mesh) {
    let mut faces = interface::faces(mesh);
    faces.retain(|face| mesh.phase[face.cell as usize] != Phase::Fibre);
    let copies = separate(mesh, &faces, true);
    faces.retain(|face| mesh.aggregate[face.cell as usize] < mesh.aggregate[face.behind as usize]);
    let join = |face: &InterfaceFace| {
        let [inside, outside] = [face.cell, face.behind].map(|cell| mesh.aggregate[cell as usize]);
        let own = |aggregate: u32| {
            let of = |&node: &u32| if aggregate == NO_AGGREGATE { node } else { copies.of(aggregate, node) };
            face.nodes().iter().map(of).collect::<Vec<u32>>()
        };
        [own(inside), own(outside)].concat()
    };
    let joined: Vec<u32> = faces.iter().flat_map(join).collect();
    let aggregate: Vec<u32> = faces.iter().map(|face| mesh.aggregate[face.cell as usize]).collect();
    mesh.cohesive = joined;
    mesh.cohesive_aggregate = aggregate;
}
