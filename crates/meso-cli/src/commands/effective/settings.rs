//! The options that the flags of `mesocrete effective` ask for.

use super::flags::Args;
use crate::failure::Failure;
use crate::inputs;
use meso_core::{Spec, spec};
use meso_effective::results::{FIGURES, PAGE, field_file};
use meso_effective::{EffectiveError, EffectiveOptions, Phases, Property};

impl Args {
    /// Values of the phases, from the file if one is named.
    pub(super) fn phases(&self) -> Result<Phases, Failure> {
        let mut phases = match &self.phases {
            Some(path) => inputs::toml(path, spec::options_from_toml)?,
            None => Phases::default(),
        };
        for property in self.properties() {
            phases.values(property).validate(property).map_err(|error| Failure::Usage(error.to_string()))?;
        }
        if !self.eigenstrain.is_empty() && !self.what.stiffness {
            return Err(Failure::Usage("--eigenstrain needs --what stiffness or all".to_owned()));
        }
        if self.properties().is_empty() && self.axes.0 != [true; 3] {
            return Err(Failure::Usage("--axes needs --what diffusivity, conductivity or all".to_owned()));
        }
        for (name, strain) in &self.eigenstrain {
            let phase = phases.stiffness.phase_mut(name).ok_or_else(|| {
                Failure::Usage(format!(
                    "--eigenstrain names {name:?}; it must be mortar, itz, aggregate, void or fibre"
                ))
            })?;
            phase.eigenstrain = Some(*strain);
        }
        if self.what.stiffness {
            phases.stiffness.validate().map_err(|error| Failure::Usage(error.to_string()))?;
        }
        Ok(phases)
    }

    pub(super) fn properties(&self) -> Vec<Property> {
        let asked = [(Property::Diffusivity, self.what.diffusivity), (Property::Conductivity, self.what.conductivity)];
        asked.into_iter().filter(|(_, asked)| *asked).map(|(property, _)| property).collect()
    }

    /// Names of the files that a run writes.
    pub(super) fn files(&self) -> Vec<String> {
        let axes = || (0..3).filter(|axis| self.axes.0[*axis] && !self.no_fields);
        let fields = self.properties().into_iter().flat_map(|what| axes().map(move |axis| field_file(what, axis)));
        [FIGURES, PAGE].map(str::to_owned).into_iter().chain(fields).collect()
    }

    pub(super) fn options(&self, what: Property, spec: &Spec) -> EffectiveOptions {
        EffectiveOptions { axes: self.axes.0, fields: !self.no_fields, ..EffectiveOptions::new(what, self.size(spec)) }
    }

    /// Edge of a voxel, mm.
    pub(super) fn size(&self, spec: &Spec) -> f64 {
        self.voxel_size_mm.unwrap_or_else(|| EffectiveOptions::default_voxel_size(spec.grading.d_min_mm))
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
