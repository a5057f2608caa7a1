//! Two smooth fields about a grain: its own share, and how far that exceeds the share of its neighbours.
//!
//! Shares are indicators of voxels, blurred by a Gaussian of one width for all grains. So the shares of all grains sum to 1 at
//! most. Where a grain's share exceeds that of all others by a margin, no other grain's does. Beyond the walls the volume is
//! mirrored, so that surfaces meet walls at right angles.
//!
//! A share is kept as the depth below a plane surface that has it. Depths grow evenly from node to node, so that plane surfaces
//! are found where they are; shares themselves, which end at 0 and 1, misplace them by up to half a voxel between nodes two
//! voxels apart.

use super::distance::Voxels;
use super::labelled::LabelledGrains;
use super::tetrahedra::Nodes;

/// Nodes of the fields in the whole volume.
pub(super) struct Lattice {
    counts: [usize; 3],
    /// For each axis and node the first voxel, which may lie beyond a wall, and the weights of it and the next ones.
    weights: [Vec<(isize, Vec<f32>)>; 3],
    voxels: [usize; 3],
    /// Voxels that a kernel reaches.
    reach: usize,
    depths: Depths,
}

/// The fields at a box of nodes, x fastest.
pub(super) struct Field {
    /// First node along x, y, z.
    pub(super) from: [usize; 3],
    /// Edges of the lattice's cells in voxels.
    pub(super) spacing: [f64; 3],
    counts: [usize; 3],
    /// Whether the box ends at the volume's lower and upper walls.
    walls: [[bool; 2]; 3],
    /// Depths of the grain's share, in widths of the blur.
    own: Vec<f32>,
    /// Depths of the grain's share where those of all others leave it half of the rest.
    lead: Vec<f32>,
}

impl Field {
    /// Ends the grain where `depth`, of a place along x and y in voxels, is 0 at a margin.
    pub(super) fn cut(&mut self, margin: f32, depth: impl Fn([f64; 2]) -> f64) {
        let [nx, ny, _] = self.counts;
        let at = |axis: usize, node: usize| (self.from[axis] as f64 + node as f64 + 0.5) * self.spacing[axis];
        let plane: Vec<f32> = (0..nx * ny).map(|k| depth([at(0, k % nx), at(1, k / nx)]) as f32 + margin).collect();
        for layer in self.lead.chunks_exact_mut(nx * ny) {
            layer.iter_mut().zip(&plane).for_each(|(lead, depth)| *lead = lead.min(*depth));
        }
    }

