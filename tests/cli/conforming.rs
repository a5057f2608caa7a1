//! Conforming meshes by gmsh. Those that need it skip, with a message, where no program `gmsh` is on the PATH.

use crate::command::Folder;
use crate::layer_errors::LayerErrors;
use meso_core::aggregate::{Aggregate, Kind};
use meso_core::export::abaqus::{self, DeckOptions};
use meso_core::mesh::VolumeMesher;
use meso_core::mesh::conforming::Surfaces;
use meso_core::mesh::{self, CellKind, ItzForm, Mesh, MeshOptions, Method, Order, Phase, PhaseVolumes, Tools, figures};
use meso_core::specimen::Specimen;
use meso_core::{Model, Silent, Spec};
use meso_gmsh::Gmsh;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

/// A dense packing of 24 mm with room to mesh between its grains.
fn packed(gap_mm: f64) -> Model {
    let mut spec = Spec { fraction: 0.45, specimen: Specimen::cube(24.0), ..Default::default() };
    (spec.placement.min_gap_mm, spec.placement.wall_gap_mm) = (gap_mm, gap_mm);
    meso_core::pack(&spec, &Silent).unwrap()
}

fn conforming(model: &Model, itz: ItzForm) -> Option<Mesh> {
    with_options(model, MeshOptions { itz, ..Default::default() })
}

/// Whether gmsh is here.
pub(crate) fn has_gmsh() -> bool {
    // Python's package takes 0.1 s of processor time to say its version.
    static HERE: LazyLock<bool> = LazyLock::new(|| Gmsh::program("gmsh").available().is_ok());
    if !*HERE {
        eprintln!("skipped: no `gmsh` here (Debian: gmsh)");
    }
    *HERE
}

/// The conforming mesh; `None` without gmsh.
pub(crate) fn with_options(model: &Model, options: MeshOptions) -> Option<Mesh> {
    if !has_gmsh() {
        return None;
    }
    let method = match options.method {
        conforming @ Method::Conforming { .. } => conforming,
        _ => Method::CONFORMING,
    };
    Some(
        mesh::build(
            model,
            &MeshOptions { method, ..options },
            &Tools { gmsh: &Gmsh::program("gmsh"), ..Tools::default() },
        )
        .unwrap(),
    )
}

#[test]
fn a_conforming_mesh_has_every_aggregates_exact_volume() {
    let model = packed(0.05);
    let Some(mesh) = conforming(&model, ItzForm::None) else { return };
    let cells = figures::CellQuality::of_cells(&mesh);
    assert!(cells.iter().all(|q| q.volume_mm3 > 0.0));
    assert!((cells.iter().map(|q| q.volume_mm3).sum::<f64>() / 13_824.0 - 1.0).abs() < 1e-12);
    let mut volumes = vec![0.0; model.aggregates.len()];
    for (q, id) in cells.iter().zip(&mesh.owner).filter(|(_, id)| **id != Mesh::NO_BODY) {
        volumes[*id as usize] += q.volume_mm3;
    }
    for (aggregate, volume) in model.aggregates.iter().zip(volumes) {
        assert!((volume / aggregate.body.volume() - 1.0).abs() < 1e-9, "{}", aggregate.id);
    }
}

#[test]
fn the_solid_itz_of_a_conforming_mesh_is_as_thick_as_asked() {
    let model = packed(0.05);
    let Some(mesh) = conforming(&model, ItzForm::Solid) else { return };
    assert!(figures::CellQuality::of_cells(&mesh).iter().all(|q| q.volume_mm3 > 0.0));
    let exact = PhaseVolumes::exact(&model.aggregates, &model.spec.specimen, |a| a.itz_thickness_mm).unwrap();
    let itz = PhaseVolumes::of_mesh(&mesh).itz;
    // Measured: 0.5 % too small.
    assert!((itz / exact.itz - 1.0).abs() < 0.01, "{itz} {}", exact.itz);
    let layer = LayerErrors::of(&mesh, &model);
    assert!(layer.area_mm2 > 0.95 * model.aggregates.iter().map(core_area).sum::<f64>(), "{layer:?}");
    assert!(layer.rms_mm < 0.01, "{layer:?}");
    assert_eq!((mesh.notes.thinned_itz_aggregates, mesh.notes.thinned_itz_nodes), (0, 0));
}

fn core_area(aggregate: &Aggregate) -> f64 {
    aggregate.body.inward_offset(aggregate.itz_thickness_mm).unwrap().expect("the core is there").area()
}

