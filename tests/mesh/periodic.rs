//! Meshes of periodic boxes: every method with every form of the ITZ, repeated along one, two and three axes.

use crate::mesh::lattice::face;
use crate::mesh::voxel::{aggregate, block, deck};
use crate::write::periodic_decks::{SIDE_MM, equations, packed, tied};
use meso_core::aggregate::Aggregate;
use meso_core::export::abaqus::Analysis;
use meso_core::math::{Rotation, Vec3};
use meso_core::mesh::{
    self, InterfaceDistance, ItzForm, Mesh, MeshOptions, Method, Phase, PhaseVolumes, Tools, figures,
};
use meso_core::specimen::{Periodic, Specimen};
use meso_core::{Model, Silent, Spec};
use std::collections::BTreeMap;

const AXES: [[bool; 3]; 3] = [[true; 3], [false, true, true], [true, false, false]];
/// The solid ITZ has its own thickness.
const THIN_VOXELS: Method = Method::Voxel { thin_itz: true, subsamples: 1 };
const METHODS: [Method; 3] = [THIN_VOXELS, Method::PLAIN, Method::FITTED];

fn meshed(model: &Model, method: Method, itz: ItzForm) -> Mesh {
    let element_size_mm = if method == THIN_VOXELS { 1.0 } else { 2.0 };
    let options = MeshOptions { method, itz, element_size_mm, ..Default::default() };
    mesh::build(model, &options, &Tools::default()).unwrap()
}

#[test]
fn every_mesh_of_a_periodic_box_fills_it_with_cells_of_positive_volume_and_matching_faces_that_equations_tie() {
    for axes in AXES {
        let model = packed(axes);
        for method in METHODS {
            for itz in [ItzForm::None, ItzForm::Solid, ItzForm::Cohesive] {
                let what = format!("{method:?} {itz:?} along {axes:?}");
                let mesh = meshed(&model, method, itz);
                assert!(figures::CellQuality::of_cells(&mesh).iter().all(|cell| cell.volume_mm3 > 0.0), "{what}");
                for axis in (0..3).filter(|axis| axes[*axis]) {
                    let [low, high] = [0.0, SIDE_MM].map(|place| face(&mesh, axis, place));
                    assert!(low.len() > 200 && low == high, "{what} across {axis}: {} {}", low.len(), high.len());
                }
                let upper = |p: &&Vec3| (0..3).any(|axis| axes[axis] && p[axis] == SIDE_MM);
                let on_upper = mesh.points.iter().filter(upper).count();
                let ties = equations(&deck(&mesh, &tied(Analysis::None))).len();
                // A node that cohesive elements need on upper faces alone is the home of its images there.
                let least = if itz == ItzForm::Cohesive { 3 * on_upper / 2 } else { 3 * on_upper };
                assert!(ties.is_multiple_of(3) && (least..=3 * on_upper).contains(&ties), "{what}: {ties} {on_upper}");
                check_volumes(&model, &mesh, method, itz, &what);
            }
        }
    }
}

/// Chords at 2 mm take 1 to 3 % of grains of 6 to 12 mm, in boxes with walls, too.
fn check_volumes(model: &Model, mesh: &Mesh, method: Method, itz: ItzForm, what: &str) {
    let shell = |a: &Aggregate| if itz == ItzForm::Solid { a.itz_thickness_mm } else { 0.0 };
    let exact = PhaseVolumes::exact(&model.aggregates, &model.spec.specimen, shell).unwrap();
    let volumes = PhaseVolumes::of_mesh(mesh);
    assert!((volumes.total() / exact.total() - 1.0).abs() < 1e-9, "{what}");
    let (grains, error) = (|v: &PhaseVolumes| v.aggregate + v.itz, if method == Method::FITTED { 0.035 } else { 0.01 });
    assert!((grains(&volumes) / grains(&exact) - 1.0).abs() < error, "{what}: {volumes:?} {exact:?}");
    // Shells of 0.1 to 0.5 mm among centres that are 1 mm apart.
    let error = if method == THIN_VOXELS { 0.1 } else { 0.06 };
    let shells = if exact.itz > 0.0 { volumes.itz / exact.itz } else { 1.0 + volumes.itz };
    assert!((shells - 1.0).abs() < error, "{what}: {volumes:?} {exact:?}");
}

#[test]
fn the_solid_itz_of_voxels_is_never_thinner_than_one_across_periodic_faces_too() {
    let model = packed([true; 3]);
    let mesh =
        mesh::build(&model, &MeshOptions { element_size_mm: 1.0, ..Default::default() }, &Tools::default()).unwrap();
    let side = SIDE_MM as usize;
    let at = |[i, j, k]: [usize; 3]| mesh.phase[(k % side * side + j % side) * side + i % side];
    let mut across = 0;
    for voxel in 0..mesh.phase.len() {
        let here = [voxel % side, voxel / side % side, voxel / (side * side)];
        for axis in 0..3 {
            let mut next = here;
            next[axis] += 1;
            let pair = [at(here), at(next)];
            assert!(!(pair.contains(&Phase::Aggregate) && pair.contains(&Phase::Mortar)), "{here:?} along {axis}");
            across += usize::from(next[axis] == side && pair == [Phase::Aggregate; 2]);
        }
    }
    assert!(across > 20, "cores go on across the faces, or this test says nothing");
}

