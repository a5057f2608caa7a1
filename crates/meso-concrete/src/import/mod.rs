//! Surfaces from files that other programs wrote, STL, PLY, OBJ and OFF; stones as harmonics; label volumes; sieve tables of
//! laboratories; and tables of numbers.
//!
//! Formats of surfaces have no units: a number is a millimetre. Each reader turns bytes into triangles; `mend` then joins
//! corners that should be equal and removes triangles without area. Names and colours are ignored.

mod columns;
mod content;
pub mod grains;
pub mod harmonics;
mod memory;
mod mend;
mod obj;
mod off;
mod ply;
pub mod polygon;
pub mod sieve_table;
mod stl;
pub mod volume;
mod words;

pub use columns::Columns;
pub use content::misnamed;
pub use memory::bytes_of_surface;
pub use mend::without_flat_triangles;

use meso_collision::geometry::{SurfaceError, TriangleMesh};
use meso_collision::math::Vec3;
use polygon::Polygons;

/// Why bytes are no surface.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ImportError {
    /// The name ends like no format that is read.
    #[error("its name must end in {}", list(&ENDINGS))]
    Ending,
    /// The file has another format than its name says.
    #[error("{0}")]
    Misnamed(String),
    /// Text in two bytes a character.
    #[error("it is text in UTF-16; save it as ASCII or UTF-8")]
    Utf16,
    /// The file does not begin as its format does.
    #[error("this is not {format} file: {wanted}")]
    Begin {
        /// With its article.
        format: &'static str,
        /// How such a file begins.
        wanted: String,
    },
    /// A word or line that cannot be read.
    #[error("line {line}: `{found}` is not {wanted}")]
    Line {
        /// From 1.
        line: usize,
        /// The text found there.
        found: String,
        /// The text expected there.
        wanted: &'static str,
    },
    /// No facets.
    #[error("it has no triangles")]
    Empty,
    /// Facets without three corners each.
    #[error("it has {corners} vertices, which is not a multiple of 3")]
    Incomplete {
        /// Number of vertices.
        corners: usize,
    },
    /// The file is shorter than its header says.
    #[error("it ends within its {part}; it was cut off, or its header is wrong")]
    Cut {
        /// Name of the section that is too short.
        part: &'static str,
    },
    /// A face that names a vertex that is not there.
    #[error("face {face}, counted from 0, names vertex {vertex} of {vertices}")]
    Corner {
        /// From 0.
        face: usize,
        /// As in the file.
        vertex: i64,
        /// How many there are.
        vertices: usize,
    },
    /// A coordinate that is NaN or infinite.
    #[error("triangle {triangle} has a coordinate that is not finite")]
    NotFinite {
        /// From 0.
        triangle: usize,
    },
}

/// Endings of the names of files that are read, in lower case.
pub const ENDINGS: [&str; 4] = ["stl", "ply", "obj", "off"];

/// Endings as a sentence lists them: `.stl, .ply or .off`.
pub fn list(endings: &[&str]) -> String {
    let dotted: Vec<String> = endings.iter().map(|ending| format!(".{ending}")).collect();
    let (last, others) = dotted.split_last().expect("there are some");
    format!("{} or {last}", others.join(", "))
}

/// The ending of a file's name, in lower case.
pub fn ending(name: &str) -> Option<String> {
    name.rsplit_once('.').map(|(_, ending)| ending.to_lowercase())
}

/// Triangles as a reader finds them.
#[derive(Default)]
struct Facets {
    /// Three a triangle, mm.
    corners: Vec<Vec3>,
    /// First triangle of each part that the file separates.
    starts: Vec<usize>,
    /// Remarks about a file that was read although it has a fault.
    notes: Vec<String>,
    polygons: Polygons,
}

impl Facets {
    /// Begins a part of the file.
    fn begin(&mut self) {
        self.starts.push(self.corners.len() / 3);
    }

    /// Adds a polygon as triangles. Face number `face` names `vertices` from 0.
    fn polygon(&mut self, vertices: &[Vec3], face: usize, corners: &[i64]) -> Result<(), ImportError> {
        let of = |&vertex: &i64| {
            let found = usize::try_from(vertex).ok().and_then(|index| vertices.get(index)).copied();
            found.ok_or(ImportError::Corner { face, vertex, vertices: vertices.len() })
        };
        let points = corners.iter().map(of).collect::<Result<Vec<Vec3>, _>>()?;
        let triangles = self.polygons.triangles(&points);
        self.corners.extend(triangles.into_iter().flatten().map(|corner| points[corner]));
        Ok(())
    }

