//! What aggregates are placed in: the specimens that a spec may name, and the room each of them encloses.
//!
//! [`Specimen`] is the spec's view, a few lengths or coordinates. [`Specimen::room`] turns it into a [`Room`]: one file
//! per kind behind one small interface.

mod convex;
mod cuboid;
mod cylinder;
mod period;
mod room;
mod sphere;

pub use period::{Period, Periodic};
pub use room::{Room, Surface};

use crate::geometry::HullError;
use crate::math::{Aabb, Vec3};
use convex::Convex;
use cuboid::Cuboid;
use cylinder::Cylinder;
use serde::{Deserialize, Serialize};
use sphere::Sphere;

/// A specimen; its frame has the origin at the lowest corner of its bounding box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Specimen {
    /// A cube from the origin.
    Cube {
        /// Side, mm.
        side_mm: f64,
        /// The axes along which it repeats itself; it has no walls across them.
        #[serde(default, skip_serializing_if = "Periodic::is_none")]
        periodic: Periodic,
    },
    /// A box from the origin.
    Box {
        /// Edge lengths along x, y, z, mm.
        size_mm: [f64; 3],
        /// The axes along which it repeats itself; it has no walls across them.
        #[serde(default, skip_serializing_if = "Periodic::is_none")]
        periodic: Periodic,
    },
    /// A box as beams are named: the length along x, the width along y, the depth upwards.
    Prism {
        /// Along x, mm.
        length_mm: f64,
        /// Along y, mm.
        width_mm: f64,
        /// Along z, mm.
        depth_mm: f64,
    },
    /// An upright cylinder: its axis is parallel to z.
    Cylinder {
        /// Diameter, mm.
        diameter_mm: f64,
        /// Along z, mm.
        height_mm: f64,
    },
    /// A sphere.
    Sphere {
        /// Diameter, mm.
        diameter_mm: f64,
    },
    /// The convex hull of points, moved to the origin.
    Polyhedron {
        /// Four points or more, mm.
        vertices_mm: Vec<[f64; 3]>,
    },
}

impl Default for Specimen {
    fn default() -> Self {
        Self::cube(150.0)
    }
}

impl Specimen {
    /// A cube with walls on all sides; `side_mm` in mm.
    pub fn cube(side_mm: f64) -> Self {
        Self::Cube { side_mm, periodic: Periodic::NONE }
    }

    /// A box with walls on all sides; edge lengths in mm.
    pub fn cuboid(size_mm: [f64; 3]) -> Self {
        Self::Box { size_mm, periodic: Periodic::NONE }
    }

    /// The name the spec gives it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Cube { .. } => "cube",
            Self::Box { .. } => "box",
            Self::Prism { .. } => "prism",
            Self::Cylinder { .. } => "cylinder",
            Self::Sphere { .. } => "sphere",
            Self::Polyhedron { .. } => "polyhedron",
        }
    }

    /// The axes along which it repeats itself.
    pub fn periodic(&self) -> Periodic {
        match *self {
            Self::Cube { periodic, .. } | Self::Box { periodic, .. } => periodic,
            _ => Periodic::NONE,
        }
    }

    /// The lengths after which it repeats itself.
    pub fn period(&self) -> Period {
        let size = match *self {
            Self::Cube { side_mm, .. } => [side_mm; 3],
            Self::Box { size_mm, .. } => size_mm,
            _ => [0.0; 3],
        };
        Period::new(&Vec3::from(size), self.periodic())
    }

    /// The room it encloses.
    ///
    /// # Errors
    /// Points that enclose no room.
    pub fn build(&self) -> Result<Box<dyn Room>, HullError> {
        Ok(match self {
            Self::Cube { side_mm, periodic } => Box::new(Cuboid::new([*side_mm; 3], *periodic)),
            Self::Box { size_mm, periodic } => Box::new(Cuboid::new(*size_mm, *periodic)),
            &Self::Prism { length_mm, width_mm, depth_mm } => {
                Box::new(Cuboid::new([length_mm, width_mm, depth_mm], Periodic::NONE))
            }
            &Self::Cylinder { diameter_mm, height_mm } => Box::new(Cylinder::new(diameter_mm, height_mm)),
            &Self::Sphere { diameter_mm } => Box::new(Sphere::new(diameter_mm)),
            Self::Polyhedron { vertices_mm } => Box::new(Convex::hull(vertices_mm)?),
        })
    }

    /// The room of a specimen that was accepted by [`Spec::validate`](crate::Spec::validate).
    ///
    /// # Panics
    /// Where [`Specimen::build`] fails.
    pub fn room(&self) -> Box<dyn Room> {
        self.build().expect("an accepted specimen encloses a room")
    }

    /// Bounding box, mm.
    pub fn aabb(&self) -> Aabb {
        self.room().aabb()
    }

    /// Volume, mm3.
    pub fn volume(&self) -> f64 {
        self.room().volume()
    }
}

/// The points moved so that the lowest corner of their bounding box is the origin.
fn at_origin(points: &[[f64; 3]]) -> Vec<Vec3> {
    let points: Vec<Vec3> = points.iter().map(|p| Vec3::from(*p)).collect();
    let origin = Aabb::around(&points).min;
    points.iter().map(|p| p - origin).collect()
}