    /// Ends the grain where its neighbours are so near that half of a gap is missing; a `margin` is there.
    ///
    /// A place belongs to the grain if the next neighbour is farther than the grain's own surface by the gap. So both grains of a pair
    /// give way alike, and the gap holds for any number of neighbours.
    pub(super) fn keep_off(&mut self, parts: &LabelledGrains, number: u32, gap: &Gap, margin: f32) {
        let pad = |axis: usize| (gap.gap_mm / gap.spacing_mm[axis]).ceil() + 2.0;
        let from = [0, 1, 2].map(|axis| (self.from[axis] as f64 * self.spacing[axis] - pad(axis)).max(0.0) as usize);
        let to = [0, 1, 2].map(|axis| {
            let last = (self.from[axis] + self.counts[axis]) as f64 * self.spacing[axis] + pad(axis);
            (last.ceil() as usize).min(parts.counts[axis])
        });
        let counts = [0, 1, 2].map(|axis| to[axis] - from[axis]);
        let [_, ny, nz] = counts;
        let row = |row: usize| {
            let start = ((from[2] + row / ny) * parts.counts[1] + from[1] + row % ny) * parts.counts[0];
            &parts.of[start + from[0]..start + to[0]]
        };
        let of: Vec<u32> = (0..ny * nz).flat_map(|at| row(at).iter().copied()).collect();
        let is_other = |voxel: usize| of[voxel] > 0 && of[voxel] != number;
        if !(0..of.len()).any(is_other) {
            return;
        }
        let voxels = Voxels { counts, spacing_mm: gap.spacing_mm };
        let [others, own, rest] = [
            voxels.distances(is_other),
            voxels.distances(|at| of[at] == number),
            voxels.distances(|at| of[at] != number),
        ];
        // Distances between middles are half a voxel longer than those from faces.
        let half = gap.spacing_mm.iter().copied().fold(f64::INFINITY, f64::min) / 2.0;
        let beyond = |voxel: usize| {
            let own = if of[voxel] == number { half - rest[voxel] } else { own[voxel] - half };
            ((others[voxel] - half - own - gap.gap_mm) / 2.0) / gap.width_mm
        };
        let beyond: Vec<f32> = (0..of.len()).map(|voxel| beyond(voxel).clamp(-FAR, FAR) as f32).collect();
        let [kx, ky, _] = self.counts;
        for (node, lead) in self.lead.iter_mut().enumerate() {
            let node = [node % kx, node / kx % ky, node / (kx * ky)];
            let at = [0, 1, 2].map(|axis| {
                let place = (self.from[axis] as f64 + node[axis] as f64 + 0.5) * self.spacing[axis] - 0.5;
                (place - from[axis] as f64).clamp(0.0, (counts[axis] - 1) as f64)
            });
            *lead = lead.min(between(&beyond, counts, at) + margin);
        }
    }

    /// Positive where the grain is deeper than `level`, and as far as `margin` from where its share is that of all others; both in
    /// widths of the blur. On each side a node is added in the
    /// wall, where there is one, with the value of its neighbour, and one beyond it with minus the size of that.
    pub(super) fn nodes(&self, level: f32, margin: f32) -> Nodes {
        let [nx, ny, _] = self.counts;
        let added = self.walls.map(|walls| walls.map(|is_there| 1 + usize::from(is_there)));
        let counts = [0, 1, 2].map(|axis| added[axis][0] + self.counts[axis] + added[axis][1]);
        let mut values = Vec::with_capacity(counts.iter().product());
        for (y, z) in (0..counts[2]).flat_map(|z| (0..counts[1]).map(move |y| (y, z))) {
            let inner = |axis: usize, node: usize| {
                let before = added[axis][0];
                node.clamp(before, before + self.counts[axis] - 1) - before
            };
            let row = (inner(2, z) * ny + inner(1, y)) * nx;
            let is_outer = y == 0 || z == 0 || y + 1 == counts[1] || z + 1 == counts[2];
            values.extend((0..counts[0]).map(|x| {
                let node = row + inner(0, x);
                let value = (self.own[node] - level).min(self.lead[node] - margin);
                if is_outer || x == 0 || x + 1 == counts[0] { -value.abs() } else { value }
            }));
        }
        Nodes { counts, walls: self.walls, values }
    }
}

/// A gap that grains keep.
pub(super) struct Gap {
    pub(super) gap_mm: f64,
    /// Edges of a voxel, mm.
    pub(super) spacing_mm: [f64; 3],
    /// Width of the blur, mm.
    pub(super) width_mm: f64,
}

/// The largest depth, in widths of the blur: no surface is found so far away.
const FAR: f64 = 100.0;

/// A value between the middles of voxels.
fn between(values: &[f32], [nx, ny, nz]: [usize; 3], at: [f64; 3]) -> f32 {
    let low = at.map(|x| x.floor());
    let part = [0, 1, 2].map(|axis| (at[axis] - low[axis]) as f32);
    let corner = |corner: usize| {
        let is_high = |axis: usize| corner >> axis & 1;
        let place = |axis: usize, count: usize| (low[axis] as usize + is_high(axis)).min(count - 1);
        let weight: f32 = (0..3).map(|axis| if is_high(axis) == 1 { part[axis] } else { 1.0 - part[axis] }).product();
        weight * values[(place(2, nz) * ny + place(1, ny)) * nx + place(0, nx)]
    };
    (0..8).map(corner).sum()
}

