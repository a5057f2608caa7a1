//! The test, the mesh and the spec that the flags of `mesocrete solve` ask for.

use super::flags::{Args, TestText};
use super::folder::CHECKPOINT;
use crate::commands::meshing::MeshSettings;
use crate::commands::{names, test_file};
use crate::failure::Failure;
use crate::gpu::{self, Choice, Device};
use crate::progress::Watch;
use crate::{inputs, room};
use meso_ask::{FRAMES, Given, Giver};
use meso_core::aggregate::Itz as Shells;
use meso_core::mesh::{CellKind, ItzForm, MethodName, Order, Purpose};
use meso_core::spec::options_from_value;
use meso_core::{Spec, SpecError};
use meso_solve::results::{Moment, ResultFile};
use meso_solve::{Geometry, Smoothing, SolveError, Test, TestKind};
use meso_study::{NameError, Names};
use serde_json::Value;
use std::path::Path;

/// Friction of brushes and teflon (van Mier et al. 1997).
const BRUSH: f64 = 0.005;

impl Args {
    /// The named test or the one of the file, with the changes of the flags.
    pub(super) fn test(&self) -> Result<Test, Failure> {
        let test = match &self.test {
            TestText::Named(kind) => Test { kind: *kind, ..Test::default() },
            TestText::File(path) => test_file::read(path)?,
            TestText::Tree(test) => (**test).clone(),
        };
        if self.brush && matches!(test.kind, TestKind::Tension | TestKind::Shear | TestKind::Expansion) {
            let why = "has no effect here, where no plate rubs; leave it out";
            return Err(Failure::Usage(format!("--brush {why} (--test {})", names::of(&test.kind))));
        }
        let frames = if test.frames == 0 { FRAMES } else { test.frames };
        let friction = if self.brush { Some(BRUSH) } else { test.friction };
        Ok(self.given.over(&Test { friction, frames, ..test }))
    }

    /// Sets who gave the options.
    pub(crate) fn given_by(&mut self, giver: Giver<'static>) {
        self.mesh.given_by(giver);
        self.given.given_by(giver);
        self.over.given_by(giver);
    }

    /// Sets the test of a study, by the keys of a TEST.toml.
    pub(crate) fn set_test(&mut self, tree: &Value) -> Result<(), Failure> {
        let test = options_from_value(tree).map_err(|error| Failure::Usage(format!("[test] {error}")))?;
        self.test = TestText::Tree(Box::new(test));
        Ok(())
    }

    /// Refuses flags that do not suit packings of `spec`, before one is packed.
    pub(crate) fn check(&self, spec: &Spec) -> Result<(), Failure> {
        meso_solve::validate(&self.mesh.materials()?, &self.test()?).map_err(|error| self.wrong(&error))?;
        self.validate()?;
        self.device()?;
        self.settings(spec).map(drop)
    }

    /// Claims the name of every file of the results.
    pub(crate) fn claim(owner: &str, names: &mut Names) -> Result<(), NameError> {
        let [prefix, suffix] = Moment::FILES;
        names.claim_series(owner, prefix, suffix)?;
        ResultFile::ALL
            .map(ResultFile::name)
            .into_iter()
            .chain([CHECKPOINT])
            .try_for_each(|name| names.claim(owner, name))
    }

    /// Refuses flags that are wrong with any file.
    pub(crate) fn validate_alone(&self) -> Result<(), Failure> {
        self.validate()?;
        if self.mesh.has_materials() {
            return Ok(());
        }
        meso_solve::validate(&self.mesh.materials()?, &self.test()?).map_err(|error| self.wrong(&error))?;
        self.mesh.options(self.purpose(), &Shells::default()).map(drop)
    }

