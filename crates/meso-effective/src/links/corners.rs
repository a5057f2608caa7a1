//! Coupling of the links at voxels that an oblique plane interface cuts.
//!
//! A voxel has eight corners, and three links lead towards each. Let `d` be the gradients along these links, `n` the normal
//! of the interface, `A` the mean values over the links' faces and `R` the mean resistances along them, both diagonal. The
//! energy of a corner is an eighth of `d K d`, with
//!
//! ```text
//! K = A - n n (1 / n A^-1 n - 1 / n R n)
//! ```
//!
//! A gradient along the interface drives the exact flux, and one across it has the exact energy. Layers along the grid are
//! exact. The diagonal of `K` goes into the links; the rest couples pairs of them.
//!
//! `A` conducts along the interface, so a wrong normal lets flux leak through edges, necks between grains, and rounded
//! surfaces. Voxels near those keep the conductances of links.

use super::Layer;
use crate::grid::{End, Grid};
use meso_collision::geometry::Plane;
use meso_collision::math::Vec3;
use meso_concrete::parallel;

/// Conductance of a link, mean value over its face, and mean resistance along it: 0 where the link couples with none.
pub(super) type Link = [f32; 3];

/// Pairs of links that are coupled at voxels.
pub(crate) struct Corners {
    /// Where the voxels of each layer begin, and where the last ones end.
    pub(crate) starts: Vec<usize>,
    /// Numbers of the voxels.
    pub(crate) voxels: Vec<u32>,
    /// Coefficients of x with y, x with z and y with z, in each the links below and above along the first axis, and within
    /// these along the second.
    pub(crate) pairs: Vec<[f32; 12]>,
}

/// A voxel with coupled links.
struct Voxel {
    number: usize,
    pairs: [f32; 12],
    /// Changes of the links below and above along each axis.
    changes: [f32; 6],
}

/// The links of a grid, and their coupling; none where no voxel has any.
pub(super) fn couple(grid: &Grid, layers: &[Layer], mut links: [Vec<Link>; 3]) -> ([Vec<f32>; 3], Option<Corners>) {
    let (top, layer_len) = (grid.counts.iter().product::<usize>(), grid.counts[0] * grid.counts[1]);
    if grid.ends[2] == End::Fixed {
        // Links between a wall and a centre are half as long.
        let (first, last) = links[2].split_at_mut(top);
        first[..layer_len].iter_mut().chain(last).for_each(|link| link[2] = 0.0);
    }
    let found = parallel::map(grid.counts[2], |k| voxels(grid, layers, &links, k));
    let mut across = links.map(|links| links.iter().map(|link| link[0]).collect::<Vec<f32>>());
    let mut corners = Corners { starts: vec![0], voxels: Vec::new(), pairs: Vec::new() };
    for layer in found {
        for Voxel { number, pairs, changes } in layer {
            changes.iter().enumerate().for_each(|(side, change)| across[side / 2][link(grid, number, side)] += change);
            corners.voxels.push(number as u32);
            corners.pairs.push(pairs);
        }
        corners.starts.push(corners.voxels.len());
    }
    if grid.ends[2] == End::Periodic {
        across[2].copy_within(..layer_len, top);
    }
    let is_coupled = !corners.voxels.is_empty();
    (across, is_coupled.then_some(corners))
}

/// Place of a voxel's link: sides 0 and 1 are below and above along x, then those along y and z.
fn link(grid: &Grid, number: usize, side: usize) -> usize {
    let axis = side / 2;
    let (step, count) = ([1, grid.counts[0], grid.counts[0] * grid.counts[1]][axis], grid.counts[axis]);
    match side % 2 {
        0 => number,
        _ if number / step % count + 1 < count || grid.ends[axis] == End::Fixed => number + step,
        _ => number + step - step * count,
    }
}

