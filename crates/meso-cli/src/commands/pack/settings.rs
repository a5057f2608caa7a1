//! The spec that the flags of `mesocrete pack` ask for.

use super::flags::Args;
use crate::failure::Failure;
use crate::progress::Watch;
use crate::{inputs, stderr};
use meso_core::packing::Placement;
use meso_core::{Spec, SpecError};

impl Args {
    /// Refuses flags that are wrong with any file.
    pub(crate) fn validate(&self) -> Result<(), Failure> {
        let contents = self.contents()?;
        match self.spec {
            Some(_) => self.meshing.validate(),
            None => self.meshing.validate_for(
                &self.spec(&Watch::of_files(true, &[]))?,
                contents.iter().any(|content| content.is_deck()),
            ),
        }
    }

    /// The spec's file, with the changes of the flags.
    pub(super) fn spec(&self, watch: &Watch) -> Result<Spec, Failure> {
        let read = |path| inputs::spec(path, watch, self.time_limit);
        let mut spec = self.spec.as_deref().map_or_else(|| Ok(Spec::default()), read)?;
        spec.seed = self.seed.unwrap_or(spec.seed);
        spec.fraction = self.fraction.unwrap_or(spec.fraction);
        spec.placement.strategy = self.strategy.unwrap_or(spec.placement.strategy);
        spec.placement.attempts = self.attempts.or(spec.placement.attempts);
        let Placement { min_gap_mm, wall_gap_mm, .. } = &mut spec.placement;
        *min_gap_mm = self.min_gap_mm.unwrap_or(*min_gap_mm);
        *wall_gap_mm = self.wall_gap_mm.unwrap_or(*wall_gap_mm);
        spec.placement.time_limit_s = self.time_limit.or(spec.placement.time_limit_s);
        spec.validate().map_err(|error| self.name_flag(error))?;
        if let Some(said) = self.meshing.leave_room(&mut spec, watch)?.filter(|_| !self.writing.quiet) {
            watch.aside(|| stderr::line(said));
        }
        spec.validate().map_err(|error| self.name_flag(error))?;
        Ok(spec)
    }

    /// A wrong value from a flag is called by the flag's name.
    pub(super) fn name_flag(&self, error: SpecError) -> Failure {
        let flag = match error.key.as_str() {
            "fraction" if self.fraction.is_some() => "--fraction",
            "placement.attempts" if self.attempts.is_some() => "--attempts",
            "placement.min_gap_mm" if self.min_gap_mm.is_some() => "--min-gap-mm",
            "placement.wall_gap_mm" if self.wall_gap_mm.is_some() => "--wall-gap-mm",
            "placement.time_limit_s" if self.time_limit.is_some() => "--time-limit",
            _ => return Failure::Usage(error.to_string()),
        };
        Failure::Usage(format!("{flag} {}", error.message))
    }
}
