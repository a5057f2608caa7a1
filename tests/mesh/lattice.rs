//! The fitted lattice in dense packings: angles, volumes, interfaces, and the faces of periodic boxes.

use crate::mesh::voxel::{aggregate, block};
use meso_core::aggregate::Aggregate;
use meso_core::geometry::Plane;
use meso_core::math::{Rotation, Vec3};
use meso_core::mesh::{self, InterfaceDistance, ItzForm, Mesh, MeshOptions, Method, PhaseVolumes, Tools, figures};
use meso_core::specimen::{Periodic, Specimen};
use meso_core::{Model, Silent, Spec};
use std::collections::BTreeSet;
use std::sync::LazyLock;

fn packed(specimen: Specimen, fraction: f64, seed: u64) -> Model {
    meso_core::pack(&Spec { fraction, specimen, seed, ..Default::default() }, &Silent).unwrap()
}

fn fitted(model: &Model, element_size_mm: f64) -> Mesh {
    let options = MeshOptions { method: Method::FITTED, itz: ItzForm::None, element_size_mm, ..Default::default() };
    mesh::build(model, &options, &Tools::default()).unwrap()
}

#[test]
fn in_a_dense_packing_no_angle_is_below_ten_degrees_and_volumes_are_within_half_a_percent() {
    let model = packed(Specimen::cube(50.0), 0.5, 1);
    let mesh = fitted(&model, 2.0);
    assert!(mesh.notes.closed_gaps > 1000, "closed gaps are what makes angles and volumes hard");
    let cells = figures::CellQuality::of_cells(&mesh);
    assert_eq!(figures::CellQuality::below(&cells, 10.0 - 1e-9), [0; 0]);
    let exact = PhaseVolumes::exact(&model.aggregates, &model.spec.specimen, |_| 0.0).unwrap();
    let volumes = PhaseVolumes::of_mesh(&mesh);
    assert!((volumes.aggregate / exact.aggregate - 1.0).abs() < 0.005, "{volumes:?} {exact:?}");
    assert!((volumes.mortar / exact.mortar - 1.0).abs() < 0.005, "{volumes:?} {exact:?}");
    assert!((volumes.total() / exact.total() - 1.0).abs() < 1e-9);
}

/// The ids of the aggregates, and [`Mesh::NO_BODY`], whose cells every node has.
fn around(mesh: &Mesh) -> Vec<BTreeSet<u32>> {
    let mut around = vec![BTreeSet::new(); mesh.points.len()];
    for (cell, id) in mesh.cells().zip(&mesh.owner) {
        cell.iter().for_each(|&node| _ = around[node as usize].insert(*id));
    }
    around
}

/// For every node of an interface how far it lies from the nearest of its aggregates, mm, and how many these are.
fn off(mesh: &Mesh, model: &Model) -> Vec<(f64, usize)> {
    let planes: Vec<Vec<Plane>> = model.aggregates.iter().map(|aggregate| aggregate.body.planes().collect()).collect();
    // From the nearest plane of a body's surface.
    let height = |id: u32, p: &Vec3| {
        let heights = planes[id as usize].iter().map(|plane| plane.normal.dot(p) - plane.offset);
        heights.fold(f64::MIN, f64::max).abs()
    };
    let of = |(ids, p): (&BTreeSet<u32>, &Vec3)| {
        let bodies: Vec<u32> = ids.iter().copied().filter(|id| *id != Mesh::NO_BODY).collect();
        let heights = bodies.iter().map(|id| height(*id, p));
        (ids.len() > 1).then_some((heights.fold(f64::INFINITY, f64::min), bodies.len()))
    };
    around(mesh).iter().zip(&mesh.points).filter_map(of).collect()
}

/// A packing of which nodes of interfaces went onto the cube's sides before cells were swapped.
static DENSE: LazyLock<(Model, Mesh)> = LazyLock::new(|| {
    let model = packed(Specimen::cube(50.0), 0.5, 3);
    let mesh = fitted(&model, 2.0);
    (model, mesh)
});

#[test]
fn every_node_of_an_interface_lies_on_one_of_its_aggregates_and_no_gap_to_the_specimens_side_is_closed() {
    assert_on_aggregates(&DENSE.0, &DENSE.1);
    // Nodes stayed off in the cylinder before cells were swapped.
    let cylinder = packed(Specimen::Cylinder { diameter_mm: 50.0, height_mm: 50.0 }, 0.5, 1);
    assert_on_aggregates(&cylinder, &fitted(&cylinder, 2.0));
}

