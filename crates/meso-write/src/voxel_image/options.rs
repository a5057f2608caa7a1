//! Options of an image.

use meso_collision::math::Vec3;
use meso_concrete::specimen::Specimen;
use meso_concrete::{short, written};
use meso_mesh::location::PointGrid;
use meso_pack::spec::SpecError;
use serde::{Deserialize, Serialize};

/// Quantity at the voxels of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// The phase at the centre, `u8`: 0 mortar, 1 ITZ, 2 aggregate, 3 void, 4 fibre, 5 on the packing's own phases, 255 outside the specimen.
    #[default]
    Phase,
    /// The id of the aggregate, void or fibre at the centre, `i32`: -1 in the mortar, -2 outside.
    Grain,
    /// The share of the voxel's volume that bodies of one kind take, `f32`; see [`ShareOf`].
    Share,
    /// From the centre to the nearest surface of an aggregate, void or fibre, mm, `f32`: negative inside, NaN outside the
    /// specimen, infinite where there are none.
    Distance,
}

impl Quantity {
    /// Name of the quantity in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Phase => "phase",
            Self::Grain => "grain",
            Self::Share => "share",
            Self::Distance => "distance",
        }
    }
}

/// Whose share of a voxel is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ShareOf {
    /// Aggregates with their ITZ shells, as the packing's fraction counts them.
    #[default]
    Aggregate,
    /// Aggregates without their ITZ shells.
    Core,
    /// The ITZ shells alone.
    Itz,
    /// Voids.
    Void,
    /// Fibres.
    Fibre,
}

/// The part of the specimen that an image shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Region {
    /// All of its bounding box.
    #[default]
    Whole,
    /// A box, mm; voxels are counted from its lower corner.
    Box {
        /// Lower corner.
        min: [f64; 3],
        /// Upper corner.
        max: [f64; 3],
    },
    /// The voxels whose centres lie on a plane across an axis.
    Section {
        /// 0, 1 or 2.
        axis: usize,
        /// Where on it, mm.
        at: f64,
    },
}

/// Everything that decides an image of a packing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageOptions {
    /// Edge of a voxel, mm.
    pub voxel_size_mm: f64,
    /// Quantity at the voxels.
    pub quantity: Quantity,
    /// Whose share, where a share is asked for.
    pub of: ShareOf,
    /// Part of the specimen.
    pub region: Region,
}

impl Default for ImageOptions {
    fn default() -> Self {
        Self { voxel_size_mm: 1.0, quantity: Quantity::Phase, of: ShareOf::Aggregate, region: Region::Whole }
    }
}

/// The error of an option that cannot be met: its name, its value, and the accepted range.
fn wrong(key: &str, value: impl std::fmt::Display, accepted: impl std::fmt::Display) -> SpecError {
    SpecError::value(key, format!("is {}; {accepted}", written(value)))
}

/// Most voxels along an axis.
const MOST: f64 = 100_000.0;
/// A length that is so near a whole number of voxels, as a share of one, is that many.
const ROUNDING: f64 = 1e-6;

impl ImageOptions {
    /// The lower corner of the first voxel, and the centres of all.
    pub(super) fn grid(&self, specimen: &Specimen) -> Result<(Vec3, PointGrid), SpecError> {
        let aabb = specimen.aabb();
        let h = self.voxel_size_mm;
        let (low, high) = (aabb.size().max() / MOST, aabb.size().max());
        if !(h >= low && h <= high) {
            let accepted = format!("it must lie within {} and {high} mm for this specimen", short(low));
            return Err(wrong("voxel_size_mm", h, accepted));
        }
        let (min, max) = match self.region {
            Region::Box { min, max } => within(min, max, specimen)?,
            Region::Whole | Region::Section { .. } => (aabb.min, aabb.max),
        };
        let mut counts = [0, 1, 2].map(|axis| count((max - min)[axis], h));
        for (axis, &count) in counts.iter().enumerate() {
            if self.region == Region::Whole && specimen.periodic().0[axis] {
                divides(aabb.size()[axis], h, count)?;
            }
        }
        let mut corner = min;
        if let Region::Section { axis, at } = self.region {
            if !(at >= min[axis] && at <= max[axis]) {
                let accepted = format!("it must lie within {} and {} mm", min[axis], max[axis]);
                return Err(wrong("section", at, accepted));
            }
            counts[axis] = 1;
            corner[axis] = at - h / 2.0;
        }
        Ok((corner, PointGrid { origin: corner.add_scalar(h / 2.0), spacing: Vec3::repeat(h), counts }))
    }
}

/// Voxels of size `h` that cover `length`.
fn count(length: f64, h: f64) -> usize {
    let (exact, nearest) = (length / h, (length / h).round());
    if (exact - nearest).abs() <= ROUNDING { nearest.max(1.0) as usize } else { exact.ceil() as usize }
}

/// Refuses voxels that leave a part of a period over: the image would not repeat itself.
fn divides(period: f64, h: f64, count: usize) -> Result<(), SpecError> {
    if (count as f64 * h - period).abs() <= ROUNDING * h {
        return Ok(());
    }
    let [fewer, more] = [count.max(2) - 1, count].map(|count| period / count as f64);
    let accepted = format!("it must divide the period of {period} mm, as {fewer} and {more} do");
    Err(wrong("voxel_size_mm", h, accepted))
}

/// A box in the specimen's bounding box, with a volume.
fn within(min: [f64; 3], max: [f64; 3], specimen: &Specimen) -> Result<(Vec3, Vec3), SpecError> {
    let aabb = specimen.aabb();
    let slack = ROUNDING * aabb.size().max();
    let fits = |axis: usize| {
        min[axis] >= aabb.min[axis] - slack && max[axis] <= aabb.max[axis] + slack && min[axis] < max[axis]
    };
    if (0..3).all(fits) {
        return Ok((min.into(), max.into()));
    }
    let size = aabb.size();
    let accepted = format!(
        "its lower corner must lie below its upper one, and both within 0, 0, 0 and {}, {}, {} mm",
        size.x, size.y, size.z
    );
    Err(wrong("box", format!("{min:?} to {max:?}"), accepted))
}

#[cfg(test)]
mod tests {
    use super::count;

    #[test]
    fn voxels_cover_a_length_and_rounding_adds_none() {
        assert_eq!([count(150.0, 0.1), count(100.0, 0.3), count(0.3, 0.1), count(7.0, 10.0)], [1500, 334, 3, 1]);
    }
}
