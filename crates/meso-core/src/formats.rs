//! What a packing and a mesh can be written as: the file's extension names the format.

use crate::export::abaqus::{self, DeckOptions};
use crate::export::vtk::Encoding;
use crate::export::{csv, msh, pvtu, stl, vtu, vtu_mesh};
use crate::mesh::Mesh;
use crate::model::Model;
use crate::packing::Images;
use crate::saved;
use std::borrow::Cow;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// How the aggregates' surfaces are written.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Surfaces {
    /// What is shown of aggregates that cross a face of a periodic specimen.
    pub images: Images,
    /// Of a `.vtu`.
    pub encoding: Encoding,
}

/// A format that holds the aggregates themselves; meshes have their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// The saved model.
    Json,
    /// Surfaces as polygons.
    Vtu,
    /// Surfaces as triangles.
    Stl,
    /// One row per body.
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
            Self::Csv => "one row per aggregate, void and fibre: size, volume, area, centroid, ITZ",
        }
    }

    /// The format that the extension of `path` names, in either case.
    pub fn from_path(path: &Path) -> Option<Self> {
        let extension = lower_extension(path)?;
        Self::ALL.into_iter().find(|format| format.extension() == extension)
    }

    /// Writes `model` to `out` in this format; `surfaces` counts where the format holds surfaces (`.vtu`, `.stl`).
    ///
    /// # Errors
    /// Those of `out`; what the format cannot hold.
    pub fn write(self, model: &Model, surfaces: Surfaces, out: impl Write) -> io::Result<()> {
        let shown = || match surfaces.images {
            Images::None => model.bodies(),
            images => Cow::Owned(images.of(&model.bodies(), &model.spec.specimen)),
        };
        match self {
            Self::Json => saved::write(model, out),
            Self::Vtu => vtu::write(&shown(), surfaces.encoding, out),
            Self::Stl => stl::write(&shown(), out),
            Self::Csv => csv::write(model.aggregates.iter().chain(&model.inclusions), out),
        }
    }
}

/// A format that holds a mesh for finite elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Abaqus and CalculiX.
    Inp,
    /// Cells with phase, aggregate id and quality: ParaView, PyVista, meshio.
    Vtu,
    /// gmsh 4.1, with physical groups.
    Msh,
    /// The same as `.vtu`, in pieces: an index, and `.vtu` files beside it.
    Pvtu,
}

impl MeshFormat {
    /// All formats, the deck first.
    pub const ALL: [Self; 4] = [Self::Inp, Self::Vtu, Self::Msh, Self::Pvtu];

    /// The extension without its dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Inp => "inp",
            Self::Vtu => "vtu",
            Self::Msh => "msh",
            Self::Pvtu => "pvtu",
        }
    }

    /// The format that the extension of `path` names, in either case.
    pub fn from_path(path: &Path) -> Option<Self> {
        let extension = lower_extension(path)?;
        Self::ALL.into_iter().find(|format| format.extension() == extension)
    }

    /// The files that `mesh` is written as where `path` is asked for: it alone, or what goes beside it and then it. A deck
    /// with a curve has the script that writes this down.
    pub fn files(self, path: &Path, mesh: &Mesh, deck: &DeckOptions) -> Vec<MeshFile> {
        let whole = |content| MeshFile { path: path.to_owned(), content };
        if self != Self::Pvtu {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let script = || MeshFile { path: abaqus::curve_path(path), content: Content::Script(name) };
            let script = (self == Self::Inp && deck.has_curve()).then(script);
            return script.into_iter().chain([whole(Content::Whole(self))]).collect();
        }
        let piece = |index| MeshFile { path: piece_path(path, index), content: Content::Piece(index) };
        let mut files: Vec<MeshFile> = (0..pvtu::pieces(mesh)).map(piece).collect();
        let name = |file: &MeshFile| file.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        files.push(whole(Content::Index(files.iter().map(name).collect())));
        files
    }
}

/// Where piece `index` of the `.pvtu` at `path` is: `name_0.vtu` beside `name.pvtu`.
#[doc(hidden)]
pub fn piece_path(path: &Path, index: usize) -> PathBuf {
    path.with_file_name(format!("{}_{index}.vtu", path.file_stem().unwrap_or_default().to_string_lossy()))
}

/// One of the files that a mesh is written as.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshFile {
    /// Where.
    pub path: PathBuf,
    content: Content,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Content {
    Whole(MeshFormat),
    Piece(usize),
    Index(Vec<String>),
    /// Of the deck with this name.
    Script(String),
}

impl MeshFile {
    /// Writes this file of `mesh` to `out`; `deck` counts for decks, `encoding` for `.vtu`.
    ///
    /// # Errors
    /// Those of `out`; what a deck cannot hold.
    pub fn write(&self, mesh: &Mesh, deck: &DeckOptions, encoding: Encoding, out: impl Write) -> io::Result<()> {
        match &self.content {
            Content::Whole(MeshFormat::Inp) => abaqus::write(mesh, deck, out),
            Content::Whole(MeshFormat::Msh) => msh::write(mesh, out),
            Content::Whole(_) => vtu_mesh::write(mesh, encoding, out),
            Content::Piece(index) => vtu_mesh::write(&pvtu::piece(mesh, *index), encoding, out),
            Content::Index(names) => pvtu::write(mesh, names, out),
            Content::Script(name) => abaqus::write_curve(mesh, deck, name, out),
        }
    }
}

fn lower_extension(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}
