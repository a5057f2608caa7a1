//! A mesh with its deck: the analysis, and what a deck cannot have.

use crate::footing::Footing;
use crate::solve::suits_phases;
use crate::{AskError, Given, Machine, MeshAsk, deck_refusal};
use meso_concrete::OutOfRange;
use meso_core::aggregate::Itz;
use meso_core::export::abaqus::{Analysis, DeckOptions};
use meso_core::formats::MeshFormat;
use meso_core::mesh::{ItzForm, Joined, Mesh, MeshError, MeshOptions, MethodName, PhaseOff, Purpose, Tools};
use meso_core::trial::{Sample, TrialError};
use meso_core::{Model, Spec};

/// A mesh and its deck that are asked for.
#[derive(Clone, Debug, Default)]
pub struct DeckAsk {
    /// The mesh.
    pub mesh: MeshAsk,
    /// The options of the deck.
    pub given: Given<DeckOptions>,
    /// The analysis of the deck; `None` for the test of a file that was not read.
    pub analysis: Option<Analysis>,
}

/// A mesh and its deck, settled for one spec.
#[derive(Clone, Debug)]
pub struct DeckSettled {
    /// The mesh.
    pub footing: Footing,
    /// The content of the deck, without the loads on the mesh.
    pub deck: DeckOptions,
    /// How to get the ITZ, if the mesh has none by default.
    pub hint: Option<String>,
    /// Whether a deck is written.
    is_written: bool,
}

fn has_deck(formats: &[MeshFormat]) -> bool {
    formats.iter().any(|format| format.is_deck())
}

impl DeckAsk {
    /// Use of the mesh: whether the deck computes something, by its own step or by one that is added to it.
    pub fn purpose(&self) -> Purpose {
        let options = &self.given.options;
        let analyses = self.analysis != Some(Analysis::None) || options.with_damage;
        if analyses && !options.geometry_only { Purpose::Test } else { Purpose::Mesh }
    }

    /// Contents of the deck as far as it was asked for.
    fn options(&self) -> DeckOptions {
        DeckOptions { analysis: self.analysis.clone().unwrap_or_default(), ..self.given.options.clone() }
    }

    /// Whether a deck of this format has a script beside it, which writes its curve.
    pub fn has_script(&self, format: MeshFormat) -> bool {
        format.has_script(&self.options())
    }

    /// Refuses options that no packing can have in these formats, before any work. A file is read first.
    ///
    /// # Errors
    /// The option.
    pub fn accept(&self, formats: &[MeshFormat]) -> Result<(), AskError> {
        self.mesh.options(self.purpose(), &Itz::default())?;
        if self.analysis.is_none() {
            return Ok(());
        }
        let deck = self.options();
        self.accept_formats(&deck, formats)?;
        deck.follows().map_err(|error| self.wrong_test(&error))
    }

    /// Refuses options that suit no packing of `spec`, and looks for no gmsh. A default size is no option.
    ///
    /// # Errors
    /// The option.
    pub fn accept_for(&self, spec: &Spec, formats: &[MeshFormat]) -> Result<(), AskError> {
        let options = self.mesh.options(self.purpose(), &spec.itz)?;
        self.suits_phases(spec, formats)?;
        if self.mesh.materials.is_some() {
            self.accept_deck(&self.deck(spec, &options)?, &options, formats)?;
        }
        match options.validate(&spec.specimen) {
            Err(MeshError::Option(wrong))
                if wrong.key == "element_size_mm" && !self.mesh.given.has("element_size_mm") =>
            {
                Ok(())
            }
            suits => suits.map_err(|error| self.mesh.wrong(&error)),
        }
    }

    /// Everything for packings of `spec` in these formats; options of decks are refused where no deck is written.
    ///
    /// # Errors
    /// Options that do not fit, a mesh beyond the memory, and a missing gmsh.
    pub fn settle(&self, spec: &Spec, formats: &[MeshFormat], machine: &Machine<'_>) -> Result<DeckSettled, AskError> {
        let footing = self.mesh.settle(self.purpose(), spec, machine)?;
        let options = &footing.options;
        let size = self.mesh.given.giver().option("element_size_mm");
        machine.accept_in_memory("the mesh", options.bytes(&spec.specimen), (&size, options.element_size_mm))?;
        self.suits_phases(spec, formats)?;
        let deck = self.deck(spec, options)?;
        self.accept_deck(&deck, options, formats)?;
        self.accept_formats(&deck, formats)?;
        deck.suits(&spec.specimen).map_err(|error| self.wrong_test(&error))?;
        if let Some(test) = deck.test() {
            suits_phases(&test, spec, options.itz).map_err(|error| self.wrong_test(&error))?;
        }
        let is_written = has_deck(formats);
        Ok(DeckSettled { hint: self.hint(spec, options.itz), footing, deck, is_written })
    }

