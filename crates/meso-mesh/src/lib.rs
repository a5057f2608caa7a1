//! Meshes of a packing: points, cells, and the phase of every cell.
//!
//! [`build()`] is the one entry; the methods are siblings. A mesh knows nothing of file formats.
//!
//! The stages of a run:
//!
//! 1. `images_near`: the bodies and, in a periodic box, their images, sorted. Their order gives the *body index*.
//! 2. A method makes cells: `voxel`, `lattice` (plain or fitted) or `conforming`. Each cell has an *owner*, a body index.
//! 3. `layer` splits the solid ITZ off the inside of every body, in tetrahedra.
//! 4. Mortar outside the container and voids are left out, and closed gaps are counted.
//! 5. `analysis` changes the mesh as an analysis needs it, cohesive elements last.
//! 6. `acceptance` refuses flat cells; then edges get middles.
//!
//! | owner | state | changed by |
//! |---|---|---|
//! | `tet::TetMesh` | positions, cells, owners of a tetrahedral mesh; removed cells keep their numbers until `drop_removed` | drivers only |
//! | `tet::Topology` | a `TetMesh` with the cells around its nodes | `replace_thicker`, `insert_thicker` |
//! | `lattice::sweeps` | the nodes that wait for each step, and all positions; patches of one colour write no position that another one reads | turns, colour by colour |
//! | `lattice::repair` | nodes that are off their body, their options, their periodic images | `relabel`, `contract`, `replace` |
//! | `conforming::Division` | slabs (the part of a specimen that one run of gmsh fills) and gmsh's input for each | never |
//!
//! Operators propose and change nothing: `Star` (the cells around a node) and `smoothed` a position, `edge_removal`,
//! `face_swap`, `contraction` and `insertion` other cells. A driver applies them. `improve` goes from the poor cells on, round
//! by round, within a budget; it measures cells by cos2, which is cos abs(cos) of the smallest dihedral angle. A `Constraint`
//! says where a node may go: tracks on faces and edges or periodic pairs in the lattice, vertex classes in a conforming
//! mesh, faces of a periodic box in the layer. A fourth mesher makes its cells and states its constraints.

// No environment, clock, file, print or mathematics of the platform: the list is in `crates/clippy.toml`.
#![cfg_attr(not(test), deny(clippy::disallowed_methods, clippy::disallowed_types, clippy::disallowed_macros))]

mod acceptance;
mod analysis;
mod body_images;
mod build;
pub mod cells;
mod clip;
pub mod conforming;
mod disjoint;
mod error;
pub mod figures;
mod lattice;
mod layer;
pub mod location;
pub mod materials;
mod options;
mod planes;
mod tet;
mod triangulation;
mod voxel;

pub use acceptance::PhaseOff;
pub use build::{Tools, accepts, build};
pub use cells::{CellKind, Mesh, Notes, Phase, PhaseNames};
pub use conforming::VolumeMesher;
pub use error::{MeshError, Ways};
pub use figures::{InterfaceDistance, PhaseVolumes};
pub use meso_concrete::Room;
pub use options::{
    Auto, ElementSize, Fit, ItzForm, Joined, MeshOptions, MeshTable, Method, MethodName, NarrowGaps, Order, Purpose,
    Volumes,
};
