//! The steps of a case: pack, write, mesh, test, effective properties.
//!
//! A step is a request of `meso-ask` with the files that it writes. Its options stand in a section of the case's task. Its
//! figures come from the values in memory, and so do those of the next step.

mod section;
mod work;

use crate::{Keep, MODELS, NameError, Names, RECORD, of_packing};
use meso_ask::files::Reader;
use meso_ask::{AskError, Giver, Input, Machine};
use meso_core::formats::{Format, SurfaceOptions};
use meso_core::mesh::Tools;
use meso_core::{Model, Spec, Watch};
use meso_files::free;
use meso_files::whole::{Keeper, Unit};
use meso_gmsh::Gmsh;
use meso_solve::Run;
use section::Section;
use serde_json::{Map, Value};
use std::any::Any;
use std::cell::Cell;
use std::path::Path;
use work::{EffectiveStep, MESH_SUMMARY, MeshStep, SolveStep};

pub(crate) use work::{commit, file_error, fill};

/// Finds the device of a name and, if there is a run, puts it there.
pub type Devices<'a> = dyn Fn(&str, Option<&mut Run<'_>>) -> Result<Attached, AskError> + Sync + 'a;

/// A run on its device.
#[derive(Default)]
pub struct Attached {
    /// The doubt about a device that cannot keep the results.
    pub doubt: Option<String>,
    /// Keeps the device until the run is over.
    pub hold: Option<Box<dyn Any>>,
}

/// Steps of one case.
pub struct Steps {
    /// Files of the packing.
    outputs: Vec<(String, Format)>,
    keep: Keep,
    mesh: Option<MeshStep>,
    solve: Option<SolveStep>,
    effective: Option<EffectiveStep>,
}

/// How the steps of a case are done.
pub struct Doing<'a, K> {
    /// Receives the stages, and says when to stop.
    pub watch: &'a dyn Watch,
    /// Keeps the files that are written.
    pub keeper: K,
    /// The program gmsh.
    pub gmsh: &'a Gmsh,
    /// Devices that take the steps of tests.
    pub devices: &'a Devices<'a>,
    /// Receives a `warning` or an `error`, and its text.
    pub tell: &'a (dyn Fn(&str, &str) + Sync),
}