#[test]
#[ignore = "slow tier"]
fn every_node_of_an_interface_of_another_packing_lies_on_one_of_its_aggregates() {
    // Nodes stayed off before cells were swapped.
    let model = packed(Specimen::cube(50.0), 0.5, 2);
    assert_on_aggregates(&model, &fitted(&model, 2.0));
}

fn assert_on_aggregates(model: &Model, mesh: &Mesh) {
    assert!(around(mesh).iter().all(|ids| !ids.is_empty()), "what was merged or swapped is in no list");
    let nodes = off(mesh, model);
    let alone = nodes.iter().filter(|(_, bodies)| *bodies == 1).count();
    assert!(alone > 10_000 && nodes.len() - alone > 2000, "{alone} of {}", nodes.len());
    assert_eq!(nodes.iter().filter(|(height, _)| *height > 1e-8).count(), 0);
    assert_eq!((mesh.notes.off_surface_nodes, mesh.notes.closed_side_gaps), (0, 0));
    assert_eq!(figures::CellQuality::below(&figures::CellQuality::of_cells(mesh), 8.0 - 1e-9), [0; 0]);
}

#[test]
fn interface_distance_separates_nodes_that_are_off_from_nodes_that_close_gaps() {
    let model = packed(Specimen::cube(25.0), 0.5, 3);
    let mesh = fitted(&model, 2.0);
    let nodes = off(&mesh, &model);
    let joined = nodes.iter().filter(|(_, bodies)| *bodies > 1).count();
    let options = MeshOptions { method: Method::FITTED, itz: ItzForm::Cohesive, ..Default::default() };
    for mesh in [mesh, mesh::build(&model, &options, &Tools::default()).unwrap()] {
        let found = InterfaceDistance::of(&mesh, &model.aggregates, &model.spec.specimen);
        assert_eq!((found.nodes, found.joined, found.off), (nodes.len(), joined, 0));
        assert!(found.max_mm < 1e-8, "{found:?}");
        assert!(found.joined_rms_mm > 0.05 && found.joined_max_mm < 2.5, "{found:?}");
    }
}

#[test]
#[ignore = "slow tier: seven seconds of processor time"]
fn where_a_face_hardly_rises_from_the_specimens_side_nodes_become_one_with_others_on_it() {
    // With places for the nodes alone the smallest angle is 9.03 degrees.
    let body = block([-6.0; 3], [6.0; 3]).rotated(&Rotation::from_euler_angles(0.01, 0.013, 0.4));
    let place = Vec3::new(9.0, 9.0, 0.02 - body.aabb().min.z);
    let (blocks, specimen) = ([aggregate(0, body.translated(&place), 0.5)], Specimen::cuboid([18.0, 18.0, 15.0]));
    let options = MeshOptions { method: Method::FITTED, itz: ItzForm::None, ..Default::default() };
    let mesh = mesh::build((&blocks, &specimen), &options, &Tools::default()).unwrap();
    let distance = InterfaceDistance::of(&mesh, &blocks, &specimen);
    assert!(distance.nodes > 200 && distance.off == 0, "{distance:?}");
    assert_eq!((mesh.notes.off_surface_nodes, mesh.notes.closed_side_gaps), (0, 0));
    assert_eq!(figures::CellQuality::below(&figures::CellQuality::of_cells(&mesh), 10.0 - 1e-9), [0; 0]);
}

