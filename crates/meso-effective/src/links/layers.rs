//! Surfaces of bodies with the values on both sides.

use crate::phases::PhaseValues;
use crate::surfaces::Surface;
use meso_collision::geometry::{BodyForm, Plane, Polyhedron, Triangles};
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::aggregate::Aggregate;
use meso_concrete::{Phase, PhaseNames};

/// A region whose surface separates two phases.
pub(crate) struct Layer {
    pub(super) surface: Polyhedron,
    pub(super) planes: Vec<Plane>,
    /// The triangles of a body with dents, whose planes bound nothing.
    pub(super) dents: Option<Triangles>,
    pub(super) aabb: Aabb,
    /// Value inside.
    pub(super) within: f64,
    /// Value inside less the value outside.
    pub(super) change: f64,
    /// Resistance inside less the resistance outside; phases without a value have the mortar's.
    pub(super) resistance: f64,
    /// 1 where the inside has no value and the outside has one, -1 the other way round, else 0.
    pub(super) blocks: f64,
    /// Value of the body within its ITZ: the flux across a sphere's surface over the gradient along it.
    pub(super) body: f64,
    /// The larger value over the smaller one.
    pub(super) contrast: f64,
}

impl Layer {
    /// All layers of `bodies`, the axes turned so that `last` becomes the third.
    pub(crate) fn all(bodies: &[Aggregate], values: &PhaseValues, names: &PhaseNames, last: usize) -> Vec<Self> {
        let turn = |v: &Vec3| Vec3::new(v[(last + 1) % 3], v[(last + 2) % 3], v[last]);
        let has_itz = values.of_aggregates(names).iter().any(|aggregate| *aggregate != values.itz);
        // A core within an insulating shell carries nothing, whatever its value.
        // Shells of one value have no surface between them.
        let counts = |&Surface { outside, within, .. }: &Surface| {
            let is_inside = outside.is_aggregate() && values.of(outside, names) == values.of(within, names);
            !is_inside && (values.itz > 0.0 || outside != Phase::Itz)
        };
        let surfaces = Surface::all(bodies, has_itz, &turn).into_iter().filter(counts);
        surfaces.map(|surface| Self::new(surface, values, names)).collect()
    }

    fn new(surface: Surface, values: &PhaseValues, names: &PhaseNames) -> Self {
        let (outside, within) = (values.of(surface.outside, names), values.of(surface.within, names));
        let resistance = |value: f64| 1.0 / if value > 0.0 { value } else { values.mortar };
        let blocked = |value: f64| f64::from(u8::from(value <= 0.0));
        Self {
            planes: surface.body.planes().collect(),
            dents: (surface.body.form() == BodyForm::Surface).then(|| surface.body.surface()),
            aabb: surface.body.aabb(),
            within,
            change: within - outside,
            resistance: resistance(within) - resistance(outside),
            blocks: blocked(within) - blocked(outside),
            body: values.of(surface.kind, names),
            contrast: if within == outside { 1.0 } else { within.max(outside) / within.min(outside) },
            surface: surface.body,
        }
    }
}
