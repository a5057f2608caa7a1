//! Formats of packings, meshes and images; the file's extension names the format.

use crate::export::abaqus::{self, DeckOptions};
use crate::export::raster::{Voxels, npy, png, tif, vti};
use crate::export::step::Block;
use crate::export::{ansys, csv, glb, lsdyna, msh, obj, ply, pvtu, script, step, stl, vtu, vtu_mesh, xdmf};
use crate::page;
use crate::voxel_image::{ImageOptions, Quantity, Region, VoxelImage};
use meso_concrete::images::Images;
use meso_concrete::specimen::{Periodic, Specimen, Surface};
use meso_concrete::watch::Watch;
use meso_concrete::{OutOfRange, Ranges};
use meso_mesh::cells::Mesh;
use meso_pack::model::Model;
use meso_pack::saved;
use meso_view::vtk::Encoding;
use std::borrow::Cow;
use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};

/// How the aggregates' surfaces are written.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceOptions {
    /// Treatment of aggregates that cross a face of a periodic specimen.
    pub images: Images,
    /// Whether the data of a `.vtu` and a `.vtp` are compressed (zlib).
    pub compress: bool,
    /// An `.stl` as text, each body a solid with its name.
    pub named_solids: bool,
    /// A `.step` with the mortar as a solid with cavities.
    pub mortar: bool,
}

impl SurfaceOptions {
    /// Refuses an option that counts in none of the files: packings in `formats`, and `meshes`.
    ///
    /// # Errors
    /// The option.
    pub fn accept(&self, formats: &[Format], meshes: &[MeshFormat]) -> Result<(), OutOfRange> {
        let has = |wanted: &[Format]| formats.iter().any(|format| wanted.contains(format));
        let packed = meshes.iter().any(|mesh| matches!(mesh, MeshFormat::Vtu | MeshFormat::Pvtu));
        let range = Ranges("write");
        let met = !self.compress || packed || has(&[Format::Vtu, Format::Vtp]);
        range.require("compress", true, met, "only a .vtu, a .vtp and a .pvtu take it")?;
        let met = self.images == Images::None || has(&Format::SURFACES);
        range.require(
            "images",
            self.images.name(),
            met,
            "only files of surfaces take it, such as .vtu, .stl and .step",
        )?;
        range.require("mortar", true, !self.mortar || has(&[Format::Step]), "only a .step takes it")?;
        range.require("named_solids", true, !self.named_solids || has(&[Format::Stl]), "only an .stl takes it")
    }

    /// Refuses images of a specimen without periodic faces.
    ///
    /// # Errors
    /// The option.
    pub fn suits(&self, specimen: &Specimen) -> Result<(), OutOfRange> {
        let met = self.images == Images::None || specimen.periodic() != Periodic::NONE;
        Ranges("write").require("images", self.images.name(), met, "the specimen has no periodic faces; leave it out")
    }
}

/// A format that holds the aggregates themselves; meshes have their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// The saved model.
    Json,
    /// The saved model, compressed.
    JsonGz,
    /// Surfaces as polygons.
    Vtu,
    /// Surfaces as VTK poly data.
    Vtp,
    /// Surfaces as triangles.
    Stl,
    /// Solids with plane faces.
    Step,
    /// A scene.
    Glb,
    /// Triangles with ids and colours.
    Ply,
    /// Polygons in named groups.
    Obj,
    /// One row per body.
    Csv,
}

impl Format {
    /// All formats, the saved model first.
    pub const ALL: [Self; 10] = [
        Self::Json,
        Self::JsonGz,
        Self::Vtu,
        Self::Vtp,
        Self::Stl,
        Self::Step,
        Self::Glb,
        Self::Ply,
        Self::Obj,
        Self::Csv,
    ];

    /// Those of surfaces.
    const SURFACES: [Self; 7] = [Self::Vtu, Self::Vtp, Self::Stl, Self::Step, Self::Glb, Self::Ply, Self::Obj];

