//! Ways into an aggregate where the ray from its centroid is none: around faces that do not look away from the centroid.
//!
//! Such faces stand where a lattice closed a gap, so that an aggregate reaches out to its neighbour. Their nodes go along
//! the direction that enters all the faces around the node as steeply as can be, far enough for the whole thickness below
//! the least steep of them (at most four times the thickness).

use super::shrink::Shrinks;
use super::steepest::steepest;
use super::ties::Ties;
use crate::math::Vec3;
use crate::mesh::Mesh;
use crate::mesh::interface::InterfaceFace;
use crate::mesh::separate::Copies;

/// A face looks away from the centroid when the cosine between its normal and the ray is above this.
const AWAY: f64 = 0.02;

/// Gives the nodes of faces that do not look away from their aggregate's centroid other images.
pub(super) fn turn(
    mesh: &Mesh,
    faces: &[InterfaceFace],
    copies: &Copies,
    shrinks: &Shrinks,
    ties: &Ties,
    images: &mut [Vec3],
) {
    let p = |node: u32| mesh.points[node as usize];
    let mut normals: Vec<(u32, Vec3)> = Vec::with_capacity(3 * faces.len());
    let mut turned = vec![false; images.len()];
    for face in faces {
        let body = mesh.aggregate[face.cell as usize];
        let [a, b, c, _] = face.nodes;
        let normal = (p(b) - p(a)).cross(&(p(c) - p(a))).normalize();
        let middle = (p(a) + p(b) + p(c)) / 3.0;
        for copy in [a, b, c].map(|node| copies.of(body, node)) {
            let flat = ties.flat(copy);
            let Some(shrink) = shrinks.get(body, flat) else { continue };
            let (slope, ray) = (flat.along(&normal), flat.along(&(middle - shrink.centre)));
            let lead = ties.lead(copy);
            normals.push((lead, slope));
            turned[lead as usize] |= slope.dot(&ray) < AWAY * ray.norm();
        }
    }
    normals.retain(|(copy, _)| turned[*copy as usize] && !ties.is_pinned(*copy));
    // Stable: the normals of a node stay in the faces' order.
    normals.sort_by_key(|(copy, _)| *copy);
    for group in normals.chunk_by(|a, b| a.0 == b.0) {
        let copy = group[0].0;
        let around: Vec<Vec3> = group.iter().map(|(_, normal)| *normal).collect();
        let shrink = shrinks.get(copies.body(copy), ties.flat(copy));
        if let (Some(shrink), Some((way, cosine))) = (shrink, steepest(&around)) {
            images[copy as usize] = p(copy) + way * (shrink.thickness / cosine.max(0.25));
        }
    }
    ties.spread(images);
}
