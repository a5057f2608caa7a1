//! Limits of a deck's values; one out of its range is named.

use super::{Analysis, DeckOptions};
use meso_mesh::cells::Phase;
use meso_mesh::materials::{Elastic, Materials, Plasticity};

/// An option that a deck cannot hold.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("deck.{key} is {value}; {accepted}")]
pub struct DeckError {
    /// The option's name.
    key: String,
    /// The value given.
    value: String,
    /// The accepted range.
    accepted: String,
}

impl DeckError {
    pub(super) fn new(key: impl Into<String>, value: impl ToString, accepted: impl Into<String>) -> Self {
        Self { key: key.into(), value: value.to_string(), accepted: accepted.into() }
    }

    /// The option's name; dotted where it stands in a table, as in `materials.mortar.poisson_ratio`.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// How the sentence goes on that the name begins: the value and what is accepted.
    pub fn fault(&self) -> String {
        format!("is {}; {}", self.value, self.accepted)
    }
}

/// Every value against its range; NaN lies in none.
pub(super) fn check(options: &DeckOptions) -> Result<(), DeckError> {
    let loading = &options.loading;
    let strain = options.final_strain();
    require("strain", strain, strain > 0.0 && strain < 1.0, "it must lie between 0 and 1; the analysis sets its sign")?;
    require("friction", loading.friction, (0.0..=10.0).contains(&loading.friction), "it must be 0 to 10")?;
    require("frames", f64::from(loading.frames), loading.frames > 0, "it must be 1 or more")?;
    positive("duration_s", loading.duration_s)?;
    positive("time_increment_s", loading.time_increment_s)?;
    if options.with_damage && options.analysis == Analysis::Elastic {
        return Err(DeckError::new(
            "with_damage",
            "true",
            "analysis elastic has no damage; take compression, tension or none",
        ));
    }
    if let Some(section) = options.section_mm2 {
        positive("section_mm2", section)?;
    }
    let fits = |line: &&String| line.is_ascii() && !line.starts_with('*') && !line.contains(['\n', '\r']);
    if let Some(line) = options.heading.iter().find(|line| !fits(line)) {
        return Err(DeckError::new("heading", format!("{line:?}"), "a line must be ASCII and must not begin with *"));
    }
    materials(&options.materials)
}

fn materials(values: &Materials) -> Result<(), DeckError> {
    for (name, phase) in
        [("aggregate", &values.aggregate), ("itz", &values.itz), ("mortar", &values.mortar), ("fibre", &values.fibre)]
    {
        elastic(name, phase)?;
    }
    let strength = &values.mortar_strength;
    for (name, value) in [
        ("compressive_mpa", strength.compressive_mpa),
        ("peak_strain", strength.peak_strain),
        ("tensile_mpa", strength.tensile_mpa),
        ("fracture_energy_n_per_mm", strength.fracture_energy_n_per_mm),
        ("crushing_energy_n_per_mm", strength.crushing_energy_n_per_mm),
    ] {
        positive(&format!("materials.mortar_strength.{name}"), value)?;
    }
    let ratio = values.itz_strength_ratio;
    require(
        "materials.itz_strength_ratio",
        ratio,
        ratio > 0.0 && ratio <= 1.0,
        "it must lie above 0 and at most at 1",
    )?;
    positive("materials.cohesive_thickness_mm", values.cohesive_thickness_mm)?;
    require(
        "materials.cohesive_shear_energy_ratio",
        values.cohesive_shear_energy_ratio,
        values.cohesive_shear_energy_ratio >= 1.0 && values.cohesive_shear_energy_ratio.is_finite(),
        "it must be 1 or more",
    )?;
    positive("materials.cohesive_mode_power", values.cohesive_mode_power)?;
    plasticity(&values.plasticity)
}

