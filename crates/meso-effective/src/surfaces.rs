//! The bodies of a packing as nested regions, each with the phases on both sides of its surface.

use meso_collision::geometry::Polyhedron;
use meso_collision::math::Vec3;
use meso_concrete::aggregate::Aggregate;
use meso_concrete::{Phase, parallel};
use serde::{Deserialize, Serialize};

/// A value for each phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ByPhase<T> {
    /// Mortar.
    pub mortar: T,
    /// Interfacial transition zone.
    pub itz: T,
    /// Aggregates within their ITZ.
    pub aggregate: T,
    /// Voids.
    pub void: T,
    /// Fibres.
    pub fibre: T,
}

impl<T: Copy> ByPhase<T> {
    /// Value of a phase.
    pub(crate) fn of(&self, phase: Phase) -> T {
        [self.mortar, self.itz, self.aggregate, self.void, self.fibre][phase as usize]
    }

    /// Value of a phase, by its name.
    pub fn phase_mut(&mut self, name: &str) -> Option<&mut T> {
        let Self { mortar, itz, aggregate, void, fibre } = self;
        let all = [mortar, itz, aggregate, void, fibre];
        all.into_iter().zip(Phase::ALL).find(|(_, phase)| phase.name() == name).map(|(value, _)| value)
    }
}

/// A region whose surface separates two phases.
pub(crate) struct Surface {
    pub(crate) body: Polyhedron,
    pub(crate) outside: Phase,
    pub(crate) within: Phase,
    /// Phase of the body within its ITZ.
    pub(crate) kind: Phase,
}

impl Surface {
    /// All surfaces of `bodies`, vertices mapped by `turn`. A shell without trustworthy core counts as the aggregate; none is
    /// made where `has_itz` is false.
    pub(crate) fn all(bodies: &[Aggregate], has_itz: bool, turn: &(impl Fn(&Vec3) -> Vec3 + Sync)) -> Vec<Self> {
        parallel::flat_map(bodies.len(), |number| Self::of(&bodies[number], has_itz, turn))
    }

    fn of(body: &Aggregate, has_itz: bool, turn: &impl Fn(&Vec3) -> Vec3) -> Vec<Self> {
        let kind = Phase::of(body.kind);
        let new = |body: Polyhedron, outside, within| Self { body, outside, within, kind };
        let outer = body.body.mapped(turn);
        if kind != Phase::Aggregate || body.itz_thickness_mm <= 0.0 || !has_itz {
            return vec![new(outer, Phase::Mortar, kind)];
        }
        match body.inner_surface() {
            Err(_) => vec![new(outer, Phase::Mortar, kind)],
            Ok(None) => vec![new(outer, Phase::Mortar, Phase::Itz)],
            Ok(Some(core)) => {
                vec![new(outer, Phase::Mortar, Phase::Itz), new(core.mapped(turn), Phase::Itz, kind)]
            }
        }
    }
}
