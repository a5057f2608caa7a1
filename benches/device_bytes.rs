//! Bytes that a tetrahedron needs on a device, and that a step moves for it. No device is needed: buffers are counted.
//!
//! `cargo bench -p meso-bench --bench device_bytes -- [SIDE_MM [ELEMENT_SIZE_MM]]` takes a cube of 50 mm with elements of 2 mm
//! when nothing is given, with `--quick` one of 24 mm, and writes `benches/results/device_bytes.csv`.

#![allow(clippy::print_stdout, reason = "a bench reports on stdout")]

#[path = "collision/specimen.rs"]
mod specimen;
#[path = "collision/table.rs"]
mod table;

use meso_core::materials::Materials;
use meso_core::mesh::{self, ItzForm, MeshOptions, Method, Tools};
use meso_solve::{LawName, Run, Sample, Smoothing, Test};
use table::Table;

const HEADER: &str = "law,smoothing,elements,held_bytes_per_element,\
                      moved_bytes_per_element_step,moved_with_damage_bytes_per_element_step";

fn main() {
    let (model, size) = specimen::asked(table::quick());
    let options =
        MeshOptions { method: Method::FITTED, element_size_mm: size, itz: ItzForm::Smeared, ..Default::default() };
    let mesh = mesh::build(&model, &options, &Tools::default()).expect("a mesh");
    let mut table = Table::new(HEADER);
    println!("{HEADER}");
    for law in [LawName::Elastic, LawName::Cdp, LawName::Cdpm2, LawName::Meso] {
        for smoothing in [Smoothing::Edges, Smoothing::None] {
            let test = Test { law, smoothing: Some(smoothing), ..Test::default() };
            let sample = Sample::of(&mesh, &model.spec.specimen, &options);
            let run = Run::new(sample, &Materials::default(), &test).expect("a test");
            let traffic = meso_gpu::traffic(&run, meso_gpu::THREADS).expect("tetrahedra");
            let each = |bytes: usize| format!("{:.1}", bytes as f64 / mesh.cell_count() as f64);
            let row = [
                format!("{law:?}").to_lowercase(),
                format!("{smoothing:?}").to_lowercase(),
                mesh.cell_count().to_string(),
                each(traffic.held),
                each(traffic.moved),
                each(traffic.moved_with_damage),
            ];
            println!("{}", row.join(","));
            table.row(&row);
        }
    }
    table.save("device_bytes.csv");
}
