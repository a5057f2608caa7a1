//! Gaps between aggregates, for analyses: mortar parts those that share nodes, and narrow gaps get two layers of tetrahedra.
//!
//! Joined aggregates make an elastic skeleton that never breaks. There are two ways to part them. The first makes whole cells
//! mortar: at a node that several aggregates share, all of them leave but one, and the nodes are taken in an order that
//! loses little volume. No cell is added, so no stable step gets shorter.
//!
//! The second cuts tetrahedra first. A shared node stays with the aggregate whose surface is nearest; the others' cells
//! there have reached across the gap. The edges that lead from the node into these are cut where they meet their surfaces,
//! and what lies before the cut becomes mortar: little volume less, but cells of half the size. Hexahedra, and cells of a
//! mesh whose opposite faces must match, become mortar whole.
//!
//! A layer of one element has all its nodes on aggregates, which do not give way: it cannot flow aside, and carries several
//! times the strength of mortar. So each edge of the mortar that runs from one body to another is halved. Cells are
//! bisected at their longest such edge first; neighbours have that edge in common, so they agree on the face between
//! them. Edges in faces across which a specimen repeats itself stay, so that opposite faces still match.

use super::cells::{CellKind, EDGES, Mesh, NO_AGGREGATE, Phase};
use super::interface::{Owners, pairs};
use super::sides::{Sides, repeating};
use super::tet::Incidence;
use crate::aggregate::Aggregate;
use crate::geometry::Plane;
use crate::math::Vec3;
use crate::packing::ById;
use std::collections::{BTreeMap, BTreeSet};

