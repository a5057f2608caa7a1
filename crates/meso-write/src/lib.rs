//! Packings and meshes as files: one file a format, the HTML page, voxel images.
//!
//! Writers take `impl io::Write`; [`formats`] maps extensions to them.

// No environment, clock, file, print or mathematics of the platform: the list is in `crates/clippy.toml`.
#![cfg_attr(not(test), deny(clippy::disallowed_methods, clippy::disallowed_types, clippy::disallowed_macros))]

pub mod export;
pub mod formats;
pub mod methods;
pub mod page;
pub mod voxel_image;