    /// The extension without its dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Json => "json",
            Self::JsonGz => "json.gz",
            Self::Vtu => "vtu",
            Self::Vtp => "vtp",
            Self::Stl => "stl",
            Self::Step => "step",
            Self::Glb => "glb",
            Self::Ply => "ply",
            Self::Obj => "obj",
            Self::Csv => "csv",
        }
    }

    /// The format's content, in a few words.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Json => "the saved model, bit for bit; every other command reads it",
            Self::JsonGz => "the saved model, compressed to less than half; every other command reads it",
            Self::Vtu => "aggregate surfaces as polygons with ids, classes, ITZ: ParaView, PyVista, meshio",
            Self::Vtp => "the same as poly data: ParaView, PyVista",
            Self::Stl => "aggregate surfaces as triangles: CAD, 3D printers",
            Self::Step => "one editable solid per aggregate, named and coloured: Abaqus/CAE, CAD, gmsh",
            Self::Glb => "one named object per aggregate, coloured by class: slides, browsers, Blender",
            Self::Ply => "triangles with ids, classes and colours: trimesh, MeshLab",
            Self::Obj => "polygons, one object per aggregate, with colours: Blender, trimesh",
            Self::Csv => "one row per aggregate, void and fibre: size, volume, area, centroid, ITZ",
        }
    }

    /// The format that the extension of `path` names, in either case; `.stp` is `.step`.
    pub fn from_path(path: &Path) -> Option<Self> {
        let extension = lower_extension(path)?;
        let stem = Path::new(path.file_stem()?);
        match extension.as_str() {
            "gz" => (lower_extension(stem)? == "json").then_some(Self::JsonGz),
            "stp" => Some(Self::Step),
            _ => Self::ALL.into_iter().find(|format| format.extension() == extension),
        }
    }

    /// Writes `model` to `out` in this format; `surfaces` counts where the format holds surfaces.
    ///
    /// # Errors
    /// Errors of `out`; values that the format cannot hold.
    pub fn write(self, model: &Model, surfaces: SurfaceOptions, mut out: impl Write) -> io::Result<()> {
        self.write_to(model, surfaces, &mut out)
    }

    /// Writes `model`; the writers are compiled once, here.
    fn write_to(self, model: &Model, surfaces: SurfaceOptions, out: &mut dyn Write) -> io::Result<()> {
        let shown = || match surfaces.images {
            Images::None => model.bodies(),
            images => Cow::Owned(images.of(&model.bodies(), &model.spec.specimen)),
        };
        let phases = &model.spec.phases();
        match self {
            Self::Json => saved::write(model, out),
            Self::JsonGz => saved::write_compressed(model, out),
            Self::Vtu => vtu::write(&shown(), Encoding::compressed(surfaces.compress), out),
            Self::Vtp => vtu::write_polygons(&shown(), Encoding::compressed(surfaces.compress), out),
            Self::Stl if surfaces.named_solids => stl::write_solids(&shown(), phases, out),
            Self::Stl => stl::write(&shown(), out),
            Self::Step => {
                let mortar = surfaces.mortar.then(|| block(&model.spec.specimen)).transpose()?;
                step::write(&shown(), phases, mortar.as_ref(), out)
            }
            Self::Glb => glb::write(&shown(), phases, out),
            Self::Ply => ply::write(&shown(), out),
            Self::Obj => obj::write(&shown(), phases, out),
            Self::Csv => csv::write(model.aggregates.iter().chain(&model.inclusions), phases, out),
        }
    }
}

/// Surface that bounds the mortar.
fn block(specimen: &Specimen) -> io::Result<Block> {
    if !specimen.period().is_none() {
        let message = "a periodic specimen has no mortar that is one solid: aggregates cross its faces; write the \
                       aggregates alone, or pack a specimen with walls";
        return Err(io::Error::other(message));
    }
    Ok(match specimen {
        Specimen::Cylinder { diameter_mm, height_mm } => {
            Block::Cylinder { radius: diameter_mm / 2.0, height: *height_mm }
        }
        Specimen::Sphere { diameter_mm } => Block::Sphere { radius: diameter_mm / 2.0 },
        flat => {
            let Surface { points, faces } = flat.container().surface();
            Block::Polygons { points, faces }
        }
    })
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
    /// A VTK grid in pieces: an index, and `.vtu` files beside it.
    Pvtu,
    /// LS-DYNA and OpenRadioss.
    K,
    /// ANSYS.
    Cdb,
    /// One XML file: ParaView, meshio.
    Xdmf,
}

impl MeshFormat {
    /// All formats, the deck first.
    pub const ALL: [Self; 7] = [Self::Inp, Self::Vtu, Self::Msh, Self::Pvtu, Self::K, Self::Cdb, Self::Xdmf];

