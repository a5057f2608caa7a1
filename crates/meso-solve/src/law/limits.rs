//! Material values that a law cannot have, by name, before any step.

use meso_mesh::Phase;
use meso_mesh::materials::{Elastic, Materials, Strength};

/// A value that a law cannot have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("materials.{key} is {value}; {accepted}")]
pub struct LawError {
    /// Where it stands in `[materials]`.
    pub key: String,
    /// The value given.
    pub value: String,
    /// The accepted values, and the way out.
    pub accepted: String,
}

/// Compressive stress at which inelastic strain begins, over the strength: as in the decks.
pub(super) const ELASTIC_LIMIT: f64 = 0.4;
/// A peak strain must be so many times the elastic strain of the strength: as in the decks.
const PEAK_OVER_ELASTIC: f64 = 1.05;

/// Every elastic value against its range.
///
/// # Errors
/// The first one outside, or NaN.
pub fn elastic(materials: &Materials) -> Result<(), LawError> {
    for phase in [Phase::Aggregate, Phase::Itz, Phase::Mortar, Phase::Fibre] {
        let key = phase.name().to_ascii_lowercase();
        let Elastic { youngs_modulus_mpa, poisson_ratio, density_t_per_mm3 } = *materials.elastic(phase);
        positive(&format!("{key}.youngs_modulus_mpa"), youngs_modulus_mpa)?;
        positive(&format!("{key}.density_t_per_mm3"), density_t_per_mm3)?;
        let stable = poisson_ratio > -1.0 && poisson_ratio < 0.5;
        require(&format!("{key}.poisson_ratio"), poisson_ratio, stable, "it must lie between -1 and 0.5")?;
    }
    Ok(())
}

/// Strengths and energies, for both phases that soften.
pub(super) fn strength(materials: &Materials) -> Result<(), LawError> {
    let given = &materials.mortar_strength;
    for (key, value) in [
        ("compressive_mpa", given.compressive_mpa),
        ("peak_strain", given.peak_strain),
        ("tensile_mpa", given.tensile_mpa),
        ("fracture_energy_n_per_mm", given.fracture_energy_n_per_mm),
        ("crushing_energy_n_per_mm", given.crushing_energy_n_per_mm),
    ] {
        positive(&format!("mortar_strength.{key}"), value)?;
    }
    let ratio = materials.itz_strength_ratio;
    require("itz_strength_ratio", ratio, ratio > 0.0 && ratio <= 1.0, "it must lie above 0 and at most at 1")?;
    for phase in [Phase::Mortar, Phase::Itz] {
        let Some(Strength { compressive_mpa, peak_strain, .. }) = materials.strength(phase) else { continue };
        let least = PEAK_OVER_ELASTIC * compressive_mpa / materials.elastic(phase).youngs_modulus_mpa;
        let accepted = format!("{} needs {least:.3e} or more, 5 % above its elastic strain", phase.name());
        require("mortar_strength.peak_strain", peak_strain, peak_strain >= least, &accepted)?;
    }
    Ok(())
}

pub(super) fn positive(key: &str, value: f64) -> Result<(), LawError> {
    require(key, value, value > 0.0 && value.is_finite(), "it must be a positive number")
}

/// An error where `met` is false.
pub(super) fn require(key: &str, value: f64, met: bool, accepted: &str) -> Result<(), LawError> {
    let error = || LawError { key: key.into(), value: value.to_string(), accepted: accepted.into() };
    if met { Ok(()) } else { Err(error()) }
}
