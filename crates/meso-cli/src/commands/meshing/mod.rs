//! Meshes and decks, alike for `mesh`, `pack` and `solve`: the [`flags`], the [`settings`] that they mean, and the [`run`].

mod errors;
mod flags;
mod run;
mod settings;

pub(super) use flags::MeshFlags;
pub(super) use settings::{MeshSettings, Meshing, Settings, materials};
