//! The options that the flags of `mesocrete effective` ask for.

use super::flags::Args;
use crate::failure::Failure;
use crate::inputs;
use meso_core::{Spec, spec};
use meso_effective::{EffectiveError, EffectiveOptions, Phases, Property};

impl Args {
    /// Values of the phases, from the file if one is named.
    pub(super) fn phases(&self) -> Result<Phases, Failure> {
        let phases = match &self.phases {
            Some(path) => inputs::toml(path, spec::options_from_toml)?,
            None => Phases::default(),
        };
        for property in self.properties() {
            phases.values(property).validate(property).map_err(|error| Failure::Usage(error.to_string()))?;
        }
        Ok(phases)
    }

    pub(super) fn properties(&self) -> Vec<Property> {
        let asked = [(Property::Diffusivity, self.what.diffusivity), (Property::Conductivity, self.what.conductivity)];
        asked.into_iter().filter(|(_, asked)| *asked).map(|(property, _)| property).collect()
    }

    pub(super) fn options(&self, what: Property, spec: &Spec) -> EffectiveOptions {
        let size = self.voxel_size_mm.unwrap_or_else(|| EffectiveOptions::default_voxel_size(spec.grading.d_min_mm));
        EffectiveOptions { axes: self.axes.0, fields: !self.no_fields, ..EffectiveOptions::new(what, size) }
    }
}

/// Turns an error into wrong usage, by the name of its flag.
pub(super) fn wrong(error: &EffectiveError) -> Failure {
    match error {
        EffectiveError::Value(value) if value.table == "effective" => {
            Failure::Usage(format!("--{} {}", value.key.replace('_', "-"), value.fault()))
        }
        EffectiveError::Diverged { .. } => Failure::Run(error.to_string()),
        _ => Failure::Usage(error.to_string()),
    }
}
