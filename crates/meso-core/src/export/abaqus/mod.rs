//! Abaqus input decks (`.inp`): flat, streamed, read by Abaqus, CalculiX and meshio.
//!
//! gmsh writes such decks but has no reader for them (none in 4.15); [`msh`](super::msh) is for gmsh.
//!
//! Element sets, node sets, surfaces and materials have the names AGGREGATE, ITZ, MORTAR, XMIN to ZMAX and S_XMIN to
//! S_ZMAX. Node and element numbers are the mesh's indices plus 1. The rules kept throughout: keyword lines under 80
//! characters, data lines of at most 16 entries and 256 characters, numbers of at most 20.

mod damage;
mod elastic;
mod explicit;
mod geometry;
mod lines;
mod materials;

use crate::materials::Materials;
use crate::mesh::Mesh;
use crate::mesh::sides::Sides;
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
    /// The analysis the deck runs; `geometry_only` leaves it out.
    pub analysis: Analysis,
    /// Mean axial strain at the end of the analysis, a positive number; absent: the analysis' own.
    pub strain: Option<f64>,
    /// How compression and tension are loaded.
    pub loading: Loading,
    /// Material values.
    pub materials: Materials,
    /// Lines for `*HEADING`, e.g. the command and the version.
    pub heading: Vec<String>,
}

/// What a deck computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Analysis {
    /// Nothing: mesh, materials and sections, ready for one's own steps.
    #[default]
    None,
    /// Linear elastic uniaxial compression by `*STATIC` (default strain 0.001).
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

/// Writes `mesh` as a deck to `out`, in one pass and without a second copy of the mesh.
///
/// # Errors
/// Those of `out`.
pub fn write(mesh: &Mesh, options: &DeckOptions, out: impl Write) -> io::Result<()> {
    let mut lines = Lines::new(out);
    geometry::heading(&mut lines, &options.heading)?;
    let sides = Sides::of(&mesh.points);
    geometry::write(&mut lines, mesh, &sides, options)?;
    if !options.geometry_only {
        materials::write(&mut lines, mesh, options)?;
        match options.analysis {
            Analysis::None => {}
            Analysis::Elastic => elastic::write(&mut lines, mesh, &sides, options.strain.unwrap_or(0.001))?,
            Analysis::Compression | Analysis::Tension => explicit::write(&mut lines, mesh, &sides, options)?,
        }
    }
    lines.finish()
}
