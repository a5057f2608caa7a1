//! The fitted lattice in dense packings: angles, volumes, interfaces, and the faces of periodic boxes.

use meso_core::math::Vec3;
use meso_core::mesh::{self, Fit, ItzForm, Mesh, MeshOptions, Method, NO_AGGREGATE, PhaseVolumes, quality};
use meso_core::packing::{Periodic, Specimen};
use meso_core::{Model, Silent, Spec};
use std::collections::BTreeSet;

fn packed(specimen: Specimen, fraction: f64, seed: u64) -> Model {
    meso_core::pack(&Spec { fraction, specimen, seed, ..Default::default() }, &Silent).unwrap()
}

fn fitted(model: &Model, element_size_mm: f64) -> Mesh {
    let options = MeshOptions { method: Method::Lattice, itz: ItzForm::None, element_size_mm, ..Default::default() };
    mesh::build(model, &options).unwrap()
}

#[test]
fn in_a_dense_packing_no_angle_is_below_eight_degrees_hardly_any_below_ten_and_volumes_are_within_half_a_percent() {
    let model = packed(Specimen::cube(50.0), 0.5, 1);
    let mesh = fitted(&model, 2.0);
    assert!(mesh.notes.closed_gaps > 1000, "closed gaps are what makes angles and volumes hard");
    let cells = quality::cells(&mesh);
    assert_eq!(quality::bad_cells(&cells, 8.0), [0; 0]);
    // Between the specimen's sides and aggregates closer to them than the lattice.
    assert!(quality::bad_cells(&cells, 9.99).len() * 500 < cells.len());
    let exact = PhaseVolumes::exact(&model.aggregates, &model.spec.specimen, |_| 0.0).unwrap();
    let volumes = PhaseVolumes::of_mesh(&mesh);
    assert!((volumes.aggregate / exact.aggregate - 1.0).abs() < 0.005, "{volumes:?} {exact:?}");
    assert!((volumes.mortar / exact.mortar - 1.0).abs() < 0.005, "{volumes:?} {exact:?}");
    assert!((volumes.total() / exact.total() - 1.0).abs() < 1e-9);
}

#[test]
fn nodes_between_one_aggregate_and_mortar_lie_on_its_surface_but_for_one_in_five_hundred_counted() {
    let model = packed(Specimen::cube(50.0), 0.5, 2);
    let mesh = fitted(&model, 2.0);
    let mut around = vec![BTreeSet::new(); mesh.points.len()];
    for (cell, id) in mesh.cells().zip(&mesh.aggregate) {
        cell.iter().for_each(|&node| _ = around[node as usize].insert(*id));
    }
    let height = |id: u32, p: &Vec3| {
        let body = &model.aggregates[id as usize].body;
        body.planes().map(|plane| plane.normal.dot(p) - plane.offset).fold(f64::MIN, f64::max)
    };
    let one = around.iter().zip(&mesh.points).filter(|(ids, _)| ids.len() == 2 && ids.contains(&NO_AGGREGATE));
    let heights: Vec<f64> = one.map(|(ids, p)| height(*ids.first().unwrap(), p).abs()).collect();
    let off: Vec<f64> = heights.iter().copied().filter(|height| *height > 1e-8).collect();
    assert!(heights.len() > 15_000);
    // The gap to the specimen's side is thinner there than angles of eight degrees allow.
    assert!(off.len() * 500 < heights.len(), "{} of {}", off.len(), heights.len());
    assert_eq!(off.len(), mesh.notes.off_surface_nodes);
    assert!(off.iter().all(|height| *height < 0.6), "{off:?}");
}

#[test]
fn a_fitted_mesh_is_identical_at_one_and_four_threads() {
    let model = packed(Specimen::cube(40.0), 0.5, 3);
    let mesh = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fitted(&model, 2.0))
    };
    assert_eq!(mesh(1), mesh(4));
}

/// The triangles or squares of a mesh on the box's face across `axis`, by the places of their nodes within the face, in
/// units of 1e-6 mm: what must match the face opposite to it. How many copies cohesive elements
/// make of a node is another matter: that hangs on the aggregates behind the face.
fn face(mesh: &Mesh, axis: usize, place: f64) -> Vec<Vec<[i64; 2]>> {
    let within = |p: &Vec3| [(axis + 1) % 3, (axis + 2) % 3].map(|i| (p[i] * 1e6).round() as i64);
    let on = |cell: &[u32]| {
        let nodes = cell.iter().map(|&node| &mesh.points[node as usize]).filter(|p| p[axis] == place);
        let mut on: Vec<[i64; 2]> = nodes.map(within).collect();
        on.sort_unstable();
        on
    };
    let mut faces: Vec<_> = mesh.cells().map(on).filter(|on| on.len() >= 3).collect();
    faces.sort_unstable();
    faces
}

#[test]
fn opposite_faces_of_a_periodic_box_match_node_for_node() {
    const SIDE: f64 = 30.0;
    let model = packed(Specimen::Cube { side_mm: SIDE, periodic: Periodic::ALL }, 0.45, 4);
    for (method, fit) in [(Method::Voxel, Fit::Plain), (Method::Lattice, Fit::Plain), (Method::Lattice, Fit::Fitted)] {
        for itz in [ItzForm::None, ItzForm::Cohesive] {
            let options = MeshOptions { method, fit, itz, element_size_mm: 2.0, ..Default::default() };
            let mesh = mesh::build(&model, &options).unwrap();
            for axis in 0..3 {
                let [low, high] = [0.0, SIDE].map(|place| face(&mesh, axis, place));
                assert!(low.len() >= 225);
                let only = |a: &[Vec<[i64; 2]>], b: &[Vec<[i64; 2]>]| a.iter().filter(|f| !b.contains(f)).count();
                let lone = only(&low, &high) + only(&high, &low);
                assert_eq!(lone, 0, "{method:?} {fit:?} {itz:?}, axis {axis}: of {}", low.len());
            }
        }
    }
}
