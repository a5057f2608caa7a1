//! Bounds on the effective value of a mixture, from volume fractions.

use serde::Serialize;

/// Bounds of Voigt, Reuss, and Hashin and Shtrikman (J. Appl. Phys. 33, 1962, 3125).
///
/// Bounds of Hashin and Shtrikman hold for an isotropic mixture; one direction of a small specimen may cross them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PropertyBounds {
    /// Phases in series.
    pub reuss: f64,
    /// Lower bound of an isotropic mixture.
    pub hashin_shtrikman_lower: f64,
    /// Upper bound of an isotropic mixture.
    pub hashin_shtrikman_upper: f64,
    /// Phases in parallel.
    pub voigt: f64,
}

impl PropertyBounds {
    /// Bounds of phases given by value and volume fraction.
    pub fn of(phases: &[(f64, f64)]) -> Self {
        let (least, largest) = extremes(phases);
        Self::shifted(phases, 2.0 * least, 2.0 * largest)
    }

    /// Bounds of bulk and shear modulus, from bulk modulus, shear modulus and volume fraction (Walpole, J. Mech. Phys. Solids 14,
    /// 1966, 151: the extremes may belong to different phases).
    pub(crate) fn of_moduli(phases: &[[f64; 3]]) -> [Self; 2] {
        let of = |which: usize| phases.iter().map(|phase| (phase[which], phase[2])).collect::<Vec<_>>();
        let (bulk, shear) = (of(0), of(1));
        let ((soft_bulk, stiff_bulk), (soft, stiff)) = (extremes(&bulk), extremes(&shear));
        let shift = |k: f64, g: f64| if g > 0.0 { g * (9.0 * k + 8.0 * g) / (6.0 * (k + 2.0 * g)) } else { 0.0 };
        [
            Self::shifted(&bulk, 4.0 / 3.0 * soft, 4.0 / 3.0 * stiff),
            Self::shifted(&shear, shift(soft_bulk, soft), shift(stiff_bulk, stiff)),
        ]
    }

    /// Harmonic means of values that are shifted by those of a softest and of a stiffest surrounding.
    fn shifted(phases: &[(f64, f64)], low: f64, high: f64) -> Self {
        let present = || phases.iter().filter(|(_, fraction)| *fraction > 0.0);
        let mean = |shift: f64| {
            let sum: f64 = present().map(|(value, fraction)| fraction / (value + shift)).sum();
            if sum.is_finite() { 1.0 / sum - shift } else { 0.0 }
        };
        Self {
            reuss: mean(0.0),
            hashin_shtrikman_lower: mean(low),
            hashin_shtrikman_upper: mean(high),
            voigt: present().map(|(value, fraction)| value * fraction).sum(),
        }
    }
}

/// Whether volume fractions are those of bodies within the specimen: bodies that reach beyond leave the mortar less than nothing, and
/// have no bounds.
pub(crate) fn are_within(mut fractions: impl Iterator<Item = f64>) -> bool {
    fractions.all(|fraction| fraction >= -ROUNDING)
}

/// Crossings below this share of a value are rounding: links have single precision.
const ROUNDING: f64 = 1e-6;

impl PropertyBounds {
    /// A sentence on a value that lies beyond a bound of Hashin and Shtrikman, or whose error reaches beyond it.
    pub(crate) fn remark(&self, name: &str, value: f64, error: f64, remedy: &str) -> Option<String> {
        let (low, high) = (self.hashin_shtrikman_lower, self.hashin_shtrikman_upper);
        // The nearer bound, and the distance from it into the bounds' interval.
        let (side, bound, inside) =
            if value - low < high - value { ("lower", low, value - low) } else { ("upper", high, high - value) };
        let scale = value.abs().max(bound);
        if inside - error >= -ROUNDING * scale {
            return None;
        }
        let percent = |part: f64| format!("{:.2} %", 100.0 * part / scale);
        let (distance, error_share) = (percent(inside.abs()), percent(error));
        Some(if inside >= 0.0 {
            format!(
                "the {side} Hashin-Shtrikman bound, {distance} from the {name}, is within its error of {error_share}; {remedy}"
            )
        } else if -inside <= error {
            format!(
                "the {name} is {distance} beyond the {side} Hashin-Shtrikman bound, within its error of {error_share}; {remedy}"
            )
        } else {
            let holds = "the bound holds for isotropic specimens, and the error is an estimate";
            format!(
                "the {name} is {distance} beyond the {side} Hashin-Shtrikman bound, and its error is {error_share}; {holds}"
            )
        })
    }
}

