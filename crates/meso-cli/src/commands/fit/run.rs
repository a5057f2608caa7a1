//! The work of `mesocrete fit`: the cases of each plan, and the results.

use super::flags::Args;
use crate::commands::study::{self, Working};
use crate::failure::{Failure, INTERRUPTED};
use crate::outputs::{Signals, Target};
use crate::own_folder::make;
use crate::{inputs, interrupt, outputs, stderr};
use meso_ask::files;
use meso_concrete::printable;
use meso_core::materials::Materials;
use meso_core::spec::options_from_toml;
use meso_files::Beside;
use meso_study::Again;
use meso_study::fit::{FitRun, RESULTS, curve};
use std::path::{Path, PathBuf};

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    let mut beside = Beside(args.spec.parent().unwrap_or(Path::new("")));
    let mut fit = args.fit(&mut beside)?;
    let how = Working::new(args.jobs, args.threads, Path::new("gmsh"), Again::None);
    let machine = how.machine();
    for case in fit.first(&mut beside)?.cases {
        study::settle(&case, &fit.steps(&case, &inputs::text)?, &machine)?;
    }
    let _made = make(&args.output)?;
    let _held = fit.begin().map_err(study::failure)?;
    let [materials, report] = RESULTS.map(|name| Target::new(&args.output.join(name), args.writing.force));
    let (materials, report) = (materials?, report?);
    let read = [Some(&args.curve), Some(&args.spec), args.materials.as_ref()];
    let read: Vec<&Path> = read.into_iter().flatten().map(PathBuf::as_path).collect();
    outputs::distinct(&[&materials, &report], &read)?;
    while let Some(plan) = fit.plan(Signals, &mut beside)? {
        let steps = |case: &_| fit.steps(case, &inputs::text);
        let done = study::cases(plan, &fit.cases(), &steps, &how, args.writing.quiet)?;
        if interrupt::asked() {
            stderr::line("stopped; the same command goes on with the next test");
            return Ok(INTERRUPTED);
        }
        let records = done.records();
        drop(done);
        let line = fit.learn(&records)?;
        if !args.writing.quiet {
            stderr::line(line);
        }
    }
    let title = format!("mesocrete fit {} {}", args.curve.display(), args.spec.display());
    fit.save(&printable(&title), args.writing.force, Signals)?;
    interrupt::end_if_told();
    if !args.writing.quiet {
        fit.lines().into_iter().for_each(stderr::line);
        outputs::wrote([&materials, &report]);
    }
    Ok(0)
}

impl Args {
    /// The fit, with the content of the files.
    fn fit(&self, beside: &mut Beside<'_>) -> Result<FitRun, Failure> {
        outputs::refuse_stdout(&self.output, "a fit writes several files; name a folder")?;
        let spec = inputs::toml(&self.spec, options_from_toml)?;
        let (name, bytes) = (self.curve.display().to_string(), inputs::table(&self.curve)?);
        let measured = |height_mm: f64| curve(&bytes, height_mm);
        let read = |path: &Path| files::materials(path, &inputs::text);
        let base = self.materials.as_deref().map_or_else(|| Ok(Materials::default()), read)?;
        Ok(FitRun::new(self.ask.clone(), spec, beside, (&name, &measured), base, &self.output)?)
    }
}
