//! Options of a mesh and its deck that follow from the flags, for one specimen.

use super::flags::{DeckFlags, MeshFlags};
use crate::failure::Failure;
use crate::{inputs, room};
use meso_ask::Giver;
use meso_core::aggregate::Itz;
use meso_core::export::abaqus::DeckOptions;
use meso_core::formats::MeshFormat;
use meso_core::materials::Materials;
use meso_core::mesh::{self, ItzForm, Joined, Mesh, MeshError, MeshOptions, MethodName, PhaseOff, Purpose, Room};
use meso_core::spec::options_from_toml;
use meso_core::{Model, Spec, Watch};
use meso_gmsh::Gmsh;
use meso_solve::Sample;
use meso_solve::footing::{self, Footing};
use std::path::Path;

// A doc comment here would become the command's own description.
#[derive(clap::Args, Debug)]
pub(crate) struct Meshing {
    #[command(flatten)]
    mesh: MeshFlags,
    #[command(flatten)]
    pub(super) deck: DeckFlags,
}

/// A mesh and its deck, checked for one spec.
pub(crate) struct Settings {
    pub(crate) mesh: MeshSettings,
    pub(crate) deck: DeckOptions,
    /// How to get the ITZ, if the mesh has none by default.
    pub(crate) hint: Option<String>,
}

/// A mesh, and the program that it may need.
pub(crate) struct MeshSettings {
    pub(crate) footing: Footing,
    pub(super) gmsh: Gmsh,
    pub(super) giver: Giver<'static>,
}

impl MeshFlags {
    /// The options for any packing whose aggregates have these shells.
    pub(crate) fn options(&self, purpose: Purpose, shells: &Itz) -> Result<MeshOptions, Failure> {
        self.table().resolve(purpose, shells).map_err(|error| self.wrong(&error))
    }

    /// The options for packings of `spec`. Options that do not fit its specimen are wrong usage, a missing gmsh a failure.
    pub(crate) fn settings(&self, purpose: Purpose, spec: &Spec) -> Result<MeshSettings, Failure> {
        let options = self.options(purpose, &spec.itz)?;
        let gmsh = Gmsh::program(&self.gmsh);
        options.validate(&spec.specimen).map_err(|error| self.wrong(&error))?;
        options.accepts_shape(&spec.shape).map_err(|error| self.wrong(&error))?;
        if options.method.name() == MethodName::Conforming {
            gmsh.check().map_err(|error| self.wrong(&error))?;
        }
        let accepts_phase_error = self.accept_phase_error;
        let giver = self.given.giver();
        Ok(MeshSettings { footing: Footing { purpose, options, accepts_phase_error }, gmsh, giver })
    }

    /// Refuses a method that cannot mesh the bodies of `model`, before gmsh is looked for: a label volume's spec has no shape.
    pub(crate) fn accept(&self, purpose: Purpose, model: &Model) -> Result<(), Failure> {
        let options = self.options(purpose, &model.spec.itz)?;
        mesh::accepts(&model.aggregates, &options).map_err(|error| self.wrong(&error))
    }

    /// The materials of the file that is given, or the illustrative ones.
    pub(crate) fn materials(&self) -> Result<Materials, Failure> {
        materials(self.materials.as_deref())
    }
}

/// The materials of a file, or the illustrative ones.
pub(crate) fn materials(path: Option<&Path>) -> Result<Materials, Failure> {
    let Some(path) = path else { return Ok(Materials::default()) };
    inputs::toml(path, options_from_toml).map(|file: MaterialsFile| file.materials)
}

/// A file of material values.
#[derive(Default, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
struct MaterialsFile {
    materials: Materials,
}

impl Meshing {
    /// Sets who gave the options.
    pub(crate) fn given_by(&mut self, giver: Giver<'static>) {
        self.mesh.given_by(giver);
        self.deck.given.given_by(giver);
    }

    fn purpose(&self) -> Purpose {
        if self.deck.analyses() { Purpose::Test } else { Purpose::Mesh }
    }

    /// Whether a deck is of a test with a curve.
    pub(crate) fn has_curve(&self) -> bool {
        self.deck.options().is_ok_and(|deck| deck.has_curve())
    }

    /// Refuses an analysis that no packing can have in these formats, before any work.
    pub(crate) fn accept_formats(&self, mut formats: impl Iterator<Item = MeshFormat>) -> Result<(), Failure> {
        let deck = self.deck.options()?;
        formats.try_for_each(|format| format.check(&deck)).map_err(|error| self.wrong_option(&error))?;
        deck.follows().map_err(|error| self.deck.wrong_test(&error))
    }

    /// Whether the test of the deck is a file.
    pub(crate) fn has_test_file(&self) -> bool {
        self.deck.file().is_some()
    }

