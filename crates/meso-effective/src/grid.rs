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
    /// A grid of `counts` voxels of the specimen. Potentials are fixed along axis `fixed`, which becomes the third; other walls
    /// are insulated.
    pub(crate) fn new(specimen: &Specimen, counts: [usize; 3], last: usize, fixed: bool) -> Self {
        let (aabb, period) = (specimen.aabb(), specimen.period());
        let axis = |a: usize| (last + 1 + a) % 3;
        let ends = [0, 1, 2].map(|a| match period.along(axis(a)) {
            Some(_) => End::Periodic,
            None if fixed && a == 2 => End::Fixed,
            None => End::Insulated,
        });
        let counts = [0, 1, 2].map(|a| counts[axis(a)]);
        let turned = |v: Vec3| Vec3::new(v[axis(0)], v[axis(1)], v[axis(2)]);
        let size = turned(aabb.size());
        let spacing = Vec3::new(size.x / counts[0] as f64, size.y / counts[1] as f64, size.z / counts[2] as f64);
        Self { origin: turned(aabb.min), spacing, counts, ends }
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

/// An even number of voxels along each axis, of nearly `size` mm.
pub(crate) fn counts(specimen: &Specimen, size: f64) -> Result<[usize; 3], EffectiveError> {
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
