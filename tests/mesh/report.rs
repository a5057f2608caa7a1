//! Reports of a finished mesh, conforming ones in a cylinder included: its worst cells, and the phase that it lost.

use crate::mesh::voxel::turned_blocks;
use crate::write::calculix::gmsh;
use meso_core::aggregate::Grading;
use meso_core::materials::Materials;
use meso_core::mesh::figures::{CellQuality, QualityReport};
use meso_core::mesh::{self, ItzForm, MeshError, MeshOptions, Method, Order, Phase, PhaseOff, PhaseVolumes, Tools};
use meso_core::specimen::Specimen;
use meso_core::{Model, Silent, Spec};

fn packed(specimen: Specimen, fraction: f64) -> Model {
    let mut spec = Spec { fraction, specimen, ..Default::default() };
    spec.grading = Grading { d_min_mm: 6.0, d_max_mm: 12.0, classes_mm: vec![6.0, 12.0], ..spec.grading };
    (spec.placement.min_gap_mm, spec.placement.wall_gap_mm) = (0.05, 0.05);
    meso_core::pack(&spec, &Silent).unwrap()
}

#[test]
fn the_report_of_a_mesh_has_the_worst_of_its_cells() {
    let (grains, specimen) = turned_blocks();
    let options =
        MeshOptions { method: Method::FITTED, element_size_mm: 1.5, itz: ItzForm::None, ..Default::default() };
    let mesh = mesh::build((&grains, &specimen), &options, &Tools::default()).unwrap();
    let materials = Materials::default();
    let report = QualityReport::of(&mesh, &grains, &specimen, &materials);

    let cells = CellQuality::of_cells(&mesh);
    assert_eq!(report.cells, cells.len());
    let least = |of: &dyn Fn(&CellQuality) -> f64| cells.iter().map(of).fold(f64::INFINITY, f64::min);
    let has = |(value, index): (f64, usize), of: &dyn Fn(&CellQuality) -> f64| {
        assert_eq!((value, of(&cells[index])), (least(of), least(of)));
        // Among equals the first is reported.
        assert!(cells[..index].iter().all(|cell| of(cell) > value), "{index}");
    };
    has(report.min_dihedral_deg, &|cell| cell.min_dihedral_deg);
    has((-report.max_dihedral_deg.0, report.max_dihedral_deg.1), &|cell| -cell.max_dihedral_deg);
    has(report.min_radius_ratio, &|cell| cell.radius_ratio);
    has(report.shortest_altitude_mm, &|cell| cell.shortest_altitude_mm);

    let below = |degrees: f64| cells.iter().filter(|cell| cell.min_dihedral_deg < degrees).count();
    let upto = |bins: usize| report.dihedral_histogram[..bins].iter().sum::<usize>();
    for (bins, limit) in (1..).zip([1.0, 2.0, 5.0, 8.0, 10.0, 15.0, 30.0]) {
        assert_eq!(upto(bins), below(limit), "{limit}");
    }
    assert!(upto(8) == cells.len() && below(30.0) > 0 && below(30.0) < cells.len());
    assert_eq!(report.bad_cells, CellQuality::below(&cells, QualityReport::BAD_DEG));
    assert_eq!((report.inverted, report.cohesive_time_step_s), (0, None));

    let step = |(cell, phase): (&CellQuality, &Phase)| {
        cell.stable_length_mm / materials.elastic(*phase, &mesh.phases).wave_speed_mm_per_s()
    };
    assert_eq!(report.stable_time_step_s, cells.iter().zip(&mesh.phase).map(step).fold(f64::INFINITY, f64::min));
    let exact = report.exact_volumes_mm3.unwrap();
    let bodies: f64 = grains.iter().map(|grain| grain.body.volume()).sum();
    assert!((exact.aggregate / bodies - 1.0).abs() < 1e-12 && (exact.total() / 27_000.0 - 1.0).abs() < 1e-12);
}

#[test]
fn cells_of_cohesive_elements_have_a_time_step_of_their_own() {
    let (grains, specimen) = turned_blocks();
    let options = MeshOptions { element_size_mm: 2.0, itz: ItzForm::Cohesive, ..Default::default() };
    let mesh = mesh::build((&grains, &specimen), &options, &Tools::default()).unwrap();
    let materials = Materials::default();
    let report = QualityReport::of(&mesh, &grains, &specimen, &materials);
    assert_eq!(report.cohesive_time_step_s, Some(materials.cohesive_time_step_s()));
}

