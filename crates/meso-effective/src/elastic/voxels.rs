//! The material of every voxel, from the exact volumes of the phases in it and the mean normal of its interfaces.
//!
//! Volumes come from plane sections, by Gauss's rule over the body's height in a voxel. The areas of a body on a voxel's six faces
//! give the integral of the normal over the interface inside (divergence theorem).

use super::blocks::Block;
use super::laminate::{Material, VOID};
use crate::grid::Grid;
use crate::moduli::{Moduli, Table};
use crate::sections::{Section, Squares, WITHIN};
use crate::surfaces::Surface;
use meso_collision::math::Vec3;
use meso_concrete::parallel;
use meso_concrete::{Phase, PhaseNames};
use std::collections::HashMap;
use std::ops::Range;

/// Materials of a grid.
pub(crate) struct Voxels {
    /// Phases alone, in their order, then those of cut voxels.
    pub(super) materials: Vec<Material>,
    /// Number of each voxel's material, x fastest.
    pub(super) of: Vec<u32>,
    /// Blocks of voxels in place of voxels, each with a material for the preconditioner; none of voxels.
    pub(super) blocks: Vec<Block>,
}

/// Points of Gauss's rule on 0 to 1, with their weights.
const GAUSS: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];
/// A smaller share of a voxel is rounding.
const NOTHING: f64 = 1e-6;

impl Voxels {
    /// Voxels of one phase each.
    pub(crate) fn of_phases(of: Vec<u32>, phases: &[Moduli]) -> Self {
        let largest = phases.iter().map(|phase| phase.youngs_modulus_mpa).fold(0.0, f64::max);
        Self { materials: regular(phases, largest).iter().map(Material::pure).collect(), of, blocks: Vec::new() }
    }

    pub(super) fn new(grid: &Grid, surfaces: &[Surface], table: &Table) -> Self {
        let table = regular(table, table[0].youngs_modulus_mpa);
        let mut cells = parallel::map(surfaces.len(), |number| cells(grid, &surfaces[number])).concat();
        cells.sort_by_key(|cell| cell.voxel);
        let runs: Vec<&[Cell]> = cells.chunk_by(|a, b| a.voxel == b.voxel).collect();
        let found = parallel::map(runs.len(), |number| of(runs[number], &table));
        let mut voxels = Self {
            materials: table.iter().map(Material::pure).collect(),
            of: vec![Phase::Mortar.number().into(); grid.counts.iter().product()],
            blocks: Vec::new(),
        };
        for (run, found) in runs.iter().zip(found) {
            let number = match found {
                Found::Phase(phase) => phase.number().into(),
                Found::Laminate(material) => {
                    voxels.materials.push(material);
                    voxels.materials.len() as u32 - 1
                }
            };
            voxels.of[run[0].voxel as usize] = number;
        }
        voxels
    }
}

/// No part: beyond the end of an odd count.
const NONE: u32 = u32::MAX;

impl Voxels {
    /// Blocks of two and of four voxels along each axis, with their counts, as far as there are several voxels.
    pub(super) fn coarser(&self, counts: [usize; 3], spacing: [f64; 3]) -> Vec<([usize; 3], Self)> {
        let whole: Vec<Block> = self.materials.iter().map(|material| Block::of(material, spacing)).collect();
        let fine = Self { materials: Vec::new(), of: self.of.clone(), blocks: whole };
        let mut found: Vec<([usize; 3], Self)> = Vec::new();
        for _ in 0..2 {
            let (counts, parts) = found.last().map_or((counts, &fine), |(counts, parts)| (*counts, parts));
            if counts == [1; 3] {
                break;
            }
            found.push(parts.joined(counts));
        }
        found
    }

    /// Blocks of two parts along each axis.
    fn joined(&self, parts: [usize; 3]) -> ([usize; 3], Self) {
        let counts = parts.map(|count| count.div_ceil(2));
        let part = |at: [usize; 3]| {
            let is_there = (0..3).all(|axis| at[axis] < parts[axis]);
            if is_there { self.of[(at[2] * parts[1] + at[1]) * parts[0] + at[0]] } else { NONE }
        };
        let parts_of = |number: usize| -> [u32; 8] {
            let at = [number % counts[0], number / counts[0] % counts[1], number / (counts[0] * counts[1])];
            std::array::from_fn(|side| part([0, 1, 2].map(|axis| 2 * at[axis] + (side >> axis & 1))))
        };
        let mut numbers = HashMap::new();
        let mut kinds = Vec::new();
        let number = |parts: [u32; 8]| {
            *numbers.entry(parts).or_insert_with(|| {
                kinds.push(parts);
                kinds.len() as u32 - 1
            })
        };
        let of = (0..counts.iter().product()).map(parts_of).map(number).collect();
        let part = |number: u32| self.blocks.get(number as usize);
        let blocks = parallel::map(kinds.len(), |kind| Block::joined(kinds[kind].map(part)));
        (counts, Self { materials: blocks.iter().map(|block| block.material).collect(), of, blocks })
    }
}

/// Phases whose modulus is at least a void's in a mortar of `modulus`.
fn regular(phases: &[Moduli], modulus: f64) -> Vec<Moduli> {
    let mut phases = phases.to_vec();
    phases.iter_mut().for_each(|phase| phase.youngs_modulus_mpa = phase.youngs_modulus_mpa.max(VOID * modulus));
    phases
}

enum Found {
    Phase(Phase),
    Laminate(Material),
}

