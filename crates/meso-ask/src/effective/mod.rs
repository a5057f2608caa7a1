//! Effective properties of a packing or a label volume.

mod frames;

pub use frames::{FramePick, RunRecord};

use crate::axes::Axes;
use crate::files::{self, Reader};
use crate::flags::{names, values};
use crate::strains::{self, Strain};
use crate::{AskError, Giver, Machine};
use meso_concrete::{OutOfRange, Ranges};
use meso_core::import::ending;
use meso_core::import::volume::{self, Volume};
use meso_core::mesh::MethodName;
use meso_core::{Model, Spec, Watch, spec};
use meso_effective::results::{
    CURVE, FIGURES, Found, PAGE, field_ending, field_files, write_curve, write_curve_page, write_figures, write_page,
};
use meso_effective::{
    Boundary, CrackValues, Cracked, EffectiveError, EffectiveOptions, LabelPhases, LabelSpecimen, Phases, Property,
    PropertyField, StiffnessOptions, effective, effective_in_cracks, effective_in_tetrahedra, effective_of_labels,
    moduli_in_cracks, stiffness, stiffness_in_tetrahedra, stiffness_of_labels,
};
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::io::{self, Write};
use std::path::Path;

/// Effective diffusivity, conductivity, permeability and stiffness, each with its error.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema, clap::Args)]
#[serde(default, deny_unknown_fields)]
pub struct EffectiveAsk {
    /// Property
    #[arg(long, value_name = "PROPERTY", default_value = "diffusivity", value_parser = names::parser::<What>())]
    pub what: What,
    /// Values of the phases: a TOML file with the tables [diffusivity], [conductivity] and [permeability], each with mortar,
    /// aggregate, itz, void, fibre [default: diffusivity 1, 0, 1, 0, 0; conductivity 1.5, 3, 1.5, 0.025, 50 W/(m K);
    /// permeability 1e-11, 0, 1e-11, 0, 0 mm2], and with tables such as
    /// [stiffness.mortar], each with youngs_modulus_mpa, poisson_ratio, eigenstrain. A label volume takes labels as keys, too,
    /// as in 0 = 1.0
    #[arg(long, value_name = "FILE", value_parser = |file: &str| Ok::<_, String>(PhasesGiven::File(file.to_owned())))]
    pub phases: Option<PhasesGiven>,
    /// Edge of a voxel, mm; the error follows from voxels of twice the size [default: an eighth of the smallest grain; of a
    /// label volume, the file's, or else 1]
    #[arg(long, value_name = "H", value_parser = values::number)]
    #[arg(allow_negative_numbers = true, aliases = ["voxel-size", "size", "h"])]
    pub voxel_size_mm: Option<f64>,
    /// Division of a model: voxel, or lattice, tetrahedra whose faces follow the aggregates
    #[arg(long, value_name = "METHOD", default_value = "voxel", value_parser = names::parser::<MethodName>())]
    pub method: MethodName,
    /// Edge length of the tetrahedra, mm; the error follows from elements of twice the size [default: a quarter of the
    /// smallest grain]
    #[arg(long, value_name = "H", value_parser = values::number)]
    #[arg(allow_negative_numbers = true, aliases = ["element-size", "mesh-size"])]
    pub element_size_mm: Option<f64>,
    /// Strains without stress of the phases, which expand or shrink the specimen, as in mortar=-4e-4,itz=-4e-4
    #[arg(long, value_name = "PHASE=STRAIN", value_delimiter = ',', value_parser = strains::of_flag)]
    #[serde(with = "strains")]
    #[schemars(with = "std::collections::BTreeMap<String, f64>")]
    pub eigenstrain: Vec<Strain>,
    /// Axes along which a label volume repeats itself; without, it has walls
    #[arg(long, value_name = "AXES", value_parser = Axes::read)]
    pub periodic: Option<Axes>,
    /// Axes of the gradient; each takes a solution. Stiffness always has all
    #[arg(long, value_name = "AXES", default_value = "xyz", value_parser = Axes::read)]
    pub axes: Axes,
    /// Conditions at walls: fixed, given potentials at the ends of the gradient and insulated sides; uniform-gradient, an upper
    /// estimate, or uniform-flux, a lower one, in tetrahedra
    #[arg(long, value_name = "NAME", default_value = "fixed", value_parser = names::parser::<Boundary>())]
    pub boundary: Boundary,
    /// Error of the equations, over the result, beside that of the voxels [default: 1e-9; of stiffness 1e-12]
    #[arg(long, value_name = "SHARE", value_parser = values::number, allow_negative_numbers = true)]
    pub tolerance: Option<f64>,
    /// Write no fields
    #[arg(long)]
    pub no_fields: bool,
    /// Frame of a test: peak, last, all, its number from 1, or the strain that it is nearest to [default: peak]
    #[arg(long, value_name = "FRAME", value_parser = FramePick::read)]
    pub frame: Option<FramePick>,
    /// Diffusivity of what fills the cracks of a frame, in the unit of the phases [default: 200 times the mortar's, as of
    /// chloride in water]
    #[arg(long, value_name = "D", value_parser = values::number, allow_negative_numbers = true)]
    pub crack_diffusivity: Option<f64>,
    /// Conductivity of what fills the cracks of a frame, W/(m K) [default: 0.6, of water]
    #[arg(long, value_name = "K", value_parser = values::number, allow_negative_numbers = true)]
    pub crack_conductivity: Option<f64>,
    /// Permeability of the cracks of a frame over that of smooth ones, whose opening w gives w^2/12 [default: 1]
    #[arg(long, value_name = "SHARE", value_parser = values::number, allow_negative_numbers = true)]
    pub crack_roughness: Option<f64>,
}