    /// The extension without its dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Inp => "inp",
            Self::Vtu => "vtu",
            Self::Msh => "msh",
            Self::Pvtu => "pvtu",
            Self::K => "k",
            Self::Cdb => "cdb",
            Self::Xdmf => "xdmf",
        }
    }

    /// The format that the extension of `path` names, in either case.
    pub fn from_path(path: &Path) -> Option<Self> {
        let extension = lower_extension(path)?;
        Self::ALL.into_iter().find(|format| format.extension() == extension)
    }

    /// Whether the format takes the options of a deck.
    pub fn is_deck(self) -> bool {
        matches!(self, Self::Inp | Self::K)
    }

    /// Whether a deck with these options has a script beside it, which writes the curve of its test.
    pub fn has_script(self, deck: &DeckOptions) -> bool {
        self.is_deck() && deck.has_script()
    }

    /// Finds out whether the format takes these options of a deck; formats without options ignore them.
    ///
    /// # Errors
    /// Names the option, its value and the accepted range.
    pub fn check(self, deck: &DeckOptions) -> Result<(), OutOfRange> {
        match self {
            Self::Inp => abaqus::check(deck),
            Self::K => lsdyna::check(deck),
            _ => Ok(()),
        }
    }

    /// The files that `mesh` is written to for `path`: first the files beside it, then `path`. A deck with a curve has
    /// a script that extracts the curve from the solver's results.
    pub fn files(self, path: &Path, mesh: &Mesh, deck: &DeckOptions) -> Vec<MeshFile> {
        let whole = |content| MeshFile { path: path.to_owned(), content };
        if self != Self::Pvtu {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let script =
                || MeshFile { path: abaqus::DeckOptions::curve_path(path), content: Content::Script(self, name) };
            let script = self.has_script(deck).then(script);
            return script.into_iter().chain([whole(Content::Whole(self))]).collect();
        }
        let piece = |index| MeshFile { path: Self::piece_path(path, index), content: Content::Piece(index) };
        let mut files: Vec<MeshFile> = (0..pvtu::pieces(mesh)).map(piece).collect();
        let name = |file: &MeshFile| file.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        files.push(whole(Content::Index(files.iter().map(name).collect())));
        files
    }

    /// Files beside `path` that an earlier mesh there has left, and that a mesh with these `files` has not; `beginning` reads how
    /// a file begins.
    pub fn leftovers(self, path: &Path, files: &[MeshFile], beginning: &Beginning<'_>) -> Vec<PathBuf> {
        let is_left = |path: &PathBuf| files.iter().all(|file| file.path != *path);
        if self == Self::Pvtu {
            let before = beginning(path).unwrap_or_default();
            let index = String::from_utf8_lossy(&before);
            let is_listed = |piece: &PathBuf| {
                index.contains(&pvtu::entry(&piece.file_name().unwrap_or_default().to_string_lossy()))
            };
            let pieces = (0..).map(|index| Self::piece_path(path, index)).take_while(is_listed);
            return pieces.filter(is_left).filter(|piece| beginning(piece).is_some()).collect();
        }
        let script = abaqus::DeckOptions::curve_path(path);
        let is_ours = self.is_deck() && is_left(&script) && is_script(path, &script, beginning) == Some(true);
        is_ours.then_some(script).into_iter().collect()
    }

    /// Why the script of a deck at `path` cannot be written, where another program's file has its name; `beginning` reads how a
    /// file begins.
    pub fn foreign_script(self, path: &Path, beginning: &Beginning<'_>) -> Option<String> {
        let script = abaqus::DeckOptions::curve_path(path);
        let message = "is no script of mesocrete, so nothing replaces it; move it, or name the deck otherwise";
        let is_foreign = self.is_deck() && is_script(path, &script, beginning) == Some(false);
        is_foreign.then(|| format!("{} {message}", script.display()))
    }

    /// Where piece `index` of the `.pvtu` at `path` is: `name_0.vtu` beside `name.pvtu`.
    pub fn piece_path(path: &Path, index: usize) -> PathBuf {
        path.with_file_name(format!("{}_{index}.vtu", path.file_stem().unwrap_or_default().to_string_lossy()))
    }
}

/// One of the files that a mesh is written as.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshFile {
    /// Path of the file.
    pub path: PathBuf,
    content: Content,
}

/// Reads how a file begins; `None` where there is none.
pub type Beginning<'a> = dyn Fn(&Path) -> Option<Vec<u8>> + 'a;

