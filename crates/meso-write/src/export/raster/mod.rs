//! Values on a regular grid of voxels, and the files that hold them: one file per format, slab by slab.
//!
//! Arrays are [z, y, x] in C order. Slabs arrive in ascending z and are written as they come, so that no file needs the
//! whole image in memory.

pub(crate) mod npy;
pub(crate) mod png;
pub(crate) mod tif;
pub(crate) mod vti;

use std::borrow::Cow;

/// The grid of an image, and the kind of its values.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Frame {
    /// Voxels along x, y and z.
    pub counts: [usize; 3],
    /// Lower corner of the first voxel, mm.
    pub corner_mm: [f64; 3],
    /// Edge of a voxel, mm.
    pub voxel_size_mm: f64,
    /// The axis that a section has lost; `None` of a volume.
    pub section: Option<usize>,
    /// Quantity of the values, in one word.
    pub name: &'static str,
    /// The type of the values.
    pub kind: ValueKind,
}

impl Frame {
    /// Lengths of the array's axes, the slowest first: three of a volume, two of a section.
    pub(crate) fn shape(&self) -> Vec<usize> {
        (0..3).rev().filter(|axis| Some(*axis) != self.section).map(|axis| self.counts[axis]).collect()
    }

    /// Rows and columns of one picture, and how many pictures there are: the layers of a volume, or one section.
    fn pictures(&self) -> ([u32; 2], usize) {
        let shape: Vec<u32> = self.shape().iter().map(|&n| n as u32).collect();
        match shape[..] {
            [layers, rows, columns] => ([rows, columns], layers as usize),
            [rows, columns] => ([rows, columns], 1),
            _ => unreachable!("volumes have three axes, sections two"),
        }
    }
}

/// The type of an image's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ValueKind {
    /// Phases, `u8`.
    Label,
    /// Ids, `i32`.
    Id,
    /// Shares and distances, `f32`.
    Real,
}

impl ValueKind {
    /// Bytes of a value.
    pub(crate) fn bytes(self) -> usize {
        match self {
            Self::Label => 1,
            Self::Id | Self::Real => 4,
        }
    }
}

/// The values of some layers, x fastest, then y, then z.
#[derive(Clone, Debug, PartialEq)]
pub enum Voxels {
    /// Phases.
    Label(Vec<u8>),
    /// Ids.
    Id(Vec<i32>),
    /// Shares or distances.
    Real(Vec<f32>),
}

impl Voxels {
    /// Number of voxels.
    pub fn len(&self) -> usize {
        match self {
            Self::Label(values) => values.len(),
            Self::Id(values) => values.len(),
            Self::Real(values) => values.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes of the values, the lowest first.
    pub fn bytes(&self) -> Cow<'_, [u8]> {
        match self {
            Self::Label(values) => Cow::Borrowed(values),
            Self::Id(values) if cfg!(target_endian = "little") => Cow::Borrowed(bytemuck::cast_slice(values)),
            Self::Real(values) if cfg!(target_endian = "little") => Cow::Borrowed(bytemuck::cast_slice(values)),
            Self::Id(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            Self::Real(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        }
    }
}
