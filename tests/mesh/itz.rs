//! The ITZ in meshes: solid layers, cohesive elements; and the decks that use them.

use crate::mesh::voxel::{aggregate, block, by_hand, deck, options_by_hand, turned_blocks};
use meso_core::export::abaqus::DeckOptions;
use meso_core::math::Vec3;
use meso_core::mesh::{self, ItzForm, Mesh, MeshOptions, Method, Phase, PhaseVolumes, Tools, figures};
use meso_core::specimen::Specimen;
use meso_core::trial::TestKind;
use meso_core::{Silent, Spec};

fn lattice(itz: ItzForm) -> Mesh {
    let (grains, specimen) = turned_blocks();
    let options = MeshOptions { method: Method::FITTED, element_size_mm: 1.25, itz, ..Default::default() };
    mesh::build((&grains, &specimen), &options, &Tools::default()).unwrap()
}

#[test]
fn a_solid_layer_has_the_volume_of_the_offset_shell() {
    let (grains, specimen) = turned_blocks();
    let exact = PhaseVolumes::exact(&grains, &specimen, |a| a.itz_thickness_mm).unwrap();
    let itz = PhaseVolumes::of_mesh(&lattice(ItzForm::Solid)).itz;
    assert!((itz / exact.itz - 1.0).abs() < 0.05, "{itz} {}", exact.itz);
}

#[test]
fn a_solid_layer_in_a_dense_packing_turns_no_cell_over() {
    let spec = Spec { fraction: 0.5, specimen: Specimen::cube(32.0), ..Default::default() };
    let model = meso_core::pack(&spec, &Silent).unwrap();
    for (element_size_mm, volume_error) in [(3.0, 0.1), (2.0, 0.005)] {
        let options = MeshOptions { method: Method::FITTED, element_size_mm, ..Default::default() };
        let mesh = mesh::build(&model, &options, &Tools::default()).unwrap();
        assert!(mesh.notes.closed_gaps > 100, "gaps that close are what turned cells over");
        let cells = figures::CellQuality::of_cells(&mesh);
        assert!(cells.iter().all(|q| q.volume_mm3 > 0.0));
        assert!(cells.iter().all(|q| q.min_dihedral_deg > 1.99), "a layer of 0.1 mm has angles of 3 degrees by itself");
        assert!(mesh.notes.shifted_itz_nodes > 0, "nodes left the exact offset for these angles");
        let volumes = PhaseVolumes::of_mesh(&mesh);
        assert!((volumes.total() / spec.specimen.volume() - 1.0).abs() < 1e-9);
        let exact = PhaseVolumes::exact(&model.aggregates, &spec.specimen, |a| a.itz_thickness_mm).unwrap();
        assert!((volumes.itz / exact.itz - 1.0).abs() < volume_error, "{} {}", volumes.itz, exact.itz);
        assert!(mesh.notes.pinched_itz_nodes * 20 < mesh.points.len(), "{:?}", mesh.notes);
    }
}

#[test]
fn cohesive_elements_close_every_interface_with_their_normal_out_of_the_aggregate() {
    for method in [Method::VOXEL, Method::FITTED] {
        let (grains, specimen) = turned_blocks();
        let options = MeshOptions { method, element_size_mm: 1.25, itz: ItzForm::Cohesive, ..Default::default() };
        let mesh = mesh::build((&grains, &specimen), &options, &Tools::default()).unwrap();
        assert!(mesh.cohesive().len() > 1000);
        for (nodes, id) in mesh.cohesive().zip(&mesh.cohesive_owner) {
            let (bottom, top) = nodes.split_at(nodes.len() / 2);
            let at = |node: &u32| mesh.points[*node as usize];
            assert!(bottom.iter().zip(top).all(|(b, t)| b != t && at(b) == at(t)));
            let normal = (at(&bottom[1]) - at(&bottom[0])).cross(&(at(&bottom[2]) - at(&bottom[0])));
            let centre = bottom.iter().map(at).sum::<Vec3>() / bottom.len() as f64;
            // To the voxel's centre, or a little way into the tetrahedron.
            let back = centre - normal.normalize() * if method == Method::VOXEL { 0.6 } else { 0.1 };
            let height =
                grains[*id as usize].body.planes().map(|p| p.normal.dot(&back) - p.offset).fold(-9.0, f64::max);
            assert!(height < 0.05, "{method:?} {id} {height}");
        }
        let shared = mesh.cells().zip(&mesh.phase).filter(|(_, phase)| **phase == Phase::Mortar);
        let mortar: std::collections::BTreeSet<u32> = shared.flat_map(|(cell, _)| cell.iter().copied()).collect();
        let mut inside = mesh.cells().zip(&mesh.phase).filter(|(_, phase)| **phase == Phase::Aggregate);
        assert!(inside.all(|(cell, _)| cell.iter().all(|node| !mortar.contains(node))), "aggregates stand apart");
    }
}

/// Two voxels of 1 mm side by side, the second one aggregate, a cohesive element between them.
fn two_voxels_apart() -> Mesh {
    let grains = [aggregate(0, block([1.0, 0.0, 0.0], [2.0, 1.0, 1.0]), 0.1)];
    let options = MeshOptions { element_size_mm: 1.0, itz: ItzForm::Cohesive, ..Default::default() };
    mesh::build((&grains, &Specimen::cuboid([2.0, 1.0, 1.0])), &options, &Tools::default()).unwrap()
}

#[test]
fn a_cohesive_compression_deck_reads_as_by_hand() {
    // By hand: the aggregate's face S6 (4-1-5-8 of its nodes) is the bottom of COH3D8, its normal towards -x; plates with
    // their positive sides towards the specimen; contact, smooth step, mass scaling, history of both plates.
    let options = DeckOptions { analysis: TestKind::Compression.into(), ..options_by_hand() };
    let text = deck(&two_voxels_apart(), &options);
    assert_eq!(text, by_hand(include_str!("../write/snapshots/two_voxels_cohesive_compression.inp")));
}

#[test]
fn a_tension_deck_holds_both_ends() {
    let text = deck(&two_voxels_apart(), &DeckOptions { analysis: TestKind::Tension.into(), ..Default::default() });
    assert!(text.contains("PIN NSET=N_BOTTOM") && text.contains("PIN NSET=N_TOP") && !text.contains("R3D3"));
    assert!(text.contains("REF_BOTTOM, 3, 3, -2.500000000e-4\nREF_TOP, 3, 3, 2.500000000e-4"), "{text}");
}
