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
//!   values. Steps of conjugate gradients lower its energy.
//!
//! Both principles are in Hashin and Shtrikman (J. Appl. Phys. 33, 1962, 3125). The two bounds converge to each other.

use super::Labelled;
use crate::flow::Flow;
use crate::grid::{End, Grid};
use meso_collision::simd::{Wide, widest};
use meso_concrete::parallel;
use std::ops::Range;

/// Most steps of conjugate gradients.
const STEPS: usize = 100;
/// A step that takes off less than this share of the interval is the last. Most volumes take one, contrasts of 1,000
/// ten; voxels cut in 64 take some four times as many.
const SMALL: f64 = 0.1;
/// The same of an interval that is wider than this share of the lower bound.
const SMALL_OF_WIDE: f64 = 0.01;
const WIDE: f64 = 0.1;
/// Layers of voxels whose sums at nodes are added up by one thread.
const SLAB: usize = 8;
/// Voxels side by side in a row.
const SIDE: usize = 8;

/// Numbers of voxels side by side.
type Lanes = [f64; SIDE];
/// Sums at the corners of voxels.
type Corners = [Lanes; 8];

/// Bounds of the value along the gradient of `flow`, whose links have the value `found`.
pub(super) fn bounds(labelled: &Labelled<f64>, flow: &Flow, last: usize, found: f64) -> [f64; 2] {
    let labels = labelled.turned(last);
    let mut values: Vec<f64> = labels.iter().map(|label| labelled.of[usize::from(*label)]).collect();
    if labelled.of.contains(&0.0) {
        // Pockets without links take no energy.
        let has_links =
            |voxel: usize| (0..3).any(|axis| flow.links.across[axis][voxel] > 0.0) || flow.links.above(voxel);
        values.iter_mut().enumerate().filter(|(voxel, _)| !has_links(*voxel)).for_each(|(_, value)| *value = 0.0);
    }
    let voxels = Trilinear::new(flow.grid, &values, flow.axis);
    let (excess, nodes) = voxels.start(flow);
    let volume = flow.grid.volume();
    let lower = found + excess / volume;
    let upper = voxels.lowered(nodes, lower * volume) / volume;
    [lower, upper.max(found)]
}

/// Potentials at the corners of voxels, trilinear within each: deviations from a unit gradient along `axis`.
///
/// Nodes have one more along each axis than voxels; the last ones along a period equal the first ones.
struct Trilinear<'a> {
    grid: &'a Grid,
    values: &'a [f64],
    axis: usize,
    /// Energy of the squares of a voxel's modes, eight times each, over its value; a mode has one bit for each axis.
    weights: [f64; 8],
}

impl<'a> Trilinear<'a> {
    fn new(grid: &'a Grid, values: &'a [f64], axis: usize) -> Self {
        let h = grid.spacing;
        // A mode's derivative along an axis has a bit less; its square has the mean 1/3 for every bit left.
        let weight = |mode: usize| {
            let along = |a: usize| 4.0 / (h[a] * h[a]) * 3.0_f64.powi(1 - mode.count_ones() as i32);
            (0..3).filter(|a| mode >> a & 1 == 1).map(along).sum::<f64>() * h.x * h.y * h.z / 64.0
        };
        Self { grid, values, axis, weights: std::array::from_fn(weight) }
    }

    fn layer(&self) -> usize {
        (self.grid.counts[0] + 1) * (self.grid.counts[1] + 1)
    }

    /// The links' energy less that of linear fluxes, and the mean potentials at the nodes with the sums of their voxels' values.
    fn start(&self, flow: &Flow) -> (f64, [Vec<f64>; 2]) {
        let h = self.grid.spacing;
        let to_corners = [0, 1, 2].map(|axis| h[axis] / 2.0 / self.grid.area(axis));
        let to_excess = [0, 1, 2].map(|axis| h.x * h.y * h.z / (6.0 * self.grid.area(axis).powi(2)));
        let (excess, [mut sums, weights]) = self.at_nodes(&FromLinks { voxels: self, flow, to_corners, to_excess });
        sums.iter_mut().zip(&weights).for_each(|(sum, weight)| *sum = if *weight > 0.0 { *sum / weight } else { 0.0 });
        self.hold(&mut sums);
        (excess, [sums, weights])
    }

