//! The options that the flags of `mesocrete effective` ask for.

use super::flags::Args;
use crate::failure::Failure;
use crate::inputs;
use meso_core::import::{ending, volume};
use meso_core::mesh::MethodName;
use meso_core::{Spec, spec};
use meso_effective::results::{FIGURES, PAGE, field_ending, field_file, stress_file};
use meso_effective::{
    Boundary, EffectiveError, EffectiveOptions, LabelPhases, LabelSpecimen, Phases, Property, StiffnessOptions,
};

/// Values of the phases.
pub(super) enum Values {
    Packing(Box<Phases>),
    Labels(LabelPhases),
}

impl Args {
    /// Values of the phases, from the file if one is named.
    pub(super) fn values(&self) -> Result<Values, Failure> {
        self.go_together()?;
        if self.is_volume() {
            return self.label_phases().map(Values::Labels);
        }
        self.phases().map(|phases| Values::Packing(Box::new(phases)))
    }

    /// Refuses flags that contradict each other.
    fn go_together(&self) -> Result<(), Failure> {
        if !self.eigenstrain.is_empty() && !self.what.stiffness {
            return Err(Failure::Usage("--eigenstrain needs --what stiffness or all".to_owned()));
        }
        if self.properties().is_empty() && self.axes.0 != [true; 3] {
            return Err(Failure::Usage("--axes needs --what diffusivity, conductivity or all".to_owned()));
        }
        if self.boundary != Boundary::Fixed && !self.in_tetrahedra() {
            return Err(Failure::Usage(format!("--boundary {} needs --method lattice", self.boundary.name())));
        }
        if self.boundary != Boundary::Fixed && self.properties().is_empty() {
            return Err(Failure::Usage("--boundary needs --what diffusivity, conductivity or all".to_owned()));
        }
        self.suit_method()?;
        if self.periodic.is_some() && !self.is_volume() {
            return Err(Failure::Usage(
                "--periodic is for label volumes; a model's specimen says it itself".to_owned(),
            ));
        }
        Ok(())
    }

    /// Refuses a method that a file or a size does not go with.
    fn suit_method(&self) -> Result<(), Failure> {
        let wrong = match self.method {
            MethodName::Conforming => "--method is conforming; it must be voxel or lattice",
            MethodName::Lattice if self.is_volume() => {
                "--method lattice is for models; a label volume is its own voxels"
            }
            MethodName::Lattice if self.voxel_size_mm.is_some() => "--method lattice takes --element-size-mm",
            MethodName::Voxel if self.element_size_mm.is_some() => "--element-size-mm needs --method lattice",
            _ => return Ok(()),
        };
        Err(Failure::Usage(wrong.to_owned()))
    }

    /// Whether a model is divided into tetrahedra.
    pub(super) fn in_tetrahedra(&self) -> bool {
        self.method == MethodName::Lattice
    }

    /// Refuses flags that are wrong with any file.
    pub(crate) fn validate(&self) -> Result<(), Failure> {
        if self.phases.is_some() { self.go_together() } else { self.values().map(drop) }
    }

    /// Refuses flags that a packing of `spec` has no property for.
    pub(crate) fn check(&self, spec: &Spec) -> Result<(), Failure> {
        self.values()?;
        let stiffness = self.what.stiffness.then_some(None);
        let mut properties = self.properties().into_iter().map(Some).chain(stiffness);
        properties.try_for_each(|property| self.bytes(spec, property).map(drop))
    }

    /// Whether the input is a label volume, by its ending.
    fn is_volume(&self) -> bool {
        ending(&self.model.to_string_lossy()).is_some_and(|ending| volume::ENDINGS.contains(&ending.as_str()))
    }

