//! The work of `mesocrete effective`: tensors, page and fields of a saved model or a label volume.

use super::flags::Args;
use crate::failure::Failure;
use crate::outputs::{Target, Unit};
use crate::own_folder::OwnFolder;
use crate::progress::{Watch, of_model};
use crate::{inputs, room, stderr};
use meso_ask::{Giver, Input, Subject};
use meso_core::Model;
use meso_core::mesh::Tools;
use meso_core::watch::Stage;
use meso_effective::results::{Found, figure};
use meso_effective::{Effective, LabelSpecimen, Stiffness};

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    args.threads.run(|| on_these_threads(args))?
}

fn on_these_threads(args: &Args) -> Result<u8, Failure> {
    let giver = Giver::Flags;
    if let (Some(array), Input::Model) = (&args.array, args.input()) {
        return Err(Failure::Usage(format!("--array is {array}; a model has no arrays: leave it out, or take a .vti")));
    }
    let values = args.ask.values(args.input(), giver, &inputs::text)?;
    let force = args.writing.force;
    let names = args.ask.files();
    let _own = OwnFolder::open(&args.output)?;
    let target = |name: &str| Target::new(&args.output.join(name), force);
    names.iter().try_for_each(|name| target(name).map(drop))?;
    let mut watch = Watch::of_files(args.writing.quiet, &of_model(Stage::Solve, 20.0));
    let specimen = Specimen::read(args, &watch)?;
    let machine = room::machine(Tools { watch: &watch, ..Tools::default() });
    let properties = args.ask.answer(specimen.subject(), values, giver, &machine);
    watch.finish();
    let properties = properties?;
    let mut unit = Unit::default();
    properties.write(|name, write| unit.fill(&target(name)?, force, write))?;
    unit.commit()?;
    properties.found.iter().for_each(|(of, _)| tell(of, args.writing.quiet));
    if !args.writing.quiet {
        names.iter().for_each(|name| stderr::line(format!("wrote {}", args.output.join(name).display())));
    }
    Ok(0)
}

impl Args {
    fn input(&self) -> Input {
        Input::of_file(&self.model.to_string_lossy())
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
    let name = found.what.name();
    format!("{name}: {}; Hashin-Shtrikman {} to {}", entries.join(", "), figure(low), figure(high))
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
