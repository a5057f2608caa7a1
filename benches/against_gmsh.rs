//! What a conforming mesh costs against gmsh alone: CPU seconds of everything, slabs and mending included, over those of gmsh
//! in one run on the surfaces of the same packing.
//!
//! `cargo bench --bench against_gmsh -- [SIDE_MM [ELEMENT_SIZE_MM [TURNS]]]` takes a cube at 0.50 with gaps of 0.05 mm, of 60 mm
//! and 2 mm elements when nothing is given (the paper's specimen has 150 mm and takes half an hour a turn), and puts its row
//! into `benches/results/against_gmsh.csv` in place of the one that is there. `gmsh` is the one on the PATH.
//!
//! Both meshes are made in turns, twice when nothing is given, in processes of their own, and the lesser times count: what else
//! the machine does adds to all of them.
//! `--quick` takes small cases.

#![allow(clippy::print_stdout, reason = "a bench reports on stdout")]

#[path = "collision/rows.rs"]
mod rows;
#[path = "collision/table.rs"]
mod table;

use meso_core::mesh::{self, ItzForm, MeshOptions, Method, Order, Tools, figures};
use meso_core::specimen::Specimen;
use meso_core::{Silent, Spec, pack};
use meso_gmsh::Gmsh;
use rows::{enter, number};
use std::process::Command;
use table::count;

const HEADER: &str = "side_mm,element_size_mm,grains,elements,cpu_s,own_cpu_s,gmsh_cpu_s,gmsh_alone_cpu_s,ratio,own_share_percent,\
                      smallest_dihedral_deg,below_1_deg,below_8_deg,shortest_altitude_mm";

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench" && word != "--quick").collect();
    if let [word, slabs, side, size] = &words[..]
        && word == "--case"
    {
        return case(slabs.parse().ok(), number(side), number(size));
    }
    let [side, size, turns] = [
        (0, if table::quick() { 30.0 } else { 60.0 }),
        (1, if table::quick() { 4.0 } else { 2.0 }),
        (2, count(2, 1) as f64),
    ]
    .map(|(i, usual)| words.get(i).map_or(usual, |word| number(word)));
    let run = |slabs: &str| {
        let mut command = Command::new(std::env::current_exe().expect("a bench has a path"));
        let output = command.args(["--case", slabs, &side.to_string(), &size.to_string()]).output();
        let output = output.expect("the bench can start itself");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("a row is text").trim().split(',').map(String::from).collect()
    };
    // By what was asked for: own and gmsh's CPU seconds come first.
    let turns: Vec<[Vec<String>; 2]> = (0..turns as usize).map(|_| [run("as-needed"), run("1")]).collect();
    let least = |which: usize, column: usize| {
        turns.iter().map(|turn| number(&turn[which][column])).fold(f64::INFINITY, f64::min)
    };
    let (own, gmsh, alone) = (least(0, 0), least(0, 1), least(1, 1));
    let rest = &turns[0][0][2..];
    let times = [own + gmsh, own, gmsh, alone].map(|seconds| format!("{seconds:.1}")).join(",");
    let shares = format!("{:.2},{:.1}", (own + gmsh) / alone, 100.0 * own / (own + gmsh));
    let row = format!("{side},{size},{},{},{times},{shares},{}", rest[0], rest[1], rest[2..].join(","));
    enter("against_gmsh.csv", HEADER, 2, row);
}

/// Meshes in so many slabs, and prints own and gmsh's CPU seconds and what the mesh is like.
fn case(slabs: Option<u32>, side_mm: f64, element_size_mm: f64) {
    let mut spec = Spec { seed: 1, specimen: Specimen::cube(side_mm), ..Spec::default() };
    (spec.placement.min_gap_mm, spec.placement.wall_gap_mm) = (0.05, 0.05);
    let model = pack(&spec, &Silent).expect("the spec is valid");
    let options = MeshOptions {
        method: Method::Conforming { order: Order::Linear, slabs },
        element_size_mm,
        itz: ItzForm::None,
        ..Default::default()
    };
    let before = cpu_seconds();
    let mesh =
        mesh::build(&model, &options, &Tools { gmsh: &Gmsh::program("gmsh"), ..Tools::default() }).expect("a mesh");
    let [own, gmsh] = [0, 1].map(|i| cpu_seconds()[i] - before[i]);
    let cells = figures::CellQuality::of_cells(&mesh);
    let least = |of: fn(&figures::CellQuality) -> f64| cells.iter().map(of).fold(f64::INFINITY, f64::min);
    let below = |degrees: f64| figures::CellQuality::below(&cells, degrees).len();
    println!(
        "{own},{gmsh},{},{},{:.2},{},{},{:.4}",
        model.aggregates.len(),
        cells.len(),
        least(|cell| cell.min_dihedral_deg),
        below(1.0),
        below(8.0),
        least(|cell| cell.shortest_altitude_mm),
    );
}

/// User and system time of this process, and of those it waited for: fields 14 to 17 of /proc/self/stat, in hundredths.
fn cpu_seconds() -> [f64; 2] {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<f64> =
        stat.rsplit_once(')').map_or("", |parts| parts.1).split_whitespace().skip(11).take(4).map(number).collect();
    [fields[0] + fields[1], fields[2] + fields[3]].map(|hundredths| hundredths / 100.0)
}
