//! Bounds of the exact value of a label volume, from one solution on its voxels.
//!
//! A label volume is constant within each voxel, and the value that it stands for is that of the exact potential on this geometry. The
//! solution on links gives a bound on either side:
//!
//! - Its fluxes through the faces, linear within each voxel, close. By Thomson's principle their energy bounds the value from below.
//!   With fluxes `p` and `q` through opposite faces the links count `(p^2 + q^2) / 2` where the linear flux has
//!   `(p^2 + p q + q^2) / 3`, so the bound is the links' value and the mean of `(p - q)^2 / 6` times the resistance.
//! - A potential that is trilinear in each voxel is continuous. By Dirichlet's principle its energy bounds the value from above. The
//!   potential at a corner is the mean of what the eight voxels around it extrapolate from the links' solution, weighted by their
//!   values. A few steps of conjugate gradients lower its energy.
//!
//! Both principles are in Hashin and Shtrikman (J. Appl. Phys. 33, 1962, 3125). The two bounds converge to each other.

use super::Labelled;
use crate::field::Flow;
use crate::grid::{End, Grid};
use crate::links::Links;
use meso_collision::simd::{Wide, widest};
use meso_concrete::parallel;
use std::ops::Range;

/// Steps of conjugate gradients: in random volumes three take off most of what ten would.
const STEPS: usize = 3;
/// Layers of voxels whose sums at nodes are added up by one thread.
const SLAB: usize = 8;

/// Bounds of the value along the gradient of `flow`, whose links have the value `found`.
pub(super) fn bounds(labelled: &Labelled<f64>, flow: &Flow, last: usize, found: f64) -> [f64; 2] {
    let labels = labelled.turned(last);
    // Pockets without links take no energy.
    let has_links = |voxel: usize| (0..3).any(|axis| flow.links.across[axis][voxel] > 0.0) || flow.links.above(voxel);
    let value = |(voxel, label): (usize, &u8)| if has_links(voxel) { labelled.of[usize::from(*label)] } else { 0.0 };
    let values: Vec<f64> = labels.iter().enumerate().map(value).collect();
    let voxels = Trilinear::new(flow.grid, &values, flow.axis);
    let (excess, nodes) = voxels.from_links(flow);
    let volume = flow.grid.volume();
    let upper = voxels.lowered(nodes) / volume;
    [found + excess / volume, upper.max(found)]
}

/// Potentials at the corners of voxels, trilinear within each: deviations from a unit gradient along `axis`.
///
/// Nodes have one more along each axis than voxels; the last ones along a period equal the first ones.
struct Trilinear<'a> {
    grid: &'a Grid,
    values: &'a [f64],
    axis: usize,
    /// Energy of the squares of a voxel's modes, over its value; a mode has one bit for each axis.
    weights: [f64; 8],
}

/// Sums at the corners of a voxel.
type Corners = [f64; 8];

impl<'a> Trilinear<'a> {
    fn new(grid: &'a Grid, values: &'a [f64], axis: usize) -> Self {
        let h = grid.spacing;
        // A mode's derivative along an axis has a bit less; its square has the mean 1/3 for every bit left.
        let weight = |mode: usize| {
            let along = |a: usize| 4.0 / (h[a] * h[a]) * 3.0_f64.powi(1 - mode.count_ones() as i32);
            (0..3).filter(|a| mode >> a & 1 == 1).map(along).sum::<f64>() * h.x * h.y * h.z
        };
        Self { grid, values, axis, weights: std::array::from_fn(weight) }
    }

    fn layer(&self) -> usize {
        (self.grid.counts[0] + 1) * (self.grid.counts[1] + 1)
    }

    /// The links' energy less that of linear fluxes, and the mean potentials at the nodes with the sums of their voxels' values.
    fn from_links(&self, flow: &Flow) -> (f64, [Vec<f64>; 2]) {
        let areas = [0, 1, 2].map(|a| self.grid.area(a));
        let h = self.grid.spacing;
        let [nx, ny, _] = self.grid.counts;
        let of = |at: [usize; 3], excess: &mut f64| {
            let number = (at[2] * ny + at[1]) * nx + at[0];
            let value = self.values[number];
            if value <= 0.0 {
                return [[0.0; 8]; 2];
            }
            let mut slopes = [[0.0; 2]; 3];
            for axis in 0..3 {
                let given = if axis == self.axis { h[axis] / 2.0 } else { 0.0 };
                let fluxes = flow.at_faces(axis, at).map(|flux| flux / areas[axis]);
                *excess += (fluxes[1] - fluxes[0]).powi(2) / (6.0 * value);
                slopes[axis] = fluxes.map(|flux| flux / value * h[axis] / 2.0 - given);
            }
            let own = flow.potential[number];
            let corner = |corner: usize| {
                let side = |axis: usize| if corner >> axis & 1 == 1 { slopes[axis][1] } else { -slopes[axis][0] };
                value * (own + side(0) + side(1) + side(2))
            };
            [std::array::from_fn(corner), [value; 8]]
        };
        let (excess, [mut sums, weights]) = self.at_nodes(of);
        sums.iter_mut().zip(&weights).for_each(|(sum, weight)| *sum = if *weight > 0.0 { *sum / weight } else { 0.0 });
        self.hold(&mut sums);
        (excess * h.x * h.y * h.z, [sums, weights])
    }