// Abaqus' own limits.
fn plasticity(plasticity: &Plasticity) -> Result<(), DeckError> {
    let (angle, kc) = (plasticity.dilation_angle_deg, plasticity.meridian_ratio);
    require(
        "materials.plasticity.dilation_angle_deg",
        angle,
        angle > 0.0 && angle < 90.0,
        "it must lie above 0 and below 90",
    )?;
    require(
        "materials.plasticity.meridian_ratio",
        kc,
        kc > 0.5 && kc <= 1.0,
        "it must lie above 0.5 and at most at 1",
    )?;
    for (name, value) in [("eccentricity", plasticity.eccentricity), ("viscosity_s", plasticity.viscosity_s)] {
        require(
            &format!("materials.plasticity.{name}"),
            value,
            value >= 0.0 && value.is_finite(),
            "it must be 0 or more",
        )?;
    }
    let biaxial = plasticity.biaxial_ratio;
    // The yield surface has alpha = (r - 1) / (2 r - 1), which Abaqus wants from 0 to 0.5.
    require(
        "materials.plasticity.biaxial_ratio",
        biaxial,
        biaxial >= 1.0 && biaxial.is_finite(),
        "it must be 1 or more",
    )
}

/// A peak strain must be so many times the elastic strain of the strength: its curve rises from there.
const PEAK_OVER_ELASTIC: f64 = 1.05;

/// Finds out whether Abaqus takes the curves of `phase`: it refuses plastic strains that fall. In compression the curves
/// see to it themselves. `opening` is what a deck has of a crack's opening; a crack's plastic opening grows by that share of
/// G / (4 f) where it loses f / (5 E).
pub(super) fn curves(materials: &Materials, phase: Phase, opening: f64) -> Result<(), DeckError> {
    let Some(strength) = materials.strength(phase) else { return Ok(()) };
    let (e, fc, ft) = (materials.elastic(phase).youngs_modulus_mpa, strength.compressive_mpa, strength.tensile_mpa);
    let given = &materials.mortar_strength;
    let share = opening * strength.fracture_energy_n_per_mm / given.fracture_energy_n_per_mm;
    for (name, value, least) in [
        ("peak_strain", given.peak_strain, PEAK_OVER_ELASTIC * fc / e),
        ("fracture_energy_n_per_mm", given.fracture_energy_n_per_mm, 0.8 * ft * ft / e / share),
    ] {
        let accepted = format!("{} needs {least:.3e} or more for its elastic strain", phase.name());
        require(&format!("materials.mortar_strength.{name}"), value, value >= least, &accepted)?;
    }
    Ok(())
}

/// Finds out whether Abaqus takes the softening of a cohesive ITZ.
pub(super) fn separation(materials: &Materials) -> Result<(), DeckError> {
    let (t, limit) = (materials.cohesive_thickness_mm, materials.cohesive_thickness_limit_mm());
    let accepted =
        format!("it must be below {limit:.3e}, where damage begins with less than the ITZ's fracture energy");
    require("materials.cohesive_thickness_mm", t, t < limit, &accepted)
}

/// tonne/mm3: whatever is mass-scaled a thousandfold lies far below it, kg/m3 and g/cm3 far above.
const HEAVIEST: f64 = 1e-3;

fn elastic(name: &str, values: &Elastic) -> Result<(), DeckError> {
    let (key, ratio) = (format!("materials.{name}"), values.poisson_ratio);
    positive(&format!("{key}.youngs_modulus_mpa"), values.youngs_modulus_mpa)?;
    let density = values.density_t_per_mm3;
    let matter = "it must be a positive number below 1e-3, in tonne/mm3: 2400 kg/m3 are 2.4e-9";
    require(&format!("{key}.density_t_per_mm3"), density, density > 0.0 && density < HEAVIEST, matter)?;
    let stable = ratio > -1.0 && ratio < 0.5;
    require(
        &format!("{key}.poisson_ratio"),
        ratio,
        stable,
        "it must lie between -1 and 0.5, where a material is stable",
    )
}

fn positive(key: &str, value: f64) -> Result<(), DeckError> {
    require(key, value, value > 0.0 && value.is_finite(), "it must be a positive number")
}

fn require(key: &str, value: f64, met: bool, accepted: &str) -> Result<(), DeckError> {
    if met { Ok(()) } else { Err(DeckError::new(key, value, accepted)) }
}
