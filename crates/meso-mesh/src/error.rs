//! Reasons why a mesh cannot be built.

use crate::triangulation::Untriangulated;
use meso_concrete::{OutOfRange, Ranges, thousands};
use std::borrow::Cow;
use std::fmt::Display;
use std::io;
use std::path::PathBuf;

/// Gaps that leave gmsh room, mm: seven packings of 30 mm and those of 60 and 150 mm at 0.50 were meshed with them.
const ADVISED_GAP_MM: f64 = 0.05;

/// Name of the element size in this library.
const SIZE: &str = "element_size_mm";

/// Reason why there is no mesh: the fault, its place, and a remedy.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// An option is out of its range.
    #[error(transparent)]
    Option(#[from] OutOfRange),
    /// Cells came out flat or turned over: there the aggregates' gaps and corners are too fine for the elements.
    #[error("{}", flat(*cells, *at, SIZE))]
    Flat {
        /// How many.
        cells: usize,
        /// A node of the first one, mm.
        at: [f64; 3],
    },
    /// A phase has far from its own volume.
    #[error("{}", phase_error(phase, [*meshed, *exact], *tried_mm, &ways.with(SIZE)))]
    PhaseError {
        /// The phase that is farthest off, in words.
        phase: Cow<'static, str>,
        /// Its volume in the mesh over the specimen's.
        meshed: f64,
        /// The exact volume of its bodies over the specimen's.
        exact: f64,
        /// Edge of the cube of the same packing that was meshed instead of the specimen, mm; `None` for the specimen.
        tried_mm: Option<f64>,
        /// Remedies.
        ways: Ways,
    },
    /// A conforming mesh was asked for where gmsh cannot run.
    #[error("the method conforming needs gmsh, which the command and the Python package run; take lattice or voxel")]
    NeedsGmsh,
    /// gmsh cannot be started.
    #[error(
        "{program} {why}; conforming meshes need gmsh: install it (Debian: apt install gmsh; PyPI: pip install gmsh)"
    )]
    MissingGmsh {
        /// The program to be run.
        program: String,
        /// Why it cannot be.
        why: String,
    },
    /// gmsh failed: it broke off, made no mesh, or wrote one that cannot be read.
    #[error("{0}")]
    Gmsh(String),
    /// The watch stopped the work.
    #[error("meshing was stopped")]
    Stopped,
    /// The files that gmsh reads and writes.
    #[error("the files for gmsh in {}: {}; TMPDIR names another folder for them", folder.display(), plain(error))]
    Files {
        /// Where they are.
        folder: PathBuf,
        /// The system's message.
        #[source]
        error: io::Error,
    },
    /// A facet, a face of the box or a plane between slabs cannot be triangulated.
    #[error("{what} at {:.6}, {:.6}, {:.6} mm", at[0], at[1], at[2])]
    Triangulation {
        /// The fault.
        what: &'static str,
        /// Where, mm.
        at: [f64; 3],
    },
    /// gmsh's meshes of two slabs have different triangles on the plane between them.
    #[error("{}", seam(*at, SIZE))]
    Seam {
        /// Where, mm.
        at: [f64; 3],
    },
    /// Two aggregates, or one and the specimen's surface, are too close for a conforming mesh.
    #[error(
        "aggregate {aggregate} and {} are {gap_mm:.1e} mm apart, too close for a conforming mesh; pack with min_gap_mm = {ADVISED_GAP_MM} \
         and wall_gap_mm = {ADVISED_GAP_MM} or more under [placement], or mesh by the method lattice",
        other.map_or("the specimen's surface".to_owned(), |id| format!("aggregate {id}"))
    )]
    NearTouching {
        /// The gap, mm.
        gap_mm: f64,
        /// An aggregate's id.
        aggregate: u32,
        /// The other's id; `None` for the specimen's surface.
        other: Option<u32>,
    },
    /// gmsh put a node on a face of a periodic box that the opposite face does not have.
    #[error("{}", unmatched(*at, SIZE))]
    Unmatched {
        /// Where, mm.
        at: [f64; 3],
    },
    /// Faces of a periodic box cut an aggregate so that edges without length are left.
    #[error(
        "the faces of the periodic box graze an edge or corner of aggregate {aggregate} at {:.6}, {:.6}, {:.6} mm; pack with \
         wall_gap_mm = {ADVISED_GAP_MM} or more under [placement], with another seed, or mesh by the method lattice",
        at[0], at[1], at[2]
    )]
    Grazed {
        /// The aggregate's id.
        aggregate: u32,
        /// Where, mm.
        at: [f64; 3],
    },
}

