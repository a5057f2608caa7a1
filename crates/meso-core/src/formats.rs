//! What a packing and a mesh can be written as: the file's extension names the format.

use crate::export::abaqus::{self, DeckOptions};
use crate::export::{csv, stl, vtu, vtu_mesh};
use crate::mesh::Mesh;
use crate::model::Model;
use crate::packing::Images;
use crate::saved;
use std::io::{self, Write};
use std::path::Path;

/// A format that holds the aggregates themselves; meshes have their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// The saved model.
    Json,
    /// Surfaces as polygons.
    Vtu,
    /// Surfaces as triangles.
    Stl,
    /// One row per aggregate.
    Csv,
}

impl Format {
    /// All formats, the saved model first.
    pub const ALL: [Self; 4] = [Self::Json, Self::Vtu, Self::Stl, Self::Csv];

    /// The extension without its dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Json => "json",
            Self::Vtu => "vtu",
            Self::Stl => "stl",
            Self::Csv => "csv",
        }
    }

    /// What it holds, in a few words.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Json => "the saved model, bit for bit; every other command reads it",
            Self::Vtu => "aggregate surfaces as polygons with ids, classes, ITZ: ParaView, PyVista, meshio",
            Self::Stl => "aggregate surfaces as triangles: CAD, 3D printers",
            Self::Csv => "one row per aggregate: size, volume, area, centroid, ITZ",
        }
    }

    /// The format that the extension of `path` names, in either case.
    pub fn from_path(path: &Path) -> Option<Self> {
        let extension = lower_extension(path)?;
        Self::ALL.into_iter().find(|format| format.extension() == extension)
    }

    /// Writes `model` to `out` in this format, every aggregate once.
    ///
    /// # Errors
    /// Those of `out`; what the format cannot hold.
    pub fn write(self, model: &Model, out: impl Write) -> io::Result<()> {
        self.write_images(model, Images::None, out)
    }

    /// As [`Format::write`], with the images of aggregates that cross a face of a periodic specimen, where the format holds
    /// surfaces (`.vtu`, `.stl`).
    ///
    /// # Errors
    /// Those of `out`; what the format cannot hold.
    pub fn write_images(self, model: &Model, images: Images, out: impl Write) -> io::Result<()> {
        let shown = || images.of(&model.aggregates, &model.spec.specimen);
        match self {
            Self::Json => saved::write(model, out),
            Self::Vtu if images != Images::None => vtu::write(&shown(), out),
            Self::Vtu => vtu::write(&model.aggregates, out),
            Self::Stl if images != Images::None => stl::write(&shown(), out),
            Self::Stl => stl::write(&model.aggregates, out),
            Self::Csv => csv::write(&model.aggregates, out),
        }
    }
}

/// A format that holds a mesh for finite elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Abaqus and CalculiX.
    Inp,
    /// Cells with phase and aggregate id.
    Vtu,
}

impl MeshFormat {
    /// All formats, the deck first.
    pub const ALL: [Self; 2] = [Self::Inp, Self::Vtu];

    /// The extension without its dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Inp => "inp",
            Self::Vtu => "vtu",
        }
    }

    /// The format that the extension of `path` names, in either case.
    pub fn from_path(path: &Path) -> Option<Self> {
        let extension = lower_extension(path)?;
        Self::ALL.into_iter().find(|format| format.extension() == extension)
    }

    /// Writes `mesh` to `out` in this format; `deck` counts for decks.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(self, mesh: &Mesh, deck: &DeckOptions, out: impl Write) -> io::Result<()> {
        match self {
            Self::Inp => abaqus::write(mesh, deck, out),
            Self::Vtu => vtu_mesh::write(mesh, &[], out),
        }
    }
}

fn lower_extension(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}
