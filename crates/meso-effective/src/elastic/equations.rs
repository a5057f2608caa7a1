//! Forces of trilinear voxels, and their preconditioner.
//!
//! Displacements are the periodic part, three blocks of nodes, x fastest. The first node along an axis is the last one, too;
//! at walls, both have no displacement, so the strain there is uniform.
//!
//! The preconditioner takes each component alone: a network of links with the stiffness of the component along each axis.

use super::blocks::Block;
use super::laminate::Material;
use super::modes::{Modes, Nodes, ROW, spread, strain_of, stress_of};
use super::voxels::Voxels;
use crate::grid::{End, Grid};
use crate::links::Links;
use crate::solver::{Equations, Multigrid, dot};
use meso_concrete::parallel;

/// Layers of voxels whose forces are added up by one thread.
const SLAB: usize = 4;
/// Links between nodes without displacement, over the largest stiffness: they move together.
const RIGID: f32 = 100.0;

/// Equations of a grid.
pub(super) struct Elastic<'a> {
    pub(super) grid: &'a Grid,
    pub(super) voxels: &'a Voxels,
    networks: [(Links, Multigrid<Links>); 3],
    /// Nodes without displacement.
    clamped: Vec<u32>,
    /// Residual of a component.
    own: Vec<f32>,
    correction: Vec<f32>,
}

impl<'a> Elastic<'a> {
    pub(super) fn new(grid: &'a Grid, voxels: &'a Voxels) -> Self {
        let [nx, ny, nz] = grid.counts;
        let walls = grid.ends.map(|end| end != End::Periodic);
        let is_clamped = |node: usize| {
            let at = [node % nx, node / nx % ny, node / (nx * ny)];
            (0..3).any(|axis| walls[axis] && at[axis] == 0)
        };
        let clamped = parallel::filter(nx * ny * nz, is_clamped);
        let networks = [0, 1, 2].map(|component| {
            let links = links(grid, voxels, component, &is_clamped);
            let multigrid = Multigrid::new(&links);
            (links, multigrid)
        });
        let own = vec![0.0; nx * ny * nz];
        Self { grid, voxels, networks, clamped, own, correction: vec![0.0; 3 * nx * ny * nz] }
    }

    fn nodes(&self) -> usize {
        self.grid.counts.iter().product()
    }

    /// Forces of the stress that displacements `u` and the strain `mean` cause.
    pub(super) fn nodal_forces(&self, u: &[f64], mean: &[f64; 6], out: &mut [f64]) {
        let [nx, ny, nz] = self.grid.counts;
        let (layer, nodes) = (nx * ny, self.nodes());
        let slabs = parallel::map(nz.div_ceil(SLAB), |slab| self.slab(slab, u, mean));
        parallel::chunks_mut(out, layer, |number, out| {
            let (component, k) = (number / nz, number % nz);
            let (slab, above) = (k / SLAB, if k == 0 { nz } else { k });
            let part = |slab: usize, k: usize| {
                let layers = slabs[slab].len() / (3 * layer);
                &slabs[slab][(component * layers + k - slab * SLAB) * layer..][..layer]
            };
            out.copy_from_slice(part(slab, k));
            if k % SLAB == 0 {
                let below = part((above - 1) / SLAB, above);
                out.iter_mut().zip(below).for_each(|(out, force)| *out += force);
            }
        });
        for node in &self.clamped {
            (0..3).for_each(|component| out[component * nodes + *node as usize] = 0.0);
        }
    }

    /// Forces of a slab on its layers of nodes, component by component.
    fn slab(&self, slab: usize, u: &[f64], mean: &[f64; 6]) -> Vec<f64> {
        let [nx, ny, nz] = self.grid.counts;
        let (layer, first) = (nx * ny, slab * SLAB);
        let last = nz.min(first + SLAB);
        let layers = last - first + 1;
        let mut forces = vec![0.0; 3 * layers * layer];
        for k in first..last {
            for (j, i) in (0..ny).flat_map(|j| (0..nx).map(move |i| (j, i))) {
                let nodes = self.forces_of([i, j, k], u, mean);
                for (node, place) in corners([nx, ny], i, j).into_iter().enumerate() {
                    let start = (k - first + (node >> 2)) * layer + place;
                    (0..3).for_each(|component| forces[component * layers * layer + start] += nodes[component][node]);
                }
            }
        }
        forces
    }

    /// Forces of a voxel or block on its nodes.
    fn forces_of(&self, at: [usize; 3], u: &[f64], mean: &[f64; 6]) -> Nodes {
        match self.block(at) {
            Some(block) => block.forces(&self.nodes_of(at, u), mean),
            None => spread(&self.stress(at, u, mean), self.grid.spacing.into()),
        }
    }

    /// The block at a place of a grid of blocks.
    pub(super) fn block(&self, at: [usize; 3]) -> Option<&Block> {
        self.voxels.blocks.get(self.number(at))
    }

    /// Stress of a voxel by modes.
    pub(super) fn stress(&self, at: [usize; 3], u: &[f64], mean: &[f64; 6]) -> Modes {
        stress_of(self.material(at), &self.strain(at, u, mean))
    }