/// Least and largest value of the phases that there are.
fn extremes(phases: &[(f64, f64)]) -> (f64, f64) {
    let present = || phases.iter().filter(|(_, fraction)| *fraction > 0.0).map(|(value, _)| *value);
    (present().fold(f64::INFINITY, f64::min), present().fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use super::PropertyBounds;

    #[test]
    fn the_upper_bound_of_impermeable_grains_is_maxwell() {
        let bounds = PropertyBounds::of(&[(1.0, 0.6), (0.0, 0.4), (5.0, 0.0)]);
        assert!((bounds.hashin_shtrikman_upper - 2.0 * 0.6 / 2.4).abs() < 1e-15, "{bounds:?}");
        assert_eq!((bounds.reuss, bounds.hashin_shtrikman_lower, bounds.voigt), (0.0, 0.0, 0.6));
    }

    #[test]
    fn a_value_whose_error_crosses_a_bound_is_remarked_on() {
        let bounds = PropertyBounds::of(&[(1.0, 0.5), (10.0, 0.5)]);
        let (low, high) = (bounds.hashin_shtrikman_lower, bounds.hashin_shtrikman_upper);
        let remark =
            |value: f64, error: f64| bounds.remark("value", value, error, "halve the voxel size").unwrap_or_default();
        assert_eq!(remark((low + high) / 2.0, 0.1), "");
        assert!(
            remark(low * 1.01, low * 0.02).contains("lower Hashin-Shtrikman bound, 0.99 % from the value, is within")
        );
        assert!(remark(low * 0.99, low * 0.02).contains("is 1.00 % beyond the lower Hashin-Shtrikman bound, within"));
        assert!(
            remark(high * 1.01, high * 0.001)
                .contains("beyond the upper Hashin-Shtrikman bound, and its error is 0.10 %")
        );
        let equal = PropertyBounds::of(&[(2.0, 0.5), (2.0, 0.5)]);
        assert_eq!(equal.remark("value", 2.0 + 1e-9, 0.0, ""), None);
    }

    #[test]
    fn bounds_are_in_order() {
        let b = PropertyBounds::of(&[(1.0, 0.5), (3.0, 0.3), (10.0, 0.2)]);
        let order = [b.reuss, b.hashin_shtrikman_lower, b.hashin_shtrikman_upper, b.voigt];
        assert!(order.windows(2).all(|pair| pair[0] < pair[1]), "{b:?}");
    }

    /// Hashin, J. Mech. Phys. Solids 11, 1963, 127: bulk modulus of coated spheres, which is the lower bound of stiff cores.
    #[test]
    fn the_lower_bulk_bound_is_that_of_coated_spheres() {
        let ([k, g], [core_k, core_g], c) = ([10.0, 6.0], [40.0, 25.0], 0.3);
        let [bulk, shear] = PropertyBounds::of_moduli(&[[k, g, 1.0 - c], [core_k, core_g, c]]);
        let spheres = k + c * (core_k - k) / (1.0 + (1.0 - c) * (core_k - k) / (k + 4.0 / 3.0 * g));
        assert!((bulk.hashin_shtrikman_lower - spheres).abs() < 1e-12, "{bulk:?}");
        let hashin = g + c / (1.0 / (core_g - g) + 6.0 * (k + 2.0 * g) * (1.0 - c) / (5.0 * g * (3.0 * k + 4.0 * g)));
        assert!((shear.hashin_shtrikman_lower - hashin).abs() < 1e-12, "{shear:?}");
    }
}
