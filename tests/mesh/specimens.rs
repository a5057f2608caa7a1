//! The fitted lattice in specimens that are not boxes: its sides are the specimen's own.

use crate::angle_piece::angle_piece;
use crate::mesh::voxel::deck;
use meso_core::export::abaqus::DeckOptions;
use meso_core::math::Vec3;
use meso_core::mesh::cells::Sides;
use meso_core::mesh::{self, ItzForm, Mesh, MeshOptions, Method, Phase, PhaseVolumes, Tools, figures};
use meso_core::specimen::Specimen;
use meso_core::{Silent, Spec};
use std::f64::consts::PI;

fn lattice(specimen: &Specimen, method: Method, itz: ItzForm) -> Mesh {
    let spec = Spec { fraction: 0.4, specimen: specimen.clone(), ..Default::default() };
    let model = meso_core::pack(&spec, &Silent).unwrap();
    let options = MeshOptions { method, itz, element_size_mm: 2.5, ..Default::default() };
    mesh::build(&model, &options, &Tools::default()).unwrap()
}

fn cylinder() -> Specimen {
    Specimen::Cylinder { diameter_mm: 50.0, height_mm: 40.0 }
}

/// An L turned by 20 degrees, so that no side lies in its box's.
fn turned_angle_piece() -> Specimen {
    let (sin, cos) = (libm::sin(PI / 9.0), libm::cos(PI / 9.0));
    angle_piece([60.0, 25.0, 30.0], |[x, y, z]| [x * cos - y * sin, x * sin + y * cos, z])
}

pub(crate) fn every_kind() -> Vec<Specimen> {
    let square = |half: f64, z: f64| [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]];
    vec![
        cylinder(),
        Specimen::Sphere { diameter_mm: 50.0 },
        Specimen::Polyhedron { vertices_mm: [square(30.0, 0.0), square(18.0, 40.0)].concat() },
        Specimen::NotchedPrism {
            length_mm: 80.0,
            width_mm: 30.0,
            depth_mm: 40.0,
            notch_depth_mm: 10.7,
            notch_width_mm: 5.3,
            upper_notch_depth_mm: 0.0,
            notch_at_mm: 0.0,
        },
        Specimen::Dogbone {
            length_mm: 120.0,
            width_mm: 50.0,
            thickness_mm: 24.0,
            neck_width_mm: 32.0,
            neck_length_mm: 10.0,
            radius_mm: 70.0,
        },
        turned_angle_piece(),
    ]
}

/// The triangles that only one cell has.
fn outside(mesh: &Mesh) -> Vec<([u32; 3], Phase)> {
    let triangle = |cell: &[u32], face: &[usize]| {
        let mut nodes = [0, 1, 2].map(|i| cell[face[i]]);
        nodes.sort_unstable();
        nodes
    };
    let cells = mesh.cells().zip(&mesh.phase);
    let mut all: Vec<_> = cells
        .flat_map(|(cell, phase)| mesh.kind.faces().iter().map(move |face| (triangle(cell, face), *phase)))
        .collect();
    all.sort_unstable();
    all.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1).map(|same| same[0]).collect()
}

#[test]
fn sides_are_the_specimens_own_with_its_volume_and_angles_of_eight_degrees() {
    for specimen in every_kind() {
        let mesh = lattice(&specimen, Method::FITTED, ItzForm::None);
        let kind = specimen.kind();
        let volume = PhaseVolumes::of_mesh(&mesh).total();
        assert!((volume / specimen.volume() - 1.0).abs() < 0.005, "{kind}: {volume} of {}", specimen.volume());
        let cells = figures::CellQuality::of_cells(&mesh);
        assert_eq!(figures::CellQuality::below(&cells, 8.0), [0; 0], "{kind}");
        let container = specimen.container();
        let outside = outside(&mesh);
        assert!(outside.len() > 3000 && outside.iter().all(|(_, phase)| *phase == Phase::Mortar), "{kind}");
        let off = |node: u32| container.depth(&mesh.points[node as usize]).abs();
        let worst = outside.iter().flat_map(|(nodes, _)| nodes.map(off)).fold(0.0, f64::max);
        assert!(worst < 1e-7, "{kind}: a node of the surface lies {worst} mm off it");
    }
}

