//! How much mortar is between an aggregate and the nearest other one.

use super::Distribution;
use super::index::Index;
use crate::aggregate::Aggregate;
use crate::gjk::{self, GjkError};
use crate::math::{Aabb, Vec3};
use rayon::prelude::*;

/// Distances from each of the first `count` aggregates to the nearest other one, mm; `None` where there is no other.
pub(super) fn nearest_distances(
    aggregates: &[Aggregate],
    count: usize,
    index: &Index,
) -> Result<Option<Distribution>, GjkError> {
    if aggregates.len() < 2 {
        return Ok(None);
    }
    let distances = (0..count as u32).into_par_iter().map(|a| nearest(aggregates, index, a));
    Ok(Distribution::of(distances.collect::<Result<Vec<_>, _>>()?))
}

/// Looks into a growing box around the aggregate until the nearest found is nearer than the box reaches.
fn nearest(aggregates: &[Aggregate], index: &Index, a: u32) -> Result<f64, GjkError> {
    let own = index.aabb(a);
    let mut reach = 0.25 * index.cell();
    loop {
        let margin = Vec3::repeat(reach);
        let mut near = Vec::new();
        index.near(&Aabb { min: own.min - margin, max: own.max + margin }, &mut near);
        near.sort_unstable();
        near.dedup();
        let mut candidates: Vec<(f64, u32)> =
            near.into_iter().filter(|&b| b != a).map(|b| (gap(own, index.aabb(b)), b)).collect();
        candidates.sort_by(|x, y| x.0.total_cmp(&y.0));
        let mut best = f64::INFINITY;
        for (at_least, b) in candidates {
            if at_least < best {
                let [a, b] = [a, b].map(|i| aggregates[i as usize].body.vertices());
                best = best.min(gjk::distance(a, b)?);
            }
        }
        if best <= reach {
            return Ok(best);
        }
        // An aggregate found further off than the box reaches bounds the search; none found doubles it.
        reach = if best.is_finite() { best } else { 2.0 * reach };
    }
}

/// Distance between two boxes.
fn gap(a: &Aabb, b: &Aabb) -> f64 {
    let apart = (a.min - b.max).sup(&(b.min - a.max));
    apart.sup(&Vec3::zeros()).norm()
}
