//! Joined aggregates: mortar parts those that share nodes.
//!
//! Joined aggregates make an elastic skeleton that never breaks. There are two ways to part them. The first makes whole cells
//! mortar: at a node that several aggregates share, all of them leave but one, and the nodes are taken in an order that
//! loses little volume. No cell is added, so no stable step gets shorter.
//!
//! The second cuts tetrahedra first. A shared node stays with the aggregate whose surface is nearest; the others' cells
//! there have reached across the gap. The edges that lead from the node into these are cut where they meet their surfaces,
//! and the piece before the cut becomes mortar: little volume less, but cells of half the size. Hexahedra, and cells of a
//! mesh whose opposite faces must match, become mortar whole.

use crate::body_images::BodyImages;
use crate::cells::{CellKind, Mesh, NO_BODY, Phase, pairs};
use crate::tet::Incidence;
use meso_collision::math::Vec3;
use meso_concrete::aggregate::Aggregate;
use std::collections::{BTreeMap, BTreeSet};

impl Mesh {
    /// Nodes that cores of several aggregates share, and pairs of aggregates that share some: an elastic skeleton.
    pub fn joined_aggregates(&self) -> (usize, usize) {
        let joined = joined(self);
        (joined.chunk_by(|a, b| a.0 == b.0).count(), pairs(&joined).len())
    }

    /// [`touching_share`](Self::touching_share) above which an analysis is warned of it. Fitted lattices of 4 mm had 0.0015
    /// at most; joined voxels of 1 mm had 0.012.
    pub const FEW_TOUCH: f64 = 0.01;

    /// Share of the cohesive elements that lie between two aggregates, with no mortar: an elastic skeleton, too, since pressure
    /// goes from one to the other. 0 without cohesive elements.
    pub fn touching_share(&self) -> f64 {
        if self.cohesive.is_empty() {
            return 0.0;
        }
        let owners = self.owners(|cell| self.phase[cell].is_aggregate());
        let is_aggregate = |&node: &u32| owners.last(node) != NO_BODY;
        let touching = self.cohesive().filter(|face| face[face.len() / 2..].iter().all(is_aggregate)).count();
        touching as f64 / self.cohesive().len() as f64
    }

    /// Numbers of the aggregates' cells, ascending, that must become mortar so that no aggregate shares a node with another
    /// one or with a fibre, few by their volume.
    ///
    /// At a shared node all leave but a fibre, or the aggregate with the largest volume there. The node that costs the least
    /// is next: where an aggregate has left a node, it has less to lose at the nodes beside it. The smallest volume of all is
    /// a vertex cover of least weight, which is hard to find.
    pub fn joining_cells(&self) -> Vec<usize> {
        let mut shared = Shared::of(self);
        let nodes: Vec<u32> = shared.cells.keys().copied().collect();
        let mut next: BTreeSet<(u64, u32)> = nodes.iter().map(|&node| (shared.cost(node).0, node)).collect();
        while let Some((_, node)) = next.pop_first() {
            let leaving = shared.cost(node).1;
            let mut others: BTreeSet<u32> = leaving.iter().flat_map(|&cell| shared.neighbours(self, cell)).collect();
            others.retain(|&other| next.remove(&(shared.cost(other).0, other)));
            leaving.iter().for_each(|&cell| shared.gone[cell] = true);
            next.extend(others.iter().map(|&other| (shared.cost(other).0, other)));
        }
        (0..shared.gone.len()).filter(|&cell| shared.gone[cell]).collect()
    }
}

/// The nodes that cells of several aggregates have, with these, ascending: cores alone, an ITZ between them counts for none.
fn joined(mesh: &Mesh) -> Vec<(u32, u32)> {
    let owners = mesh.owners(|cell| mesh.phase[cell].is_aggregate());
    owners.bodies(|node| owners.are_several(node))
}

/// Parts the aggregates of `mesh`, images of `bodies`, that share nodes; `cuts` tetrahedra before whole cells go.
pub(crate) fn part(mesh: &mut Mesh, bodies: &BodyImages, cuts: bool) {
    (mesh.notes.parted_nodes, mesh.notes.separated_pairs) = mesh.joined_aggregates();
    let mut bitten = BTreeSet::new();
    if cuts && mesh.kind == CellKind::Tetrahedron && mesh.periodic == [false; 3] {
        for _ in 0..CUTS {
            let left = left(mesh, bodies, &joined(mesh));
            cut(mesh, bodies, &left);
            let gone = cells_at(mesh, &left);
            leave(mesh, &gone, &mut bitten);
        }
    }
    let gone = mesh.joining_cells();
    leave(mesh, &gone, &mut bitten);
    mesh.notes.parted_aggregates = bitten.len();
}

