//! `mesocrete recipes`: the specimens that `init` knows.

use crate::failure::Failure;
use crate::outputs::{Target, Unit};
use meso_core::recipes::Recipe;

pub(crate) fn run() -> Result<u8, Failure> {
    let width = Recipe::ALL.iter().map(|recipe| recipe.name.len()).max().unwrap_or(0);
    Unit::default().fill(&Target::Stdout, false, |out| {
        Recipe::ALL.iter().try_for_each(|recipe| writeln!(out, "{:width$}  {}", recipe.name, recipe.title()))
    })?;
    Ok(0)
}
