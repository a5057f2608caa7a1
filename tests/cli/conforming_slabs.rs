//! Conforming meshes of specimens that gmsh fills in slabs. They skip without gmsh.

use crate::conforming::with_options;
use meso_core::math::Vec3;
use meso_core::mesh::{ItzForm, Mesh, MeshOptions, Method, Order, Phase, PhaseVolumes, figures};
use meso_core::{Model, Silent, Spec};
use std::collections::BTreeMap;
use std::sync::LazyLock;

const SIDE_MM: f64 = 24.0;

fn packed(specimen: &str, others: &str) -> Model {
    let spec = format!(
        "fraction = 0.4\nspecimen = {{ kind = 'cube', side_mm = {SIDE_MM}{specimen} }}\n\
         placement = {{ min_gap_mm = 0.05, wall_gap_mm = 0.05 }}\n{others}"
    );
    meso_core::pack(&Spec::from_toml(&spec).unwrap(), &Silent).unwrap()
}

fn in_slabs(model: &Model, itz: ItzForm, slabs: u32) -> Option<Mesh> {
    let method = Method::Conforming { order: Order::Linear, slabs: Some(slabs) };
    with_options(model, MeshOptions { itz, element_size_mm: 6.0, method, ..Default::default() })
}

/// A packing without further phases, and its mesh in three slabs by three threads.
static THREE: LazyLock<(Model, Option<Mesh>)> = LazyLock::new(|| {
    let model = packed("", "");
    let mesh = on_threads(3, || in_slabs(&model, ItzForm::None, 3));
    (model, mesh)
});

fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

/// Every face lies between two cells or on a side of the box.
fn assert_whole(mesh: &Mesh) {
    let on = |corners: &[Vec3; 3], axis: usize, place: f64| corners.iter().all(|corner| corner[axis] == place);
    assert_whole_within(mesh, |corners| (0..3).any(|axis| on(corners, axis, 0.0) || on(corners, axis, SIDE_MM)));
}

/// Every face lies between two cells or where it `is_outside`.
fn assert_whole_within(mesh: &Mesh, is_outside: impl Fn(&[Vec3; 3]) -> bool) {
    let mut faces = BTreeMap::new();
    for cell in mesh.cells() {
        for face in mesh.kind.faces() {
            let mut corners = [0, 1, 2].map(|i| cell[face[i]]);
            corners.sort_unstable();
            *faces.entry(corners).or_insert(0) += 1;
        }
    }
    for (corners, cells) in faces {
        let places = corners.map(|node| mesh.points[node as usize]);
        assert!(cells == 2 || cells == 1 && is_outside(&places), "{cells} cells at {places:?}");
    }
}

#[test]
fn slabs_make_one_mesh_in_which_every_aggregate_has_its_exact_volume() {
    let (model, Some(three)) = &*THREE else { return };
    let [one, four] = [1, 4].map(|slabs| in_slabs(model, ItzForm::None, slabs).unwrap());
    for (slabs, mesh) in [(3, three), (4, &four)] {
        assert_whole(mesh);
        let cells = figures::CellQuality::of_cells(mesh);
        assert!(cells.iter().all(|q| q.volume_mm3 > 0.0));
        assert!(mesh.cell_count() > one.cell_count() && mesh.cell_count() < 2 * one.cell_count(), "{slabs}");
        let mut volumes = vec![0.0; model.aggregates.len()];
        for (q, id) in cells.iter().zip(&mesh.owner).filter(|(_, id)| **id != Mesh::NO_BODY) {
            volumes[*id as usize] += q.volume_mm3;
        }
        for (aggregate, volume) in model.aggregates.iter().zip(volumes) {
            assert!((volume / aggregate.body.volume() - 1.0).abs() < 1e-9, "{slabs}: {}", aggregate.id);
        }
        let [whole, exact] = [mesh, &one].map(PhaseVolumes::of_mesh);
        assert!((whole.mortar / exact.mortar - 1.0).abs() < 1e-9, "{slabs}");
    }
}

#[test]
fn slabs_of_a_periodic_box_match_across_its_faces() {
    let model = packed(", periodic = ['x', 'z']", "");
    let Some(mesh) = in_slabs(&model, ItzForm::None, 3) else { return };
    assert_whole(&mesh);
    let exact = PhaseVolumes::exact(&model.aggregates, &model.spec.specimen, |_| 0.0).unwrap();
    assert!((PhaseVolumes::of_mesh(&mesh).aggregate / exact.aggregate - 1.0).abs() < 1e-12);
    for axis in [0, 2] {
        let on = |place: f64| {
            let on = mesh.points.iter().filter(|point| point[axis] == place);
            let mut within: Vec<[u64; 2]> =
                on.map(|point| [1, 2].map(|next| point[(axis + next) % 3].to_bits())).collect();
            within.sort_unstable();
            within
        };
        assert!(on(0.0) == on(SIDE_MM) && on(0.0).len() > 100, "across {axis}: {}", on(0.0).len());
    }
}

