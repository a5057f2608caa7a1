//! The paper's Table 2, the curve of fraction against time, and the time per grain against their number, each case in a
//! process of its own.
//!
//! `cargo bench --bench packing` writes `packing.csv`, `packing.svg` and `packing_scale.csv` in `benches/results/`; with
//! `-- --quick` takes the cheapest case of each, `-- --scale` the last alone, up to a million grains (an hour). Times are CPU seconds, memory is the peak of the whole
//! process, both as Linux counts them; elsewhere those columns stay empty.

#![allow(clippy::print_stdout, reason = "a bench reports on stdout")]

#[path = "collision/plot.rs"]
mod plot;
#[path = "collision/table.rs"]
mod table;

use meso_core::packing::{Placement, Strategy};
use meso_core::specimen::{Periodic, Specimen};
use meso_core::watch::Silent;
use meso_core::{Spec, pack};
use plot::{Line, Plot};
use std::process::Command;
use table::Table;

/// One packing of the paper's specimen.
struct Case {
    strategy: Strategy,
    attempts: Option<u32>,
    fraction: f64,
}

/// What is known beside our own figures: (name, fraction, seconds).
const OTHERS: [(&str, f64, f64); 2] = [("the paper (claimed)", 0.50, 1080.0), ("PyCMG", 0.40, 217.0)];
const SEEDS: [u64; 3] = [1, 2, 3];

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(at) = arguments.iter().position(|argument| argument == "--case") {
        return run(&arguments[at + 1..]);
    }
    let full = arguments.iter().any(|argument| argument == "--scale");
    if !full {
        fractions();
    }
    scale(if full { &SIDES } else { &SIDES[..table::count(3, 1)] });
}

/// Fraction against time.
fn fractions() {
    let mut table = Table::new(HEADER);
    println!("{HEADER}");
    let mut lines: Vec<Line> = Vec::new();
    for (name, cases) in cases() {
        lines.push((name, cases.iter().map(|case| measure(case, &mut table)).collect()));
    }
    lines.extend(OTHERS.map(|(name, fraction, seconds)| (name.to_string(), vec![(seconds, fraction)])));
    table.save("packing.csv");
    let plot = Plot {
        title: "150 mm cube, Fuller 5-20 mm: fraction reached against CPU time, one thread",
        x: "CPU time, s",
        y: "aggregate fraction",
        log_x: true,
        log_y: false,
        lines: &lines,
    };
    table::save("packing.svg", &plot.svg());
}

/// Sides of the cubes of the scale table, mm: about 5,000, 51,000, 250,000 and 1,000,000 grains.
const SIDES: [f64; 4] = [110.0, 235.0, 400.0, 635.0];

/// Time per grain at 0.50, by the number of grains and of threads.
fn scale(sides: &[f64]) {
    let header = "side_mm,threads,grains,fraction,sweeps,wall_s,cpu_s,cpu_us_per_grain,peak_mb";
    let mut table = Table::new(header);
    println!("{header}");
    for side in sides {
        for threads in ["1", "2"] {
            let output = Command::new(std::env::current_exe().expect("a bench has a path"))
                .args(["--case", "cube", &side.to_string()])
                .env("RAYON_NUM_THREADS", threads)
                .output()
                .expect("the bench can start itself");
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            let row = String::from_utf8(output.stdout).expect("a row is text");
            let mut cells: Vec<String> = row.trim().split(',').map(String::from).collect();
            cells.insert(1, threads.into());
            println!("{}", cells.join(","));
            table.row(&cells);
        }
    }
    table.save("packing_scale.csv");
}

/// Packs a cube of `side_mm` to 0.50 and prints its row, less the threads.
fn run_cube(side_mm: f64) {
    let start = std::time::Instant::now();
    let spec = Spec { seed: 1, specimen: Specimen::Cube { side_mm, periodic: Periodic::NONE }, ..Spec::default() };
    let report = pack(&spec, &Silent).expect("the spec is valid").report;
    let cpu = cpu_seconds().unwrap_or(f64::NAN);
    println!(
        "{side_mm},{},{:.5},{},{:.1},{cpu:.1},{:.1},{:.0}",
        report.aggregates,
        report.fraction,
        report.work.sweeps,
        start.elapsed().as_secs_f64(),
        1e6 * cpu / report.aggregates as f64,
        peak_megabytes().unwrap_or(f64::NAN),
    );
}

