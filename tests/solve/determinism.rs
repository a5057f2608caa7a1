//! A test gives the same bytes on any number of threads and on every instruction set.

use crate::samples::{Meshed, brittle, concrete, damaged_plasticity};
use meso_core::materials::Materials;
use meso_core::mesh::{ItzForm, Method};
use meso_core::watch::Silent;
use meso_solve::{Frame, InstructionSet, LawName, Observer, Response, Run, Smoothing, Test};
use std::cell::RefCell;

/// Keeps the bytes of all fields of every frame.
#[derive(Default)]
struct Fields(RefCell<Vec<u8>>);

impl Observer for Fields {
    fn frame(&self, frame: &Frame) {
        let mut bytes = self.0.borrow_mut();
        bytes.extend(frame.displacement().as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        let points = frame.cells(|point| *point);
        let stress = points.iter().flat_map(|point| point.stress);
        bytes.extend(stress.chain(points.iter().map(|point| point.damage)).flat_map(f32::to_le_bytes));
    }
}

pub(crate) fn rows(response: &Response) -> Vec<u8> {
    response.curve.iter().flat_map(|row| row.values()).flat_map(f64::to_le_bytes).collect()
}

/// Bytes of the curve and of the fields.
fn bytes(meshed: &Meshed, test: &Test, threads: usize) -> Vec<u8> {
    bytes_by(meshed, test, threads, InstructionSet::best())
}

/// Bytes of the curve and of the fields, by one instruction set.
fn bytes_by(meshed: &Meshed, test: &Test, threads: usize, set: InstructionSet) -> Vec<u8> {
    bytes_of(meshed, &brittle(), test, threads, set)
}

pub(crate) fn bytes_of(
    meshed: &Meshed,
    materials: &Materials,
    test: &Test,
    threads: usize,
    set: InstructionSet,
) -> Vec<u8> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let fields = Fields::default();
        let mut run = Run::new(meshed.sample(), materials, test).unwrap().with_instructions(set);
        let response = run.to_end(&Silent, &fields);
        assert!(response.result.figures.peak_mpa > 1.0 && response.curve.len() > 50, "{:?}", response.result);
        [rows(&response), fields.0.into_inner()].concat()
    })
}

/// Few steps and much strain: the shortest way into softening, physics apart.
pub(crate) fn fast() -> Test {
    Test { duration_s: Some(6e-5), time_step_s: Some(3e-7), rows: 100, frames: 2, ..damaged_plasticity() }
}

pub(crate) fn cases() -> [(Meshed, Test); 4] {
    let plain = Test { smoothing: Some(Smoothing::None), ..fast() };
    [
        (concrete(1.0, Method::FITTED, 3.0, ItzForm::Smeared), fast()),
        (concrete(1.0, Method::FITTED, 3.0, ItzForm::Smeared), plain),
        (concrete(1.0, Method::VOXEL, 1.5, ItzForm::Smeared), fast()),
        (concrete(0.5, Method::FITTED, 3.0, ItzForm::Cohesive), fast()),
    ]
}

#[test]
fn curves_and_fields_are_identical_on_1_2_and_16_threads() {
    for (meshed, test) in cases() {
        let one = bytes(&meshed, &test, 1);
        assert!(one == bytes(&meshed, &test, 2) && one == bytes(&meshed, &test, 16));
    }
}

#[test]
fn curves_and_fields_are_identical_on_every_instruction_set() {
    let sets: Vec<_> = InstructionSet::available().into_iter().filter(|set| *set != InstructionSet::Portable).collect();
    for (meshed, test) in cases() {
        let run = |set| bytes_by(&meshed, &test, 1, set);
        let portable = run(InstructionSet::Portable);
        assert!(sets.iter().all(|&set| portable == run(set)), "{sets:?}");
    }
    let [(lattice, _), ..] = cases();
    for law in [LawName::Cdpm2, LawName::Meso] {
        let test = Test { law, ..fast() };
        let run = |set| bytes_by(&lattice, &test, 1, set);
        let portable = run(InstructionSet::Portable);
        assert!(sets.iter().all(|&set| portable == run(set)), "{law:?} {sets:?}");
    }
}

/// A function without `#[inline(always)]` is compiled for every machine: its registers' instructions are then calls. Frames
/// took as long as 135 steps so. Only constructors, which fill registers, may call one.
#[test]
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
fn no_instruction_of_the_kernels_is_a_call() {
    let program = std::fs::read(std::env::current_exe().unwrap()).unwrap();
    // Put together here, so that the test's own text is no match.
    let prefix = ["_mm", "256_"].concat();
    let names = program.split(|byte| !(byte.is_ascii_alphanumeric() || *byte == b'_'));
    let names: Vec<&str> = names.filter_map(|name| std::str::from_utf8(name).ok()).collect();
    assert!(names.iter().any(|name| name.contains("on_avx2")), "the program has no symbols");
    let called = names.iter().filter_map(|name| Some(name.split_once(&prefix)?.1));
    let computes = |name: &&str| (name.contains("_ps") || name.contains("_pd")) && !name.starts_with("set");
    let called: Vec<&str> = called.filter(computes).collect();
    assert!(called.is_empty(), "{called:?}");
}
