//! What a mesh cannot be made of.

use super::conforming::ROOM_MM;

/// Why there is no mesh: what, where, and the way out.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// An option is out of its range.
    #[error("mesh.{key} is {value}; {accepted}")]
    Option {
        /// The option's name.
        key: &'static str,
        /// What was given.
        value: String,
        /// What is accepted.
        accepted: String,
    },
    /// Cells came out flat or turned over: there the grains' gaps and corners are too fine for the elements.
    #[error(
        "the mesh would have {cells} cells without a positive volume, the first at {:.3}, {:.3}, {:.3} mm; choose another \
         element_size_mm or method",
        at[0], at[1], at[2]
    )]
    Flat {
        /// How many.
        cells: usize,
        /// A node of the first one, mm.
        at: [f64; 3],
    },
    /// A conforming mesh was asked for where gmsh cannot run.
    #[error("the method conforming needs gmsh, which the command and the Python package run; take lattice or voxel")]
    NeedsGmsh,
    /// gmsh is not there.
    #[error("{0}")]
    MissingGmsh(String),
    /// gmsh did not do what it was asked.
    #[error("{0}")]
    Gmsh(String),
    /// Two aggregates, or one and the specimen's surface, are too close for a conforming mesh.
    #[error(
        "aggregate {aggregate} and {} are {gap_mm:.1e} mm apart, too close for a conforming mesh; pack with min_gap_mm = {ROOM_MM} \
         and wall_gap_mm = {ROOM_MM} or more under [placement], or mesh by the method lattice",
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
    #[error(
        "gmsh put a node at {:.6}, {:.6}, {:.6} mm on a face of the periodic box, and none on the opposite one, with somewhat \
         smaller elements, too; choose another element_size_mm, pack with a larger min_gap_mm under [placement], or mesh by the method lattice",
        at[0], at[1], at[2]
    )]
    Unmatched {
        /// Where, mm.
        at: [f64; 3],
    },
    /// Faces of a periodic box cut an aggregate so that edges without length are left.
    #[error(
        "the faces of the periodic box graze an edge or corner of aggregate {aggregate} at {:.6}, {:.6}, {:.6} mm; pack with \
         wall_gap_mm = {ROOM_MM} or more under [placement], with another seed, or mesh by the method lattice",
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
    pub(crate) fn option(key: &'static str, value: impl ToString, accepted: impl Into<String>) -> Self {
        Self::Option { key, value: value.to_string(), accepted: accepted.into() }
    }
}
