//! Blocks of voxels with displacements that are trilinear over the whole block: coarse spaces of a label volume.
//!
//! A block has the exact stiffness of the voxels in it. Displacements that are trilinear over blocks are so over voxels, too, so each
//! space contains the coarser one, and all energies bound the exact one from above.
//!
//! A block of 2 x 2 x 2 parts has the stiffness `sum of Q^T K Q`, where `Q` interpolates the nodes of a part from those of the block.
//! At the end of an odd count, a block has one part along that axis. Blocks of the same parts are one.

use super::laminate::Material;
use super::modes::{Nodes, spread, strain_of, stress_of};

/// Displacements of a block's nodes: eight along x, then those along y and z.
const LEN: usize = 24;

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
            let mut nodes: Nodes = [[0.0; 8]; 3];
            nodes[column / 8][column % 8] = 1.0;
            let strain = strain_of(&nodes, size);
            eigen[column] = (0..6).map(|row| f64::from(material.eigenstress[row]) * strain[row][0] * volume).sum();
            let forces = spread(&stress_of(material, &strain), size);
            (0..LEN).for_each(|row| stiffness[row][column] = forces[row / 8][row % 8] as f32);
        }
        Self { size, stiffness, eigen, material: *material }
    }

    /// Eight parts, of which the first is there; a part's number has one bit for each axis.
    pub(super) fn joined(parts: [Option<&Self>; 8]) -> Self {
        let first = parts[0].map_or([0.0; 3], |first| first.size);
        let size = [0, 1, 2].map(|axis| first[axis] + parts[1 << axis].map_or(0.0, |part| part.size[axis]));
        let (mut stiffness, mut eigen) = (vec![[0.0; LEN]; LEN], [0.0; LEN]);
        let (mut mean, volume) = ([0.0; 21], size.iter().product::<f64>());
        for (side, part) in parts.iter().enumerate().filter_map(|(side, part)| Some((side, (*part)?))) {
            // Nodes of the block, with their weights, at each node of the part.
            let weights: [Vec<(usize, f64)>; 8] = std::array::from_fn(|node| {
                let weight = |axis: usize, of: usize| {
                    let start = if side >> axis & 1 == 1 { first[axis] } else { 0.0 };
                    let at = (start + (node >> axis & 1) as f64 * part.size[axis]) / size[axis];
                    if of >> axis & 1 == 1 { at } else { 1.0 - at }
                };
                let all = (0..8).map(|of| (of, weight(0, of) * weight(1, of) * weight(2, of)));
                all.filter(|(_, weight)| *weight > 0.0).collect()
            });
            let mut half = [[0.0; LEN]; LEN];
            for (column, node) in (0..LEN).map(|column| (column / 8 * 8, column % 8)) {
                for (of, weight) in &weights[node] {
                    (0..LEN).for_each(|row| {
                        half[column + of][row] += weight * f64::from(part.stiffness[column + node][row]);
                    });
                }
            }
            for (row, node) in (0..LEN).map(|row| (row / 8 * 8, row % 8)) {
                for (of, weight) in &weights[node] {
                    (0..LEN).for_each(|column| stiffness[row + of][column] += weight * half[column][row + node]);
                    eigen[row + of] += weight * part.eigen[row + node];
                }
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

    /// Displacements of the nodes for a `mean` strain and a deviation from it, less their mean: the forces of a translation are rounding.
    fn displaced(&self, nodes: &Nodes, mean: &[f64; 6]) -> [f64; LEN] {
        let strain = [
            [mean[0], mean[5] / 2.0, mean[4] / 2.0],
            [mean[5] / 2.0, mean[1], mean[3] / 2.0],
            [mean[4] / 2.0, mean[3] / 2.0, mean[2]],
        ];
        std::array::from_fn(|number| {
            let (component, node) = (number / 8, number % 8);
            let along = |axis: usize| ((node >> axis & 1) as f64 - 0.5) * self.size[axis];
            let given: f64 = (0..3).map(|axis| strain[component][axis] * along(axis)).sum();
            given + nodes[component][node] - nodes[component].iter().sum::<f64>() / 8.0
        })
    }

    /// Forces on the nodes.
    pub(super) fn forces(&self, nodes: &Nodes, mean: &[f64; 6]) -> Nodes {
        self.forces_at(&self.displaced(nodes, mean))
    }

    fn forces_at(&self, displaced: &[f64; LEN]) -> Nodes {
        let mut forces = [0.0; LEN];
        for (row, by) in self.stiffness.iter().zip(displaced) {
            (0..LEN).for_each(|column| forces[column] += f64::from(row[column]) * by);
        }
        [0, 1, 2].map(|component| {
            let own: [f64; 8] = std::array::from_fn(|node| forces[8 * component + node]);
            let mean = own.iter().sum::<f64>() / 8.0;
            own.map(|force| force - mean)
        })
    }

    /// Stresses by component, the energy, and the eigenstress times the strain, each times the volume.
    pub(super) fn sums(&self, nodes: &Nodes, mean: &[f64; 6]) -> [f64; 8] {
        let displaced = self.displaced(nodes, mean);
        let forces = self.forces_at(&displaced);
        let product = |of: &[f64; LEN]| (0..LEN).map(|number| forces[number / 8][number % 8] * of[number]).sum::<f64>();
        let unit =
            |row: usize| self.displaced(&[[0.0; 8]; 3], &std::array::from_fn(|of| f64::from(u8::from(of == row))));
        let eigen = self.eigen.iter().zip(&displaced).map(|(force, by)| force * by).sum();
        std::array::from_fn(|which| match which {
            6 => product(&displaced),
            7 => eigen,
            row => product(&unit(row)),
        })
    }
}