    /// Adds up what voxels have for their corners, and a sum over all voxels.
    fn at_nodes<const N: usize>(
        &self,
        of: impl Fn([usize; 3], &mut f64) -> [Corners; N] + Sync,
    ) -> (f64, [Vec<f64>; N]) {
        let [nx, ny, nz] = self.grid.counts;
        let (row, layer) = (nx + 1, self.layer());
        let slab = |slab: usize| {
            widest(Slab::<_, N> {
                of: &of,
                layers: slab * SLAB..nz.min((slab + 1) * SLAB),
                counts: [nx, ny],
                row,
                layer,
            })
        };
        let slabs = parallel::map(nz.div_ceil(SLAB), slab);
        let total = slabs.iter().map(|(total, _)| total).sum();
        let mut all = [(); N].map(|()| vec![0.0; (nz + 1) * layer]);
        for (number, (_, sums)) in slabs.iter().enumerate() {
            for (all, sums) in all.iter_mut().zip(sums) {
                let to = &mut all[number * SLAB * layer..][..sums.len()];
                to.iter_mut().zip(sums).for_each(|(to, from)| *to += from);
            }
        }
        all.iter_mut().for_each(|sums| self.fold(sums));
        (total, all)
    }

    /// Adds nodes at the end of a period to those at its beginning, and gives both the sum.
    fn fold(&self, nodes: &mut [f64]) {
        for axis in (0..3).filter(|axis| self.grid.ends[*axis] == End::Periodic) {
            self.each_pair(axis, |first, last| {
                let sum = nodes[first] + nodes[last];
                (nodes[first], nodes[last]) = (sum, sum);
            });
        }
    }

    /// Nodes at given ends have no deviation.
    fn hold(&self, nodes: &mut [f64]) {
        if self.grid.ends[2] == End::Fixed {
            self.each_pair(2, |first, last| (nodes[first], nodes[last]) = (0.0, 0.0));
        }
    }

    /// Calls `visit` with the nodes at both ends of an axis.
    fn each_pair(&self, axis: usize, mut visit: impl FnMut(usize, usize)) {
        let counts = self.grid.counts.map(|count| count + 1);
        let steps = [1, counts[0], counts[0] * counts[1]];
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        for (p, q) in (0..counts[b]).flat_map(|p| (0..counts[c]).map(move |q| (p, q))) {
            let first = p * steps[b] + q * steps[c];
            visit(first, first + self.grid.counts[axis] * steps[axis]);
        }
    }

    /// Half the derivatives of the energy by the nodes' potentials, and the energy, of a deviation from a `given` gradient.
    fn derivatives(&self, nodes: &[f64], given: f64) -> (f64, Vec<f64>) {
        let [nx, ny, _] = self.grid.counts;
        let (row, layer) = (nx + 1, self.layer());
        let bit = 1 << self.axis;
        let of = |[i, j, k]: [usize; 3], energy: &mut f64| {
            let value = self.values[(k * ny + j) * nx + i];
            if value <= 0.0 {
                return [[0.0; 8]];
            }
            let start = k * layer + j * row + i;
            let places = [start, start + row, start + layer, start + layer + row];
            let mut modes = [0.0; 8];
            for (pair, place) in places.into_iter().enumerate() {
                (modes[2 * pair], modes[2 * pair + 1]) = (nodes[place], nodes[place + 1]);
            }
            transform(&mut modes);
            modes.iter_mut().for_each(|mode| *mode /= 8.0);
            modes[bit] += given;
            let mut sum = 0.0;
            for (mode, weight) in modes.iter_mut().zip(self.weights) {
                let through = value * weight * *mode;
                sum += through * *mode;
                *mode = through / 8.0;
            }
            *energy += sum;
            back(&mut modes);
            [modes]
        };
        let (energy, [mut out]) = self.at_nodes(of);
        self.hold(&mut out);
        (energy, out)
    }

