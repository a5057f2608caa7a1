//! How thick the solid ITZ of a conforming mesh is: how far the layer's inner side lies from the exact offset of the aggregates.
//!
//! `cargo bench --bench itz_layer -- [SIDE_MM [ELEMENT_SIZE_MM [FRACTION [SEED]]]]` takes a cube with gaps of 0.05 mm, of 30 mm
//! with elements of 2 mm at 0.5 and seed 1 when nothing is given (the paper's specimen has 150 mm), and puts its row into
//! `benches/results/itz_layer.csv` in place of the one that is there. `gmsh` is the one on the PATH.
//! `--quick` takes small cases.

#![allow(clippy::print_stdout, reason = "a bench reports on stdout")]

#[path = "../tests/layer_errors.rs"]
mod layer_errors;
#[path = "collision/rows.rs"]
mod rows;
#[path = "collision/table.rs"]
mod table;

use layer_errors::LayerErrors;
use meso_core::mesh::{self, MeshOptions, Method, PhaseVolumes, Tools, figures};
use meso_core::specimen::Specimen;
use meso_core::{Silent, Spec, pack};
use meso_gmsh::Gmsh;
use rows::{enter, number};
use table::count;

const HEADER: &str = "side_mm,element_size_mm,fraction,seed,aggregates,elements,error_rms_mm,area_mm2,volume_error_percent,\
                      nodes_that_stop_short,smallest_dihedral_deg,shortest_altitude_mm,inverted";

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench" && word != "--quick").collect();
    let [side, element_size_mm, fraction, seed] =
        [(0, 30.0), (1, if table::quick() { 4.0 } else { 2.0 }), (2, count(50, 30) as f64 / 100.0), (3, 1.0)]
            .map(|(i, usual)| words.get(i).map_or(usual, |word| number(word)));
    let mut spec = Spec { seed: seed as u64, fraction, specimen: Specimen::cube(side), ..Spec::default() };
    (spec.placement.min_gap_mm, spec.placement.wall_gap_mm) = (0.05, 0.05);
    let model = pack(&spec, &Silent).expect("the spec is valid");
    let options = MeshOptions { method: Method::CONFORMING, element_size_mm, ..MeshOptions::default() };
    let mesh =
        mesh::build(&model, &options, &Tools { gmsh: &Gmsh::program("gmsh"), ..Tools::default() }).expect("a mesh");
    let exact = PhaseVolumes::exact(&model.aggregates, &model.spec.specimen, |a| a.itz_thickness_mm).expect("cores");
    let volume = 100.0 * (PhaseVolumes::of_mesh(&mesh).itz / exact.itz - 1.0);
    let layer = LayerErrors::of(&mesh, &model);
    let cells = figures::CellQuality::of_cells(&mesh);
    let least = |of: fn(&figures::CellQuality) -> f64| cells.iter().map(of).fold(f64::INFINITY, f64::min);
    let figures = format!("{:.5},{:.0},{volume:.3},{}", layer.rms_mm, layer.area_mm2, mesh.notes.thinned_itz_nodes);
    let worst = format!(
        "{:.2},{:.5},{}",
        least(|cell| cell.min_dihedral_deg),
        least(|cell| cell.shortest_altitude_mm),
        cells.iter().filter(|cell| cell.volume_mm3 <= 0.0).count()
    );
    let made = format!("{side},{element_size_mm},{fraction},{seed},{},{}", model.aggregates.len(), cells.len());
    enter("itz_layer.csv", HEADER, 4, format!("{made},{figures},{worst}"));
}
