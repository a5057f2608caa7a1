//! Label volumes: an integer for each voxel, as computed tomography leaves them after segmentation.
//!
//! Arrays are [z, y, x] in C order, as in the images that mesocrete writes. A reader gives its values one after another, x
//! fastest; `Values` numbers the labels.

mod npy;
mod tif;
mod vti;
mod xml;

use super::{ending, list, misnamed};
use crate::{OutOfRange, Ranges, written};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// Endings of the names of files that are read, in lower case.
pub const ENDINGS: [&str; 4] = ["tif", "tiff", "npy", "vti"];
/// Numbers of labels: `u8` where labels are phases, `u16` where they are grains.
pub trait LabelNumber: Copy + Default + Into<usize> + TryFrom<usize> {}

impl LabelNumber for u8 {}
impl LabelNumber for u16 {}

/// A label at every voxel.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume<N = u8> {
    /// Voxels along x, y, z.
    pub counts: [usize; 3],
    /// Edges of a voxel along x, y, z, mm; `None` if the file does not say.
    pub spacing_mm: Option<[f64; 3]>,
    /// Why the file gives no size of a voxel, or which part of it was assumed; `None` if there is nothing to say.
    pub size_note: Option<String>,
    /// Which of several arrays was read, for the user.
    pub array_note: Option<String>,
    /// The labels that occur, ascending.
    pub labels: Vec<i64>,
    /// Index into [`labels`](Self::labels) of every voxel, x fastest.
    pub of: Vec<N>,
}

/// What is asked of a file.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wanted<'a> {
    /// Name of the array of a `.vti`; `None` takes its scalars.
    pub array: Option<&'a str>,
    /// Most bytes of memory that may be taken; `None` if unknown.
    pub most_bytes: Option<u64>,
}

/// Why bytes are no label volume.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum VolumeError {
    /// The name ends like no format that is read.
    #[error("its name must end in {}", list(&ENDINGS))]
    Ending,
    /// The file has another format than its name says.
    #[error("{0}")]
    Misnamed(String),
    /// The file does not begin as its format does.
    #[error("this is not {0}")]
    Begin(&'static str),
    /// The file is shorter than its header says.
    #[error("it ends within its {0}; it was cut off, or its header is wrong")]
    Cut(&'static str),
    /// A part of a format that is not read.
    #[error("{found} is not read; {fix}")]
    Unread {
        /// The part.
        found: String,
        /// Remedy.
        fix: &'static str,
    },
    /// A header without a needed entry.
    #[error("its header has no {0}")]
    Missing(&'static str),
    /// No voxels.
    #[error("it has no voxels")]
    Empty,
    /// A value that is no integer.
    #[error("voxel {voxel}, counted from 0, has the value {value}; labels are integers: segment the image first")]
    Fraction {
        /// Number, x fastest.
        voxel: usize,
        /// The value as text.
        value: String,
    },
    /// An integer beyond 64 bits with a sign.
    #[error(
        "voxel {voxel}, counted from 0, has the label {label}; labels are at most 9223372036854775807: number them anew"
    )]
    Beyond {
        /// Number, x fastest.
        voxel: usize,
        /// The label.
        label: u64,
    },
    /// A volume that takes more memory than there is.
    #[error("it has {} x {} x {} voxels, which take about {needed} MB of memory, and {free} MB are free; cut a part out", counts[0], counts[1], counts[2])]
    Large {
        /// Voxels along x, y, z.
        counts: [usize; 3],
        /// Memory for them, MB.
        needed: u64,
        /// Free memory, MB.
        free: u64,
    },
    /// Memory that the system did not give.
    #[error("there is not enough memory for it; cut a part out")]
    Memory,
    /// An array that is not there.
    #[error("it has no array `{array}` of one value a voxel; {}", arrays(found))]
    Array {
        /// The name that was asked for.
        array: String,
        /// Those that are there.
        found: Vec<String>,
    },
    /// More labels than phases or grains could be.
    #[error("it has more than {most} labels; segment the image first, one label a phase or a grain")]
    Many {
        /// Most labels that are read; grey values have more.
        most: usize,
    },
}

