//! A checkpoint gives the bytes of a test that was never cut, or it is refused.
//!
//! Cases `checkpoint.py`: 35 of 40 flipped bits gave another curve without a word, one test never ended.

use crate::determinism::{cases, fast, rows};
use crate::samples::{Meshed, brittle, concrete};
use meso_core::mesh::{ItzForm, Method};
use meso_core::watch::{Silent, Stage, Watch};
use meso_solve::{Along, Gauge, Observer, Run, Test, TestKind, checkpoint_note};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

const NOTE: &[u8] = b"two frames";

/// Asks for the state at row 40, keeps it and stops at row 50.
#[derive(Default)]
pub(crate) struct Killed {
    rows: AtomicUsize,
    state: Mutex<Vec<u8>>,
}

impl Killed {
    pub(crate) fn state(&self) -> Vec<u8> {
        self.state.lock().unwrap().clone()
    }
}

impl Watch for Killed {
    fn stage(&self, _: Stage, _: f64) {
        self.rows.fetch_add(1, Ordering::Relaxed);
    }

    fn stops(&self) -> bool {
        self.rows.load(Ordering::Relaxed) == 50
    }
}

impl Observer for Killed {
    fn keeps(&self) -> bool {
        self.rows.load(Ordering::Relaxed) == 40
    }

    fn keep(&self, run: &Run) {
        run.save(NOTE, &mut *self.state.lock().unwrap()).unwrap();
    }
}

#[test]
fn a_resumed_test_gives_the_bytes_of_one_that_was_never_cut() {
    // Bars, rates and a momentum, whose sum begins at the row before.
    let part = Gauge::Part { name: "part".to_owned(), axis: Along::Z, from_mm: 2.0, to_mm: 6.0 };
    let fast = Test {
        kind: TestKind::Hopkinson,
        rate_effect: true,
        gauges: vec![part],
        rows: 100,
        speed_m_per_s: Some(3.0),
        pulse_s: Some(3e-4),
        ..Test::default()
    };
    let fast = (concrete(1.0, Method::FITTED, 3.0, ItzForm::Smeared), fast);
    for (meshed, test) in cases().into_iter().chain([fast]) {
        let whole = meshed.solve(&brittle(), &test);
        let killed = Killed::default();
        let part = meshed.watched(&brittle(), &test, &killed, &killed);
        assert_eq!((part.curve.len(), &part.curve[..]), (50, &whole.curve[..50]));
        let mut run = Run::new(meshed.sample(), &brittle(), &test).unwrap();
        run.resume(&mut &killed.state.lock().unwrap()[..]).unwrap();
        let resumed = run.to_end(&Silent, &Silent);
        assert!(rows(&whole) == rows(&resumed) && whole.extra.values == resumed.extra.values);
        assert_eq!(whole.result.phases, resumed.result.phases);
    }
}

/// A checkpoint of the first case.
fn checkpoint() -> (Meshed, Vec<u8>) {
    let [(meshed, test), ..] = cases();
    let killed = Killed::default();
    meshed.watched(&brittle(), &test, &killed, &killed);
    (meshed, killed.state.into_inner().unwrap())
}

#[test]
fn a_checkpoint_returns_its_note_and_serves_its_own_test_alone() {
    let (meshed, state) = checkpoint();
    assert_eq!(checkpoint_note(&mut &state[..]).unwrap(), NOTE);
    let other = Test { friction: Some(0.2), ..fast() };
    let mut run = Run::new(meshed.sample(), &brittle(), &other).unwrap();
    let error = run.resume(&mut &state[..]).unwrap_err().to_string();
    assert!(error.contains("another mesh, other materials or another test"), "{error}");
    // A refused state leaves no trace.
    let mut run = Run::new(meshed.sample(), &brittle(), &fast()).unwrap();
    assert!(run.resume(&mut &state[..state.len() - 100]).is_err());
    assert!(rows(&run.to_end(&Silent, &Silent)) == rows(&meshed.solve(&brittle(), &fast())));
}

#[test]
fn a_checkpoint_with_one_flipped_bit_is_refused() {
    let (meshed, mut state) = checkpoint();
    let mut run = Run::new(meshed.sample(), &brittle(), &fast()).unwrap();
    // Every bit of the first 250 bytes, so of mark, version, note and counts; and 500 over the whole file.
    let spread = (0..500_u64).map(|i| (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 8) as usize % (8 * state.len()));
    let bits: Vec<usize> = (0..2000).chain(spread).collect();
    for bit in bits {
        state[bit / 8] ^= 1 << (bit % 8);
        assert!(checkpoint_note(&mut &state[..]).is_err(), "bit {bit}");
        assert!(bit % 4 != 0 || run.resume(&mut &state[..]).is_err(), "bit {bit}");
        state[bit / 8] ^= 1 << (bit % 8);
    }
    run.resume(&mut &state[..]).unwrap();
}

#[test]
fn a_checkpoint_that_is_cut_continued_or_not_one_is_refused() {
    let (meshed, state) = checkpoint();
    let mut run = Run::new(meshed.sample(), &brittle(), &fast()).unwrap();
    let whole = state.len();
    let cut =
        [0, 1, 7, 8, 16, 24, 34, 66, 200, whole / 2, whole - 33, whole - 32, whole - 1].map(|n| state[..n].to_vec());
    let continued = [1, 32, 1000].map(|n| [&state[..], &vec![b'x'; n]].concat());
    let mut of_before = state.clone();
    of_before[8] = 7;
    let foreign = [b"{\"frames\":[]}\n".to_vec(), vec![0; 4096], of_before, [&state[..], &state[..]].concat()];
    for (i, bytes) in cut.into_iter().chain(continued).chain(foreign).enumerate() {
        let [note, resumed] = [checkpoint_note(&mut &bytes[..]).map(drop), run.resume(&mut &bytes[..])];
        let errors = [note, resumed].map(|result| result.unwrap_err().to_string());
        let is_told = |error: &String| error.contains("cut off or damaged") || error.contains("it is no checkpoint");
        assert!(errors.iter().all(is_told), "{i}: {errors:?}");
    }
}