    /// The files that are read.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.mesh.inputs().chain(self.deck.file())
    }

    /// Refuses flags that suit no packing.
    pub(crate) fn validate(&self) -> Result<(), Failure> {
        self.mesh.options(self.purpose(), &Itz::default()).map(drop)
    }

    /// Refuses flags that suit no packing of `spec`. It opens no file and looks for no gmsh. A default size is no flag.
    pub(crate) fn validate_for(&self, spec: &Spec, writes_deck: bool) -> Result<(), Failure> {
        let options = self.mesh.options(self.purpose(), &spec.itz)?;
        if !self.mesh.has_materials() {
            self.validate_deck(&self.deck(spec, &options)?, &options, writes_deck)?;
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

    /// Refuses a method that cannot mesh the bodies of `model`.
    pub(crate) fn accept(&self, model: &Model) -> Result<(), Failure> {
        self.mesh.accept(self.purpose(), model)
    }

    /// Everything for packings of `spec`; flags of decks are refused where no deck is written.
    pub(crate) fn settings(&self, spec: &Spec, writes_deck: bool) -> Result<Settings, Failure> {
        let mesh = self.mesh.settings(self.purpose(), spec)?;
        let options = &mesh.footing.options;
        room::accept_in_memory(
            "the mesh",
            options.bytes(&spec.specimen),
            (&self.mesh.given.giver().option("element_size_mm"), options.element_size_mm),
        )?;
        let deck = self.deck(spec, options)?;
        self.validate_deck(&deck, options, writes_deck)?;
        deck.suits(&spec.specimen).map_err(|error| self.deck.wrong_test(&error))?;
        Ok(Settings { hint: self.hint(spec, options.itz), mesh, deck })
    }

    /// Refuses flags of decks without effect: on this deck, or because none is written.
    fn validate_deck(&self, deck: &DeckOptions, mesh: &MeshOptions, is_written: bool) -> Result<(), Failure> {
        if is_written {
            let has_hexahedra = mesh.method.name() == MethodName::Voxel;
            return deck.validate_effects(has_hexahedra).map_err(|error| self.wrong_option(&error));
        }
        match self.deck.only_for_decks() {
            Some(option) => {
                Err(Failure::Usage(format!("{option} has no effect: no .inp or .k is written; leave it out")))
            }
            None => Ok(()),
        }
    }

    /// Contents of a deck of `spec`, checked as far as that takes no mesh.
    fn deck(&self, spec: &Spec, mesh: &MeshOptions) -> Result<DeckOptions, Failure> {
        let deck = DeckOptions {
            materials: self.mesh.materials()?,
            allow_joined: self.mesh.table().joined == Some(Joined::Keep),
            ..self.deck.options()?
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
            format!(
                "no ITZ in the mesh: shells of {low} to {high} mm are thinner than its elements. --itz cohesive or --method lattice \
                 includes them"
            )
        })
    }

    /// Finds the size that `auto` means, and sets the gaps that the mesh needs and the spec leaves open; says so.
    pub(crate) fn leave_room(&self, spec: &mut Spec, watch: &dyn Watch) -> Result<Option<String>, Failure> {
        self.mesh.leave_room(self.purpose(), spec, watch)
    }

    /// Finds the size that `auto` means for a packing that is there.
    pub(crate) fn try_sizes(&self, spec: &Spec, watch: &dyn Watch) -> Result<(), Failure> {
        self.mesh.try_sizes(self.purpose(), spec, false, watch)
    }

    /// Puts the supports and loads of the test on `mesh` into the deck, and the heading. `off` is the phase that is farthest
    /// off its volume.
    pub(crate) fn load(
        &self,
        settings: &mut Settings,
        mesh: &Mesh,
        model: &Model,
        off: Option<PhaseOff>,
    ) -> Result<(), Failure> {
        let (spec, options) = (&model.spec, settings.mesh.footing.options.for_bodies(&model.aggregates));
        settings.deck.head(spec, &options, off.is_some_and(|off| !off.is_accepted()));
        let sample = Sample::of(mesh, &spec.specimen, &options);
        settings.deck.load(&sample).map_err(|error| self.deck.wrong_test(&error))
    }
}

impl MeshFlags {
    /// Finds the size that `auto` means, and sets the gaps that the mesh needs and the spec leaves open; says so.
    pub(crate) fn leave_room(
        &self,
        purpose: Purpose,
        spec: &mut Spec,
        watch: &dyn Watch,
    ) -> Result<Option<String>, Failure> {
        self.try_sizes(purpose, spec, true, watch)?;
        let options = self.options(purpose, &spec.itz)?;
        let left = footing::leave_room(spec, &options, purpose).map_err(|error| self.wrong(&error))?;
        Ok(left.map(|(room, gap)| match room {
            Room::Everywhere(_) => format!("packing with gaps of {gap} mm, which a conforming mesh needs"),
            Room::Between(_) => {
                format!(
                    "packing with gaps of {gap} mm between aggregates, so that the elements resolve the mortar there"
                )
            }
        }))
    }
}