/// Standard deviations that a kernel reaches.
const REACH: f64 = 3.0;

impl Lattice {
    /// Nodes some `step` voxels apart, for a blur of `width` voxels.
    pub(super) fn new(voxels: [usize; 3], step: f64, width: f64) -> Self {
        let reach = (REACH * width).ceil() as usize;
        let counts = voxels.map(|count| (count as f64 / step).ceil() as usize);
        let axis = |axis: usize| {
            let spacing = voxels[axis] as f64 / counts[axis] as f64;
            (0..counts[axis]).map(|node| kernel((node as f64 + 0.5) * spacing, width, reach)).collect()
        };
        Self { counts, weights: [axis(0), axis(1), axis(2)], voxels, reach, depths: Depths::new() }
    }

    /// Edges of the lattice's cells in voxels.
    fn spacing(&self) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.voxels[axis] as f64 / self.counts[axis] as f64)
    }

    /// The fields around a grain, by its number from 1.
    pub(super) fn field(&self, parts: &LabelledGrains, number: u32) -> Field {
        let part = &parts.grains[number as usize - 1];
        let spacing = self.spacing();
        let pad = |axis: usize| self.reach as f64 / spacing[axis] + 2.0;
        let from = [0, 1, 2].map(|axis| (part.from[axis] as f64 / spacing[axis] - pad(axis)).max(0.0) as usize);
        let to = [0, 1, 2]
            .map(|axis| ((part.to[axis] as f64 / spacing[axis] + pad(axis)).ceil() as usize).min(self.counts[axis]));
        let counts = [0, 1, 2].map(|axis| to[axis] - from[axis]);
        let own = self.blurred(parts, from, counts, |voxel| voxel == number);
        let others = self.blurred(parts, from, counts, |voxel| voxel > 0 && voxel != number);
        let lead = own.iter().zip(&others).map(|(own, others)| self.depths.of((1.0 + own - others) / 2.0)).collect();
        let own = own.iter().map(|own| self.depths.of(*own)).collect();
        let walls = [0, 1, 2].map(|axis| [from[axis] == 0, to[axis] == self.counts[axis]]);
        Field { from, spacing, counts, walls, own, lead }
    }

    /// The blurred indicator of some voxels: along x, then y, then z.
    fn blurred(
        &self,
        parts: &LabelledGrains,
        from: [usize; 3],
        counts: [usize; 3],
        is_in: impl Fn(u32) -> bool,
    ) -> Vec<f32> {
        let [nx, ny, nz] = counts;
        let [ys, zs] = [1, 2].map(|axis| self.span(axis, from[axis], counts[axis]));
        let rows = ys[1] - ys[0];
        let mut along_x = vec![0.0; nx * rows * (zs[1] - zs[0])];
        let [first, last] = self.span(0, from[0], nx);
        let kernels = &self.weights[0][from[0]..from[0] + nx];
        let seen = kernels[0].0..kernels[nx - 1].0 + kernels[nx - 1].1.len() as isize;
        let seen: Vec<usize> = seen.map(|x| mirrored(x, self.voxels[0]) - first).collect();
        let mut row = vec![0.0; 0];
        for (line, out) in along_x.chunks_exact_mut(nx).enumerate() {
            let (y, z) = (ys[0] + line % rows, zs[0] + line / rows);
            let start = (z * self.voxels[1] + y) * self.voxels[0];
            let voxels = &parts.of[start + first..start + last];
            if !voxels.iter().any(|&voxel| is_in(voxel)) {
                continue;
            }
            row.clear();
            row.extend(seen.iter().map(|&x| f32::from(u8::from(is_in(voxels[x])))));
            for (out, (start, weights)) in out.iter_mut().zip(kernels) {
                let row = &row[(start - kernels[0].0) as usize..];
                *out = weights.iter().zip(row).map(|(weight, share)| weight * share).sum();
            }
        }
        let mut along_y = vec![0.0; nx * ny * (zs[1] - zs[0])];
        for (line, out) in along_y.chunks_exact_mut(nx).enumerate() {
            let (node, z) = (line % ny, line / ny);
            let plane = &along_x[z * nx * rows..][..nx * rows];
            self.sum(1, from[1] + node, |y| &plane[(y - ys[0]) * nx..][..nx], out);
        }
        let mut along_z = vec![0.0; nx * ny * nz];
        for (node, out) in along_z.chunks_exact_mut(nx * ny).enumerate() {
            self.sum(2, from[2] + node, |z| &along_y[(z - zs[0]) * nx * ny..][..nx * ny], out);
        }
        along_z
    }

    /// Adds the rows of an axis that a node sees to `out`, by their weights.
    fn sum<'a>(&self, axis: usize, node: usize, row: impl Fn(usize) -> &'a [f32], out: &mut [f32]) {
        let (start, weights) = &self.weights[axis][node];
        for (k, weight) in (0..).zip(weights) {
            let row = row(mirrored(start + k, self.voxels[axis]));
            out.iter_mut().zip(row).for_each(|(out, value)| *out += weight * value);
        }
    }

    /// The voxels that some nodes of an axis see.
    fn span(&self, axis: usize, from: usize, count: usize) -> [usize; 2] {
        let seen = |node: usize| {
            let (start, weights) = &self.weights[axis][node];
            (0..weights.len() as isize).map(move |k| mirrored(start + k, self.voxels[axis]))
        };
        let (first, last) = (from, from + count - 1);
        let ends = || seen(first).chain(seen(last));
        [ends().min().unwrap_or(0), ends().max().unwrap_or(0) + 1]
    }
}

