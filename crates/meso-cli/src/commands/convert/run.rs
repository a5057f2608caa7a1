//! The work of `mesocrete convert`: a saved model in another format.

use super::flags::Args;
use crate::failure::Failure;
use crate::formats::Named;
use crate::inputs;
use crate::outputs::{self, Target, Unit};
use crate::progress::Watch;
use meso_ask::Giver;
use meso_concrete::OutOfRange;
use meso_core::formats::{Format, SurfaceOptions};
use meso_core::watch::Stage;
use std::path::Path;

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    args.threads.run(|| on_these_threads(args))?
}

fn on_these_threads(args: &Args) -> Result<u8, Failure> {
    let plan = args.output.iter().map(|output| Ok((Target::new(&output.path, args.writing.force)?, args.of(output))));
    let plan = plan.collect::<Result<Vec<_>, Failure>>()?;
    outputs::distinct(&plan.iter().map(|(target, _)| target).collect::<Vec<_>>(), &[&args.model])?;
    args.settle()?;
    let mut watch = Watch::of_files(args.writing.quiet, &[(Stage::Read, 1.0)]);
    let model = inputs::model(&args.model, &watch)?;
    watch.finish();
    let surfaces = args.surfaces();
    surfaces.suits(&model.spec.specimen).map_err(|error| Failure::Usage(Giver::Flags.refusal(&error)))?;
    let mut unit = Unit::default();
    for (target, format) in &plan {
        unit.fill(target, args.writing.force, |out| format.write(&model, surfaces, out))?;
    }
    unit.commit()?;
    if !args.writing.quiet {
        outputs::wrote(plan.iter().map(|(target, _)| target));
    }
    Ok(0)
}

impl Args {
    /// Refuses flags that are wrong with any file.
    pub(crate) fn settle(&self) -> Result<(), Failure> {
        let formats: Vec<Format> = self.output.iter().map(|output| self.of(output)).collect();
        let refused = |error: &OutOfRange| Failure::Usage(Giver::Flags.refusal(error));
        self.surfaces().accept(&formats, &[]).map_err(|error| refused(&error))?;
        match self.format.filter(|_| !self.output.iter().any(is_stdout)) {
            Some(format) => {
                let (option, name) = (Giver::Flags.option("format"), format.extension());
                let why = "only standard output takes it; the format of a file follows its extension";
                Err(Failure::Usage(format!("{option} is {name}; {why}")))
            }
            None => Ok(()),
        }
    }

    fn surfaces(&self) -> SurfaceOptions {
        let &Self { compress, images, mortar, named_solids, .. } = self;
        SurfaceOptions { compress, images, mortar, named_solids }
    }

    fn of(&self, output: &Named<Format>) -> Format {
        if is_stdout(output) { self.format.unwrap_or(Format::Json) } else { output.format }
    }
}

fn is_stdout(output: &Named<Format>) -> bool {
    output.path == Path::new("-")
}
