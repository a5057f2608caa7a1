//! Time, memory and error of every meshing method on the paper's specimen (150 mm, 0.50), by element size.
//!
//! `cargo bench --bench meshing -- METHOD [SIZE]...` measures one of `voxel`, `lattice-plain`, `lattice-fitted` and
//! `conforming` at 4, 3, 2, 1.5 and 1 mm or the sizes given, puts its rows into `benches/results/meshing.csv` in place
//! of those that are there, and draws `meshing.svg` anew; without a method all but `conforming`, which takes the longest.
//! `--quick` takes 8 mm.
//!
//! Each case runs in a process of its own, without an ITZ. Times are CPU seconds of all threads, memory is the peak of
//! the process and, apart, of gmsh, as Linux counts them. A conforming mesh needs room between the grains: its packing
//! has gaps of 0.05 mm or more.

#![allow(clippy::print_stdout, reason = "a bench reports on stdout")]

#[path = "collision/plot.rs"]
mod plot;
#[path = "collision/table.rs"]
mod table;

use meso_core::export::abaqus::{self, DeckOptions};
use meso_core::mesh::{
    self, InterfaceDistance, ItzForm, Mesh, MeshOptions, Method, PhaseVolumes, Tools, VolumeMesher, figures,
};
use meso_core::{Model, Silent, Spec, pack, saved};
use meso_gmsh::Gmsh;
use plot::{Line, Plot};
use std::path::Path;
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};
use table::Table;

const METHODS: [&str; 4] = ["voxel", "lattice-plain", "lattice-fitted", "conforming"];
const SIZES_MM: [f64; 5] = [4.0, 3.0, 2.0, 1.5, 1.0];
const HEADER: &str = "method,element_size_mm,grains,elements,nodes,wall_s,cpu_s,gmsh_wall_s,deck_s,peak_mb,gmsh_peak_mb,\
                      aggregate_volume_error_percent,interface_nodes,interface_off,interface_max_mm,interface_rms_mm,\
                      joined_nodes,joined_max_mm,joined_rms_mm,smallest_dihedral_deg,below_8_deg";

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    if let [word, method, size, model] = &words[..]
        && word == "--case"
    {
        return case(method, size.parse().expect("a size"), Path::new(model));
    }
    let methods: Vec<&str> = METHODS.into_iter().filter(|method| words.iter().any(|word| word == method)).collect();
    let methods = if methods.is_empty() { METHODS[..3].to_vec() } else { methods };
    let sizes: Vec<f64> = words.iter().filter_map(|word| word.parse().ok()).collect();
    let usual = if table::quick() { vec![8.0] } else { SIZES_MM.to_vec() };
    let sizes = if sizes.is_empty() { usual } else { sizes };
    println!("{HEADER}");
    for method in methods {
        measure(method, &sizes);
    }
}

/// Runs the cases of one method and enters each as it ends.
fn measure(method: &str, sizes: &[f64]) {
    let model = std::env::temp_dir().join(format!("mesocrete-meshing-{}.json", std::process::id()));
    save(&packed(if method == "conforming" { 0.05 } else { 0.0 }), &model);
    for size in sizes {
        let mut command = Command::new(std::env::current_exe().expect("a bench has a path"));
        let output = command.args(["--case", method, &size.to_string()]).arg(&model).output();
        let output = output.expect("the bench can start itself");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let row = String::from_utf8(output.stdout).expect("a row is text").trim().to_owned();
        println!("{row}");
        enter(row);
    }
    std::fs::remove_file(&model).expect("the model is ours");
}

/// The paper's specimen with gaps of at least `gap_mm`.
fn packed(gap_mm: f64) -> Model {
    let mut spec = Spec { seed: 1, ..Spec::default() };
    (spec.placement.min_gap_mm, spec.placement.wall_gap_mm) = (gap_mm, gap_mm);
    pack(&spec, &Silent).expect("the spec is valid")
}

fn save(model: &Model, path: &Path) {
    let file = std::fs::File::create(path).expect("a temporary file");
    saved::write(model, std::io::BufWriter::new(file)).expect("room for the model");
}

/// Puts a row in place of the one of its method and size, and draws all.
fn enter(row: String) {
    let cells = |row: &str| row.split(',').map(String::from).collect::<Vec<_>>();
    let text = std::fs::read_to_string(table::folder().join("meshing.csv")).unwrap_or_default();
    let mut table = Table::new(HEADER);
    // Rows of other columns are of an older bench.
    let is_same = text.lines().next() == Some(&Table::header(HEADER));
    let old = if is_same { text.lines().skip(1).collect() } else { Vec::new() };
    let mut rows: Vec<Vec<String>> = old.into_iter().map(cells).collect();
    let new = cells(&table.stamped(&row));
    rows.retain(|row| row[..2] != new[..2]);
    rows.push(new);
    let place = |row: &[String]| METHODS.iter().position(|method| *method == row[0]);
    rows.sort_by(|a, b| place(a).cmp(&place(b)).then(number(&b[1]).total_cmp(&number(&a[1]))));
    rows.iter().for_each(|row| table.keep(&row.join(",")));
    table.save("meshing.csv");
    draw(&rows);
}

