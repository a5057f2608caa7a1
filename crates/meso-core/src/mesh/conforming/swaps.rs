//! Other tetrahedra in the same room: an edge is taken out of the cells around it, or put through a face.
//!
//! Freitag and Ollivier-Gooch, "Tetrahedral mesh improvement using swapping and smoothing" (1997); the cells without the edge are
//! found as there, by the best triangulation of the ring around it (Klincsek 1980).

use super::web::Web;

/// Longest ring that is looked at: longer ones seldom gain, and cost the cube of their length.
const LONGEST_RING: usize = 7;

/// Takes the edge from a to b out of the cells around it where all are of one grain and that leaves no angle as sharp as the
/// sharpest there; whether it did.
pub(super) fn take_out(web: &mut Web, a: u32, b: u32) -> bool {
    let cells = web.around(&[a, b]);
    let Some(ring) = ring(web, &cells, a, b) else { return false };
    let Some(new) = without_edge(web, &ring, a, b, web.sharpest(&cells)) else { return false };
    replace_thicker(web, &cells, &new)
}

/// The nodes around the edge, counter-clockwise seen from b, where they close up and all cells are of one grain.
fn ring(web: &Web, cells: &[u32], a: u32, b: u32) -> Option<Vec<u32>> {
    let (&first, rest) = cells.split_first()?;
    if !(3..=LONGEST_RING).contains(&cells.len()) || rest.iter().any(|&cell| web.grain(cell) != web.grain(first)) {
        return None;
    }
    let steps: Vec<[u32; 2]> = cells.iter().map(|&cell| beside(web.cell(cell), a, b)).collect();
    let mut ring = vec![steps[0][0]];
    for _ in 0..steps.len() {
        let [_, next] = steps.iter().find(|step| Some(&step[0]) == ring.last())?;
        ring.push(*next);
    }
    let closes = ring.pop() == Some(ring[0]);
    let mut once = ring.clone();
    once.sort_unstable();
    once.dedup();
    (closes && once.len() == ring.len()).then_some(ring)
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

/// The cells over and under the triangles of the ring that are the least sharp, if less so than `limit`.
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
    let new: Vec<[u32; 4]> =
        face.iter().map(|gone| nodes.map(|node| if node == *gone { beyond } else { node })).collect();
    let sharpest = new.iter().map(|cell| web.sharpness(*cell)).fold(-1.0, f64::max);
    if sharpest >= web.sharpest(&cells) {
        return false;
    }
    replace_thicker(web, &cells, &new)
}

/// Puts `new` cells in the place of `old` ones where that makes no altitude, and so no stable time step, shorter; whether it
/// did.
fn replace_thicker(web: &mut Web, old: &[u32], new: &[[u32; 4]]) -> bool {
    let before = web.shortest_altitude(old.iter().map(|&cell| web.cell(cell)));
    let thicker = web.shortest_altitude(new.iter().copied()) >= before;
    if thicker {
        web.replace(old, new);
    }
    thicker
}
