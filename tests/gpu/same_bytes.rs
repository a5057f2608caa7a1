//! A device gives the bytes of the processor.

use meso_core::aggregate::Grading;
use meso_core::materials::Materials;
use meso_core::mesh::{self, ItzForm, Joined, Mesh, MeshOptions, Method, Tools};
use meso_core::specimen::Specimen;
use meso_core::{Silent, Spec};
use meso_gpu::{DeviceName, attach_in_groups, devices};
use meso_solve::{Control, LawName, Run, Sample, Smoothing, Test, TestKind};

pub(crate) struct Cube {
    pub(crate) mesh: Mesh,
    pub(crate) specimen: Specimen,
    pub(crate) options: MeshOptions,
}

pub(crate) fn cube(element_size_mm: f64) -> Cube {
    let specimen = Specimen::cube(24.0);
    let mut spec = Spec { specimen: specimen.clone(), fraction: 0.3, seed: 3, ..Spec::default() };
    spec.grading = Grading { d_min_mm: 4.0, d_max_mm: 10.0, classes_mm: vec![4.0, 7.0, 10.0], ..Grading::default() };
    spec.placement.min_gap_mm = 1.0;
    let model = meso_core::pack(&spec, &Silent).unwrap();
    let options = MeshOptions {
        method: Method::FITTED,
        element_size_mm,
        itz: ItzForm::Smeared,
        joined: Joined::Mortar,
        ..Default::default()
    };
    let mesh = mesh::build(&model, &options, &Tools::default()).unwrap();
    Cube { mesh, specimen, options }
}

pub(crate) fn brittle() -> Materials {
    let mut materials = Materials::default();
    materials.mortar_strength.crushing_energy_n_per_mm = 0.5;
    materials.plasticity.meridian_ratio = 0.8;
    materials
}

/// The state at the end, as a checkpoint stores it: curve, sums, fields and memory.
fn state(cube: &Cube, test: &Test, device: Option<(&DeviceName, usize)>) -> (Vec<u8>, Vec<[f64; 11]>) {
    let sample = Sample::of(&cube.mesh, &cube.specimen, &cube.options);
    let mut run = Run::new(sample, &brittle(), test).unwrap();
    if let Some((device, threads)) = device {
        attach_in_groups(&mut run, device, threads).unwrap();
    }
    let response = run.to_end(&Silent, &Silent);
    let mut bytes = Vec::new();
    run.save(&[], &mut bytes).unwrap();
    (bytes, response.curve.iter().map(|row| row.values()).collect())
}

fn pocl() -> Option<DeviceName> {
    let found = devices().into_iter().find(|device| device.faults.is_empty());
    if found.is_none() {
        eprintln!("skipped: no device keeps the promise here (Debian: pocl-opencl-icd, ocl-icd-libopencl1)");
    }
    found
}

#[test]
fn every_law_smoothing_test_and_control_has_the_bytes_of_the_processor() {
    let Some(device) = pocl() else { return };
    let cube = cube(4.0);
    for law in [LawName::Cdp, LawName::Cdpm2, LawName::Elastic] {
        for smoothing in [Smoothing::Edges, Smoothing::None] {
            for kind in [TestKind::Compression, TestKind::Tension] {
                for control in [Control::Steady, Control::Servo] {
                    let smoothing = Some(smoothing);
                    let mut test = Test { law, smoothing, kind, control, rows: 50, ..Test::default() };
                    test.time_step_s = Some(test.duration_s(24.0) / 1200.0);
                    let (expected, curve) = state(&cube, &test, None);
                    let (got, other) = state(&cube, &test, Some((&device, 64)));
                    for (i, (a, b)) in curve.iter().zip(&other).enumerate() {
                        assert_eq!(a, b, "row {i} of {test:?}");
                    }
                    assert!(expected == got, "{test:?}");
                }
            }
        }
    }
}
