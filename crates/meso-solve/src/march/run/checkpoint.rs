//! The whole state of a test as bytes: a test that is resumed gives the same bytes as one that was never cut.
//!
//! Little-endian numbers: a mark and a version, a note of the caller's, a fingerprint of the test, the state, and last the
//! SHA-256 of all bytes before it. The mesh is not in it; whoever resumes builds the same run anew.

use super::{Run, Since, State};
use crate::error::SolveError;
use crate::march::curve::Row;
use crate::march::path::Leg;
use crate::march::servo::{Follower, Servo};
use meso_element::block::{Block, Common, Group};
use meso_element::lanes::LANES;
use sha2::{Digest, Sha256};
use std::io::{self, Read, Write};

const MARK: [u8; 8] = *b"mesosolv";
const VERSION: u64 = 14;
/// Bytes of a SHA-256.
const SEAL: usize = 32;
const DAMAGED: &str = "the file is cut off or damaged";

/// Reads a whole checkpoint, and returns the note that [`Run::save`] was given.
///
/// # Errors
/// A file that is no checkpoint of this version, one with a changed bit, one that is cut off or continued, and those of
/// `from`.
pub fn checkpoint_note(from: &mut dyn Read) -> Result<Vec<u8>, SolveError> {
    let mut sealed = Sealed { from, hash: Sha256::new() };
    let note = opening(&mut sealed)?;
    let mut end = HashedEnd { hash: sealed.hash, last: Vec::new() };
    io::copy(sealed.from, &mut end).map_err(|error| SolveError::Resume(error.to_string()))?;
    if end.last == end.hash.finalize().as_slice() { Ok(note) } else { Err(damaged()) }
}

impl Run<'_> {
    /// Writes the state, with a `note` that [`checkpoint_note`] returns.
    ///
    /// # Errors
    /// Fails with the errors of `out`.
    pub fn save(&self, note: &[u8], out: &mut dyn Write) -> io::Result<()> {
        let mut out = io::BufWriter::new(HashingWriter { out, hash: Sha256::new() });
        self.write(note, &mut out)?;
        let HashingWriter { out, hash } = out.into_inner().map_err(io::IntoInnerError::into_error)?;
        out.write_all(&hash.finalize())?;
        out.flush()
    }

    fn write(&self, note: &[u8], out: &mut impl Write) -> io::Result<()> {
        out.write_all(&MARK)?;
        words(out, &[VERSION, note.len() as u64])?;
        out.write_all(note)?;
        out.write_all(&self.fingerprint())?;
        let state = &self.state;
        words(out, &[state.step, state.rows.len() as u64])?;
        numbers(out, &state.numbers())?;
        numbers(out, &state.servo.values())?;
        numbers(out, &state.follower.values())?;
        numbers(out, &state.leg.values())?;
        numbers(out, state.held.as_flattened())?;
        numbers(out, &state.forces)?;
        let Since { forces, speeds, travel, count, gauges } = &state.since_row;
        numbers(out, forces)?;
        numbers(out, speeds)?;
        numbers(out, &[*travel, *count])?;
        // A row that has just begun has no sums yet.
        (0..self.gauges.len()).try_for_each(|gauge| numbers(out, &[gauges.get(gauge).copied().unwrap_or(0.0)]))?;
        state.rows.iter().try_for_each(|row| numbers(out, &row.values()))?;
        numbers(out, &state.extra)?;
        numbers(out, self.nodes.displacement.as_flattened())?;
        numbers(out, self.nodes.velocity.as_flattened())?;
        for group in self.blocks.iter().flat_map(|block| &block.groups) {
            numbers(out, &[group.dissipated, group.hourglass[0], group.hourglass[1]])?;
            for eight in &group.memory {
                eight.0.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))?;
            }
        }
        Ok(())
    }

    /// Takes in a state that [`save`](Self::save) wrote for the same mesh, materials and test.
    ///
    /// # Errors
    /// A state of another test, one that is not whole to the bit, and those of `from`. The run is then as it was before its
    /// first step.
    pub fn resume(&mut self, from: &mut dyn Read) -> Result<(), SolveError> {
        let resumed = self.take_in(&mut io::BufReader::new(from));
        if resumed.is_err() {
            self.rewind();
        }
        resumed
    }

    fn take_in(&mut self, from: &mut dyn Read) -> Result<(), SolveError> {
        let mut sealed = Sealed { from, hash: Sha256::new() };
        let from = &mut sealed;
        opening(from)?;
        let mut fingerprint = [0; SEAL];
        read(from, &mut fingerprint)?;
        if fingerprint != self.fingerprint() {
            let why = "it belongs to another mesh, other materials or another test; resume with the same ones";
            return Err(SolveError::Resume(why.to_owned()));
        }
        let (step, rows) = (word(from)?, word(from)?);
        let mut state = State { step, ..State::default() };
        state.take(some(from)?);
        (state.servo, state.follower) = (Servo::from_values(some(from)?), Follower::from_values(some(from)?));
        let values = some(from)?;
        state.leg = Leg::from_values(values);
        if state.leg.values().map(f64::to_bits) != values.map(f64::to_bits) {
            return Err(damaged());
        }
        fill(from, state.held.as_flattened_mut())?;
        state.forces = some(from)?;
        let (forces, speeds) = (some(from)?, some(from)?);
        let [travel, count] = some(from)?;
        let mut gauges = vec![0.0; self.gauges.len()];
        fill(from, &mut gauges)?;
        state.since_row = Since { forces, speeds, travel, count, gauges };
        self.state = state;
        for _ in 0..rows {
            self.state.rows.push(Row::from_values(some(from)?));
        }
        self.state.extra = vec![0.0; self.state.rows.len() * self.extra().names.len()];
        fill(from, &mut self.state.extra)?;
        fill(from, self.nodes.displacement.as_flattened_mut())?;
        fill(from, self.nodes.velocity.as_flattened_mut())?;
        for group in self.blocks.iter_mut().flat_map(|block| &mut block.groups) {
            take_in(group, from)?;
        }
        sealed.finish()
    }

    /// Back to the state before the first step.
    fn rewind(&mut self) {
        self.state = State::default();
        self.nodes.rest();
        for group in self.blocks.iter_mut().flat_map(|block| &mut block.groups) {
            group.memory.fill(Default::default());
            (group.dissipated, group.hourglass) = (0.0, [0.0; 2]);
        }
    }

    /// Differs between tests with another state or another future: the SHA-256 of all that determines them.
    fn fingerprint(&self) -> [u8; SEAL] {
        let test = &self.test;
        let mut hash = Sha256::new();
        let common = Common { free: None, ..self.common.clone() };
        hash.update(format!("{test:?} {:?} {:?} {common:?}", self.outline, self.scatter));
        self.nodes.mass.iter().for_each(|m| hash.update(m.to_le_bytes()));
        self.blocks.iter().for_each(|block| hash.update(size(block).to_le_bytes()));
        hash.finalize().into()
    }
}