/// A property, or all of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum What {
    /// Diffusivity, relative to the phases' own.
    #[default]
    Diffusivity,
    /// Conductivity of heat, W/(m K).
    Conductivity,
    /// Stiffness, MPa, and expansion.
    Stiffness,
    /// Permeability, mm2.
    Permeability,
    /// Diffusivity, conductivity and stiffness; of a frame permeability, too.
    All,
}

impl What {
    /// The properties of an input, `None` for stiffness.
    pub fn properties(self, input: Input) -> Vec<Option<Property>> {
        let [diffusivity, conductivity, permeability] =
            [Property::Diffusivity, Property::Conductivity, Property::Permeability].map(Some);
        match self {
            Self::Diffusivity => vec![diffusivity],
            Self::Conductivity => vec![conductivity],
            Self::Permeability => vec![permeability],
            Self::Stiffness => vec![None],
            Self::All if input == Input::Run => vec![diffusivity, conductivity, permeability, None],
            Self::All => vec![diffusivity, conductivity, None],
        }
    }
}

/// Where the values of the phases stand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum PhasesGiven {
    /// In a file of this name.
    File(String),
    /// In tables by property.
    Tables(Value),
}

/// What a property is asked of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// A saved model.
    Model,
    /// A label volume.
    Labels,
    /// A test with frames.
    Run,
}

impl Input {
    /// The kind of a file, by its ending.
    pub fn of_file(name: &str) -> Self {
        let is_volume = ending(name).is_some_and(|ending| volume::ENDINGS.contains(&ending.as_str()));
        if is_volume { Self::Labels } else { Self::Model }
    }
}

/// Values of the phases, read.
#[derive(Clone, Debug)]
pub enum PhaseTables {
    /// By phase.
    Packing(Box<Phases>),
    /// By label.
    Labels(LabelPhases),
}

