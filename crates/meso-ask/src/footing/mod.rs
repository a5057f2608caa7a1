//! A mesh that a test may stand on: one rule for packings, decks, tests, studies and Python.
//!
//! 1. [`leave_room`] gives a packing the gaps that the elements of its mesh resolve.
//! 2. [`Footing::mesh`] meshes it, and refuses a phase that is far off its exact volume: before meshing where a small cube
//!    shows it already (`trial`), else before the first step. The error names a size of elements that was tried.
//! 3. `Sample::doubts` and `Sample::flags` say what is left to know about a mesh before any step.

mod trial;

pub use trial::{element_size, options};

use meso_core::mesh::{Mesh, MeshError, MeshOptions, MethodName, PhaseOff, Purpose, Room, Tools, build};
use meso_core::{Model, Spec};
use trial::Trial;

/// Largest elements of the documented first test, mm. It goes on with its phase error, and its results carry the flag.
const FIRST_MM: f64 = 4.0;
/// A specimen of fewer cubes of one element is meshed before anything is tried: that takes seconds.
const QUICK: f64 = 20_000.0;
/// A specimen that is not this many times as large as the cube of a trial is meshed at once.
const FAR_LARGER: f64 = 4.0;
/// Phase error of a trial, as a share, beyond which the specimen is not meshed. A cube of 50 mm lost 32 % of its aggregates where
/// one of 150 mm lost 19 %.
const HOPELESS: f64 = 2.0 * PhaseOff::ACCEPTED;

/// Sets the gaps that a mesh needs and `spec` leaves open; returns them, mm, and `None` if nothing changes.
///
/// # Errors
/// Options that do not suit the specimen.
pub fn leave_room(spec: &mut Spec, options: &MeshOptions, purpose: Purpose) -> Result<Option<(Room, f64)>, MeshError> {
    let Some(room) = options.room(purpose) else { return Ok(None) };
    options.validate(&spec.specimen)?;
    Ok(spec.leave_room(room).map(|gap| (room, gap)))
}

/// How a mesh is made and judged.
#[derive(Clone, Debug)]
pub struct Footing {
    /// Use of the mesh.
    pub purpose: Purpose,
    /// Options of the mesh.
    pub options: MeshOptions,
    /// Whether a phase may be any share off its exact volume.
    pub accepts_phase_error: bool,
}

impl Footing {
    /// Meshes `model`, and finds the phase that is farthest off its exact volume; `None` where that is not known.
    ///
    /// # Errors
    /// [`MeshError::PhaseError`] for a phase that is farther off than [`PhaseOff::ACCEPTED`]; other faults of meshing.
    pub fn mesh(&self, model: &Model, tools: &Tools) -> Result<(Mesh, Option<PhaseOff>), MeshError> {
        let trial = Trial { footing: self, spec: &model.spec, leaves_room: false, watch: tools.watch };
        self.foresee(&trial)?;
        let mesh = build(model, &self.options, tools)?;
        match PhaseOff::accept(&mesh, model, &self.options, self.accepted()) {
            Ok(off) => Ok((mesh, off)),
            Err(error) => {
                drop(mesh);
                Err(trial.advised(error))
            }
        }
    }

    /// Largest accepted phase error, as a share.
    fn accepted(&self) -> f64 {
        let is_documented = self.purpose == Purpose::FirstTest && self.options.element_size_mm <= FIRST_MM;
        if self.accepts_phase_error || is_documented { f64::INFINITY } else { PhaseOff::ACCEPTED }
    }

    /// Refuses a mesh that takes long and whose phases are far off in a small cube already.
    fn foresee(&self, trial: &Trial) -> Result<(), MeshError> {
        let specimen = &trial.spec.specimen;
        let is_quick = self.options.method.name() != MethodName::Lattice || self.options.cubes(specimen) < QUICK;
        if self.accepted().is_infinite() || is_quick || specimen.volume() < FAR_LARGER * trial.cube_mm().powi(3) {
            return Ok(());
        }
        match trial.of(&self.options).filter(|tried| tried.off.is_beyond(HOPELESS)) {
            Some(tried) => {
                let are_faceted = MeshOptions::are_faceted(&trial.spec.shape);
                Err(trial.advised(tried.off.refused(
                    &trial.spec.phases(),
                    &self.options,
                    are_faceted,
                    Some(trial.cube_mm()),
                )))
            }
            None => Ok(()),
        }
    }
}