impl Steps {
    /// Reads the steps of a case from its task; the files that they name lie in `folder`, and `giver` spells the options of a
    /// section.
    ///
    /// # Errors
    /// Unknown options, values that no packing can have, and names of files that two steps use.
    pub fn of(
        task: &Value,
        keep: Keep,
        folder: &Path,
        giver: &dyn Fn(&'static str) -> Giver<'static>,
        read: &Reader<'_>,
    ) -> Result<Self, AskError> {
        let section = |name: &'static str| Section::of(task, name, giver(name), folder);
        let mesh = section("mesh")?.map(|section| MeshStep::of(section, read)).transpose()?;
        let solve = section("solve")?.map(|section| SolveStep::of(section, task.get("test"), read)).transpose()?;
        let effective = section("effective")?;
        let effective = effective.map(|section| EffectiveStep::of(section, giver("effective"), read)).transpose()?;
        let outputs = task.get("outputs").and_then(Value::as_array).into_iter().flatten();
        let outputs = outputs
            .map(|name| packing_file(name.as_str().unwrap_or_default(), giver("mesh")))
            .collect::<Result<_, _>>()?;
        let steps = Self { outputs, keep, mesh, solve, effective };
        steps.claim().map_err(|error| AskError::Usage(error.to_string()))?;
        Ok(steps)
    }

    /// Refuses files that two steps would write under one name.
    fn claim(&self) -> Result<(), NameError> {
        let mut names = Names::default();
        let summary = self.mesh.as_ref().map(|_| MESH_SUMMARY);
        let own = [self.keep.model(), RECORD].into_iter().chain(summary);
        own.into_iter().try_for_each(|name| names.claim("the study", name))?;
        self.solve.as_ref().map_or(Ok(()), |_| SolveStep::claim("[solve]", &mut names))?;
        let properties = self.effective.as_ref().map_or_else(Vec::new, |step| step.ask.files(Input::Model));
        properties.iter().try_for_each(|name| names.claim("[effective]", name))?;
        self.outputs.iter().try_for_each(|(name, _)| names.claim("outputs", name))?;
        self.mesh.as_ref().map_or(Ok(()), |mesh| mesh.claim("[mesh] output", &mut names))
    }

    /// Refuses options that the packing of `spec` cannot be meshed or tested with on a machine, and a missing gmsh or device.
    ///
    /// # Errors
    /// The option, in the giver's spelling.
    pub fn accept(&self, spec: &Spec, machine: &Machine<'_>, devices: &Devices<'_>) -> Result<(), AskError> {
        self.mesh.as_ref().map_or(Ok(()), |mesh| mesh.accept(spec, machine))?;
        self.effective.as_ref().map_or(Ok(()), |effective| effective.accept(spec, machine))?;
        self.solve.as_ref().map_or(Ok(()), |solve| solve.accept(spec, machine, devices))
    }

    /// Finds out whether this machine has the device of the test.
    ///
    /// # Errors
    /// The device, with the remedy.
    pub fn find_device(&self, devices: &Devices<'_>) -> Result<(), AskError> {
        self.solve.as_ref().map_or(Ok(()), |solve| solve.find_device(devices))
    }

    /// Memory that the mesh and the test of `spec` take at most, bytes, on any machine.
    pub fn memory(&self, spec: &Spec, gmsh: &Gmsh) -> f64 {
        let asked = Cell::new(0.0);
        let machine = Machine { memory: None, tools: Tools { gmsh, ..Tools::default() }, asked: Some(&asked) };
        // A refusal is that of `accept`.
        let _ = self.accept(spec, &machine, &|_, _| Ok(Attached::default()));
        asked.get()
    }

    /// Names of the files of the packing and its mesh.
    pub fn files(&self) -> impl Iterator<Item = &str> {
        let packings = self.outputs.iter().map(|(name, _)| name.as_str());
        packings.chain(self.mesh.iter().flat_map(MeshStep::files))
    }

    /// The spec of a case, with the gaps that its mesh and its test need.
    ///
    /// # Errors
    /// Options that do not fit the specimen.
    pub fn spec(&self, spec: &Spec, watch: &dyn Watch) -> Result<Spec, AskError> {
        let mut spec = spec.clone();
        self.mesh.as_ref().map_or(Ok(()), |mesh| mesh.leave_room(&mut spec, watch))?;
        self.solve.as_ref().map_or(Ok(()), |solve| solve.leave_room(&mut spec, watch))?;
        Ok(spec)
    }

    /// Packs the spec of a case.
    ///
    /// # Errors
    /// A spec that cannot be packed.
    pub fn pack(&self, spec: &Spec, watch: &dyn Watch) -> Result<Model, AskError> {
        let spec = self.spec(spec, watch)?;
        meso_core::pack(&spec, watch).map_err(|error| AskError::Usage(error.to_string()))
    }

    /// Does the steps after the packing in the folder of a case; the results of all.
    ///
    /// # Errors
    /// The fault of a step, and the errors of a test, whose files are then there.
    pub fn run<K: Keeper + Copy>(
        &self,
        model: &Model,
        folder: &Path,
        doing: &Doing<'_, K>,
    ) -> Result<Map<String, Value>, AskError> {
        self.write(model, folder, doing.keeper)?;
        let (mut results, mut errors) = (of_packing(&model.report), Vec::new());
        if let Some(mesh) = &self.mesh {
            results.insert("mesh".to_owned(), mesh.run(model, folder, doing)?);
        }
        let tested = self.solve.as_ref().map(|solve| solve.run(model, folder, doing)).transpose()?;
        let goes_on = tested.as_ref().is_none_or(|tested| tested.is_over);
        if let Some(tested) = tested {
            results.insert("solve".to_owned(), tested.figures);
            errors = tested.errors;
        }
        if let Some(effective) = self.effective.as_ref().filter(|_| goes_on) {
            results.insert("effective".to_owned(), effective.run(model, folder, doing)?);
        }
        self.keep.tidy(folder).map_err(|error| file_error(folder, &error))?;
        match (errors.is_empty(), goes_on) {
            (true, true) => Ok(results),
            (true, false) => Err(AskError::Run("the test has no valid end; result.json says why".to_owned())),
            (false, _) => Err(AskError::Run(errors.join("; "))),
        }
    }

    /// Writes the packing; a saved model that is there is that of the case.
    fn write<K: Keeper + Copy>(&self, model: &Model, folder: &Path, keeper: K) -> Result<(), AskError> {
        let mut unit = Unit::unforced(keeper);
        let format = if self.keep == Keep::JsonGz { Format::JsonGz } else { Format::Json };
        let saved = (self.keep.model().to_owned(), format);
        let is_saved = MODELS.iter().any(|name| folder.join(name).is_file());
        for (name, format) in (!is_saved).then_some(&saved).into_iter().chain(&self.outputs) {
            fill(&mut unit, &folder.join(name), |out| format.write(model, SurfaceOptions::default(), out))?;
        }
        commit(unit)
    }
}

impl<K> Doing<'_, K> {
    fn tell(&self, word: &str, text: &str) {
        (self.tell)(word, text);
    }

    fn warn(&self, text: &str) {
        self.tell("warning", text);
    }

    fn on_machine<T>(&self, work: impl FnOnce(&Machine<'_>) -> T) -> T {
        let stops = || self.watch.stops();
        let tools = Tools { gmsh: &self.gmsh.until(&stops), watch: self.watch };
        work(&Machine { memory: free::memory(), tools, asked: None })
    }
}

/// A file of the packing.
fn packing_file(name: &str, mesh: Giver<'_>) -> Result<(String, Format), AskError> {
    let format = Format::from_path(Path::new(name)).ok_or_else(|| {
        let known = Format::ALL.map(|format| format!(".{}", format.extension())).join(", ");
        let meshes = mesh.option("output");
        AskError::Usage(format!("outputs has {name:?}; it must end in one of {known}; meshes go to {meshes}"))
    })?;
    Ok((name.to_owned(), format))
}
