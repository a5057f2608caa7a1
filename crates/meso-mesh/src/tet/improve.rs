//! The star of a node, its constraints, the best position that they allow, and the driver of all improvement: it starts from
//! the poor cells, goes round by round, and ends within a budget.

use super::tetrahedra::{TetMesh, lane_cos2, min_dihedral_cos2};
use crate::planes::LANES;
use meso_collision::math::Vec3;
use meso_collision::simd::{Wide, widest};
use meso_concrete::parallel;
use meso_concrete::stop;
use rayon::prelude::*;

/// The tetrahedra around one node as the opposite faces (a, b, c), with positive volume over the node, and their owners.
#[derive(Default)]
pub(crate) struct Star {
    pub(crate) centre: Vec3,
    /// The last eight is filled up with faces that it has already.
    eights: Vec<Eight>,
    owners: Vec<u32>,
    /// Number of the face that changed places with the first one.
    first: usize,
}

/// Eight faces: the x, y and z of their corners a, then of b and c.
#[derive(Clone, Copy)]
struct Eight([[f64; LANES]; 9]);

impl Eight {
    fn face(&self, lane: usize) -> [Vec3; 3] {
        [0, 3, 6].map(|at| Vec3::new(self.0[at][lane], self.0[at + 1][lane], self.0[at + 2][lane]))
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, [a, b, c]: [Vec3; 3]) {
        let all = [a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z];
        self.0.iter_mut().zip(all).for_each(|(row, value)| row[lane] = value);
    }

    /// [`min_dihedral_cos2`] of every face with `x`.
    #[inline(always)]
    fn cos2(&self, x: &Vec3) -> [f64; LANES] {
        let Self([ax, ay, az, bx, by, bz, cx, cy, cz]) = self;
        let mut all = [0.0; LANES];
        for l in 0..LANES {
            let [a, b, c] = [[ax[l], ay[l], az[l]], [bx[l], by[l], bz[l]], [cx[l], cy[l], cz[l]]].map(Vec3::from);
            all[l] = lane_cos2([*x, a, b, c]);
        }
        all
    }
}

/// [`min_dihedral_cos2`] of eight tetrahedra: x, y and z of their first corners, then of the others.
pub(crate) fn eight_cos2(corners: &[[f64; LANES]; 12]) -> [f64; LANES] {
    widest(Cavity(corners))
}

struct Cavity<'a>(&'a [[f64; LANES]; 12]);

impl Wide for Cavity<'_> {
    type Output = [f64; LANES];

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self([ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz]) = self;
        let mut all = [0.0; LANES];
        for l in 0..LANES {
            let [a, b] = [[ax[l], ay[l], az[l]], [bx[l], by[l], bz[l]]].map(Vec3::from);
            let [c, d] = [[cx[l], cy[l], cz[l]], [dx[l], dy[l], dz[l]]].map(Vec3::from);
            all[l] = lane_cos2([a, b, c, d]);
        }
        all
    }
}

/// The worst tetrahedron of some faces with a node at `x`; the search ends at the first eight with one above `limit`.
struct WorstAround<'a> {
    eights: &'a [Eight],
    x: &'a Vec3,
    limit: f64,
}

impl Wide for WorstAround<'_> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let mut worst: f64 = -1.0;
        for eight in self.eights {
            worst = eight.cos2(self.x).into_iter().fold(worst, f64::max);
            if worst > self.limit {
                break;
            }
        }
        worst
    }
}

/// The first of the worst tetrahedra of some faces with a node at `x`, and its measure.
struct First<'a>(&'a [Eight], &'a Vec3);

impl Wide for First<'_> {
    type Output = (f64, usize);

    #[inline(always)]
    fn run(self) -> (f64, usize) {
        let mut first = (-1.0, 0);
        for (number, eight) in self.0.iter().enumerate() {
            for (lane, cos2) in eight.cos2(self.1).into_iter().enumerate() {
                if cos2 > first.0 {
                    first = (cos2, number * LANES + lane);
                }
            }
        }
        first
    }
}

/// The measure of every tetrahedron of some faces with a node at `x`, by eights.
struct Each<'a> {
    eights: &'a [Eight],
    x: &'a Vec3,
    measures: &'a mut [[f64; LANES]],
}

