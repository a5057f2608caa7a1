//! The bodies of a packing as nested regions, each with the phases on both sides of its surface.

use meso_collision::geometry::Polyhedron;
use meso_collision::math::Vec3;
use meso_concrete::aggregate::Aggregate;
use meso_concrete::aggregate::Kind;
use meso_concrete::{Phase, PhaseNames, own_tables, parallel};
use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;

/// A value for each phase.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields, remote = "Self", bound(deserialize = "T: Default + Deserialize<'de>"))]
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
    /// The specimen's own phases, by their names.
    #[serde(skip)]
    pub own: BTreeMap<String, T>,
}

impl<'de, T: Default + Deserialize<'de>> Deserialize<'de> for ByPhase<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        own_tables::read(deserializer, |common| Self::deserialize(common)).map(|(common, own)| Self { own, ..common })
    }
}

impl<T: Copy + Default> ByPhase<T> {
    /// Value of one of the `phases`, all of which have one.
    pub(crate) fn of(&self, phase: Phase, phases: &PhaseNames) -> T {
        match phase {
            Phase::Mortar => self.mortar,
            Phase::Itz => self.itz,
            Phase::Aggregate => self.aggregate,
            Phase::Void => self.void,
            Phase::Fibre => self.fibre,
            Phase::Own(_) => self.own.get(phases.name(phase)).copied().unwrap_or_default(),
        }
    }

    /// Value of a phase, by its name.
    pub fn phase_mut(&mut self, name: &str) -> Option<&mut T> {
        match name {
            "mortar" => Some(&mut self.mortar),
            "itz" => Some(&mut self.itz),
            "aggregate" => Some(&mut self.aggregate),
            "void" => Some(&mut self.void),
            "fibre" => Some(&mut self.fibre),
            own => self.own.get_mut(own),
        }
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
        let nested = body.nested();
        let mut all: Vec<Self> = nested.first().map_or_else(Vec::new, |outer| Self::of_two(outer, has_itz, turn));
        all.extend(nested.windows(2).map(|layers| Self {
            body: layers[1].body.mapped(turn),
            outside: layers[0].phase(),
            within: layers[1].phase(),
            kind: body.phase(),
        }));
        all
    }

    /// The surfaces of a body and its ITZ.
    fn of_two(body: &Aggregate, has_itz: bool, turn: &impl Fn(&Vec3) -> Vec3) -> Vec<Self> {
        let kind = body.phase();
        let new = |body: Polyhedron, outside, within| Self { body, outside, within, kind };
        let outer = body.body.mapped(turn);
        if body.kind != Kind::Aggregate || body.itz_thickness_mm <= 0.0 || !has_itz {
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
