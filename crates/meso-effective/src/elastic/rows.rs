//! Rows of voxels, several side by side, in vector instructions: the forces of their nodes, and sums over them.
//!
//! Nodes of a row are first added up along y and z, which voxels beside each other share; what is left along x is done for each
//! voxel. Forces go back the same way. No operation is fused or reordered, so every instruction set finds the same bits.

use super::blocks::{Block, scratch};
use super::laminate::Material;
use super::modes::{self, Cubic, Modes, Nodes, Number};
use super::voxels::Voxels;
use crate::grid::Grid;
use meso_collision::simd::Wide;
use std::ops::{Add, Mul, Range, Sub};

/// Voxels side by side.
const SIDE: usize = 8;

/// Numbers of voxels side by side.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(super) struct Lanes([f64; SIDE]);

macro_rules! operator {
    ($trait:ident, $name:ident, $assign:tt) => {
        impl $trait for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $name(mut self, other: Self) -> Self {
                for lane in 0..SIDE {
                    self.0[lane] $assign other.0[lane];
                }
                self
            }
        }
    };
}
operator!(Add, add, +=);
operator!(Sub, sub, -=);
operator!(Mul, mul, *=);

impl Number for Lanes {
    #[inline(always)]
    fn all(value: f64) -> Self {
        Self([value; SIDE])
    }
}

impl Lanes {
    #[inline(always)]
    fn load(row: &[f64], at: usize) -> Self {
        let mut lanes = [0.0; SIDE];
        lanes.copy_from_slice(&row[at..at + SIDE]);
        Self(lanes)
    }

    #[inline(always)]
    fn store(self, row: &mut [f64], at: usize) {
        row[at..at + SIDE].copy_from_slice(&self.0);
    }
}

/// Displacements and a mean strain on a grid of voxels.
#[derive(Clone, Copy)]
pub(super) struct State<'a> {
    pub(super) grid: &'a Grid,
    pub(super) voxels: &'a Voxels,
    /// Constants of the first materials, as far as they are the same along all axes: the phases.
    pub(super) cubic: &'a [Cubic<f64>],
    pub(super) u: &'a [f64],
    pub(super) mean: &'a [f64; 6],
}

/// Numbers along a row of nodes, for each component and mode along y and z. They begin with the row's first node, and zeros follow.
type Lines = [[Vec<f64>; 4]; 3];

fn lines(nx: usize) -> Lines {
    let len = nx.next_multiple_of(SIDE) + SIDE;
    std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; len]))
}