/// Gives the mortar the cells `gone`, and counts them; their aggregates are `bitten`.
fn leave(mesh: &mut Mesh, gone: &[usize], bitten: &mut BTreeSet<u32>) {
    bitten.extend(gone.iter().map(|&cell| mesh.owner[cell]));
    mesh.notes.parted_cells += gone.len();
    mesh.notes.parted_mm3 += gone.iter().map(|&cell| mesh.volume(cell)).sum::<f64>();
    become_mortar(mesh, gone);
}

/// Gives the mortar `cells`.
pub(super) fn become_mortar(mesh: &mut Mesh, cells: &[usize]) {
    for &cell in cells {
        mesh.phase[cell] = Phase::Mortar;
        mesh.owner[cell] = NO_BODY;
    }
}

/// The nodes that several bodies share.
struct Shared {
    /// The bodies' cells at each, with the body and the cell's volume, mm3; a fibre's weighs more than all.
    cells: BTreeMap<u32, Vec<(usize, u32, f64)>>,
    /// For every cell of the mesh whether it becomes mortar.
    gone: Vec<bool>,
}

impl Shared {
    fn of(mesh: &Mesh) -> Self {
        let is_stiff = |cell: usize| mesh.phase[cell].is_aggregate() || mesh.phase[cell] == Phase::Fibre;
        let owners = mesh.owners(is_stiff);
        let mut cells: BTreeMap<u32, Vec<(usize, u32, f64)>> = BTreeMap::new();
        let all = mesh.cells().zip(&mesh.owner).enumerate().filter(|(number, _)| is_stiff(*number));
        for (number, (cell, &body)) in all {
            let weight = || if mesh.phase[number] == Phase::Fibre { f64::INFINITY } else { mesh.volume(number) };
            for &node in cell[..mesh.kind.corners()].iter().filter(|node| owners.are_several(**node)) {
                cells.entry(node).or_default().push((number, body, weight()));
            }
        }
        Self { cells, gone: vec![false; mesh.cell_count()] }
    }

    /// The volume that leaves a node, in a form that sorts as it does, and the cells: none of fibres.
    fn cost(&self, node: u32) -> (u64, Vec<usize>) {
        let left = || self.cells[&node].iter().filter(|(cell, ..)| !self.gone[*cell]);
        let mut volumes: BTreeMap<u32, f64> = BTreeMap::new();
        left().for_each(|(_, body, volume)| *volumes.entry(*body).or_default() += volume);
        let largest = volumes.iter().fold(
            (NO_BODY, 0.0),
            |best, (body, volume)| {
                if *volume > best.1 { (*body, *volume) } else { best }
            },
        );
        let leaves = || left().filter(|(_, body, volume)| *body != largest.0 && volume.is_finite());
        // An empty sum may be -0.
        let cost = leaves().map(|(_, _, volume)| volume).sum::<f64>() + 0.0;
        (cost.to_bits(), leaves().map(|(cell, ..)| *cell).collect())
    }

    /// The shared nodes of a cell.
    fn neighbours(&self, mesh: &Mesh, cell: usize) -> Vec<u32> {
        let nodes = &mesh.by_owner().cell(cell)[..mesh.kind.corners()];
        nodes.iter().copied().filter(|node| self.cells.contains_key(node)).collect()
    }
}

/// A cut through an edge whose two nodes different aggregates leave joins these anew. Cells that are still
/// joined after so many rounds of cuts become mortar whole.
const CUTS: usize = 2;

/// The (node, aggregate) of which the aggregate leaves the node: all but the one whose surface is nearest to it.
fn left(mesh: &Mesh, bodies: &BodyImages, joined: &[(u32, u32)]) -> Vec<(u32, u32)> {
    let stays = |meet: &[(u32, u32)]| {
        let x = mesh.points[meet[0].0 as usize];
        let depth = |id: u32| beyond(bodies, id, &x).abs();
        meet.iter().map(|(_, id)| *id).min_by(|a, b| depth(*a).total_cmp(&depth(*b)).then(a.cmp(b)))
    };
    let nodes = joined.chunk_by(|a, b| a.0 == b.0);
    nodes.flat_map(|meet| meet.iter().copied().filter(move |(_, id)| Some(*id) != stays(meet))).collect()
}

