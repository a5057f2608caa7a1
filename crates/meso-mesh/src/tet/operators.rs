//! Operators on cells, as proposals: other tetrahedra in the same volume, with a node less, or with one more.
//!
//! Freitag and Ollivier-Gooch, "Tetrahedral mesh improvement using swapping and smoothing" (1997); the cells without the edge are
//! found as there, by the best triangulation of the ring around it (Klincsek 1980).
//! Contraction and insertion as of Klingner and Shewchuk, "Aggressive tetrahedral mesh improvement" (2007).

use super::tetrahedra::shortest_altitude;
use super::topology::{NEW, Replacement, Topology};
use meso_collision::math::Vec3;

/// Nodes this near to a plane or a line are on it, mm: rounding leaves a hundredth of it.
pub(crate) const ON_MM: f64 = 1e-10;

/// Longest ring that is looked at: longer ones seldom gain, and cost the cube of their length.
const LONGEST_RING: usize = 7;

/// Applies the first swap found that enlarges the smallest angle around `cell`; whether there was one.
pub(crate) fn swapped(topology: &mut Topology, cell: u32) -> bool {
    let nodes = topology.cell(cell);
    let apply = |proposed: Option<Replacement>, topology: &mut Topology| {
        proposed.is_some_and(|proposed| topology.replace_thicker(&proposed))
    };
    edges(nodes).into_iter().any(|[a, b]| apply(edge_removal(topology, a, b), topology))
        || nodes.into_iter().any(|apex| apply(face_swap(topology, cell, apex), topology))
}

/// The edges of a cell.
pub(crate) fn edges([a, b, c, d]: [u32; 4]) -> [[u32; 2]; 6] {
    [[a, b], [a, c], [a, d], [b, c], [b, d], [c, d]]
}

/// The cells around the edge from a to b without that edge, where that leaves no angle as small as the smallest there. The cells
/// are of one owner, or on both sides of a plane facet, in which the edge's two triangles then have the other diagonal.
pub(crate) fn edge_removal(topology: &Topology, a: u32, b: u32) -> Option<Replacement> {
    let old = topology.around(&[a, b]);
    let arcs = arcs(topology, &old, a, b)?;
    let worst = topology.worst(&old);
    let mut new = Vec::new();
    for (owner, arc) in arcs {
        let of_arc = without_edge(topology, &arc, a, b, worst)?;
        new.extend(of_arc.into_iter().map(|cell| (cell, owner)));
    }
    Some(Replacement { old, new })
}

/// Whether four points are in one plane.
pub(crate) fn are_coplanar(points: [Vec3; 4]) -> bool {
    shortest_altitude(points).abs() <= ON_MM
}

/// The nodes around the edge, counter-clockwise seen from b, where they close up: all of them where the cells are of one owner,
/// otherwise those of either side, from one of the facet's two to the other.
fn arcs(topology: &Topology, cells: &[u32], a: u32, b: u32) -> Option<Vec<(u32, Vec<u32>)>> {
    let steps: Vec<([u32; 2], u32)> =
        cells.iter().map(|&cell| (beside(topology.cell(cell), a, b), topology.owner(cell))).collect();
    let after = |node: u32| steps.iter().find(|step| step.0[0] == node);
    let is_first = |step: &&([u32; 2], u32)| steps.iter().any(|last| last.0[1] == step.0[0] && last.1 != step.1);
    let first = steps.iter().find(is_first).or(steps.first())?;
    let mut arcs = vec![(first.1, vec![first.0[0]])];
    let mut step = first;
    for turn in 1..=steps.len() {
        let [here, next] = step.0;
        let (owner, arc) = arcs.last_mut()?;
        if *owner == step.1 {
            arc.push(next);
        } else {
            arcs.push((step.1, vec![here, next]));
        }
        step = after(next)?;
        // Shut once, and only at the end.
        if (step.0 == first.0) != (turn == steps.len()) {
            return None;
        }
    }
    let are_short = arcs.iter().all(|(_, arc)| (3..=LONGEST_RING).contains(&arc.len()));
    match &mut arcs[..] {
        [(_, ring)] => {
            ring.pop();
            (3..=LONGEST_RING).contains(&ring.len())
        }
        [(_, one), _] => are_short && are_coplanar([a, b, one[0], one[one.len() - 1]].map(|node| topology.point(node))),
        _ => false,
    }
    .then_some(arcs)
}

