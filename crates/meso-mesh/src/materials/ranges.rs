//! Ranges of the values in `[materials]`, which decks and the solver's laws check alike.
//!
//! A law that needs a narrower range, and a deck whose curves need more, add theirs.

use super::{Elastic, LawName, Materials, Strength};
use crate::cells::Phase;
use meso_concrete::{OutOfRange, PhaseNames, PhysicalRange, Ranges};

/// Checks values by their names in `[materials]`.
pub const MATERIALS: Ranges = Ranges("materials");

/// From foam to ten times lead; kg/mm3, g/cm3 and kg/m3 of stone lie above.
pub const DENSITY: PhysicalRange = PhysicalRange {
    least: 1e-11,
    most: 1e-7,
    unit: "tonne/mm3",
    others: &[("kg/m3", 1e-12), ("g/cm3", 1e-9), ("kg/mm3", 1e-3)],
};
/// From weak mortar to diamond; rubber has its own range below [`SOFTEST`].
pub const MODULUS: PhysicalRange =
    PhysicalRange { least: 300.0, most: 2e6, unit: "MPa", others: PhysicalRange::STRESSES };
/// Largest modulus of rubber and foam, MPa: GPa of mortar, stone and steel lie above.
const SOFTEST: f64 = 10.0;
/// Largest compressive strength of a phase softer than [`MODULUS`], over its modulus: soils have 0.001 to 0.05, and mortar of
/// 30 MPa with its modulus in GPa has 1.
const SOFT_STRENGTH: f64 = 0.1;
const COMPRESSIVE: PhysicalRange =
    PhysicalRange { least: 0.1, most: 1000.0, unit: "MPa", others: PhysicalRange::STRESSES };
/// Of soil. With values in GPa throughout, a mortar's tensile strength lies below its range.
const SOFT_COMPRESSIVE: PhysicalRange = PhysicalRange { least: 0.02, ..COMPRESSIVE };
const TENSILE: PhysicalRange = PhysicalRange { least: 0.01, most: 100.0, unit: "MPa", others: PhysicalRange::STRESSES };
/// Mortar with many fibres reaches 15 N/mm; N/m of plain mortar lie above.
const FRACTURE: PhysicalRange = PhysicalRange { least: 1e-4, most: 15.0, unit: "N/mm", others: ENERGIES };
const CRUSHING: PhysicalRange = PhysicalRange { least: 1e-3, most: 1000.0, unit: "N/mm", others: ENERGIES };
const PEAK_STRAIN: PhysicalRange = PhysicalRange { least: 1e-5, most: 0.1, unit: "", others: PhysicalRange::STRAINS };
/// Units of energy per area beside N/mm.
const ENERGIES: &[(&str, f64)] = &[("N/m", 1e-3)];

/// Least peak strain over the elastic strain of the strength: the curve rises from there.
const PEAK_OVER_ELASTIC: f64 = 1.05;

impl Materials {
    /// Checks the elastic values and densities of all phases.
    ///
    /// # Errors
    /// Names the first value outside its range.
    pub fn validate_elastic(&self) -> Result<(), OutOfRange> {
        // A law's own strength, where none is given, is that of concrete.
        let strength = self.mortar_strength.of(LawName::Meso).compressive_mpa;
        let mut all = self.by_name();
        all.try_for_each(|(name, values, ratio)| elastic(name, &values, ratio.map(|ratio| ratio * strength)))
    }

    /// Checks the strengths and energies of the mortar, and the shares of them that the ITZ and phases of one's own have.
    ///
    /// # Errors
    /// Names the first value outside its range.
    pub fn validate_strength(&self, law: LawName) -> Result<(), OutOfRange> {
        let given = self.mortar_strength.of(law);
        let compressive = if MODULUS.has(self.mortar.youngs_modulus_mpa) { COMPRESSIVE } else { SOFT_COMPRESSIVE };
        for (key, value, range) in [
            ("compressive_mpa", given.compressive_mpa, compressive),
            ("peak_strain", given.peak_strain, PEAK_STRAIN),
            ("tensile_mpa", given.tensile_mpa, TENSILE),
            ("fracture_energy_n_per_mm", given.fracture_energy_n_per_mm, FRACTURE),
            ("crushing_energy_n_per_mm", given.crushing_energy_n_per_mm, CRUSHING),
        ] {
            accept(range, format!("mortar_strength.{key}"), value)?;
        }
        let ratio = self.itz_strength_ratio;
        let met = ratio > 0.0 && ratio <= 1.0;
        MATERIALS.require("itz_strength_ratio", ratio, met, "it must lie above 0 and at most at 1")?;
        self.own.iter().filter_map(|(name, own)| Some((name, own.strength_ratio?))).try_for_each(|(name, ratio)| {
            let accepted = "it must be 0.01 to 100, over the mortar's strengths; without it the phase stays elastic";
            MATERIALS.require(format!("{name}.strength_ratio"), ratio, (0.01..=100.0).contains(&ratio), accepted)
        })
    }