/// Names of arrays in a sentence.
fn arrays(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{}`", name.escape_debug())).collect();
    if quoted.is_empty() { "it has none".to_owned() } else { format!("take one of {}", quoted.join(", ")) }
}

/// Reads the label volume in `bytes`; the ending of `name` decides the format.
///
/// # Errors
/// See [`VolumeError`].
pub fn read<N: LabelNumber>(name: &str, bytes: &[u8]) -> Result<Volume<N>, VolumeError> {
    read_wanted(name, bytes, &Wanted::default())
}

/// Reads the wanted label volume in `bytes`; the ending of `name` decides the format.
///
/// # Errors
/// See [`VolumeError`].
pub fn read_wanted<N: LabelNumber>(name: &str, bytes: &[u8], wanted: &Wanted<'_>) -> Result<Volume<N>, VolumeError> {
    let found = match ending(name).as_deref() {
        Some("vti") => vti::read(bytes, wanted),
        Some("tif" | "tiff" | "npy") if wanted.array.is_some() => {
            let fix = "leave the name of the array out: only a .vti has several";
            return Err(VolumeError::Unread { found: "a named array".to_owned(), fix });
        }
        Some("tif" | "tiff") => tif::read(bytes, wanted),
        Some("npy") => npy::read(bytes, wanted),
        _ => Err(VolumeError::Ending),
    };
    found.map_err(|error| misnamed(name, bytes, &ENDINGS).map_or(error, VolumeError::Misnamed))
}

impl Volume {
    /// Edges that a voxel may have, mm.
    const EDGES_MM: RangeInclusive<f64> = 1e-6..=1e6;

    /// Refuses the edges of a voxel in the option `voxel_size_mm` of a table.
    ///
    /// # Errors
    /// The first edge out of its range.
    pub fn accept_edges(table: &'static str, edges: &[f64; 3]) -> Result<(), OutOfRange> {
        let range = Self::EDGES_MM;
        let accepted = format!("it must be {:e} to {:e} mm", range.start(), range.end());
        let accept = |edge: &f64| Ranges(table).require("voxel_size_mm", *edge, range.contains(edge), &*accepted);
        edges.iter().try_for_each(accept)
    }
}

impl<N: LabelNumber> Volume<N> {
    /// What the file left open about the size of a voxel, where `is_sized` says that it is given otherwise.
    pub fn size_remark(&self, is_sized: bool) -> Option<String> {
        match (&self.size_note, self.spacing_mm) {
            _ if is_sized => None,
            (note, Some(_)) => note.clone(),
            (note, None) => {
                let reason = note.as_deref().unwrap_or("the file has no size of a voxel");
                Some(format!("{reason}, so it is 1 mm"))
            }
        }
    }

    /// A volume from its labels, x fastest.
    ///
    /// # Errors
    /// More labels than phases could be, and a number of values that is not that of the voxels.
    pub fn new(
        counts: [usize; 3],
        spacing_mm: Option<[f64; 3]>,
        labels: impl IntoIterator<Item = i64>,
    ) -> Result<Self, VolumeError> {
        let mut values = Values::default();
        labels.into_iter().try_for_each(|label| values.add(label))?;
        values.volume(counts, spacing_mm)
    }
}

/// Labels as they are read, numbered in the order in which they are met.
#[derive(Default)]
struct Values<N> {
    numbers: BTreeMap<i64, N>,
    /// The label before, and its number.
    last: Option<(i64, N)>,
    of: Vec<N>,
}

/// Bytes in a megabyte.
const MB: u64 = 1_000_000;

impl<N: LabelNumber> Values<N> {
    /// Room for the labels of so many voxels, whose reading takes `beside` bytes.
    fn of(counts: [usize; 3], beside: usize, wanted: &Wanted<'_>) -> Result<Self, VolumeError> {
        let count = voxels(counts).ok_or(VolumeError::Cut("values"))?;
        let needed = (size_of::<N>() as u64).saturating_mul(count as u64).saturating_add(beside as u64);
        if let Some(free) = wanted.most_bytes.filter(|free| needed > *free) {
            return Err(VolumeError::Large { counts, needed: needed.div_ceil(MB), free: free / MB });
        }
        let mut values = Self { numbers: BTreeMap::new(), last: None, of: Vec::new() };
        values.of.try_reserve_exact(count).map_err(|_| VolumeError::Memory)?;
        Ok(values)
    }

    fn add(&mut self, label: i64) -> Result<(), VolumeError> {
        let number = match self.last {
            Some((last, number)) if last == label => number,
            _ => self.number(label)?,
        };
        self.last = Some((label, number));
        self.of.push(number);
        Ok(())
    }

    fn number(&mut self, label: i64) -> Result<N, VolumeError> {
        if let Some(number) = self.numbers.get(&label) {
            return Ok(*number);
        }
        let most = self.numbers.len();
        let number = N::try_from(most).map_err(|_| VolumeError::Many { most })?;
        self.numbers.insert(label, number);
        Ok(number)
    }

    fn add_real(&mut self, value: f64) -> Result<(), VolumeError> {
        // Larger values are no labels, and their neighbours cannot be told from them.
        if value.fract() != 0.0 || value.abs() > 9e15 {
            return Err(VolumeError::Fraction { voxel: self.of.len(), value: value.to_string() });
        }
        self.add(value as i64)
    }

    /// Adds values as a file has them.
    fn add_bytes(&mut self, bytes: &[u8], kind: Kind, is_big: bool) -> Result<(), VolumeError> {
        if kind.size == 1 {
            return self.add_single(bytes, kind.number);
        }
        for value in bytes.chunks_exact(kind.size) {
            let mut eight = [0; 8];
            eight[..kind.size].copy_from_slice(value);
            if is_big {
                eight[..kind.size].reverse();
            }
            let raw = u64::from_le_bytes(eight);
            let unused = 64 - 8 * kind.size as u32;
            match kind.number {
                Number::Unsigned => self.add_unsigned(raw)?,
                Number::Signed => self.add((raw << unused).cast_signed() >> unused)?,
                Number::Real if kind.size == 4 => self.add_real(f64::from(f32::from_bits(raw as u32)))?,
                Number::Real => self.add_real(f64::from_bits(raw))?,
            }
        }
        Ok(())
    }

    /// Adds labels of one byte, which have few values: each is looked up once.
    fn add_single(&mut self, bytes: &[u8], number: Number) -> Result<(), VolumeError> {
        let mut occurs = [false; 256];
        bytes.iter().for_each(|byte| occurs[usize::from(*byte)] = true);
        let mut numbers = [N::default(); 256];
        for byte in (0..=u8::MAX).filter(|byte| occurs[usize::from(*byte)]) {
            let is_signed = matches!(number, Number::Signed);
            let label = if is_signed { i64::from(byte.cast_signed()) } else { i64::from(byte) };
            numbers[usize::from(byte)] = self.number(label)?;
        }
        self.of.extend(bytes.iter().map(|byte| numbers[usize::from(*byte)]));
        Ok(())
    }

    fn add_unsigned(&mut self, raw: u64) -> Result<(), VolumeError> {
        let label = i64::try_from(raw).map_err(|_| VolumeError::Beyond { voxel: self.of.len(), label: raw })?;
        self.add(label)
    }

    fn volume(self, counts: [usize; 3], spacing_mm: Option<[f64; 3]>) -> Result<Volume<N>, VolumeError> {
        if self.of.is_empty() {
            return Err(VolumeError::Empty);
        }
        if voxels(counts) != Some(self.of.len()) {
            return Err(VolumeError::Cut("values"));
        }
        let mut places = vec![N::default(); self.numbers.len()];
        for (place, number) in self.numbers.values().enumerate() {
            places[(*number).into()] = N::try_from(place).unwrap_or_default();
        }
        let mut of = self.of;
        if (0..).zip(&places).any(|(number, place)| number != (*place).into()) {
            of.iter_mut().for_each(|number| *number = places[(*number).into()]);
        }
        let kept = spacing_mm.filter(|spacing| spacing.iter().all(|h| <Volume>::EDGES_MM.contains(h)));
        let size_note = spacing_mm.filter(|_| kept.is_none()).map(|spacing| {
            let [x, y, z] = spacing.map(written);
            format!("the file has voxels of {x} x {y} x {z} mm, which no specimen has")
        });
        Ok(Volume {
            counts,
            spacing_mm: kept,
            size_note,
            array_note: None,
            labels: self.numbers.into_keys().collect(),
            of,
        })
    }
}

/// Number of voxels, if it can be one.
fn voxels(counts: [usize; 3]) -> Option<usize> {
    counts.iter().try_fold(1_usize, |product, count| product.checked_mul(*count))
}

/// Type of the values of a file.
#[derive(Clone, Copy)]
struct Kind {
    number: Number,
    /// Bytes: 1, 2, 4 or 8.
    size: usize,
}

#[derive(Clone, Copy)]
enum Number {
    Unsigned,
    Signed,
    Real,
}
