//! The faces of a periodic box while the layer is made: nodes on them stay in their faces, and images of each other move by
//! the same displacement.
//!
//! The nodes at all images of a position form an *image class*, which has a number. Interfaces duplicate nodes, so that a
//! class may have several nodes at one image, one for each body there. Images of one body are *tied*: one of them leads, the
//! others follow it bit for bit. Where the images differ (one has an interface and the other none, or another body lies
//! behind the face, as where an aggregate ends at the face itself), no node of the class moves: the layer has no thickness
//! there.
//!
//! Nodes in the caps of a body stay in the sides of the box where these are, too, and have no images there.

use crate::cells::{NO_BODY, NodeImages, Sides, repeating};
use crate::tet::{TetMesh, ascending};
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::aggregate::Aggregate;

/// Which nodes move together.
pub(super) struct PeriodicConstraint {
    pub(super) faces: Faces,
    /// The lead of every node; the node itself where it is tied to none.
    lead: Vec<u32>,
    /// Nodes with their leads, but for the leads themselves.
    followers: Vec<(u32, u32)>,
    /// Leads that do not move.
    pinned: Vec<bool>,
}

impl PeriodicConstraint {
    /// The constraint of `mesh`, whose cells carry indices of `bodies`; nodes from `copies` on are copies, each of its `owner`.
    pub(super) fn new(mesh: &TetMesh, periodic: [bool; 3], bodies: &Bodies, owner: &[u32], copies: u32) -> Self {
        let nodes = 0..mesh.points.len() as u32;
        let free = |faces, pinned| Self { faces, lead: nodes.clone().collect(), followers: Vec::new(), pinned };
        let caps = bodies.caps();
        if periodic == [false; 3] {
            return free(Faces::of(mesh, periodic, &caps), vec![false; nodes.len()]);
        }
        let sides = Sides::in_planes(mesh.by_body());
        let faces = Faces::on(mesh, periodic, &sides, &caps);
        let lone = |node| faces.class(node).is_none() && faces.repeating(node) != Flat::SPACE;
        let pinned = nodes.clone().map(lone).collect();
        let unlike = unlike(mesh, periodic, &sides, &faces, bodies);
        let mut constraint = free(faces, pinned);
        constraint.choose_leads(bodies, owner, copies, &unlike);
        constraint
    }