    /// [Checks](Self::validate_peak_strain) all phases.
    ///
    /// # Errors
    /// As there.
    pub fn validate_peak_strains(&self, law: LawName) -> Result<(), OutOfRange> {
        let names = self.own_phases();
        let all = [Phase::Mortar, Phase::Itz].into_iter().chain(names.own());
        all.into_iter().try_for_each(|phase| self.validate_peak_strain(phase, &names, law))
    }

    /// Checks that the curve of one of the `phases` rises from its elastic strain to its peak strain; elastic phases have no curve.
    ///
    /// # Errors
    /// The mortar's peak strain is too small for the phase's strength and stiffness.
    pub fn validate_peak_strain(&self, phase: Phase, phases: &PhaseNames, law: LawName) -> Result<(), OutOfRange> {
        let Some(Strength { compressive_mpa, peak_strain, .. }) = self.strength(phase, phases, law) else {
            return Ok(());
        };
        let modulus = self.elastic(phase, phases).youngs_modulus_mpa;
        let least = PEAK_OVER_ELASTIC * compressive_mpa / modulus;
        if let Some(ratio) = self.own.get(phases.name(phase)).and_then(|own| own.strength_ratio) {
            let most = ratio * peak_strain / least;
            let accepted = format!(
                "it must be {most:.4} at most: {compressive_mpa} MPa over {modulus} MPa is an elastic strain of too much for \
                 mortar_strength.peak_strain, {peak_strain}"
            );
            let key = format!("{}.strength_ratio", phases.name(phase));
            return MATERIALS.require(key, ratio, peak_strain >= least, accepted);
        }
        let accepted = || {
            let elastic = format!("its strength of {compressive_mpa} MPa over its modulus of {modulus} MPa");
            format!("{} needs {least:.3e} or more, 5 % above its elastic strain: {elastic}", phases.set_name(phase))
        };
        MATERIALS.require("mortar_strength.peak_strain", peak_strain, peak_strain >= least, accepted())
    }

    /// Checks the values of a cohesive ITZ that concern it alone.
    ///
    /// # Errors
    /// Names the first value outside its range.
    pub fn validate_cohesive(&self) -> Result<(), OutOfRange> {
        MATERIALS.positive("cohesive_thickness_mm", self.cohesive_thickness_mm)?;
        let ratio = self.cohesive_shear_energy_ratio;
        let met = ratio >= 1.0 && ratio.is_finite();
        MATERIALS.require("cohesive_shear_energy_ratio", ratio, met, "it must be 1 or more")?;
        MATERIALS.positive("cohesive_mode_power", self.cohesive_mode_power)
    }

    /// Checks that a cohesive ITZ is thinner than [its limit](Self::cohesive_thickness_limit_mm), beyond which it cannot soften.
    ///
    /// # Errors
    /// The cohesive thickness is at its limit or above.
    pub fn validate_cohesive_softening(&self, law: LawName) -> Result<(), OutOfRange> {
        let (t, limit) = (self.cohesive_thickness_mm, self.cohesive_thickness_limit_mm(law));
        let accepted =
            format!("it must be below {limit:.3e}, where damage begins with less than the ITZ's fracture energy");
        MATERIALS.require("cohesive_thickness_mm", t, t < limit, accepted)
    }

