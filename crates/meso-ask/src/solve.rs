//! A test of a mesh, before there is one.

use crate::footing::Footing;
use crate::{AskError, FRAMES, Given, Giver, Machine, MeshAsk, flags::names};
use meso_core::aggregate::Itz as Shells;
use meso_core::materials::Materials;
use meso_core::mesh::{CellKind, ItzForm, Mesh, MethodName, Order, Phase, Purpose};
use meso_core::trial::TrialError;
use meso_core::{Model, Spec, Watch};
use meso_solve::results::sample_of;
use meso_solve::{Geometry, LawName, Run, Smoothing, SolveError, Test};

/// Friction of brushes and teflon (van Mier et al. 1997).
const BRUSH: f64 = 0.005;

/// Where the values of a test stand that nobody gave as an option.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum TestGiven {
    /// Nowhere: the test has a name.
    #[default]
    Named,
    /// In the file of this name.
    File(String),
    /// In a table.
    Table,
}

/// A test that is asked for.
#[derive(Clone, Debug, Default)]
pub struct SolveAsk {
    /// The mesh that is tested.
    pub mesh: MeshAsk,
    /// The named test, or that of a file or a table; `None` for a file that was not read.
    pub base: Option<Test>,
    /// Where its values stand.
    pub from: TestGiven,
    /// Options over it.
    pub given: Given<Test>,
    /// Plates of brushes or teflon.
    pub brush: bool,
    /// Whether a device takes the steps.
    pub on_device: bool,
    /// Whether this is the first test of a user who names no specimen.
    pub is_first: bool,
}

/// Refuses strains of phases that no mesh of a specimen has, before it is packed.
pub(crate) fn suits_phases(test: &Test, spec: &Spec, itz: ItzForm) -> Result<(), TrialError> {
    let has = |phase| match phase {
        Phase::Itz => itz == ItzForm::Smeared || itz == ItzForm::Solid && spec.itz.thickness_mm[1] > 0.0,
        Phase::Fibre => spec.fibres.as_ref().is_some_and(|fibres| fibres.fraction > 0.0),
        _ => true,
    };
    let reason = "no mesh of this specimen has that phase";
    Ok(test.expansion().map_or(Ok(()), |expansion| expansion.suits_phases(reason, has))?)
}

impl SolveAsk {
    /// The test with the options over it.
    pub fn test(&self) -> Test {
        let test = self.base.clone().unwrap_or_default();
        let frames = if test.frames == 0 { FRAMES } else { test.frames };
        let friction = if self.brush { Some(BRUSH) } else { test.friction };
        self.given.over(&Test { friction, frames, ..test })
    }

    /// Use of the mesh.
    pub fn purpose(&self) -> Purpose {
        if self.is_first { Purpose::FirstTest } else { Purpose::Test }
    }

    /// Refuses options that no specimen can have, before any work.
    ///
    /// # Errors
    /// The option.
    pub fn accept(&self) -> Result<(), AskError> {
        if let Some(test) = self.base.as_ref().filter(|test| self.brush && !test.rubs()) {
            let (brush, name) = (self.given.giver().option("brush"), self.given.giver().option("test"));
            let kind = names::of(&test.kind);
            let why = "has no effect here, where no plate rubs; leave it out";
            return Err(AskError::Usage(format!("{brush} {why} ({name} {kind})")));
        }
        if let (Some(materials), Some(_)) = (&self.mesh.materials, &self.base) {
            let test = self.test();
            meso_solve::validate(materials, &test).map_err(|error| self.wrong(&error))?;
        }
        let options = self.mesh.options(self.purpose(), &Shells::default())?;
        let is_voxel = options.method.name() == MethodName::Voxel;
        let option = |key: &str| self.given.giver().option(key);
        if self.given.options.smoothing == Some(Smoothing::Edges) && is_voxel {
            let (smoothing, method) = (option("smoothing"), option("method"));
            let why = format!("needs tetrahedra; take {method} lattice or conforming, or leave it out");
            return Err(AskError::Usage(format!("{smoothing} edges {why}")));
        }
        if options.method.order() == Order::Quadratic {
            return Err(AskError::Usage(format!("{} is 2; a test takes 1", option("order"))));
        }
        if self.on_device {
            let kind = if is_voxel { CellKind::Hexahedron } else { CellKind::Tetrahedron };
            meso_solve::device::accept(kind).map_err(|error| self.wrong(&error))?;
        }
        Ok(())
    }

