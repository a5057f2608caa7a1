//! The test, the mesh and the spec that the flags of `mesocrete solve` ask for.

use super::flags::{Args, TestText};
use crate::failure::Failure;
use crate::gpu::{self, Choice, Device};
use crate::inputs;
use crate::progress::Watch;
use meso_ask::files::{self, is_toml};
use meso_ask::{SolveAsk, TestGiven};
use meso_core::{Spec, SpecError};
use meso_solve::Test;
use std::path::Path;

impl Args {
    /// The test that is asked for, with the content of the files.
    pub(super) fn ask(&self) -> Result<SolveAsk, Failure> {
        let (base, from) = match &self.test {
            TestText::Named(kind) => (Test { kind: *kind, ..Test::default() }, TestGiven::Named),
            TestText::File(path) => (files::test(path, &inputs::text)?, TestGiven::File(path.display().to_string())),
        };
        Ok(SolveAsk { mesh: self.mesh.ask()?, base: Some(base), from, ..self.unread() })
    }

    /// The test that is asked for, as far as no file is read.
    fn unread(&self) -> SolveAsk {
        let base = match self.test {
            TestText::Named(kind) => Some(Test { kind, ..Test::default() }),
            TestText::File(_) => None,
        };
        SolveAsk {
            mesh: self.mesh.unread(),
            base,
            from: TestGiven::default(),
            given: self.given.clone(),
            brush: self.brush,
            on_device: self.device != Choice::Cpu,
            is_first: self.model.is_none(),
        }
    }

    /// Refuses flags that are wrong with any file.
    pub(crate) fn validate(&self) -> Result<(), Failure> {
        self.accept(&self.unread())
    }

    /// Refuses flags that cannot be meant, before any work.
    pub(super) fn accept(&self, ask: &SolveAsk) -> Result<(), Failure> {
        ask.accept()?;
        if self.output == Path::new("-") {
            let message = "--output - is standard output, but a test writes several files; name a folder";
            return Err(Failure::Usage(message.to_owned()));
        }
        if self.checkpoint.is_some_and(|every| !(0.0..=1e9).contains(&every)) {
            return Err(Failure::Usage("--checkpoint must be a number of seconds from 0 to 1e9".to_owned()));
        }
        match self.over.asked().next().filter(|_| !self.packs()) {
            Some(key) => Err(Failure::Usage(format!(
                "{} has no effect on a saved model; leave it out, or give a SPEC.toml",
                self.over.giver().option(key)
            ))),
            None => Ok(()),
        }
    }

    /// The device that takes the steps; none where this processor does.
    pub(super) fn device(&self) -> Result<Option<Device>, Failure> {
        gpu::find(&self.device)
    }

    /// Whether there is no saved model yet.
    pub(super) fn packs(&self) -> bool {
        self.model.as_deref().is_none_or(is_toml)
    }

    /// The spec to pack: a SPEC.toml or the paper's specimen, with the changes of the flags.
    pub(super) fn spec(&self, ask: &SolveAsk, watch: &Watch) -> Result<Spec, Failure> {
        let read = |path| inputs::spec(path, watch, self.over.options.time_limit_s);
        let mut spec = self.model.as_deref().map_or_else(|| Ok(Spec::of_first_test()), read)?;
        self.over.options.lay(&mut spec);
        spec.validate().map_err(|error| self.name_flag(&error))?;
        ask.leave_room(&mut spec, watch)?;
        spec.validate().map_err(|error| self.name_flag(&error))?;
        Ok(spec)
    }

    fn name_flag(&self, error: &SpecError) -> Failure {
        Failure::Usage(self.over.spec_error(error))
    }
}