    /// Everything for `model`, which is there.
    ///
    /// # Errors
    /// Those of [`DeckAsk::settle`], and a method that cannot mesh its bodies.
    pub fn settle_for(
        &self,
        model: &Model,
        formats: &[MeshFormat],
        machine: &Machine<'_>,
    ) -> Result<DeckSettled, AskError> {
        self.mesh.accept(self.purpose(), model, machine.tools.watch)?;
        self.settle(&model.spec, formats, machine)
    }

    /// Meshes `model`, and puts its supports and loads into the deck. The phase is the one that is farthest off its volume.
    ///
    /// # Errors
    /// Those of meshing; a deck that the mesh cannot have.
    pub fn answer(
        &self,
        settled: &mut DeckSettled,
        model: &Model,
        tools: &Tools<'_>,
    ) -> Result<(Mesh, Option<PhaseOff>), AskError> {
        let (mesh, off) = self.mesh.mesh(&settled.footing, model, tools)?;
        self.load(settled, &mesh, model, off)?;
        if settled.is_written {
            settled.deck.validate(&mesh).map_err(|error| self.wrong_option(&error))?;
        }
        Ok((mesh, off))
    }

    /// Refuses options of decks without effect: on this deck, or because none is written.
    fn accept_deck(&self, deck: &DeckOptions, mesh: &MeshOptions, formats: &[MeshFormat]) -> Result<(), AskError> {
        if has_deck(formats) {
            let has_hexahedra = mesh.method.name() == MethodName::Voxel;
            return deck.validate_effects(has_hexahedra).map_err(|error| self.wrong_option(&error));
        }
        // An analysis also decides mesh and packing, a time increment the figures.
        match self.given.asked().find(|key| *key != "time_increment_s") {
            Some(key) => {
                let option = self.given.giver().option(key);
                Err(AskError::Usage(format!("{option} has no effect: no .inp or .k is written; leave it out")))
            }
            None => Ok(()),
        }
    }

    /// Refuses a deck without values of the phases that `spec` adds, or with values of others.
    fn suits_phases(&self, spec: &Spec, formats: &[MeshFormat]) -> Result<(), AskError> {
        let has_own = self.mesh.materials.as_ref().is_some_and(|materials| !materials.own.is_empty());
        if !has_own && (!has_deck(formats) || self.given.options.geometry_only) {
            return Ok(());
        }
        self.mesh.suits_phases(spec)
    }

    fn accept_formats(&self, deck: &DeckOptions, formats: &[MeshFormat]) -> Result<(), AskError> {
        formats.iter().try_for_each(|format| format.check(deck)).map_err(|error| self.wrong_option(&error))
    }

    /// Contents of a deck of `spec`, checked as far as that takes no mesh.
    fn deck(&self, spec: &Spec, mesh: &MeshOptions) -> Result<DeckOptions, AskError> {
        let deck = DeckOptions {
            materials: self.mesh.materials.clone().unwrap_or_default(),
            allow_joined: self.mesh.table().joined == Some(Joined::Keep),
            ..self.options()
        };
        deck.validate_for(spec.specimen.periodic().0).map_err(|error| self.wrong_option(&error))?;
        if mesh.itz == ItzForm::Cohesive {
            deck.validate_cohesive().map_err(|error| self.wrong_option(&error))?;
        }
        Ok(deck)
    }

    fn hint(&self, spec: &Spec, itz: ItzForm) -> Option<String> {
        let [low, high] = spec.itz.thickness_mm;
        (self.mesh.table().itz.is_none() && itz == ItzForm::None && high > 0.0).then(|| {
            let giver = self.mesh.given.giver();
            let (cohesive, lattice) = (giver.choice("itz", "cohesive"), giver.choice("method", "lattice"));
            format!(
                "no ITZ in the mesh: shells of {low} to {high} mm are thinner than its elements. {cohesive} or {lattice} \
                 includes them"
            )
        })
    }

    /// Puts the supports and loads of the test on `mesh` into the deck, and the heading.
    fn load(
        &self,
        settled: &mut DeckSettled,
        mesh: &Mesh,
        model: &Model,
        off: Option<PhaseOff>,
    ) -> Result<(), AskError> {
        let (spec, options) = (&model.spec, settled.footing.options.for_bodies(&model.aggregates));
        settled.deck.head(spec, &options, off.is_some_and(|off| !off.is_accepted()));
        let sample = Sample::of(mesh, &spec.specimen, &options);
        settled.deck.load(&sample).map_err(|error| self.wrong_test(&error))
    }

    /// A value of a deck out of its range, in the giver's spelling.
    fn wrong_option(&self, error: &OutOfRange) -> AskError {
        AskError::Usage(self.given.refusal(error))
    }

    /// An error of a deck's test, in the giver's spelling.
    fn wrong_test(&self, error: &TrialError) -> AskError {
        AskError::Usage(deck_refusal(&self.options(), "analysis", error, self.given.giver()))
    }
}
