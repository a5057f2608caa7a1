//! The containers aggregates are placed in.

use crate::math::{Aabb, Vec3};
use serde::{Deserialize, Serialize};

/// A specimen; its frame has the origin at the corner (or the base's bounding corner) of its bounding box.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Specimen {
    /// A cube from the origin.
    Cube {
        /// Side, mm.
        side_mm: f64,
    },
    /// A box from the origin.
    Box {
        /// Edge lengths along x, y, z, mm.
        size_mm: [f64; 3],
    },
}

impl Default for Specimen {
    fn default() -> Self {
        Self::Cube { side_mm: 150.0 }
    }
}

impl Specimen {
    /// Bounding box, mm.
    pub fn aabb(&self) -> Aabb {
        let max = match *self {
            Self::Cube { side_mm } => Vec3::repeat(side_mm),
            Self::Box { size_mm } => Vec3::from(size_mm),
        };
        Aabb { min: Vec3::zeros(), max }
    }

    /// Volume, mm3.
    pub fn volume(&self) -> f64 {
        self.aabb().size().product()
    }

    /// The name the spec gives it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Cube { .. } => "cube",
            Self::Box { .. } => "box",
        }
    }

    /// Where the centre of a body may be, so that its box `local` about that centre stays `gap` mm inside the
    /// specimen's bounding box.
    pub fn room_for(&self, local: &Aabb, gap: f64) -> Aabb {
        let aabb = self.aabb();
        let gap = Vec3::repeat(gap);
        Aabb { min: aabb.min - local.min + gap, max: aabb.max - local.max - gap }
    }

    /// True when the vertices `body`, moved by `centre`, lies in the specimen with `gap` mm to its surface; exact for boxes.
    pub fn holds(&self, body: &[Vec3], centre: &Vec3, gap: f64) -> bool {
        let aabb = self.aabb();
        body.iter().all(|v| {
            let point = v + centre;
            (0..3).all(|i| point[i] >= aabb.min[i] + gap && point[i] <= aabb.max[i] - gap)
        })
    }
}
