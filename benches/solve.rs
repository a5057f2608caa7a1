//! Nanoseconds that an element and a step take, bytes that an element takes, and what a second thread buys.
//!
//! `cargo bench -p meso-bench --bench solve -- [SIDE_MM [ELEMENT_SIZE_MM]]` takes a cube of 50 mm with elements of 2 mm when nothing is
//! given, with `--quick` one turn of a cube of 24 mm, and writes `benches/results/solve.csv`. Times are processor seconds of one thread, medians over turns that the
//! cases take one after the other; the gain of two threads is in wall-clock time, which means something on a quiet machine
//! alone.
//!
//! Then criterion takes the cases of one instruction set, and compares with its run before.

#![allow(clippy::print_stdout, reason = "a bench reports on stdout")]

#[allow(dead_code, unreachable_pub, reason = "other benches compare")]
#[path = "collision/clock.rs"]
mod clock;
#[path = "collision/specimen.rs"]
mod specimen;
#[path = "collision/table.rs"]
mod table;

use criterion::{BenchmarkId, Criterion, Throughput};
use meso_core::materials::Materials;
use meso_core::mesh::{self, ItzForm, Mesh, MeshOptions, Method, Tools};
use meso_core::specimen::Specimen;
use meso_core::watch::Stage;
use meso_core::{Model, Silent, Watch};
use meso_solve::{Geometry, InstructionSet, LawName, Run, Sample, Smoothing, Test};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};
use table::Table;

const HEADER: &str = "case,law,instruction_set,elements,cohesive_faces,ns_per_element_step,bytes_per_element,\
                      two_threads_gain";
/// Steps of a turn, and turns.
const STEPS: u64 = 40;
const TURNS: usize = 7;
/// Steps that a run is good for once it is ready.
const STEPS_LEFT: u32 = 350;

/// A test that is measured.
struct Case<'a> {
    name: &'static str,
    mesh: &'a Meshed,
    law: LawName,
    smoothing: Smoothing,
    /// Share of the test that is over when the clock starts.
    from: f64,
    set: InstructionSet,
}

struct Meshed {
    mesh: Mesh,
    options: MeshOptions,
    specimen: Specimen,
}

impl Meshed {
    fn of(model: &Model, method: Method, size: f64, itz: ItzForm) -> Self {
        let options = MeshOptions { method, element_size_mm: size, itz, ..Default::default() };
        let mesh = mesh::build(model, &options, &Tools::default()).expect("a mesh");
        Self { mesh, options, specimen: model.spec.specimen.clone() }
    }
}

/// Lets a run go on by so many rows, of one step each or more.
struct Rows(AtomicU64);

impl Watch for Rows {
    fn stage(&self, _: Stage, _: f64) {
        self.0.fetch_sub(1, Relaxed);
    }

    fn stops(&self) -> bool {
        self.0.load(Relaxed) == 0
    }
}

fn go(run: &mut Run, steps: u64) {
    run.to_end(&Rows(AtomicU64::new(steps)), &Silent);
}

/// A run that has come to where it is measured; every step is a row.
fn ready<'a>(case: &Case<'a>) -> Run<'a> {
    let Meshed { mesh, options, specimen } = case.mesh;
    let mut materials = Materials::default();
    materials.mortar_strength.crushing_energy_n_per_mm = Some(0.5);
    materials.plasticity.meridian_ratio = 0.8;
    // Few steps, so that softening is soon there: what a step costs does not hang on its length.
    let steps = 1000.0;
    let (law, smoothing) = (case.law, Some(case.smoothing));
    let test = Test { law, smoothing, rows: 1_000_000, ..Test::default() };
    let duration = test.duration_s(&Geometry::of(specimen));
    let test = Test { time_step_s: Some(duration / steps), ..test };
    let run = Run::new(Sample::of(mesh, specimen, options), &materials, &test).expect("a test");
    let mut run = run.with_instructions(case.set);
    go(&mut run, 1 + (case.from * steps) as u64);
    run
}

/// Processor seconds of [`STEPS`] steps.
fn turn(run: &mut Run) -> f64 {
    let start = clock::seconds();
    go(run, STEPS);
    clock::seconds() - start
}

