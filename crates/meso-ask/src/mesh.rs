//! A mesh: its options for one use, what its specimen cannot have, and the mesh itself.

use crate::footing::{self, Footing};
use crate::{AskError, Given, Giver, Machine};
use meso_core::aggregate::Itz;
use meso_core::materials::Materials;
use meso_core::mesh::{self, Mesh, MeshError, MeshOptions, MeshTable, MethodName, PhaseOff, Purpose, Room, Tools};
use meso_core::{Model, Spec, Watch};
use std::sync::OnceLock;

/// A mesh that is asked for.
#[derive(Clone, Debug, Default)]
pub struct MeshAsk {
    /// The options.
    pub given: Given<MeshTable>,
    /// Whether a phase may be any share off its exact volume.
    pub accept_phase_error: bool,
    /// Values of the materials; `None` for those of a file that was not read.
    pub materials: Option<Materials>,
    /// The size that `auto` means for the packing at hand, mm.
    pub tried: OnceLock<f64>,
}

impl MeshAsk {
    /// The options, with the size that was found.
    pub fn table(&self) -> MeshTable {
        self.given.options.clone().with_tried(self.tried.get().copied())
    }

    /// Finds the size that `auto` means for `spec`. `leaves_room` says that it is still to be packed, with the gaps that the
    /// mesh needs.
    ///
    /// # Errors
    /// A packing of which no size keeps the phases.
    fn try_sizes(&self, purpose: Purpose, spec: &Spec, leaves_room: bool, watch: &dyn Watch) -> Result<(), AskError> {
        if self.given.options.is_auto() && self.tried.get().is_none() {
            let found = footing::element_size(&self.table(), purpose, spec, leaves_room, watch);
            let size = found.map_err(|error| self.wrong(&error))?;
            self.tried.get_or_init(|| size);
        }
        Ok(())
    }

    /// The options for any packing whose aggregates have these shells.
    ///
    /// # Errors
    /// Options that are out of their range, or have no effect.
    pub fn options(&self, purpose: Purpose, shells: &Itz) -> Result<MeshOptions, AskError> {
        self.table().resolve(purpose, shells).map_err(|error| self.wrong(&error))
    }

    /// The mesh for packings of `spec`.
    ///
    /// # Errors
    /// Options that do not fit the specimen, and a missing gmsh.
    pub fn settle(&self, purpose: Purpose, spec: &Spec, machine: &Machine<'_>) -> Result<Footing, AskError> {
        let options = self.options(purpose, &spec.itz)?;
        options.validate(&spec.specimen).map_err(|error| self.wrong(&error))?;
        options.accepts_shape(&spec.shape).map_err(|error| self.wrong(&error))?;
        if options.method.name() == MethodName::Conforming {
            machine.tools.gmsh.available().map_err(|error| self.wrong(&error))?;
        }
        Ok(Footing { purpose, options, accepts_phase_error: self.accept_phase_error })
    }

    /// Refuses a method that cannot mesh the bodies of `model`, before gmsh is looked for: a label volume's spec has no shape.
    /// Then finds the size that `auto` means.
    ///
    /// # Errors
    /// The method; a packing of which no size keeps the phases.
    pub fn accept(&self, purpose: Purpose, model: &Model, watch: &dyn Watch) -> Result<(), AskError> {
        let options = self.options(purpose, &model.spec.itz)?;
        mesh::accepts(&model.aggregates, &options).map_err(|error| self.wrong(&error))?;
        self.try_sizes(purpose, &model.spec, false, watch)
    }

    /// Meshes `model`, and finds the phase that is farthest off its exact volume.
    ///
    /// # Errors
    /// Those of [`Footing::mesh`].
    pub fn mesh(
        &self,
        footing: &Footing,
        model: &Model,
        tools: &Tools<'_>,
    ) -> Result<(Mesh, Option<PhaseOff>), AskError> {
        footing.mesh(model, tools).map_err(|error| self.wrong(&error))
    }

    /// Finds the size that `auto` means, and sets the gaps that the mesh needs and `spec` leaves open; returns a line about
    /// them.
    ///
    /// # Errors
    /// Options that do not fit the specimen.
    pub fn leave_room(&self, purpose: Purpose, spec: &mut Spec, watch: &dyn Watch) -> Result<Option<String>, AskError> {
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

    /// Refuses phases of `spec` without values, and values of others.
    ///
    /// # Errors
    /// The first of them.
    pub(crate) fn suits_phases(&self, spec: &Spec) -> Result<(), AskError> {
        let usual = Materials::default();
        let suits = self.materials.as_ref().unwrap_or(&usual).suits(&spec.phases());
        let option = self.given.giver().option("materials");
        suits.map_err(|error| AskError::Usage(format!("{error} ({option})")))
    }

    /// An error of meshing in the giver's spelling; wrong options are wrong usage.
    pub(crate) fn wrong(&self, error: &MeshError) -> AskError {
        let giver = self.given.giver();
        let text = error.message(|key| giver.option(key));
        match error {
            MeshError::Option(wrong) => AskError::Usage(giver.refusal(wrong)),
            MeshError::MissingGmsh { .. } => {
                let lattice = giver.choice("method", "lattice");
                AskError::Run(match giver {
                    Giver::Keywords | Giver::Keyword(_) => {
                        format!("{text} for this Python or on the PATH, or take {lattice}")
                    }
                    _ => {
                        // A file names no program.
                        let program = Giver::Flags.option("gmsh");
                        format!("{text} and put it on the PATH or name it with {program}, or take {lattice}")
                    }
                })
            }
            MeshError::PhaseError { .. } => {
                AskError::Run(format!("{text}; {} accepts it", giver.option("accept_phase_error")))
            }
            MeshError::NearTouching { .. } => {
                let method = giver.choice("method", "conforming");
                AskError::Run(format!("{text}; a packing that is made with {method} leaves such gaps by itself"))
            }
            MeshError::Files { error, .. } => AskError::files(text, error),
            _ => AskError::Run(text),
        }
    }
}