/// How far `x` lies beyond `body` or its nearest image, mm; negative inside.
fn beyond(bodies: &BodyImages, body: u32, x: &Vec3) -> f64 {
    let beyond = |body: &Aggregate| body.body.height(x);
    bodies.images(body).iter().map(beyond).fold(f64::INFINITY, f64::min)
}

/// The shares of an edge between which it is cut: no cell gets much smaller than its neighbours.
const CUT: [f64; 2] = [0.35, 0.65];

/// Cuts the edges that lead from the nodes which aggregates leave into these aggregates.
fn cut(mesh: &mut Mesh, bodies: &BodyImages, left: &[(u32, u32)]) {
    let leaves = |node: u32, aggregate: u32| left.binary_search(&(node, aggregate)).is_ok();
    let mut edges: Vec<([u32; 2], u32)> = Vec::new();
    for ((cell, phase), &aggregate) in mesh.cells().zip(&mesh.phase).zip(&mesh.owner) {
        if !phase.is_aggregate() || !cell.iter().any(|&node| leaves(node, aggregate)) {
            continue;
        }
        for &from in cell.iter().filter(|&&node| leaves(node, aggregate)) {
            edges.extend(cell.iter().filter(|&&to| !leaves(to, aggregate)).map(|&to| ([from, to], aggregate)));
        }
    }
    edges.sort_unstable();
    edges.dedup();
    // An edge that two aggregates leave from its two ends is cut once.
    let mut seen = BTreeMap::new();
    edges.retain(|([a, b], _)| seen.insert([*a.min(b), *a.max(b)], ()).is_none());
    let (cells, _) = mesh.cells.as_chunks();
    let mut around = Incidence::around(cells, mesh.points.len(), edges.iter().flat_map(|(edge, _)| *edge));
    for ([from, to], aggregate) in edges {
        let [near, far] = [from, to].map(|node| beyond(bodies, aggregate, &mesh.points[node as usize]));
        let share = if near > far { near / (near - far) } else { 0.5 };
        let share = share.clamp(CUT[0], CUT[1]);
        let position = mesh.points[from as usize] * (1.0 - share) + mesh.points[to as usize] * share;
        cut_edge(mesh, &mut around, [from, to], position);
    }
}

/// Puts a node at `position` on the edge between `a` and `b`, and splits every cell there in two.
fn cut_edge(mesh: &mut Mesh, around: &mut Incidence, [a, b]: [u32; 2], position: Vec3) {
    let middle = mesh.points.len() as u32;
    mesh.points.push(position);
    around.add_node();
    let at_b = around.cells(b);
    let cells: Vec<u32> = around.cells(a).iter().copied().filter(|cell| at_b.contains(cell)).collect();
    for cell in cells {
        let new = mesh.cell_count() as u32;
        let old: [u32; 4] = std::array::from_fn(|i| mesh.cells[4 * cell as usize + i]);
        let with = |gone: u32| old.map(|node| if node == gone { middle } else { node });
        mesh.cells[4 * cell as usize..][..4].copy_from_slice(&with(b));
        mesh.cells.extend(with(a));
        mesh.phase.push(mesh.phase[cell as usize]);
        mesh.owner.push(mesh.owner[cell as usize]);
        around.unlink(cell, &[b]);
        around.link(new, &with(a));
    }
}

/// The cells of aggregates at nodes that these leave.
fn cells_at(mesh: &Mesh, left: &[(u32, u32)]) -> Vec<usize> {
    let corners = mesh.kind.corners();
    let leaves = |cell: &[u32], aggregate: u32| {
        cell[..corners].iter().any(|&node| left.binary_search(&(node, aggregate)).is_ok())
    };
    let cells = mesh.cells().zip(&mesh.phase).zip(&mesh.owner).enumerate();
    let left = cells.filter(|(_, ((cell, phase), id))| phase.is_aggregate() && leaves(cell, **id));
    left.map(|(number, _)| number).collect()
}