    /// The mesh of a specimen, if its test would have a number of steps that can be taken.
    ///
    /// # Errors
    /// Options that the specimen cannot have.
    pub fn settle(&self, spec: &Spec, machine: &Machine<'_>) -> Result<Footing, AskError> {
        self.mesh.suits_phases(spec)?;
        let footing = self.mesh.settle(self.purpose(), spec, machine)?;
        let (test, options) = (self.test(), &footing.options);
        test.suits(&spec.specimen).map_err(|error| self.wrong(&error.into()))?;
        suits_phases(&test, spec, options.itz).map_err(|error| self.wrong(&error.into()))?;
        let size = self.given.giver().option("element_size_mm");
        machine.accept_in_memory(
            "the test",
            options.bytes_of_test(&spec.specimen),
            (&size, options.element_size_mm),
        )?;
        let (measures, is_cohesive) = (Geometry::of(&spec.specimen), options.itz == ItzForm::Cohesive);
        let scatter =
            self.mesh.materials.as_ref().filter(|_| test.law != LawName::Elastic).and_then(Materials::scattered);
        let scatter = scatter.map_or(Ok(()), |own| own.suits(options.element_size_mm, is_cohesive));
        scatter.map_err(|error| self.wrong(&error.into()))?;
        // In real time the mesh decides the step.
        if test.is_fast() {
            let mortar = self.mesh.materials.clone().unwrap_or_default().mortar;
            let suits = test.suits_waves(options.element_size_mm, &mortar);
            return suits.map(|()| footing).map_err(|error| self.wrong(&error.into()));
        }
        let steps = test.steps(&measures, options.element_size_mm, is_cohesive);
        steps.map(|_| footing).map_err(|error| self.wrong(&error.into()))
    }

    /// The mesh of `model`, which is there; see [`SolveAsk::settle`].
    ///
    /// # Errors
    /// Those of [`SolveAsk::settle`], and a method that cannot mesh its bodies.
    pub fn settle_for(&self, model: &Model, machine: &Machine<'_>) -> Result<Footing, AskError> {
        self.mesh.accept(self.purpose(), model, machine.tools.watch)?;
        self.settle(&model.spec, machine)
    }

    /// The test of `mesh` before its first step; `tell` receives doubts about the mesh.
    ///
    /// # Errors
    /// A mesh that cannot be tested.
    pub fn begin<'m>(
        &self,
        mesh: &'m Mesh,
        model: &Model,
        footing: &Footing,
        tell: impl FnMut(&String),
    ) -> Result<Run<'m>, AskError> {
        let sample = sample_of(mesh, model, &footing.options);
        let materials = self.mesh.materials.clone().unwrap_or_default();
        let run = Run::new(sample, &materials, &self.test()).map_err(|error| self.wrong(&error))?;
        run.doubts().iter().for_each(tell);
        Ok(run)
    }

    /// Finds the size that `auto` means, and sets the gaps that the mesh needs and `spec` leaves open.
    ///
    /// # Errors
    /// Options that do not fit the specimen.
    pub fn leave_room(&self, spec: &mut Spec, watch: &dyn Watch) -> Result<(), AskError> {
        self.mesh.leave_room(self.purpose(), spec, watch).map(drop)
    }

    /// An error of the engine as wrong usage: a value of a file has its name, unless an option changed it.
    fn wrong(&self, error: &SolveError) -> AskError {
        let SolveError::Value(value) = error else { return AskError::Usage(error.to_string()) };
        let (is_test, key) = (value.table == "test", value.key.as_str());
        let is_given = self.given.has(key) || key == "friction" && self.brush;
        AskError::Usage(match &self.from {
            TestGiven::File(name) if !is_test || !is_given => format!("{name}: {error}"),
            TestGiven::Table if is_test && !is_given => Giver::Table("test").refusal(value),
            _ if is_test && key == "kind" => format!("{} {}", self.given.giver().option("test"), value.fault()),
            _ if is_test && (is_given || Given::<Test>::has_flag(key)) => self.given.refusal(value),
            _ => error.to_string(),
        })
    }
}