/// Whether `script` is that of a deck at `path`, and not another program's; `None` where it is not there.
fn is_script(path: &Path, script: &Path, beginning: &Beginning<'_>) -> Option<bool> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    Some(beginning(script)?.starts_with(script::opening(&name).as_bytes()))
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Content {
    Whole(MeshFormat),
    Piece(usize),
    Index(Vec<String>),
    /// The script of the deck with this format and name.
    Script(MeshFormat, String),
}

impl MeshFile {
    /// Writes this file of `mesh` to `out`; `deck` counts for decks, `compress` for `.vtu`.
    ///
    /// # Errors
    /// Errors of `out`; values that a deck cannot hold.
    pub fn write(&self, mesh: &Mesh, deck: &DeckOptions, compress: bool, mut out: impl Write) -> io::Result<()> {
        self.write_to(mesh, deck, compress, &mut out)
    }

    /// Writes this file of `mesh`; the writers are compiled once, here.
    fn write_to(&self, mesh: &Mesh, deck: &DeckOptions, compress: bool, out: &mut dyn Write) -> io::Result<()> {
        match &self.content {
            Content::Whole(MeshFormat::Inp) => abaqus::write(mesh, deck, out),
            Content::Whole(MeshFormat::Msh) => msh::write(mesh, out),
            Content::Whole(MeshFormat::K) => lsdyna::write(mesh, deck, out),
            Content::Whole(MeshFormat::Cdb) => ansys::write(mesh, out),
            Content::Whole(MeshFormat::Xdmf) => xdmf::write(mesh, out),
            Content::Whole(_) => vtu_mesh::write(mesh, compress, out),
            Content::Piece(index) => vtu_mesh::write(&pvtu::piece(mesh, *index), compress, out),
            Content::Index(names) => pvtu::write(mesh, names, out),
            Content::Script(format, name) => script::write(*format == MeshFormat::K, mesh, deck, name, out),
        }
    }
}

/// A format that holds a voxel image or a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFormat {
    /// An array of numpy.
    Npy,
    /// Pages of a TIFF.
    Tif,
    /// VTK image data.
    Vti,
    /// A picture of a section.
    Png,
    /// A section as exact polygons.
    Svg,
}

impl ImageFormat {
    /// All formats, the array first.
    pub const ALL: [Self; 5] = [Self::Npy, Self::Tif, Self::Vti, Self::Png, Self::Svg];

    /// The extension without its dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Npy => "npy",
            Self::Tif => "tif",
            Self::Vti => "vti",
            Self::Png => "png",
            Self::Svg => "svg",
        }
    }

    /// The format that the extension of `path` names, in either case; `.tiff` is `.tif`.
    pub fn from_path(path: &Path) -> Option<Self> {
        let extension = lower_extension(path)?;
        let extension = if extension == "tiff" { "tif" } else { &extension };
        Self::ALL.into_iter().find(|format| format.extension() == extension)
    }

    /// Refuses values that the format cannot hold.
    ///
    /// # Errors
    /// The way out.
    pub fn check(self, options: &ImageOptions) -> Result<(), &'static str> {
        let is_section = matches!(options.region, Region::Section { .. });
        match (self, options.quantity) {
            (Self::Png | Self::Svg, _) if !is_section => {
                Err("it holds one section; name one, as in z=75, or use .npy, .tif or .vti")
            }
            (Self::Png, Quantity::Grain | Quantity::Distance) => {
                Err("it holds phases or shares; use .npy, .tif or .vti")
            }
            (Self::Svg, Quantity::Grain | Quantity::Distance | Quantity::Share) => {
                Err("it holds phases; use .npy, .tif, .vti or .png")
            }
            _ => Ok(()),
        }
    }

    /// Writes an image as [`ImageFormat::write`] does, in any format; a `.tif` seeks in `out`.
    ///
    /// # Errors
    /// Fails with the errors of `out`.
    pub fn write_file(
        self,
        image: &VoxelImage,
        model: &Model,
        region: Region,
        watch: &dyn Watch,
        out: impl Write + Seek,
    ) -> io::Result<()> {
        match self {
            Self::Tif => tif::write(&image.frame(), image.slabs_watched(watch), out),
            _ => self.write(image, model, region, watch, out),
        }
    }

    /// Writes an image of `model` to `out` as it is made, and reports the share that is; not `.tif`, which seeks.
    ///
    /// # Errors
    /// Fails with the errors of `out`.
    pub fn write(
        self,
        image: &VoxelImage,
        model: &Model,
        region: Region,
        watch: &dyn Watch,
        mut out: impl Write,
    ) -> io::Result<()> {
        self.write_to(image, model, region, watch, &mut out)
    }

    /// Writes an image; the writers are compiled once, here.
    fn write_to(
        self,
        image: &VoxelImage,
        model: &Model,
        region: Region,
        watch: &dyn Watch,
        mut out: &mut dyn Write,
    ) -> io::Result<()> {
        let frame = image.frame();
        match (self, region) {
            (Self::Npy, _) => npy::write(&frame, image.slabs_watched(watch), out),
            (Self::Vti, _) => vti::write(&frame, image.slabs_watched(watch), out),
            (Self::Svg, Region::Section { axis, at }) => page::section(model, axis, at, &mut out),
            (Self::Png, Region::Section { .. }) => {
                let values: Voxels = image.layers(0..frame.counts[2]);
                png::write(&frame, &values, out)
            }
            _ => Err(io::Error::other("a .png or .svg holds a section, and a .tif needs a file to seek in")),
        }
    }
}

fn lower_extension(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}
