//! Voids and fibres: sizes as in the spec.

use super::{Finding, rounding};
use meso_collision::math::longest_distance;
use meso_concrete::aggregate::{Aggregate, Inclusions, Kind, Voids};
use std::f64::consts::PI;

/// A void has the volume of a sphere of one of the diameters asked for; a fibre has the volume and the length of the
/// cylinder.
pub(super) fn size(asked: &Inclusions<'_>, body: &Aggregate) -> Option<Finding> {
    let volume = body.body.volume();
    let reason = match (body.kind, asked.voids, asked.fibres) {
        (Kind::Void, Some(voids), _) => {
            let [low, high] = voids.limits_mm();
            let diameter = Voids::diameter_of(volume);
            let rounding = rounding(diameter);
            let fits = diameter >= low - rounding && diameter <= high + rounding;
            (!fits).then(|| format!("its sphere has a diameter of {diameter} mm, not {low} to {high} mm"))
        }
        (Kind::Fibre, _, Some(fibres)) => {
            let longest = longest_distance(body.body.vertices());
            let diameter = (volume / fibres.length_mm * 4.0 / PI).sqrt();
            // Ends far from the centre are rounded sideways, too.
            let rounding = rounding(longest);
            let fits =
                (longest - fibres.longest()).abs() <= rounding && (diameter - fibres.diameter_mm).abs() <= rounding;
            (!fits).then(|| format!("its diagonal is {longest} mm and its cylinder's diameter {diameter} mm"))
        }
        _ => Some(format!("the spec asks for no {}", body.kind.plural())),
    };
    Some(Finding::Shape { body: body.id, reason: reason? })
}
