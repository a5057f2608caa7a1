//! Blocks of voxels with displacements that are trilinear over the whole block: coarse spaces of a label volume.
//!
//! A block has the exact stiffness of the voxels in it. Displacements that are trilinear over blocks are so over voxels, too, so each
//! space contains the coarser one, and all energies bound the exact one from above.
//!
//! A block of 2 x 2 x 2 parts has the stiffness `sum of Q^T K Q`, where `Q` interpolates the nodes of a part from those of the block.
//! At the end of an odd count, a block has one part along that axis. Blocks of the same parts are one.

use super::laminate::Material;
use super::modes::{Nodes, ROW, at_nodes, products, spread, strain_of, stress_of};
use meso_collision::simd::{Wide, widest};

/// Displacements of a block's nodes: eight along x, then those along y and z.
const LEN: usize = 24;

/// Forces while they are summed, eight rows at a time. On the stack, compilers would take them apart into single numbers.
pub(super) type Scratch = Vec<f64>;

pub(super) fn scratch() -> Scratch {
    vec![0.0; LEN]
}

/// A block as an element.
pub(super) struct Block {
    /// Edges, mm.
    size: [f64; 3],
    stiffness: Box<[[f32; LEN]; LEN]>,
    /// Forces of the eigenstress.
    eigen: [f64; LEN],
    /// Mean material, for the preconditioner.
    pub(super) material: Material,
}

impl Block {
    /// A voxel.
    pub(super) fn of(material: &Material, size: [f64; 3]) -> Self {
        let volume: f64 = size.iter().product();
        let (mut stiffness, mut eigen) = (Box::new([[0.0; LEN]; LEN]), [0.0; LEN]);
        for column in 0..LEN {
            let mut nodes: Nodes<f64> = [[0.0; 8]; 3];
            nodes[column / 8][column % 8] = 1.0;
            let strain = strain_of(&products(nodes), size);
            eigen[column] = (0..6).map(|row| f64::from(material.eigenstress[row]) * strain[row][0] * volume).sum();
            let forces = at_nodes(spread(&stress_of(&material.stiffness.map(f64::from), &strain), size));
            (0..LEN).for_each(|row| stiffness[row][column] = forces[row / 8][row % 8] as f32);
        }
        Self { size, stiffness, eigen, material: *material }
    }

    /// Eight parts, of which the first is there; a part's number has one bit for each axis.
    pub(super) fn joined(parts: [Option<&Self>; 8]) -> Self {
        let first = parts[0].map_or([0.0; 3], |first| first.size);
        let size = [0, 1, 2].map(|axis| first[axis] + parts[1 << axis].map_or(0.0, |part| part.size[axis]));
        let (mut stiffness, mut eigen) = ([[0.0; LEN]; LEN], [0.0; LEN]);
        let (mut mean, volume) = ([0.0; 21], size.iter().product::<f64>());
        for (side, part) in parts.iter().enumerate().filter_map(|(side, part)| Some((side, (*part)?))) {
            // Weights of the block's nodes at each node of the part.
            let weight = |node: usize, of: usize, axis: usize| {
                let start = if side >> axis & 1 == 1 { first[axis] } else { 0.0 };
                let at = (start + (node >> axis & 1) as f64 * part.size[axis]) / size[axis];
                if of >> axis & 1 == 1 { at } else { 1.0 - at }
            };
            let weights = std::array::from_fn(|node| {
                std::array::from_fn(|of| weight(node, of, 0) * weight(node, of, 1) * weight(node, of, 2))
            });
            widest(Interpolated { part, weights: &weights, stiffness: &mut stiffness });
            for (number, force) in part.eigen.iter().enumerate() {
                let of = weights[number % 8].iter().zip(&mut eigen[number / 8 * 8..]);
                of.for_each(|(weight, eigen)| *eigen += weight * force);
            }
            let share = part.size.iter().product::<f64>() / volume;
            mean.iter_mut().zip(part.material.stiffness).for_each(|(mean, c)| *mean += share * f64::from(c));
        }
        // Rounded once, both halves alike.
        let rounded = |row: usize, column: usize| stiffness[row.max(column)][row.min(column)] as f32;
        let stiffness = Box::new(std::array::from_fn(|row| std::array::from_fn(|column| rounded(row, column))));
        let material = Material { stiffness: mean.map(|c| c as f32), eigenstress: [0.0; 6] };
        Self { size, stiffness, eigen, material }
    }

