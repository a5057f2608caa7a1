//! A mesh, a test and effective properties of a packing: what is asked, what it writes, its figures.

use super::section::Section;
use super::{Attached, Devices, Doing};
use crate::results::{of_effective, of_summary};
use crate::{NameError, Names};
use meso_ask::files::{self, Reader};
use meso_ask::{
    AskError, DeckAsk, EffectiveAsk, Facts, Giver, Input, Machine, MeshAsk, MeshFigures, PhaseTables, SolveAsk,
    Subject, TestGiven, strict_doubt,
};
use meso_core::export::abaqus::{Analysis, DeckOptions};
use meso_core::formats::{MeshFormat, SurfaceOptions};
use meso_core::materials::Materials;
use meso_core::mesh::MeshTable;
use meso_core::spec::options_from_value;
use meso_core::{Model, Spec, Watch};
use meso_files::whole::{Keeper, Unit};
use meso_solve::results::{Moment, Outcome, ResultFile, Shooting, Snapshot, Source, Still, TestSeconds, figures};
use meso_solve::{Ended, Frame, Observer, Row, Test};
use serde_json::Value;
use std::cell::RefCell;
use std::io::{self, Write};
use std::path::Path;

/// The figures of a case's mesh.
pub(super) const MESH_SUMMARY: &str = "mesh.json";

/// A mesh with its files.
pub(super) struct MeshStep {
    ask: DeckAsk,
    outputs: Vec<(String, MeshFormat)>,
    compress: bool,
    strict: bool,
}

/// Keys of the options of `T`.
fn keys<T: serde::Serialize + Default>() -> Vec<String> {
    let tree = serde_json::to_value(T::default()).unwrap_or_default();
    tree.as_object().map(|options| options.keys().cloned().collect()).unwrap_or_default()
}

/// The mesh of a section.
fn mesh_ask(section: &mut Section<'_>, read: &Reader<'_>) -> Result<MeshAsk, AskError> {
    let materials = match section.value("materials") {
        None => Materials::default(),
        Some(Value::String(name)) => files::materials(&section.file(&name), read)?,
        Some(table @ Value::Object(_)) => section.read("materials", &table)?,
        Some(other) => return Err(section.wrong("materials", &other, "it must be a file or a table of values")),
    };
    Ok(MeshAsk {
        given: section.take::<MeshTable>(&[])?,
        accept_phase_error: section.switch("accept_phase_error")?,
        materials: Some(materials),
        ..MeshAsk::default()
    })
}

impl MeshStep {
    pub(super) fn of(mut section: Section<'_>, read: &Reader<'_>) -> Result<Self, AskError> {
        let outputs = section.names("output")?;
        if outputs.is_empty() {
            return Err(section.missing("output", "name the files of the mesh, e.g. mesh.inp"));
        }
        let format = |name: String| match MeshFormat::from_path(Path::new(&name)) {
            Some(format) => Ok((name, format)),
            None => {
                let known = MeshFormat::ALL.map(|format| format!(".{}", format.extension())).join(", ");
                Err(section.wrong("output", &name.into(), &format!("its extension must be one of {known}")))
            }
        };
        let outputs = outputs.into_iter().map(format).collect::<Result<_, _>>()?;
        let analysis = match section.value("analysis") {
            None => Analysis::None,
            Some(Value::String(name)) if files::is_toml(Path::new(&name)) => {
                files::test(&section.file(&name), read)?.into()
            }
            Some(table @ Value::Object(_)) => section.test("analysis", table)?.into(),
            Some(word) => section.read("analysis", &word)?,
        };
        let ask = DeckAsk {
            mesh: mesh_ask(&mut section, read)?,
            given: section.take::<DeckOptions>(&[])?,
            analysis: Some(analysis),
        };
        let step = Self { ask, outputs, compress: section.switch("compress")?, strict: section.switch("strict")? };
        let known = [keys::<MeshTable>(), keys::<DeckOptions>()].concat();
        section.end(&known.iter().map(String::as_str).collect::<Vec<_>>())?;
        step.ask.accept(&step.formats())?;
        let surfaces = SurfaceOptions { compress: step.compress, ..SurfaceOptions::default() };
        let accepted = surfaces.accept(&[], &step.formats());
        accepted.map_err(|error| AskError::Usage(step.ask.given.refusal(&error)))?;
        Ok(step)
    }

