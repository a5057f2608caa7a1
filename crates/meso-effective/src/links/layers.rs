//! The bodies of a packing as nested convex layers, each with the values on both sides of its surface.

use crate::phases::PhaseValues;
use meso_collision::geometry::{Plane, Polyhedron};
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::aggregate::{Aggregate, Kind};
use meso_concrete::parallel;

/// A convex region whose surface separates two phases.
pub(crate) struct Layer {
    pub(super) surface: Polyhedron,
    pub(super) planes: Vec<Plane>,
    pub(super) aabb: Aabb,
    /// Value inside less the value outside.
    pub(super) change: f64,
    /// Resistance inside less the resistance outside; phases without a value have the mortar's.
    pub(super) resistance: f64,
    /// 1 where the inside has no value and the outside has one, -1 the other way round, else 0.
    pub(super) blocks: f64,
    /// Value of the body within its ITZ: the flux across a sphere's surface over the gradient along it.
    pub(super) body: f64,
}

impl Layer {
    /// All layers of `bodies`, the axes turned so that `last` becomes the third. A shell without trustworthy core counts as
    /// the aggregate.
    pub(crate) fn all(bodies: &[Aggregate], values: &PhaseValues, last: usize) -> Vec<Self> {
        let turn = |v: &Vec3| Vec3::new(v[(last + 1) % 3], v[(last + 2) % 3], v[last]);
        parallel::flat_map(bodies.len(), |number| Self::of(&bodies[number], values, &turn))
    }

    fn of(body: &Aggregate, values: &PhaseValues, turn: &impl Fn(&Vec3) -> Vec3) -> Vec<Self> {
        let surface = body.body.mapped(turn);
        let inside = values.of(body.kind);
        let layer =
            |surface: Polyhedron, outside: f64, within: f64| Self::new(surface, [outside, within], inside, values);
        if body.kind != Kind::Aggregate || body.itz_thickness_mm <= 0.0 || values.itz == inside {
            return vec![layer(surface, values.mortar, inside)];
        }
        match body.core() {
            Err(_) => vec![layer(surface, values.mortar, inside)],
            Ok(None) => vec![layer(surface, values.mortar, values.itz)],
            Ok(Some(core)) => {
                let shell = layer(surface, values.mortar, values.itz);
                vec![shell, layer(core.mapped(turn), values.itz, inside)]
            }
        }
    }

    fn new(surface: Polyhedron, [outside, within]: [f64; 2], body: f64, values: &PhaseValues) -> Self {
        let resistance = |value: f64| 1.0 / if value > 0.0 { value } else { values.mortar };
        let blocked = |value: f64| f64::from(u8::from(value <= 0.0));
        Self {
            planes: surface.planes().collect(),
            aabb: surface.aabb(),
            change: within - outside,
            resistance: resistance(within) - resistance(outside),
            blocks: blocked(within) - blocked(outside),
            body,
            surface,
        }
    }
}