    /// The corners of each part.
    fn parts(&self) -> impl Iterator<Item = &[Vec3]> {
        let starts = std::iter::once(0).chain(self.starts.iter().copied());
        let ends = self.starts.iter().copied().chain(std::iter::once(self.corners.len() / 3));
        starts.zip(ends).map(|(from, to)| &self.corners[3 * from..3 * to]).filter(|part| !part.is_empty())
    }
}

/// A surface, and remarks about its file.
#[derive(Clone, Debug)]
pub struct Imported {
    /// In the frame of the file.
    pub mesh: TriangleMesh,
    /// Whether every edge lies between two triangles.
    pub edges: Result<(), SurfaceError>,
    /// Remarks for the user: faults that were mended.
    pub notes: Vec<String>,
}

/// Reads the surface in `bytes`; the ending of `name` decides the format.
///
/// # Errors
/// See [`ImportError`]. Open surfaces are no error here: see [`Imported::edges`].
pub fn read(name: &str, bytes: &[u8]) -> Result<Imported, ImportError> {
    let mut facets = facets(name, bytes)?;
    let mut surface = mend::mended(TriangleMesh::welded(&facets.corners));
    facets.notes.append(&mut surface.notes);
    Ok(Imported { notes: facets.notes, ..surface })
}

/// Reads the bodies in `bytes`: the components of each part, or of the whole where a part is not closed, and remarks.
///
/// # Errors
/// See [`ImportError`].
pub fn read_bodies(name: &str, bytes: &[u8]) -> Result<(Vec<TriangleMesh>, Vec<String>), ImportError> {
    let facets = facets(name, bytes)?;
    let mut parts: Vec<Bodies> = facets.parts().map(Bodies::new).collect();
    if parts.len() > 1 && parts.iter().any(|part| !part.are_closed) {
        parts = vec![Bodies::new(&facets.corners)];
    }
    let mut notes = facets.notes;
    let (count, mut first) = (parts.iter().map(|part| part.bodies.len()).sum(), 0);
    for part in &mut parts {
        let within = numbers(first, part.bodies.len(), count);
        notes.extend(part.notes.drain(..).map(|note| format!("{within}{note}")));
        first += part.bodies.len();
    }
    let bodies: Vec<TriangleMesh> = parts.into_iter().flat_map(|part| part.bodies).collect();
    if bodies.is_empty() { Err(ImportError::Empty) } else { Ok((bodies, notes)) }
}

/// Words for some of the `count` bodies in a file, from number `first`; none for all of them.
pub fn numbers(first: usize, some: usize, count: usize) -> String {
    match some {
        _ if some == count => String::new(),
        0 | 1 => format!("body {first} of {count}, counted from 0: "),
        _ => format!("bodies {first} to {} of {count}, counted from 0: ", first + some - 1),
    }
}

/// Bodies of a part of a file.
struct Bodies {
    bodies: Vec<TriangleMesh>,
    /// Whether every edge of each lies between two triangles.
    are_closed: bool,
    notes: Vec<String>,
}

impl Bodies {
    fn new(corners: &[Vec3]) -> Self {
        let given = TriangleMesh::welded(corners);
        let bodies = bodies(&given);
        // Bodies that touch are sound, though more than two triangles meet in an edge of all.
        if bodies.iter().all(|body| body.check_edges().is_ok()) {
            return Self { bodies, are_closed: true, notes: Vec::new() };
        }
        let Imported { mesh, edges, notes } = mend::mended(given);
        Self { bodies: self::bodies(&mesh), are_closed: edges.is_ok(), notes }
    }
}

/// The components that have triangles, without vertices that no triangle has.
pub fn bodies(mesh: &TriangleMesh) -> Vec<TriangleMesh> {
    mesh.components().into_iter().filter(|body| !body.triangles.is_empty()).collect()
}

fn facets(name: &str, bytes: &[u8]) -> Result<Facets, ImportError> {
    let found = facets_as_named(name, bytes);
    found.map_err(|error| misnamed(name, bytes, &ENDINGS).map_or(error, ImportError::Misnamed))
}

fn facets_as_named(name: &str, bytes: &[u8]) -> Result<Facets, ImportError> {
    let mut facets = match ending(name).as_deref() {
        Some("stl") => stl::read(bytes),
        Some("ply") => ply::read(bytes),
        Some("obj") => obj::read(bytes),
        Some("off") => off::read(bytes),
        _ => Err(ImportError::Ending),
    }?;
    facets.notes.extend(facets.polygons.notes());
    let corners = &facets.corners;
    if corners.is_empty() {
        return Err(ImportError::Empty);
    }
    if corners.len() % 3 != 0 {
        return Err(ImportError::Incomplete { corners: corners.len() });
    }
    if let Some(corner) = corners.iter().position(|p: &Vec3| !p.iter().all(|x| x.is_finite())) {
        return Err(ImportError::NotFinite { triangle: corner / 3 });
    }
    Ok(facets)
}