/// The depths below a plane surface that have a blurred share, in widths of the blur.
struct Depths {
    /// Shares at even depths from -[`REACH`] on.
    shares: Vec<f32>,
}

/// Known depths in a width.
const KNOWN: usize = 64;

impl Depths {
    fn new() -> Self {
        let depth = |k: usize| k as f64 / KNOWN as f64 - REACH;
        let share = |k: usize| libm::erfc(-depth(k) / std::f64::consts::SQRT_2) / 2.0;
        Self { shares: (0..=2 * REACH as usize * KNOWN).map(|k| share(k) as f32).collect() }
    }

    fn of(&self, share: f32) -> f32 {
        let last = self.shares.len() - 1;
        // Most nodes are far from the surface.
        if share <= self.shares[0] || share >= self.shares[last] {
            return if share <= self.shares[0] { -REACH } else { REACH } as f32;
        }
        let above = self.shares.partition_point(|known| *known < share);
        let [low, high] = [self.shares[above - 1], self.shares[above]];
        let part = (share - low) / (high - low);
        ((above - 1) as f32 + part) / KNOWN as f32 - REACH as f32
    }
}

/// Weights of the voxels about `x`, which sum to 1.
fn kernel(x: f64, width: f64, reach: usize) -> (isize, Vec<f32>) {
    let start = x.floor() as isize - reach as isize;
    let weight = |k: usize| {
        let away = (start as f64 + k as f64 + 0.5 - x) / width;
        libm::exp(-0.5 * away * away)
    };
    let weights: Vec<f64> = (0..=2 * reach).map(weight).collect();
    let sum: f64 = weights.iter().sum();
    (start, weights.iter().map(|weight| (weight / sum) as f32).collect())
}

/// The voxel that a position beyond a wall mirrors.
fn mirrored(voxel: isize, count: usize) -> usize {
    let period = 2 * count as isize;
    let within = voxel.rem_euclid(period);
    within.min(period - 1 - within) as usize
}