#[test]
fn a_gap_to_a_side_thinner_than_the_elements_is_counted_where_they_close_it_and_a_wide_one_is_not() {
    for method in [Method::VOXEL, Method::PLAIN, Method::FITTED] {
        for (gap, repeats) in [(0.2, false), (0.2, true), (3.0, false)] {
            let blocks = [aggregate(5, block([gap, 6.0, 6.0], [9.0, 14.0, 14.0]), 0.5)];
            let specimen = Specimen::Cube { side_mm: 20.0, periodic: Periodic([repeats; 3]) };
            let options = MeshOptions { method, itz: ItzForm::None, element_size_mm: 2.0, ..Default::default() };
            let mesh = mesh::build((&blocks, &specimen), &options, &Tools::default()).unwrap();
            let there =
                around(&mesh).iter().zip(&mesh.points).filter(|(ids, p)| ids.contains(&0) && p.x == 0.0).count();
            let closed = method != Method::FITTED && gap < 1.0;
            assert_eq!(there > 0, closed, "{method:?} {gap}");
            // Across a face that is another's image the mesh goes on.
            let counted = if repeats { 0 } else { there };
            assert_eq!(mesh.notes.closed_side_gaps, counted, "{method:?} {gap}");
            assert_eq!(mesh.notes.closed_side_gap_aggregates, usize::from(counted > 0));
            let widest = if counted > 0 { gap } else { 0.0 };
            assert!((mesh.notes.widest_closed_side_gap_mm - widest).abs() < 1e-12, "{:?}", mesh.notes);
        }
    }
}

#[test]
fn a_fitted_mesh_is_identical_at_one_and_four_threads() {
    let model = packed(Specimen::cube(30.0), 0.5, 3);
    let mesh = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fitted(&model, 2.0))
    };
    let mesh = [1, 4].map(mesh);
    assert!(mesh[0].notes.closed_gaps > 100 && mesh[0] == mesh[1]);
}

/// Two blocks of 8 mm, `gap` mm from each other, turned against the axes together.
fn neighbours(gap: f64) -> ([Aggregate; 2], Specimen) {
    let turn = Rotation::from_euler_angles(0.2, 0.3, 0.4);
    let at = |id: u32, x: f64| {
        let body = block([x, -4.0, -4.0], [x + 8.0, 4.0, 4.0]);
        aggregate(id, body.rotated(&turn).translated(&Vec3::repeat(15.0)), 0.5)
    };
    ([at(0, -8.0 - gap / 2.0), at(1, gap / 2.0)], Specimen::cube(30.0))
}

#[test]
fn a_gap_thinner_than_the_elements_is_counted_where_they_close_it_and_a_wide_one_is_not() {
    for method in [Method::VOXEL, Method::PLAIN, Method::FITTED] {
        for (gap, joined) in [(0.2, true), (5.0, false)] {
            let (blocks, specimen) = neighbours(gap);
            let options = MeshOptions { method, itz: ItzForm::None, element_size_mm: 2.0, ..Default::default() };
            let mesh = mesh::build((&blocks, &specimen), &options, &Tools::default()).unwrap();
            let nodes = |id: u32| -> BTreeSet<u32> {
                let cells = mesh.cells().zip(&mesh.owner).filter(|(_, of)| **of == id);
                cells.flat_map(|(cell, _)| cell.iter().copied()).collect()
            };
            let shared = nodes(0).intersection(&nodes(1)).count();
            let notes = &mesh.notes;
            assert_eq!((notes.closed_gaps, notes.closed_gap_pairs), (shared, usize::from(joined)), "{method:?}");
            assert_eq!(shared > 0, joined, "{method:?}");
            let widest = if joined { gap } else { 0.0 };
            assert!((notes.widest_closed_gap_mm - widest).abs() < 1e-9, "{method:?} {notes:?}");
        }
    }
}

/// The triangles or squares of a mesh on the box's face across `axis`, by the places of their nodes within the face, in
/// units of 1e-6 mm. They must match the opposite face. The number of copies of a node for cohesive elements need not
/// match: it depends on the aggregates behind the face.
pub(crate) fn face(mesh: &Mesh, axis: usize, place: f64) -> Vec<Vec<[i64; 2]>> {
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
    for method in [Method::VOXEL, Method::PLAIN, Method::FITTED] {
        for itz in [ItzForm::None, ItzForm::Cohesive] {
            let options = MeshOptions { method, itz, element_size_mm: 2.0, ..Default::default() };
            let mesh = mesh::build(&model, &options, &Tools::default()).unwrap();
            for axis in 0..3 {
                let [low, high] = [0.0, SIDE].map(|place| face(&mesh, axis, place));
                assert!(low.len() >= 225);
                let only =
                    |a: &[Vec<[i64; 2]>], b: &[Vec<[i64; 2]>]| a.iter().filter(|f| b.binary_search(f).is_err()).count();
                let lone = only(&low, &high) + only(&high, &low);
                assert_eq!(lone, 0, "{method:?} {itz:?}, axis {axis}: of {}", low.len());
            }
        }
    }
}
