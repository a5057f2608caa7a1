//! The work of `mesocrete convert`: a saved model in another format.

use super::flags::Args;
use crate::failure::Failure;
use crate::formats::Named;
use crate::inputs;
use crate::outputs::{self, Target, Unit};
use crate::progress::Watch;
use meso_ask::Giver;
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
    let surfaces = SurfaceOptions {
        compress: args.compress,
        images: args.images,
        mortar: args.mortar,
        named_solids: args.named_solids,
    };
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
        let for_one = [(self.mortar, "mortar", Format::Step), (self.named_solids, "named_solids", Format::Stl)];
        let has = |format| self.output.iter().any(|output| self.of(output) == format);
        match for_one.into_iter().find(|(given, _, format)| *given && !has(*format)) {
            Some((_, key, format)) => {
                let (option, extension) = (Giver::Flags.option(key), format.extension());
                let message = format!("{option} applies to .{extension} files alone; give -o a name that ends so");
                Err(Failure::Usage(message))
            }
            None => Ok(()),
        }
    }

    fn of(&self, output: &Named<Format>) -> Format {
        if output.path == Path::new("-") { self.format } else { output.format }
    }
}
