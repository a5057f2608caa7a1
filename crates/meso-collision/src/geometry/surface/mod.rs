//! Surfaces of triangles: input meshes, nearest points, and cuts.

pub(crate) mod body_surface;
pub(crate) mod box_tree;
pub(crate) mod clip;
mod components;
pub(crate) mod nearest;
pub(crate) mod triangle_mesh;
pub(crate) mod triangles;