/// The coupled voxels of layer `k`, in their order.
fn voxels(grid: &Grid, layers: &[Layer], links: &[Vec<Link>; 3], k: usize) -> Vec<Voxel> {
    let len = grid.counts[0] * grid.counts[1];
    let is_cut = |number: &usize| {
        (0..6).any(|side| {
            let [_, value, resistance] = links[side / 2][link(grid, *number, side)];
            resistance > 0.0 && f64::from(value * resistance - 1.0).abs() > ROUNDING
        })
    };
    let numbers: Vec<usize> = (k * len..(k + 1) * len).filter(is_cut).collect();
    let normals = normals(grid, layers, &numbers, k);
    let each = numbers.into_iter().zip(normals);
    each.filter_map(|(number, normal)| Some(Voxel::new(grid, links, number, &normal?))).collect()
}

/// Corners with a larger contrast couple nothing: numbers of 32 bits would leave no energy across the interface.
const STEEPEST: f64 = 1e5;
/// Links whose value and resistance give 1 within this are not cut.
const ROUNDING: f64 = 1e-5;

impl Voxel {
    fn new(grid: &Grid, links: &[Vec<Link>; 3], number: usize, normal: &Vec3) -> Self {
        let scale = |a: usize, b: usize| grid.spacing.product() / (8.0 * grid.spacing[a] * grid.spacing[b]);
        let (mut pairs, mut changes) = ([0.0; 12], [0.0; 6]);
        for corner in 0..8 {
            let side = [corner & 1, corner >> 1 & 1, corner >> 2 & 1];
            let link = [0, 1, 2].map(|axis| links[axis][link(grid, number, 2 * axis + side[axis])].map(f64::from));
            let [value, resistance] = [1, 2].map(|which| link.map(|link| link[which]));
            let most = |of: [f64; 3]| of.into_iter().fold(0.0, f64::max);
            let contrast = most(value) * most(resistance);
            if resistance.contains(&0.0) || contrast > STEEPEST {
                continue;
            }
            let tensor = tensor(value, resistance, normal);
            // A link has four corners at both of its ends.
            (0..3).for_each(|a| changes[2 * a + side[a]] += tensor[a][a] * scale(a, a) - link[a][0] / 8.0);
            for (pair, [a, b]) in [[0, 1], [0, 2], [1, 2]].into_iter().enumerate() {
                pairs[4 * pair + 2 * side[a] + side[b]] += tensor[a][b] * scale(a, b);
            }
        }
        Self { number, pairs: pairs.map(|pair| pair as f32), changes: changes.map(|change| change as f32) }
    }
}

/// The tensor of a corner from mean values and resistances of its links.
fn tensor(value: [f64; 3], resistance: [f64; 3], n: &Vec3) -> [[f64; 3]; 3] {
    let across: f64 = (0..3).map(|i| n[i] * n[i] * resistance[i]).sum();
    let along: f64 = (0..3).map(|i| n[i] * n[i] / value[i]).sum();
    let less = 1.0 / along - 1.0 / across;
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| f64::from(u8::from(i == j)) * value[i] - less * n[i] * n[j]))
}

/// Interfaces count as near within this many voxels.
const REACH: f64 = 1.5;
/// Normals differ if their cosine is below 1 less this, or less the inverse of a contrast that is larger than ten.
const BENT: f64 = 0.1;

/// The interface near a voxel's centre.
#[derive(Clone, Copy)]
struct Near {
    distance: f64,
    normal: Vec3,
    is_plane: bool,
}

/// The normal at each of the voxels `numbers` in layer `k`; none unless the interfaces near it are parallel planes.
fn normals(grid: &Grid, layers: &[Layer], numbers: &[usize], k: usize) -> Vec<Option<Vec3>> {
    let mut near = vec![Near { distance: f64::INFINITY, normal: Vec3::zeros(), is_plane: true }; numbers.len()];
    if !numbers.is_empty() {
        let interfaces = Interfaces::new(grid, layers, k);
        interfaces.visit(numbers, |interface, at, number| near[number].approach(interface, at));
        interfaces.visit(numbers, |interface, at, number| near[number].compare(interface, at, interfaces.reach));
    }
    near.into_iter().map(|near| (near.is_plane && near.distance.is_finite()).then_some(near.normal)).collect()
}

