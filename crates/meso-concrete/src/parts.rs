//! Bodies inside a specimen, borrowed from whoever owns them.

use crate::aggregate::Aggregate;
use crate::parallel;
use crate::phase::PhaseNames;
use crate::specimen::Specimen;
use meso_collision::math::Aabb;
use std::borrow::Cow;

/// Disjoint bodies and the specimen that contains them: the input of meshing and of the figures on a mesh.
#[derive(Clone, Debug)]
pub struct Parts<'a> {
    /// Aggregates first, then voids and fibres; the body with id i is the i-th.
    pub bodies: Cow<'a, [Aggregate]>,
    /// The specimen around them.
    pub specimen: &'a Specimen,
    /// The phases, with the names of the specimen's own.
    pub phases: PhaseNames,
}

impl<'a, B: AsRef<[Aggregate]> + ?Sized> From<(&'a B, &'a Specimen)> for Parts<'a> {
    fn from((bodies, specimen): (&'a B, &'a Specimen)) -> Self {
        Self { bodies: Cow::Borrowed(bodies.as_ref()), specimen, phases: PhaseNames::default() }
    }
}

/// Makes caps of the triangles of aggregates with dents that lie exactly in an end of a cylinder, or in a side of a box across which
/// it does not repeat itself: they end there as grains do that a scan cuts, and have no ITZ there. Convex aggregates have none.
pub fn mark_caps(aggregates: &mut [Aggregate], specimen: &Specimen) {
    let mut sides = specimen.period().mixed(&Aabb::everywhere(), &specimen.aabb());
    if matches!(specimen, Specimen::Cylinder { .. }) {
        let everywhere = Aabb::everywhere();
        (sides.min.x, sides.min.y) = (everywhere.min.x, everywhere.min.y);
        (sides.max.x, sides.max.y) = (everywhere.max.x, everywhere.max.y);
    } else if !specimen.container().is_box() {
        return;
    }
    parallel::each_mut(aggregates, |_, aggregate| aggregate.body.mark_caps(&sides));
}
