//! The report on a mesh: its worst cells, the bad ones by number, volumes against the exact ones, the time step.
//!
//! Cells are looked at in runs, so that a mesh of tens of millions needs no list of all their measures.

use super::{CellQuality, measured};
use crate::aggregate::Aggregate;
use crate::materials::Materials;
use crate::mesh::{InterfaceDistance, Mesh, Phase, PhaseVolumes};
use crate::packing::Specimen;
use rayon::prelude::*;
use serde::Serialize;

/// Cells with a dihedral angle below this are called bad, degrees.
pub const BAD_DEG: f64 = 8.0;

/// Upper limits of the histogram's bins, degrees.
pub const DIHEDRAL_BINS: [f64; 7] = [1.0, 2.0, 5.0, 8.0, 10.0, 15.0, 30.0];

/// The worst of all cells, with a histogram, and how much of each phase is there. Cells are indices; decks count from 1.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct QualityReport {
    /// Number of cells.
    pub cells: usize,
    /// Smallest dihedral angle, degrees, and the cell's index.
    pub min_dihedral_deg: (f64, usize),
    /// Largest dihedral angle, degrees, and the cell's index.
    pub max_dihedral_deg: (f64, usize),
    /// Smallest radius ratio and the cell's index.
    pub min_radius_ratio: (f64, usize),
    /// Shortest altitude, mm, and the cell's index.
    pub shortest_altitude_mm: (f64, usize),
    /// Cells by smallest dihedral angle: below 1, 2, 5, 8, 10, 15, 30 degrees and the rest.
    pub dihedral_histogram: [usize; 8],
    /// The cells with a dihedral angle below [`BAD_DEG`].
    pub bad_cells: Vec<usize>,
    /// Cells with no positive volume.
    pub inverted: usize,
    /// Stable time step of explicit dynamics, s: 1 / (c sqrt(sum |grad N|^2)) of the worst cell, c the dilatational wave speed.
    pub stable_time_step_s: f64,
    /// The same of cohesive elements, by their stiffness and mass per area; `None` where there are none.
    pub cohesive_time_step_s: Option<f64>,
    /// Volume of every phase in the mesh, mm3.
    pub volumes_mm3: PhaseVolumes,
    /// The same from the polyhedra themselves, with the shells of a solid ITZ where the mesh has one; `None` where a core
    /// has no trustworthy volume.
    pub exact_volumes_mm3: Option<PhaseVolumes>,
    /// How near the interfaces lie to the aggregates' surfaces.
    pub interface_distance: InterfaceDistance,
}

impl QualityReport {
    /// Of a mesh of `bodies` in `specimen`; time steps are those of `materials`.
    pub fn of(mesh: &Mesh, bodies: &[Aggregate], specimen: &Specimen, materials: &Materials) -> Self {
        let worst = Worst::of(mesh, materials);
        let solid = mesh.phase.contains(&Phase::Itz) && !mesh.has_smeared_itz();
        let shell = |aggregate: &Aggregate| if solid { aggregate.itz_thickness_mm } else { 0.0 };
        Self {
            cells: mesh.cell_count(),
            min_dihedral_deg: worst.min_dihedral,
            max_dihedral_deg: (-worst.max_dihedral.0, worst.max_dihedral.1),
            min_radius_ratio: worst.radius_ratio,
            shortest_altitude_mm: worst.altitude,
            dihedral_histogram: worst.histogram,
            bad_cells: worst.bad,
            inverted: worst.inverted,
            stable_time_step_s: worst.time_step,
            cohesive_time_step_s: (!mesh.cohesive.is_empty()).then(|| materials.cohesive_time_step_s()),
            volumes_mm3: PhaseVolumes::of_mesh(mesh),
            exact_volumes_mm3: PhaseVolumes::exact(bodies, specimen, shell).ok(),
            interface_distance: InterfaceDistance::of(mesh, bodies, specimen),
        }
    }
}

/// Cells looked at together.
const RUN: usize = 1 << 16;

/// The worst of some cells; each with the first cell that has it.
struct Worst {
    min_dihedral: (f64, usize),
    /// Its negative, so that the smallest is the worst here, too.
    max_dihedral: (f64, usize),
    radius_ratio: (f64, usize),
    altitude: (f64, usize),
    histogram: [usize; 8],
    bad: Vec<usize>,
    inverted: usize,
    time_step: f64,
}

impl Worst {
    fn none() -> Self {
        let none = (f64::INFINITY, 0);
        Self {
            min_dihedral: none,
            max_dihedral: none,
            radius_ratio: none,
            altitude: none,
            histogram: [0; 8],
            bad: Vec::new(),
            inverted: 0,
            time_step: f64::INFINITY,
        }
    }

    fn of(mesh: &Mesh, materials: &Materials) -> Self {
        let materials = materials.in_mesh(mesh);
        let speeds = |phase: Phase| materials.elastic(phase).wave_speed_mm_per_s();
        let runs = mesh.cells.par_chunks(RUN * mesh.kind.nodes()).zip(mesh.phase.par_chunks(RUN)).enumerate();
        let of_run = |(run, (cells, phases)): (usize, (&[u32], &[Phase]))| {
            let mut worst = Self::none();
            let cells = cells.chunks_exact(mesh.kind.nodes()).map(|cell| measured(mesh, cell));
            for ((index, quality), phase) in (run * RUN..).zip(cells).zip(phases) {
                worst.see(index, &quality, speeds(*phase));
            }
            worst
        };
        let runs: Vec<Self> = runs.map(of_run).collect();
        runs.into_iter().fold(Self::none(), Self::and)
    }

    fn see(&mut self, index: usize, cell: &CellQuality, wave_speed: f64) {
        let angle = cell.min_dihedral_deg;
        self.min_dihedral = first_least(self.min_dihedral, (angle, index));
        self.max_dihedral = first_least(self.max_dihedral, (-cell.max_dihedral_deg, index));
        self.radius_ratio = first_least(self.radius_ratio, (cell.radius_ratio, index));
        self.altitude = first_least(self.altitude, (cell.shortest_altitude_mm, index));
        self.histogram[DIHEDRAL_BINS.iter().position(|limit| angle < *limit).unwrap_or(7)] += 1;
        if angle < BAD_DEG {
            self.bad.push(index);
        }
        self.inverted += usize::from(cell.volume_mm3 <= 0.0);
        self.time_step = self.time_step.min(cell.stable_length_mm / wave_speed);
    }

    /// With the cells that come after these.
    fn and(self, later: Self) -> Self {
        Self {
            min_dihedral: first_least(self.min_dihedral, later.min_dihedral),
            max_dihedral: first_least(self.max_dihedral, later.max_dihedral),
            radius_ratio: first_least(self.radius_ratio, later.radius_ratio),
            altitude: first_least(self.altitude, later.altitude),
            histogram: std::array::from_fn(|bin| self.histogram[bin] + later.histogram[bin]),
            bad: [self.bad, later.bad].concat(),
            inverted: self.inverted + later.inverted,
            time_step: self.time_step.min(later.time_step),
        }
    }
}

fn first_least(first: (f64, usize), second: (f64, usize)) -> (f64, usize) {
    if second.0.total_cmp(&first.0).is_lt() { second } else { first }
}
