//! Abaqus input decks (`.inp`): flat, streamed, read by Abaqus, CalculiX and meshio.
//!
//! gmsh writes such decks but has no reader for them (none in 4.15); [`msh`](super::msh) is for gmsh.
//!
//! Element sets, node sets, surfaces and materials have the names AGGREGATE, ITZ, MORTAR (and FIBRE, where there are
//! fibres), XMIN to ZMAX and S_XMIN to S_ZMAX. Node and element numbers are the mesh's indices plus 1. The rules kept throughout: keyword lines under 80
//! characters, data lines of at most 16 entries and 256 characters, numbers of at most 20.

mod damage;
mod elastic;
mod explicit;
mod geometry;
mod limits;
mod lines;
mod materials;
mod periodic;

use crate::materials::Materials;
use crate::mesh::sides::Sides;
use crate::mesh::{Mesh, Phase};
pub use limits::DeckError;
use lines::Lines;
use serde::{Deserialize, Serialize};
use std::io::{self, Write};

/// What a deck holds besides the mesh.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DeckOptions {
    /// Write nodes, elements, sets and surfaces alone, for `*INCLUDE`.
    pub geometry_only: bool,
    /// Hexahedra with reduced integration, C3D8R for C3D8.
    pub reduced_integration: bool,
    /// Tie opposite faces of a periodic box by `*EQUATION`, with the reference nodes REF_X, REF_Y and REF_Z.
    pub periodic_equations: bool,
    /// The analysis the deck runs; `geometry_only` leaves it out.
    pub analysis: Analysis,
    /// Mean axial strain at the end of the analysis, a positive number; absent: the analysis' own.
    pub strain: Option<f64>,
    /// How compression and tension are loaded.
    pub loading: Loading,
    /// Material values.
    pub materials: Materials,
    /// Lines for `*HEADING`, e.g. the command and the version: ASCII, none beginning with `*`; 76 characters of each are kept.
    pub heading: Vec<String>,
}

/// What a deck computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Analysis {
    /// Nothing: mesh, materials and sections, ready for one's own steps.
    #[default]
    None,
    /// Linear elastic uniaxial compression by `*STATIC` (default strain 0.001); of the mean stress, where the box is
    /// periodic and its faces are tied.
    Elastic,
    /// Quasi-static compression between rigid plates with friction, explicit, with damage (default strain 0.006).
    Compression,
    /// Quasi-static tension between glued plates, explicit, with damage (default strain 0.001).
    Tension,
}

/// How the explicit analyses are loaded.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Loading {
    /// Friction between plates and specimen; the paper's low and high cases are 0.1 and 0.6.
    pub friction: f64,
    /// Length of the step, s.
    pub duration_s: f64,
    /// Time increment that mass scaling keeps, s.
    pub time_increment_s: f64,
    /// Frames of field output.
    pub frames: u32,
}

impl Default for Loading {
    /// 100,000 increments: 18 mm/s on the paper's specimen, slow against waves of 3,500 m/s.
    fn default() -> Self {
        Self { friction: 0.1, duration_s: 0.05, time_increment_s: 5e-7, frames: 50 }
    }
}

impl DeckOptions {
    /// Finds out whether `mesh` can be written as a deck with these options.
    ///
    /// # Errors
    /// Names the option, its value and what is accepted.
    pub fn validate(&self, mesh: &Mesh) -> Result<(), DeckError> {
        self.validate_for(mesh.periodic)?;
        if self.has_curves() {
            materials::check(mesh, &self.materials)?;
        }
        if !mesh.cohesive.is_empty() {
            self.validate_cohesive()?;
        }
        if self.analysis == Analysis::Compression && !self.geometry_only {
            explicit::check(&Sides::of(mesh))?;
        }
        if self.periodic_equations { periodic::check(mesh) } else { Ok(()) }
    }

    /// What can be said of cohesive elements before there is a mesh.
    ///
    /// # Errors
    /// As [`validate`](Self::validate).
    pub fn validate_cohesive(&self) -> Result<(), DeckError> {
        if self.geometry_only { Ok(()) } else { limits::separation(&self.materials) }
    }

    /// Whether mortar and ITZ have strength in the deck.
    fn has_curves(&self) -> bool {
        self.analysis.damages() && !self.geometry_only
    }

    /// What can be said before there is a mesh: of a specimen that repeats itself along the `periodic` axes.
    ///
    /// # Errors
    /// As [`validate`](Self::validate).
    pub fn validate_for(&self, periodic: [bool; 3]) -> Result<(), DeckError> {
        limits::check(self)?;
        if self.has_curves() {
            limits::curves(&self.materials, Phase::Mortar, 0.0)?;
        }
        if !self.periodic_equations {
            return Ok(());
        }
        let no = |key, value, accepted| Err(DeckError::new(key, value, accepted));
        let tie = "only a box without walls has faces to tie: pack with specimen.periodic = [\"x\", \"y\", \"z\"]";
        let step = "with periodic_equations it needs a box without any wall; take none and a step of your own";
        match self.analysis {
            _ if periodic == [false; 3] => no("periodic_equations", "true", tie),
            Analysis::Elastic if !self.geometry_only && periodic != [true; 3] => no("analysis", "elastic", step),
            Analysis::None | Analysis::Elastic => Ok(()),
            Analysis::Compression | Analysis::Tension => {
                no("periodic_equations", "true", "plates need free faces; take analysis elastic or none")
            }
        }
    }
}

/// Writes `mesh` as a deck to `out`, streamed, without a second copy of the mesh.
///
/// # Errors
/// Those of `out`, and those of [`DeckOptions::validate`] as invalid input.
pub fn write(mesh: &Mesh, options: &DeckOptions, out: impl Write) -> io::Result<()> {
    options.validate(mesh).map_err(|error| io::Error::new(io::ErrorKind::InvalidInput, error))?;
    let mut lines = Lines::new(out);
    geometry::heading(&mut lines, options)?;
    let sides = Sides::of(mesh);
    geometry::write(&mut lines, mesh, &sides, options)?;
    if options.periodic_equations {
        periodic::write(&mut lines, mesh, &sides)?;
    }
    if !options.geometry_only {
        materials::write(&mut lines, mesh, options)?;
        match options.analysis {
            Analysis::None => {}
            Analysis::Elastic => {
                let step = if options.periodic_equations { elastic::write_periodic } else { elastic::write };
                step(&mut lines, mesh, &sides, options.strain.unwrap_or(0.001))?;
            }
            Analysis::Compression | Analysis::Tension => explicit::write(&mut lines, mesh, &sides, options)?,
        }
    }
    lines.finish()
}
