//! A mesh as data: points, cells, the phase and the owner of every cell; where owners meet, and the sides.
//!
//! Nothing here knows how meshes are made, nor any file format.

mod copies;
mod images;
mod interface;
mod joins;
mod mesh;
mod notes;
mod owners;
mod second_order;
mod sides;

pub(crate) use copies::{Copies, copies};
pub use images::{NodeImages, Spots, upper};
pub(crate) use interface::by_nodes;
pub use interface::{InterfaceFace, faces};
pub(crate) use joins::complete;
pub use joins::owners;
pub use mesh::{CellKind, Cells, Mesh};
pub(crate) use mesh::{DROPPED, NO_BODY, cell_volume, drop_lone_nodes, owned_volumes, volume};
pub use meso_concrete::{Phase, PhaseNames};
pub use notes::Notes;
pub(crate) use owners::{Owners, pairs};
pub(crate) use second_order::EDGES;
pub(crate) use sides::{FlatSides, bits as side_bits, repeating};
pub use sides::{SIDES, Sides};
