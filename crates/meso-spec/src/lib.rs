//! The serde view of every option of a SPEC.toml.
//!
//! Reading goes text -> `tree` (values with line numbers) -> `read` (serde, with the path of whatever is wrong)
//! -> `limits` (invalid values). Every error names the key, the value and the way out.

// No environment, clock, file, print or mathematics of the platform: the list is in `crates/clippy.toml`.
#![cfg_attr(not(test), deny(clippy::disallowed_methods, clippy::disallowed_types, clippy::disallowed_macros))]

#[cfg(feature = "schema")]
mod describe;
pub mod distinct;
mod error;
mod files;
mod library;
mod limits;
mod messages;
mod mix_design;
mod read;
mod room;
#[cfg(feature = "schema")]
mod schema;
mod sieves;
mod surface;
mod tree;
mod values;

pub use error::SpecError;
pub use files::Files;
pub use files::NoFiles;
pub use limits::MAX_LENGTH_MM;
pub use messages::nearest;
pub use mix_design::MixDesign;

use meso_concrete::PhaseNames;
use meso_concrete::aggregate::{Fibres, Grading, Inclusions, Itz, OwnPhase, Shape, ShellLaw, Voids};
use meso_concrete::specimen::Specimen;
use meso_concrete::stop;
use meso_concrete::watch::{Silent, Watch};
use meso_place::Placement;
use serde::{Deserialize, Serialize};

/// Files, watch and time limit of a spec that is being read.
struct Reading<'a> {
    files: &'a mut dyn Files,
    watch: &'a dyn Watch,
    /// In place of the spec's.
    time_limit_s: Option<f64>,
    /// Whether the spec describes grains that were found.
    is_found: bool,
}

/// Everything that decides a model, with the paper's specimen as default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Spec {
    /// Seed of all randomness.
    pub seed: u64,
    /// Volume of the aggregates over the specimen's, 0 to 1.
    pub fraction: f64,
    /// Specimen to fill.
    pub specimen: Specimen,
    /// Sizes.
    pub grading: Grading,
    /// Shapes.
    pub shape: Shape,
    /// Interfacial transition zone.
    pub itz: Itz,
    /// Placement.
    pub placement: Placement,
    /// Spherical voids, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub voids: Option<Voids>,
    /// Straight fibres, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fibres: Option<Fibres>,
    /// Phases that some of the aggregates have instead of the phase `aggregate`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub phases: Vec<OwnPhase>,
}

impl Default for Spec {
    fn default() -> Self {
        Self {
            seed: 1,
            fraction: 0.5,
            specimen: Specimen::default(),
            grading: Grading::default(),
            shape: Shape::default(),
            itz: Itz::default(),
            placement: Placement::default(),
            voids: None,
            fibres: None,
            phases: Vec::new(),
        }
    }
}