/// The planes between slabs leave no trace: one mesh, with the volumes of the one that a single run gives.
#[test]
fn slabs_of_cylinders_prisms_and_polyhedra_make_one_mesh_with_every_volume_exact() {
    for (specimen, slabs) in [
        ("kind = 'cylinder', diameter_mm = 25, height_mm = 36", 3),
        ("kind = 'cylinder', diameter_mm = 32, height_mm = 20", 2),
        (
            "kind = 'notched-prism', length_mm = 40, width_mm = 20, depth_mm = 25, notch_depth_mm = 8, notch_width_mm = 3",
            2,
        ),
        (
            "kind = 'polyhedron', vertices_mm = [[0,0,0], [30,0,0], [0,34,0], [28,30,0], [4,5,45], [20,6,41], [5,19,43]]",
            2,
        ),
    ] {
        let spec = format!(
            "fraction = 0.25\nspecimen = {{ {specimen} }}\nplacement = {{ min_gap_mm = 0.05, wall_gap_mm = 0.05 }}\n\
             [grading]\nd_min_mm = 5\nd_max_mm = 10\nclasses_mm = [5, 10]\n"
        );
        let model = meso_core::pack(&Spec::from_toml(&spec).unwrap(), &Silent).unwrap();
        let Some(one) = in_slabs(&model, ItzForm::None, 1) else { return };
        let container = model.spec.specimen.container();
        let aggregates: f64 = model.aggregates.iter().map(|a| a.body.volume()).sum();
        assert!(model.aggregates.len() > 10, "{specimen}: {} aggregates", model.aggregates.len());
        let mesh = in_slabs(&model, ItzForm::None, slabs).unwrap();
        // Chords of curved walls are within 0.02 mm of these.
        assert_whole_within(&mesh, |corners| corners.iter().all(|corner| container.depth(corner).abs() < 0.02));
        assert!(figures::CellQuality::of_cells(&mesh).iter().all(|q| q.volume_mm3 > 0.0));
        let [meshed, whole] = [PhaseVolumes::of_mesh(&mesh), PhaseVolumes::of_mesh(&one)];
        assert!((meshed.aggregate / aggregates - 1.0).abs() < 1e-9, "{specimen}");
        assert!((meshed.mortar / whole.mortar - 1.0).abs() < 1e-9, "{specimen}");
        assert!(mesh.points.len() != one.points.len(), "{specimen}: no plane in it");
    }
}

#[test]
fn slabs_take_the_itz_in_any_form_and_voids_and_fibres() {
    let others = "voids = { fraction = 0.02, diameter_mm = [2, 4] }\n\
                  fibres = { fraction = 0.005, length_mm = 10, diameter_mm = 1 }\n";
    let model = packed("", others);
    for itz in [ItzForm::Solid, ItzForm::Cohesive] {
        let Some(mesh) = in_slabs(&model, itz, 2) else { return };
        let thickness = |solid: f64| if itz == ItzForm::Solid { solid } else { 0.0 };
        let exact =
            PhaseVolumes::exact(&model.bodies(), &model.spec.specimen, |a| thickness(a.itz_thickness_mm)).unwrap();
        let meshed = PhaseVolumes::of_mesh(&mesh);
        for (phase, within) in [(Phase::Mortar, 1e-9), (Phase::Fibre, 1e-9), (Phase::Aggregate, 0.01)] {
            assert!((meshed.of(phase) / exact.of(phase) - 1.0).abs() < within, "{itz:?} {phase:?}");
        }
        assert!((meshed.itz - exact.itz).abs() <= 0.015 * exact.itz, "{} {}", meshed.itz, exact.itz);
        assert_eq!(mesh.cohesive().len() > 1000, itz == ItzForm::Cohesive);
    }
}

#[test]
fn slabs_give_the_same_mesh_on_any_number_of_threads() {
    let (model, Some(by_three)) = &*THREE else { return };
    let by_one = on_threads(1, || in_slabs(model, ItzForm::None, 3));
    assert!(by_one.as_ref() == Some(by_three));
}