    fn choose_leads(&mut self, bodies: &Bodies, owner: &[u32], copies: u32, unlike: &[bool]) {
        let mut members: Vec<(u32, Key, u8, u32)> = Vec::new();
        for (node, &body) in (0..).zip(owner).filter(|(_, body)| **body != NO_BODY) {
            let at = self.faces.class(node);
            members.extend(at.map(|(class, along)| (class, bodies.key(body, along), along, node)));
        }
        members.sort_unstable();
        for tied in members.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let (class, lead) = (tied[0].0, tied[0].3);
            let alike = tied.iter().all(|member| (member.3 < copies) == (lead < copies));
            let images = self.faces.at(class).filter(|node| *node < copies).count();
            if alike && tied.len() == images && !unlike[class as usize] {
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

    /// The nodes that move as `lead` does, with it.
    pub(super) fn tied(&self, lead: u32) -> Vec<u32> {
        let mut images = self.faces.images(lead);
        images.retain(|&node| self.lead(node) == lead);
        images
    }

    /// The node's image class; its own number where it has no images.
    pub(super) fn class(&self, node: u32) -> u32 {
        self.faces.class(node).map_or(node, |(class, _)| class)
    }

    /// Neither the node nor any that it is tied to moves.
    pub(super) fn is_pinned(&self, node: u32) -> bool {
        self.pinned[self.lead(node) as usize]
    }

    /// The node is to stay where it is, and all that it is tied to.
    pub(super) fn pin(&mut self, node: u32) {
        self.pinned[self.lead[node as usize] as usize] = true;
    }

    /// Moves the nodes on faces exactly onto them, and images to the same coordinates within their faces.
    pub(super) fn align(&self, points: &mut [Vec3]) {
        for node in (0..points.len() as u32).filter(|&node| self.flat(node) != Flat::SPACE) {
            points[node as usize] = self.faces.put(node, &points[self.class(node) as usize]);
        }
    }

    /// Moves the followers as their leads: within their faces they have the same coordinates afterwards.
    pub(super) fn spread(&self, points: &mut [Vec3]) {
        for &(node, lead) in &self.followers {
            points[node as usize] = self.faces.put(node, &points[lead as usize]);
        }
    }

    /// Gives the followers the positions of their leads.
    pub(super) fn share<T: Copy>(&self, values: &mut [T]) {
        self.followers.iter().for_each(|&(node, lead)| values[node as usize] = values[lead as usize]);
    }
}

/// Marks the image classes at triangles on a face that have no counterpart, with the same body behind it, on the opposite
/// face.
fn unlike(mesh: &TetMesh, periodic: [bool; 3], sides: &Sides, of: &Faces, bodies: &Bodies) -> Vec<bool> {
    let mut unlike = vec![false; mesh.points.len()];
    for axis in (0..3).filter(|axis| periodic[*axis]) {
        let mut triangles: Vec<(Vec<u32>, Key)> = Vec::new();
        for (upper, faces) in [(0, &sides.faces()[2 * axis]), (1, &sides.faces()[2 * axis + 1])] {
            for &(cell, face) in faces {
                // A node without an image is a class of its own.
                let class = |node: u32| of.class(node).map_or(node, |(class, _)| class);
                let corners = ascending(mesh.by_body().face(cell, face).map(class));
                triangles.push((corners, bodies.key(mesh.owner[cell as usize], upper << axis)));
            }
        }
        triangles.sort_unstable();
        for lone in triangles.chunk_by(|a, b| a == b).filter(|same| same.len() == 1) {
            lone[0].0.iter().for_each(|&class| unlike[class as usize] = true);
        }
    }
    unlike
}

/// The nodes on faces across which a box repeats itself, and in caps; empty where there are none.
pub(super) struct Faces {
    walls: Aabb,
    /// The faces that each node has to stay in.
    flat: Vec<Flat>,
    /// The axes along which the box repeats itself.
    periodic: [bool; 3],
    images: NodeImages,
}

impl Faces {
    /// The faces of `mesh`, whose bodies have these `caps`.
    pub(super) fn of(mesh: &TetMesh, periodic: [bool; 3], caps: &[u8]) -> Self {
        if periodic == [false; 3] {
            let walls = Aabb::around(&mesh.points);
            return Self { walls, flat: Vec::new(), periodic, images: NodeImages::default() }.with_caps(mesh, caps);
        }
        Self::on(mesh, periodic, &Sides::in_planes(mesh.by_body()), caps)
    }

    /// The faces of a mesh with these `sides`.
    pub(super) fn on(mesh: &TetMesh, periodic: [bool; 3], sides: &Sides, caps: &[u8]) -> Self {
        let images = NodeImages::of(&mesh.points, periodic, sides);
        let flat = (0..mesh.points.len() as u32).map(|node| Flat::of(sides.on(node), periodic)).collect();
        Self { walls: Aabb::around(&mesh.points), flat, periodic, images }.with_caps(mesh, caps)
    }

    /// Keeps the nodes of every body that lie in its caps there.
    fn with_caps(mut self, mesh: &TetMesh, caps: &[u8]) -> Self {
        if caps.iter().all(|caps| *caps == 0) {
            return self;
        }
        let sides = Sides::of_points(&mesh.points);
        self.flat.resize(mesh.points.len(), Flat::SPACE);
        for (cell, &owner) in mesh.cells.iter().zip(&mesh.owner) {
            let caps = caps.get(owner as usize).copied().unwrap_or(0);
            let on_sides = cell.iter().filter(|_| caps != 0);
            on_sides.for_each(|&node| self.flat[node as usize].0 |= caps & sides.on(node));
        }
        self
    }

    pub(super) fn walls(&self) -> &Aabb {
        &self.walls
    }

    /// The faces that a node has to stay in.
    pub(super) fn flat(&self, node: u32) -> Flat {
        self.flat.get(node as usize).copied().unwrap_or_default()
    }

    /// The faces of these across which the box repeats itself.
    fn repeating(&self, node: u32) -> Flat {
        Flat::of(self.flat(node).0, self.periodic)
    }

    /// The node's image class, and the upper faces that the node lies on, a bit per axis; `None` away from the faces, and
    /// where opposite faces do not match.
    pub(super) fn class(&self, node: u32) -> Option<(u32, u8)> {
        self.images.class(node)
    }

    /// The nodes of an image class.
    pub(super) fn at(&self, class: u32) -> impl ExactSizeIterator<Item = u32> {
        self.images.at(class)
    }

    /// The node and its images.
    pub(super) fn images(&self, node: u32) -> Vec<u32> {
        self.class(node).map_or_else(|| vec![node], |(class, _)| self.at(class).collect())
    }

    /// Whether a node may move as far as its faces go: it lies on none, or has all of its images.
    pub(super) fn is_matched(&self, node: u32) -> bool {
        let all = 1 << (0..3).filter(|&axis| self.repeating(node).holds(axis)).count();
        self.images(node).len() == all
    }

    /// The position of `node` where its image is at `x`: with the coordinates of its own faces.
    pub(super) fn put(&self, node: u32, x: &Vec3) -> Vec3 {
        self.flat(node).put(x, &self.walls)
    }
}

/// The faces that a node has to stay in: a bit per side, in the order of [`SIDES`](crate::cells::SIDES).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Flat(u8);

impl Flat {
    /// No face at all.
    pub(super) const SPACE: Self = Self(0);

    /// The `sides` across which the box repeats itself.
    pub(super) fn of(sides: u8, periodic: [bool; 3]) -> Self {
        Self(sides & repeating(periodic))
    }

    /// Whether it is among these sides.
    pub(super) fn is_in(self, sides: u8) -> bool {
        self.0 & sides != 0
    }

    /// A coordinate that cannot change.
    pub(super) fn holds(self, axis: usize) -> bool {
        self.0 >> (2 * axis) & 3 != 0
    }

    /// The part of a displacement that stays in the faces.
    pub(super) fn along(self, step: &Vec3) -> Vec3 {
        Vec3::from_fn(|axis, _| if self.holds(axis) { 0.0 } else { step[axis] })
    }

    /// `x` with the coordinates of the faces in `walls`.
    pub(super) fn put(self, x: &Vec3, walls: &Aabb) -> Vec3 {
        Vec3::from_fn(|axis, _| match self.0 >> (2 * axis) & 3 {
            0 => x[axis],
            1 => walls.min[axis],
            _ => walls.max[axis],
        })
    }

    /// The position of a node that moves from `x` towards `target` and stays on its side of these faces: at most half of the
    /// distance to each, and so that nodes on one line across a face keep their order.
    pub(super) fn hold_off(self, x: &Vec3, target: &Vec3, walls: &Aabb) -> Vec3 {
        Vec3::from_fn(|axis, _| {
            let step = target[axis] - x[axis];
            let clearance = if step < 0.0 { x[axis] - walls.min[axis] } else { walls.max[axis] - x[axis] };
            let ahead = self.0 >> (2 * axis + usize::from(step > 0.0)) & 1 == 1;
            if ahead && clearance > 0.0 {
                x[axis] + step * (clearance / (clearance + 2.0 * step.abs()))
            } else {
                target[axis]
            }
        })
    }
}

/// Bodies, those of one id in a row.
pub(super) struct Bodies<'a> {
    all: &'a [Aggregate],
    /// For every body how far it lies from the first of its id, in boxes along each axis.
    shifts: Vec<[i32; 3]>,
}

/// The id that a body shares with its images, and the boxes between them.
pub(super) type Key = (u32, [i32; 3]);

impl<'a> Bodies<'a> {
    /// `size` is the box's, mm.
    pub(super) fn new(all: &'a [Aggregate], size: &Vec3) -> Self {
        let corner = |body: &Aggregate| body.body.vertices()[0];
        let shift = |body: &Aggregate, first: &Aggregate| {
            let boxes = (corner(body) - corner(first)).component_div(size);
            [0, 1, 2].map(|axis| boxes[axis].round() as i32)
        };
        let of_id = |same: &[Aggregate]| same.iter().map(|body| shift(body, &same[0])).collect::<Vec<_>>();
        Self { all, shifts: all.chunk_by(|a, b| a.id == b.id).flat_map(of_id).collect() }
    }