    /// The energy of potentials at the nodes after some steps; their `weights` scale the steps.
    fn lowered(&self, [nodes, weights]: [Vec<f64>; 2]) -> f64 {
        let (mut energy, mut rest) = self.derivatives(&nodes, self.grid.spacing[self.axis] / 2.0);
        rest.iter_mut().for_each(|rest| *rest = -*rest);
        let scaled = |rest: &[f64]| -> Vec<f64> {
            let over = |(rest, weight): (&f64, &f64)| if *weight > 0.0 { rest / weight } else { 0.0 };
            rest.iter().zip(&weights).map(over).collect()
        };
        let mut way = scaled(&rest);
        let mut product = self.product(&rest, &way);
        for step in 1..=STEPS {
            let (curvature, along) = self.derivatives(&way, 0.0);
            if !(curvature > 0.0 && product > 0.0) {
                break;
            }
            let length = product / curvature;
            energy -= length * product;
            if step == STEPS {
                break;
            }
            rest.iter_mut().zip(&along).for_each(|(rest, along)| *rest -= length * along);
            let next = scaled(&rest);
            let now = self.product(&rest, &next);
            way.iter_mut().zip(&next).for_each(|(way, next)| *way = next + now / product * *way);
            product = now;
        }
        energy
    }

    /// Scalar product over the nodes, each period's once.
    fn product(&self, a: &[f64], b: &[f64]) -> f64 {
        let count = |axis: usize| self.grid.counts[axis] + usize::from(self.grid.ends[axis] != End::Periodic);
        let row = |j: usize, k: usize| -> Range<usize> {
            let start = k * self.layer() + j * (self.grid.counts[0] + 1);
            start..start + count(0)
        };
        let rows = (0..count(2)).flat_map(|k| (0..count(1)).map(move |j| (j, k)));
        rows.map(|(j, k)| a[row(j, k)].iter().zip(&b[row(j, k)]).map(|(a, b)| a * b).sum::<f64>()).sum()
    }
}

/// Layers of voxels whose sums at nodes are added up: what `of` has for the corners of each.
struct Slab<'a, F, const N: usize> {
    of: &'a F,
    layers: Range<usize>,
    counts: [usize; 2],
    row: usize,
    layer: usize,
}

impl<F: Fn([usize; 3], &mut f64) -> [Corners; N], const N: usize> Wide for Slab<'_, F, N> {
    type Output = (f64, [Vec<f64>; N]);
    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { of, layers, counts: [nx, ny], row, layer } = self;
        let (mut total, mut sums) = (0.0, [(); N].map(|()| vec![0.0; (layers.len() + 1) * layer]));
        for k in layers.clone() {
            for j in 0..ny {
                for i in 0..nx {
                    let start = (k - layers.start) * layer + j * row + i;
                    for (sums, corners) in sums.iter_mut().zip(of([i, j, k], &mut total)) {
                        let mut pair = |at: usize, low: f64, high: f64| {
                            sums[at] += low;
                            sums[at + 1] += high;
                        };
                        pair(start, corners[0], corners[1]);
                        pair(start + row, corners[2], corners[3]);
                        pair(start + layer, corners[4], corners[5]);
                        pair(start + layer + row, corners[6], corners[7]);
                    }
                }
            }
        }
        (total, sums)
    }
}

/// Sums and differences of the corners' values along each axis: eight times the modes.
#[inline(always)]
fn transform(of: &mut Corners) {
    for axis in 0..3 {
        for low in (0..8).filter(|low| low >> axis & 1 == 0) {
            let high = low | 1 << axis;
            (of[low], of[high]) = (of[low] + of[high], of[high] - of[low]);
        }
    }
}

/// The transposed sums: values of the modes at the corners.
#[inline(always)]
fn back(of: &mut Corners) {
    for axis in 0..3 {
        for low in (0..8).filter(|low| low >> axis & 1 == 0) {
            let high = low | 1 << axis;
            (of[low], of[high]) = (of[low] - of[high], of[low] + of[high]);
        }
    }
}

impl Flow<'_> {
    /// Fluxes through the faces below and above a voxel along `axis`.
    #[inline]
    fn at_faces(&self, axis: usize, at: [usize; 3]) -> [f64; 2] {
        let Links { counts, across, .. } = self.links;
        let steps = [1, counts[0], counts[0] * counts[1]];
        let number = at[0] + at[1] * steps[1] + at[2] * steps[2];
        let (step, count, links) = (steps[axis], counts[axis], &across[axis]);
        let is_open = self.grid.ends[axis] == End::Fixed;
        let around = step * count;
        let own = self.potential[number];
        let below = match at[axis] {
            0 if is_open => 0.0,
            0 => self.potential[number + around - step],
            _ => self.potential[number - step],
        };
        let (above, upper) = match at[axis] + 1 == count {
            true if is_open => (0.0, number + step),
            true => (self.potential[number + step - around], number + step - around),
            false => (self.potential[number + step], number + step),
        };
        let given = |number: usize| if axis == self.axis { self.length(axis, number) } else { 0.0 };
        // Links without a length are 0.
        [
            f64::from(links[number]) * (given(at[axis]) + own - below),
            f64::from(links[upper]) * (given(at[axis] + 1) + above - own),
        ]
    }
}
