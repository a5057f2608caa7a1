//! Meshes and decks, alike for `mesh`, `pack` and `solve`: the [`flags`], and [`gmsh`].

mod flags;
mod gmsh;

pub(super) use flags::{MeshFlags, Meshing};
