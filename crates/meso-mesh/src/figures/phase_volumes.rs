//! The volumes of a mesh's phases, beside the exact ones.

use crate::cells::{Mesh, Phase, cell_volume};
use meso_collision::geometry::OffsetError;
use meso_concrete::aggregate::{Aggregate, Kind};
use meso_concrete::specimen::Specimen;
use meso_concrete::{PhaseNames, parallel};
use serde::Serialize;

/// Volume of every phase, mm3.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PhaseVolumes {
    /// Aggregate cores, those of a phase of their own included.
    pub aggregate: f64,
    /// Shells.
    pub itz: f64,
    /// Everything else, but for voids.
    pub mortar: f64,
    /// Fibres.
    #[serde(skip_serializing_if = "is_zero")]
    pub fibre: f64,
    /// The parts of the aggregate cores that are of the specimen's own phases; files name them.
    #[serde(skip)]
    pub own: [f64; PhaseNames::MOST],
}

/// Share of a whole that is rounding, where it is left by a sum.
const ROUNDING: f64 = 1e-9;

fn is_zero(volume: &f64) -> bool {
    *volume == 0.0
}

impl PhaseVolumes {
    /// The phases' volumes in `mesh`.
    pub fn of_mesh(mesh: &Mesh) -> Self {
        let nodes = mesh.kind.nodes();
        let of_run = |_: usize, cells: &[u32], phases: &[Phase]| {
            let mut sums = [0.0; PhaseNames::ROOM];
            for (cell, phase) in cells.chunks_exact(nodes).zip(phases) {
                sums[phase.index()] += cell_volume(mesh.kind, cell, &mesh.points);
            }
            sums
        };
        let runs = mesh.in_runs(of_run);
        let sum = |i: usize| runs.iter().map(|sums| sums[i]).sum::<f64>();
        let [mortar, itz, aggregate, _, fibre] = std::array::from_fn(sum);
        let own = std::array::from_fn(|i| sum(Phase::ALL.len() + i));
        Self { aggregate: own.iter().fold(aggregate, |all, own| all + own), itz, mortar, fibre, own }
    }

    /// The volumes in `mesh` that compare with those of bodies: a smeared ITZ counts as mortar.
    pub fn of_bodies(mesh: &Mesh) -> Self {
        let volumes = Self::of_mesh(mesh);
        match mesh.has_smeared_itz() {
            true => Self { mortar: volumes.mortar + volumes.itz, itz: 0.0, ..volumes },
            false => volumes,
        }
    }

    /// Volume of one phase, mm3.
    pub fn of(&self, phase: Phase) -> f64 {
        match phase {
            Phase::Mortar => self.mortar,
            Phase::Itz => self.itz,
            Phase::Aggregate => self.without_own(),
            Phase::Own(own) => self.own[usize::from(own)],
            Phase::Void => 0.0,
            Phase::Fibre => self.fibre,
        }
    }

    /// Volume of the aggregates of no phase of their own, mm3: a rest that is rounding counts as nothing.
    fn without_own(&self) -> f64 {
        let own = self.own.iter().fold(0.0, |sum, own| sum + own);
        let rest = self.aggregate - own;
        if own > 0.0 && rest <= ROUNDING * self.aggregate { 0.0 } else { rest }
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
        let core = |index: usize| -> Result<(f64, Vec<(Phase, f64)>), OffsetError> {
            let aggregate = &aggregates[index];
            let itz = if aggregate.kind == Kind::Aggregate { shell(aggregate) } else { 0.0 };
            let layers = if aggregate.shells.is_empty() { Vec::new() } else { aggregate.layer_volumes(itz)? };
            Ok((aggregate.core_volume(itz)?, layers))
        };
        // Summed in the aggregates' order: the same on any number of threads.
        let cores = parallel::try_map(aggregates.len(), core)?;
        let (mut inside, mut own) = (0.0, [0.0; PhaseNames::MOST]);
        for (body, (core, mut layers)) in aggregates.iter().zip(cores) {
            if body.kind != Kind::Aggregate {
                continue;
            }
            inside += core;
            if layers.is_empty() {
                layers.push((body.phase(), core));
            }
            for (phase, volume) in layers {
                if let Phase::Own(number) = phase {
                    own[usize::from(number)] += volume;
                }
            }
        }
        Ok(Self { own, ..Self::with_cores(aggregates, specimen, inside) })
    }

    /// The exact volumes where the cores of all aggregates have `inside` mm3 together.
    fn with_cores(aggregates: &[Aggregate], specimen: &Specimen, inside: f64) -> Self {
        let (mut all, mut outer, mut fibre) = (0.0, 0.0, 0.0);
        for aggregate in aggregates {
            let volume = aggregate.body.volume();
            all += volume;
            match aggregate.kind {
                Kind::Aggregate => outer += volume,
                Kind::Void => {}
                Kind::Fibre => fibre += volume,
            }
        }
        let own = [0.0; PhaseNames::MOST];
        Self { aggregate: inside, itz: outer - inside, mortar: specimen.volume() - all, fibre, own }
    }

    /// The exact volumes beside a mesh of these aggregates, by [`exact`](Self::exact) unless the mesh has noted those of cores.
    ///
    /// # Errors
    /// Where an aggregate's core has no trustworthy volume.
    pub(crate) fn beside(
        mesh: &Mesh,
        aggregates: &[Aggregate],
        specimen: &Specimen,
        shell: impl Fn(&Aggregate) -> f64 + Sync,
    ) -> Result<Self, OffsetError> {
        match mesh.notes.cores_mm3 {
            Some(inside) if mesh.phases.own().len() == 0 => Ok(Self::with_cores(aggregates, specimen, inside)),
            _ => Self::exact(aggregates, specimen, shell),
        }
    }

    /// The exact volumes of the phases that `mesh` has: with the shells where its ITZ is solid; `None` where a core has no
    /// trustworthy volume.
    pub fn exact_for(mesh: &Mesh, bodies: &[Aggregate], specimen: &Specimen) -> Option<Self> {
        let solid = mesh.phase.contains(&Phase::Itz) && !mesh.has_smeared_itz();
        let shell = |aggregate: &Aggregate| if solid { aggregate.itz_thickness_mm } else { 0.0 };
        Self::beside(mesh, bodies, specimen, shell).ok()
    }

    /// Volume of the voids in `mesh` and their own in the packing, whose phases these are, mm3; `None` where there are no
    /// voids, or where the mesh conforms to them.
    pub fn voids(&self, mesh: &Mesh, specimen_mm3: f64) -> Option<[f64; 2]> {
        let exact = specimen_mm3 - self.total();
        (exact > ROUNDING * specimen_mm3 && !mesh.notes.conforming).then_some([mesh.notes.voids_mm3, exact])
    }

    /// Sum of the phases, mm3.
    pub fn total(&self) -> f64 {
        self.aggregate + self.itz + self.mortar + self.fibre
    }
}
