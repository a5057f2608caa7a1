//! Cost of explicit dynamics in steps of a given length: the mass that mass scaling adds, phase by phase.
//!
//! A cell whose own stable step is shorter by the factor k gets k^2 times its mass, as `*FIXED MASS SCALING, TYPE=BELOW MIN` does
//! it; its own step is the bound of [`stable_length_mm`](super::CellQuality::stable_length_mm) over the wave speed.

use super::quality::stable_length_mm;
use crate::cells::{Mesh, Phase, cell_volume};
use crate::materials::Materials;
use meso_collision::math::Vec3;
use serde::Serialize;
use std::borrow::Cow;

/// The mass that a time step costs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MassScaling {
    /// The step, s.
    pub time_step_s: f64,
    /// Mass of all elements with the added mass, over their own.
    pub factor: f64,
    /// The phases that the mesh has; cohesive elements are the ITZ.
    pub phases: Vec<PhaseScaling>,
}

/// One phase's share of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhaseScaling {
    /// Name of the phase's element set.
    pub phase: String,
    /// Number of elements.
    pub elements: usize,
    /// Share of them whose own step is shorter, 0 to 1.
    pub scaled: f64,
    /// Mass of the elements with the added mass, over their own.
    pub factor: f64,
    /// Shortest step of its elements, s.
    pub shortest_step_s: f64,
    /// Their mass before scaling, tonne.
    pub mass_t: f64,
}

/// Halvings of the logarithm in the search for a step: 1 % in steps that are a thousand times too long.
const BISECTIONS: usize = 10;

impl MassScaling {
    /// Mass over the mesh's own that is little.
    pub const LITTLE: f64 = 1.2;
    /// Mass that is refused: nothing of the specimen's own inertia is left.
    pub const MOST: f64 = 100.0;

    /// Mass that is worth a warning: less for a step that was given than for that of tests by rule, of which lattices of a packing
    /// of 0.5 need 4 times theirs.
    pub const fn much(is_given: bool) -> f64 {
        if is_given { 2.0 } else { 5.0 }
    }

    /// Adds up the elements of `mesh` in steps of `time_step_s` seconds.
    pub fn of(mesh: &Mesh, materials: &Materials, time_step_s: f64) -> Self {
        let materials = materials.in_mesh(mesh);
        let cells = Sums::of_cells(mesh, &materials, time_step_s);
        let phases = &mesh.phases;
        let solid = phases.solid().map(|phase| cells[phase.index()].named(phases.set_name(phase)));
        let joints = Sums::of_cohesive(mesh, &materials, time_step_s).named(phases.set_name(Phase::Itz));
        let phases: Vec<PhaseScaling> = solid.chain([joints]).filter(|phase| phase.elements > 0).collect();
        let mass = |with: fn(&PhaseScaling) -> f64| phases.iter().map(|phase| phase.mass_t * with(phase)).sum::<f64>();
        Self { time_step_s, factor: mass(|phase| phase.factor) / mass(|_| 1.0), phases }
    }

    /// The longest step of two digits, s, in which `mesh` needs at most `factor` times its mass; no longer than this one.
    pub fn step_for(&self, mesh: &Mesh, materials: &Materials, factor: f64) -> f64 {
        let shortest = self.phases.iter().map(|phase| phase.shortest_step_s).fold(self.time_step_s, f64::min);
        let (mut low, mut high) = (shortest, self.time_step_s);
        for _ in 0..BISECTIONS {
            let middle = (low * high).sqrt();
            let fits = Self::of(mesh, materials, middle).factor <= factor;
            *(if fits { &mut low } else { &mut high }) = middle;
        }
        let text = format!("{low:.1e}");
        let rounded: f64 = text.parse().unwrap_or(low);
        if rounded > low { format!("{:.1e}", 0.95 * low).parse().unwrap_or(low) } else { rounded }
    }

    /// The mass that is added, % of the mesh's own.
    pub fn added_percent(&self) -> f64 {
        100.0 * (self.factor - 1.0)
    }
}

/// Elements of one phase, added up.
#[derive(Clone, Copy)]
struct Sums {
    elements: usize,
    scaled: usize,
    mass: f64,
    scaled_mass: f64,
    shortest: f64,
}

impl Sums {
    const NONE: Self = Self { elements: 0, scaled: 0, mass: 0.0, scaled_mass: 0.0, shortest: f64::INFINITY };

    /// By phase number.
    fn of_cells(mesh: &Mesh, materials: &Materials, step: f64) -> Vec<Self> {
        let nodes = mesh.kind.nodes();
        let of_run = |_: usize, cells: &[u32], phases: &[Phase]| {
            let mut sums = vec![Self::NONE; mesh.phases.count()];
            for (cell, phase) in cells.chunks_exact(nodes).zip(phases) {
                let (volume, elastic) =
                    (cell_volume(mesh.kind, cell, &mesh.points), materials.elastic(*phase, &mesh.phases));
                let own = stable_length_mm(mesh, cell) / elastic.wave_speed_mm_per_s();
                sums[phase.index()].add(volume * elastic.density_t_per_mm3, own, step);
            }
            sums
        };
        let runs = mesh.in_runs(of_run);
        let sum = |i: usize| runs.iter().fold(Self::NONE, |all, run| all.and(&run[i]));
        (0..mesh.phases.count()).map(sum).collect()
    }

    fn of_cohesive(mesh: &Mesh, materials: &Materials, step: f64) -> Self {
        let per_area = materials.itz.density_t_per_mm3 * materials.cohesive_thickness_mm;
        let own = materials.cohesive_time_step_s();
        let mut sums = Self::NONE;
        mesh.cohesive().for_each(|nodes| sums.add(area(mesh, &nodes[..nodes.len() / 2]) * per_area, own, step));
        sums
    }

    fn add(&mut self, mass: f64, own_step: f64, step: f64) {
        let times = (step / own_step).max(1.0);
        self.elements += 1;
        self.scaled += usize::from(times > 1.0);
        self.mass += mass;
        self.scaled_mass += mass * times * times;
        self.shortest = self.shortest.min(own_step);
    }

    fn and(self, later: &Self) -> Self {
        Self {
            elements: self.elements + later.elements,
            scaled: self.scaled + later.scaled,
            mass: self.mass + later.mass,
            scaled_mass: self.scaled_mass + later.scaled_mass,
            shortest: self.shortest.min(later.shortest),
        }
    }

    fn named(&self, phase: Cow<'static, str>) -> PhaseScaling {
        PhaseScaling {
            phase: phase.into_owned(),
            elements: self.elements,
            scaled: self.scaled as f64 / self.elements as f64,
            factor: self.scaled_mass / self.mass,
            shortest_step_s: self.shortest,
            mass_t: self.mass,
        }
    }
}

/// Area of a triangle or of a parallelogram, mm2.
fn area(mesh: &Mesh, face: &[u32]) -> f64 {
    let p = |i: usize| mesh.points[face[i] as usize];
    let edges: [Vec3; 2] = [p(1) - p(0), p(face.len() - 1) - p(0)];
    edges[0].cross(&edges[1]).norm() * if face.len() == 3 { 0.5 } else { 1.0 }
}