#[test]
fn a_second_order_conforming_mesh_has_the_same_shape_with_one_node_in_the_middle_of_every_edge() {
    let model = packed(0.05);
    let of_order = |order| {
        let method = Method::Conforming { order, slabs: None };
        with_options(&model, MeshOptions { method, element_size_mm: 3.0, ..Default::default() })
    };
    let (Some(first), Some(second)) = (of_order(Order::Linear), of_order(Order::Quadratic)) else { return };
    assert_eq!(second.kind, CellKind::QuadraticTetrahedron);
    assert_eq!((&first.phase, &first.owner), (&second.phase, &second.owner));
    let mut middles = BTreeMap::new();
    for (corners, cell) in first.cells().zip(second.cells()) {
        assert_eq!(corners, &cell[..4]);
        let at = |i: usize| second.points[cell[i] as usize];
        for ([i, j], middle) in [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]].into_iter().zip(4..) {
            assert!((at(middle) - (at(i) + at(j)) / 2.0).norm() < 1e-12);
            let edge = (cell[i].min(cell[j]), cell[i].max(cell[j]));
            assert_eq!(*middles.entry(edge).or_insert(cell[middle]), cell[middle], "an edge has one middle");
        }
    }
    assert_eq!(second.points.len(), first.points.len() + middles.len());
    let [volumes, same] = [&first, &second].map(PhaseVolumes::of_mesh);
    assert!(volumes == same && volumes.itz > 0.0);
    let mut deck = Vec::new();
    abaqus::write(&second, &DeckOptions::default(), &mut deck).unwrap();
    let deck = String::from_utf8(deck).unwrap();
    assert!(["AGGREGATE", "ITZ", "MORTAR"].iter().all(|set| deck.contains(&format!("TYPE=C3D10, ELSET={set}"))));
}

#[test]
fn elements_as_coarse_as_the_aggregates_end() {
    assert_coarse_elements_end(30.0);
}

/// gmsh did not end here before it had nodes at the aggregates' centres.
#[test]
#[ignore = "slow: a cube of 60 mm"]
fn slow_elements_as_coarse_as_hundreds_of_aggregates_end() {
    assert_coarse_elements_end(60.0);
}

fn assert_coarse_elements_end(side_mm: f64) {
    let mut spec = Spec { fraction: 0.5, specimen: Specimen::cube(side_mm), ..Default::default() };
    (spec.placement.min_gap_mm, spec.placement.wall_gap_mm) = (0.05, 0.05);
    let model = meso_core::pack(&spec, &Silent).unwrap();
    assert!(model.aggregates.len() as f64 > 0.0037 * side_mm.powi(3), "{}", model.aggregates.len());
    let options = MeshOptions { element_size_mm: 4.0, itz: ItzForm::None, ..Default::default() };
    let Some(mesh) = with_options(&model, options) else { return };
    let exact: f64 = model.aggregates.iter().map(|a| a.body.volume()).sum();
    assert!((PhaseVolumes::of_mesh(&mesh).aggregate / exact - 1.0).abs() < 1e-9);
    // That of its centre, which may have moved for better angles.
    let mut held = vec![BTreeSet::new(); mesh.points.len()];
    for (cell, id) in mesh.cells().zip(&mesh.owner) {
        for &node in cell {
            held[node as usize].insert(*id);
        }
    }
    let inside: BTreeSet<u32> = held.iter().filter(|held| held.len() == 1).flatten().copied().collect();
    assert!(model.aggregates.iter().all(|a| inside.contains(&a.id)), "each aggregate has a node inside");
}

#[test]
fn aggregates_that_nearly_touch_are_named_at_once_with_the_remedy() {
    let (model, options) = (packed(0.0), MeshOptions { method: Method::CONFORMING, ..Default::default() });
    let error = mesh::build(
        &model,
        &options,
        &Tools { gmsh: &|_: &Surfaces| panic!("gmsh must not be asked"), ..Tools::default() },
    )
    .unwrap_err()
    .to_string();
    assert!(error.starts_with("aggregate ") && error.contains("too close for a conforming mesh"), "{error}");
    assert!(error.contains("min_gap_mm = 0.05 and wall_gap_mm = 0.05 or more under [placement]"), "{error}");
}

#[test]
fn one_command_packs_with_the_gaps_that_gmsh_needs_and_writes_the_deck() {
    if !has_gmsh() {
        return;
    }
    let folder = Folder::with_spec();
    let conforming = ["--method", "conforming", "--element-size-mm", "5", "--analysis", "elastic"];
    let run = folder.run(&[&["pack", "small.toml", "-o", "m.inp", "-o", "m.json"][..], &conforming[..]].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("packing with gaps of 0.05 mm, which a conforming mesh needs"), "{}", run.stderr);
    assert!(folder.read("m.inp").windows(7).any(|w| w == b"*STATIC"));
    let model = meso_core::saved::read(&folder.read("m.json")).unwrap();
    assert_eq!((model.spec.placement.min_gap_mm, model.spec.placement.wall_gap_mm), (0.05, 0.05));
    // Gaps that are asked for are kept.
    let wider = ["--min-gap-mm", "0.2", "--wall-gap-mm", "0.1", "--quiet"];
    let run = folder.run(&[&["pack", "small.toml", "-o", "w.json"][..], &conforming[..2], &wider].concat());
    assert_eq!((run.code, run.stderr.as_str()), (0, ""));
    let model = meso_core::saved::read(&folder.read("w.json")).unwrap();
    assert_eq!((model.spec.placement.min_gap_mm, model.spec.placement.wall_gap_mm), (0.2, 0.1));
}