    fn phases(&self) -> Result<Phases, Failure> {
        let mut phases = match &self.phases {
            Some(path) => inputs::toml(path, spec::options_from_toml)?,
            None => Phases::default(),
        };
        for property in self.properties() {
            phases.values(property).validate(property).map_err(|error| Failure::Usage(error.to_string()))?;
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

    fn label_phases(&self) -> Result<LabelPhases, Failure> {
        let mut phases: LabelPhases = match &self.phases {
            Some(path) => inputs::toml(path, spec::options_from_toml)?,
            None => LabelPhases::default(),
        };
        for (name, strain) in &self.eigenstrain {
            phases.stiffness.entry(name.clone()).or_default().eigenstrain = Some(*strain);
        }
        Ok(phases)
    }

    /// The label volume, with the edges of its voxels.
    pub(super) fn labels(&self) -> Result<LabelSpecimen, Failure> {
        let volume = inputs::volume(&self.model)?;
        let given = self.voxel_size_mm.map(|h| [h; 3]);
        let spacing_mm = given.or(volume.spacing_mm).unwrap_or([1.0; 3]);
        Ok(LabelSpecimen { volume, spacing_mm, periodic: self.periodic.map_or([false; 3], |axes| axes.0) })
    }

    pub(super) fn properties(&self) -> Vec<Property> {
        let asked = [(Property::Diffusivity, self.what.diffusivity), (Property::Conductivity, self.what.conductivity)];
        asked.into_iter().filter(|(_, asked)| *asked).map(|(property, _)| property).collect()
    }

    /// Names of the files that a run writes.
    pub(crate) fn files(&self) -> Vec<String> {
        let axes = || (0..3).filter(|axis| self.axes.0[*axis] && !self.no_fields);
        let ending = field_ending(self.in_tetrahedra());
        let of = |what| axes().map(move |axis| field_file(what, axis, ending));
        let fields = self.properties().into_iter().flat_map(of);
        let stresses = (0..6).filter(|_| self.what.stiffness && !self.no_fields).map(|row| stress_file(row, ending));
        [FIGURES, PAGE].map(str::to_owned).into_iter().chain(fields).chain(stresses).collect()
    }

    pub(super) fn options(&self, what: Property, voxel_size_mm: f64) -> EffectiveOptions {
        let usual = EffectiveOptions::new(what, voxel_size_mm);
        let tolerance = self.tolerance.unwrap_or(usual.tolerance);
        EffectiveOptions { axes: self.axes.0, fields: !self.no_fields, tolerance, boundary: self.boundary, ..usual }
    }

    pub(super) fn stiffness_options(&self, voxel_size_mm: f64) -> StiffnessOptions {
        let usual = StiffnessOptions::new(voxel_size_mm);
        StiffnessOptions { fields: !self.no_fields, tolerance: self.tolerance.unwrap_or(usual.tolerance), ..usual }
    }

    /// Memory that a property, or else the stiffness, of a packing of `spec` takes at most, bytes.
    pub(super) fn bytes(&self, spec: &Spec, property: Option<Property>) -> Result<f64, Failure> {
        let (size, specimen) = (self.size(spec), &spec.specimen);
        let bytes = match property {
            Some(property) if self.in_tetrahedra() => self.options(property, size).bytes_in_tetrahedra(specimen, size),
            None if self.in_tetrahedra() => self.stiffness_options(size).bytes_in_tetrahedra(specimen, size),
            Some(property) => self.options(property, size).bytes(specimen),
            None => self.stiffness_options(size).bytes(specimen),
        };
        bytes.map_err(|error| wrong(&error))
    }

    /// Edge of a voxel or a tetrahedron, mm.
    pub(super) fn size(&self, spec: &Spec) -> f64 {
        let smallest = spec.grading.d_min_mm;
        if self.in_tetrahedra() {
            return self.element_size_mm.unwrap_or_else(|| EffectiveOptions::default_element_size(smallest));
        }
        self.voxel_size_mm.unwrap_or_else(|| EffectiveOptions::default_voxel_size(smallest))
    }
}

/// Turns an error into wrong usage, by the name of its flag.
pub(super) fn wrong(error: &EffectiveError) -> Failure {
    match error {
        EffectiveError::Value(value) if value.table == "effective" => {
            Failure::Usage(format!("--{} {}", value.key.replace('_', "-"), value.fault()))
        }
        EffectiveError::Boundary(name, why) => Failure::Usage(format!("--boundary is {name}; {why}")),
        EffectiveError::Diverged { .. } => Failure::Run(error.to_string()),
        _ => Failure::Usage(error.to_string()),
    }
}
