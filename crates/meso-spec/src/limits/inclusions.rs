//! Voids and fibres that cannot be, named before any work starts.

use super::grading::grading;
use super::{Checked, MAX_AGGREGATES, MAX_LENGTH_MM, MIN_LENGTH_MM, in_order, length, share, within};
use crate::messages::{at_most, number};
use crate::{Spec, SpecError};
use meso_collision::math::Vec3;
use meso_concrete::aggregate::{Cone, Fibres, Voids};

/// Straight rods that lie at random fill a space to 5.4 times their diameter over their length, and no further: half
/// of the mean number of contacts of a rod (A. P. Philipse, Langmuir 12 (1996) 1127, for length over diameter from
/// about 15). Later experiments count fewer, 9.8 (A. Wouterse, S. Luding and A. P. Philipse, Granular Matter 11 (2009)
/// 169); the larger number refuses nothing that may be.
pub(crate) const RANDOM_RODS: f64 = 5.4;

/// Checks `[voids]` and `[fibres]` alone, then with all else the spec asks for.
pub(super) fn check(spec: &Spec) -> Checked {
    if let Some(voids) = &spec.voids {
        check_voids(voids)?;
        let [least, largest] = match voids.grading {
            Some(_) => ["voids.grading.d_min_mm", "voids.grading.d_max_mm"],
            None => [DIAMETER; 2],
        };
        longest_fits(spec, largest, voids.longest())?;
        count(spec, least, "voids", voids.limits_mm()[0], voids.per_mm3())?;
    }
    if let Some(fibres) = &spec.fibres {
        check_fibres(fibres)?;
        longest_fits(spec, "fibres.length_mm", fibres.longest())?;
        count(spec, "fibres.diameter_mm", "fibres", fibres.diameter_mm, fibres.fraction / fibres.volume())?;
    }
    sum(spec)
}

const DIAMETER: &str = "voids.diameter_mm";

fn check_voids(voids: &Voids) -> Checked {
    share("voids.fraction", "void", voids.fraction)?;
    match (&voids.diameter_mm, &voids.grading) {
        (Some(limits), None) => {
            limits.iter().try_for_each(|&diameter| length(DIAMETER, diameter))?;
            in_order(DIAMETER, *limits)
        }
        (None, Some(own)) => grading(own, MIN_LENGTH_MM).map_err(|error| error.within("voids")),
        (both, _) => {
            let found =
                if both.is_some() { "stands beside voids.grading" } else { "is missing, and so is voids.grading" };
            Err(SpecError::value(DIAMETER, format!("{found}; give one of the two")))
        }
    }
}

fn check_fibres(fibres: &Fibres) -> Checked {
    share("fibres.fraction", "fibre", fibres.fraction)?;
    length("fibres.diameter_mm", fibres.diameter_mm)?;
    length("fibres.length_mm", fibres.length_mm)?;
    let (diameter, long) = (number(fibres.diameter_mm), number(fibres.length_mm));
    if fibres.length_mm <= fibres.diameter_mm {
        let message = format!("is {long} but fibres.diameter_mm is {diameter}; a fibre is longer than it is thick");
        return Err(SpecError::value("fibres.length_mm", message));
    }
    if let Some(cone) = &fibres.orientation {
        return check_cone(cone);
    }
    let most = RANDOM_RODS * fibres.diameter_mm / fibres.length_mm;
    if fibres.fraction > most {
        let message = format!(
            "is {} but straight fibres {long} long and {diameter} thick fill at most {most:.3} at random; \
             take fewer, shorter or thicker fibres",
            number(fibres.fraction)
        );
        return Err(SpecError::value("fibres.fraction", message));
    }
    Ok(())
}

fn check_cone(cone: &Cone) -> Checked {
    const KEY: &str = "fibres.orientation.direction";
    cone.direction.iter().try_for_each(|&x| within(KEY, x, -MAX_LENGTH_MM, MAX_LENGTH_MM))?;
    if Vec3::from(cone.direction).norm() < MIN_LENGTH_MM {
        return Err(SpecError::value(KEY, "is [0, 0, 0]; it must have a length, as [0, 0, 1] has"));
    }
    within("fibres.orientation.within_degrees", cone.within_degrees, 0.0, 90.0)
}

/// A body `longest` mm long fits between the walls, and does not meet its own image.
fn longest_fits(spec: &Spec, key: &str, longest: f64) -> Checked {
    let placement = &spec.placement;
    let inner = spec.specimen.container().width() - 2.0 * placement.wall_gap_mm;
    let period = spec.specimen.period();
    let repeat = (0..3).filter_map(|axis| period.along(axis)).fold(f64::INFINITY, f64::min) - placement.min_gap_mm;
    if longest < inner.min(repeat) {
        return Ok(());
    }
    let why = if inner <= repeat {
        format!("the specimen has only {} mm of room", at_most(inner))
    } else {
        format!("the specimen is periodic after {}, and they would meet their own images", number(repeat))
    };
    let message = format!(
        "makes bodies {} long but {why}; take smaller ones or a larger specimen",
        number((longest * 1e3).round() / 1e3)
    );
    Err(SpecError::value(key, message))
}

fn count(spec: &Spec, key: &str, what: &str, smallest: f64, per_mm3: f64) -> Checked {
    let count = per_mm3 * spec.specimen.volume();
    if count <= MAX_AGGREGATES {
        return Ok(());
    }
    let message = format!(
        "is {} at the least, which makes about {count:.1e} {what} in this specimen; at most {MAX_AGGREGATES:.0e} are \
         accepted: raise it, or take a smaller specimen",
        number(smallest)
    );
    Err(SpecError::value(key, message))
}

/// All phases together leave space for the mortar.
fn sum(spec: &Spec) -> Checked {
    let [voids, fibres] = spec.inclusions().fractions();
    let all = spec.fraction + voids + fibres;
    if all < 1.0 {
        return Ok(());
    }
    let message = format!(
        "is {}; with {} of voids and {} of fibres that makes {}, and all together must stay below 1",
        number(spec.fraction),
        number(voids),
        number(fibres),
        number(all)
    );
    Err(SpecError::value("fraction", message))
}
