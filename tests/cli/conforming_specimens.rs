//! Conforming meshes of specimens that are not boxes: their own surface, no staircase. They skip without gmsh.

use crate::angle_piece::angle_piece;
use crate::conforming::with_options;
use meso_core::aggregate::Grading;
use meso_core::mesh::{ItzForm, Mesh, MeshOptions, Phase, PhaseVolumes, figures};
use meso_core::specimen::Specimen;
use meso_core::{Model, Silent, Spec};
use std::collections::BTreeMap;

fn packed(specimen: &Specimen) -> Model {
    let mut spec = Spec { fraction: 0.3, specimen: specimen.clone(), ..Default::default() };
    (spec.placement.min_gap_mm, spec.placement.wall_gap_mm) = (0.05, 0.05);
    spec.grading = Grading { d_max_mm: 12.0, classes_mm: vec![5.0, 12.0], ..spec.grading };
    meso_core::pack(&spec, &Silent).unwrap()
}

fn cylinder() -> Specimen {
    Specimen::Cylinder { diameter_mm: 30.0, height_mm: 25.0 }
}

/// With plane faces alone.
fn faceted() -> [Specimen; 4] {
    let square = |half: f64, z: f64| [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]];
    let vertices_mm = [square(18.0, 0.0), square(11.0, 24.0)].concat();
    [
        Specimen::Polyhedron { vertices_mm },
        Specimen::NotchedPrism {
            length_mm: 50.0,
            width_mm: 20.0,
            depth_mm: 25.0,
            notch_depth_mm: 7.7,
            notch_width_mm: 3.3,
            upper_notch_depth_mm: 0.0,
            notch_at_mm: 0.0,
        },
        Specimen::Dogbone {
            length_mm: 60.0,
            width_mm: 30.0,
            thickness_mm: 20.0,
            neck_width_mm: 20.0,
            neck_length_mm: 10.0,
            radius_mm: 50.0,
        },
        turned_angle_piece(),
    ]
}

/// An L, turned so that no side lies in its box's.
fn turned_angle_piece() -> Specimen {
    let (sin, cos) = (0.6, 0.8);
    angle_piece([40.0, 18.0, 20.0], |[x, y, z]| [x * cos - y * sin, x * sin + y * cos, z])
}

/// The nodes of the triangles that only one cell has, with the middles of these triangles' edges.
fn outside(mesh: &Mesh) -> Vec<meso_core::math::Vec3> {
    let mut sides = BTreeMap::new();
    for (cell, phase) in mesh.cells().zip(&mesh.phase) {
        for face in mesh.kind.faces() {
            let mut nodes = [0, 1, 2].map(|i| cell[face[i]]);
            nodes.sort_unstable();
            sides.entry(nodes).or_insert_with(Vec::new).push(*phase);
        }
    }
    let alone = sides.into_iter().filter(|(_, phases)| phases.len() == 1);
    alone
        .flat_map(|(nodes, phases)| {
            assert_eq!(phases, [Phase::Mortar], "grains lie inside");
            let [a, b, c] = nodes.map(|node| mesh.points[node as usize]);
            [a, b, c, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0]
        })
        .collect()
}

/// A mesh whose surface lies `off_mm` from the specimen's at most, and whose aggregates are exact.
fn meshed_within(specimen: &Specimen, off_mm: f64) -> Option<Mesh> {
    let model = packed(specimen);
    let kind = specimen.kind();
    assert!(model.aggregates.len() > 15, "{kind}: {} aggregates", model.aggregates.len());
    let mesh = with_options(&model, MeshOptions { itz: ItzForm::None, element_size_mm: 5.0, ..Default::default() })?;
    assert!(figures::CellQuality::of_cells(&mesh).iter().all(|q| q.volume_mm3 > 0.0), "{kind}");
    let (container, outside) = (specimen.container(), outside(&mesh));
    let off = outside.iter().map(|x| container.depth(x).abs()).fold(0.0, f64::max);
    assert!(outside.len() > 1000 && off < off_mm, "{kind}: {off} mm off the surface");
    let exact: f64 = model.aggregates.iter().map(|a| a.body.volume()).sum();
    assert!((PhaseVolumes::of_mesh(&mesh).aggregate / exact - 1.0).abs() < 1e-9, "{kind}");
    assert!(mesh.owner.contains(&Mesh::NO_BODY));
    Some(mesh)
}

#[test]
fn plane_faces_are_the_specimens_own_and_its_volume_exact() {
    for specimen in faceted() {
        let Some(mesh) = meshed_within(&specimen, 1e-9) else { return };
        let volume = PhaseVolumes::of_mesh(&mesh).total();
        assert!((volume / specimen.volume() - 1.0).abs() < 1e-9, "{}: {volume}", specimen.kind());
    }
}

#[test]
fn curved_walls_have_their_nodes_on_them_and_chords_of_two_hundredths() {
    for specimen in [cylinder(), Specimen::Sphere { diameter_mm: 32.0 }] {
        let Some(mesh) = meshed_within(&specimen, 0.02) else { return };
        let volume = PhaseVolumes::of_mesh(&mesh).total() / specimen.volume();
        assert!(volume < 1.0 && volume > 0.995, "{}: {volume}", specimen.kind());
    }
}

#[test]
fn a_solid_itz_in_a_cylinder_is_there_and_leaves_its_sides_alone() {
    let model = packed(&cylinder());
    let of = |itz| with_options(&model, MeshOptions { itz, element_size_mm: 3.0, ..Default::default() });
    let (Some(with), Some(without)) = (of(ItzForm::Solid), of(ItzForm::None)) else { return };
    let [with, without] = [&with, &without].map(|mesh| (PhaseVolumes::of_mesh(mesh), outside(mesh)));
    assert!(with.0.itz > 0.0 && (with.0.total() / without.0.total() - 1.0).abs() < 1e-12);
    assert_eq!(with.1, without.1);
}
