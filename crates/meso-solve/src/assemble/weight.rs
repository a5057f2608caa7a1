//! Mass of the nodes: the elements' own, and the mass that scaling adds.

use crate::assemble::mass::{Need, box_metric, tet_metric};
use crate::assemble::parts::BlockParts;
use crate::assemble::patches::{Patch, Patches};
use crate::assemble::tet::corners;
use crate::error::SolveError;
use meso_collision::math::{Mat3, Vec3};
use meso_element::face::DAMPED;
use meso_mesh::{CellKind, Mesh, Phase};
use meso_trial::nodes::area;
use rayon::prelude::*;

/// Patches whose needs are known at once.
const WINDOW: usize = 1 << 13;

/// Mass of the mesh's nodes.
pub(crate) struct Weight {
    /// Lumped, by the mesh's numbers, tonne.
    pub(crate) mass: Vec<f64>,
    /// Mass that solid elements do not need for the step, tonne; empty where no cohesive face asks for it.
    spare: Vec<f64>,
    /// Total without and with mass scaling, tonne.
    pub(crate) total: [f64; 2],
    /// Longest step that needs no mass, s.
    pub(crate) stable_s: f64,
}

impl Weight {
    /// Sums the mass of all elements.
    ///
    /// # Errors
    /// Cells of no positive volume.
    pub(crate) fn of(parts: &BlockParts, patches: Option<&Patches>) -> Result<Self, SolveError> {
        let mesh = parts.sample.mesh;
        let (count, joints) = (mesh.points.len(), mesh.cohesive.len());
        let spare = vec![0.0; if joints > 0 { count } else { 0 }];
        let mut weight = Self { mass: vec![0.0; count], spare, total: [0.0; 2], stable_s: f64::INFINITY };
        match patches {
            Some(patches) => weight.add_patches(parts, patches)?,
            None => weight.add_cells(parts)?,
        }
        weight.add_faces(parts);
        Ok(weight)
    }

    fn add_cells(&mut self, parts: &BlockParts) -> Result<(), SolveError> {
        let mesh = parts.sample.mesh;
        let share = 1.0 / mesh.kind.corners() as f64;
        for (number, (cell, &phase)) in (0..).zip(mesh.cells().zip(&mesh.phase)) {
            let need = need(parts, number, phase)?;
            self.add(&need, cell.iter().map(|&node| (node, share)));
        }
        Ok(())
    }

    /// Adds an element with the share of each of its nodes.
    fn add(&mut self, need: &Need, nodes: impl Iterator<Item = (u32, f64)>) {
        self.total[0] += need.mass;
        self.total[1] += need.mass + need.added();
        self.stable_s = self.stable_s.min(need.stable_s);
        for (node, share) in nodes {
            self.mass[node as usize] += share * (need.mass + need.added());
            if let Some(spare) = self.spare.get_mut(node as usize) {
                *spare += share * (need.mass - need.needed).max(0.0);
            }
        }
    }

    fn add_patches(&mut self, parts: &BlockParts, patches: &Patches) -> Result<(), SolveError> {
        let mesh = parts.sample.mesh;
        let cells = (0..mesh.cell_count() as u32).into_par_iter();
        cells.find_map_first(|cell| tetrahedron(mesh, cell).err()).map_or(Ok(()), Err)?;
        let need = |number: u32| {
            let patch = patches.patch(mesh, number);
            let matter = &parts.common.matter[patches.phase[number as usize].index()];
            (Need::of_patch(matter, &patch, parts.dt), patch)
        };
        let count = patches.len() as u32;
        for start in (0..count).step_by(WINDOW) {
            let numbers = start..count.min(start + WINDOW as u32);
            let needs: Vec<(Need, Patch)> = numbers.into_par_iter().map(need).collect();
            for (need, patch) in &needs {
                self.add(need, patch.nodes().iter().copied().zip(patch.shares().iter().copied()));
            }
        }
        Ok(())
    }

    /// Adds the mass that cohesive faces need beyond the spare mass of their nodes.
    fn add_faces(&mut self, parts: &BlockParts) {
        let (mesh, Some(cohesion)) = (parts.sample.mesh, &parts.common.cohesion) else { return };
        if self.spare.is_empty() {
            return;
        }
        let mut needed = vec![0.0; mesh.points.len()];
        let safe = parts.dt / crate::assemble::mass::SAFETY;
        for face in mesh.cohesive() {
            let (_, area) = facing(mesh, face);
            let share = DAMPED * cohesion.stiffness * area * safe * safe / 2.0;
            face.iter().for_each(|&node| needed[node as usize] += share);
        }
        for (node, needed) in needed.iter().enumerate() {
            let added = (needed - self.spare[node]).max(0.0);
            self.mass[node] += added;
            self.total[1] += added;
        }
    }
}

fn need(parts: &BlockParts, cell: u32, phase: Phase) -> Result<Need, SolveError> {
    let mesh = parts.sample.mesh;
    let matter = &parts.common.matter[phase.index()];
    if mesh.kind == CellKind::Hexahedron {
        let shape = &parts.common.shape;
        return Ok(Need::of(matter, &box_metric(shape), 8, shape.volume(), parts.dt));
    }
    let (metric, volume) = tetrahedron(mesh, cell)?;
    Ok(Need::of(matter, &metric, 4, volume, parts.dt))
}

/// Metric and volume of a tetrahedron.
///
/// # Errors
/// No positive volume.
fn tetrahedron(mesh: &Mesh, cell: u32) -> Result<(Mat3, f64), SolveError> {
    let (metric, volume) = tet_metric(&corners(mesh, cell));
    if !(volume > 0.0 && metric.iter().all(|x| x.is_finite())) {
        let at: [f64; 3] = corners(mesh, cell)[0].into();
        return Err(SolveError::mesh(format!("the tetrahedron at {at:?} has the volume {volume} mm3; mesh anew")));
    }
    Ok((metric, volume))
}

/// Unit normal of a cohesive face, out of the aggregate, and the area of each pair of its nodes, mm2.
pub(crate) fn facing(mesh: &Mesh, face: &[u32]) -> (Vec3, f64) {
    let pairs = face.len() / 2;
    let area = area(mesh, &face[..pairs]);
    let size = area.norm();
    let normal = if size > 0.0 { area / size } else { Vec3::z() };
    (normal, size / pairs as f64)
}