/// Writes bytes and hashes them.
struct HashingWriter<'a> {
    out: &'a mut dyn Write,
    hash: Sha256,
}

impl Write for HashingWriter<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes)?;
        self.hash.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Reads bytes and hashes them.
struct Sealed<'a> {
    from: &'a mut dyn Read,
    hash: Sha256,
}

impl Read for Sealed<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = self.from.read(bytes)?;
        self.hash.update(&bytes[..count]);
        Ok(count)
    }
}

impl Sealed<'_> {
    /// Compares the hash with the file's, which must be its last bytes.
    fn finish(self) -> Result<(), SolveError> {
        let mut rest = Vec::new();
        // One byte more shows a file that goes on.
        let read = self.from.take(SEAL as u64 + 1).read_to_end(&mut rest);
        read.map_err(|error| SolveError::Resume(error.to_string()))?;
        if rest == self.hash.finalize().as_slice() { Ok(()) } else { Err(damaged()) }
    }
}

/// Hashes bytes up to the last 32, which it keeps.
struct HashedEnd {
    hash: Sha256,
    last: Vec<u8>,
}

impl Write for HashedEnd {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.last.extend_from_slice(bytes);
        let old = self.last.len().saturating_sub(SEAL);
        self.hash.update(&self.last[..old]);
        self.last.drain(..old);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Reads mark, version and note; the note is returned.
fn opening(from: &mut dyn Read) -> Result<Vec<u8>, SolveError> {
    let mut mark = [0; 8];
    read(from, &mut mark)?;
    if mark != MARK || word(from)? != VERSION {
        return Err(SolveError::Resume("it is no checkpoint, or one of another version".to_owned()));
    }
    let (length, mut note) = (word(from)?, Vec::new());
    // A damaged length asks for no memory: the file limits it.
    from.take(length).read_to_end(&mut note).map_err(|error| SolveError::Resume(error.to_string()))?;
    Ok(note)
}

fn damaged() -> SolveError {
    SolveError::Resume(DAMAGED.to_owned())
}

fn size(block: &Block) -> u64 {
    block.groups.iter().map(|group| (group.memory.len() * 8 + group.phase.index()) as u64).sum()
}

/// Reads the state of a group's elements.
fn take_in(group: &mut Group, from: &mut dyn Read) -> Result<(), SolveError> {
    let mut sums = [0.0; 3];
    fill(from, &mut sums)?;
    let [dissipated, stored, lost] = sums;
    (group.dissipated, group.hourglass) = (dissipated, [stored, lost]);
    for eight in &mut group.memory {
        let mut bytes = [0; 4 * LANES];
        read(from, &mut bytes)?;
        for (x, bytes) in eight.0.iter_mut().zip(bytes.as_chunks().0) {
            *x = f32::from_le_bytes(*bytes);
        }
    }
    Ok(())
}

fn words(out: &mut impl Write, words: &[u64]) -> io::Result<()> {
    words.iter().try_for_each(|word| out.write_all(&word.to_le_bytes()))
}

fn numbers(out: &mut impl Write, numbers: &[f64]) -> io::Result<()> {
    numbers.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))
}

fn read(from: &mut dyn Read, bytes: &mut [u8]) -> Result<(), SolveError> {
    from.read_exact(bytes).map_err(|error| match error.kind() {
        io::ErrorKind::UnexpectedEof => damaged(),
        _ => SolveError::Resume(error.to_string()),
    })
}

fn word(from: &mut dyn Read) -> Result<u64, SolveError> {
    let mut bytes = [0; 8];
    read(from, &mut bytes)?;
    Ok(u64::from_le_bytes(bytes))
}

fn some<const N: usize>(from: &mut dyn Read) -> Result<[f64; N], SolveError> {
    let mut numbers = [0.0; N];
    fill(from, &mut numbers)?;
    Ok(numbers)
}

fn fill(from: &mut dyn Read, numbers: &mut [f64]) -> Result<(), SolveError> {
    for x in numbers {
        *x = f64::from_bits(word(from)?);
    }
    Ok(())
}
