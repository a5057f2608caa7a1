//! Meshes and decks, alike for `mesh`, `pack` and `solve`: the [`flags`], and the [`run`].

mod flags;
mod run;

pub(super) use flags::{MeshFlags, Meshing};
pub(super) use run::build;