    pub(super) fn material(&self, at: [usize; 3]) -> &Material {
        &self.voxels.materials[self.number(at)]
    }

    /// Number of the material or block at a place.
    fn number(&self, [i, j, k]: [usize; 3]) -> usize {
        let [nx, ny, _] = self.grid.counts;
        self.voxels.of[(k * ny + j) * nx + i] as usize
    }

    /// Strain of a voxel by modes.
    pub(super) fn strain(&self, at: [usize; 3], u: &[f64], mean: &[f64; 6]) -> Modes {
        let mut strain = strain_of(&self.nodes_of(at, u), self.grid.spacing.into());
        strain.iter_mut().zip(mean).for_each(|(row, mean)| row[0] += mean);
        strain
    }

    /// Displacements at the nodes of a voxel or block.
    pub(super) fn nodes_of(&self, [i, j, k]: [usize; 3], u: &[f64]) -> Nodes {
        let [nx, ny, nz] = self.grid.counts;
        let above = if k + 1 == nz { 0 } else { k + 1 };
        let corners = corners([nx, ny], i, j);
        [0, 1, 2].map(|component| {
            let block = &u[component * self.nodes()..][..self.nodes()];
            let mut values = [0.0; 8];
            for (node, place) in corners.into_iter().enumerate() {
                values[node] = block[if node < 4 { k } else { above } * nx * ny + place];
            }
            values
        })
    }
}

impl Equations for Elastic<'_> {
    type Number = f64;

    fn layer_len(&self) -> usize {
        self.grid.counts[0] * self.grid.counts[1]
    }

    fn apply(&self, u: &[f64], out: &mut [f64]) -> f64 {
        self.nodal_forces(u, &[0.0; 6], out);
        dot(u, out, self.layer_len())
    }

    /// Clamped nodes move together in the networks: they receive the reaction, and the rest moves relative to them.
    fn correction(&mut self, r: &[f64]) -> &[f32] {
        let nodes = self.nodes();
        let count = self.clamped.len() as f64;
        for (component, (links, multigrid)) in self.networks.iter_mut().enumerate() {
            let own = &r[component * nodes..][..nodes];
            let to = &mut self.correction[component * nodes..][..nodes];
            self.own.iter_mut().zip(own).for_each(|(to, from)| *to = *from as f32);
            let reaction = -own.iter().sum::<f64>() / count;
            self.clamped.iter().for_each(|node| self.own[*node as usize] = reaction as f32);
            to.copy_from_slice(multigrid.cycle(links, &self.own));
            if self.clamped.is_empty() {
                continue;
            }
            let rigid = self.clamped.iter().map(|node| f64::from(to[*node as usize])).sum::<f64>() / count;
            to.iter_mut().for_each(|to| *to -= rigid as f32);
            self.clamped.iter().for_each(|node| to[*node as usize] = 0.0);
        }
        &self.correction
    }
}

/// Places in their layer of a voxel's nodes.
fn corners([nx, ny]: [usize; 2], i: usize, j: usize) -> [usize; 8] {
    let next = |i: usize, n: usize| if i + 1 == n { 0 } else { i + 1 };
    let (right, back) = (next(i, nx), next(j, ny) * nx);
    let below = [j * nx + i, j * nx + right, back + i, back + right];
    [below[0], below[1], below[2], below[3], below[0], below[1], below[2], below[3]]
}

/// Links between nodes with the stiffness of `component` along each axis.
fn links(grid: &Grid, voxels: &Voxels, component: usize, is_clamped: &(impl Fn(usize) -> bool + Sync)) -> Links {
    let [nx, ny, nz] = grid.counts;
    let diagonal = |row: usize| row * 6 - row * row.saturating_sub(1) / 2;
    let across = [0, 1, 2].map(|axis| {
        let over = (grid.area(axis) / (4.0 * grid.spacing[axis])) as f32;
        let entry = diagonal(ROW[component][axis]);
        let stiffness = |number: usize| voxels.materials[voxels.of[number] as usize].stiffness[entry];
        let largest = voxels.materials.iter().map(|material| material.stiffness[entry]).fold(0.0, f32::max);
        let before = |at: usize, n: usize| if at == 0 { n - 1 } else { at - 1 };
        let link = |number: usize| {
            let number = number % (nx * ny * nz);
            let at = [number % nx, number / nx % ny, number / (nx * ny)];
            let below = [0, 1, 2].map(|axis| before(at[axis], grid.counts[axis]));
            let index = |[i, j, k]: [usize; 3]| (k * ny + j) * nx + i;
            let mut start = at;
            start[axis] = below[axis];
            if is_clamped(number) && is_clamped(index(start)) {
                return RIGID * 4.0 * over * largest;
            }
            let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
            let around = [(at[b], at[c]), (below[b], at[c]), (at[b], below[c]), (below[b], below[c])];
            let sum: f32 = around
                .into_iter()
                .map(|(at_b, at_c)| {
                    let mut voxel = start;
                    (voxel[b], voxel[c]) = (at_b, at_c);
                    stiffness(index(voxel))
                })
                .sum();
            sum * over
        };
        parallel::map_short(nx * ny * (nz + usize::from(axis == 2)), link)
    });
    Links::of(grid.counts, true, across)
}