    pub(super) fn count(&self) -> u32 {
        self.all.len() as u32
    }

    /// The caps of each.
    pub(super) fn caps(&self) -> Vec<u8> {
        self.all.iter().map(|body| body.body.caps()).collect()
    }

    pub(super) fn get(&self, index: u32) -> &'a Aggregate {
        &self.all[index as usize]
    }

    /// The body as its image at the lower faces sees it, from an image that lies on the upper faces `along` (a bit per
    /// axis): the same for all images. [`NO_BODY`] is the same everywhere.
    pub(super) fn key(&self, index: u32, along: u8) -> Key {
        if index == NO_BODY {
            return (NO_BODY, [0; 3]);
        }
        let shift = self.shifts[index as usize];
        (self.get(index).id, [0, 1, 2].map(|axis| shift[axis] - i32::from(along >> axis & 1)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_held_off_a_face_keep_their_side_and_their_order() {
        let walls = Aabb { min: Vec3::zeros(), max: Vec3::repeat(10.0) };
        let flat = Flat::of(0b11_0001, [true, true, false]);
        let held = |x: f64| flat.hold_off(&Vec3::new(x, 5.0, 5.0), &Vec3::new(x - 0.4, 5.0, 4.0), &walls);
        let all: Vec<f64> = (1..100).map(|i| held(f64::from(i) * 0.05).x).collect();
        assert!(all[0] > 0.0 && all.is_sorted());
        assert!((all[98] - (4.95 - 0.4)).abs() < 0.06, "far from the face hardly anything changes");
        assert_eq!(held(3.0).z, 4.0, "the box does not repeat itself there");
        assert!(flat.holds(0) && !flat.holds(1) && !flat.holds(2));
    }
}