impl State<'_> {
    /// Modes along y and z of the nodes around a row of voxels. The node behind the last one is the first one again.
    #[inline(always)]
    fn combine(&self, [j, k]: [usize; 2], lines: &mut Lines) {
        let [nx, ny, nz] = self.grid.counts;
        let (behind, above) = (if j + 1 == ny { 0 } else { j + 1 }, if k + 1 == nz { 0 } else { k + 1 });
        let starts = [(j, k), (behind, k), (j, above), (behind, above)].map(|(j, k)| (k * ny + j) * nx);
        for (component, lines) in lines.iter_mut().enumerate() {
            let u = &self.u[component * nx * ny * nz..];
            let [a, b, c, d] = starts.map(|start| &u[start..start + nx]);
            let [sum, y, z, yz] = lines.each_mut().map(|line| &mut line[..=nx]);
            for i in 0..nx {
                let ([below, above], [below_y, above_y]) = ([a[i] + b[i], c[i] + d[i]], [b[i] - a[i], d[i] - c[i]]);
                sum[i] = below + above;
                y[i] = below_y + above_y;
                z[i] = above - below;
                yz[i] = above_y - below_y;
            }
            for line in [sum, y, z, yz] {
                line[nx] = line[0];
            }
        }
    }

    /// Strain of voxels from place `i` of a row on.
    #[inline(always)]
    fn strain(&self, lines: &Lines, i: usize) -> Modes<Lanes> {
        let mut of: Nodes<Lanes> = [[Lanes::all(0.0); 8]; 3];
        for component in 0..3 {
            for mode in 0..4 {
                let line = &lines[component][mode];
                let (left, right) = (Lanes::load(line, i), Lanes::load(line, i + 1));
                of[component][2 * mode] = left + right;
                of[component][2 * mode + 1] = right - left;
            }
        }
        let mut strain = modes::strain_of(&of, self.grid.spacing.into());
        for (row, mean) in strain.iter_mut().zip(self.mean) {
            row[0] = row[0] + Lanes::all(*mean);
        }
        strain
    }

    /// Stress of voxels with materials `numbers`; none beyond their end.
    #[inline(always)]
    fn stress(&self, numbers: &[u32], strain: &Modes<Lanes>) -> Modes<Lanes> {
        if numbers.iter().all(|number| (*number as usize) < self.cubic.len()) {
            let mut constants: Cubic<Lanes> = [Lanes::all(0.0); 3];
            for (lane, number) in numbers.iter().enumerate() {
                let of = &self.cubic[*number as usize];
                (0..3).for_each(|i| constants[i].0[lane] = of[i]);
            }
            modes::stress_of_cubic(&constants, strain)
        } else {
            let mut stiffness = [Lanes::all(0.0); 21];
            self.gather(numbers, &mut stiffness, |material| &material.stiffness);
            modes::stress_of(&stiffness, strain)
        }
    }

    /// Numbers of materials, side by side.
    #[inline(always)]
    fn gather<const N: usize>(&self, numbers: &[u32], to: &mut [Lanes; N], of: impl Fn(&Material) -> &[f32; N]) {
        for (lane, number) in numbers.iter().enumerate() {
            let of = of(&self.voxels.materials[*number as usize]);
            (0..N).for_each(|i| to[i].0[lane] = f64::from(of[i]));
        }
    }

    /// Sums over a layer of blocks.
    #[inline(always)]
    fn block_sums(&self, k: usize) -> [f64; 8] {
        let ([nx, ny, nz], mut sums) = (self.grid.counts, [0.0; 8]);
        let (volume, mut scratch) = (self.grid.volume() / (nx * ny * nz) as f64, scratch());
        for (j, i) in (0..nx * ny).map(|at| (at / nx, at % nx)) {
            let Some(block) = self.block([i, j, k]) else { continue };
            let own = block.sums(&self.nodes_of([i, j, k]), self.mean, &mut scratch);
            (0..8).for_each(|which| sums[which] += own[which] / volume);
        }
        sums
    }

    /// The block at a place of a grid of blocks.
    #[inline(always)]
    fn block(&self, at: [usize; 3]) -> Option<&Block> {
        self.voxels.blocks.get(self.number(at))
    }

    /// Mean stress of a voxel.
    pub(super) fn mean_stress(&self, at: [usize; 3]) -> [f64; 6] {
        let mut strain = modes::strain_of(&modes::products(self.nodes_of(at)), self.grid.spacing.into());
        strain.iter_mut().zip(self.mean).for_each(|(row, mean)| row[0] += mean);
        let material = &self.voxels.materials[self.number(at)];
        modes::stress_of(&material.stiffness.map(f64::from), &strain).map(|row| row[0])
    }

    /// Number of the material or block at a place.
    #[inline(always)]
    fn number(&self, [i, j, k]: [usize; 3]) -> usize {
        let [nx, ny, _] = self.grid.counts;
        self.voxels.of[(k * ny + j) * nx + i] as usize
    }

    /// Displacements at the nodes of a voxel or block.
    #[inline(always)]
    fn nodes_of(&self, [i, j, k]: [usize; 3]) -> Nodes<f64> {
        let [nx, ny, nz] = self.grid.counts;
        let above = if k + 1 == nz { 0 } else { k + 1 };
        let (corners, all) = (corners([nx, ny], i, j), nx * ny * nz);
        let mut values = [[0.0; 8]; 3];
        for (component, values) in values.iter_mut().enumerate() {
            let layers = [k, above].map(|k| &self.u[component * all + k * nx * ny..][..nx * ny]);
            for (node, value) in values.iter_mut().enumerate() {
                *value = layers[node / 4][corners[node]];
            }
        }
        values
    }

    /// Materials of the voxels of a row.
    #[inline(always)]
    fn numbers(&self, [j, k]: [usize; 2]) -> &[u32] {
        let [nx, ny, _] = self.grid.counts;
        &self.voxels.of[(k * ny + j) * nx..][..nx]
    }
}

/// Places in their layer of a voxel's nodes.
#[inline(always)]
fn corners([nx, ny]: [usize; 2], i: usize, j: usize) -> [usize; 8] {
    let next = |i: usize, n: usize| if i + 1 == n { 0 } else { i + 1 };
    let (right, back) = (next(i, nx), next(j, ny) * nx);
    let below = [j * nx + i, j * nx + right, back + i, back + right];
    [below[0], below[1], below[2], below[3], below[0], below[1], below[2], below[3]]
}

/// Forces by component on layers of nodes, and on the layer above them.
pub(super) struct Forces<'a> {
    pub(super) own: [&'a mut [f64]; 3],
    pub(super) above: [Vec<f64>; 3],
}

impl Forces<'_> {
    /// The layers of nodes below and above a layer of voxels.
    #[inline(always)]
    fn around(&mut self, component: usize, layer: usize, len: usize) -> [&mut [f64]; 2] {
        let (below, rest) = self.own[component][layer * len..].split_at_mut(len);
        let above = if rest.is_empty() { &mut self.above[component] } else { rest };
        [below, &mut above[..len]]
    }
}

/// Forces of layers of voxels on their nodes.
pub(super) struct Slab<'a, 'b> {
    pub(super) state: State<'a>,
    pub(super) layers: Range<usize>,
    pub(super) forces: &'a mut Forces<'b>,
}