    /// Adds up what rows of voxels have for their corners, and a sum over all voxels.
    fn at_nodes<const N: usize>(&self, rows: &impl CornerRows<N>) -> (f64, [Vec<f64>; N]) {
        let [nx, ny, nz] = self.grid.counts;
        let layer = self.layer();
        let slab = |slab: usize| {
            widest(CornerSlab::<_, N> { rows, layers: slab * SLAB..nz.min((slab + 1) * SLAB), counts: [nx, ny] })
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
        let (energy, [mut out]) = self.at_nodes(&Derivatives { voxels: self, nodes, given: 8.0 * given });
        self.hold(&mut out);
        (energy, out)
    }

    /// The energy of potentials at the nodes after some steps towards one that is at least `least`; their `weights` scale the steps.
    fn lowered(&self, [nodes, weights]: [Vec<f64>; 2], least: f64) -> f64 {
        let (mut energy, mut rest) = self.derivatives(&nodes, self.grid.spacing[self.axis] / 2.0);
        rest.iter_mut().for_each(|rest| *rest = -*rest);
        let scaled = |rest: &[f64]| -> Vec<f64> {
            let over = |(rest, weight): (&f64, &f64)| if *weight > 0.0 { rest / weight } else { 0.0 };
            rest.iter().zip(&weights).map(over).collect()
        };
        let mut way = scaled(&rest);
        let mut product = self.product(&rest, &way);
        for _ in 0..STEPS {
            let (curvature, along) = self.derivatives(&way, 0.0);
            if !(curvature > 0.0 && product > 0.0) {
                break;
            }
            let length = product / curvature;
            energy -= length * product;
            let small = if energy - least > WIDE * least { SMALL_OF_WIDE } else { SMALL };
            let is_large = length * product > small * (energy - least);
            if !is_large {
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

/// What rows of voxels add to the sums at their corners.
trait CornerRows<const N: usize>: Sync {
    /// Prepared for a row.
    type Row;
    fn row(&self, j: usize, k: usize) -> Self::Row;
    /// The sums of the voxels from `i` on; a `total` over all voxels grows.
    fn corners(&self, row: &Self::Row, i: usize, total: &mut Lanes, to: &mut [Corners; N]);
}

/// Layers of voxels whose sums at nodes are added up.
struct CornerSlab<'a, R, const N: usize> {
    rows: &'a R,
    layers: Range<usize>,
    counts: [usize; 2],
}

impl<R: CornerRows<N>, const N: usize> Wide for CornerSlab<'_, R, N> {
    type Output = (f64, [Vec<f64>; N]);
    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { rows, layers, counts: [nx, ny] } = self;
        let (width, layer) = (nx + 1, (nx + 1) * (ny + 1));
        let (mut total, mut sums) = ([0.0; SIDE], [(); N].map(|()| vec![0.0; (layers.len() + 1) * layer]));
        let mut of = [[[0.0; SIDE]; 8]; N];
        for (k, j) in layers.clone().flat_map(|k| (0..ny).map(move |j| (k, j))) {
            let row = rows.row(j, k);
            let start = (k - layers.start) * layer + j * width;
            let starts = [start, start + width, start + layer, start + layer + width];
            for i in (0..nx).step_by(SIDE) {
                rows.corners(&row, i, &mut total, &mut of);
                for (sums, corners) in sums.iter_mut().zip(&of) {
                    for (corner, lanes) in corners.iter().enumerate() {
                        let to = &mut sums[starts[corner / 2] + i + corner % 2..];
                        match to.first_chunk_mut::<SIDE>() {
                            Some(to) if i + SIDE <= nx => (0..SIDE).for_each(|lane| to[lane] += lanes[lane]),
                            _ => to[..nx - i].iter_mut().zip(lanes).for_each(|(to, lane)| *to += lane),
                        }
                    }
                }
            }
        }
        (total.iter().sum(), sums)
    }
}

/// Numbers from the beginning of a row, 0 beyond its end.
#[inline(always)]
fn lanes(row: &[f64]) -> Lanes {
    if let Some(lanes) = row.first_chunk() {
        return *lanes;
    }
    let mut lanes = [0.0; SIDE];
    lanes.iter_mut().zip(row).for_each(|(lane, of)| *lane = *of);
    lanes
}

/// Derivatives of the energy of potentials at the nodes.
struct Derivatives<'a> {
    voxels: &'a Trilinear<'a>,
    nodes: &'a [f64],
    /// Eight times the mode of the given gradient.
    given: f64,
}

impl<'a> CornerRows<1> for Derivatives<'a> {
    type Row = ([&'a [f64]; 4], &'a [f64]);

    #[inline(always)]
    fn row(&self, j: usize, k: usize) -> Self::Row {
        let ([nx, ny, _], layer) = (self.voxels.grid.counts, self.voxels.layer());
        let start = k * layer + j * (nx + 1);
        let starts = [start, start + nx + 1, start + layer, start + layer + nx + 1];
        (starts.map(|start| &self.nodes[start..][..nx + 1]), &self.voxels.values[(k * ny + j) * nx..][..nx])
    }

    #[inline(always)]
    fn corners(&self, (nodes, values): &Self::Row, i: usize, total: &mut Lanes, [modes]: &mut [Corners; 1]) {
        let Trilinear { weights, axis, .. } = self.voxels;
        let value = lanes(&values[i..]);
        for (corner, lanes_of) in modes.iter_mut().enumerate() {
            *lanes_of = lanes(&nodes[corner / 2][i + corner % 2..]);
        }
        transform(modes);
        modes[1 << axis].iter_mut().for_each(|mode| *mode += self.given);
        for (mode, weight) in modes.iter_mut().zip(weights) {
            for lane in 0..SIDE {
                let through = value[lane] * weight * mode[lane];
                total[lane] += through * mode[lane];
                mode[lane] = through;
            }
        }
        back(modes);
    }
}

/// Potentials that the links' solution has at the corners of voxels, times their values, and the values.
struct FromLinks<'a> {
    voxels: &'a Trilinear<'a>,
    flow: &'a Flow<'a>,
    to_corners: [f64; 3],
    to_excess: [f64; 3],
}

impl<'a> CornerRows<2> for FromLinks<'a> {
    /// Fluxes through the faces below and above along each axis, potentials, and values.
    type Row = ([[Vec<f64>; 2]; 3], &'a [f64], &'a [f64]);