impl Spec {
    /// The spec as JSON text; keys keep their order.
    ///
    /// # Errors
    /// None, as numbers and text have a JSON form.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string(self)
    }

    /// The specimen as JSON text; keys keep their order.
    ///
    /// # Errors
    /// None, as in [`to_json`](Self::to_json).
    pub fn specimen_to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string(&self.specimen)
    }

    /// Reads and validates a SPEC.toml; omitted options keep their defaults.
    ///
    /// # Errors
    /// Names the key, the line and the way out: syntax, unknown keys, wrong types, invalid values.
    pub fn from_toml(text: &str) -> Result<Self, SpecError> {
        Self::from_toml_with(text, &mut NoFiles)
    }

    /// Reads and validates a SPEC.toml whose tables name other `files`: a sieve table (CSV) as `curve = { kind =
    /// "sieves", file = "..." }`, grains (STL, JSON, a folder of these) as `shape.library`, a specimen (STL) as
    /// `specimen = { kind = "mesh", file = "..." }`.
    ///
    /// # Errors
    /// Fails like [`Spec::from_toml`], and where `files` fail.
    pub fn from_toml_with(text: &str, files: &mut dyn Files) -> Result<Self, SpecError> {
        Self::from_toml_while(text, files, &Silent, None)
    }

    /// Reads a spec like [`Spec::from_toml_with`], and reports to `watch`: a surface of a million triangles takes
    /// seconds. The watch also receives the fraction asked for. `time_limit_s` replaces the spec's own limit.
    ///
    /// # Errors
    /// Fails like [`Spec::from_toml_with`], and where the time limit ends the proof of the surface: see [`SpecError::is_late`].
    pub fn from_toml_while(
        text: &str,
        files: &mut dyn Files,
        watch: &dyn Watch,
        time_limit_s: Option<f64>,
    ) -> Result<Self, SpecError> {
        let reading = Reading { files, watch, time_limit_s, is_found: false };
        Self::from_tree(tree::parse_toml(text)?, reading)
    }

    /// Reads and validates a spec from a tree of values, e.g. a Python dict or a saved model.
    ///
    /// # Errors
    /// Fails like [`Spec::from_toml`], without a line.
    pub fn from_value(value: &serde_json::Value) -> Result<Self, SpecError> {
        Self::from_value_with(value, &mut NoFiles)
    }

    /// Reads a tree of values like [`Spec::from_value`], with `files` as in [`Spec::from_toml_with`].
    ///
    /// # Errors
    /// Fails like [`Spec::from_toml_with`], without a line.
    pub fn from_value_with(value: &serde_json::Value, files: &mut dyn Files) -> Result<Self, SpecError> {
        Self::from_value_while(value, files, &Silent, None)
    }

    /// Reads a tree of values like [`Spec::from_value_with`], with a watch and a time limit as in
    /// [`Spec::from_toml_while`].
    ///
    /// # Errors
    /// Fails like [`Spec::from_toml_while`], without a line.
    pub fn from_value_while(
        value: &serde_json::Value,
        files: &mut dyn Files,
        watch: &dyn Watch,
        time_limit_s: Option<f64>,
    ) -> Result<Self, SpecError> {
        Self::from_tree(tree::from_json(value), Reading { files, watch, time_limit_s, is_found: false })
    }

    /// Reads the spec of a model whose grains were found, as [`validate_described`](Self::validate_described) accepts it.
    ///
    /// # Errors
    /// Fails like [`Spec::from_value`].
    pub fn from_described(value: &serde_json::Value, watch: &dyn Watch) -> Result<Self, SpecError> {
        let reading = Reading { files: &mut NoFiles, watch, time_limit_s: None, is_found: true };
        Self::from_tree(tree::from_json(value), reading)
    }

    /// Voids and fibres of the spec.
    pub fn inclusions(&self) -> Inclusions<'_> {
        Inclusions { voids: self.voids.as_ref(), fibres: self.fibres }
    }

    /// Phases of the specimen, with the names of its own.
    pub fn phases(&self) -> PhaseNames {
        PhaseNames::of(&self.phases, &self.shape.shells)
    }

    /// Shells of the grains with a phase of their own, or without one, from outside, with the positions of their phases.
    pub fn shells_of(&self, own: Option<u8>) -> Vec<(u8, &ShellLaw)> {
        let (names, phase) = (self.phases(), own.and_then(|own| self.phases.get(usize::from(own))));
        let has = |law: &&ShellLaw| law.of.is_none() || law.of.as_ref() == phase.map(|phase| &phase.name);
        self.shape.shells.iter().filter(has).filter_map(|law| Some((names.find(&law.name)?, law))).collect()
    }

    fn from_tree(mut tree: tree::Node, mut reading: Reading<'_>) -> Result<Self, SpecError> {
        if let Some(fraction) = plain_fraction(&tree) {
            reading.watch.target(fraction);
        }
        let table = tree.child_mut("grading").map_or(Ok(None), |own| sieves::inline(own, reading.files))?;
        let pores = tree.child_mut("voids").and_then(|voids| voids.child_mut("grading"));
        let pores = pores.map_or(Ok(None), |own| has_limits(own).and_then(|()| sieves::inline(own, reading.files)));
        let pores = pores.map_err(|error| error.within("voids"))?;
        let limit = library::inline(&mut tree, &mut reading)?;
        let (to_read, watch) = (library::Limit::of(&tree, reading.time_limit_s), reading.watch);
        stop::until(to_read.waiting(watch), || surface::inline(&mut tree, &mut reading))
            .map_err(|_| to_read.late("the specimen's surface was read", "a reduced surface"))??;
        let is_given = |table: &str, key: &str| tree.child(table).is_some_and(|table| table.child(key).is_some());
        let (vertices_given, size_given) = (is_given("shape", "vertices"), is_given("grading", "size"));
        let mix = mix_design::take(&mut tree)?;
        let mut spec: Self = stop::until(limit.waiting(reading.watch), || read::read(&tree))
            .map_err(|_| limit.late("the library's grains were proved", library::GRAINS))??;
        let of_pores = spec.voids.as_mut().and_then(|voids| voids.grading.as_mut());
        for grading in std::iter::once(&mut spec.grading).chain(of_pores) {
            if grading.classes_mm.is_empty() {
                grading.classes_mm = grading.usual_classes();
            }
        }
        if !size_given {
            spec.grading.size = spec.grading.curve.usual_size();
        }
        if !vertices_given {
            spec.shape.vertices = spec.shape.kind.usual_vertices();
        }
        if let Some(mix) = mix {
            spec.fraction = mix.fraction(&spec.grading).map_err(|error| error.at(&tree))?;
        }
        spec.placement.time_limit_s = reading.time_limit_s.or(spec.placement.time_limit_s);
        reading.watch.target(spec.fraction);
        let valid =
            if reading.is_found { spec.validate_described(reading.watch) } else { spec.validate_while(reading.watch) };
        valid.map_err(|error| error.at(&tree))?;
        if let Some(table) = table {
            table.say(&spec.grading, reading.files);
        }
        if let (Some(table), Some(grading)) = (pores, spec.voids.as_ref().and_then(|voids| voids.grading.as_ref())) {
            table.say(grading, reading.files);
        }
        Ok(spec)
    }
}

