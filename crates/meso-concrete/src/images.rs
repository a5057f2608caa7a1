//! The images of aggregates in periodic specimens: whole, or cut at the faces.

use crate::aggregate::Aggregate;
use crate::parallel;
use crate::specimen::{Period, Specimen};
use meso_collision::geometry::{BodyForm, clipped};
use meso_collision::math::{Aabb, Vec3};
use serde::{Deserialize, Serialize};

/// How aggregates that cross a face of a periodic specimen are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Images {
    /// Each aggregate once, whole, with its middle in the specimen.
    #[default]
    None,
    /// Every image that reaches into the specimen, whole.
    Whole,
    /// Every image that reaches into the specimen, cut at its faces: opposite faces match. Aggregates with dents, balls and ellipsoids
    /// stay whole.
    Cut,
}

impl Images {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Whole => "whole",
            Self::Cut => "cut",
        }
    }

    /// The aggregates as asked for; images keep the id of their aggregate. Without periods, the aggregates themselves.
    pub fn of(self, aggregates: &[Aggregate], specimen: &Specimen) -> Vec<Aggregate> {
        let (period, domain) = (specimen.period(), open_at_walls(specimen));
        if self == Self::None || period.is_none() {
            return aggregates.to_vec();
        }
        parallel::flat_map(aggregates.len(), |number| self.of_one(&aggregates[number], &period, &domain))
    }

    fn of_one(self, aggregate: &Aggregate, period: &Period, domain: &Aabb) -> Vec<Aggregate> {
        let image = |shift: Vec3| {
            // Cut before translation, so that the parts on both sides of a face have the same corners there.
            let part = || clipped(&aggregate.body, &domain.moved(&-shift));
            let body = match aggregate.body.form() {
                BodyForm::Hull if self == Self::Cut => part()?.translated(&shift),
                // The facets of a round body lie within it, and may miss what it reaches.
                BodyForm::Round(_) => aggregate.body.translated(&shift),
                BodyForm::Hull | BodyForm::Surface => part().map(|_| aggregate.body.translated(&shift))?,
            };
            Some(Aggregate { body, ..aggregate.clone() })
        };
        period.shifts(&aggregate.body.aabb(), domain).into_iter().filter_map(image).collect()
    }
}

/// The specimen's box, unbounded where it has walls: aggregates inside walls are not cut there.
fn open_at_walls(specimen: &Specimen) -> Aabb {
    specimen.period().mixed(&specimen.aabb(), &Aabb::everywhere())
}

/// The aggregates, then their whole images whose boxes come within `margin` mm of the specimen's box.
///
/// A point, a line or an aggregate in the specimen meets only these.
pub fn near(aggregates: &[Aggregate], specimen: &Specimen, margin: f64) -> Vec<Aggregate> {
    numbered(aggregates, specimen, margin).into_iter().map(|(_, body)| body).collect()
}

/// The bodies that [`near`] returns, each with the index of its aggregate.
pub fn numbered(aggregates: &[Aggregate], specimen: &Specimen, margin: f64) -> Vec<(u32, Aggregate)> {
    let (period, domain) = (specimen.period(), open_at_walls(specimen).grown(margin));
    let own = (0..).zip(aggregates.iter().cloned());
    if period.is_none() {
        return own.collect();
    }
    let images = |number: usize| -> Vec<(u32, Aggregate)> {
        let aggregate = &aggregates[number];
        let shifts = period.shifts(&aggregate.body.aabb(), &domain).into_iter().filter(|shift| *shift != Vec3::zeros());
        let image = |shift| Aggregate { body: aggregate.body.translated(&shift), ..aggregate.clone() };
        shifts.map(|shift| (number as u32, image(shift))).collect()
    };
    own.chain(parallel::flat_map(aggregates.len(), images)).collect()
}
