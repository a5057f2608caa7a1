//! The whole state of a test as bytes: a test that is resumed gives the same bytes as one that was never cut.
//!
//! Little-endian numbers: a mark and a version, a fingerprint of the test, then the state. The mesh is not in it; whoever
//! resumes builds the same run anew.

use crate::block::{Block, Group};
use crate::error::SolveError;
use crate::lanes::LANES;
use crate::march::curve::Row;
use crate::march::run::{Run, State};
use crate::march::servo::Servo;
use std::io::{self, Read, Write};

const MARK: [u8; 8] = *b"mesosolv";
const VERSION: u64 = 7;

impl Run<'_> {
    /// Writes the state.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut out = io::BufWriter::new(out);
        out.write_all(&MARK)?;
        let state = &self.state;
        words(&mut out, &[VERSION, self.fingerprint(), state.step, state.rows.len() as u64])?;
        let [bottom, top, travel, count] = state.since_row;
        let State { time, progress, held, speed, travel: place, .. } = *state;
        numbers(&mut out, &[time, progress, held, speed, place])?;
        let State { external, internal, friction, kinetic, spent, .. } = *state;
        numbers(&mut out, &[external, internal, friction, kinetic, spent, bottom, top, travel, count])?;
        numbers(&mut out, &state.servo.values())?;
        state.rows.iter().try_for_each(|row| numbers(&mut out, &row.values()))?;
        numbers(&mut out, self.nodes.displacement.as_flattened())?;
        numbers(&mut out, self.nodes.velocity.as_flattened())?;
        for group in self.blocks.iter().flat_map(|block| &block.groups) {
            numbers(&mut out, &[group.dissipated, group.hourglass[0], group.hourglass[1]])?;
            for eight in &group.memory {
                eight.0.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))?;
            }
        }
        words(&mut out, &[self.fingerprint()])?;
        out.flush()
    }

    /// Takes in a state that [`save`](Self::save) wrote for the same mesh, materials and test.
    ///
    /// # Errors
    /// A state of another test, one that was cut short, and those of `from`. The run is then as it was before its first step.
    pub fn resume(&mut self, from: &mut dyn Read) -> Result<(), SolveError> {
        let resumed = self.take_in(&mut io::BufReader::new(from));
        if resumed.is_err() {
            self.rewind();
        }
        resumed
    }

    fn take_in(&mut self, from: &mut dyn Read) -> Result<(), SolveError> {
        let mut mark = [0; 8];
        read(from, &mut mark)?;
        let [version, fingerprint] = [word(from)?, word(from)?];
        if mark != MARK || version != VERSION {
            return Err(SolveError::Resume("it is no checkpoint, or one of another version".to_owned()));
        }
        if fingerprint != self.fingerprint() {
            let why = "it belongs to another mesh, other materials or another test; resume with the same ones";
            return Err(SolveError::Resume(why.to_owned()));
        }
        let (step, rows) = (word(from)?, word(from)?);
        let (mut places, mut sums, mut servo) = ([0.0; 5], [0.0; 9], [0.0; 3]);
        fill(from, &mut places)?;
        fill(from, &mut sums)?;
        fill(from, &mut servo)?;
        let [time, progress, held, speed, travel] = places;
        let [external, internal, friction, kinetic, spent, since_row @ ..] = sums;
        let (servo, rows_so_far) = (Servo::from_values(servo), Vec::new());
        self.state = State {
            step,
            time,
            progress,
            held,
            speed,
            servo,
            travel,
            external,
            internal,
            friction,
            kinetic,
            spent,
            since_row,
            rows: rows_so_far,
        };
        for _ in 0..rows.min(step) {
            let mut values = [0.0; 11];
            fill(from, &mut values)?;
            self.state.rows.push(Row::from_values(values));
        }
        fill(from, self.nodes.displacement.as_flattened_mut())?;
        fill(from, self.nodes.velocity.as_flattened_mut())?;
        for group in self.blocks.iter_mut().flat_map(|block| &mut block.groups) {
            group.take_in(from)?;
        }
        let is_whole = word(from)? == self.fingerprint();
        if is_whole { Ok(()) } else { Err(SolveError::Resume("the file is cut off or damaged".to_owned())) }
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

    /// A number that differs between tests with another state or another future: FNV-1a of all that determines them.
    fn fingerprint(&self) -> u64 {
        let test = crate::test::Test { instruction_set: None, ..self.test.clone() };
        let told = format!("{test:?} {:?} {:?}", self.outline, self.common);
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut take = |byte: u8| hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        told.bytes().for_each(&mut take);
        self.nodes.mass.iter().for_each(|m| m.to_le_bytes().into_iter().for_each(&mut take));
        self.blocks.iter().for_each(|block| size(block).to_le_bytes().into_iter().for_each(&mut take));
        hash
    }
}

fn size(block: &Block) -> u64 {
    block.groups.iter().map(|group| (group.memory.len() * 8 + group.phase as usize) as u64).sum()
}

impl Group {
    fn take_in(&mut self, from: &mut dyn Read) -> Result<(), SolveError> {
        let mut sums = [0.0; 3];
        fill(from, &mut sums)?;
        let [dissipated, stored, lost] = sums;
        (self.dissipated, self.hourglass) = (dissipated, [stored, lost]);
        for eight in &mut self.memory {
            let mut bytes = [0; 4 * LANES];
            read(from, &mut bytes)?;
            for (x, bytes) in eight.0.iter_mut().zip(bytes.as_chunks().0) {
                *x = f32::from_le_bytes(*bytes);
            }
        }
        Ok(())
    }
}

fn words(out: &mut impl Write, words: &[u64]) -> io::Result<()> {
    words.iter().try_for_each(|word| out.write_all(&word.to_le_bytes()))
}

fn numbers(out: &mut impl Write, numbers: &[f64]) -> io::Result<()> {
    numbers.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))
}

fn read(from: &mut dyn Read, bytes: &mut [u8]) -> Result<(), SolveError> {
    from.read_exact(bytes).map_err(|error| SolveError::Resume(error.to_string()))
}

fn word(from: &mut dyn Read) -> Result<u64, SolveError> {
    let mut bytes = [0; 8];
    read(from, &mut bytes)?;
    Ok(u64::from_le_bytes(bytes))
}

fn fill(from: &mut dyn Read, numbers: &mut [f64]) -> Result<(), SolveError> {
    for x in numbers {
        *x = f64::from_bits(word(from)?);
    }
    Ok(())
}
