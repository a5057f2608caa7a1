//! The constraints of a node, the best position that they allow, and the driver of all improvement: it starts from the poor
//! cells, goes round by round, and ends within a budget.

use crate::math::Vec3;
use crate::stop;
use rayon::prelude::*;

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
    stop::point();
    let positions = steps.into_iter().flat_map(|step| constraint.reachable(x, step));
    best_position(before, positions, worst).map(|(_, position)| position)
}

/// Someone who improves a mesh.
pub(in crate::mesh) trait Improver: Sync {
    /// Whether a cell falls short of what is wanted.
    fn is_poor(&self, cell: u32) -> bool;

    /// Works on `poor` cells, ascending; the cells that this may have changed.
    fn round(&mut self, poor: &[u32]) -> Vec<u32>;
}

/// Works on the poor ones of `suspects` and of what changes around them, until none is left or `rounds` are over; the cells
/// that changed last.
///
/// Cells are taken by their numbers, not by their quality: neighbours then follow each other, and the result does not hang on
/// ties.
pub(in crate::mesh) fn improve(improver: &mut impl Improver, mut suspects: Vec<u32>, rounds: usize) -> Vec<u32> {
    for _ in 0..rounds {
        let poor: Vec<u32> = suspects.into_par_iter().panic_fuse().filter(|&cell| improver.is_poor(cell)).collect();
        if poor.is_empty() {
            return poor;
        }
        suspects = ascending(improver.round(&poor));
    }
    suspects
}

/// Numbers sorted, each once.
pub(in crate::mesh) fn ascending(numbers: impl IntoIterator<Item = u32>) -> Vec<u32> {
    let mut numbers: Vec<u32> = numbers.into_iter().collect();
    numbers.par_sort_unstable();
    numbers.dedup();
    numbers
}
