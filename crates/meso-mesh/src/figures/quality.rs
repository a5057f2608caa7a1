//! Quality of a mesh: the angles and shapes of its cells, and the report on it.
//!
//! The report looks at cells in runs, so that a mesh of tens of millions needs no list of all their measures.

use super::interface_distance::InterfaceDistance;
use super::phase_volumes::PhaseVolumes;
use crate::cells::{CellKind, Mesh, Phase, cell_volume};
use crate::materials::Materials;
use crate::tet::{dihedral_cosines, face_vectors, shortest_altitude, stable_length, volume};
use meso_collision::math::Vec3;
use meso_concrete::aggregate::Aggregate;
use meso_concrete::parallel;
use meso_concrete::specimen::Specimen;
use meso_concrete::stop;
use serde::Serialize;

/// One cell's measures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellQuality {
    /// Smallest angle between two faces, degrees; 90 for voxels.
    pub min_dihedral_deg: f64,
    /// Largest angle between two faces, degrees.
    pub max_dihedral_deg: f64,
    /// Three times the inscribed over the circumscribed sphere's radius; 1 for the regular tetrahedron and for voxels.
    pub radius_ratio: f64,
    /// Shortest distance from a node (a face) to the opposite face, mm.
    pub shortest_altitude_mm: f64,
    /// The stable time step of explicit dynamics times the wave speed, mm: a bound for lumped masses.
    pub stable_length_mm: f64,
    /// mm3; negative where the nodes are out of order.
    pub volume_mm3: f64,
}

impl CellQuality {
    /// Every cell's measures, in the cells' order.
    pub fn of_cells(mesh: &Mesh) -> Vec<Self> {
        Self::each(mesh, |quality| quality)
    }

    /// Every cell's measures as far as they are `kept`, in the cells' order.
    pub fn each<T: Copy + Default + Send>(mesh: &Mesh, kept: impl Fn(Self) -> T + Sync) -> Vec<T> {
        parallel::map_short(mesh.cell_count(), |cell| kept(measured(mesh, mesh.by_owner().cell(cell))))
    }

    /// The cells whose smallest dihedral angle lies below `degrees`, as indices.
    pub fn below(cells: &[Self], degrees: f64) -> Vec<usize> {
        (0..).zip(cells).filter(|(_, q)| q.min_dihedral_deg < degrees).map(|(index, _)| index).collect()
    }
}

pub(super) fn measured(mesh: &Mesh, cell: &[u32]) -> CellQuality {
    stop::point();
    match mesh.kind {
        CellKind::Hexahedron => voxel(cell, mesh),
        kind => {
            let quality = tetrahedron(corners(mesh, cell));
            CellQuality { stable_length_mm: quality.stable_length_mm / parts(kind), ..quality }
        }
    }
}

/// [`CellQuality::stable_length_mm`] of one cell.
pub(super) fn stable_length_mm(mesh: &Mesh, cell: &[u32]) -> f64 {
    match mesh.kind {
        CellKind::Hexahedron => voxel(cell, mesh).stable_length_mm,
        kind => stable_length(corners(mesh, cell)) / parts(kind),
    }
}

fn corners(mesh: &Mesh, cell: &[u32]) -> [Vec3; 4] {
    [0, 1, 2, 3].map(|i| mesh.points[cell[i] as usize])
}

/// Parts of an edge between neighbouring nodes.
fn parts(kind: CellKind) -> f64 {
    if kind == CellKind::QuadraticTetrahedron { 2.0 } else { 1.0 }
}

/// Measures of the tetrahedron with these corners, mm.
pub(crate) fn tetrahedron(p: [Vec3; 4]) -> CellQuality {
    let degrees = |cosine: f64| libm::acos(cosine.clamp(-1.0, 1.0)).to_degrees();
    let [low, high] = dihedral_cosines(p);
    let areas = face_vectors(p).map(|n| n.norm() / 2.0);
    let volume = volume(p);
    let inscribed = 3.0 * volume / areas.iter().sum::<f64>();
    CellQuality {
        min_dihedral_deg: degrees(high),
        max_dihedral_deg: degrees(low),
        radius_ratio: 3.0 * inscribed / circumradius(p),
        shortest_altitude_mm: shortest_altitude(p),
        stable_length_mm: stable_length(p),
        volume_mm3: volume,
    }
}

/// |u^2 (v x w) + v^2 (w x u) + w^2 (u x v)| / (2 |u . v x w|), edges from the first corner.
fn circumradius([a, b, c, d]: [Vec3; 4]) -> f64 {
    let (u, v, w) = (b - a, c - a, d - a);
    let numerator = v.cross(&w) * u.norm_squared() + w.cross(&u) * v.norm_squared() + u.cross(&v) * w.norm_squared();
    numerator.norm() / (2.0 * u.dot(&v.cross(&w)).abs())
}

