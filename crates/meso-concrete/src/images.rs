//! The images of aggregates in periodic specimens: whole, or cut at the faces.

use crate::aggregate::Aggregate;
use crate::parallel;
use crate::specimen::{Period, Specimen};
use meso_collision::geometry::clipped;
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
    /// Every image that reaches into the specimen, cut at its faces: opposite faces match.
    Cut,
}

impl Images {
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
            let part = clipped(&aggregate.body, &domain.moved(&-shift))?;
            let body = if self == Self::Cut { part } else { aggregate.body.clone() };
            Some(Aggregate { body: body.translated(&shift), ..aggregate.clone() })
        };
        period.shifts(&aggregate.body.aabb(), domain).into_iter().filter_map(image).collect()
    }
}

/// The specimen's box, unbounded where it has walls: aggregates inside walls are not cut there.
fn open_at_walls(specimen: &Specimen) -> Aabb {
    specimen.period().mixed(&specimen.aabb(), &Aabb::everywhere())
}

/// The aggregates, then their whole images whose boxes come within `margin` mm of the specimen's: all that a point, a
/// line or an aggregate in the specimen may meet.
pub fn near(aggregates: &[Aggregate], specimen: &Specimen, margin: f64) -> Vec<Aggregate> {
    let (period, domain) = (specimen.period(), open_at_walls(specimen));
    if period.is_none() {
        return aggregates.to_vec();
    }
    let domain = domain.grown(margin);
    let images = |aggregate: &Aggregate| -> Vec<Aggregate> {
        let shifts = period.shifts(&aggregate.body.aabb(), &domain).into_iter().filter(|shift| *shift != Vec3::zeros());
        shifts.map(|shift| Aggregate { body: aggregate.body.translated(&shift), ..aggregate.clone() }).collect()
    };
    let images = parallel::flat_map(aggregates.len(), |number| images(&aggregates[number]));
    aggregates.iter().cloned().chain(images).collect()
}

/// Values made of bodies, found by the bodies' ids; images have the id of their body.
pub struct ById<T>(Vec<(u32, T)>);

impl<T> ById<T> {
    /// Applies `made` to each of `bodies`. Values of one id keep the order of their bodies.
    pub fn new<'a>(bodies: &'a [Aggregate], made: impl Fn(&'a Aggregate) -> T) -> Self {
        let mut by_id: Vec<(u32, T)> = bodies.iter().map(|body| (body.id, made(body))).collect();
        by_id.sort_by_key(|body| body.0);
        Self(by_id)
    }

    /// Iterates over the values of body `id` and of its images.
    pub fn images(&self, id: u32) -> impl Iterator<Item = &T> {
        let start = self.0.partition_point(|body| body.0 < id);
        self.0[start..].iter().take_while(move |body| body.0 == id).map(|(_, made)| made)
    }
}
