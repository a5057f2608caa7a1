//! The fraction from a mix design: the aggregate is the volume of a cubic metre that cement, water and air leave, and
//! the part of it coarser than `d_min_mm` is placed.

use super::read::read;
use super::tree::{Node, Value};
use super::{SpecError, limits};
use meso_concrete::aggregate::{Form, Grading};
use serde::Deserialize;

/// A mix design, `[mix]` in a spec, given instead of `fraction`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MixDesign {
    /// Cement, kg per m3 of concrete.
    pub cement_kg_per_m3: f64,
    /// Water, kg per m3 of concrete.
    pub water_kg_per_m3: f64,
    /// Air, share of the concrete's volume, 0 to 1.
    #[serde(default)]
    pub air: f64,
    /// Density of the cement, kg/m3.
    #[serde(default = "cement_density")]
    pub cement_density_kg_per_m3: f64,
    /// Density of the water, kg/m3.
    #[serde(default = "water_density")]
    pub water_density_kg_per_m3: f64,
}

/// Portland cement, as mix design tables have it.
fn cement_density() -> f64 {
    3150.0
}

fn water_density() -> f64 {
    1000.0
}

#[derive(Deserialize)]
struct MixTable {
    mix: MixDesign,
}

/// Takes `[mix]` out of a spec.
pub(super) fn take(tree: &mut Node) -> Result<Option<MixDesign>, SpecError> {
    let Some(entry) = tree.take("mix") else { return Ok(None) };
    let line = entry.1.line;
    if tree.child("fraction").is_some() {
        let error = SpecError::value("mix", "is given, and so is fraction; give one of the two");
        return Err(SpecError { line, ..error });
    }
    let alone = Node { value: Value::Table(vec![entry]), line };
    let mix = read::<MixTable>(&alone)?.mix;
    mix.validate().map_err(|error| error.at(&alone))?;
    Ok(Some(mix))
}

impl MixDesign {
    fn validate(&self) -> Result<(), SpecError> {
        limits::within("mix.cement_kg_per_m3", self.cement_kg_per_m3, 0.0, 2000.0)?;
        limits::within("mix.water_kg_per_m3", self.water_kg_per_m3, 0.0, 1000.0)?;
        limits::within("mix.air", self.air, 0.0, 0.5)?;
        limits::within("mix.cement_density_kg_per_m3", self.cement_density_kg_per_m3, 1000.0, 5000.0)?;
        limits::within("mix.water_density_kg_per_m3", self.water_density_kg_per_m3, 900.0, 1100.0)
    }

    /// Volume of all aggregate, sand included, over the concrete's: v_a = 1 - c/rho_c - w/rho_w - v_air.
    pub fn all_aggregate(&self) -> f64 {
        let paste =
            self.cement_kg_per_m3 / self.cement_density_kg_per_m3 + self.water_kg_per_m3 / self.water_density_kg_per_m3;
        1.0 - paste - self.air
    }

    /// The spec's fraction: v_a (P(d_max) - P(d_min)) for a normalised grading, which places its whole target; v_a
    /// for a raw one, which omits the fines itself.
    ///
    /// # Errors
    /// A mix without volume for aggregate.
    pub fn fraction(&self, grading: &Grading) -> Result<f64, SpecError> {
        let all = self.all_aggregate();
        if all <= 0.0 {
            let message = format!("leaves {all:.3} of the volume to the aggregate; reduce cement, water or air");
            return Err(SpecError::value("mix", message));
        }
        let raw = |d: f64| grading.curve.passing(d, grading.d_max_mm);
        Ok(match grading.form {
            Form::Raw => all,
            Form::Normalised => all * (raw(grading.d_max_mm) - raw(grading.d_min_mm)),
        })
    }
}