#[test]
fn the_command_that_refuses_a_packing_names_the_one_that_leaves_room() {
    if !has_gmsh() {
        return;
    }
    let folder = Folder::new();
    std::fs::write(folder.path("tight.json"), {
        let mut bytes = Vec::new();
        meso_core::saved::write(&packed(0.0), &mut bytes).unwrap();
        bytes
    })
    .unwrap();
    let run = folder.run(&["mesh", "tight.json", "-o", "m.inp", "--method", "conforming"]);
    assert!(run.code == 1 && run.stderr.contains("min_gap_mm = 0.05"), "{}", run.stderr);
    assert!(
        run.stderr.contains("a packing that is made with --method conforming leaves such gaps by itself"),
        "{}",
        run.stderr
    );
}

#[test]
fn voids_are_holes_and_fibres_bodies_of_their_exact_volumes_in_a_conforming_mesh() {
    let spec = "fraction = 0.25\nspecimen = { kind = 'cube', side_mm = 24 }\n\
                placement = { min_gap_mm = 0.05, wall_gap_mm = 0.05 }\n\
                voids = { fraction = 0.02, diameter_mm = [2, 4] }\n\
                fibres = { fraction = 0.008, length_mm = 10, diameter_mm = 1 }\n";
    let model = meso_core::pack(&Spec::from_toml(spec).unwrap(), &Silent).unwrap();
    let bodies = model.bodies();
    let count = |kind| bodies.iter().filter(|body| body.kind == kind).count();
    assert!(count(Kind::Void) > 10 && count(Kind::Fibre) > 10, "{} {}", count(Kind::Void), count(Kind::Fibre));
    for itz in [ItzForm::None, ItzForm::Solid, ItzForm::Cohesive] {
        let options = MeshOptions { itz, element_size_mm: 6.0, ..Default::default() };
        let Some(mesh) = with_options(&model, options) else { return };
        let [meshed, exact] = [
            PhaseVolumes::of_mesh(&mesh),
            PhaseVolumes::exact(&bodies, &model.spec.specimen, |a| {
                if itz == ItzForm::Solid { a.itz_thickness_mm } else { 0.0 }
            })
            .unwrap(),
        ];
        for (phase, within) in [(Phase::Mortar, 1e-9), (Phase::Fibre, 1e-9), (Phase::Aggregate, 0.01)] {
            assert!(
                (meshed.of(phase) / exact.of(phase) - 1.0).abs() < within,
                "{itz:?} {phase:?} {meshed:?} {exact:?}"
            );
        }
        assert_eq!(mesh.cohesive().len() > 1000, itz == ItzForm::Cohesive);
        for (nodes, id) in mesh.cohesive().zip(&mesh.cohesive_owner) {
            let at = |i: usize| mesh.points[nodes[i] as usize];
            assert!((0..3).all(|i| at(i) == at(i + 3) && nodes[i] != nodes[i + 3]), "{nodes:?}");
            let body = &bodies.iter().find(|body| body.id == *id).unwrap().body;
            let normal = (at(1) - at(0)).cross(&(at(2) - at(0)));
            assert!(normal.dot(&(at(0) - body.centroid())) > 0.0, "the normal leads out of the aggregate");
        }
        let held: BTreeSet<u32> = mesh.owner.iter().copied().filter(|id| *id != Mesh::NO_BODY).collect();
        let solid: BTreeSet<u32> = bodies.iter().filter(|b| b.kind != Kind::Void).map(|b| b.id).collect();
        assert_eq!(held, solid);
    }
}

#[test]
fn where_gmsh_is_missing_the_command_says_how_to_get_it() {
    let folder = Folder::with_spec();
    folder.write("gap.toml", "fraction = 0.2\nspecimen = {kind = \"cube\", side_mm = 30.0}\nplacement = {min_gap_mm = 0.1, wall_gap_mm = 0.1}\n");
    assert_eq!(folder.run(&["pack", "gap.toml", "-o", "model.json"]).code, 0);
    let run = folder.run(&["mesh", "model.json", "-o", "m.vtu", "--method", "conforming", "--gmsh", "./no-gmsh"]);
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(
        run.stderr.contains("./no-gmsh cannot be run") && run.stderr.contains("pip install gmsh"),
        "{}",
        run.stderr
    );
    assert!(!folder.names().contains(&"m.vtu".to_owned()));
}

#[cfg(unix)]
#[test]
fn a_gmsh_that_does_not_run_is_told_before_any_work() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::with_spec();
    folder.write("broken", "#!/bin/sh\necho \"No module named 'gmsh'\" >&2\nexit 1\n");
    std::fs::set_permissions(folder.path("broken"), std::fs::Permissions::from_mode(0o755)).unwrap();
    let run = folder.run(&["pack", "small.toml", "-o", "m.msh", "--method", "conforming", "--gmsh", "./broken"]);
    assert_eq!(run.code, 1, "{}", run.stderr);
    for said in ["./broken --version failed (exit status: 1)", "pip install gmsh", "No module named 'gmsh'"] {
        assert!(run.stderr.contains(said), "{}", run.stderr);
    }
    assert!(!run.stderr.contains("packed"), "{}", run.stderr);
}
