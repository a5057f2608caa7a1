//! The work of `mesocrete convert`: a saved model in another format.

use super::flags::Args;
use super::settings::plan;
use crate::failure::Failure;
use crate::inputs;
use crate::outputs::{self, Unit};
use crate::progress::Watch;
use meso_core::formats::SurfaceOptions;
use meso_core::watch::Stage;

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    args.threads.run(|| on_these_threads(args))?
}

fn on_these_threads(args: &Args) -> Result<u8, Failure> {
    let plan = args.output.iter().map(|path| plan(path, args)).collect::<Result<Vec<_>, _>>()?;
    outputs::distinct(&plan.iter().map(|(target, _)| target).collect::<Vec<_>>(), &[&args.model])?;
    args.validate()?;
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