#[test]
fn a_mesh_that_has_far_from_a_phase_is_refused_unless_that_is_accepted() {
    let model = packed(Specimen::cube(40.0), 0.3);
    let coarse = |itz: ItzForm, method: Method| MeshOptions { method, itz, element_size_mm: 4.0, ..Default::default() };
    let build = |options: &MeshOptions, accepted: f64| {
        let mesh = mesh::build(&model, options, &Tools { gmsh: &gmsh, ..Tools::default() })?;
        PhaseOff::accept(&mesh, &model, options, accepted).map(|off| (mesh, off))
    };
    let solid = coarse(ItzForm::Solid, Method::VOXEL);
    let error = build(&solid, PhaseOff::ACCEPTED).unwrap_err();
    assert!(matches!(error, MeshError::PhaseError { .. }), "{error}");
    let said = error.to_string();
    assert!(said.starts_with("the ITZ takes "), "{said}");
    let ways = "take a smaller element_size_mm, the method lattice or conforming, or itz none";
    assert!(said.ends_with(ways), "{said}");

    let (mesh, off) = build(&solid, f64::INFINITY).unwrap();
    let (off, volumes) = (off.unwrap(), PhaseVolumes::of_mesh(&mesh));
    assert_eq!((off.phase, off.meshed), (Phase::Itz, volumes.itz / 64_000.0));
    let exact = PhaseVolumes::exact_for(&mesh, &model.aggregates, &model.spec.specimen).unwrap();
    assert_eq!(off.exact, exact.itz / 64_000.0);
    assert!((off.error() - (volumes.itz / exact.itz - 1.0)).abs() < 1e-12, "{}", off.error());
    assert!(off.error() > 1.0, "{}", off.error());
    // A limit on either side of this error.
    assert!(build(&solid, off.error() * (1.0 + 1e-9)).is_ok() && build(&solid, off.error() * (1.0 - 1e-9)).is_err());

    // Without a shell the same voxels keep every phase.
    let (_, off) = build(&coarse(ItzForm::None, Method::VOXEL), PhaseOff::ACCEPTED).unwrap();
    assert!(off.unwrap().error().abs() < PhaseOff::ACCEPTED);
    // The lattice is as coarse as the grains: another way out.
    let said = build(&coarse(ItzForm::Smeared, Method::FITTED), 0.0).unwrap_err().to_string();
    assert!(said.ends_with("take a smaller element_size_mm, or the method conforming"), "{said}");
}

/// The case `hooked_fibre.toml`: an ITZ of NaN passed the rule of 10 %.
#[test]
fn a_volume_that_is_no_number_is_off_by_more_than_any_share() {
    let volumes = |aggregate: f64, itz: f64| PhaseVolumes { aggregate, itz, mortar: 500.0, ..PhaseVolumes::default() };
    for (meshed, exact) in [
        (volumes(300.0, 200.0), volumes(300.0, f64::NAN)),
        (volumes(300.0, f64::NAN), volumes(300.0, 200.0)),
        (volumes(f64::NAN, 200.0), volumes(100.0, 200.0)),
        (volumes(300.0, f64::INFINITY), volumes(100.0, f64::INFINITY)),
        (volumes(300.0, 200.0), volumes(300.0, -f64::NAN)),
    ] {
        let off = PhaseOff::between(&meshed, &exact, 1000.0).unwrap();
        assert!(
            off.error().is_nan() && [0.0, 0.1, 1e300, f64::INFINITY].map(|share| off.is_beyond(share)) == [true; 4]
        );
    }
    let off = PhaseOff::between(&volumes(300.0, 210.0), &volumes(300.0, 200.0), 1000.0).unwrap();
    assert!(off.phase == Phase::Itz && off.is_beyond(0.049) && !off.is_beyond(0.051) && !off.is_beyond(f64::INFINITY));
}

/// A conforming mesh takes neither spheres nor dents, so that it is no remedy for them.
#[test]
fn a_refused_mesh_of_spheres_names_no_method_that_refuses_them() {
    let text = "fraction = 0.3\nspecimen = { kind = 'cube', side_mm = 40 }\nshape = { kind = 'sphere' }\n";
    let model = meso_core::pack(&Spec::from_toml(text).unwrap(), &Silent).unwrap();
    for (method, itz, ways) in [
        (Method::VOXEL, ItzForm::Solid, "take a smaller element_size_mm, the method lattice, or itz none"),
        (Method::FITTED, ItzForm::Solid, "take a smaller element_size_mm, or itz none"),
        (Method::FITTED, ItzForm::None, "take a smaller element_size_mm"),
    ] {
        let options = MeshOptions { method, itz, element_size_mm: 5.0, ..Default::default() };
        let mesh = mesh::build(&model, &options, &Tools::default()).unwrap();
        let error = PhaseOff::accept(&mesh, &model, &options, 0.0).unwrap_err().to_string();
        assert!(error.ends_with(ways), "{error}");
    }
}

#[test]
fn a_conforming_mesh_fills_a_cylinder_to_its_curved_side_whole_or_in_slabs() {
    let model = packed(Specimen::Cylinder { diameter_mm: 30.0, height_mm: 60.0 }, 0.25);
    let bodies: f64 = model.aggregates.iter().map(|aggregate| aggregate.body.volume()).sum();
    for slabs in [1, 2] {
        let method = Method::Conforming { order: Order::Linear, slabs: Some(slabs) };
        let options = MeshOptions { method, itz: ItzForm::None, element_size_mm: 3.0, ..Default::default() };
        let mesh = match mesh::build(&model, &options, &Tools { gmsh: &gmsh, ..Tools::default() }) {
            Err(MeshError::Gmsh(why)) => return eprintln!("skipped: no `gmsh` here (Debian: gmsh): {why}"),
            meshed => meshed.unwrap(),
        };
        assert!(CellQuality::of_cells(&mesh).iter().all(|cell| cell.volume_mm3 > 0.0));
        let volumes = PhaseVolumes::of_mesh(&mesh);
        assert!((volumes.aggregate / bodies - 1.0).abs() < 1e-9, "{} {bodies}", volumes.aggregate);
        // The side has chords: they lie inside of it, and take less than 2 %.
        let whole = volumes.total() / model.spec.specimen.volume();
        assert!((0.98..1.0).contains(&whole), "{whole}");
        let farthest = mesh.points.iter().map(|p| (p.x - 15.0).hypot(p.y - 15.0)).fold(0.0, f64::max);
        assert!((farthest / 15.0 - 1.0).abs() < 1e-12, "{farthest}");
    }
}