    /// Half the edges, with the sign that a node has along each axis.
    #[inline(always)]
    fn along(&self) -> [[f64; 8]; 3] {
        let mut along = [[0.0; 8]; 3];
        for (axis, along) in along.iter_mut().enumerate() {
            for (node, along) in along.iter_mut().enumerate() {
                *along = ((node >> axis & 1) as f64 - 0.5) * self.size[axis];
            }
        }
        along
    }

    /// Displacements of the nodes for a `mean` strain and a deviation from it, less their mean: the forces of a translation are rounding.
    #[inline(always)]
    fn displaced(&self, nodes: &Nodes<f64>, mean: &[f64; 6]) -> Nodes<f64> {
        let along = self.along();
        let mut displaced = *nodes;
        for component in 0..3 {
            let own = &mut displaced[component];
            let middle = own.iter().sum::<f64>() / 8.0;
            for node in 0..8 {
                let given = |axis: usize| {
                    let row = ROW[component][axis];
                    (if row < 3 { mean[row] } else { mean[row] / 2.0 }) * along[axis][node]
                };
                own[node] = given(0) + given(1) + given(2) + own[node] - middle;
            }
        }
        displaced
    }

    /// Forces on the nodes.
    #[inline(always)]
    pub(super) fn forces(&self, nodes: &Nodes<f64>, mean: &[f64; 6], scratch: &mut Scratch) -> Nodes<f64> {
        self.forces_at(&self.displaced(nodes, mean), scratch)
    }

    #[inline(always)]
    fn forces_at(&self, displaced: &Nodes<f64>, scratch: &mut Scratch) -> Nodes<f64> {
        let forces = &mut scratch[..LEN];
        forces.fill(0.0);
        let (rows, _) = self.stiffness.as_chunks::<8>();
        for (rows, by) in rows.iter().zip(displaced) {
            for (column, force) in forces.iter_mut().enumerate().take(LEN) {
                let part = |row: usize| f64::from(rows[row][column]) * by[row];
                let halves = [(part(0) + part(1)) + (part(2) + part(3)), (part(4) + part(5)) + (part(6) + part(7))];
                *force += halves[0] + halves[1];
            }
        }
        let mut of = [[0.0; 8]; 3];
        for component in 0..3 {
            let own = &forces[8 * component..][..8];
            let middle = own.iter().sum::<f64>() / 8.0;
            for node in 0..8 {
                of[component][node] = own[node] - middle;
            }
        }
        of
    }

    /// Stresses by component, the energy, and the eigenstress times the strain, each times the volume.
    #[inline(always)]
    pub(super) fn sums(&self, nodes: &Nodes<f64>, mean: &[f64; 6], scratch: &mut Scratch) -> [f64; 8] {
        let (displaced, along) = (self.displaced(nodes, mean), self.along());
        let forces = self.forces_at(&displaced, scratch);
        let mut sums = [0.0; 8];
        for component in 0..3 {
            for axis in 0..3 {
                let row = ROW[component][axis];
                let moment: f64 = forces[component].iter().zip(along[axis]).map(|(force, by)| force * by).sum();
                sums[row] += if row < 3 { moment } else { moment / 2.0 };
            }
        }
        let product = |of: &[f64]| of.iter().zip(displaced.as_flattened()).map(|(of, by)| of * by).sum();
        (sums[6], sums[7]) = (product(forces.as_flattened()), product(&self.eigen));
        sums
    }
}

/// Adds the stiffness of a part between the nodes of its block.
struct Interpolated<'a> {
    part: &'a Block,
    weights: &'a [[f64; 8]; 8],
    stiffness: &'a mut [[f64; LEN]; LEN],
}

impl Wide for Interpolated<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let mut half = [[0.0; LEN]; LEN];
        let mut part = [[0.0; LEN]; LEN];
        for (to, from) in part.iter_mut().zip(self.part.stiffness.iter()) {
            for i in 0..LEN {
                to[i] = f64::from(from[i]);
            }
        }
        to_block(self.weights, &part, &mut half);
        for i in 0..LEN {
            for j in 0..LEN {
                part[j][i] = half[i][j];
            }
        }
        to_block(self.weights, &part, self.stiffness);
    }
}

/// Adds the rows of a part's nodes to those of its block's nodes.
#[inline(always)]
fn to_block(weights: &[[f64; 8]; 8], part: &[[f64; LEN]; LEN], block: &mut [[f64; LEN]; LEN]) {
    for (number, from) in part.iter().enumerate() {
        for (of, weight) in weights[number % 8].iter().enumerate() {
            if *weight > 0.0 {
                let to = &mut block[number / 8 * 8 + of];
                for i in 0..LEN {
                    to[i] += weight * from[i];
                }
            }
        }
    }
}
