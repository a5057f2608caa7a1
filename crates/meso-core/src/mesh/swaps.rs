//! Other tetrahedra in the same room: an edge is taken out of the cells around it, or put through a face.
//!
//! Freitag and Ollivier-Gooch, "Tetrahedral mesh improvement using swapping and smoothing" (1997); the cells without the edge are
//! found as there, by the best triangulation of the ring around it (Klincsek 1980).

use super::quality::shortest_altitude;
use super::web::Web;
use crate::math::Vec3;

/// Nodes this near to a plane or a line are on it, mm: what rounding leaves is a hundredth of it.
pub(super) const ON_MM: f64 = 1e-10;

/// Longest ring that is looked at: longer ones seldom gain, and cost the cube of their length.
const LONGEST_RING: usize = 7;

/// Takes the first swap found that makes what is around `cell` less sharp; whether there was one.
pub(super) fn swapped(web: &mut Web, cell: u32) -> bool {
    let [a, b, c, d] = web.cell(cell);
    let edges = [[a, b], [a, c], [a, d], [b, c], [b, d], [c, d]];
    edges.into_iter().any(|[a, b]| take_out(web, a, b))
        || [a, b, c, d].into_iter().any(|apex| put_through(web, cell, apex))
}

/// Takes the edge from a to b out of the cells around it where that leaves no angle as sharp as the sharpest there; whether it
/// did. The cells are of one grain, or on both sides of a plane facet, in which the edge's two triangles then have the other
/// diagonal.
pub(super) fn take_out(web: &mut Web, a: u32, b: u32) -> bool {
    let cells = web.around(&[a, b]);
    let Some(arcs) = arcs(web, &cells, a, b) else { return false };
    let sharpest = web.sharpest(&cells);
    let mut new = Vec::new();
    for (grain, arc) in arcs {
        let Some(of_arc) = without_edge(web, &arc, a, b, sharpest) else { return false };
        new.extend(of_arc.into_iter().map(|cell| (cell, grain)));
    }
    web.replace_thicker(&cells, &new)
}

/// Whether four points are in one plane.
pub(super) fn are_in_a_plane(points: [Vec3; 4]) -> bool {
    shortest_altitude(points).abs() <= ON_MM
}

/// The nodes around the edge, counter-clockwise seen from b, where they close up: all of them where the cells are of one grain,
/// otherwise those of either side, from one of the facet's two to the other.
fn arcs(web: &Web, cells: &[u32], a: u32, b: u32) -> Option<Vec<(u32, Vec<u32>)>> {
    let steps: Vec<([u32; 2], u32)> =
        cells.iter().map(|&cell| (beside(web.cell(cell), a, b), web.grain(cell))).collect();
    let after = |node: u32| steps.iter().find(|step| step.0[0] == node);
    let is_first = |step: &&([u32; 2], u32)| steps.iter().any(|last| last.0[1] == step.0[0] && last.1 != step.1);
    let first = steps.iter().find(is_first).or(steps.first())?;
    let mut arcs = vec![(first.1, vec![first.0[0]])];
    let mut step = first;
    for place in 1..=steps.len() {
        let [here, next] = step.0;
        let (grain, arc) = arcs.last_mut()?;
        if *grain == step.1 {
            arc.push(next);
        } else {
            arcs.push((step.1, vec![here, next]));
        }
        step = after(next)?;
        // Shut once, and only at the end.
        if (step.0 == first.0) != (place == steps.len()) {
            return None;
        }
    }
    let are_short = arcs.iter().all(|(_, arc)| (3..=LONGEST_RING).contains(&arc.len()));
    match &mut arcs[..] {
        [(_, ring)] => {
            ring.pop();
            (3..=LONGEST_RING).contains(&ring.len())
        }
        [(_, one), _] => are_short && are_in_a_plane([a, b, one[0], one[one.len() - 1]].map(|node| web.point(node))),
        _ => false,
    }
    .then_some(arcs)
}

/// The other two nodes of a cell, so that with a and b before them the volume stays positive.
fn beside(cell: [u32; 4], a: u32, b: u32) -> [u32; 2] {
    let place = |end: u32| cell.iter().position(|node| *node == end).expect("a cell around an edge has both its ends");
    let (at_a, at_b) = (place(a), place(b));
    let mut others = cell.into_iter().filter(|node| ![a, b].contains(node));
    let [first, second] = [others.next(), others.next()].map(|node| node.expect("a cell has four nodes"));
    // The order a, b, first, second takes so many exchanges of neighbours, or two less.
    let is_even = (at_a + at_b + usize::from(at_a < at_b)).is_multiple_of(2);
    if is_even { [first, second] } else { [second, first] }
}

/// The cells over and under the triangles of the ring, or of an arc and its chord, that are the least sharp, if less so than `limit`.
fn without_edge(web: &Web, ring: &[u32], a: u32, b: u32, limit: f64) -> Option<Vec<[u32; 4]>> {
    let count = ring.len();
    // From one node of the ring to a later one: how sharp the best triangulation between them is, and its third node.
    let mut best = vec![(-1.0_f64, 0); count * count];
    for length in 2..count {
        for i in 0..count - length {
            let j = i + length;
            let with = |k: usize| {
                let cells = pair(ring, [i, k, j], a, b).map(|cell| web.sharpness(cell));
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

/// Joins the nodes beyond a face of a cell, opposite to its corner `apex`, by an edge where both cells are of one grain and
/// that leaves no angle as sharp as the sharpest there; whether it did.
pub(super) fn put_through(web: &mut Web, cell: u32, apex: u32) -> bool {
    let nodes = web.cell(cell);
    let face: Vec<u32> = nodes.into_iter().filter(|node| *node != apex).collect();
    let cells = web.around(&face);
    let [first, second] = cells[..] else { return false };
    if web.grain(first) != web.grain(second) {
        return false;
    }
    let other = if first == cell { second } else { first };
    let Some(beyond) = web.cell(other).into_iter().find(|node| !face.contains(node)) else { return false };
    // The corner that `beyond` takes in each keeps its place in the order, and so its turn.
    let grain = web.grain(cell);
    let new: Vec<([u32; 4], u32)> =
        face.iter().map(|gone| (nodes.map(|node| if node == *gone { beyond } else { node }), grain)).collect();
    let sharpest = new.iter().map(|(cell, _)| web.sharpness(*cell)).fold(-1.0, f64::max);
    if sharpest >= web.sharpest(&cells) {
        return false;
    }
    web.replace_thicker(&cells, &new)
}
