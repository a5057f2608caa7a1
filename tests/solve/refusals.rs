//! Samples and values that cannot be tested are refused before the first step, by name and with a remedy.

use crate::samples::{Meshed, options};
use meso_core::materials::Materials;
use meso_core::math::Vec3;
use meso_core::mesh::{ItzForm, Mesh, Method};
use meso_core::specimen::Specimen;
use meso_solve::{Gauge, Interface, Run, Sample, Smoothing, Test};

fn refusal(sample: Sample, materials: &Materials, test: &Test) -> String {
    Run::new(sample, materials, test).err().expect("a refusal").to_string()
}

fn cube() -> Meshed {
    Meshed::mortar([6.0; 3], Method::FITTED, 3.0)
}

#[test]
fn values_out_of_range_are_named_with_what_is_accepted() {
    let meshed = cube();
    let base = Test::default();
    let named = |name: &str| Test { gauges: vec![Gauge::LateralStrain { name: name.to_owned() }], ..base.clone() };
    for (test, text) in [
        (Test { strain: Some(0.0), ..base.clone() }, "test.strain is 0; it must be 1e-12 to 0.1"),
        (Test { strain: Some(-1e-3), ..base.clone() }, "test.strain is -0.001"),
        (Test { strain: Some(5e-324), ..base.clone() }, "and single precision carries no smaller ones"),
        (Test { strain: Some(9.9e-13), ..base.clone() }, "test.strain is"),
        (Test { strain: Some(f64::NAN), ..base.clone() }, "test.strain is NaN"),
        (Test { friction: Some(-0.1), ..base.clone() }, "test.friction is -0.1; it must be 0 to 10"),
        (Test { ramp: 0.0, ..base.clone() }, "test.ramp is 0"),
        (Test { hourglass: 2.0, ..base.clone() }, "test.hourglass is 2"),
        (Test { time_step_s: Some(-1.0), ..base.clone() }, "test.time_step_s is -1"),
        (Test { time_step_s: Some(1.0), ..base.clone() }, "they must be 10 to 1e9"),
        (Test { duration_s: Some(f64::INFINITY), ..base.clone() }, "test.duration_s is inf"),
        (Test { interface: Interface { friction: f64::NAN }, ..base.clone() }, "test.interface.friction"),
        (named("strain"), "test.gauges.name is strain; every curve has this column; take another name"),
        (named("a,b"), "test.gauges.name is a,b; it must be letters, digits and _"),
        (named("a_n"), "it must not end in _n, as columns of supports' forces do"),
    ] {
        let error = refusal(meshed.sample(), &Materials::default(), &test);
        assert!(error.contains(text), "{error}");
    }
}

#[test]
fn materials_that_cannot_be_are_named() {
    let meshed = cube();
    for (change, text) in [
        (
            (|m: &mut Materials| m.mortar.youngs_modulus_mpa = -1.0) as fn(&mut Materials),
            "materials.mortar.youngs_modulus_mpa is -1",
        ),
        (|m| m.mortar.poisson_ratio = 0.5, "materials.mortar.poisson_ratio is 0.5"),
        (|m| m.mortar.density_t_per_mm3 = 2400.0, "2400 kg/m3 are 2.4e-9"),
        (|m| m.mortar_strength.tensile_mpa = f64::NAN, "materials.mortar_strength.tensile_mpa is NaN"),
        (|m| m.plasticity.meridian_ratio = 0.5, "materials.plasticity.meridian_ratio is 0.5"),
        (|m| m.aggregate.youngs_modulus_mpa = 1e-30, "aggregate.youngs_modulus_mpa is"),
        (|m| m.mortar.youngs_modulus_mpa = 1e40, "the solver computes in single precision and takes 1e-12 to 1e12"),
        (|m| m.mortar_strength.tensile_mpa = 1e-200, "materials.mortar_strength.tensile_mpa is"),
        (|m| m.mortar_strength.fracture_energy_n_per_mm = 1e300, "mortar_strength.fracture_energy_n_per_mm is"),
        (|m| m.mortar_strength.crushing_energy_n_per_mm = Some(1e-40), "mortar_strength.crushing_energy_n_per_mm is"),
    ] {
        let mut materials = Materials::default();
        change(&mut materials);
        let error = refusal(meshed.sample(), &materials, &Test::default());
        assert!(error.contains(text), "{error}");
    }
}

