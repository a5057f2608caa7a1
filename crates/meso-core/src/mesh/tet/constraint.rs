//! What a node may do, and the best that it can: smoothing by search.

use crate::math::Vec3;

/// What one node of a mesh may do.
pub(in crate::mesh) trait Constraint {
    /// The positions that the node may take about one `step` from `x`; the unit of steps is the implementer's.
    fn reachable(&self, x: &Vec3, step: f64) -> Vec<Vec3>;

    /// Whether the node may be contracted onto its neighbour `into`.
    fn may_contract(&self, _into: u32) -> bool {
        false
    }

    /// All nodes that move when this one moves to `x`, itself included, with their new positions: its periodic images.
    fn moved(&self, node: u32, x: &Vec3) -> Vec<(u32, Vec3)> {
        vec![(node, *x)]
    }
}

/// Unit vectors to the 26 neighbours in a grid.
pub(in crate::mesh) fn directions() -> impl Iterator<Item = Vec3> {
    let direction = |i: i32| Vec3::new(f64::from(i % 3 - 1), f64::from(i / 3 % 3 - 1), f64::from(i / 9 - 1));
    (0..27).map(direction).filter_map(|direction| direction.try_normalize(0.5))
}

/// The position at which `worst(position, limit)` is least, and below `before`, with what it is there.
pub(in crate::mesh) fn best_position(
    before: f64,
    positions: impl IntoIterator<Item = Vec3>,
    worst: impl Fn(&Vec3, f64) -> f64,
) -> Option<(f64, Vec3)> {
    let mut best = (before, None);
    for position in positions {
        let there = worst(&position, best.0);
        if there < best.0 {
            best = (there, Some(position));
        }
    }
    best.1.map(|position| (best.0, position))
}

/// Where a node at `x` with the worst cell `before` should go: the best position that `constraint` lets it take at one of
/// `steps`; `None` where it is there already.
pub(in crate::mesh) fn smoothed(
    constraint: &impl Constraint,
    x: &Vec3,
    steps: impl IntoIterator<Item = f64>,
    before: f64,
    worst: impl Fn(&Vec3, f64) -> f64,
) -> Option<Vec3> {
    let positions = steps.into_iter().flat_map(|step| constraint.reachable(x, step));
    best_position(before, positions, worst).map(|(_, position)| position)
}
