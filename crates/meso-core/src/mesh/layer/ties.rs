//! Nodes on the faces of a periodic box: they stay in their faces, and images of each other go the same ways.
//!
//! A place on a face has a node on every side that it is seen from, and after materials are parted one for each body
//! there. Images of a place that belong to the same body are *tied*: one of them leads, the others follow it bit for bit.
//! Where they are not alike (one side has an interface and the other none, or another body behind the face, as where an
//! aggregate ends at the face itself), none of the place's nodes moves: the layer has no thickness there.

use super::bodies::{Bodies, Key};
use super::faces::Faces;
use super::flat::Flat;
use crate::math::Vec3;
use crate::mesh::sides::Sides;
use crate::mesh::{Mesh, NO_AGGREGATE};

/// How the nodes hang together.
pub(super) struct Ties {
    pub(super) faces: Faces,
    /// For every node the one that leads it; itself where it is tied to none.
    lead: Vec<u32>,
    /// Nodes with their leads, but for the leads themselves.
    followers: Vec<(u32, u32)>,
    /// Leads that do not move.
    pinned: Vec<bool>,
}

impl Ties {
    /// Those of `mesh`, whose cells carry indices of `bodies`; nodes from `copies` on are copies, each of its `owner`.
    pub(super) fn new(mesh: &Mesh, bodies: &Bodies, owner: &[u32], copies: u32) -> Self {
        let nodes = 0..mesh.points.len() as u32;
        let tied = |faces, pinned| Self { faces, lead: nodes.clone().collect(), followers: Vec::new(), pinned };
        if mesh.periodic == [false; 3] {
            return tied(Faces::of(mesh), vec![false; nodes.len()]);
        }
        let sides = Sides::of(mesh);
        let faces = Faces::on(mesh, &sides);
        let lone = |node| faces.place(node).is_none() && faces.flat(node) != Flat::SPACE;
        let pinned = nodes.clone().map(lone).collect();
        let unlike = unlike(mesh, &sides, &faces, bodies);
        let mut ties = tied(faces, pinned);
        ties.tie(bodies, owner, copies, &unlike);
        ties
    }

    fn tie(&mut self, bodies: &Bodies, owner: &[u32], copies: u32, unlike: &[bool]) {
        let mut members: Vec<(u32, Key, u8, u32)> = Vec::new();
        for (node, &body) in (0..).zip(owner).filter(|(_, body)| **body != NO_AGGREGATE) {
            let at = self.faces.place(node);
            members.extend(at.map(|(place, along)| (place, bodies.key(body, along), along, node)));
        }
        members.sort_unstable();
        for tied in members.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let (place, lead) = (tied[0].0, tied[0].3);
            let alike = tied.iter().all(|member| (member.3 < copies) == (lead < copies));
            let images = self.faces.at(place).filter(|node| *node < copies).count();
            if alike && tied.len() == images && !unlike[place as usize] {
                tied[1..].iter().for_each(|member| self.follow(member.3, lead));
            } else {
                tied.iter().for_each(|member| self.pinned[member.3 as usize] = true);
            }
        }
    }

    fn follow(&mut self, node: u32, lead: u32) {
        self.lead[node as usize] = lead;
        self.followers.push((node, lead));
    }

    /// The faces that a node has to stay in.
    pub(super) fn flat(&self, node: u32) -> Flat {
        self.faces.flat(node)
    }

    pub(super) fn lead(&self, node: u32) -> u32 {
        self.lead[node as usize]
    }

    pub(super) fn leads(&self, node: u32) -> bool {
        self.lead(node) == node
    }

    /// One number for all images of a node's place.
    pub(super) fn place(&self, node: u32) -> u32 {
        self.faces.place(node).map_or(node, |(place, _)| place)
    }

    /// Neither the node nor any that it is tied to moves.
    pub(super) fn is_pinned(&self, node: u32) -> bool {
        self.pinned[self.lead(node) as usize]
    }

    /// The node is to stay where it is, and all that it is tied to.
    pub(super) fn pin(&mut self, node: u32) {
        self.pinned[self.lead[node as usize] as usize] = true;
    }

    /// Puts the nodes on faces exactly there, and images of one place at the same coordinates within their faces.
    pub(super) fn align(&self, points: &mut [Vec3]) {
        for node in (0..points.len() as u32).filter(|&node| self.flat(node) != Flat::SPACE) {
            points[node as usize] = self.faces.put(node, &points[self.place(node) as usize]);
        }
    }

    /// Moves the followers as their leads: within their faces they have the same coordinates afterwards.
    pub(super) fn spread(&self, points: &mut [Vec3]) {
        for &(node, lead) in &self.followers {
            points[node as usize] = self.faces.put(node, &points[lead as usize]);
        }
    }

    /// Gives the followers what their leads have.
    pub(super) fn share<T: Copy>(&self, values: &mut [T]) {
        self.followers.iter().for_each(|&(node, lead)| values[node as usize] = values[lead as usize]);
    }
}

/// The places of triangles on the faces that lack one opposite to them with the same body behind it.
fn unlike(mesh: &Mesh, sides: &Sides, of: &Faces, bodies: &Bodies) -> Vec<bool> {
    let mut unlike = vec![false; mesh.points.len()];
    for axis in (0..3).filter(|axis| mesh.periodic[*axis]) {
        let mut triangles: Vec<([u32; 3], Key)> = Vec::new();
        for (upper, faces) in [(0, &sides.faces()[2 * axis]), (1, &sides.faces()[2 * axis + 1])] {
            for &(cell, face) in faces {
                let nodes = [0, 1, 2].map(|i| mesh.cells[4 * cell as usize + mesh.kind.faces()[face][i]]);
                // What has no image stays by itself.
                let mut corners = nodes.map(|node| of.place(node).map_or(node, |(place, _)| place));
                corners.sort_unstable();
                triangles.push((corners, bodies.key(mesh.aggregate[cell as usize], upper << axis)));
            }
        }
        triangles.sort_unstable();
        for lone in triangles.chunk_by(|a, b| a == b).filter(|same| same.len() == 1) {
            lone[0].0.iter().for_each(|&place| unlike[place as usize] = true);
        }
    }
    unlike
}
