//! Forces of trilinear voxels, and their preconditioner.
//!
//! Displacements are the periodic part, three blocks of nodes, x fastest. The first node along an axis is the last one, too;
//! at walls, both have no displacement, so the strain there is uniform.
//!
//! The preconditioner takes each component alone: a network of links with the stiffness of the component along each axis.

use super::laminate::packed;
use super::modes::{Cubic, ROW, cubic};
use super::rows::{BlockSlab, Forces, Slab, State};
use super::voxels::Voxels;
use crate::grid::{End, Grid};
use crate::links::Links;
use crate::solver::{Equations, Multigrid, dot};
use meso_collision::simd::widest;
use meso_concrete::parallel;

/// Layers of voxels whose forces are added up by one thread.
const SLAB: usize = 4;
/// Links between nodes without displacement, over the largest stiffness: they move together.
const RIGID: f32 = 100.0;

/// Equations of a grid.
pub(super) struct Elastic<'a> {
    pub(super) grid: &'a Grid,
    pub(super) voxels: &'a Voxels,
    /// Constants of the first materials, as far as they are the same along all axes: the phases.
    cubic: Vec<Cubic<f64>>,
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
        let cubic = voxels.materials.iter().map_while(|material| cubic(&material.stiffness)).collect();
        Self { grid, voxels, cubic, networks, clamped, own, correction: vec![0.0; 3 * nx * ny * nz] }
    }

    fn nodes(&self) -> usize {
        self.grid.counts.iter().product()
    }

    /// Forces of the stress that displacements `u` and the strain `mean` cause.
    pub(super) fn nodal_forces(&self, u: &[f64], mean: &[f64; 6], out: &mut [f64]) {
        let [nx, ny, nz] = self.grid.counts;
        let (layer, nodes) = (nx * ny, self.nodes());
        let (x, rest) = out.split_at_mut(nodes);
        let (y, z) = rest.split_at_mut(nodes);
        let parts = [x, y, z].map(|of| of.chunks_mut(SLAB * layer));
        let [x, y, z] = parts;
        let slab = |((x, y), z)| Forces { own: [x, y, z], above: [0, 1, 2].map(|_| vec![0.0; layer]) };
        let mut slabs: Vec<Forces> = x.zip(y).zip(z).map(slab).collect();
        let state = self.state(u, mean);
        parallel::each_mut(&mut slabs, |slab, forces| {
            let layers = slab * SLAB..nz.min((slab + 1) * SLAB);
            if self.voxels.blocks.is_empty() {
                widest(Slab { state, layers, forces });
            } else {
                widest(BlockSlab { state, layers, forces });
            }
        });
        let above: Vec<_> = slabs.into_iter().map(|slab| slab.above).collect();
        parallel::chunks_mut(out, layer, |number, out| {
            let (component, k) = (number / nz, number % nz);
            if k % SLAB == 0 {
                let below = if k == 0 { above.len() - 1 } else { k / SLAB - 1 };
                out.iter_mut().zip(&above[below][component]).for_each(|(out, force)| *out += force);
            }
        });
        for node in &self.clamped {
            (0..3).for_each(|component| out[component * nodes + *node as usize] = 0.0);
        }
    }

    /// Displacements and a mean strain on the grid.
    pub(super) fn state<'b>(&'b self, u: &'b [f64], mean: &'b [f64; 6]) -> State<'b> {
        State { grid: self.grid, voxels: self.voxels, cubic: &self.cubic, u, mean }
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
            if !self.clamped.is_empty() {
                let reaction = -own.iter().sum::<f64>() / count;
                self.clamped.iter().for_each(|node| self.own[*node as usize] = reaction as f32);
            }
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

/// Links between nodes with the stiffness of `component` along each axis.
fn links(grid: &Grid, voxels: &Voxels, component: usize, is_clamped: &(impl Fn(usize) -> bool + Sync)) -> Links {
    let [nx, ny, nz] = grid.counts;
    let across = [0, 1, 2].map(|axis| {
        let over = (grid.area(axis) / (4.0 * grid.spacing[axis])) as f32;
        let entry = packed(ROW[component][axis], ROW[component][axis]);
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
