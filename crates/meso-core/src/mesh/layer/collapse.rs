//! Rails that collapse: the inner end is contracted onto the outer one, and the cells that hold both are gone.
//!
//! A rail is an edge of one of the three tetrahedra of each prism around it, and of no other cell, so that neighbours
//! still match. Where the collapse of one rail alone would turn a neighbour over, a group of them may collapse: it begins with
//! the rails of one poor cell. Where their collapse leaves cells as poor as those that it mends, the rails of these join the
//! group, for [`WAVES`] times: with all rails around gone the body's cells are nearly the old ones, none of which was poor.

use super::periodic::{Faces, Flat};
use super::prisms::Layered;
use crate::math::Vec3;
use crate::mesh::cells::Phase;
use crate::mesh::tet::{Constraint, Incidence, Star, TetMesh, ascending, cos2_of, min_dihedral_cos2};

/// Cells with a smaller dihedral angle are poor, degrees.
const POOR_DEG: f64 = 2.0;
/// How often a group grows.
const WAVES: usize = 4;

/// The nodes that may move, and how.
pub(super) struct Movable {
    /// For every node the outer end of the rail whose inner end it is, or [`NO_RAIL`].
    outer: Vec<u32>,
    /// The nodes that stay: the mortar's, the outer ends of rails, and their images.
    fixed: Vec<bool>,
    /// Images on them move together, within these.
    pub(super) faces: Faces,
    /// Cells above this are poor.
    pub(super) limit: f64,
}

const NO_RAIL: u32 = u32::MAX;

impl Movable {
    pub(super) fn new(layered: &Layered, rails: &[[u32; 2]]) -> Self {
        let Layered { mesh, phase, periodic } = layered;
        let mut outer = vec![NO_RAIL; mesh.points.len()];
        let mut fixed = vec![false; mesh.points.len()];
        for &[inner, end] in rails {
            outer[inner as usize] = end;
            fixed[end as usize] = true;
        }
        for (cell, _) in mesh.cells.iter().zip(phase).filter(|(_, phase)| **phase == Phase::Mortar) {
            cell.iter().for_each(|&node| fixed[node as usize] = true);
        }
        let faces = Faces::of(mesh, *periodic);
        let stays =
            |node: u32| !faces.is_matched(node) || faces.images(node).iter().any(|&image| fixed[image as usize]);
        let on_faces: Vec<u32> =
            (0..fixed.len() as u32).filter(|&node| faces.flat(node) != Flat::SPACE && stays(node)).collect();
        on_faces.into_iter().for_each(|node| fixed[node as usize] = true);
        Self { outer, fixed, faces, limit: cos2_of(POOR_DEG) }
    }

    /// The outer end of the rail whose inner end `node` is.
    pub(super) fn outer_end(&self, node: u32) -> Option<u32> {
        Some(self.outer[node as usize]).filter(|end| *end != NO_RAIL)
    }

    /// Whether a node and all of its images are inner ends.
    pub(super) fn are_inner_ends(&self, node: u32) -> bool {
        self.faces.images(node).into_iter().all(|image| self.outer_end(image).is_some())
    }

    /// The nodes of `cells` that may move, and their images, ascending.
    pub(super) fn nodes(&self, mesh: &TetMesh, cells: &[u32]) -> Vec<u32> {
        let all = cells.iter().flat_map(|&cell| mesh.cell(cell));
        let free = all.filter(|&node| !self.fixed[node as usize]);
        ascending(free.flat_map(|node| self.faces.images(node)))
    }

    /// The inner ends among these.
    fn inner_ends(&self, mesh: &TetMesh, cells: &[u32]) -> Vec<u32> {
        let mut nodes = self.nodes(mesh, cells);
        nodes.retain(|&node| self.are_inner_ends(node));
        nodes
    }
}

/// One node that may move.
pub(super) struct Mover<'a>(pub(super) &'a Movable, pub(super) u32);

impl Constraint for Mover<'_> {
    /// Steps are in mm.
    fn reachable(&self, x: &Vec3, step: f64) -> Vec<Vec3> {
        let flat = self.0.faces.flat(self.1);
        crate::mesh::tet::directions().map(|direction| x + flat.along(&direction) * step).collect()
    }

    fn may_contract(&self, into: u32) -> bool {
        self.0.outer_end(self.1) == Some(into)
    }

    fn moved(&self, node: u32, x: &Vec3) -> Vec<(u32, Vec3)> {
        self.0.faces.images(node).into_iter().map(|image| (image, self.0.faces.put(image, x))).collect()
    }
}

