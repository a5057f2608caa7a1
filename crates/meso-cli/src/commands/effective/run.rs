//! The work of `mesocrete effective`: tensors, page and fields of a saved model, a label volume or the frames of a test.

use super::flags::Args;
use crate::failure::Failure;
use crate::outputs::{Target, Unit};
use crate::own_folder::OwnFolder;
use crate::progress::{Watch, of_model};
use crate::{inputs, room, stderr};
use meso_ask::{Giver, Input, PhaseTables, Properties, RunRecord, Subject};
use meso_core::Model;
use meso_core::mesh::Tools;
use meso_core::watch::Stage;
use meso_effective::results::{FIGURES, Found, figure, further_files};
use meso_effective::{At, Effective, LabelSpecimen, Stiffness, Unloading};
use meso_files::whole::beginning;
use meso_solve::results::{Moment, ResultFile};

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    args.threads.run(|| on_these_threads(args))?
}

fn on_these_threads(args: &Args) -> Result<u8, Failure> {
    let giver = Giver::Flags;
    if let (Some(array), Input::Model) = (&args.array, args.input()) {
        let option = giver.option("array");
        return Err(Failure::Usage(format!(
            "{option} is {array}; a model has no arrays: leave it out, or take a .vti"
        )));
    }
    let values = args.ask.values(args.input(), giver, &inputs::text)?;
    let force = args.writing.force;
    let names = args.ask.files(args.input());
    let frames = if args.input() == Input::Run { Some(Frames::of(args)?) } else { None };
    let _own = OwnFolder::open(&args.output)?;
    let target = |name: &str| Target::new(&args.output.join(name), force);
    names.iter().try_for_each(|name| target(name).map(drop))?;
    let mut watch = Watch::of_files(args.writing.quiet, &of_model(Stage::Solve, 20.0));
    let properties = match frames {
        Some(frames) => frames.answer(args, &values, &watch),
        None => {
            let specimen = Specimen::read(args, &watch)?;
            let machine = room::machine(Tools { watch: &watch, ..Tools::default() });
            Ok(args.ask.answer(specimen.subject(), values, giver, &machine)?)
        }
    };
    watch.finish();
    let properties = properties?;
    let mut unit = Unit::default();
    properties.write(|name, write| unit.fill(&target(name)?, force, write))?;
    if args.output.join(FIGURES).is_file() {
        // Fields of the result that is replaced.
        let left = further_files().into_iter().filter(|name| !names.contains(name)).map(|name| args.output.join(name));
        left.filter(|path| beginning(path).is_some()).for_each(|path| unit.remove(path));
    }
    unit.commit()?;
    properties.found.iter().for_each(|(of, _)| tell(of, args.writing.quiet));
    if !args.writing.quiet {
        names.iter().for_each(|name| stderr::line(format!("wrote {}", args.output.join(name).display())));
    }
    Ok(0)
}

impl Args {
    fn input(&self) -> Input {
        if self.model.is_dir() { Input::Run } else { Input::of_file(&self.model.to_string_lossy()) }
    }
}

/// The frames that are asked for, before they are read.
struct Frames {
    record: RunRecord,
    chosen: Vec<Moment>,
}

impl Frames {
    /// Of a folder; what it lacks is refused before any work.
    fn of(args: &Args) -> Result<Self, Failure> {
        let path = args.model.join(ResultFile::Figures.name());
        let wrong = |why: String| Failure::Usage(format!("{}: {why}", path.display()));
        if !path.exists() {
            let folder = args.model.display();
            return Err(wrong(format!(
                "there is no such file; name a folder that `mesocrete solve -o {folder}` wrote"
            )));
        }
        let record = RunRecord::read(&inputs::text(&path)?).map_err(wrong)?;
        let pick = args.ask.frame.unwrap_or_default();
        let chosen = record.choose(pick, Giver::Flags)?;
        for frame in &chosen {
            let file = args.model.join(frame.file());
            std::fs::metadata(&file).map_err(|error| Failure::file(&file, &error))?;
            let doubt = record.doubt(pick, frame, Giver::Flags);
            doubt.iter().for_each(|doubt| stderr::line(format!("warning: {doubt}")));
        }
        Ok(Self { record, chosen })
    }