/// Measures of a box-shaped hexahedron.
fn voxel(cell: &[u32], mesh: &Mesh) -> CellQuality {
    let edges = [1, 3, 4].map(|i: usize| (mesh.points[cell[i] as usize] - mesh.points[cell[0] as usize]).norm());
    CellQuality {
        min_dihedral_deg: 90.0,
        max_dihedral_deg: 90.0,
        radius_ratio: 1.0,
        shortest_altitude_mm: edges.into_iter().fold(f64::INFINITY, f64::min),
        // The stable length with the gradients at the centre is 2 / (c sqrt(8 sum |grad N|^2)).
        stable_length_mm: 1.0 / edges.map(|edge| 1.0 / (edge * edge)).iter().sum::<f64>().sqrt(),
        volume_mm3: cell_volume(mesh.kind, cell, &mesh.points),
    }
}

/// Upper limits of the histogram's bins, degrees.
const DIHEDRAL_BINS: [f64; 7] = [1.0, 2.0, 5.0, 8.0, 10.0, 15.0, 30.0];

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
    /// The cells with a dihedral angle below 8 degrees.
    pub bad_cells: Vec<usize>,
    /// Cells with no positive volume.
    pub inverted: usize,
    /// Stable time step of explicit dynamics, s: 1 / (c sqrt(sum |grad N|^2)) of the worst cell, c the dilatational wave
    /// speed.
    pub stable_time_step_s: f64,
    /// Shortest stable time step of cohesive elements, by their stiffness and mass per area; `None` where there are none.
    pub cohesive_time_step_s: Option<f64>,
    /// Volume of every phase in the mesh, mm3.
    pub volumes_mm3: PhaseVolumes,
    /// Volumes of the phases from the polyhedra themselves, with the shells of a solid ITZ where the mesh has one; `None` where a core
    /// has no trustworthy volume.
    pub exact_volumes_mm3: Option<PhaseVolumes>,
    /// How near the interfaces lie to the aggregates' surfaces.
    pub interface_distance: InterfaceDistance,
}

impl QualityReport {
    /// Cells with a dihedral angle below this are called bad, degrees.
    pub const BAD_DEG: f64 = 8.0;

    /// Measures a mesh of `bodies` in `specimen`; time steps are those of `materials`.
    pub fn of(mesh: &Mesh, bodies: &[Aggregate], specimen: &Specimen, materials: &Materials) -> Self {
        let worst = Worst::of(mesh, materials);
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
            exact_volumes_mm3: PhaseVolumes::exact_for(mesh, bodies, specimen),
            interface_distance: InterfaceDistance::of(mesh, bodies, specimen),
        }
    }
}

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
        let speeds = |phase: Phase| materials.elastic(phase, &mesh.phases).wave_speed_mm_per_s();
        let of_run = |first: usize, cells: &[u32], phases: &[Phase]| {
            let mut worst = Self::none();
            let cells = cells.chunks_exact(mesh.kind.nodes()).map(|cell| measured(mesh, cell));
            for ((index, quality), phase) in (first..).zip(cells).zip(phases) {
                worst.see(index, &quality, speeds(*phase));
            }
            worst
        };
        mesh.in_runs(of_run).into_iter().fold(Self::none(), Self::and)
    }

    fn see(&mut self, index: usize, cell: &CellQuality, wave_speed: f64) {
        let angle = cell.min_dihedral_deg;
        self.min_dihedral = first_least(self.min_dihedral, (angle, index));
        self.max_dihedral = first_least(self.max_dihedral, (-cell.max_dihedral_deg, index));
        self.radius_ratio = first_least(self.radius_ratio, (cell.radius_ratio, index));
        self.altitude = first_least(self.altitude, (cell.shortest_altitude_mm, index));
        self.histogram[DIHEDRAL_BINS.iter().position(|limit| angle < *limit).unwrap_or(7)] += 1;
        if angle < QualityReport::BAD_DEG {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_regular_tetrahedron_has_the_known_angle_and_ratio_one() {
        let p = [[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0], [-1.0, -1.0, 1.0]].map(Vec3::from);
        let q = tetrahedron(p);
        assert!((q.min_dihedral_deg - 70.528_779_365_509_31).abs() < 1e-9, "{q:?}");
        assert!((q.max_dihedral_deg - q.min_dihedral_deg).abs() < 1e-9);
        assert!((q.radius_ratio - 1.0).abs() < 1e-12);
        assert!((q.volume_mm3 - 8.0 / 3.0).abs() < 1e-12);
        assert!((q.shortest_altitude_mm - 4.0 / 3.0_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_flat_tetrahedron_has_angles_near_zero_and_180() {
        let p = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, 0.3, 1e-4]].map(Vec3::from);
        let q = tetrahedron(p);
        assert!(q.min_dihedral_deg < 0.05 && q.max_dihedral_deg > 179.9);
        assert!((q.shortest_altitude_mm - 1e-4).abs() < 1e-8);
    }
}