/// An interface with its planes, but those at the ends of the grid, where bodies go on in the next period.
struct PlaneInterface<'a> {
    layer: &'a Layer,
    planes: Vec<Plane>,
}

/// Interfaces near a layer of voxels.
struct Interfaces<'a> {
    grid: &'a Grid,
    k: usize,
    reach: f64,
    all: Vec<PlaneInterface<'a>>,
}

impl<'a> Interfaces<'a> {
    fn new(grid: &'a Grid, layers: &'a [Layer], k: usize) -> Self {
        let reach = REACH * grid.spacing.max();
        let z = grid.origin.z + (k as f64 + 0.5) * grid.spacing.z;
        let is_near =
            |layer: &&Layer| layer.contrast != 1.0 && z > layer.aabb.min.z - reach && z < layer.aabb.max.z + reach;
        let new = |layer: &'a Layer| {
            let planes = layer.planes.iter().filter(|plane| !is_at_end(plane, grid)).copied().collect();
            PlaneInterface { layer, planes }
        };
        Self { grid, k, reach, all: layers.iter().filter(is_near).map(new).collect() }
    }

    /// Calls `of` with every interface, each voxel's centre near it, and the voxel's place among `numbers`.
    fn visit(&self, numbers: &[usize], mut of: impl FnMut(&PlaneInterface, &Vec3, usize)) {
        let [nx, ny, _] = self.grid.counts;
        let Grid { origin, spacing, .. } = self.grid;
        let range = |layer: &Layer, axis: usize| {
            let at = |x: f64| ((x - origin[axis]) / spacing[axis] - 0.5).max(0.0);
            let end = at(layer.aabb.max[axis] + self.reach) as usize + 1;
            at(layer.aabb.min[axis] - self.reach).ceil() as usize..end.min(self.grid.counts[axis])
        };
        for interface in &self.all {
            let columns = range(interface.layer, 0);
            for j in range(interface.layer, 1) {
                let row = (self.k * ny + j) * nx;
                let first = numbers.partition_point(|number| *number < row + columns.start);
                let reached = numbers[first..].iter().take_while(|number| **number < row + columns.end);
                for (place, number) in reached.enumerate() {
                    let voxel = Vec3::new((number - row) as f64 + 0.5, j as f64 + 0.5, self.k as f64 + 0.5);
                    of(interface, &(origin + voxel.component_mul(spacing)), first + place);
                }
            }
        }
    }
}

/// Whether a face lies in an end of the grid.
fn is_at_end(plane: &Plane, grid: &Grid) -> bool {
    let Some(axis) = (0..3).find(|axis| plane.normal[*axis].abs() == 1.0) else { return false };
    let height = plane.height(&grid.origin);
    let other = height + plane.normal[axis] * grid.spacing[axis] * grid.counts[axis] as f64;
    height.abs().min(other.abs()) < ROUNDING * grid.spacing[axis]
}

impl Near {
    fn approach(&mut self, interface: &PlaneInterface, at: &Vec3) {
        let heights = interface.planes.iter().map(|plane| (plane.height(at), plane.normal));
        if let Some((height, normal)) = heights.max_by(|one, other| one.0.total_cmp(&other.0))
            && height.abs() < self.distance
        {
            (self.distance, self.normal) = (height.abs(), normal);
        }
    }

    fn compare(&mut self, interface: &PlaneInterface, at: &Vec3, reach: f64) {
        let Layer { dents, contrast, .. } = interface.layer;
        if dents.is_none() && Plane::height_over(&interface.planes, at) > reach {
            return;
        }
        let parallel = 1.0 - BENT.min(1.0 / contrast);
        let is_bent = |plane: &Plane| plane.height(at).abs() < reach && plane.normal.dot(&self.normal).abs() < parallel;
        self.is_plane &= dents.is_none() && contrast.is_finite() && !interface.planes.iter().any(is_bent);
    }
}