    /// Reads one frame after the other, and solves it.
    fn answer(&self, args: &Args, values: &PhaseTables, watch: &Watch) -> Result<Properties, Failure> {
        let (mut all, values) = (Properties::default(), self.record.values(values.clone()));
        for moment in &self.chosen {
            let file = args.model.join(moment.file());
            let bytes = std::fs::read(&file).map_err(|error| Failure::file(&file, &error))?;
            let read = self.record.frame(*moment, &bytes);
            let (mesh, frame) = read.map_err(|why| Failure::Usage(format!("{}: {why}", file.display())))?;
            drop(bytes);
            let machine = room::machine(Tools { watch, ..Tools::default() });
            let subject = Subject::Frame(self.record.cracked(&mesh, &frame));
            all.extend(args.ask.answer(subject, values.clone(), Giver::Flags, &machine)?);
        }
        Ok(all)
    }
}

/// What was read.
enum Specimen {
    Packing(Box<Model>),
    Labels(LabelSpecimen),
}

impl Specimen {
    fn read(args: &Args, watch: &Watch) -> Result<Self, Failure> {
        if args.input() == Input::Model {
            return Ok(Self::Packing(Box::new(inputs::model(&args.model, watch)?)));
        }
        let volume = inputs::volume(&args.model, args.array.as_deref())?;
        inputs::warn_of_choices(&volume, args.ask.voxel_size_mm.is_some());
        let given = args.ask.voxel_size_mm.map(|h| [h; 3]);
        let spacing_mm = given.or(volume.spacing_mm).unwrap_or([1.0; 3]);
        let periodic = args.ask.periodic.map_or([false; 3], |axes| axes.flags());
        Ok(Self::Labels(LabelSpecimen { volume, spacing_mm, periodic }))
    }

    fn subject(&self) -> Subject<'_> {
        match self {
            Self::Packing(model) => Subject::Packing(model),
            Self::Labels(specimen) => Subject::Labels(specimen),
        }
    }
}

/// Prints the result with its errors, then warnings.
fn tell(found: &Found, quiet: bool) {
    if !quiet {
        stderr::line(match found {
            Found::Flux(found) => flux_line(found),
            Found::Stiffness(found) => stiffness_line(found),
            Found::Unloading(found) => unloading_line(found),
        });
    }
    found.warnings().iter().for_each(|warning| stderr::line(format!("warning: {warning}")));
}

/// The diagonal.
fn flux_line(found: &Effective) -> String {
    let entry = |axis: usize| {
        let (value, error) = (found.tensor[axis][axis]?, found.error[axis][axis]?);
        Some(format!("{} {} +- {}", ["x", "y", "z"][axis], figure(value), figure(error)))
    };
    let entries: Vec<String> = (0..3).filter_map(entry).collect();
    let (low, high) = (found.bounds.hashin_shtrikman_lower, found.bounds.hashin_shtrikman_upper);
    let (name, entries) = (found.what.name(), entries.join(", "));
    match moment(&found.at) {
        Some(moment) => format!("{moment}: {name} {entries}"),
        None => format!("{name}: {entries}; Hashin-Shtrikman {} to {}", figure(low), figure(high)),
    }
}

/// Constants of the nearest isotropic material, and the expansion if there is one.
fn stiffness_line(found: &Stiffness) -> String {
    let (is, error) = (&found.isotropic, &found.isotropic_error);
    let modulus = format!("E {:.0} +- {:.0} MPa", is.youngs_modulus_mpa, error.youngs_modulus_mpa);
    let ratio = format!("nu {:.4} +- {:.4}", is.poisson_ratio, error.poisson_ratio);
    let [x, y, z, ..] = found.expansion;
    let free = found.phases.iter().any(|phase| phase.eigenstrain != 0.0);
    let expansion = if free { format!("; free strain x {x:.3e}, y {y:.3e}, z {z:.3e}") } else { String::new() };
    format!("stiffness: {modulus}, {ratio}{expansion}")
}

/// When a frame was taken, if a result belongs to one.
fn moment(at: &At) -> Option<String> {
    Some(format!("frame {}, strain {:.5}", at.frame?, at.strain?))
}

/// Young's moduli of a frame.
fn unloading_line(found: &Unloading) -> String {
    let entry = |axis: usize| {
        let (value, error) = (found.youngs_modulus_mpa[axis]?, found.error[axis]?);
        Some(format!("{} {value:.0} +- {error:.0} MPa", ["x", "y", "z"][axis]))
    };
    let entries: Vec<String> = (0..3).filter_map(entry).collect();
    format!("{}: modulus {}", moment(&found.at).unwrap_or_default(), entries.join(", "))
}