/// Time against error: volume and interface, one line per method and measure.
fn draw(rows: &[Vec<String>]) {
    let line = |method: &str, column: usize, floor: f64| -> Line {
        let of = rows.iter().filter(|row| row[0] == method);
        // A logarithm has no zero.
        (method.to_owned(), of.map(|row| (number(&row[6]), number(&row[column]).abs().max(floor))).collect())
    };
    for (name, title, y, column, floor) in [
        ("meshing_volume.svg", "error of the aggregates' volume", "error, % (0.001 and less as 0.001)", 11, 1e-3),
        (
            "meshing_interface.svg",
            "distance of interface nodes",
            "distance, mm rms (0.0001 and less as 0.0001)",
            15,
            1e-4,
        ),
    ] {
        let lines: Vec<Line> = METHODS.iter().map(|method| line(method, column, floor)).collect();
        let lines: Vec<Line> = lines.into_iter().filter(|line| !line.1.is_empty()).collect();
        let title = format!("150 mm cube at 0.50, 4 to 1 mm: {title} against CPU time");
        let plot = Plot { title: &title, x: "CPU time, s", y, log_x: true, log_y: true, lines: &lines };
        table::save(name, &plot.svg());
    }
}

fn number(cell: &str) -> f64 {
    cell.parse().unwrap_or(f64::NAN)
}

/// Meshes and prints the row.
fn case(method: &str, element_size_mm: f64, path: &Path) {
    let model = saved::read(&std::fs::read(path).expect("the model")).expect("a model");
    let (start, before) = (Instant::now(), cpu_seconds());
    let (mesh, outside) = build(&model, method, element_size_mm);
    let (wall, cpu, peak) = (start.elapsed().as_secs_f64(), cpu_seconds() - before, peak_mb("self"));
    let start = Instant::now();
    abaqus::write(&mesh, &DeckOptions::default(), std::io::sink()).expect("nothing stands in a sink's way");
    let deck = start.elapsed().as_secs_f64();
    let measured = errors(&mesh, &model);
    let (wall_gmsh, peak_gmsh) =
        outside.map_or_else(Default::default, |(s, mb)| (format!("{s:.1}"), format!("{mb:.0}")));
    println!(
        "{method},{element_size_mm},{},{},{},{wall:.1},{cpu:.1},{wall_gmsh},{deck:.1},{peak:.0},{peak_gmsh},{measured}",
        model.aggregates.len(),
        mesh.cell_count(),
        mesh.points.len(),
    );
}

/// The mesh, and where gmsh has run, the wall-clock seconds of its runs, one after the other or at once, and the largest
/// one's peak memory, MB.
fn build(model: &Model, method: &str, element_size_mm: f64) -> (Mesh, Option<(f64, f64)>) {
    let method = match method {
        "voxel" => Method::VOXEL,
        "lattice-plain" => Method::PLAIN,
        "lattice-fitted" => Method::FITTED,
        _ => Method::CONFORMING,
    };
    let options = MeshOptions { method, element_size_mm, itz: ItzForm::None, ..Default::default() };
    let outside = Mutex::new(None);
    let gmsh = |surfaces: &mesh::conforming::Surfaces| {
        let start = Instant::now();
        let (output, peak) = watched(|| Gmsh::program("gmsh").fill(surfaces));
        let mut outside = outside.lock().expect("no run has panicked");
        let (seconds, peak_before) = outside.unwrap_or((0.0, 0.0));
        *outside = Some((seconds + start.elapsed().as_secs_f64(), peak.max(peak_before)));
        output
    };
    let mesh =
        mesh::build(model, &options, &Tools { gmsh: &gmsh, ..Tools::default() }).expect("the specimen can be meshed");
    (mesh, outside.into_inner().expect("no run has panicked"))
}

/// Runs `work`; the peak memory of the processes it starts, MB.
fn watched<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let (done, peak) = (AtomicBool::new(false), AtomicU64::new(0));
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !done.load(Ordering::Relaxed) {
                for child in children() {
                    peak.fetch_max(peak_mb(&child) as u64, Ordering::Relaxed);
                }
                std::thread::sleep(Duration::from_millis(20));
            }
        });
        let result = work();
        done.store(true, Ordering::Relaxed);
        (result, peak.load(Ordering::Relaxed) as f64)
    })
}

/// Process ids of what this process' threads started.
fn children() -> Vec<String> {
    let threads = std::fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let lists = threads.filter_map(|thread| std::fs::read_to_string(thread.path().join("children")).ok());
    lists.flat_map(|list| list.split_whitespace().map(String::from).collect::<Vec<_>>()).collect()
}

/// The row's columns of errors and angles.
fn errors(mesh: &Mesh, model: &Model) -> String {
    let exact = PhaseVolumes::exact(&model.aggregates, &model.spec.specimen, |_| 0.0).expect("grains have volumes");
    let volume = 100.0 * (PhaseVolumes::of_mesh(mesh).aggregate / exact.aggregate - 1.0);
    let distance = InterfaceDistance::of(mesh, &model.aggregates, &model.spec.specimen);
    let cells = figures::CellQuality::of_cells(mesh);
    let worst = cells.iter().map(|cell| cell.min_dihedral_deg).fold(f64::INFINITY, f64::min);
    let bad = figures::CellQuality::below(&cells, 8.0).len();
    let interface = format!("{},{},{:.4},{:.5}", distance.nodes, distance.off, distance.max_mm, distance.rms_mm);
    let joined = format!("{},{:.4},{:.5}", distance.joined, distance.joined_max_mm, distance.joined_rms_mm);
    format!("{volume:.4},{interface},{joined},{worst:.2},{bad}")
}

/// User and system time of this process and of those it waited for: fields 14 to 17 of /proc/self/stat, in hundredths.
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = stat.rsplit_once(')').map_or("", |parts| parts.1).split_whitespace();
    fields.skip(11).take(4).map(number).sum::<f64>() / 100.0
}

/// Peak resident memory of a process, MB.
fn peak_mb(process: &str) -> f64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM"));
    line.and_then(|line| line.split_whitespace().nth(1)).map_or(0.0, |kb| number(kb) / 1000.0)
}
