//! `mesocrete init`: a commented SPEC.toml to start from.

use super::shared::Writing;
use crate::failure::Failure;
use crate::outputs::{Target, Unit};
use crate::stderr;
use meso_core::recipes::Recipe;
use std::path::PathBuf;

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// Name of a recipe, see `mesocrete recipes`
    #[arg(default_value = Recipe::DEFAULT)]
    recipe: String,
    /// Where to write it; `-` is standard output
    #[arg(short, long, value_name = "FILE", default_value = "SPEC.toml")]
    output: PathBuf,
    #[command(flatten)]
    writing: Writing,
}

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    let recipe = Recipe::named(&args.recipe).map_err(Failure::Usage)?;
    let target = Target::new(&args.output, args.writing.force)?;
    let mut unit = Unit::default();
    unit.fill(&target, args.writing.force, |out| out.write_all(recipe.text.as_bytes()))?;
    unit.commit()?;
    if let (Some(path), false) = (target.file(), args.writing.quiet) {
        let path = path.display();
        stderr::line(format!("wrote {path}; edit it, then: mesocrete pack {path}"));
    }
    Ok(0)
}