impl Wide for Each<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (eight, measures) in self.eights.iter().zip(self.measures) {
            *measures = eight.cos2(self.x);
        }
    }
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
        let mut star = Self::default();
        star.refill(node, cells, position);
        star
    }

    /// Turns this star into that of another node; see [`of_cells`](Self::of_cells).
    pub(crate) fn refill(
        &mut self,
        node: u32,
        cells: impl Iterator<Item = ([u32; 4], u32)>,
        position: impl Fn(u32) -> Vec3,
    ) {
        self.centre = position(node);
        self.eights.clear();
        self.owners.clear();
        self.first = 0;
        for (nodes, owner) in cells {
            debug_assert!(nodes.contains(&node), "a star's cells hold its node");
            // Without branches: nobody predicts the corner that a node is.
            let at: usize = (1..4).map(|corner| corner * usize::from(nodes[corner] == node)).sum();
            // An even permutation that brings the node to the front.
            let other = |i: usize| position(nodes[(at ^ i) % 4]);
            self.push([other(1), other(2), other(3)], owner);
        }
    }

    #[inline(always)]
    fn push(&mut self, face: [Vec3; 3], owner: u32) {
        let lane = self.owners.len() % LANES;
        if lane == 0 {
            let [a, b, c] = face;
            let all = [a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z];
            self.eights.push(Eight(all.map(|value| [value; LANES])));
        } else if let Some(eight) = self.eights.last_mut() {
            eight.set(lane, face);
        }
        self.owners.push(owner);
    }

    fn face(&self, number: usize) -> [Vec3; 3] {
        self.eights[number / LANES].face(number % LANES)
    }

    fn faces(&self) -> impl Iterator<Item = ([Vec3; 3], u32)> + '_ {
        self.owners.iter().enumerate().map(|(number, owner)| (self.face(number), *owner))
    }

    /// With the cells of a periodic image of the node, `shift` mm away.
    pub(crate) fn with_image(mut self, image: &Self, shift: &Vec3) -> Self {
        image.faces().for_each(|(face, owner)| self.push(face.map(|p| p - shift), owner));
        self
    }

    /// [`min_dihedral_cos2`] of the worst tetrahedron with the node at `x`; of any above `limit` where there is one.
    pub(crate) fn worst(&self, x: &Vec3, limit: f64) -> f64 {
        let Some(eight) = self.eights.first() else { return -1.0 };
        // Most positions that are refused are refused by the face that was the worst before.
        let [a, b, c] = eight.face(0);
        let first = min_dihedral_cos2([*x, a, b, c]);
        if first > limit { first } else { widest(WorstAround { eights: &self.eights, x, limit }) }
    }

    /// [`worst`](Self::worst) of the node's own position; the worst tetrahedron comes first from now on, where searches
    /// with a limit end soonest.
    pub(crate) fn worst_first(&mut self) -> f64 {
        let (worst, at) = widest(First(&self.eights, &self.centre));
        if at > 0 {
            let [first, other] = [self.face(0), self.face(at)];
            self.eights[0].set(0, other);
            self.eights[at / LANES].set(at % LANES, first);
            self.owners.swap(0, at);
            self.first = at;
        }
        worst
    }

    /// Calls `visit` with the measure of every tetrahedron with the node at `x`, in the order in which the cells came;
    /// `memory` serves further calls. For stars whose worst tetrahedron came first once at most.
    pub(crate) fn each(&self, x: &Vec3, memory: &mut Vec<[f64; LANES]>, mut visit: impl FnMut(usize, f64)) {
        memory.resize(self.eights.len(), [0.0; LANES]);
        widest(Each { eights: &self.eights, x, measures: memory });
        for number in 0..self.owners.len() {
            let at = if number == 0 {
                self.first
            } else if number == self.first {
                0
            } else {
                number
            };
            visit(number, memory[at / LANES][at % LANES]);
        }
    }

    /// The gain of six times the volume of the star's tetrahedra by a unit move of the node, each tetrahedron counted as
    /// often as `weight` of its owner says: volumes are linear in the node's position.
    pub(crate) fn gain(&self, weight: impl Fn(u32) -> f64) -> Vec3 {
        -self.faces().map(|([a, b, c], owner)| (b - a).cross(&(c - a)) * weight(owner)).sum::<Vec3>()
    }

    /// The owners of the star's tetrahedra; each as often as it occurs.
    pub(crate) fn owners(&self) -> impl Iterator<Item = u32> + '_ {
        self.owners.iter().copied()
    }

    /// Mean of the surrounding nodes, each as often as it occurs.
    pub(crate) fn mean(&self) -> Vec3 {
        let sum: Vec3 = self.faces().flat_map(|(face, _)| face).sum();
        sum / (3 * self.owners.len()) as f64
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
/// Cavity are taken by their numbers, not by their quality: neighbours then follow each other, and the result does not hang on
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

#[cfg(test)]
mod tests {
    use super::super::tetrahedra::INVERTED;
    use super::*;
    use meso_collision::simd::{Isa, choose};
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{RngCore, SeedableRng};

    #[test]
    fn a_star_measured_by_eights_has_the_bits_of_its_tetrahedra_one_by_one() {
        let mut random = ChaCha8Rng::seed_from_u64(48);
        let mut point = || Vec3::from_fn(|_, _| f64::from(random.next_u32()) / f64::from(u32::MAX));
        let mut turned = 0;
        for count in 1..30 {
            let points: Vec<Vec3> = (0..=3 * count).map(|_| point()).collect();
            let cells: Vec<[u32; 4]> = (0..count).map(|i| [0, 3 * i + 1, 3 * i + 2, 3 * i + 3]).collect();
            let at = |node: u32| points[node as usize];
            let one_by_one: Vec<f64> = cells.iter().map(|cell| min_dihedral_cos2(cell.map(at))).collect();
            let corner = |l: usize, row: usize| at(cells[l.min(cells.len() - 1)][row / 3])[row % 3];
            let eight = eight_cos2(&std::array::from_fn(|row| std::array::from_fn(|l| corner(l, row))));
            assert!(eight.iter().zip(&one_by_one).all(|(a, b)| a.to_bits() == b.to_bits()), "{count}");
            let worst = one_by_one.iter().copied().fold(-1.0, f64::max);
            turned += usize::from(worst == INVERTED);
            for isa in Isa::ALL {
                choose(isa);
                let mut star = Star::of_cells(0, cells.iter().map(|&cell| (cell, 7)), at);
                assert_eq!(star.worst(&points[0], INVERTED).to_bits(), worst.to_bits(), "{count} {isa:?}");
                assert_eq!(star.worst_first().to_bits(), worst.to_bits());
                let (mut each, mut measures) = (vec![0.0; one_by_one.len()], Vec::new());
                star.each(&points[0], &mut measures, |number, measure| each[number] = measure);
                assert_eq!(each, one_by_one);
                let [a, b, c] = star.face(0);
                assert_eq!(min_dihedral_cos2([points[0], a, b, c]), worst, "the worst one comes first");
            }
            choose(Isa::best());
        }
        assert!((1..29).contains(&turned), "some have a tetrahedron that is turned over: {turned}");
    }
}
