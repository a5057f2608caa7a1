//! Formats of outputs, which their names ask for.

use crate::failure::Failure;
use crate::outputs::Target;
use clap::builder::{PathBufValueParser, TypedValueParser};
use meso_core::formats::{Format, ImageFormat, MeshFormat};
use std::path::{Path, PathBuf};

/// Formats of which the name of an output asks for one.
pub(crate) trait Formats: Copy + Send + Sync + 'static {
    /// What standard output takes.
    const STREAM: Self;
    /// A word for them, in messages.
    const KIND: &'static str;

    /// The format that an extension asks for.
    fn of(path: &Path) -> Option<Self>;
    /// All extensions.
    fn known() -> Vec<&'static str>;
}

/// An output as the user typed it.
#[derive(Clone, Debug)]
pub(crate) struct Named<F> {
    pub(crate) path: PathBuf,
    pub(crate) format: F,
}

impl<F: Formats> Named<F> {
    /// Parser of an output, which refuses an unknown extension.
    pub(crate) fn parser() -> impl TypedValueParser<Value = Self> {
        PathBufValueParser::new().try_map(Self::of)
    }

    /// The output of a name.
    pub(crate) fn of(path: PathBuf) -> Result<Self, String> {
        let format = if path == Path::new("-") { Some(F::STREAM) } else { F::of(&path) };
        let known = || F::known().join(", .");
        let is_mesh = MeshFormat::from_path(&path).is_some();
        let hint = if is_mesh { " (a mesh for finite elements: mesocrete mesh)" } else { "" };
        let unknown = || format!("unknown {}; the extension must be one of .{}{hint}", F::KIND, known());
        format.ok_or_else(unknown).map(|format| Self { path, format })
    }

    /// Destinations of `all`, inspected before any work is done.
    pub(crate) fn targets(all: &[Self], force: bool) -> Result<Vec<(Target, F)>, Failure> {
        all.iter().map(|output| Ok((Target::new(&output.path, force)?, output.format))).collect()
    }
}

macro_rules! formats {
    ($type:ident, $stream:ident, $kind:literal) => {
        impl Formats for $type {
            const STREAM: Self = Self::$stream;
            const KIND: &'static str = $kind;

            fn of(path: &Path) -> Option<Self> {
                Self::from_path(path)
            }

            fn known() -> Vec<&'static str> {
                Self::ALL.map(Self::extension).to_vec()
            }
        }
    };
}

formats!(Format, Json, "format");
formats!(MeshFormat, Inp, "mesh format");
formats!(ImageFormat, Npy, "image format");

/// Content of an output of `mesocrete pack`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Content {
    Packing(Format),
    Mesh(MeshFormat),
    /// Pictures and figures.
    Page,
}

impl Formats for Content {
    const STREAM: Self = Self::Packing(Format::Json);
    const KIND: &'static str = "format";

    fn of(path: &Path) -> Option<Self> {
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("html")) {
            return Some(Self::Page);
        }
        let packing = Format::from_path(path).map(Self::Packing);
        packing.or_else(|| MeshFormat::from_path(path).map(Self::Mesh))
    }

    fn known() -> Vec<&'static str> {
        let meshes = MeshFormat::ALL.map(MeshFormat::extension).into_iter().filter(|name| *name != "vtu");
        Format::ALL.map(Format::extension).into_iter().chain(meshes).chain(["html"]).collect()
    }
}
