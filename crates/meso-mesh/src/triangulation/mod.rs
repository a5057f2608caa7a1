//! Plane regions and faceted surfaces as triangles of a given size: shared edges come out alike, bit for bit.

mod facets;
mod nodes;
mod plane;
mod walls;

pub(crate) use facets::{LONGEST, facets, of_body};
use meso_collision::math::Vec3;
pub(crate) use nodes::{Nodes, key, snap};
pub(crate) use plane::{FittedPlane, Frame, halved, region};
pub(crate) use walls::{chord, polygons, walls};

/// A surface of triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Triangles {
    pub(crate) points: Vec<Vec3>,
    /// Counter-clockwise from outside.
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// Why something has no triangles.
#[derive(Debug, thiserror::Error)]
#[error("{what} at {:.6}, {:.6}, {:.6} mm", at[0], at[1], at[2])]
pub(crate) struct Untriangulated {
    /// The fault.
    pub(crate) what: &'static str,
    /// Where, mm.
    pub(crate) at: [f64; 3],
}

impl Untriangulated {
    pub(crate) fn new(what: &'static str, at: &Vec3) -> Self {
        Self { what, at: (*at).into() }
    }
}