/// Collapses the rails of the `poor` cells, with their images, where that leaves better ones. Returns how many rails did.
pub(super) fn collapse(mesh: &mut TetMesh, movable: &Movable, poor: &[u32]) -> usize {
    let nodes = movable.inner_ends(mesh, poor);
    let incidence = Incidence::around(&mesh.cells, mesh.points.len(), nodes.iter().copied());
    let mut collapsed = 0;
    for &node in &nodes {
        let images = movable.faces.images(node);
        // All at once, when their first comes up.
        if images[0] != node {
            continue;
        }
        let rails: Vec<Rail> =
            images.iter().filter_map(|&image| Rail::new(mesh, movable, image, incidence.cells(image))).collect();
        let before = rails.iter().map(|rail| rail.before(mesh)).fold(-1.0, f64::max);
        let after = rails.iter().map(|rail| rail.after(mesh, before)).fold(-1.0, f64::max);
        if before > movable.limit && after < before {
            rails.iter().for_each(|rail| mesh.contract(rail.node, rail.end, &rail.cells));
            collapsed += rails.len();
        }
    }
    collapsed
}

/// The inner end of a rail with the cells around it.
struct Rail {
    node: u32,
    /// The outer end.
    end: u32,
    /// Those that go with the rail first.
    cells: Vec<u32>,
    gone: usize,
}

impl Rail {
    fn new(mesh: &TetMesh, movable: &Movable, node: u32, cells: &[u32]) -> Option<Self> {
        let end = movable.outer_end(node)?;
        let there = cells.iter().filter(|&&cell| !mesh.is_removed(cell));
        let (mut cells, rest): (Vec<u32>, Vec<u32>) = there.partition(|&&cell| mesh.cell(cell).contains(&end));
        let gone = cells.len();
        cells.extend(rest);
        Some(Self { node, end, cells, gone })
    }

    fn before(&self, mesh: &TetMesh) -> f64 {
        Star::of(mesh, self.node, &self.cells).worst_first()
    }

    fn after(&self, mesh: &TetMesh, limit: f64) -> f64 {
        Star::of(mesh, self.node, &self.cells[self.gone..]).worst(&mesh.position(self.end), limit)
    }
}

/// Collapses groups of rails around the `poor` cells, with their images, where that leaves better ones. Returns how many rails
/// did, and adds the cells around them to `suspects`.
pub(super) fn collapse_groups(mesh: &mut TetMesh, movable: &Movable, poor: &[u32], suspects: &mut Vec<u32>) -> usize {
    let mut groups: Vec<Group> = poor.iter().map(|&cell| Group { nodes: movable.inner_ends(mesh, &[cell]) }).collect();
    let mut collapsed = 0;
    for _ in 0..WAVES {
        let nodes = groups.iter().flat_map(|group| group.nodes.iter().copied());
        let incidence = Incidence::around(&mesh.cells, mesh.points.len(), nodes);
        groups.retain_mut(|group| match group.tried(mesh, movable, &incidence, suspects) {
            Tried::Collapsed => {
                collapsed += group.nodes.len();
                false
            }
            Tried::Grown => true,
            Tried::InVain => false,
        });
    }
    collapsed
}

/// Inner ends of rails.
struct Group {
    nodes: Vec<u32>,
}

/// What came of a group.
enum Tried {
    Collapsed,
    Grown,
    InVain,
}

impl Group {
    /// Collapses, or grows by the rails of the cells that forbid it.
    fn tried(
        &mut self,
        mesh: &mut TetMesh,
        movable: &Movable,
        incidence: &Incidence,
        suspects: &mut Vec<u32>,
    ) -> Tried {
        let mut cells = ascending(self.nodes.iter().flat_map(|&node| incidence.cells(node)).copied());
        cells.retain(|&cell| !mesh.is_removed(cell));
        // Another group may have taken some of them.
        self.nodes.retain(|node| cells.iter().any(|&cell| mesh.cell(cell).contains(node)));
        let before = cells.iter().map(|&cell| mesh.cos2(cell)).fold(-1.0, f64::max);
        if before <= movable.limit {
            return Tried::InVain;
        }
        let then = |cell: u32| self.collapsed(movable, mesh.cell(cell));
        let cos2 = |nodes: [u32; 4]| min_dihedral_cos2(mesh.corners(nodes));
        let forbids = |cell: &u32| then(*cell).is_some_and(|nodes| cos2(nodes) >= before);
        let forbidding: Vec<u32> = cells.iter().copied().filter(forbids).collect();
        if forbidding.is_empty() {
            let all: Vec<(u32, Option<[u32; 4]>)> = cells.iter().map(|&cell| (cell, then(cell))).collect();
            for (cell, nodes) in all {
                match nodes {
                    Some(nodes) => mesh.cells[cell as usize] = nodes,
                    None => mesh.remove(cell),
                }
            }
            suspects.extend(cells);
            return Tried::Collapsed;
        }
        let count = self.nodes.len();
        let more = movable.inner_ends(mesh, &forbidding);
        self.nodes = ascending(self.nodes.drain(..).chain(more));
        if self.nodes.len() > count { Tried::Grown } else { Tried::InVain }
    }

    /// The cell's nodes after the collapse; `None` where it is gone with a rail of its own.
    fn collapsed(&self, movable: &Movable, nodes: [u32; 4]) -> Option<[u32; 4]> {
        let ends = nodes.map(|node| match self.nodes.binary_search(&node) {
            Ok(_) => movable.outer[node as usize],
            Err(_) => node,
        });
        let twice = (0..4).any(|i| ends[..i].contains(&ends[i]));
        (!twice).then_some(ends)
    }
}
