//! The directories of a TIFF file: sizes and places, before any pixel is read.

use super::super::VolumeError;

const CUT: VolumeError = VolumeError::Cut("pages");

pub(super) const WIDTH: u16 = 256;
pub(super) const HEIGHT: u16 = 257;
const SUBFILE: u16 = 254;
const COMPRESSION: u16 = 259;
/// Which way rows and columns run.
const ORIENTATION: u16 = 274;
const PHOTOMETRIC: u16 = 262;
const DESCRIPTION: u16 = 270;
/// Slices that one page holds.
const DEPTH: u16 = 32997;

/// Photometric interpretations of which the decoder reads the first and the third.
pub(super) const WHITE_IS_ZERO: u64 = 0;
pub(super) const PALETTE: u64 = 3;

/// Rows from the top, pixels from the left.
pub(super) const FROM_THE_TOP_LEFT: u64 = 1;
const LZW: u64 = 5;

/// A file's bytes, with the order and the width of its numbers.
pub(super) struct Head<'a> {
    bytes: &'a [u8],
    is_big: bool,
    /// Places are numbers of eight bytes, as in files beyond 4 GB.
    is_wide: bool,
}

/// An entry of a directory.
#[derive(Clone, Copy)]
pub(super) struct Entry {
    tag: u16,
    kind: u16,
    count: usize,
    /// Where its value lies, or that value's place.
    at: usize,
}

/// A page of the file.
pub(super) struct Page {
    entries: Vec<Entry>,
}

impl<'a> Head<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Result<Self, VolumeError> {
        let (is_big, is_wide) = match bytes.get(..4) {
            Some(b"II*\0") => (false, false),
            Some(b"MM\0*") => (true, false),
            Some(b"II+\0") => (false, true),
            Some(b"MM\0+") => (true, true),
            _ => return Err(VolumeError::Begin("a TIFF file")),
        };
        Ok(Self { bytes, is_big, is_wide })
    }

    /// All pages in order.
    pub(super) fn pages(&self) -> Result<Vec<Page>, VolumeError> {
        let [count_bytes, entry_bytes, place_bytes] = if self.is_wide { [8, 20, 8] } else { [2, 12, 4] };
        let mut next = self.number(if self.is_wide { 8 } else { 4 }, place_bytes)?;
        let (mut pages, mut left) = (Vec::new(), self.bytes.len() / entry_bytes);
        while next != 0 {
            let count = self.number(next, count_bytes)?;
            // Directories do not overlap, so that their entries fit into the file.
            left = left.checked_sub(count).filter(|_| count > 0).ok_or(CUT)?;
            let entry = |number: usize| self.entry(next + count_bytes + number * entry_bytes);
            pages.push(Page { entries: (0..count).map(entry).collect::<Result<_, _>>()? });
            next = self.number(next + count_bytes + count * entry_bytes, place_bytes)?;
        }
        Ok(pages)
    }

    fn entry(&self, at: usize) -> Result<Entry, VolumeError> {
        let (count, size) = (at + 4, if self.is_wide { 8 } else { 4 });
        let two = |at| self.number(at, 2).map(|number| number as u16);
        Ok(Entry { tag: two(at)?, kind: two(at + 2)?, count: self.number(count, size)?, at: count + size })
    }

    fn number(&self, at: usize, size: usize) -> Result<usize, VolumeError> {
        let bytes = self.bytes.get(at..).and_then(|rest| rest.get(..size)).ok_or(CUT)?;
        let add = |sum: usize, byte: &u8| sum << 8 | usize::from(*byte);
        Ok(if self.is_big { bytes.iter().fold(0, add) } else { bytes.iter().rev().fold(0, add) })
    }

    /// Where the values of an entry begin.
    fn place(&self, entry: Entry) -> Result<usize, VolumeError> {
        let size = match entry.kind {
            3 | 8 => 2,
            4 | 9 | 11 | 13 => 4,
            5 | 10 | 12 | 16..=18 => 8,
            _ => 1,
        };
        let within = if self.is_wide { 8 } else { 4 };
        let is_near = entry.count.checked_mul(size).is_some_and(|bytes| bytes <= within);
        if is_near { Ok(entry.at) } else { self.number(entry.at, within) }
    }

    /// The first number of a tag.
    pub(super) fn of(&self, page: &Page, tag: u16) -> Option<u64> {
        let entry = page.entry(tag)?;
        let size = match entry.kind {
            1 => 1,
            3 => 2,
            4 => 4,
            16 => 8,
            _ => return None,
        };
        self.number(self.place(entry).ok()?, size).ok().map(|number| number as u64)
    }

    /// The first quotient of a tag.
    pub(super) fn quotient(&self, page: &Page, tag: u16) -> Option<f64> {
        let entry = page.entry(tag).filter(|entry| entry.kind == 5)?;
        let at = self.place(entry).ok()?;
        Some(self.number(at, 4).ok()? as f64 / self.number(at + 4, 4).ok()? as f64)
    }

    /// The description of a page. Older programs wrote it in Latin-1.
    pub(super) fn description(&self, page: &Page) -> String {
        let bytes = page.entry(DESCRIPTION).and_then(|entry| {
            let at = self.place(entry).ok()?;
            self.bytes.get(at..)?.get(..entry.count)
        });
        let bytes = bytes.unwrap_or_default();
        let text =
            str::from_utf8(bytes).map_or_else(|_| bytes.iter().copied().map(char::from).collect(), str::to_owned);
        text.trim_end_matches('\0').to_owned()
    }

    pub(super) fn photometric(&self, page: &Page) -> Option<u64> {
        self.of(page, PHOTOMETRIC)
    }

    /// Marks the labels of a palette as grey values in a copy of the file: colours are for the eye alone.
    pub(super) fn without_palette(&self, page: &Page, copy: &mut [u8]) {
        let Some(entry) = page.entry(PHOTOMETRIC).filter(|_| self.photometric(page) == Some(PALETTE)) else { return };
        let last = [1, 1, 1, 2, 4].get(usize::from(entry.kind)).copied().unwrap_or(8) - 1;
        let place = self.place(entry).map(|place| place + if self.is_big { last } else { 0 });
        if let Some(byte) = place.ok().and_then(|place| copy.get_mut(place)) {
            *byte = 1;
        }
    }
}

impl Page {
    fn entry(&self, tag: u16) -> Option<Entry> {
        self.entries.iter().find(|entry| entry.tag == tag).copied()
    }

    /// Whether this is a smaller copy of another page.
    pub(super) fn is_reduced(&self, head: &Head<'_>) -> bool {
        head.of(self, SUBFILE).is_some_and(|kind| kind & 1 == 1)
    }

    pub(super) fn orientation(&self, head: &Head<'_>) -> u64 {
        head.of(self, ORIENTATION).unwrap_or(FROM_THE_TOP_LEFT)
    }

    pub(super) fn is_lzw(&self, head: &Head<'_>) -> bool {
        head.of(self, COMPRESSION) == Some(LZW)
    }

    pub(super) fn slices(&self, head: &Head<'_>) -> u64 {
        head.of(self, DEPTH).unwrap_or(1)
    }
}