    /// Checks the yield surface and flow against the limits of Abaqus' `*CONCRETE DAMAGED PLASTICITY`.
    ///
    /// # Errors
    /// Names the first value outside its range.
    pub fn validate_plasticity(&self) -> Result<(), OutOfRange> {
        let given = &self.plasticity;
        let require = |key, value, met, accepted| MATERIALS.require(format!("plasticity.{key}"), value, met, accepted);
        let (angle, kc) = (given.dilation_angle_deg, given.meridian_ratio);
        require("dilation_angle_deg", angle, angle > 0.0 && angle < 90.0, "it must lie above 0 and below 90")?;
        require("meridian_ratio", kc, kc > 0.5 && kc <= 1.0, "it must lie above 0.5 and at most at 1")?;
        for (key, value) in [("eccentricity", given.eccentricity), ("viscosity_s", given.viscosity_s)] {
            require(key, value, value >= 0.0 && value.is_finite(), "it must be 0 or more")?;
        }
        // The yield surface has alpha = (r - 1) / (2 r - 1), which Abaqus wants from 0 to 0.5.
        let biaxial = given.biaxial_ratio;
        require("biaxial_ratio", biaxial, biaxial >= 1.0 && biaxial.is_finite(), "it must be 1 or more")
    }

    /// Checks the values of the law `meso`.
    ///
    /// # Errors
    /// Names the first value outside its range.
    pub fn validate_mesoscale(&self) -> Result<(), OutOfRange> {
        let given = &self.meso;
        let require = |key, value, met, accepted| MATERIALS.require(format!("meso.{key}"), value, met, accepted);
        let (angle, kc, ductility) = (given.dilation_angle_deg, given.meridian_ratio, given.confined_ductility);
        let (biaxial, bend) = (given.biaxial_ratio, given.meridian_bend);
        let accepted = "it must be 1 to 2: below 1 the surface narrows under pressure faster than the dilation fades, and closed \
             loops of strain return energy; grains give the concrete its own ratio, 1.2 to 1.3";
        require("biaxial_ratio", biaxial, (1.0..=2.0).contains(&biaxial), accepted)?;
        require("meridian_bend", bend, (0.0..=10.0).contains(&bend), "it must be 0 to 10; 0.15 is the default")?;
        require("dilation_angle_deg", angle, (0.0..60.0).contains(&angle), "it must be 0 or more and below 60")?;
        require("meridian_ratio", kc, kc > 0.6 && kc <= 1.0, "it must lie above 0.6 and at most at 1; 2/3 is usual")?;
        require("confined_ductility", ductility, (0.0..=100.0).contains(&ductility), "it must be 0 to 100")?;
        MATERIALS.positive("meso.crushing_length_mm", given.crushing_length_mm)
    }
}

fn accept(range: PhysicalRange, key: String, value: f64) -> Result<(), OutOfRange> {
    MATERIALS.positive(&key, value)?;
    MATERIALS.require(key, value, range.has(value), range.refusal(value))
}

/// Checks the elastic values of a phase with a compressive strength, MPa, or without one. Moduli of soil in MPa are those of stone
/// in GPa, so that the strength decides which is meant.
fn elastic(phase: &str, values: &Elastic, strength: Option<f64>) -> Result<(), OutOfRange> {
    let (modulus, ratio) = (values.youngs_modulus_mpa, values.poisson_ratio);
    let is_rubber = modulus > 0.0 && modulus <= SOFTEST;
    let is_between = modulus > SOFTEST && modulus < MODULUS.least;
    let is_soft = is_between && strength.is_some_and(|strength| (0.0..=SOFT_STRENGTH * modulus).contains(&strength));
    if !is_rubber && !is_soft {
        let key = format!("{phase}.youngs_modulus_mpa");
        MATERIALS.positive(&key, modulus)?;
        let or_soil = strength.filter(|_| is_between).map_or(String::new(), |strength| {
            format!(
                "; soil as soft as this has a strength of {} MPa at most, and this phase {strength}",
                SOFT_STRENGTH * modulus
            )
        });
        MATERIALS.require(key, modulus, MODULUS.has(modulus), MODULUS.refusal(modulus) + &or_soil)?;
    }
    accept(DENSITY, format!("{phase}.density_t_per_mm3"), values.density_t_per_mm3)?;
    let accepted = "it must lie between -1 and 0.5, where a material is stable";
    MATERIALS.require(format!("{phase}.poisson_ratio"), ratio, ratio > -1.0 && ratio < 0.5, accepted)
}
