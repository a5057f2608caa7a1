//! Acceptance of a finished mesh: every cell has a positive volume, and every phase has nearly its exact one.
//!
//! Elements as large as the grains lose phases, shells and fibres first: [`PhaseOff`] names the one that is farthest off.

use super::error::{MeshError, Ways};
use super::options::{ItzForm, MeshOptions, MethodName, is_faceted};
use crate::cells::{Cells, Mesh, Phase, cell_volume};
use crate::figures::PhaseVolumes;
use meso_concrete::{Parts, PhaseNames, exceeds, parallel};

/// Refuses cells of which one has no positive volume: no solver takes them.
pub(super) fn all_positive(cells: Cells) -> Result<(), MeshError> {
    let is_solid = |cell: usize| cell_volume(cells.kind, cells.cell(cell), cells.points) > 0.0;
    let flat = parallel::filter(cells.owner.len(), |cell| !is_solid(cell));
    match flat.first() {
        None => Ok(()),
        Some(&first) => {
            let at = cells.points[cells.cell(first as usize)[0] as usize].into();
            Err(MeshError::Flat { cells: flat.len(), at })
        }
    }
}

/// The phase of a mesh that is farthest from its exact volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseOff {
    /// Which one.
    pub phase: Phase,
    /// Its volume in the mesh over the specimen's.
    pub meshed: f64,
    /// The exact volume of its bodies over the specimen's.
    pub exact: f64,
}

impl PhaseOff {
    /// Most that a phase's volume in a mesh may differ from its exact one, as a share of this.
    pub const ACCEPTED: f64 = 0.1;

    /// Accepts a mesh of `parts` made with `options`, unless a phase has more or less of its volume than `accepted` allows.
    ///
    /// `accepted` is a share of the exact volume, [`ACCEPTED`](Self::ACCEPTED) unless a coarse mesh is wanted. Returns the
    /// phase that is farthest off; `None` where a core has no trustworthy volume.
    ///
    /// # Errors
    /// [`MeshError::PhaseError`].
    pub fn accept<'a>(
        mesh: &Mesh,
        parts: impl Into<Parts<'a>>,
        options: &MeshOptions,
        accepted: f64,
    ) -> Result<Option<Self>, MeshError> {
        let parts = parts.into();
        let off = Self::of(mesh, &parts, options);
        match off.filter(|off| off.is_beyond(accepted)) {
            Some(off) => Err(off.refused(&mesh.phases, options, parts.bodies.iter().all(is_faceted), None)),
            None => Ok(off),
        }
    }

    /// The phase whose volume in `meshed` is farthest from `exact`, in a specimen of `whole` mm3; `None` without a phase. A volume
    /// that is no number is the farthest of all.
    pub fn between(meshed: &PhaseVolumes, exact: &PhaseVolumes, whole: f64) -> Option<Self> {
        let off = |phase| Self { phase, meshed: meshed.of(phase) / whole, exact: exact.of(phase) / whole };
        let own = (0..PhaseNames::MOST as u8).map(Phase::Own);
        let wanted = Phase::SOLID.into_iter().chain(own).map(off).filter(|off| exceeds(off.exact, 0.0));
        wanted.max_by(|a, b| a.error().abs().total_cmp(&b.error().abs()))
    }

    fn of(mesh: &Mesh, parts: &Parts, options: &MeshOptions) -> Option<Self> {
        let Parts { bodies, specimen, .. } = parts;
        let exact = PhaseVolumes::beside(mesh, bodies, specimen, |aggregate| options.shell_mm(aggregate)).ok()?;
        Self::between(&PhaseVolumes::of_bodies(mesh), &exact, specimen.volume())
    }

    /// Whether a mesh may have such an error without consent.
    pub fn is_accepted(&self) -> bool {
        self.error().abs() <= Self::ACCEPTED
    }

    /// Its excess, or, below 0, its lack, as a share of its exact volume.
    pub fn error(&self) -> f64 {
        self.meshed / self.exact - 1.0
    }

    /// Whether it is off by more than this share of its exact volume; a volume that is no number is off by more than any.
    pub fn is_beyond(&self, share: f64) -> bool {
        exceeds(self.error().abs(), share)
    }

    /// The error that says so, with remedies. `are_faceted` says that all bodies are convex polyhedra, which a conforming mesh
    /// takes; `tried_mm` is the edge of the cube that was meshed instead of the specimen.
    pub fn refused(
        &self,
        phases: &PhaseNames,
        options: &MeshOptions,
        are_faceted: bool,
        tried_mm: Option<f64>,
    ) -> MeshError {
        let Self { phase, meshed, exact } = *self;
        let ways = ways_out(phase, options, are_faceted);
        MeshError::PhaseError { phase: phases.in_words(phase), meshed, exact, tried_mm, ways }
    }
}

/// Remedies that keep the phase.
fn ways_out(phase: Phase, options: &MeshOptions, are_faceted: bool) -> Ways {
    let (before, after) = match phase {
        Phase::Fibre => ("an ", " of at most half the fibres' diameter"),
        _ => ("a smaller ", ""),
    };
    let method = match (options.method.name(), are_faceted) {
        (MethodName::Voxel, true) => Some("the method lattice or conforming"),
        (MethodName::Voxel, false) => Some("the method lattice"),
        (MethodName::Lattice, true) => Some("the method conforming"),
        (MethodName::Lattice, false) => None,
        (MethodName::Conforming, _) => Some("another method"),
    };
    let others = match (options.itz, method) {
        (ItzForm::Solid, Some(method)) => format!(", {method}, or itz none"),
        (ItzForm::Solid, None) => ", or itz none".to_owned(),
        (ItzForm::Cohesive | ItzForm::Smeared | ItzForm::None, Some(method)) => format!(", or {method}"),
        (ItzForm::Cohesive | ItzForm::Smeared | ItzForm::None, None) => String::new(),
    };
    Ways { before, after: after.to_owned(), others }
}
