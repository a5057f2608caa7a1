//! How good a mesh is: the angles and shapes of its cells, how much of the specimen each phase fills, and the report on it.
//!
//! The report looks at cells in runs, so that a mesh of tens of millions needs no list of all their measures.

mod mass_scaling;

pub use mass_scaling::{MassScaling, PhaseScaling};

use super::cells::{CellKind, Mesh, Phase};
use super::error::MeshError;
use super::fidelity::InterfaceDistance;
use super::tet::{TetMesh, dihedral_cosines, face_vectors, shortest_altitude, volume};
use crate::aggregate::{Aggregate, Kind};
use crate::geometry::OffsetError;
use crate::materials::Materials;
use crate::math::Vec3;
use crate::packing::Specimen;
use crate::stop;
use rayon::prelude::*;
use serde::Serialize;

/// One cell's measures.
#[derive(Clone, Copy, Debug, PartialEq)]
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
        mesh.cells.par_chunks_exact(mesh.kind.nodes()).panic_fuse().map(|cell| measured(mesh, cell)).collect()
    }

    /// The cells whose smallest dihedral angle lies below `degrees`, as indices.
    pub fn below(cells: &[Self], degrees: f64) -> Vec<usize> {
        (0..).zip(cells).filter(|(_, q)| q.min_dihedral_deg < degrees).map(|(index, _)| index).collect()
    }
}

fn measured(mesh: &Mesh, cell: &[u32]) -> CellQuality {
    stop::point();
    match mesh.kind {
        CellKind::Hexahedron => voxel(cell, mesh),
        _ => {
            let quality = tetrahedron([0, 1, 2, 3].map(|i| mesh.points[cell[i] as usize]));
            // The nodes of a second-order tetrahedron are half as far apart.
            let halves = if mesh.kind == CellKind::QuadraticTetrahedron { 2.0 } else { 1.0 };
            CellQuality { stable_length_mm: quality.stable_length_mm / halves, ..quality }
        }
    }
}

/// The length L of a tetrahedron that bounds its stable time step: L / c is stable for dilatational waves of speed c.
///
/// With lumped masses m = rho V / 4 its highest frequency w has w^2 <= 4 c^2 sum |grad N|^2 (the trace bounds the largest
/// eigenvalue, for Poisson's ratios of 0 or more), and central differences are stable up to 2 / w. So L = 1 / sqrt(sum
/// |grad N|^2), where |grad N| is one over an altitude. The shortest altitude is up to twice as long, and no bound.
pub(crate) fn stable_length(p: [Vec3; 4]) -> f64 {
    6.0 * volume(p) / face_vectors(p).map(|n| n.norm_squared()).into_iter().sum::<f64>().sqrt()
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
        // The same bound with the gradients at the centre: 2 / (c sqrt(8 sum |grad N|^2)).
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
    /// The cells with a dihedral angle below [`BAD_DEG`](Self::BAD_DEG).
    pub bad_cells: Vec<usize>,
    /// Cells with no positive volume.
    pub inverted: usize,
    /// Stable time step of explicit dynamics, s: 1 / (c sqrt(sum |grad N|^2)) of the worst cell, c the dilatational wave
    /// speed.
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
    /// Cells with a dihedral angle below this are called bad, degrees.
    pub const BAD_DEG: f64 = 8.0;

    /// Of a mesh of `bodies` in `specimen`; time steps are those of `materials`.
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

/// Cells looked at, or added up, together.
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

/// Volume of every phase, mm3.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PhaseVolumes {
    /// Aggregate cores.
    pub aggregate: f64,
    /// Shells.
    pub itz: f64,
    /// Everything else, but for voids.
    pub mortar: f64,
    /// Fibres.
    #[serde(skip_serializing_if = "is_zero")]
    pub fibre: f64,
}

fn is_zero(volume: &f64) -> bool {
    *volume == 0.0
}

impl PhaseVolumes {
    /// The phases' volumes in `mesh`.
    pub fn of_mesh(mesh: &Mesh) -> Self {
        let nodes = mesh.kind.nodes();
        let of_run = |(cells, phases): (&[u32], &[Phase])| {
            let mut sums = [0.0; 5];
            for (cell, phase) in cells.chunks_exact(nodes).zip(phases) {
                sums[*phase as usize] += cell_volume(mesh.kind, cell, &mesh.points);
            }
            sums
        };
        // Runs of one length, added in their order: the same on any number of threads.
        let runs: Vec<[f64; 5]> =
            mesh.cells.par_chunks(RUN * nodes).zip(mesh.phase.par_chunks(RUN)).map(of_run).collect();
        let [mortar, itz, aggregate, _, fibre] = std::array::from_fn(|i| runs.iter().map(|sums| sums[i]).sum());
        Self { aggregate, itz, mortar, fibre }
    }

