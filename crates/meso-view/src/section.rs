//! Plane sections: their axes, the order of corners around them, and polygons in parts.

use std::ops::IndexMut;

/// The axes to the right and upwards in a section across x, y, z.
pub const ACROSS: [(usize, usize); 3] = [(1, 2), (0, 2), (0, 1)];

/// Sorts the corners of a convex section by their angles about their middle.
pub fn sort_around(corners: &mut [[f64; 2]]) {
    let count = corners.len() as f64;
    let [x, y] = corners.iter().fold([0.0, 0.0], |sum, c| [sum[0] + c[0] / count, sum[1] + c[1] / count]);
    let angle = |c: &[f64; 2]| libm::atan2(c[1] - y, c[0] - x);
    corners.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
}

/// The parts of a polygon, whose points have `N` coordinates, below `at` on `axis`, and from there on. Two polygons with a
/// common edge cut it at the same point to the last bit, so that the parts cover the polygon exactly.
pub fn divide<P: Copy + IndexMut<usize, Output = f64>, const N: usize>(
    polygon: &[P],
    axis: usize,
    at: f64,
    below: &mut Vec<P>,
    above: &mut Vec<P>,
) {
    below.clear();
    above.clear();
    let Some(mut from) = polygon.last() else { return };
    for to in polygon {
        if (from[axis] < at) != (to[axis] < at) {
            let (low, high) = if from[axis] < at { (from, to) } else { (to, from) };
            let share = (at - low[axis]) / (high[axis] - low[axis]);
            let mut cut = *low;
            (0..N).for_each(|k| cut[k] = low[k] + (high[k] - low[k]) * share);
            cut[axis] = at;
            below.push(cut);
            above.push(cut);
        }
        if to[axis] < at {
            below.push(*to);
        } else {
            above.push(*to);
        }
        from = to;
    }
}