impl Mesh {
    /// Nodes that cores of several aggregates share, and pairs of aggregates that share some: an elastic skeleton.
    pub fn joined_aggregates(&self) -> (usize, usize) {
        let joined = joined(self);
        (joined.chunk_by(|a, b| a.0 == b.0).count(), pairs(&joined).len())
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
    let owners = mesh.owners(|cell| mesh.phase[cell] == Phase::Aggregate);
    owners.bodies(|node| owners.are_several(node))
}

/// Parts the aggregates of `mesh`, images of `bodies`, that share nodes; `cuts` tetrahedra before whole cells go.
pub(super) fn part(mesh: &mut Mesh, bodies: &[Aggregate], cuts: bool) {
    (mesh.notes.parted_nodes, mesh.notes.parted_pairs) = mesh.joined_aggregates();
    if cuts && mesh.kind == CellKind::Tetrahedron && mesh.periodic == [false; 3] {
        let bodies = ById::new(bodies, |body| body);
        for _ in 0..CUTS {
            let left = left(mesh, &bodies, &joined(mesh));
            cut(mesh, &bodies, &left);
            let gone = cells_at(mesh, &left);
            become_mortar(mesh, &gone);
        }
    }
    let gone = mesh.joining_cells();
    become_mortar(mesh, &gone);
}

/// Gives the mortar the cells `gone`.
fn become_mortar(mesh: &mut Mesh, gone: &[usize]) {
    mesh.notes.parted_cells += gone.len();
    mesh.notes.parted_mm3 += gone.iter().map(|&cell| mesh.volume(cell)).sum::<f64>();
    for &cell in gone {
        mesh.phase[cell] = Phase::Mortar;
        mesh.aggregate[cell] = NO_AGGREGATE;
    }
}

/// The nodes that several bodies share.
struct Shared {
    /// The bodies' cells at each, with the body and the cell's volume, mm3; a fibre's weighs more than all.
    cells: BTreeMap<u32, Vec<(usize, u32, f64)>>,
    /// Of every cell of the mesh.
    gone: Vec<bool>,
}

impl Shared {
    fn of(mesh: &Mesh) -> Self {
        let is_stiff = |cell: usize| matches!(mesh.phase[cell], Phase::Aggregate | Phase::Fibre);
        let owners = mesh.owners(is_stiff);
        let mut cells: BTreeMap<u32, Vec<(usize, u32, f64)>> = BTreeMap::new();
        let all = mesh.cells().zip(&mesh.aggregate).enumerate().filter(|(number, _)| is_stiff(*number));
        for (number, (cell, &body)) in all {
            let weight = if mesh.phase[number] == Phase::Fibre { f64::INFINITY } else { mesh.volume(number) };
            for &node in cell[..mesh.kind.corners()].iter().filter(|node| owners.are_several(**node)) {
                cells.entry(node).or_default().push((number, body, weight));
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
            (NO_AGGREGATE, 0.0),
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
        let nodes = &mesh.cells[cell * mesh.kind.nodes()..][..mesh.kind.corners()];
        nodes.iter().copied().filter(|node| self.cells.contains_key(node)).collect()
    }
}

/// A cut through an edge whose two nodes different aggregates leave joins these anew. After so many rounds of cuts what is
/// still joined becomes mortar whole.
const CUTS: usize = 2;

/// The (node, aggregate) of which the aggregate leaves the node: all but the one whose surface is nearest to it.
fn left(mesh: &Mesh, bodies: &ById<&Aggregate>, joined: &[(u32, u32)]) -> Vec<(u32, u32)> {
    let stays = |meet: &[(u32, u32)]| {
        let x = mesh.points[meet[0].0 as usize];
        let depth = |id: u32| beyond(bodies, id, &x).abs();
        meet.iter().map(|(_, id)| *id).min_by(|a, b| depth(*a).total_cmp(&depth(*b)).then(a.cmp(b)))
    };
    let nodes = joined.chunk_by(|a, b| a.0 == b.0);
    nodes.flat_map(|meet| meet.iter().copied().filter(move |(_, id)| Some(*id) != stays(meet))).collect()
}

/// How far `x` lies beyond the outermost plane of body `id` or of its nearest image, mm; negative inside.
fn beyond(bodies: &ById<&Aggregate>, id: u32, x: &Vec3) -> f64 {
    let beyond = |body: &&Aggregate| Plane::height_over(body.body.planes(), x);
    bodies.images(id).map(beyond).fold(f64::INFINITY, f64::min)
}

/// The shares of an edge between which it is cut: no cell gets much smaller than its neighbours.
const CUT: [f64; 2] = [0.35, 0.65];

/// Cuts the edges that lead from the nodes which aggregates leave into these aggregates.
fn cut(mesh: &mut Mesh, bodies: &ById<&Aggregate>, left: &[(u32, u32)]) {
    let leaves = |node: u32, aggregate: u32| left.binary_search(&(node, aggregate)).is_ok();
    let mut edges: Vec<([u32; 2], u32)> = Vec::new();
    for ((cell, phase), &aggregate) in mesh.cells().zip(&mesh.phase).zip(&mesh.aggregate) {
        if *phase != Phase::Aggregate || !cell.iter().any(|&node| leaves(node, aggregate)) {
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
        mesh.aggregate.push(mesh.aggregate[cell as usize]);
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
    let cells = mesh.cells().zip(&mesh.phase).zip(&mesh.aggregate).enumerate();
    let left = cells.filter(|(_, ((cell, phase), id))| **phase == Phase::Aggregate && leaves(cell, **id));
    left.map(|(number, _)| number).collect()
}

/// Halves the edges of mortar between two bodies; the number of these.
pub(super) fn split_narrow(mesh: &mut Mesh) -> usize {
    if mesh.kind != CellKind::Tetrahedron {
        return 0;
    }
    let bridges = Bridges::of(mesh);
    let first = mesh.points.len() as u32;
    let middle = |&[a, b]: &[u32; 2]| (mesh.points[a as usize] + mesh.points[b as usize]) / 2.0;
    let middles: Vec<_> = bridges.edges.iter().map(middle).collect();
    mesh.points.extend(middles);
    let mut cell = 0;
    // The half that is cut off goes to the end, and is looked at there.
    while cell < mesh.phase.len() {
        let nodes: [u32; 4] = std::array::from_fn(|corner| mesh.cells[4 * cell + corner]);
        let is_mortar = mesh.phase[cell] == Phase::Mortar;
        let Some((edge, [i, j])) = is_mortar.then(|| bridges.longest_of(&nodes)).flatten() else {
            cell += 1;
            continue;
        };
        mesh.cells[4 * cell + i] = first + edge;
        let mut rest = nodes;
        rest[j] = first + edge;
        mesh.cells.extend(rest);
        mesh.phase.push(Phase::Mortar);
        mesh.aggregate.push(NO_AGGREGATE);
    }
    bridges.edges.len()
}

/// Edges of the mortar from one body to another.
struct Bridges {
    /// The lower end and the upper one, ascending.
    edges: Vec<[u32; 2]>,
    /// The rank of each by its length, the longest first.
    rank: Vec<u32>,
    owners: Owners,
}

impl Bridges {
    fn of(mesh: &Mesh) -> Self {
        let owners = mesh.owners(|cell| mesh.aggregate[cell] != NO_AGGREGATE);
        let mut bridges = Self { edges: Vec::new(), rank: Vec::new(), owners };
        let sides = Sides::of_points(&mesh.points);
        let is_fixed = |[a, b]: [u32; 2]| sides.on(a) & sides.on(b) & repeating(mesh.periodic) != 0;
        let mortar = mesh.cells().zip(&mesh.phase).filter(|(_, phase)| **phase == Phase::Mortar);
        let mut edges: Vec<[u32; 2]> = mortar
            .flat_map(|(cell, _)| EDGES.map(|[i, j]| ordered(cell[i], cell[j])))
            .filter(|&edge| bridges.parts_two(edge) && !is_fixed(edge))
            .collect();
        edges.sort_unstable();
        edges.dedup();
        bridges.rank = ranks(mesh, &edges);
        bridges.edges = edges;
        bridges
    }

    /// Whether the ends lie on two bodies. A node of several may share one of them with the other end: such an edge may be
    /// theirs.
    fn parts_two(&self, edge: [u32; 2]) -> bool {
        let [a, b] = edge.map(|node| self.owners.only(node));
        a.is_some() && b.is_some() && a != b
    }

    /// The longest bridge of a cell: its number, and the places of its ends.
    fn longest_of(&self, nodes: &[u32; 4]) -> Option<(u32, [usize; 2])> {
        let found = EDGES.iter().filter_map(|&[i, j]| Some((self.number(nodes[i], nodes[j])?, [i, j])));
        found.min_by_key(|(edge, _)| self.rank[*edge as usize])
    }

    fn number(&self, a: u32, b: u32) -> Option<u32> {
        let place = self.parts_two([a, b]).then(|| self.edges.binary_search(&ordered(a, b)).ok())?;
        place.map(|place| place as u32)
    }
}

fn ordered(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Ranks by length, the longest first; of equal ones the lower number.
fn ranks(mesh: &Mesh, edges: &[[u32; 2]]) -> Vec<u32> {
    let square = |[a, b]: [u32; 2]| (mesh.points[a as usize] - mesh.points[b as usize]).norm_squared();
    let squares: Vec<f64> = edges.iter().map(|&edge| square(edge)).collect();
    let mut order: Vec<usize> = (0..edges.len()).collect();
    order.sort_by(|&i, &j| squares[j].total_cmp(&squares[i]).then(i.cmp(&j)));
    let mut ranks = vec![0; edges.len()];
    (0..).zip(order).for_each(|(rank, edge)| ranks[edge] = rank);
    ranks
}
