//! The spec that the flags of `mesocrete pack` ask for.

use super::flags::Args;
use crate::failure::Failure;
use crate::progress::Watch;
use crate::{inputs, stderr};
use meso_ask::DeckAsk;
use meso_core::{Spec, SpecError};

impl Args {
    /// Refuses flags that are wrong with any file.
    pub(crate) fn validate(&self) -> Result<(), Failure> {
        let (contents, ask) = (self.contents()?, self.meshing.unread());
        match self.spec {
            Some(_) => ask.accept()?,
            None => {
                let spec = self.spec(&ask, &Watch::of_files(true, &[]))?;
                ask.accept_for(&spec, contents.iter().any(|content| content.is_deck()))?;
            }
        }
        Ok(())
    }

    /// The spec's file, with the changes of the flags.
    pub(super) fn spec(&self, ask: &DeckAsk, watch: &Watch) -> Result<Spec, Failure> {
        let read = |path| inputs::spec(path, watch, self.over.options.time_limit_s);
        let mut spec = self.spec.as_deref().map_or_else(|| Ok(Spec::default()), read)?;
        self.over.options.lay(&mut spec);
        spec.validate().map_err(|error| self.name_flag(&error))?;
        if let Some(said) = ask.mesh.leave_room(ask.purpose(), &mut spec, watch)?.filter(|_| !self.writing.quiet) {
            watch.aside(|| stderr::line(said));
        }
        spec.validate().map_err(|error| self.name_flag(&error))?;
        Ok(spec)
    }

    /// A wrong value from a flag is called by the flag's name.
    pub(super) fn name_flag(&self, error: &SpecError) -> Failure {
        Failure::Usage(self.over.spec_error(error))
    }
}