#[test]
fn the_sides_of_plain_lattices_are_staircases() {
    let specimen = cylinder();
    let mesh = lattice(&specimen, Method::PLAIN, ItzForm::None);
    let container = specimen.container();
    let worst = outside(&mesh)
        .into_iter()
        .flat_map(|(nodes, _)| nodes.map(|n| container.depth(&mesh.points[n as usize]).abs()));
    assert!(worst.fold(0.0, f64::max) > 0.5);
}

#[test]
fn a_cylinders_sets_are_its_ends_and_the_quarters_of_its_mantle() {
    let mesh = lattice(&cylinder(), Method::FITTED, ItzForm::Cohesive);
    let sides = Sides::of(&mesh);
    let at = |&(cell, face): &(u32, usize)| {
        let nodes = &mesh.cells[cell as usize * 4..][..4];
        [0, 1, 2].map(|i| mesh.points[nodes[mesh.kind.faces()[face][i]] as usize])
    };
    let area = |bit: usize| -> Vec3 {
        let triangles = sides.faces()[bit].iter().map(at);
        triangles.map(|[a, b, c]| (b - a).cross(&(c - a)) / 2.0).sum()
    };
    let end = PI * 25.0 * 25.0;
    assert!((area(4) + Vec3::z() * end).norm() < 0.01 * end && (area(5) - Vec3::z() * end).norm() < 0.01 * end);
    // A quarter of the mantle, projected: the chord times the height.
    let quarter = 2.0_f64.sqrt() * 25.0 * 40.0;
    for (bit, way) in [(0, -Vec3::x()), (1, Vec3::x()), (2, -Vec3::y()), (3, Vec3::y())] {
        assert!((area(bit) - way * quarter).norm() < 0.05 * quarter, "{bit}: {}", area(bit));
    }
    assert!(sides.members(5).all(|node| mesh.points[node as usize].z == 40.0));
    let text = deck(&mesh, &DeckOptions::default());
    assert!(mesh::cells::SIDES.iter().all(|(_, _, name)| text.contains(&format!("NAME=S_{name}\n"))));
}

#[test]
fn walls_of_pores_are_no_part_of_a_round_side() {
    let text = "fraction = 0.2\nspecimen = { kind = 'cylinder', diameter_mm = 50, height_mm = 40 }\n\
                grading = { d_min_mm = 8, d_max_mm = 12 }\nvoids = { fraction = 0.05, diameter_mm = [5, 8] }";
    let model = meso_core::pack(&Spec::from_toml(text).unwrap(), &Silent).unwrap();
    for (method, itz) in
        [(Method::FITTED, ItzForm::Cohesive), (Method::FITTED, ItzForm::Smeared), (Method::VOXEL, ItzForm::Smeared)]
    {
        let options = MeshOptions { method, itz, element_size_mm: 2.0, ..Default::default() };
        let mesh = mesh::build(&model, &options, &Tools::default()).unwrap();
        let (sides, container) = (Sides::of(&mesh), model.spec.specimen.container());
        let depth = |node: u32| container.depth(&mesh.points[node as usize]);
        let deepest = (0..4).flat_map(|bit| sides.members(bit)).map(depth).fold(0.0, f64::max);
        assert!(deepest < 2.0 * 2.0_f64.sqrt(), "{method:?} {itz:?}: a node {deepest} mm inside");
        let cells = mesh.by_owner();
        let wall = |&(cell, face): &(u32, usize)| cells.face(cell, face).all(|node| depth(node) > 2.0 * 2.0_f64.sqrt());
        // Where a pore meets the steps of voxels it is open.
        assert!(method == Method::VOXEL || !mesh.outer_faces().iter().any(wall), "{method:?} {itz:?}");
    }
}

#[test]
fn a_solid_layer_in_a_cylinder_turns_no_cell_over_and_leaves_its_sides_alone() {
    let specimen = cylinder();
    let [without, with] = [ItzForm::None, ItzForm::Solid].map(|itz| lattice(&specimen, Method::FITTED, itz));
    assert!(figures::CellQuality::of_cells(&with).iter().all(|q| q.volume_mm3 > 0.0));
    let volume = |mesh: &Mesh| PhaseVolumes::of_mesh(mesh).total();
    assert!(PhaseVolumes::of_mesh(&with).itz > 0.0 && (volume(&with) / volume(&without) - 1.0).abs() < 1e-12);
    assert_eq!(outside(&with).len(), outside(&without).len());
}