    fn formats(&self) -> Vec<MeshFormat> {
        self.outputs.iter().map(|(_, format)| *format).collect()
    }

    pub(super) fn accept(&self, spec: &Spec, machine: &Machine<'_>) -> Result<(), AskError> {
        self.ask.settle(spec, &self.formats(), machine).map(drop)
    }

    pub(super) fn leave_room(&self, spec: &mut Spec, watch: &dyn Watch) -> Result<(), AskError> {
        self.ask.mesh.leave_room(self.ask.purpose(), spec, watch).map(drop)
    }

    pub(super) fn files(&self) -> impl Iterator<Item = &str> {
        self.outputs.iter().map(|(name, _)| name.as_str())
    }

    /// Claims the name of every file of the mesh.
    pub(super) fn claim(&self, owner: &str, names: &mut Names) -> Result<(), NameError> {
        for (name, format) in &self.outputs {
            names.claim(owner, name)?;
            match format {
                format if self.ask.has_script(*format) => {
                    names.claim(owner, &DeckOptions::curve_path(Path::new(name)).to_string_lossy())?;
                }
                MeshFormat::Pvtu => {
                    let stem = Path::new(name).file_stem().unwrap_or_default().to_string_lossy();
                    names.claim_series(owner, &format!("{stem}_"), ".vtu")?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Meshes, and writes the files; the figures.
    pub(super) fn run<K: Keeper + Copy>(
        &self,
        model: &Model,
        folder: &Path,
        doing: &Doing<'_, K>,
    ) -> Result<Value, AskError> {
        let (settled, (mesh, off)) = doing.on_machine(|machine| {
            let mut settled = self.ask.settle_for(model, &self.formats(), machine)?;
            let mesh = self.ask.answer(&mut settled, model, &machine.tools)?;
            Ok::<_, AskError>((settled, mesh))
        })?;
        let deck = &settled.deck;
        let mut unit = Unit::unforced(doing.keeper);
        for (name, format) in &self.outputs {
            for file in format.files(&folder.join(name), &mesh, deck) {
                fill(&mut unit, &file.path, |out| file.write(&mesh, deck, self.compress, out))?;
            }
        }
        let figures = MeshFigures::of(&mesh, model, &settled);
        fill(&mut unit, &folder.join(MESH_SUMMARY), |out| {
            serde_json::to_writer_pretty(&mut *out, &figures)?;
            writeln!(out)
        })?;
        commit(unit)?;
        if let Some(doubt) = strict_doubt(off, &mesh, self.ask.mesh.given.giver()).filter(|_| self.strict) {
            return Err(AskError::Run(format!("{doubt}; mesh.json has all phases")));
        }
        tree(&figures).map(|figures| of_summary(&figures))
    }
}

/// A test with its files.
pub(super) struct SolveStep {
    ask: SolveAsk,
    device: String,
}

/// The processor, which is no device.
const CPU: &str = "cpu";

impl SolveStep {
    /// The test of a section; `table` gives it by the keys of a TEST.toml.
    pub(super) fn of(mut section: Section<'_>, table: Option<&Value>, read: &Reader<'_>) -> Result<Self, AskError> {
        let (base, from) = match (section.value("test"), table) {
            (None, Some(table)) => {
                let test = options_from_value(table).map_err(|error| AskError::Usage(format!("[test] {error}")))?;
                (test, TestGiven::Table)
            }
            (None, None) => (Test::default(), TestGiven::Named),
            (Some(Value::String(name)), _) if files::is_toml(Path::new(&name)) => {
                let path = section.file(&name);
                (files::test(&path, read)?, TestGiven::File(path.display().to_string()))
            }
            (Some(table @ Value::Object(_)), _) => (section.test("test", table)?, TestGiven::Named),
            (Some(word), _) => (Test { kind: section.read("test", &word)?, ..Test::default() }, TestGiven::Named),
        };
        let device = match section.value("device") {
            None => CPU.to_owned(),
            Some(Value::String(name)) => name,
            Some(other) => return Err(section.wrong("device", &other, "it must be a name, such as cpu or gpu")),
        };
        let (all, of_mesh, mesh) = (keys::<Test>(), keys::<MeshTable>(), mesh_ask(&mut section, read)?);
        let all: Vec<&str> = all.iter().map(String::as_str).filter(|key| *key != "kind").collect();
        let given = section.take::<Test>(&all)?;
        let (brush, on_device) = (section.switch("brush")?, device != CPU);
        let ask = SolveAsk { mesh, base: Some(base), from, given, brush, on_device, is_first: false };
        section.end(&[&all[..], &of_mesh.iter().map(String::as_str).collect::<Vec<_>>()].concat())?;
        ask.accept()?;
        Ok(Self { ask, device })
    }

    pub(super) fn accept(&self, spec: &Spec, machine: &Machine<'_>, devices: &Devices<'_>) -> Result<(), AskError> {
        self.find_device(devices)?;
        self.ask.settle(spec, machine).map(drop)
    }

    /// Finds out whether this machine has the device.
    pub(super) fn find_device(&self, devices: &Devices<'_>) -> Result<(), AskError> {
        if self.ask.on_device { devices(&self.device, None).map(drop) } else { Ok(()) }
    }

    pub(super) fn leave_room(&self, spec: &mut Spec, watch: &dyn Watch) -> Result<(), AskError> {
        self.ask.leave_room(spec, watch)
    }

    /// Claims the name of every file of the results.
    pub(super) fn claim(owner: &str, names: &mut Names) -> Result<(), NameError> {
        let [prefix, suffix] = Moment::FILES;
        names.claim_series(owner, prefix, suffix)?;
        ResultFile::ALL.iter().try_for_each(|file| names.claim(owner, file.name()))
    }

    /// Meshes and tests, and writes the results; the figures. A test that was stopped writes none.
    pub(super) fn run<K: Keeper + Copy>(
        &self,
        model: &Model,
        folder: &Path,
        doing: &Doing<'_, K>,
    ) -> Result<Tested, AskError> {
        let (ask, watch) = (&self.ask, doing.watch);
        let (started, mut seconds) = (watch.seconds(), TestSeconds::default());
        let (footing, mesh) = doing.on_machine(|machine| {
            let footing = ask.settle_for(model, machine)?;
            let begun = watch.seconds();
            let (mesh, _) = ask.mesh.mesh(&footing, model, &machine.tools)?;
            seconds.mesh = watch.seconds() - begun;
            Ok::<_, AskError>((footing, mesh))
        })?;
        let (source, begun) = (Source::of(model, &footing.options), watch.seconds());
        let mut run = ask.begin(&mesh, model, &footing, |doubt| doing.warn(doubt))?;
        let attached = if ask.on_device { (doing.devices)(&self.device, Some(&mut run))? } else { Attached::default() };
        attached.doubt.iter().for_each(|doubt| doing.warn(doubt));
        let filming = Filming {
            mesh: &mesh,
            folder,
            unit: RefCell::new(Unit::unforced(doing.keeper)),
            still: RefCell::default(),
            frames: RefCell::default(),
            failed: RefCell::default(),
            shooting: Shooting::default(),
        };
        let response = run.to_end(watch, &filming);
        seconds.solve = watch.seconds() - begun;
        let result = &response.result;
        if result.ended == Ended::Stopped {
            return Err(AskError::Run("stopped".to_owned()));
        }
        let last = Snapshot::last(&run, &result.ended);
        // The device is given back once nothing of the run is left there.
        drop((run, attached));
        seconds.total = watch.seconds() - started;
        result.late_warnings().for_each(|doubt| doing.warn(&doubt));
        result.errors.iter().for_each(|error| doing.tell("error", error));
        result.flagged().iter().for_each(|found| doing.warn(found));
        let Filming { unit, frames, failed, shooting, .. } = filming;
        failed.into_inner().map_or(Ok(()), Err)?;
        let (mut unit, frames, taken) = (unit.into_inner(), frames.into_inner(), shooting.taken());
        let outcome = Outcome {
            mesh: &mesh,
            response: &response,
            source: &source,
            frames: &frames,
            taken: &taken,
            last: last.as_ref(),
            seconds,
        };
        for file in ResultFile::ALL {
            fill(&mut unit, &folder.join(file.name()), |out| file.write(&outcome, out))?;
        }
        commit(unit)?;
        let figures = figures(&outcome).map_err(|error| AskError::Run(error.to_string()))?;
        let is_over = result.ended == Ended::Completed;
        Ok(Tested { figures: of_summary(&figures), errors: result.errors.clone(), is_over })
    }
}

/// A test that came to an end.
pub(super) struct Tested {
    pub(super) figures: Value,
    pub(super) errors: Vec<String>,
    /// Whether it came to the end that was asked for.
    pub(super) is_over: bool,
}

/// Writes the frames of a test while it goes on; they get their names with the results.
struct Filming<'a, K> {
    mesh: &'a meso_core::mesh::Mesh,
    folder: &'a Path,
    unit: RefCell<Unit<K>>,
    still: RefCell<Still>,
    frames: RefCell<Vec<Moment>>,
    failed: RefCell<Option<AskError>>,
    shooting: Shooting,
}

impl<K: Keeper> Observer for Filming<'_, K> {
    fn wants(&self, row: &Row) -> bool {
        self.shooting.wants(row)
    }

    fn moment(&self, frame: &Frame) {
        self.shooting.take(frame);
    }

    fn frame(&self, frame: &Frame) {
        let shot = Snapshot::of(frame);
        let path = self.folder.join(shot.moment.file());
        match fill(&mut self.unit.borrow_mut(), &path, |out| shot.write(self.mesh, &mut self.still.borrow_mut(), out)) {
            Ok(()) => self.frames.borrow_mut().push(shot.moment),
            Err(fault) => drop(self.failed.borrow_mut().get_or_insert(fault)),
        }
    }
}

/// Effective properties with their files.
pub(super) struct EffectiveStep {
    pub(super) ask: EffectiveAsk,
    values: PhaseTables,
    giver: Giver<'static>,
}

impl EffectiveStep {
    pub(super) fn of(section: Section<'_>, giver: Giver<'static>, read: &Reader<'_>) -> Result<Self, AskError> {
        let keys = keys::<EffectiveAsk>();
        let mut ask: EffectiveAsk = section.all(&keys.iter().map(String::as_str).collect::<Vec<_>>(), "phases")?;
        ask.name_phases();
        let values = ask.values(Input::Model, giver, read)?;
        Ok(Self { ask, values, giver })
    }

    pub(super) fn accept(&self, spec: &Spec, machine: &Machine<'_>) -> Result<(), AskError> {
        let settled = self.ask.settle(Facts::Packing(spec), self.values.clone());
        let tasks = settled.map_err(|error| EffectiveAsk::fault(&error, self.giver))?;
        tasks.iter().try_for_each(|task| task.accept(machine, self.giver))
    }

    /// Solves, and writes the results; the figures.
    pub(super) fn run<K: Keeper + Copy>(
        &self,
        model: &Model,
        folder: &Path,
        doing: &Doing<'_, K>,
    ) -> Result<Value, AskError> {
        let (subject, values) = (Subject::Packing(model), self.values.clone());
        let found = doing.on_machine(|machine| self.ask.answer(subject, values, self.giver, machine))?;
        let mut unit = Unit::unforced(doing.keeper);
        found.write(|name, write| fill(&mut unit, &folder.join(name), write))?;
        commit(unit)?;
        let found = found.found;
        found.iter().flat_map(|(of, _)| of.warnings()).for_each(|warning| doing.warn(warning));
        let found: Vec<Value> = found.iter().map(|(of, _)| tree(of)).collect::<Result<_, _>>()?;
        Ok(of_effective(&found.into()))
    }
}

fn tree(figures: &impl serde::Serialize) -> Result<Value, AskError> {
    serde_json::to_value(figures).map_err(|error| AskError::Run(error.to_string()))
}

/// Fills a file that waits for its name.
pub(crate) fn fill<K: Keeper>(
    unit: &mut Unit<K>,
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), AskError> {
    unit.fill(path, true, |out| write(out)).map_err(|error| file_error(path, &error))
}

/// Gives the files of a step their names.
pub(crate) fn commit<K: Keeper>(unit: Unit<K>) -> Result<(), AskError> {
    unit.commit().map_err(|(path, error)| file_error(&path, &error))
}

/// A file that could not be read or written.
pub(crate) fn file_error(path: &Path, error: &io::Error) -> AskError {
    AskError::files(format!("{}: {}", path.display(), meso_files::reason(error)), error)
}