impl MeshError {
    /// Gaps that a conforming mesh needs, mm.
    pub const ADVISED_GAP_MM: f64 = ADVISED_GAP_MM;

    /// An option that is out of its range.
    pub fn option(key: &str, value: impl Display, accepted: impl Into<String>) -> Self {
        Self::Option(Ranges("mesh").error(key, value, accepted))
    }

    /// The message, in which the element size has the name that a front gives to `element_size_mm`.
    pub fn message(&self, name: impl Fn(&str) -> String) -> String {
        let size = name(SIZE);
        match self {
            Self::Flat { cells, at } => flat(*cells, *at, &size),
            Self::PhaseError { phase, meshed, exact, tried_mm, ways } => {
                phase_error(phase, [*meshed, *exact], *tried_mm, &ways.with(&size))
            }
            Self::Seam { at } => seam(*at, &size),
            Self::Unmatched { at } => unmatched(*at, &size),
            _ => self.to_string(),
        }
    }

    /// Whether gmsh may do better when it is asked for other elements: its own failures, never a stop or a full disk.
    pub(super) fn is_worth_another_try(&self) -> bool {
        matches!(self, Self::Unmatched { .. } | Self::Flat { .. } | Self::Seam { .. } | Self::Gmsh(_))
    }
}

/// Remedies for a phase that is far off its volume.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ways {
    /// The remedy before the name of the element size: `a smaller `.
    pub(crate) before: &'static str,
    /// Words after the name of the element size.
    pub(crate) after: String,
    /// Remedies besides the element size.
    pub(crate) others: String,
}

impl Ways {
    /// The remedies with an element size that was tried, mm, and the `finding`.
    pub fn with_tried(self, size_mm: f64, finding: &str) -> Self {
        Self { before: "", after: format!(" {size_mm} ({finding})"), ..self }
    }

    fn with(&self, size: &str) -> String {
        format!("{}{size}{}{}", self.before, self.after, self.others)
    }
}

fn flat(cells: usize, [x, y, z]: [f64; 3], size: &str) -> String {
    let cells = thousands(cells);
    format!(
        "the mesh would have {cells} cells without a positive volume, the first at {x:.3}, {y:.3}, {z:.3} mm; choose another \
         {size} or method"
    )
}

fn phase_error(phase: &str, [meshed, exact]: [f64; 2], tried_mm: Option<f64>, ways: &str) -> String {
    let percent = 100.0 * (meshed / exact - 1.0);
    let specimen = tried_mm.map_or("the specimen".to_owned(), |edge| format!("a cube of {edge} mm, tried first,"));
    format!(
        "the {phase} takes {meshed:.4} of {specimen} in the mesh and {exact:.4} in the packing: {percent:+.0} %, where 10 % are \
         accepted; take {ways}"
    )
}

fn seam([x, y, z]: [f64; 3], size: &str) -> String {
    format!("gmsh's meshes of two slabs do not meet at {x:.6}, {y:.6}, {z:.6} mm; choose another {size} or fewer slabs")
}

fn unmatched([x, y, z]: [f64; 3], size: &str) -> String {
    format!(
        "gmsh put a node at {x:.6}, {y:.6}, {z:.6} mm on a face of the periodic box without one on the opposite face, also with \
         slightly smaller elements; choose another {size}, pack with a larger min_gap_mm under [placement], or mesh by the method \
         lattice"
    )
}

impl From<Untriangulated> for MeshError {
    fn from(Untriangulated { what, at }: Untriangulated) -> Self {
        Self::Triangulation { what, at }
    }
}

/// The system's message without Rust's "(os error 28)".
fn plain(error: &io::Error) -> String {
    let text = error.to_string();
    text.split(" (os error").next().unwrap_or(&text).to_owned()
}
