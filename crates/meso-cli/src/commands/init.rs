//! `mesocrete init`: a commented SPEC.toml or TEST.toml to start from, or the commented material values of a concrete.

use super::shared::Writing;
use super::{names, values};
use crate::failure::Failure;
use crate::outputs::{Target, Unit};
use crate::stderr::{self, flag};
use meso_core::materials::{LawName, Mix, Rock};
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
    /// Where to write it; `-` is standard output [default: SPEC.toml; TEST.toml with --test, MATERIALS.toml
    /// with --materials]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write material values instead, each with its source: of a concrete's class, C30 or C30/37, or of a mortar's mean strength
    /// in MPa, M40
    #[arg(long, value_name = "CLASS", conflicts_with_all = ["recipe", "test"])]
    materials: Option<String>,
    /// Rock of the aggregates
    #[arg(long, value_name = "KIND", value_parser = names::parser::<Rock>(), requires = "materials")]
    #[arg(conflicts_with_all = ["recipe", "test"])]
    rock: Option<Rock>,
    /// Volume of the packing's aggregates over the specimen's, which the mortar's modulus follows from
    #[arg(long, value_name = "F", value_parser = values::number, requires = "materials", allow_negative_numbers = true)]
    #[arg(default_value_t = Mix::USUAL_FRACTION, conflicts_with_all = ["recipe", "test"])]
    fraction: f64,
    /// The law that the values are for; decks take those of cdp
    #[arg(long, value_name = "LAW", value_parser = names::parser::<LawName>(), requires = "materials", default_value = "meso")]
    #[arg(conflicts_with_all = ["recipe", "test"])]
    law: LawName,
    #[command(flatten)]
    writing: Writing,
}

/// A file to start from.
struct Start {
    text: String,
    name: &'static str,
    /// The command that the file is for, before its name.
    then: String,
}

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    let start = args.start()?;
    let path = args.output.as_deref().unwrap_or(Path::new(start.name));
    let target = Target::new(path, args.writing.force)?;
    let mut unit = Unit::default();
    unit.fill(&target, args.writing.force, |out| out.write_all(start.text.as_bytes()))?;
    unit.commit()?;
    if let (Some(path), false) = (target.file(), args.writing.quiet) {
        let (path, then) = (path.display(), start.then);
        stderr::line(format!("wrote {path}; edit it, then: mesocrete {then} {path}"));
    }
    Ok(0)
}

impl Args {
    fn start(&self) -> Result<Start, Failure> {
        if let Some(test) = self.test {
            return Ok(Start { text: test.recipe(), name: "TEST.toml", then: format!("solve {}", flag("test")) });
        }
        let Some(class) = &self.materials else {
            let recipe = Recipe::named(&self.recipe).map_err(Failure::Usage)?;
            return Ok(Start { text: recipe.text.to_owned(), name: "SPEC.toml", then: "pack".to_owned() });
        };
        let option = flag("materials");
        let then = format!("solve {option}");
        let mix = Mix::parse(class, self.rock, self.fraction, self.law)
            .map_err(|error| Failure::Usage(format!("{option} {error}")))?;
        let sourced = mix.materials().map_err(|error| {
            let giver =
                if error.key == "fraction" { flag(&error.key) } else { format!("{option} {class}: {}", error.key) };
            Failure::Usage(format!("{giver} {}", error.fault()))
        })?;
        let rock = self.rock.map(|rock| format!(" with {}", names::of(&rock))).unwrap_or_default();
        let (law, fcm) = (names::of(&self.law), mix.fcm_mpa);
        let title = format!("Materials of {class}{rock} for the law {law}: a concrete of {fcm:.1} MPa in the mean");
        Ok(Start { text: sourced.toml(&title), name: "MATERIALS.toml", then })
    }
}
