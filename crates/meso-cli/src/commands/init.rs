//! `mesocrete init`: a commented SPEC.toml or TEST.toml to start from.

use super::names;
use super::shared::Writing;
use crate::failure::Failure;
use crate::outputs::{Target, Unit};
use crate::stderr;
use meso_core::recipes::Recipe;
use meso_solve::TestKind;
use std::path::{Path, PathBuf};

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// Name of a recipe, see `mesocrete recipes`
    #[arg(default_value = Recipe::DEFAULT)]
    recipe: String,
    /// A TEST.toml for `mesocrete solve --test` instead
    #[arg(long, value_name = "NAME", conflicts_with = "recipe", value_parser = names::parser::<TestKind>())]
    test: Option<TestKind>,
    /// Where to write it; `-` is standard output [default: SPEC.toml; TEST.toml with --test]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    writing: Writing,
}

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    let (text, usual, next) = match args.test {
        Some(test) => (test.recipe(), "TEST.toml", "solve --test"),
        None => (Recipe::named(&args.recipe).map_err(Failure::Usage)?.text.to_owned(), "SPEC.toml", "pack"),
    };
    let target = Target::new(args.output.as_deref().unwrap_or(Path::new(usual)), args.writing.force)?;
    let mut unit = Unit::default();
    unit.fill(&target, args.writing.force, |out| out.write_all(text.as_bytes()))?;
    unit.commit()?;
    if let (Some(path), false) = (target.file(), args.writing.quiet) {
        let path = path.display();
        stderr::line(format!("wrote {path}; edit it, then: mesocrete {next} {path}"));
    }
    Ok(0)
}