/// What is known of a specimen before any work.
#[derive(Clone, Copy, Debug)]
pub enum Facts<'a> {
    /// The spec of a packing.
    Packing(&'a Spec),
    /// A label volume.
    Labels(&'a LabelSpecimen),
    /// A frame of a test.
    Frame(Cracked<'a>),
}

/// The specimen itself.
#[derive(Clone, Copy, Debug)]
pub enum Subject<'a> {
    /// A packing.
    Packing(&'a Model),
    /// A label volume.
    Labels(&'a LabelSpecimen),
    /// A frame of a test.
    Frame(Cracked<'a>),
}

impl<'a> Subject<'a> {
    fn facts(self) -> Facts<'a> {
        match self {
            Self::Packing(model) => Facts::Packing(&model.spec),
            Self::Labels(specimen) => Facts::Labels(specimen),
            Self::Frame(of) => Facts::Frame(of),
        }
    }
}

/// Properties of one specimen, with their fields.
#[derive(Default)]
pub struct Properties {
    /// Each property, and the seconds that it took.
    pub found: Vec<(Found, f64)>,
    fields: Vec<PropertyField>,
    /// Whether they are those of all frames of a test.
    of_all: bool,
}

impl Properties {
    /// Adds those of another frame.
    pub fn extend(&mut self, other: Self) {
        self.of_all |= other.of_all;
        self.found.extend(other.found);
        self.fields.extend(other.fields);
    }

    /// Hands every file to `fill`, by its name.
    ///
    /// # Errors
    /// The first of `fill`.
    pub fn write<E>(&self, mut fill: impl FnMut(&str, &Filling<'_>) -> Result<(), E>) -> Result<(), E> {
        let Self { found, fields, of_all } = self;
        fields.iter().try_for_each(|field| fill(&field.file(), &|out| field.write(out)))?;
        fill(FIGURES, &|out| write_figures(found, out))?;
        if *of_all {
            fill(CURVE, &|out| write_curve(found, out))?;
            return fill(PAGE, &|out| write_curve_page(found, out));
        }
        fill(PAGE, &|out| write_page(found, fields, out))
    }
}

/// Writes the content of a file.
pub type Filling<'a> = dyn Fn(&mut dyn Write) -> io::Result<()> + 'a;

/// The table of refusals.
const ASK: Ranges = Ranges("effective");

impl EffectiveAsk {
    /// Refuses options that contradict each other or their input, before anything is read.
    ///
    /// # Errors
    /// The option, its value and what would be accepted.
    pub fn accept(&self, input: Input) -> Result<(), OutOfRange> {
        let properties = self.what.properties(input);
        let has = |stiffness: bool| properties.iter().any(|property| property.is_none() == stiffness);
        let (is_flux, is_lattice) = (has(false), self.method == MethodName::Lattice);
        let method = names::of(&self.method);
        self.accept_frame(input)?;
        let fits = self.method != MethodName::Conforming;
        ASK.require("method", &method, fits, "it must be voxel or lattice")?;
        let accepted = "a label volume is its own voxels; take the method voxel";
        ASK.require("method", &method, input == Input::Model || !is_lattice, accepted)?;
        if let Some(size) = self.voxel_size_mm {
            let accepted = "only the method voxel takes it; tetrahedra have an element size";
            ASK.require("voxel_size_mm", size, !is_lattice, accepted)?;
        }
        if let Some(size) = self.element_size_mm {
            ASK.require("element_size_mm", size, is_lattice, "only the method lattice takes it")?;
        }
        let accepted = "a model's specimen has its own periods; only label volumes take it";
        let periodic = self.periodic.map(|axes| axes.to_string()).unwrap_or_default();
        ASK.require("periodic", periodic, self.periodic.is_none() || input == Input::Labels, accepted)?;
        let strains = strains::shown(&self.eigenstrain);
        let accepted = "only stiffness has strains; take what = stiffness or all";
        ASK.require("eigenstrain", strains, self.eigenstrain.is_empty() || has(true), accepted)?;
        let takes_any = is_flux || input == Input::Run || self.axes == Axes::ALL;
        ASK.require("axes", self.axes, takes_any, "stiffness takes all, xyz")?;
        let is_fixed = self.boundary == Boundary::Fixed;
        ASK.require("boundary", self.boundary.name(), is_flux || is_fixed, "stiffness takes fixed")?;
        self.boundary.accept_for(is_lattice)
    }

    /// Refuses options of frames without one, and of divisions with one.
    fn accept_frame(&self, input: Input) -> Result<(), OutOfRange> {
        let is_run = input == Input::Run;
        let cracks = [
            ("crack_diffusivity", self.crack_diffusivity),
            ("crack_conductivity", self.crack_conductivity),
            ("crack_roughness", self.crack_roughness),
        ];
        let own = cracks.map(|(key, value)| (key, value.map(|value| value.to_string())));
        let frame = ("frame", self.frame.map(|frame| frame.to_string()));
        for (key, value) in own.into_iter().chain([frame]).filter_map(|(key, value)| Some((key, value?))) {
            let accepted = "only the folder of a test has frames; name the one that `mesocrete solve` wrote";
            ASK.require(key, value, is_run, accepted)?;
        }
        let accepted = "a frame has the mesh of its test; leave it out";
        ASK.require("method", names::of(&self.method), !is_run || self.method == MethodName::Voxel, accepted)?;
        [("voxel_size_mm", self.voxel_size_mm), ("element_size_mm", self.element_size_mm)]
            .into_iter()
            .try_for_each(|(key, size)| ASK.require(key, size.unwrap_or_default(), !is_run || size.is_none(), accepted))
    }

    /// One task for each property, with all options in their ranges. `values` are those of the phases.
    ///
    /// # Errors
    /// Those of [`accept`](Self::accept); values out of range; a specimen that has no such property.
    pub fn settle(&self, of: Facts<'_>, mut values: PhaseTables) -> Result<Vec<EffectiveTask>, EffectiveError> {
        self.accept(of.input())?;
        if let Facts::Labels(specimen) = of {
            <Volume>::accept_edges("effective", &specimen.spacing_mm)?;
        }
        for (place, (name, strain)) in self.eigenstrain.iter().enumerate() {
            let is_new = self.eigenstrain[..place].iter().all(|(other, _)| other != name);
            ASK.require("eigenstrain", name, is_new, "it is given twice; keep one of the two")?;
            if let (Facts::Labels(specimen), Ok(label)) = (of, name.parse::<i64>()) {
                let is_there = specimen.volume.labels.contains(&label);
                ASK.require("eigenstrain", name, is_there, "the volume has no such label; leave it out")?;
            }
            let accepted =
                "its phases must be mortar, itz, aggregate, void, fibre, or one of the packing's own with values";
            let unknown = || ASK.error("eigenstrain", format!("{name}={strain:e}"), accepted);
            let moduli = match &mut values {
                PhaseTables::Packing(phases) => phases.stiffness.phase_mut(name).ok_or_else(unknown)?,
                PhaseTables::Labels(phases) => phases.stiffness.entry(name.clone()).or_default(),
            };
            moduli.eigenstrain = Some(*strain);
        }
        let cracks = CrackValues {
            diffusivity: self.crack_diffusivity,
            conductivity: self.crack_conductivity,
            roughness: self.crack_roughness,
        };
        let (in_tetrahedra, axes) = (self.method == MethodName::Lattice, self.axes.flags());
        let division = Division { in_tetrahedra, size_mm: self.size(of), cracks, axes };
        let task = |property: Option<Property>| {
            let work = self.work(property, division.size_mm);
            let bytes = work.accept(of, &values, division)?;
            Ok(EffectiveTask { work, values: values.clone(), division, bytes })
        };
        self.what.properties(of.input()).into_iter().map(task).collect()
    }

    /// Settles, and solves every property.
    ///
    /// # Errors
    /// Those of [`EffectiveAsk::settle`], a task beyond the memory, and equations that do not converge.
    pub fn answer(
        &self,
        of: Subject<'_>,
        values: PhaseTables,
        giver: Giver<'_>,
        machine: &Machine<'_>,
    ) -> Result<Properties, AskError> {
        let wrong = |error| Self::fault(&error, giver);
        let tasks = self.settle(of.facts(), values).map_err(wrong)?;
        tasks.iter().try_for_each(|task| task.accept(machine, giver))?;
        let of_all = self.frame == Some(FramePick::All);
        let mut properties = Properties { of_all, ..Properties::default() };
        for task in tasks {
            let begun = machine.tools.watch.seconds();
            let (found, fields) = task.solve(of, machine.tools.watch).map_err(wrong)?;
            properties.found.push((found, machine.tools.watch.seconds() - begun));
            properties.fields.extend(fields);
        }
        Ok(properties)
    }

    /// Values of the phases: of a file, of tables, or the usual ones.
    ///
    /// # Errors
    /// Options that contradict each other, a file that cannot be read, and unknown values.
    pub fn values(&self, input: Input, giver: Giver<'_>, read: &Reader<'_>) -> Result<PhaseTables, AskError> {
        self.accept(input).map_err(|wrong| AskError::Usage(giver.refusal(&wrong)))?;
        Ok(match input {
            Input::Model | Input::Run => PhaseTables::Packing(Box::new(self.phases(read)?)),
            Input::Labels => PhaseTables::Labels(self.phases(read)?),
        })
    }

    /// Puts values of one property, given without its name, into a table of its name.
    pub fn name_phases(&mut self) {
        let named = [Input::Model, Input::Run].map(|input| What::All.properties(input)).concat();
        let is_named = |key: &String| named.iter().any(|of| of.map_or("stiffness", Property::name) == key);
        if let Some(PhasesGiven::Tables(Value::Object(tables))) = &mut self.phases
            && self.what != What::All
            && !tables.keys().any(is_named)
        {
            let values = std::mem::take(tables);
            tables.insert(names::of(&self.what), Value::Object(values));
        }
    }

    fn phases<T: DeserializeOwned + Default>(&self, read: &Reader<'_>) -> Result<T, AskError> {
        match &self.phases {
            Some(PhasesGiven::File(path)) => files::toml(Path::new(path), read, spec::options_from_toml),
            Some(PhasesGiven::Tables(tables)) => {
                spec::options_from_value(tables).map_err(|error| AskError::Usage(error.to_string()))
            }
            None => Ok(T::default()),
        }
    }

    /// An error in the giver's spelling.
    pub fn fault(error: &EffectiveError, giver: Giver<'_>) -> AskError {
        match error {
            EffectiveError::Value(value) if value.table == "effective" => AskError::Usage(giver.refusal(value)),
            EffectiveError::Diverged { .. } => AskError::Run(error.to_string()),
            EffectiveError::Mesh(error) => AskError::Usage(error.message(|key| giver.option(key))),
            _ => AskError::Usage(error.to_string()),
        }
    }

    /// Names of the files that a run writes.
    pub fn files(&self, input: Input) -> Vec<String> {
        let ending = field_ending(self.method == MethodName::Lattice || input == Input::Run);
        let properties = self.what.properties(input).into_iter().filter(|_| self.has_fields());
        let fields = properties.flat_map(|what| match what {
            Some(_) => {
                let files = field_files(what, ending).into_iter().zip(self.axes.flags());
                files.filter(|(_, is_asked)| *is_asked).map(|(file, _)| file).collect()
            }
            None if input == Input::Run => Vec::new(),
            None => field_files(None, ending),
        });
        let curve = (self.frame == Some(FramePick::All)).then(|| CURVE.to_owned());
        [FIGURES, PAGE].map(str::to_owned).into_iter().chain(curve).chain(fields).collect()
    }

    /// Whether fields are written; those of all frames would be.
    fn has_fields(&self) -> bool {
        !self.no_fields && self.frame != Some(FramePick::All)
    }

    /// Edge of a voxel or a tetrahedron, mm.
    fn size(&self, of: Facts<'_>) -> f64 {
        match (of, self.method) {
            (Facts::Labels(specimen), _) => specimen.spacing_mm[0],
            // It has a mesh.
            (Facts::Frame(_), _) => 0.0,
            (Facts::Packing(spec), MethodName::Lattice) => {
                self.element_size_mm.unwrap_or_else(|| EffectiveOptions::default_element_size(spec.grading.d_min_mm))
            }
            (Facts::Packing(spec), _) => {
                self.voxel_size_mm.unwrap_or_else(|| EffectiveOptions::default_voxel_size(spec.grading.d_min_mm))
            }
        }
    }

    fn work(&self, property: Option<Property>, size_mm: f64) -> Work {
        let (axes, fields, boundary) = (self.axes.flags(), self.has_fields(), self.boundary);
        match property {
            Some(what) => {
                let usual = EffectiveOptions::new(what, size_mm);
                let tolerance = self.tolerance.unwrap_or(usual.tolerance);
                Work::Flux(EffectiveOptions { axes, fields, tolerance, boundary, ..usual })
            }
            None => {
                let usual = StiffnessOptions::new(size_mm);
                let tolerance = self.tolerance.unwrap_or(usual.tolerance);
                Work::Stiffness(StiffnessOptions { fields, tolerance, ..usual })
            }
        }
    }
}

impl Facts<'_> {
    fn input(&self) -> Input {
        match self {
            Self::Packing(_) => Input::Model,
            Self::Labels(_) => Input::Labels,
            Self::Frame(_) => Input::Run,
        }
    }
}

/// How a specimen is divided, and what fills its cracks.
#[derive(Clone, Copy, Debug)]
struct Division {
    in_tetrahedra: bool,
    size_mm: f64,
    cracks: CrackValues,
    axes: [bool; 3],
}

/// A property with its options.
#[derive(Clone, Copy, Debug)]
enum Work {
    Flux(EffectiveOptions),
    Stiffness(StiffnessOptions),
}

impl Work {
    /// Refuses what `of` cannot have; the memory that it takes at most, bytes.
    fn accept(&self, of: Facts<'_>, values: &PhaseTables, division: Division) -> Result<f64, EffectiveError> {
        match (self, of, values) {
            (Self::Flux(options), Facts::Packing(spec), PhaseTables::Packing(phases)) => {
                let specimen = &spec.specimen;
                phases.values(options.what).validate(options.what, &spec.phases())?;
                match division.in_tetrahedra {
                    true => options.bytes_in_tetrahedra(specimen, division.size_mm),
                    false => options.bytes(specimen),
                }
            }
            (Self::Stiffness(options), Facts::Packing(spec), PhaseTables::Packing(phases)) => {
                let specimen = &spec.specimen;
                phases.stiffness.validate(&spec.phases())?;
                match division.in_tetrahedra {
                    true => options.bytes_in_tetrahedra(specimen, division.size_mm),
                    false => options.bytes(specimen),
                }
            }
            (Self::Flux(options), Facts::Labels(LabelSpecimen { volume, .. }), PhaseTables::Labels(phases)) => {
                phases.values(options.what, volume)?;
                Ok(options.bytes_of(volume.counts))
            }
            (Self::Stiffness(options), Facts::Labels(LabelSpecimen { volume, .. }), PhaseTables::Labels(phases)) => {
                phases.moduli(volume)?;
                Ok(options.bytes_of(volume.counts))
            }
            (Self::Flux(options), Facts::Frame(of), PhaseTables::Packing(phases)) => {
                of.accept(phases, &division.cracks, options)
            }
            (Self::Stiffness(options), Facts::Frame(of), PhaseTables::Packing(phases)) => {
                of.accept_moduli(&phases.stiffness, options.tolerance)
            }
            (_, Facts::Packing(_) | Facts::Frame(_), PhaseTables::Labels(_))
            | (_, Facts::Labels(_), PhaseTables::Packing(_)) => Err(mismatch()),
        }
    }
}

/// The error of a specimen that is another one than the one settled for.
fn mismatch() -> EffectiveError {
    ASK.error("phases", "of another input", "a model has values by phase, a label volume by label").into()
}

/// One property of one specimen, settled: nothing is refused any more but what its solution shows.
#[derive(Clone, Debug)]
pub struct EffectiveTask {
    work: Work,
    values: PhaseTables,
    division: Division,
    /// Memory that it takes at most, bytes.
    pub bytes: f64,
}

impl EffectiveTask {
    /// Name of the property.
    pub fn name(&self) -> &'static str {
        match &self.work {
            Work::Flux(options) => options.what.name(),
            Work::Stiffness(_) => "stiffness",
        }
    }

    /// The option of a model's size of voxels or tetrahedra, and its value, mm.
    pub fn size(&self) -> (&'static str, f64) {
        let Division { in_tetrahedra, size_mm, .. } = self.division;
        (if in_tetrahedra { "element_size_mm" } else { "voxel_size_mm" }, size_mm)
    }

    /// Refuses a task beyond the memory.
    ///
    /// # Errors
    /// The bytes that it takes, with a size that fits.
    pub fn accept(&self, machine: &Machine<'_>, giver: Giver<'_>) -> Result<(), AskError> {
        let (name, (key, size)) = (self.name(), self.size());
        if let PhaseTables::Labels(_) = &self.values {
            let work = format!("the {name} of the volume");
            return machine.accept_bytes(&work, self.bytes, |_| "cut a part out of the image".to_owned());
        }
        if size == 0.0 {
            let work = format!("the {name} of the frame");
            let fix = |_| "solve the test with larger elements".to_owned();
            return machine.accept_bytes(&work, self.bytes, fix);
        }
        let cells = if self.division.in_tetrahedra { "tetrahedra" } else { "voxels" };
        let work = format!("the {name} of {cells} of {size} mm");
        machine.accept_in_memory(&work, self.bytes, (&giver.option(key), size))
    }

    /// Solves it.
    ///
    /// # Errors
    /// Those that only the solution shows, such as equations that do not converge.
    pub fn solve(&self, of: Subject<'_>, watch: &dyn Watch) -> Result<(Found, Vec<PropertyField>), EffectiveError> {
        let Division { in_tetrahedra, size_mm: size, cracks, axes } = self.division;
        let flux = |(found, fields)| (Found::Flux(Box::new(found)), fields);
        let elastic = |(found, fields)| (Found::Stiffness(Box::new(found)), fields);
        match (self.work, of, &self.values) {
            (Work::Flux(options), Subject::Packing(model), PhaseTables::Packing(phases)) => match in_tetrahedra {
                true => effective_in_tetrahedra(model, phases, &options, size, watch).map(flux),
                false => effective(model, phases, &options, watch).map(flux),
            },
            (Work::Flux(options), Subject::Labels(specimen), PhaseTables::Labels(phases)) => {
                effective_of_labels(specimen, phases, &options, watch).map(flux)
            }
            (Work::Flux(options), Subject::Frame(of), PhaseTables::Packing(phases)) => {
                effective_in_cracks(&of, phases, &cracks, &options, watch).map(flux)
            }
            (Work::Stiffness(options), Subject::Packing(model), PhaseTables::Packing(phases)) => match in_tetrahedra {
                true => stiffness_in_tetrahedra(model, &phases.stiffness, &options, size, watch).map(elastic),
                false => stiffness(model, &phases.stiffness, &options, watch).map(elastic),
            },
            (Work::Stiffness(options), Subject::Labels(specimen), PhaseTables::Labels(phases)) => {
                stiffness_of_labels(specimen, phases, &options, watch).map(elastic)
            }
            (Work::Stiffness(options), Subject::Frame(of), PhaseTables::Packing(phases)) => {
                let found = moduli_in_cracks(&of, &phases.stiffness, axes, options.tolerance, watch)?;
                Ok((Found::Unloading(Box::new(found)), Vec::new()))
            }
            _ => Err(mismatch()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Giver;

    fn ask(value: serde_json::Value) -> EffectiveAsk {
        serde_json::from_value(value).unwrap()
    }

    #[test]
    fn options_that_contradict_each_other_are_refused_before_anything_is_read() {
        for (input, asked, said) in [
            (Input::Model, r#"{"method": "conforming"}"#, "--method is conforming; it must be voxel or lattice"),
            (Input::Labels, r#"{"method": "lattice"}"#, "--method is lattice; a label volume is its own voxels"),
            (
                Input::Model,
                r#"{"method": "lattice", "voxel_size_mm": 2}"#,
                "--voxel-size-mm is 2; only the method voxel",
            ),
            (Input::Model, r#"{"element_size_mm": 2}"#, "--element-size-mm is 2; only the method lattice takes it"),
            (Input::Model, r#"{"periodic": "xy"}"#, "--periodic is xy; a model's specimen has its own periods"),
            (
                Input::Model,
                r#"{"eigenstrain": {"mortar": -4e-4}}"#,
                "--eigenstrain is mortar=-4e-4; only stiffness has",
            ),
            (Input::Model, r#"{"what": "stiffness", "axes": "x"}"#, "--axes is x; stiffness takes all, xyz"),
            (
                Input::Model,
                r#"{"boundary": "uniform-flux"}"#,
                "--boundary is uniform-flux; voxels have fixed; take the",
            ),
            (
                Input::Model,
                r#"{"what": "stiffness", "boundary": "uniform-flux"}"#,
                "--boundary is uniform-flux; stiffness takes fixed",
            ),
        ] {
            let wrong = ask(serde_json::from_str(asked).unwrap()).accept(input).expect_err(asked);
            let refusal = Giver::Flags.refusal(&wrong);
            assert!(refusal.starts_with(said), "{asked}: {refusal}");
        }
        for (input, asked) in [
            (Input::Model, r#"{"what": "all", "axes": "x", "eigenstrain": {"mortar": 1e-4}}"#),
            (Input::Model, r#"{"method": "lattice", "boundary": "uniform-flux"}"#),
            (Input::Labels, r#"{"periodic": "z", "voxel_size_mm": 0.1}"#),
        ] {
            assert_eq!(ask(serde_json::from_str(asked).unwrap()).accept(input), Ok(()), "{asked}");
        }
    }

    #[test]
    fn a_request_reads_back_as_it_was_written() {
        let asked = ask(serde_json::json!({ "what": "all", "eigenstrain": { "itz": 1e-5 }, "axes": "yz" }));
        assert_eq!(ask(serde_json::to_value(&asked).unwrap()), asked);
        assert_eq!(asked.files(Input::Model).len(), 2 + 2 + 2 + 6);
        assert_eq!(asked.files(Input::Run).len(), 2 + 2 + 2 + 2);
    }
}
