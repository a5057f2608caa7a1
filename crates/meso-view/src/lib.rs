//! Formats of viewers that packings, meshes and tests share: VTK grids, plots, plane sections, and parts of a page.
//!
//! Writers take `impl io::Write`. The crate stands below `meso-write` and `meso-solve`, which compile beside each other.

// No environment, clock, file, print or mathematics of the platform: the list is in `crates/clippy.toml`.
#![cfg_attr(not(test), deny(clippy::disallowed_methods, clippy::disallowed_types, clippy::disallowed_macros))]

pub mod embedded;
pub mod plot;
pub mod section;
pub mod vtk;