impl Wide for Slab<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { state, layers, forces } = self;
        let [nx, ny, _] = state.grid.counts;
        let spacing = state.grid.spacing.into();
        forces.own.iter_mut().for_each(|own| own.fill(0.0));
        let (mut of, mut left, mut right) = (lines(nx), lines(nx), lines(nx));
        for (k, j) in layers.clone().flat_map(|k| (0..ny).map(move |j| (k, j))) {
            state.combine([j, k], &mut of);
            let numbers = state.numbers([j, k]);
            for i in (0..nx).step_by(SIDE) {
                let strain = state.strain(&of, i);
                let stress = state.stress(&numbers[i..nx.min(i + SIDE)], &strain);
                let modes = modes::spread(&stress, spacing);
                for component in 0..3 {
                    for mode in 0..4 {
                        let (a, b) = (modes[component][2 * mode], modes[component][2 * mode + 1]);
                        (a - b).store(&mut left[component][mode], i);
                        (a + b).store(&mut right[component][mode], i + 1);
                    }
                }
            }
            let rows = [j, if j + 1 == ny { 0 } else { j + 1 }];
            for component in 0..3 {
                let layers = forces.around(component, k - layers.start, nx * ny);
                scatter(&left[component], &mut right[component], layers, rows, nx);
            }
        }
    }
}

/// Adds forces by modes along y and z to two rows of nodes in each of two layers.
#[inline(always)]
fn scatter(left: &[Vec<f64>; 4], right: &mut [Vec<f64>; 4], layers: [&mut [f64]; 2], rows: [usize; 2], nx: usize) {
    for line in right.iter_mut() {
        line[0] = line[nx];
    }
    let ([sl, yl, zl, yzl], [sr, yr, zr, yzr]) =
        (left.each_ref().map(|line| &line[..nx]), right.each_ref().map(|line| &line[..nx]));
    for (layer, by_z) in layers.into_iter().zip([-1.0, 1.0]) {
        for (row, by_y) in rows.into_iter().zip([-1.0, 1.0]) {
            let row = &mut layer[row * nx..][..nx];
            for i in 0..nx {
                let (sum, y, z, yz) = (sl[i] + sr[i], yl[i] + yr[i], zl[i] + zr[i], yzl[i] + yzr[i]);
                row[i] += (sum + by_y * y) + by_z * (z + by_y * yz);
            }
        }
    }
}

/// Forces of layers of blocks on their nodes.
pub(super) struct BlockSlab<'a, 'b> {
    pub(super) state: State<'a>,
    pub(super) layers: Range<usize>,
    pub(super) forces: &'a mut Forces<'b>,
}

impl Wide for BlockSlab<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { state, layers, forces } = self;
        let [nx, ny, _] = state.grid.counts;
        forces.own.iter_mut().for_each(|own| own.fill(0.0));
        let mut scratch = scratch();
        for (k, (j, i)) in layers.clone().flat_map(|k| (0..nx * ny).map(move |at| (k, (at / nx, at % nx)))) {
            let Some(block) = state.block([i, j, k]) else { continue };
            let of = block.forces(&state.nodes_of([i, j, k]), state.mean, &mut scratch);
            let places = corners([nx, ny], i, j);
            for (component, of) in of.iter().enumerate() {
                let layers = forces.around(component, k - layers.start, nx * ny);
                for (node, force) in of.iter().enumerate() {
                    layers[node / 4][places[node]] += force;
                }
            }
        }
    }
}

/// Sums over a layer of voxels: stresses, energy, and eigenstress times strain.
pub(super) struct LayerSums<'a> {
    pub(super) state: State<'a>,
    pub(super) layer: usize,
}

impl Wide for LayerSums<'_> {
    type Output = [f64; 8];

    #[inline(always)]
    fn run(self) -> [f64; 8] {
        let Self { state, layer } = self;
        let [nx, ny, _] = state.grid.counts;
        if !state.voxels.blocks.is_empty() {
            return state.block_sums(layer);
        }
        let (mut of, mut sums) = (lines(nx), [Lanes::all(0.0); 8]);
        for j in 0..ny {
            state.combine([j, layer], &mut of);
            let numbers = state.numbers([j, layer]);
            for i in (0..nx).step_by(SIDE) {
                let numbers = &numbers[i..nx.min(i + SIDE)];
                let strain = state.strain(&of, i);
                let stress = state.stress(numbers, &strain);
                let mut eigenstress = [Lanes::all(0.0); 6];
                state.gather(numbers, &mut eigenstress, |material| &material.eigenstress);
                for row in 0..6 {
                    sums[row] = sums[row] + stress[row][0];
                    sums[7] = sums[7] + eigenstress[row] * strain[row][0];
                }
                sums[6] = sums[6] + modes::energy(&strain, &stress);
            }
        }
        sums.map(|lanes| lanes.0.iter().sum())
    }
}
