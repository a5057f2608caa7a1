//! Narrow gaps between aggregates get two layers of tetrahedra.
//!
//! A layer of one element has all its nodes on aggregates, which do not give way: it cannot flow aside, and carries several
//! times the strength of mortar. So each edge of the mortar that runs from one body to another is halved. Cells are
//! bisected at their longest such edge first; neighbours have that edge in common, so they agree on the face between
//! them. Edges in faces across which a specimen repeats itself stay, so that opposite faces still match.

use crate::cells::{CellKind, EDGES, Mesh, NO_BODY, Owners, Phase, Sides, repeating};
use meso_concrete::parallel;

/// Halves the edges of mortar between two bodies; the number of these.
pub(crate) fn split_narrow(mesh: &mut Mesh) -> usize {
    if mesh.kind != CellKind::Tetrahedron {
        return 0;
    }
    let bridges = Bridges::of(mesh);
    let first = mesh.points.len() as u32;
    let middle = |&[a, b]: &[u32; 2]| (mesh.points[a as usize] + mesh.points[b as usize]) / 2.0;
    let middles: Vec<_> = bridges.edges.iter().map(middle).collect();
    mesh.points.extend(middles);
    let nodes_of = |mesh: &Mesh, cell: usize| std::array::from_fn(|corner| mesh.cells[4 * cell + corner]);
    let is_crossed =
        |cell: usize| mesh.phase[cell] == Phase::Mortar && bridges.longest_of(&nodes_of(mesh, cell)).is_some();
    let mut open = parallel::filter(mesh.cell_count(), is_crossed);
    let mut next = 0;
    // The half that is cut off goes to the end, and is looked at there.
    while let Some(&cell) = open.get(next) {
        let nodes: [u32; 4] = nodes_of(mesh, cell as usize);
        let Some((edge, [i, j])) = bridges.longest_of(&nodes) else {
            next += 1;
            continue;
        };
        open.push(mesh.phase.len() as u32);
        mesh.cells[4 * cell as usize + i] = first + edge;
        let mut rest = nodes;
        rest[j] = first + edge;
        mesh.cells.extend(rest);
        mesh.phase.push(Phase::Mortar);
        mesh.owner.push(NO_BODY);
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
        let owners = mesh.owners(|cell| mesh.owner[cell] != NO_BODY);
        let mut bridges = Self { edges: Vec::new(), rank: Vec::new(), owners };
        let sides = Sides::of_points(&mesh.points);
        let is_fixed = |[a, b]: [u32; 2]| sides.on(a) & sides.on(b) & repeating(mesh.periodic) != 0;
        let bridges_of = |cell: usize| {
            let nodes = mesh.cell(cell);
            let only = |i: usize| bridges.owners.only(nodes[i]);
            let bodies = if mesh.phase[cell] == Phase::Mortar { [0, 1, 2, 3].map(only) } else { [None; 4] };
            let parting = EDGES.into_iter().filter(move |&[i, j]| are_two(bodies[i], bodies[j]));
            parting.map(|[i, j]| ordered(nodes[i], nodes[j])).filter(|edge| !is_fixed(*edge))
        };
        let mut edges = parallel::flat_map(mesh.cell_count(), bridges_of);
        edges.sort_unstable();
        edges.dedup();
        bridges.rank = ranks(mesh, &edges);
        bridges.edges = edges;
        bridges
    }

    /// The longest bridge of a cell: its number, and the places of its ends.
    fn longest_of(&self, nodes: &[u32; 4]) -> Option<(u32, [usize; 2])> {
        let found = EDGES.iter().filter_map(|&[i, j]| Some((self.number(nodes[i], nodes[j])?, [i, j])));
        found.min_by_key(|(edge, _)| self.rank[*edge as usize])
    }

    fn number(&self, a: u32, b: u32) -> Option<u32> {
        let is_bridge = are_two(self.owners.only(a), self.owners.only(b));
        let place = is_bridge.then(|| self.edges.binary_search(&ordered(a, b)).ok())?;
        place.map(|place| place as u32)
    }
}

/// Whether nodes on these bodies lie on two. A node of several has none here: it may share one with the other end, and
/// such an edge may be theirs.
fn are_two(a: Option<u32>, b: Option<u32>) -> bool {
    a.is_some() && b.is_some() && a != b
}

fn ordered(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Ranks by length, the longest first; of equal ones the lower number.
fn ranks(mesh: &Mesh, edges: &[[u32; 2]]) -> Vec<u32> {
    let square = |[a, b]: [u32; 2]| (mesh.points[a as usize] - mesh.points[b as usize]).norm_squared();
    let squares: Vec<f64> = edges.iter().map(|&edge| square(edge)).collect();
    let mut order: Vec<usize> = (0..edges.len()).collect();
    order.sort_unstable_by(|&i, &j| squares[j].total_cmp(&squares[i]).then(i.cmp(&j)));
    let mut ranks = vec![0; edges.len()];
    (0..).zip(order).for_each(|(rank, edge)| ranks[edge] = rank);
    ranks
}
