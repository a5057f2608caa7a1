//! The star of a node, its constraints, the best position that they allow, and the driver of all improvement: it starts from
//! the poor cells, goes round by round, and ends within a budget.

use super::tetrahedra::{TetMesh, min_dihedral_cos2};
use meso_collision::math::Vec3;
use meso_concrete::parallel;
use meso_concrete::stop;
use rayon::prelude::*;

/// The tetrahedra around one node as the opposite faces (a, b, c), with positive volume over the node, and their owners.
pub(crate) struct Star {
    pub(crate) centre: Vec3,
    faces: Vec<([Vec3; 3], u32)>,
}

impl Star {
    /// The star of `node` in a mesh, from the numbers of its cells.
    pub(crate) fn of(mesh: &TetMesh, node: u32, cells: &[u32]) -> Self {
        Self::of_cells(node, cells.iter().map(|&cell| mesh.owned(cell)), |node| mesh.position(node))
    }

    /// The star of `node` from its cells with their owners; `position` finds their corners.
    pub(crate) fn of_cells(
        node: u32,
        cells: impl Iterator<Item = ([u32; 4], u32)>,
        position: impl Fn(u32) -> Vec3,
    ) -> Self {
        let face = |(nodes, owner): ([u32; 4], u32)| {
            let at = nodes.iter().position(|&n| n == node).expect("a star's cells hold its node");
            // Even permutations that bring the node to the front.
            let [i, j, k] = [[1, 2, 3], [0, 3, 2], [3, 0, 1], [2, 1, 0]][at];
            ([position(nodes[i]), position(nodes[j]), position(nodes[k])], owner)
        };
        Self { centre: position(node), faces: cells.map(face).collect() }
    }

    /// With the cells of a periodic image of the node, `shift` mm away.
    pub(crate) fn with_image(mut self, image: Self, shift: &Vec3) -> Self {
        self.faces.extend(image.faces.into_iter().map(|(face, owner)| (face.map(|p| p - shift), owner)));
        self
    }

    /// [`min_dihedral_cos2`] of the worst tetrahedron with the node at `x`. The search ends at the first above `limit`.
    pub(crate) fn worst(&self, x: &Vec3, limit: f64) -> f64 {
        let mut worst: f64 = -1.0;
        for ([a, b, c], _) in &self.faces {
            worst = worst.max(min_dihedral_cos2([*x, *a, *b, *c]));
            if worst > limit {
                break;
            }
        }
        worst
    }

    /// [`worst`](Self::worst) of the node's own position; the worst tetrahedron comes first from now on, where searches
    /// with a limit end soonest.
    pub(crate) fn worst_first(&mut self) -> f64 {
        let x = self.centre;
        let (mut worst, mut at) = (-1.0, 0);
        for (i, ([a, b, c], _)) in self.faces.iter().enumerate() {
            let cos2 = min_dihedral_cos2([x, *a, *b, *c]);
            if cos2 > worst {
                (worst, at) = (cos2, i);
            }
        }
        self.faces.swap(0, at);
        worst
    }

    /// The gain of six times the volume of the star's tetrahedra by a unit move of the node, each tetrahedron counted as
    /// often as `weight` of its owner says: volumes are linear in the node's position.
    pub(crate) fn gain(&self, weight: impl Fn(u32) -> f64) -> Vec3 {
        -self.faces.iter().map(|([a, b, c], owner)| (b - a).cross(&(c - a)) * weight(*owner)).sum::<Vec3>()
    }

    /// The owners of the star's tetrahedra; each as often as it occurs.
    pub(crate) fn owners(&self) -> impl Iterator<Item = u32> + '_ {
        self.faces.iter().map(|(_, owner)| *owner)
    }

    /// Mean of the surrounding nodes, each as often as it occurs.
    pub(crate) fn mean(&self) -> Vec3 {
        let sum: Vec3 = self.faces.iter().flat_map(|(face, _)| face).sum();
        sum / (3 * self.faces.len()) as f64
    }
}

/// The moves that one node of a mesh may make.
pub(crate) trait Constraint {
    /// The positions that the node may take about one `step` from `x`; the unit of steps is the implementer's.
    fn reachable(&self, x: &Vec3, step: f64) -> Vec<Vec3>;
}

/// Unit vectors to the 26 neighbours in a grid.
pub(crate) fn directions() -> impl Iterator<Item = Vec3> {
    let direction = |i: i32| Vec3::new(f64::from(i % 3 - 1), f64::from(i / 3 % 3 - 1), f64::from(i / 9 - 1));
    (0..27).map(direction).filter_map(|direction| direction.try_normalize(0.5))
}

/// The position at which `worst(position, limit)` is least, and below `before`, with its value there.
pub(crate) fn best_position(
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
pub(crate) fn smoothed(
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
pub(crate) trait Improver: Sync {
    /// Whether a cell falls short of the target.
    fn is_poor(&self, cell: u32) -> bool;

    /// Works on `poor` cells, ascending; the cells that this may have changed.
    fn round(&mut self, poor: &[u32]) -> Vec<u32>;
}

/// Works on the poor ones of `suspects` and of the cells that change around them, until none is left or `rounds` are over; the cells
/// that changed last.
///
/// Cells are taken by their numbers, not by their quality: neighbours then follow each other, and the result does not hang on
/// ties.
pub(crate) fn improve(improver: &mut impl Improver, mut suspects: Vec<u32>, rounds: usize) -> Vec<u32> {
    for _ in 0..rounds {
        let poor = parallel::pick(&suspects, |&cell| improver.is_poor(cell));
        drop(suspects);
        if poor.is_empty() {
            return poor;
        }
        suspects = ascending(improver.round(&poor));
    }
    suspects
}

/// Numbers sorted, each once.
pub(crate) fn ascending(numbers: impl IntoIterator<Item = u32>) -> Vec<u32> {
    let mut numbers: Vec<u32> = numbers.into_iter().collect();
    numbers.par_sort_unstable();
    numbers.dedup();
    numbers
}