const HEADER: &str =
    "strategy,attempts,target,seed,fraction,aggregates,discarded,worst_class_deviation,stop_reason,cpu_s,peak_mb";

/// The lines of the plot: the paper's rule by its number of attempts, rearrangement by its target.
fn cases() -> Vec<(String, Vec<Case>)> {
    let literal = [10, 100, 1_000, 10_000];
    let dense = [0.40, 0.50, 0.60, 0.65, 0.68, 0.70];
    let literal = literal.map(|n| Case { strategy: Strategy::TakeAndPlace, attempts: Some(n), fraction: 0.5 });
    let dense = dense.map(|fraction| Case { strategy: Strategy::Rearrange, attempts: None, fraction });
    let mut all: Vec<(String, Vec<Case>)> =
        vec![("take-and-place".into(), literal.into()), ("rearrange".into(), dense.into())];
    all.iter_mut().for_each(|(_, cases)| cases.truncate(table::count(cases.len(), 1)));
    all
}

/// Medians over the seeds: (CPU seconds, fraction).
fn measure(case: &Case, table: &mut Table) -> (f64, f64) {
    let seeds = &SEEDS[..table::count(SEEDS.len(), 1)];
    let mut rows: Vec<(f64, f64)> = seeds.iter().map(|&seed| child(case, seed, table)).collect();
    rows.sort_by(|p, q| p.0.total_cmp(&q.0));
    rows[rows.len() / 2]
}

fn child(case: &Case, seed: u64, table: &mut Table) -> (f64, f64) {
    let strategy = if case.strategy == Strategy::Rearrange { "rearrange" } else { "take-and-place" };
    let attempts = case.attempts.map_or(String::from("-"), |n| n.to_string());
    let output = Command::new(std::env::current_exe().expect("a bench has a path"))
        .args(["--case", strategy, &attempts, &case.fraction.to_string(), &seed.to_string()])
        .env("RAYON_NUM_THREADS", "1")
        .output()
        .expect("the bench can start itself");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let row = String::from_utf8(output.stdout).expect("a row is text");
    let cells: Vec<String> = row.trim().split(',').map(String::from).collect();
    println!("{}", row.trim());
    table.row(&cells);
    (cells[9].parse().unwrap_or(f64::NAN), cells[4].parse().expect("a fraction"))
}

/// Packs one case and prints its row: strategy, attempts, fraction and seed, or a cube and its side.
fn run(arguments: &[String]) {
    if let [kind, side, ..] = arguments
        && kind == "cube"
    {
        return run_cube(side.parse().expect("a side"));
    }
    let [strategy, attempts, fraction, seed, ..] = arguments else { panic!("a case has four arguments") };
    let placement = Placement {
        strategy: if strategy == "rearrange" { Strategy::Rearrange } else { Strategy::TakeAndPlace },
        attempts: attempts.parse().ok(),
        ..Placement::default()
    };
    let fraction = fraction.parse().expect("a fraction");
    let spec = Spec { seed: seed.parse().expect("a seed"), fraction, placement, ..Spec::default() };
    let report = pack(&spec, &Silent).expect("the spec is valid").report;
    let deviations = report.classes.iter().map(|class| (class.fraction / class.target_fraction - 1.0).abs());
    println!(
        "{strategy},{attempts},{fraction},{seed},{:.5},{},{},{:.5},{:?},{},{}",
        report.fraction,
        report.aggregates,
        report.discarded,
        deviations.fold(0.0, f64::max),
        report.stop_reason,
        cpu_seconds().map_or(String::new(), |s| format!("{s:.2}")),
        peak_megabytes().map_or(String::new(), |mb| format!("{mb:.1}")),
    );
}

/// User and system time of this process: fields 14 and 15 of /proc/self/stat, in hundredths of a second.
fn cpu_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    Some((fields[11].parse::<f64>().ok()? + fields[12].parse::<f64>().ok()?) / 100.0)
}

fn peak_megabytes() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1000.0)
}
