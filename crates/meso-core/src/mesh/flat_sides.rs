//! The flat sides of a specimen's box across which it does not repeat itself: where aggregates end before the mesh does.

use crate::math::{Aabb, Vec3};
use crate::packing::Specimen;

/// Points this near to a side, in sizes of the box, are on it.
const ROUNDING: f64 = 1e-9;

/// The planes of the sides, in the order of [`SIDES`](super::sides::SIDES).
pub(super) struct FlatSides {
    aabb: Aabb,
    repeats: [bool; 3],
    slack: f64,
}

impl FlatSides {
    pub(super) fn of(specimen: &Specimen) -> Self {
        let aabb = specimen.aabb();
        Self { aabb, repeats: specimen.periodic().0, slack: ROUNDING * aabb.size().max() }
    }

    /// Whether `x` lies on one of the sides.
    pub(super) fn have(&self, x: &Vec3) -> bool {
        self.across(x) != 0
    }

    /// The sides that `x` lies on, a bit for each.
    pub(super) fn across(&self, x: &Vec3) -> u8 {
        (0..3).filter(|&axis| !self.repeats[axis]).fold(0, |bits, axis| {
            let (low, high) =
                (x[axis] <= self.aabb.min[axis] + self.slack, x[axis] >= self.aabb.max[axis] - self.slack);
            bits | u8::from(low) << (2 * axis) | u8::from(high) << (2 * axis + 1)
        })
    }

    /// From `body` to the farthest of the sides `across`, mm.
    pub(super) fn gap(&self, body: &Aabb, across: u8) -> f64 {
        let gaps = |axis: usize| [body.min[axis] - self.aabb.min[axis], self.aabb.max[axis] - body.max[axis]];
        let all = [0, 1, 2].map(gaps);
        (0..6).filter(|side| across >> side & 1 == 1).map(|side| all.as_flattened()[side]).fold(0.0, f64::max)
    }
}