    /// That of one phase.
    pub fn of(&self, phase: Phase) -> f64 {
        match phase {
            Phase::Mortar => self.mortar,
            Phase::Itz => self.itz,
            Phase::Aggregate => self.aggregate,
            Phase::Fibre => self.fibre,
        }
    }

    /// The exact volumes, from the polyhedra; `shell(aggregate)` is the thickness of its shell, mm.
    ///
    /// # Errors
    /// Where an aggregate's core has no trustworthy volume.
    pub fn exact(
        aggregates: &[Aggregate],
        specimen: &Specimen,
        shell: impl Fn(&Aggregate) -> f64 + Sync,
    ) -> Result<Self, OffsetError> {
        let core = |aggregate: &Aggregate| {
            let inner = if aggregate.kind == Kind::Aggregate { shell(aggregate) } else { 0.0 };
            Ok(crate::geometry::inward_offset(&aggregate.body, inner)?.map_or(0.0, |body| body.volume()))
        };
        // Summed in the aggregates' order: the same on any number of threads.
        let cores = aggregates.par_iter().map(core).collect::<Result<Vec<f64>, OffsetError>>()?;
        let (mut all, mut outer, mut inside, mut fibre) = (0.0, 0.0, 0.0, 0.0);
        for (aggregate, core) in aggregates.iter().zip(cores) {
            let volume = aggregate.body.volume();
            all += volume;
            match aggregate.kind {
                Kind::Aggregate => (outer, inside) = (outer + volume, inside + core),
                Kind::Void => {}
                Kind::Fibre => fibre += volume,
            }
        }
        Ok(Self { aggregate: inside, itz: outer - inside, mortar: specimen.volume() - all, fibre })
    }

    /// The exact volumes of the phases that `mesh` has: with the shells where its ITZ is solid; `None` where a core has no
    /// trustworthy volume.
    pub fn exact_for(mesh: &Mesh, bodies: &[Aggregate], specimen: &Specimen) -> Option<Self> {
        let solid = mesh.phase.contains(&Phase::Itz) && !mesh.has_smeared_itz();
        let shell = |aggregate: &Aggregate| if solid { aggregate.itz_thickness_mm } else { 0.0 };
        Self::exact(bodies, specimen, shell).ok()
    }

    /// Sum of the phases, mm3.
    pub fn total(&self) -> f64 {
        self.aggregate + self.itz + self.mortar + self.fibre
    }
}

/// Refuses a mesh with a cell of no positive volume: no solver takes it.
pub(super) fn all_positive(mesh: &Mesh) -> Result<(), MeshError> {
    let cells = mesh.cells.par_chunks_exact(mesh.kind.nodes());
    let solid = |cell: &&[u32]| cell_volume(mesh.kind, cell, &mesh.points) > 0.0;
    let flat: Vec<&[u32]> = cells.filter(|cell| !solid(cell)).collect();
    match flat.first() {
        None => Ok(()),
        Some(first) => Err(MeshError::Flat { cells: flat.len(), at: mesh.points[first[0] as usize].into() }),
    }
}

/// Refuses tetrahedra of which one has no positive volume.
pub(super) fn all_tetrahedra_positive(mesh: &TetMesh) -> Result<(), MeshError> {
    let is_positive = |cell: u32| mesh.volume(cell) > 0.0;
    let flat: Vec<u32> = mesh.numbers().into_par_iter().filter(|&cell| !is_positive(cell)).collect();
    match flat.first() {
        None => Ok(()),
        Some(&first) => Err(MeshError::Flat { cells: flat.len(), at: mesh.position(mesh.cell(first)[0]).into() }),
    }
}

/// Volume of a cell, mm3; negative where its nodes are out of order.
pub(crate) fn cell_volume(kind: CellKind, cell: &[u32], points: &[Vec3]) -> f64 {
    let p = |i: usize| points[cell[i] as usize];
    let six = |a: usize, b: usize, c: usize, d: usize| (p(b) - p(a)).cross(&(p(c) - p(a))).dot(&(p(d) - p(a)));
    match kind {
        CellKind::Tetrahedron | CellKind::QuadraticTetrahedron => volume([p(0), p(1), p(2), p(3)]),
        // Six tetrahedra around the diagonal 0-6: exact for the parallelepipeds that voxels are.
        CellKind::Hexahedron => {
            [(1, 2), (2, 3), (3, 7), (7, 4), (4, 5), (5, 1)].iter().map(|&(b, c)| six(0, b, c, 6)).sum::<f64>() / 6.0
        }
    }
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