/// The other two nodes of a cell, so that with a and b before them the volume stays positive.
fn beside(cell: [u32; 4], a: u32, b: u32) -> [u32; 2] {
    let corner = |end: u32| cell.iter().position(|node| *node == end).expect("a cell around an edge has both its ends");
    let (at_a, at_b) = (corner(a), corner(b));
    let mut others = cell.into_iter().filter(|node| ![a, b].contains(node));
    let [first, second] = [others.next(), others.next()].map(|node| node.expect("a cell has four nodes"));
    // The order a, b, first, second takes so many exchanges of neighbours, or two less.
    let is_even = (at_a + at_b + usize::from(at_a < at_b)).is_multiple_of(2);
    if is_even { [first, second] } else { [second, first] }
}

/// The cells over and under the triangles of the ring, or of an arc and its chord, whose worst one is best, if better than `limit`.
fn without_edge(topology: &Topology, ring: &[u32], a: u32, b: u32, limit: f64) -> Option<Vec<[u32; 4]>> {
    let count = ring.len();
    // From one node of the ring to a later one: the worst cell of the best triangulation between them, and its third node.
    let mut best = vec![(-1.0_f64, 0); count * count];
    for length in 2..count {
        for i in 0..count - length {
            let j = i + length;
            let with = |k: usize| {
                let cells = pair(ring, [i, k, j], a, b).map(|cell| topology.cos2(cell));
                (cells[0].max(cells[1]).max(best[i * count + k].0).max(best[k * count + j].0), k)
            };
            best[i * count + j] = (i + 1..j).map(with).min_by(|a, b| a.0.total_cmp(&b.0))?;
        }
    }
    if best[count - 1].0 >= limit {
        return None;
    }
    let (mut new, mut open) = (Vec::new(), vec![[0, count - 1]]);
    while let Some([i, j]) = open.pop().filter(|_| new.len() < 2 * count) {
        if j > i + 1 {
            let k = best[i * count + j].1;
            new.extend(pair(ring, [i, k, j], a, b));
            open.extend([[i, k], [k, j]]);
        }
    }
    Some(new)
}

fn pair(ring: &[u32], [i, j, k]: [usize; 3], a: u32, b: u32) -> [[u32; 4]; 2] {
    [[ring[i], ring[j], ring[k], b], [ring[i], ring[k], ring[j], a]]
}

/// An edge through the face of a cell opposite to its corner `apex`, where both cells there are of one owner and that leaves no
/// angle as small as the smallest there: the 2-3 swap.
pub(crate) fn face_swap(topology: &Topology, cell: u32, apex: u32) -> Option<Replacement> {
    let nodes = topology.cell(cell);
    let face: Vec<u32> = nodes.into_iter().filter(|node| *node != apex).collect();
    let old = topology.around(&face);
    let [first, second] = old[..] else { return None };
    if topology.owner(first) != topology.owner(second) {
        return None;
    }
    let other = if first == cell { second } else { first };
    let beyond = topology.cell(other).into_iter().find(|node| !face.contains(node))?;
    // The corner that `beyond` takes in each keeps its place in the order, and so its turn.
    let owner = topology.owner(cell);
    let new: Vec<([u32; 4], u32)> =
        face.iter().map(|gone| (nodes.map(|node| if node == *gone { beyond } else { node }), owner)).collect();
    let worst = new.iter().map(|(nodes, _)| topology.cos2(*nodes)).fold(-1.0, f64::max);
    (worst < topology.worst(&old)).then_some(Replacement { old, new })
}

/// The cells around `node` once it is contracted onto `into`, where that leaves all of them better than `limit`: those that have
/// both nodes are gone, the others fill their volume.
pub(crate) fn contraction(topology: &Topology, node: u32, into: u32, limit: f64) -> Option<Replacement> {
    let old = topology.star(node).to_vec();
    let renamed = |&cell: &u32| (topology.cell(cell).map(|n| if n == node { into } else { n }), topology.owner(cell));
    let rest = old.iter().filter(|&&cell| !topology.cell(cell).contains(&into)).map(renamed);
    if !rest.clone().all(|(nodes, _)| topology.cos2(nodes) < limit) {
        return None;
    }
    let new = rest.collect();
    Some(Replacement { old, new })
}

/// The cells around the edge from a to b, each halved at a [`NEW`] node on it.
pub(crate) fn insertion(topology: &Topology, a: u32, b: u32) -> Replacement {
    let old = topology.around(&[a, b]);
    let half = |cell: u32, end: u32| {
        (topology.cell(cell).map(|node| if node == end { NEW } else { node }), topology.owner(cell))
    };
    let new = old.iter().flat_map(|&cell| [half(cell, a), half(cell, b)]).collect();
    Replacement { old, new }
}