#[test]
fn boxes_are_not_smoothed() {
    let meshed = Meshed::mortar([6.0; 3], Method::VOXEL, 3.0);
    let test = Test { smoothing: Some(Smoothing::Edges), ..Test::default() };
    let error = refusal(meshed.sample(), &Materials::default(), &test);
    assert!(error.contains("boxes cannot be smoothed over edges; take tetrahedra"), "{error}");
}

#[test]
fn meshes_that_cannot_be_tested_are_refused() {
    let refused = |change: fn(&mut Mesh)| {
        let mut meshed = cube();
        change(&mut meshed.mesh);
        refusal(meshed.sample(), &Materials::default(), &Test::default())
    };
    let flat = refused(|mesh| mesh.points[mesh.cells[1] as usize] = mesh.points[mesh.cells[0] as usize]);
    assert!(flat.contains("has the volume 0 mm3; mesh anew"), "{flat}");
    let turned = refused(|mesh| mesh.cells.swap(0, 1));
    assert!(turned.contains("has the volume -"), "{turned}");
    let empty = refused(|mesh| {
        mesh.cells.clear();
        mesh.phase.clear();
        mesh.owner.clear();
    });
    assert!(empty.contains("it has no cells"), "{empty}");
    let spike = refused(|mesh| {
        mesh.points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, 0.3, 10.0]].map(Vec3::from).to_vec();
        mesh.cells = vec![0, 1, 2, 3];
        mesh.phase.truncate(1);
        mesh.owner.truncate(1);
    });
    assert!(spike.contains("no face points to its upper plate"), "{spike}");
}

#[test]
fn hexahedra_that_are_no_boxes_are_refused() {
    let mut meshed = Meshed::mortar([6.0; 3], Method::VOXEL, 3.0);
    meshed.mesh.points[13].x += 0.1;
    let error = refusal(meshed.sample(), &Materials::default(), &Test::default());
    assert!(error.contains("is no box like the first one"), "{error}");
}

/// Case `voxel_cylinder.toml`: forces over the gross section gave a cylinder of 6 voxels in diameter 12 % too much strength.
#[test]
fn voxels_that_do_not_fill_a_round_specimen_are_refused() {
    let meshed = |specimen: Specimen, method, size| Meshed::of(&[], specimen, options(method, size, ItzForm::None));
    let cylinder = |diameter_mm| Specimen::Cylinder { diameter_mm, height_mm: 24.0 };
    let sphere = Specimen::Sphere { diameter_mm: 24.0 };
    for (meshed, share) in [
        (meshed(cylinder(12.0), Method::VOXEL, 2.0), "113.2 %"),
        (meshed(cylinder(20.0), Method::VOXEL, 4.0), "107.0 %"),
        (meshed(sphere, Method::VOXEL, 4.0), "%"),
    ] {
        let error = refusal(meshed.sample(), &Materials::default(), &Test::default());
        assert!(error.contains("of the specimen's volume") && error.contains(share), "{error}");
        assert!(error.contains("the method lattice, whose surface follows the specimen"), "{error}");
    }
    let fitted = meshed(cylinder(24.0), Method::FITTED, 3.0);
    assert!(Run::new(fitted.sample(), &Materials::default(), &Test::default()).is_ok());
    let fine = meshed(cylinder(24.0), Method::VOXEL, 1.0);
    assert!(Run::new(fine.sample(), &Materials::default(), &Test::default()).is_ok());
}
