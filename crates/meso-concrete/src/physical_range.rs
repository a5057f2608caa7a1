//! Physical ranges: a value outside its range is refused with the units in which it would lie inside.

/// Range of a quantity in our own unit, beside other units in which users have it.
#[derive(Clone, Copy, Debug)]
pub struct PhysicalRange {
    /// Smallest value that any concrete has.
    pub least: f64,
    /// Largest value that any concrete has.
    pub most: f64,
    /// Our unit; empty for a ratio.
    pub unit: &'static str,
    /// Other units, and the size of each in ours.
    pub others: &'static [(&'static str, f64)],
}

/// Share of the largest value below which nobody means a value: -0.02 is a shrinkage in per cent, not in microstrain.
const SLIGHT: f64 = 2e-4;

impl PhysicalRange {
    /// Units of stress beside MPa.
    pub const STRESSES: &[(&str, f64)] = &[("GPa", 1e3), ("Pa", 1e-6), ("kPa", 1e-3), ("psi", 6.894757e-3)];
    /// Units of strain beside the ratio of lengths.
    pub const STRAINS: &[(&str, f64)] = &[("%", 1e-2), ("per mille", 1e-3), ("microstrain", 1e-6)];

    /// Strains without stress: no phase of concrete shrinks by 0.5 %, and per cent of shrinkage lie below that.
    pub const FREE_STRAIN: Self = Self { least: -0.005, most: 0.02, unit: "", others: Self::STRAINS };
    /// Young's moduli of the phases of a composite, of which voids and soft ones have little; nothing is stiffer.
    pub const MODULUS_OF_A_PHASE: Self = Self { least: 0.0, most: 2e6, unit: "MPa", others: Self::STRESSES };

    /// Whether the value lies in the range; NaN does not.
    pub fn has(&self, value: f64) -> bool {
        (self.least..=self.most).contains(&value)
    }

    /// The reason why a value lies outside: the range, and the value in our unit for every unit that would fit.
    pub fn refusal(&self, value: f64) -> String {
        let Self { least, most, unit, others } = self;
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        let is_meant = |value: f64| self.has(value) && value.abs() >= SLIGHT * most;
        let fits = others.iter().filter(|(_, size)| is_meant(value * size));
        let fits: Vec<String> =
            fits.map(|(name, size)| format!("{} {name} are {}{unit}", digits(value), digits(value * size))).collect();
        let fits = if fits.is_empty() { String::new() } else { format!(": {}", fits.join(", ")) };
        format!("it must be {} to {}{unit}{fits}", digits(*least), digits(*most))
    }
}

/// A number of at most 6 digits.
fn digits(value: f64) -> String {
    let short = format!("{value:.5e}").parse::<f64>().unwrap_or(value);
    if short == 0.0 || (1e-4..1e7).contains(&short.abs()) { format!("{short}") } else { format!("{short:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STRESS: PhysicalRange =
        PhysicalRange { least: 1.0, most: 300.0, unit: "MPa", others: PhysicalRange::STRESSES };
    const STRAIN: PhysicalRange = PhysicalRange { least: -0.005, most: 0.02, unit: "", others: PhysicalRange::STRAINS };

    #[test]
    fn a_value_outside_is_named_with_every_unit_that_would_fit() {
        assert_eq!(STRESS.refusal(3.5e7), "it must be 1 to 300 MPa: 3.5e7 Pa are 35 MPa");
        assert_eq!(STRESS.refusal(5000.0), "it must be 1 to 300 MPa: 5000 kPa are 5 MPa, 5000 psi are 34.4738 MPa");
        assert_eq!(STRESS.refusal(0.035), "it must be 1 to 300 MPa: 0.035 GPa are 35 MPa");
        assert_eq!(STRAIN.refusal(-0.02), "it must be -0.005 to 0.02: -0.02 % are -0.0002, -0.02 per mille are -2e-5");
    }

    #[test]
    fn no_unit_makes_a_value_of_what_is_none() {
        for value in [f64::NAN, f64::INFINITY, -1.0, 1e30] {
            assert!(!STRESS.has(value));
            assert_eq!(STRESS.refusal(value), "it must be 1 to 300 MPa");
        }
        assert!(STRESS.has(1.0) && STRESS.has(300.0) && !STRESS.has(300.1));
    }
}
