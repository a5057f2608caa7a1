//! Bounds on the effective value of a mixture, from volume fractions.

use serde::Serialize;

/// Bounds of Voigt, Reuss, and Hashin and Shtrikman (J. Appl. Phys. 33, 1962, 3125).
///
/// Those of Hashin and Shtrikman hold for an isotropic mixture; one direction of a small specimen may cross them.
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
        let present = || phases.iter().filter(|(_, fraction)| *fraction > 0.0);
        let least = present().map(|(value, _)| *value).fold(f64::INFINITY, f64::min);
        let largest = present().map(|(value, _)| *value).fold(0.0, f64::max);
        let mean = |shift: f64| {
            let sum: f64 = present().map(|(value, fraction)| fraction / (value + shift)).sum();
            if sum.is_finite() { 1.0 / sum - shift } else { 0.0 }
        };
        Self {
            reuss: mean(0.0),
            hashin_shtrikman_lower: mean(2.0 * least),
            hashin_shtrikman_upper: mean(2.0 * largest),
            voigt: present().map(|(value, fraction)| value * fraction).sum(),
        }
    }
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
    fn bounds_are_in_order() {
        let b = PropertyBounds::of(&[(1.0, 0.5), (3.0, 0.3), (10.0, 0.2)]);
        let order = [b.reuss, b.hashin_shtrikman_lower, b.hashin_shtrikman_upper, b.voigt];
        assert!(order.windows(2).all(|pair| pair[0] < pair[1]), "{b:?}");
    }
}