fn main() {
    let (model, size) = specimen::asked(table::quick());
    let lattice = Meshed::of(&model, Method::FITTED, size, ItzForm::None);
    let voxels = Meshed::of(&model, Method::VOXEL, size / 1.25, ItzForm::None);
    let cohesive = Meshed::of(&model, Method::FITTED, size, ItzForm::Cohesive);
    let best = InstructionSet::best();
    let case = |name, mesh, law, from, set| Case { name, mesh, law, smoothing: Smoothing::None, from, set };
    let smoothed = |law, from, set| {
        let name = if from > 0.0 { "C3D4 smoothed softening" } else { "C3D4 smoothed elastic" };
        Case { smoothing: Smoothing::Edges, ..case(name, &lattice, law, from, set) }
    };
    let mut cases = Vec::new();
    for set in InstructionSet::available() {
        cases.push(case("C3D4 elastic", &lattice, LawName::Elastic, 0.0, set));
        cases.push(case("C3D4 softening", &lattice, LawName::Cdp, 0.6, set));
        cases.push(case("C3D4 softening", &lattice, LawName::Cdpm2, 0.6, set));
        cases.push(case("C3D4 softening", &lattice, LawName::Meso, 0.6, set));
        cases.push(smoothed(LawName::Elastic, 0.0, set));
        cases.push(smoothed(LawName::Cdp, 0.6, set));
        cases.push(smoothed(LawName::Meso, 0.6, set));
    }
    cases.push(case("C3D8R elastic", &voxels, LawName::Elastic, 0.0, best));
    cases.push(case("C3D8R softening", &voxels, LawName::Cdp, 0.6, best));
    cases.push(case("C3D4 softening, cohesive ITZ", &cohesive, LawName::Cdp, 0.6, best));
    measure(&cases);
    let mut criterion = Criterion::default().sample_size(10).measurement_time(Duration::from_secs(2));
    cases.iter().filter(|case| case.set == best).for_each(|case| sample(case, &mut criterion));
    criterion.final_summary();
}

/// One step under criterion.
fn sample(case: &Case, criterion: &mut Criterion) {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let mut group = criterion.benchmark_group("step");
    group.throughput(Throughput::Elements(case.mesh.mesh.cell_count() as u64));
    let name = BenchmarkId::new(case.name, format!("{:?}", case.law).to_lowercase());
    let begin = || one.install(|| ready(case));
    let (mut run, mut left) = (begin(), STEPS_LEFT);
    let mut step = || {
        if left == 0 {
            (run, left) = (begin(), STEPS_LEFT);
        }
        left -= 1;
        let start = Instant::now();
        one.install(|| go(&mut run, 1));
        start.elapsed()
    };
    group.bench_function(name, |bencher| bencher.iter_custom(|count| (0..count).map(|_| step()).sum()));
    group.finish();
}

fn measure(cases: &[Case]) {
    let threads = |count| rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("threads");
    let (one, two) = (threads(1), threads(2));
    let mut runs: Vec<Run> = one.install(|| cases.iter().map(ready).collect());
    let mut times = vec![Vec::new(); cases.len()];
    for _ in 0..table::count(TURNS, 1) {
        for (run, times) in runs.iter_mut().zip(&mut times) {
            times.push(one.install(|| turn(run)));
        }
    }
    let mut table = Table::new(HEADER);
    println!("{HEADER}");
    for ((case, run), times) in cases.iter().zip(&mut runs).zip(&mut times) {
        let count = case.mesh.mesh.cell_count();
        let wall = |run: &mut Run| {
            let start = Instant::now();
            go(run, STEPS);
            start.elapsed().as_secs_f64()
        };
        let gain = one.install(|| wall(run)) / two.install(|| wall(run));
        let row = [
            case.name.replace(',', ""),
            format!("{:?}", case.law).to_lowercase(),
            format!("{:?}", case.set).to_lowercase(),
            count.to_string(),
            case.mesh.mesh.cohesive().len().to_string(),
            format!("{:.1}", clock::median(times) * 1e9 / count as f64 / STEPS as f64),
            format!("{:.1}", run.bytes() as f64 / count as f64),
            format!("{gain:.2}"),
        ];
        println!("{}", row.join(","));
        table.row(&row);
    }
    table.save("solve.csv");
}
