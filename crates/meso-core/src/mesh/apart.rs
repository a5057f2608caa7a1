//! Aggregates that share nodes parted by mortar: for analyses, since joined ones make an elastic skeleton that never breaks.
//!
//! Two ways. The first makes whole cells mortar: at a node that several aggregates share, all of them leave but one, and
//! the nodes are taken in an order that loses little volume. No cell is added, so no stable step gets shorter.
//!
//! The second cuts tetrahedra first. A shared node stays with the aggregate whose surface is nearest; the others' cells
//! there have reached across the gap. The edges that lead from the node into these are cut where they meet their surfaces,
//! and what lies before the cut becomes mortar: little volume less, but cells of half the size. Hexahedra, and cells of a
//! mesh whose opposite faces must match, become mortar whole.

use super::cells::{CellKind, Mesh, NO_AGGREGATE, Phase};
use super::fidelity::ById;
use super::quality::cell_volume;
use crate::aggregate::Aggregate;
use crate::math::Vec3;
use std::collections::{BTreeMap, BTreeSet};

/// What was parted.
pub(super) struct Parted {
    /// Nodes that several aggregates had.
    pub(super) nodes: usize,
    /// Pairs of aggregates that had such nodes.
    pub(super) pairs: usize,
    /// Cells of aggregates that are mortar now.
    pub(super) cells: usize,
    /// Their volume, mm3.
    pub(super) volume_mm3: f64,
}

/// The nodes that cells of several aggregates have, with these, ascending: cores alone, an ITZ between them counts for none.
pub(crate) fn joined(mesh: &Mesh) -> Vec<(u32, u32)> {
    let corners = mesh.kind.corners();
    let cores = || {
        let cells = mesh.cells().zip(&mesh.phase).zip(&mesh.aggregate);
        let cores = cells.filter(|((_, phase), _)| **phase == Phase::Aggregate);
        cores.flat_map(move |((cell, _), &aggregate)| cell[..corners].iter().map(move |&node| (node, aggregate)))
    };
    let mut first = vec![NO_AGGREGATE; mesh.points.len()];
    for (node, aggregate) in cores() {
        let first = &mut first[node as usize];
        *first = if *first == NO_AGGREGATE { aggregate } else { *first };
    }
    let further = cores().filter(|&(node, aggregate)| first[node as usize] != aggregate);
    let mut joined: Vec<(u32, u32)> =
        further.flat_map(|(node, aggregate)| [(node, aggregate), (node, first[node as usize])]).collect();
    joined.sort_unstable();
    joined.dedup();
    joined
}

