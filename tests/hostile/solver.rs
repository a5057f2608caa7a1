//! Promises for any bytes of a checkpoint and any text of a TEST.toml: nothing panics, and a test that is taken has a curve.

use meso_core::materials::Materials;
use meso_core::mesh::{self, ItzForm, Mesh, MeshOptions, Method, Tools};
use meso_core::spec::options_from_toml;
use meso_core::specimen::Specimen;
use meso_core::watch::{Silent, Stage, Watch};
use meso_solve::{Observer, Run, Sample, SolveError, Test, TestKind, checkpoint_note};
use sha2::{Digest, Sha256};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

/// A cube of mortar in eight boxes.
struct Tiny {
    specimen: Specimen,
    options: MeshOptions,
    mesh: Mesh,
}

impl Tiny {
    fn get() -> &'static Self {
        static TINY: OnceLock<Tiny> = OnceLock::new();
        TINY.get_or_init(|| {
            let specimen = Specimen::cube(20.0);
            let method = Method::VOXEL;
            let options = MeshOptions { method, element_size_mm: 10.0, itz: ItzForm::None, ..MeshOptions::default() };
            let mesh = mesh::build((&[], &specimen), &options, &Tools::default()).expect("a cube of boxes");
            Self { specimen, options, mesh }
        })
    }

    fn run(&self, test: &Test) -> Result<Run<'_>, SolveError> {
        Run::new(Sample::of(&self.mesh, &self.specimen, &self.options), &Materials::default(), test)
    }
}

/// Stops a test after some rows or steps, and keeps the state of a row.
#[derive(Default)]
struct Short {
    row: AtomicU32,
    step: AtomicU32,
    state: std::sync::Mutex<Vec<u8>>,
}

impl Watch for Short {
    fn stage(&self, _: Stage, _: f64) {
        self.row.fetch_add(1, Ordering::Relaxed);
    }

    fn stops(&self) -> bool {
        self.step.fetch_add(1, Ordering::Relaxed) > 2000 || self.row.load(Ordering::Relaxed) > 12
    }
}

impl Observer for Short {
    fn keeps(&self) -> bool {
        self.row.load(Ordering::Relaxed) == 2
    }

    fn keep(&self, run: &Run) {
        let mut state = self.state.lock().expect("nothing panics");
        run.save(NOTE, &mut *state).expect("memory takes all");
    }
}

const NOTE: &[u8] = b"{\"frames\":[],\"taken\":{}}";

/// A test with turns, gauges and a lead: its checkpoint has every kind of number.
fn long() -> Test {
    Test { kind: TestKind::Cyclic, duration_s: Some(1e-3), rows: 40, ..Test::default() }
}

/// The bytes of a good checkpoint without its hash.
fn good() -> &'static [u8] {
    static GOOD: OnceLock<Vec<u8>> = OnceLock::new();
    GOOD.get_or_init(|| {
        let short = Short::default();
        Tiny::get().run(&long()).expect("a good test").to_end(&short, &short);
        let mut state = short.state.into_inner().expect("nothing panics");
        state.truncate(state.len().checked_sub(32).expect("a state was kept"));
        state
    })
}

/// Bytes of a checkpoint as they come, and a good checkpoint that they change, with a hash that is right.
///
/// Four bytes are a change: an operation, a place and a value.
pub(crate) fn checkpoint(bytes: &[u8]) {
    let _ = checkpoint_note(&mut &bytes[..]);
    take_in(bytes);
    let mut state = good().to_vec();
    for change in bytes.as_chunks::<4>().0.iter().take(64) {
        edit(&mut state, *change);
    }
    take_in(&state);
}

/// Changes a byte, a number, or the length.
fn edit(state: &mut Vec<u8>, [operation, low, high, value]: [u8; 4]) {
    if state.is_empty() {
        return;
    }
    let at = usize::from(u16::from_le_bytes([low, high])) % state.len();
    let numbers = [f64::NAN, f64::INFINITY, -1.0, 1e300, -1e300, 1e-310, 0.0, 4e9];
    let number = numbers[usize::from(value) % numbers.len()].to_le_bytes();
    match operation % 5 {
        0 => state[at] = value,
        1 => state[at] ^= 1 << (value % 8),
        2 => state.iter_mut().skip(at / 8 * 8).zip(number).for_each(|(byte, new)| *byte = new),
        3 if value < 8 => state.truncate(at),
        _ => drop(state.splice(at..at, number.into_iter().take(usize::from(value % 9)))),
    }
}

/// A state with the right hash is refused, and then the run is as before its first step; or what the run saves of it is taken
/// in again byte for byte, and the run goes on without a panic.
fn take_in(state: &[u8]) {
    let sealed = [state, &Sha256::digest(state)[..]].concat();
    let mut run = Tiny::get().run(&long()).expect("a good test");
    let begun = saved(&run, NOTE);
    match run.resume(&mut &sealed[..]) {
        Err(error) => {
            assert!(!error.to_string().is_empty());
            assert!(saved(&run, NOTE) == begun, "a refused state leaves no trace");
        }
        Ok(()) => {
            let note = checkpoint_note(&mut &sealed[..]).expect("what is resumed has a note");
            let kept = saved(&run, &note);
            let mut again = Tiny::get().run(&long()).expect("a good test");
            again.resume(&mut &kept[..]).expect("what is saved is taken in");
            assert!(saved(&again, &note) == kept, "what is taken in is what was saved");
            run.to_end(&Short::default(), &Silent);
        }
    }
}

fn saved(run: &Run, note: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    run.save(note, &mut bytes).expect("memory takes all");
    bytes
}

/// A TEST.toml is refused with a message, or its test begins, and each row of the curve has all further columns.
pub(crate) fn test_file(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let test = match options_from_toml::<Test>(text) {
        Ok(test) => test,
        Err(error) => return assert!(!error.to_string().trim().is_empty()),
    };
    if meso_solve::validate(&Materials::default(), &test).is_err() {
        return;
    }
    let cylinder = Specimen::Cylinder { diameter_mm: 20.0, height_mm: 40.0 };
    for specimen in [Specimen::cube(20.0), cylinder] {
        if let Err(error) = test.suits(&specimen) {
            assert!(!error.to_string().trim().is_empty());
        }
    }
    // Rows that are many take memory, and frames take nothing here.
    let Ok(mut run) = Tiny::get().run(&test) else { return };
    let response = run.to_end(&Short::default(), &Silent);
    let extra = &response.extra;
    assert_eq!(extra.values.len(), extra.names.len() * response.curve.len());
}
