//! The work of `mesocrete effective`: tensors, page and fields of a saved model.

use super::flags::Args;
use super::settings::wrong;
use crate::failure::Failure;
use crate::outputs::{Target, Unit};
use crate::progress::{Watch, of_model};
use crate::{inputs, room, stderr};
use meso_core::Model;
use meso_core::watch::Stage;
use meso_effective::results::{FIGURES, PAGE, write_figures, write_page};
use meso_effective::{Effective, FluxField, Phases, Property, effective};
use std::path::Path;
use std::time::Instant;

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    args.threads.run(|| on_these_threads(args))?
}

fn on_these_threads(args: &Args) -> Result<u8, Failure> {
    let phases = args.phases()?;
    let force = args.writing.force;
    make(&args.output)?;
    let target = |name: &str| Target::new(&args.output.join(name), force);
    let (figures, page) = (target(FIGURES)?, target(PAGE)?);
    let mut watch = Watch::of_files(args.writing.quiet, &of_model(Stage::Solve, 20.0));
    let model = inputs::model(&args.model, &watch)?;
    let (mut found, mut fields) = (Vec::new(), Vec::new());
    for property in args.properties() {
        let (result, theirs) = solve(args, property, &model, &phases, &watch)?;
        found.push(result);
        fields.extend(theirs.into_iter().map(|field| (property, field)));
    }
    watch.finish();
    let mut unit = Unit::default();
    let mut written = vec![&figures, &page];
    let vti = fields.iter().map(|(what, field)| target(&field.file(*what))).collect::<Result<Vec<_>, _>>()?;
    written.extend(&vti);
    for ((_, field), target) in fields.iter().zip(&vti) {
        unit.fill(target, force, |out| field.write_vti(out))?;
    }
    unit.fill(&figures, force, |out| write_figures(&found, out))?;
    unit.fill(&page, force, |out| write_page(&found, &fields, out))?;
    unit.commit()?;
    found.iter().for_each(|(of, _)| tell(of, args.writing.quiet));
    if !args.writing.quiet {
        written
            .iter()
            .filter_map(|target| target.file())
            .for_each(|path| stderr::line(format!("wrote {}", path.display())));
    }
    Ok(0)
}

type Found = ((Effective, f64), Vec<FluxField>);

fn solve(args: &Args, what: Property, model: &Model, phases: &Phases, watch: &Watch) -> Result<Found, Failure> {
    let options = args.options(what, &model.spec);
    let work = format!("the {} of voxels of {} mm", what.name(), options.voxel_size_mm);
    let bytes = options.bytes(&model.spec.specimen).map_err(|error| wrong(&error))?;
    room::accept_in_memory(&work, bytes, ("--voxel-size-mm", options.voxel_size_mm))?;
    let begun = Instant::now();
    let (found, fields) = effective(model, phases, &options, watch).map_err(|error| wrong(&error))?;
    Ok(((found, begun.elapsed().as_secs_f64()), fields))
}

/// Makes the folder of the results.
fn make(path: &Path) -> Result<(), Failure> {
    match std::fs::metadata(path) {
        Ok(kind) if kind.is_dir() => Ok(()),
        Ok(_) => Err(Failure::Run(format!("{} is not a folder; name a folder for the results", path.display()))),
        Err(_) => std::fs::create_dir(path).map_err(|error| Failure::file(path, &error)),
    }
}

/// Prints the diagonal with its errors, then warnings.
fn tell(found: &Effective, quiet: bool) {
    if !quiet {
        let entry = |axis: usize| {
            let (value, error) = (found.tensor[axis][axis]?, found.error[axis][axis]?);
            Some(format!("{} {value:.5} +- {error:.5}", ["x", "y", "z"][axis]))
        };
        let entries: Vec<String> = (0..3).filter_map(entry).collect();
        let (low, high) = (found.bounds.hashin_shtrikman_lower, found.bounds.hashin_shtrikman_upper);
        let name = found.what.name();
        stderr::line(format!("{name}: {}; Hashin-Shtrikman {low:.5} to {high:.5}", entries.join(", ")));
    }
    found.warnings.iter().for_each(|warning| stderr::line(format!("warning: {warning}")));
}
