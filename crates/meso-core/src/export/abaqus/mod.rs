//! Abaqus input decks (`.inp`): flat, streamed, read by Abaqus, CalculiX, meshio and gmsh.
//!
//! Element sets, node sets, surfaces and materials have the names AGGREGATE, ITZ, MORTAR, XMIN to ZMAX and S_XMIN to
//! S_ZMAX. Node and element numbers are the mesh's indices plus 1. The rules kept throughout: keyword lines under 80
//! characters, data lines of at most 16 entries and 256 characters, numbers of at most 20.

mod elastic;
mod geometry;
mod lines;
mod materials;

use crate::materials::Materials;
use crate::mesh::Mesh;
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
}

/// Writes `mesh` as a deck to `out`, in one pass and without a second copy of the mesh.
///
/// # Errors
/// Those of `out`.
pub fn write(mesh: &Mesh, options: &DeckOptions, out: impl Write) -> io::Result<()> {
    let mut lines = Lines::new(out);
    geometry::heading(&mut lines, &options.heading)?;
    let sides = geometry::Sides::of(&mesh.points);
    geometry::write(&mut lines, mesh, &sides, options)?;
    if !options.geometry_only {
        materials::write(&mut lines, mesh, &options.materials)?;
        match options.analysis {
            Analysis::None => {}
            Analysis::Elastic => elastic::write(&mut lines, mesh, &sides, options.strain.unwrap_or(0.001))?,
        }
    }
    lines.finish()
}
