//! Voxels of a box, and the specimen's ends.

use crate::error::EffectiveError;
use meso_collision::math::Vec3;
use meso_concrete::OutOfRange;
use meso_concrete::Ranges;
use meso_concrete::specimen::Specimen;

/// Both ends of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// The specimen repeats itself.
    Periodic,
    /// No flux.
    Insulated,
    /// Given potentials; only along the third axis.
    Fixed,
}

/// The box of a specimen, and the axes along which it repeats itself.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Space {
    pub(crate) min: Vec3,
    pub(crate) size: Vec3,
    pub(crate) periodic: [bool; 3],
}

impl Space {
    pub(crate) fn of(specimen: &Specimen) -> Self {
        let (aabb, period) = (specimen.aabb(), specimen.period());
        Self { min: aabb.min, size: aabb.size(), periodic: [0, 1, 2].map(|axis| period.along(axis).is_some()) }
    }

    /// Conditions at the ends of each axis, by their name at walls.
    pub(crate) fn boundary(&self, at_walls: &'static str) -> [&'static str; 3] {
        self.periodic.map(|is| if is { "periodic" } else { at_walls })
    }

    /// Edges of a voxel, mm.
    pub(crate) fn spacing(&self, counts: [usize; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.size[axis] / counts[axis] as f64)
    }
}

/// Voxels of a box, its axes turned so that a fixed one is the third.
pub(crate) struct Grid {
    pub(crate) origin: Vec3,
    pub(crate) spacing: Vec3,
    pub(crate) counts: [usize; 3],
    pub(crate) ends: [End; 3],
}

/// A link's ends relative to the face in its middle, mm.
pub(crate) struct Link {
    pub(crate) from: f64,
    pub(crate) to: f64,
}

impl Grid {
    /// A grid of `counts` voxels. Potentials are fixed along axis `fixed`, which becomes the third; other walls
    /// are insulated.
    pub(crate) fn new(space: &Space, counts: [usize; 3], last: usize, fixed: bool) -> Self {
        let axis = |a: usize| (last + 1 + a) % 3;
        let ends = [0, 1, 2].map(|a| match space.periodic[axis(a)] {
            true => End::Periodic,
            false if fixed && a == 2 => End::Fixed,
            false => End::Insulated,
        });
        let counts = [0, 1, 2].map(|a| counts[axis(a)]);
        let turned = |v: Vec3| Vec3::new(v[axis(0)], v[axis(1)], v[axis(2)]);
        let size = turned(space.size);
        let spacing = Vec3::new(size.x / counts[0] as f64, size.y / counts[1] as f64, size.z / counts[2] as f64);
        Self { origin: turned(space.min), spacing, counts, ends }
    }

    /// The link through plane `number` across `axis`; none at an insulated wall.
    pub(crate) fn link(&self, axis: usize, number: usize) -> Option<Link> {
        let half = self.spacing[axis] / 2.0;
        let (first, last) = (number == 0, number == self.counts[axis]);
        match self.ends[axis] {
            End::Insulated if first || last => None,
            End::Fixed if first => Some(Link { from: 0.0, to: half }),
            End::Fixed if last => Some(Link { from: -half, to: 0.0 }),
            _ => Some(Link { from: -half, to: half }),
        }
    }

    /// Area of a face across `axis`, mm2.
    pub(crate) fn area(&self, axis: usize) -> f64 {
        self.spacing[(axis + 1) % 3] * self.spacing[(axis + 2) % 3]
    }

    /// Volume of the box, mm3.
    pub(crate) fn volume(&self) -> f64 {
        (0..3).map(|a| self.spacing[a] * self.counts[a] as f64).product()
    }
}

/// Most voxels: their numbers fit 32 bits, and their links 50 GB.
const MOST: f64 = 1e9;
/// Fewest voxels along an axis: the second resolution has half as many.
const FEWEST: usize = 4;

/// Grids of twice and four times the size, as far as they have two voxels along each axis.
pub(crate) fn coarser(counts: [usize; 3]) -> Vec<[usize; 3]> {
    let twice = counts.map(|count| count.div_ceil(2));
    let fourfold = twice.map(|count| count.div_ceil(2));
    [twice, fourfold].into_iter().filter(|counts| counts.iter().all(|count| *count > 1)).collect()
}

/// Sizes of the voxels of [`coarser`] grids over the fine ones', mean of the axes with several voxels.
pub(crate) fn ratios(counts: [usize; 3]) -> [f64; 2] {
    let twice = counts.map(|count| count.div_ceil(2));
    let of = |coarse: [usize; 3]| {
        let several = || (0..3).filter(|axis| counts[*axis] > 1);
        several().map(|axis| counts[axis] as f64 / coarse[axis] as f64).sum::<f64>() / several().count() as f64
    };
    [of(twice), of(twice.map(|count| count.div_ceil(2)))]
}

/// An even number of voxels along each axis of a box, of nearly `size` mm.
pub(crate) fn counts(specimen: &Specimen, size: f64) -> Result<[usize; 3], EffectiveError> {
    if !specimen.container().is_box() {
        return Err(EffectiveError::Specimen(specimen.kind()));
    }
    let ranges = Ranges("effective");
    ranges.positive("voxel_size_mm", size)?;
    let lengths = specimen.aabb().size();
    let shortest = lengths.min();
    let exact = [0, 1, 2].map(|axis| lengths[axis] / size);
    let error = |accepted: String| -> OutOfRange { ranges.error("voxel_size_mm", size, accepted) };
    if exact.iter().product::<f64>() > MOST {
        return Err(error(format!("a thousand million voxels are the most; {} mm is", lengths.max() / 900.0)).into());
    }
    let counts = exact.map(|count| 2 * (count / 2.0 + 0.5) as usize);
    if counts.iter().any(|count| *count < FEWEST) {
        return Err(error(format!("it must be at most {} mm, a quarter of the shortest side", shortest / 4.0)).into());
    }
    Ok(counts)
}