/// The pairs of aggregates among [`joined`] nodes.
pub(crate) fn pairs(joined: &[(u32, u32)]) -> usize {
    let mut pairs = Vec::new();
    for meet in joined.chunk_by(|a, b| a.0 == b.0) {
        for (i, (_, higher)) in meet.iter().enumerate() {
            pairs.extend(meet[..i].iter().map(|(_, lower)| (*lower, *higher)));
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs.len()
}

/// Parts the aggregates of `mesh`, images of `bodies`, that share nodes; `cuts` tetrahedra before whole cells go.
pub(super) fn part(mesh: &mut Mesh, bodies: &[Aggregate], cuts: bool) -> Parted {
    let joined = joined(mesh);
    let (nodes, pairs) = (joined.chunk_by(|a, b| a.0 == b.0).count(), pairs(&joined));
    let mut parted = Parted { nodes, pairs, cells: 0, volume_mm3: 0.0 };
    if cuts && mesh.kind == CellKind::Tetrahedron && mesh.periodic == [false; 3] {
        let bodies = ById::new(bodies);
        for _ in 0..CUTS {
            let left = left(mesh, &bodies, &self::joined(mesh));
            cut(mesh, &bodies, &left);
            let gone = cells_at(mesh, &left);
            parted.become_mortar(mesh, &gone);
        }
    }
    let gone = joining_cells(mesh);
    parted.become_mortar(mesh, &gone);
    parted
}

impl Parted {
    /// Gives the mortar the cells `gone`.
    fn become_mortar(&mut self, mesh: &mut Mesh, gone: &[usize]) {
        self.cells += gone.len();
        self.volume_mm3 += gone.iter().map(|&cell| volume(mesh, cell)).sum::<f64>();
        for &cell in gone {
            mesh.phase[cell] = Phase::Mortar;
            mesh.aggregate[cell] = NO_AGGREGATE;
        }
    }
}

fn volume(mesh: &Mesh, cell: usize) -> f64 {
    let nodes = mesh.kind.nodes();
    cell_volume(mesh.kind, &mesh.cells[cell * nodes..][..nodes], &mesh.points)
}

/// The aggregates' cells that must become mortar so that no aggregate shares a node with another one or with a fibre,
/// ascending.
///
/// At a shared node all leave but a fibre, or the aggregate with the largest volume there. The node that costs the least
/// is next: where an aggregate has left a node, it has less to lose at the nodes beside it. The smallest volume of all is
/// a vertex cover of least weight, which is hard to find.
pub(crate) fn joining_cells(mesh: &Mesh) -> Vec<usize> {
    let mut shared = Shared::of(mesh);
    let nodes: Vec<u32> = shared.cells.keys().copied().collect();
    let mut next: BTreeSet<(u64, u32)> = nodes.iter().map(|&node| (shared.cost(node).0, node)).collect();
    while let Some((_, node)) = next.pop_first() {
        let leaving = shared.cost(node).1;
        let mut others: BTreeSet<u32> = leaving.iter().flat_map(|&cell| shared.neighbours(mesh, cell)).collect();
        others.retain(|&other| next.remove(&(shared.cost(other).0, other)));
        leaving.iter().for_each(|&cell| shared.gone[cell] = true);
        next.extend(others.iter().map(|&other| (shared.cost(other).0, other)));
    }
    (0..shared.gone.len()).filter(|&cell| shared.gone[cell]).collect()
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
        let corners = mesh.kind.corners();
        let bodies = || {
            let cells = mesh.cells().zip(&mesh.phase).zip(&mesh.aggregate).enumerate();
            cells.filter(|(_, ((_, phase), _))| matches!(phase, Phase::Aggregate | Phase::Fibre))
        };
        let (mut first, mut several) = (vec![NO_AGGREGATE; mesh.points.len()], vec![false; mesh.points.len()]);
        for (_, ((cell, _), &body)) in bodies() {
            for &node in &cell[..corners] {
                let first = &mut first[node as usize];
                several[node as usize] |= *first != NO_AGGREGATE && *first != body;
                *first = body;
            }
        }
        let mut cells: BTreeMap<u32, Vec<(usize, u32, f64)>> = BTreeMap::new();
        for (number, ((cell, phase), &body)) in bodies() {
            let weight = if *phase == Phase::Fibre { f64::INFINITY } else { volume(mesh, number) };
            for &node in cell[..corners].iter().filter(|node| several[**node as usize]) {
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
fn left(mesh: &Mesh, bodies: &ById, joined: &[(u32, u32)]) -> Vec<(u32, u32)> {
    let stays = |meet: &[(u32, u32)]| {
        let x = mesh.points[meet[0].0 as usize];
        let depth = |id: u32| beyond(bodies, id, &x).abs();
        meet.iter().map(|(_, id)| *id).min_by(|a, b| depth(*a).total_cmp(&depth(*b)).then(a.cmp(b)))
    };
    let nodes = joined.chunk_by(|a, b| a.0 == b.0);
    nodes.flat_map(|meet| meet.iter().copied().filter(move |(_, id)| Some(*id) != stays(meet))).collect()
}

/// How far `x` lies beyond the outermost plane of body `id` or of its nearest image, mm; negative inside.
fn beyond(bodies: &ById, id: u32, x: &Vec3) -> f64 {
    let beyond = |body: &Aggregate| {
        body.body.planes().map(|plane| plane.normal.dot(x) - plane.offset).fold(f64::NEG_INFINITY, f64::max)
    };
    bodies.images(id).map(beyond).fold(f64::INFINITY, f64::min)
}

/// The shares of an edge between which it is cut: no cell gets much smaller than its neighbours.
const CUT: [f64; 2] = [0.35, 0.65];

/// Cuts the edges that lead from the nodes which aggregates leave into these aggregates.
fn cut(mesh: &mut Mesh, bodies: &ById, left: &[(u32, u32)]) {
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
    let mut star = Star::of(mesh, edges.iter().flat_map(|(edge, _)| *edge));
    for ([from, to], aggregate) in edges {
        let [near, far] = [from, to].map(|node| beyond(bodies, aggregate, &mesh.points[node as usize]));
        let share = if near > far { near / (near - far) } else { 0.5 };
        let share = share.clamp(CUT[0], CUT[1]);
        let position = mesh.points[from as usize] * (1.0 - share) + mesh.points[to as usize] * share;
        star.cut(mesh, [from, to], position);
    }
}

/// The cells around some nodes.
struct Star(BTreeMap<u32, Vec<u32>>);

impl Star {
    fn of(mesh: &Mesh, nodes: impl Iterator<Item = u32>) -> Self {
        let mut around: BTreeMap<u32, Vec<u32>> = nodes.map(|node| (node, Vec::new())).collect();
        let mut wanted = vec![false; mesh.points.len()];
        around.keys().for_each(|&node| wanted[node as usize] = true);
        for (number, cell) in (0..).zip(mesh.cells()) {
            for node in cell.iter().filter(|&&node| wanted[node as usize]) {
                around.get_mut(node).expect("it is wanted").push(number);
            }
        }
        Self(around)
    }

    /// Puts a node at `position` on the edge between `a` and `b`, and splits every cell there in two.
    fn cut(&mut self, mesh: &mut Mesh, [a, b]: [u32; 2], position: Vec3) {
        let middle = mesh.points.len() as u32;
        mesh.points.push(position);
        let cells: Vec<u32> = self.0[&a].iter().copied().filter(|cell| self.0[&b].contains(cell)).collect();
        for cell in cells {
            let new = mesh.cell_count() as u32;
            let old: [u32; 4] = std::array::from_fn(|i| mesh.cells[4 * cell as usize + i]);
            let with = |gone: u32| old.map(|node| if node == gone { middle } else { node });
            mesh.cells[4 * cell as usize..][..4].copy_from_slice(&with(b));
            mesh.cells.extend(with(a));
            mesh.phase.push(mesh.phase[cell as usize]);
            mesh.aggregate.push(mesh.aggregate[cell as usize]);
            for node in old {
                let Some(around) = self.0.get_mut(&node) else { continue };
                if node == b {
                    around.retain(|other| *other != cell);
                }
                if node != a {
                    around.push(new);
                }
            }
        }
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