#[test]
fn a_layer_in_a_dense_periodic_box_has_the_angles_and_volumes_of_one_with_walls_on_any_number_of_threads() {
    const SIDE: f64 = 32.0;
    let specimen = Specimen::Cube { side_mm: SIDE, periodic: Periodic([true; 3]) };
    let model = meso_core::pack(&Spec { fraction: 0.5, specimen, ..Default::default() }, &Silent).unwrap();
    let options = MeshOptions { method: Method::FITTED, ..Default::default() };
    let [mesh, other] = [1, 4].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| mesh::build(&model, &options, &Tools::default()).unwrap())
    });
    assert!(mesh == other);
    assert!(mesh.notes.closed_gaps > 500);
    assert!(figures::CellQuality::of_cells(&mesh).iter().all(|cell| cell.min_dihedral_deg > 1.99));
    for axis in 0..3 {
        let [low, high] = [0.0, SIDE].map(|place| face(&mesh, axis, place));
        assert!(low.len() > 500 && low == high, "across {axis}: {} {}", low.len(), high.len());
    }
    let exact = PhaseVolumes::exact(&model.aggregates, &model.spec.specimen, |a| a.itz_thickness_mm).unwrap();
    let volumes = PhaseVolumes::of_mesh(&mesh);
    let errors = [volumes.itz / exact.itz, volumes.aggregate / exact.aggregate].map(|ratio| (ratio - 1.0).abs());
    assert!(errors[0] < 0.005 && errors[1] < 0.01, "{errors:?}");
    assert!(mesh.notes.pinched_itz_nodes * 50 < mesh.points.len(), "{:?}", mesh.notes);
}

/// With their images; before, they stayed where the cut had put them, and 59 of the first lay off, two of them in no count.
#[test]
fn nodes_on_periodic_faces_go_onto_their_aggregates_and_those_that_do_not_are_in_the_notes() {
    for (axes, seed, most) in [([true; 3], 1, 15), ([false, true, true], 2, 5)] {
        let specimen = Specimen::Cube { side_mm: 40.0, periodic: Periodic(axes) };
        let model = meso_core::pack(&Spec { fraction: 0.5, specimen, seed, ..Default::default() }, &Silent).unwrap();
        let mesh = meshed(&model, Method::FITTED, ItzForm::None);
        let distance = InterfaceDistance::of(&mesh, &model.aggregates, &model.spec.specimen);
        assert_eq!(mesh.notes.off_surface_nodes, distance.off, "{distance:?}");
        assert!(distance.off < most, "{distance:?}");
        assert!(figures::CellQuality::of_cells(&mesh).iter().all(|cell| cell.min_dihedral_deg > 8.0 - 1e-9));
        for axis in (0..3).filter(|axis| axes[*axis]) {
            let [low, high] = [0.0, 40.0].map(|place| face(&mesh, axis, place));
            assert!(low.len() > 1000 && low == high, "across {axis}: {} {}", low.len(), high.len());
        }
    }
}

/// A block of 8 mm in the middle of a face across x, turned about x, in a box of 16 mm.
fn block_across() -> Mesh {
    let turn = Rotation::from_euler_angles(0.3, 0.0, 0.0);
    let body = block([-4.0; 3], [4.0; 3]).rotated(&turn).translated(&Vec3::new(0.0, 8.0, 8.0));
    let options = MeshOptions { method: Method::FITTED, element_size_mm: 1.0, ..Default::default() };
    let specimen = Specimen::Cube { side_mm: 16.0, periodic: Periodic([true; 3]) };
    mesh::build((&[aggregate(0, body, 0.5)], &specimen), &options, &Tools::default()).unwrap()
}

#[test]
fn a_layer_is_as_thick_on_the_faces_of_a_periodic_box_as_inside() {
    let mesh = block_across();
    assert_eq!((mesh.notes.thinned_itz_aggregates, mesh.notes.thinned_itz_nodes), (0, 0), "{:?}", mesh.notes);
    let volumes = PhaseVolumes::of_mesh(&mesh);
    // Its edges are cut a little where they cross the face.
    assert!((volumes.aggregate / 343.0 - 1.0).abs() < 0.005 && (volumes.itz / 169.0 - 1.0).abs() < 0.01, "{volumes:?}");
    // The area of every phase on both faces.
    let mut areas: BTreeMap<(bool, Phase), f64> = BTreeMap::new();
    for (cell, phase) in mesh.cells().zip(&mesh.phase) {
        for corners in mesh.kind.faces() {
            let [a, b, c] = [0, 1, 2].map(|i| mesh.points[cell[corners[i]] as usize]);
            if a.x == b.x && b.x == c.x && (a.x == 0.0 || a.x == 16.0) {
                *areas.entry((a.x > 0.0, *phase)).or_default() += (b - a).cross(&(c - a)).norm() / 2.0;
            }
        }
    }
    for upper in [false, true] {
        let [core, shell] = [Phase::Aggregate, Phase::Itz].map(|phase| areas[&(upper, phase)]);
        // Nodes on faces do not slide into corners. The triangles there lie across the corner and oblique to the face, so that a
        // layer of the right thickness is cut obliquely.
        assert!((core / 49.0 - 1.0).abs() < 0.05 && (shell / 15.0 - 1.0).abs() < 0.08, "{areas:?}");
    }
}

#[test]
fn both_parts_of_an_aggregate_on_a_face_keep_its_id() {
    let mesh = block_across();
    assert!(mesh.owner.iter().all(|id| [0, Mesh::NO_BODY].contains(id)));
    let mut parts: BTreeMap<(Phase, bool), usize> = BTreeMap::new();
    for ((cell, phase), id) in mesh.cells().zip(&mesh.phase).zip(&mesh.owner) {
        assert_eq!(*id == 0, *phase != Phase::Mortar);
        *parts.entry((*phase, mesh.points[cell[0] as usize].x < 8.0)).or_default() += 1;
    }
    assert!(parts.len() == 6 && parts.values().all(|cells| *cells > 300), "{parts:?}");
}