    #[inline(always)]
    fn row(&self, j: usize, k: usize) -> Self::Row {
        let [nx, ny, _] = self.flow.grid.counts;
        let start = (k * ny + j) * nx;
        let fluxes = [0, 1, 2].map(|axis| self.flow.at_faces(axis, j, k));
        (fluxes, &self.flow.potential[start..][..nx], &self.voxels.values[start..][..nx])
    }

    #[inline(always)]
    fn corners(&self, (fluxes, own, values): &Self::Row, i: usize, total: &mut Lanes, [sums, of]: &mut [Corners; 2]) {
        let (own, value) = (lanes(&own[i..]), lanes(&values[i..]));
        *of = [value; 8];
        for sums in sums.iter_mut() {
            (0..SIDE).for_each(|lane| sums[lane] = value[lane] * own[lane]);
        }
        for (axis, [low, high]) in fluxes.iter().enumerate() {
            let given = if axis == self.voxels.axis { self.flow.grid.spacing[axis] / 2.0 } else { 0.0 };
            let (low, high) = (lanes(&low[i..]), lanes(&high[i..]));
            for lane in 0..SIDE {
                let varied = (high[lane] - low[lane]).powi(2) * self.to_excess[axis];
                total[lane] += if value[lane] > 0.0 { varied / value[lane] } else { 0.0 };
            }
            for (corner, sums) in sums.iter_mut().enumerate() {
                let (sign, flux) = if corner >> axis & 1 == 1 { (1.0, high) } else { (-1.0, low) };
                for lane in 0..SIDE {
                    sums[lane] += sign * (flux[lane] * self.to_corners[axis] - value[lane] * given);
                }
            }
        }
    }
}

/// Sums and differences of the corners' values along each axis: eight times the modes.
#[inline(always)]
fn transform(of: &mut Corners) {
    pairs(of, |low, high| (low + high, high - low));
}

/// The transposed sums: values of the modes at the corners.
#[inline(always)]
fn back(of: &mut Corners) {
    pairs(of, |low, high| (low - high, low + high));
}

#[inline(always)]
fn pairs(values: &mut Corners, of: impl Fn(f64, f64) -> (f64, f64)) {
    for axis in 0..3 {
        for low in (0..8).filter(|low| low >> axis & 1 == 0) {
            let high = low | 1 << axis;
            let (mut a, mut b) = (values[low], values[high]);
            for lane in 0..SIDE {
                (a[lane], b[lane]) = of(a[lane], b[lane]);
            }
            (values[low], values[high]) = (a, b);
        }
    }
}

impl Flow<'_> {
    /// Fluxes through the faces below and above the voxels of a row along `axis`.
    #[inline(always)]
    fn at_faces(&self, axis: usize, j: usize, k: usize) -> [Vec<f64>; 2] {
        let [nx, ny, nz] = self.links.counts;
        let (next, before) = (|at: usize, n: usize| (at + 1) % n, |at: usize, n: usize| (at + n - 1) % n);
        let outside = vec![0.0; nx];
        let is_open = self.grid.ends[2] == End::Fixed;
        let row = |j: usize, k: usize| &self.potential[(k * ny + j) * nx..][..nx];
        let links = |j: usize, k: usize| &self.links.across[axis][(k * ny + j) * nx..][..nx];
        let at = [0, j, k][axis];
        let given = |number: usize| if axis == self.axis { self.length(axis, number) } else { 0.0 };
        let fluxes = |links: &[f32], own: &[f64], below: &[f64], given: f64| -> Vec<f64> {
            let ends = own.iter().zip(below);
            links.iter().zip(ends).map(|(link, (own, below))| f64::from(*link) * (given + own - below)).collect()
        };
        let own = row(j, k);
        match axis {
            0 => {
                let mut below = fluxes(&links(j, k)[..1], &own[..1], &own[nx - 1..], given(0));
                below.extend(fluxes(&links(j, k)[1..], &own[1..], own, given(1)));
                let above = below[1..].iter().chain(&below[..1]).copied().collect();
                [below, above]
            }
            1 => [
                fluxes(links(j, k), own, row(before(j, ny), k), given(at)),
                fluxes(links(next(j, ny), k), row(next(j, ny), k), own, given(at + 1)),
            ],
            _ => {
                let below = if is_open && k == 0 { &outside } else { row(j, before(k, nz)) };
                let above = if is_open && k + 1 == nz { &outside } else { row(j, next(k, nz)) };
                [fluxes(links(j, k), own, below, given(at)), fluxes(links(j, k + 1), above, own, given(at + 1))]
            }
        }
    }
}