/// Refuses a grading of pores without limits, which have no usual sizes.
fn has_limits(grading: &tree::Node) -> Result<(), SpecError> {
    let missing = ["d_min_mm", "d_max_mm"].into_iter().find(|key| grading.child(key).is_none());
    let message = "is missing; pores have no usual diameters: give the smallest and the largest, in mm";
    missing.map_or(Ok(()), |key| {
        Err(SpecError { line: grading.line, ..SpecError::value(format!("grading.{key}"), message) })
    })
}

/// The fraction asked for, where it does not follow from a mix design.
fn plain_fraction(tree: &tree::Node) -> Option<f64> {
    match tree.child("fraction").map(|node| &node.value) {
        Some(&tree::Value::Float(fraction)) => Some(fraction),
        None if tree.child("mix").is_none() => Some(Spec::default().fraction),
        _ => None,
    }
}

/// Reads options outside a spec (a mesh's, a deck's) from a tree of values, with a spec's errors.
///
/// # Errors
/// Names the key and the way out: unknown keys and wrong types; values are for the options' own `validate`.
pub fn options_from_value<T: serde::de::DeserializeOwned>(value: &serde_json::Value) -> Result<T, SpecError> {
    read::read(&tree::from_json(value))
}

/// Reads options outside a spec from TOML text, with a spec's errors.
///
/// # Errors
/// Fails like [`options_from_value`], with the line; syntax; numbers that are not finite, which a tree of values cannot hold.
pub fn options_from_toml<T: serde::de::DeserializeOwned>(text: &str) -> Result<T, SpecError> {
    let tree = tree::parse_toml(text)?;
    tree.finite("")?;
    read::read(&tree)
}

/// The line of TOML text on which the key at a dotted `path` stands.
pub fn line_of(text: &str, path: &str) -> Option<usize> {
    tree::parse_toml(text).ok()?.line_at(path)
}