/// The material of a voxel that surfaces reach into.
fn of(run: &[Cell], table: &[Moduli]) -> Found {
    let mut shares = [0.0; PhaseNames::ROOM];
    shares[Phase::Mortar.index()] = 1.0;
    for cell in run {
        shares[cell.outside.index()] -= f64::from(cell.share);
        shares[cell.within.index()] += f64::from(cell.share);
    }
    let all = (0..table.len() as u8).map(Phase::numbered);
    let there: Vec<Phase> = all.filter(|phase| shares[phase.index()] > NOTHING).collect();
    let size = |cell: &Cell| cell.normal.iter().map(|n| n * n).sum::<f32>();
    let Some(largest) = run.iter().max_by(|a, b| size(a).total_cmp(&size(b))) else { return Found::Phase(there[0]) };
    if there.len() == 1 {
        return Found::Phase(there[0]);
    }
    let whole: f64 = there.iter().map(|phase| shares[phase.index()]).sum();
    let phases: Vec<_> = there.iter().map(|&phase| (table[phase.index()], shares[phase.index()] / whole)).collect();
    let normal = Vec3::from(largest.normal.map(f64::from));
    let normal = normal.try_normalize(0.0).unwrap_or_else(Vec3::x);
    Found::Laminate(Material::laminate(&phases, &normal))
}

/// A voxel that a body covers or cuts.
#[derive(Clone)]
struct Cell {
    voxel: u32,
    outside: Phase,
    within: Phase,
    /// Share of the voxel inside the body.
    share: f32,
    /// Integral of the outward normal over the interface, mm2.
    normal: [f32; 3],
}

/// Voxels around a body.
struct VoxelsAround {
    ranges: [Range<usize>; 3],
}

impl VoxelsAround {
    fn new(grid: &Grid, surface: &Surface) -> Self {
        let aabb = surface.body.aabb();
        let range = |axis: usize| {
            let at = |x: f64| ((x - grid.origin[axis]) / grid.spacing[axis]).max(0.0);
            let end = (at(aabb.max[axis]).ceil() as usize).min(grid.counts[axis]);
            (at(aabb.min[axis]) as usize).min(end)..end
        };
        Self { ranges: [0, 1, 2].map(range) }
    }

    fn len(&self) -> usize {
        self.ranges.iter().map(Range::len).product()
    }

    fn index(&self, at: [usize; 3]) -> Option<usize> {
        let inside = (0..3).all(|axis| self.ranges[axis].contains(&at[axis]));
        let [x, y, z] = [0, 1, 2].map(|axis| at[axis].wrapping_sub(self.ranges[axis].start));
        inside.then(|| (z * self.ranges[1].len() + y) * self.ranges[0].len() + x)
    }

    fn at(&self, index: usize) -> [usize; 3] {
        let (nx, ny) = (self.ranges[0].len(), self.ranges[1].len());
        let place = [index % nx, index / nx % ny, index / (nx * ny)];
        [0, 1, 2].map(|axis| self.ranges[axis].start + place[axis])
    }
}

fn cells(grid: &Grid, surface: &Surface) -> Vec<Cell> {
    let around = VoxelsAround::new(grid, surface);
    let mut section = Section::default();
    let mut shares = vec![0.0; around.len()];
    let mut normals = vec![[0.0; 3]; around.len()];
    let aabb = surface.body.aabb();
    let [bottom, top] = [aabb.min, aabb.max].map(|end| (end.z - grid.origin.z) / grid.spacing.z);
    for k in around.ranges[2].clone() {
        // Sections vary steadily between the body's ends, and jump there if a face is level.
        let (from, to) = (bottom.max(k as f64), top.min(k as f64 + 1.0));
        for (height, weight) in GAUSS {
            let weight = weight * (to - from);
            each_share(grid, &mut section, surface, 2, from + height * (to - from), |i, j, share| {
                around.index([i, j, k]).into_iter().for_each(|index| shares[index] += weight * share);
            });
        }
    }
    for axis in 0..3 {
        for (place, side) in around.ranges[axis].clone().flat_map(|place| [(place, 0.0), (place, 1.0)]) {
            let (plane, sign) = (place as f64 + WITHIN + side * (1.0 - 2.0 * WITHIN), 1.0 - 2.0 * side);
            each_share(grid, &mut section, surface, axis, plane, |b, c, share| {
                let mut at = [0; 3];
                (at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3]) = (place, b, c);
                let area = sign * share * grid.area(axis);
                around.index(at).into_iter().for_each(|index| normals[index][axis] += area);
            });
        }
    }
    let cell = |(index, share): (usize, &f64)| {
        let [i, j, k] = around.at(index);
        let voxel = ((k * grid.counts[1] + j) * grid.counts[0] + i) as u32;
        let Surface { outside, within, .. } = *surface;
        (*share > 0.0).then(|| Cell {
            voxel,
            outside,
            within,
            share: *share as f32,
            normal: normals[index].map(|n| n as f32),
        })
    };
    shares.iter().enumerate().filter_map(cell).collect()
}

/// Calls `visit` with the place along the next two axes, and the share, of every square that the plane's section meets.
fn each_share(
    grid: &Grid,
    section: &mut Section,
    surface: &Surface,
    axis: usize,
    plane: f64,
    mut visit: impl FnMut(usize, usize, f64),
) {
    let squares = Squares::across(grid, axis);
    let at = grid.origin[axis] + plane * grid.spacing[axis];
    let columns = squares.counts[0];
    section.shares(&surface.body, axis, at, &squares, |square, share| visit(square % columns, square / columns, share));
}