    /// Refuses flags that cannot be meant, before any work.
    pub(super) fn validate(&self) -> Result<(), Failure> {
        if self.output == Path::new("-") {
            let message = "--output - is standard output, but a test writes several files; name a folder";
            return Err(Failure::Usage(message.to_owned()));
        }
        if self.checkpoint.is_some_and(|every| !(0.0..=1e9).contains(&every)) {
            return Err(Failure::Usage("--checkpoint must be a number of seconds from 0 to 1e9".to_owned()));
        }
        let options = self.mesh.options(self.purpose(), &Shells::default())?;
        if self.given.options.smoothing == Some(Smoothing::Edges) && options.method.name() == MethodName::Voxel {
            let message = "--smoothing edges needs tetrahedra; take --method lattice or conforming, or leave it out";
            return Err(Failure::Usage(message.to_owned()));
        }
        if options.method.order() == Order::Quadratic {
            return Err(Failure::Usage("--order is 2; a test takes 1".to_owned()));
        }
        if self.device != Choice::Cpu {
            let is_voxel = options.method.name() == MethodName::Voxel;
            let kind = if is_voxel { CellKind::Hexahedron } else { CellKind::Tetrahedron };
            meso_solve::device::accept(kind).map_err(|error| self.wrong(&error))?;
        }
        if self.packs() {
            return Ok(());
        }
        match self.over.asked().next() {
            Some(key) => Err(Failure::Usage(format!(
                "{} has no effect on a saved model; leave it out, or give a SPEC.toml",
                self.over.giver().option(key)
            ))),
            None => Ok(()),
        }
    }

    /// Turns an error of the engine into wrong usage: a value of a file has its name, unless a flag changed it.
    pub(super) fn wrong(&self, error: &SolveError) -> Failure {
        let SolveError::Value(value) = error else { return Failure::Usage(error.to_string()) };
        let (is_test, key) = (value.table == "test", value.key.as_str());
        let is_given = self.given.has(key) || key == "friction" && self.brush;
        Failure::Usage(match &self.test {
            TestText::File(path) if !is_test || !is_given => format!("{}: {error}", path.display()),
            TestText::Tree(_) if is_test && !is_given => Giver::Table("test").refusal(value),
            _ if is_test && key == "kind" => format!("{} {}", self.given.giver().option("test"), value.fault()),
            _ if is_test && Given::<Test>::has_flag(key) => self.given.refusal(value),
            _ => error.to_string(),
        })
    }

    /// The device that takes the steps; none where this processor does.
    pub(super) fn device(&self) -> Result<Option<Device>, Failure> {
        gpu::find(&self.device)
    }

    /// Whether there is no saved model yet.
    pub(super) fn packs(&self) -> bool {
        self.model.as_deref().is_none_or(test_file::is_toml)
    }

    /// Use of the mesh: a user who names no specimen makes a first test.
    pub(super) fn purpose(&self) -> Purpose {
        if self.model.is_none() { Purpose::FirstTest } else { Purpose::Test }
    }

    /// The mesh of a specimen, if its test would have a number of steps that can be taken.
    pub(super) fn settings(&self, spec: &Spec) -> Result<MeshSettings, Failure> {
        let settings = self.mesh.settings(self.purpose(), spec)?;
        let (test, options) = (self.test()?, &settings.footing.options);
        test.suits(&spec.specimen).map_err(|error| self.wrong(&error.into()))?;
        room::accept_in_memory(
            "the test",
            options.bytes_of_test(&spec.specimen),
            ("--element-size-mm", options.element_size_mm),
        )?;
        let (measures, is_cohesive) = (Geometry::of(&spec.specimen), options.itz == ItzForm::Cohesive);
        let steps = test.steps(&measures, options.element_size_mm, is_cohesive);
        steps.map(|_| settings).map_err(|error| self.wrong(&error.into()))
    }

    /// The spec to pack: a SPEC.toml or the paper's specimen, with the changes of the flags.
    pub(super) fn spec(&self, watch: &Watch) -> Result<Spec, Failure> {
        let read = |path| inputs::spec(path, watch, self.over.options.time_limit_s);
        let mut spec = self.model.as_deref().map_or_else(|| Ok(Spec::of_first_test()), read)?;
        self.over.options.lay(&mut spec);
        spec.validate().map_err(|error| self.name_flag(&error))?;
        self.leave_room(&mut spec, watch)?;
        spec.validate().map_err(|error| self.name_flag(&error))?;
        Ok(spec)
    }

    /// Finds the size that `auto` means, and sets the gaps that the mesh needs and `spec` leaves open.
    pub(crate) fn leave_room(&self, spec: &mut Spec, watch: &dyn meso_core::Watch) -> Result<(), Failure> {
        self.mesh.leave_room(self.purpose(), spec, watch).map(drop)
    }

    fn name_flag(&self, error: &SpecError) -> Failure {
        Failure::Usage(self.over.spec_error(error))
    }
}
