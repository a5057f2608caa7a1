//! A device gives the bytes of the processor.

use meso_core::aggregate::Grading;
use meso_core::materials::Materials;
use meso_core::mesh::{self, ItzForm, Joined, Mesh, MeshOptions, Method, Tools};
use meso_core::specimen::Specimen;
use meso_core::{Silent, Spec};
use meso_gpu::{DeviceName, attach, devices};
use meso_solve::{
    Control, Ended, Frame, Geometry, LawName, Observer, Response, Run, Sample, Smoothing, Test, TestKind,
};
use std::cell::RefCell;

pub(crate) struct Cube {
    pub(crate) mesh: Mesh,
    pub(crate) specimen: Specimen,
    pub(crate) options: MeshOptions,
}

pub(crate) fn cube(side_mm: f64, element_size_mm: f64) -> Cube {
    let specimen = Specimen::cube(side_mm);
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

impl Cube {
    pub(crate) fn run(&self, test: &Test) -> Run<'_> {
        Run::new(Sample::of(&self.mesh, &self.specimen, &self.options), &brittle(), test).unwrap()
    }

    /// A test of some 1,000 steps.
    fn short(&self, test: Test) -> Test {
        let duration = test.duration_s(&Geometry::of(&self.specimen));
        Test { time_step_s: Some(duration / 1000.0), rows: 50, ..test }
    }
}

/// Frames as bytes, and the state after one of them.
#[derive(Default)]
struct Frames {
    fields: RefCell<Vec<Vec<u32>>>,
    kept: RefCell<Option<Vec<u8>>>,
    keeps: bool,
}

impl Observer for Frames {
    fn frame(&self, frame: &Frame) {
        let moved = frame.displacement().into_iter().flatten();
        let stress = frame.cells(|point| point.stress);
        self.fields.borrow_mut().push(moved.chain(stress.into_iter().flatten()).map(f32::to_bits).collect());
    }

    fn keeps(&self) -> bool {
        self.keeps && self.fields.borrow().len() == 1 && self.kept.borrow().is_none()
    }

    fn keep(&self, run: &Run) {
        *self.kept.borrow_mut() = Some(saved(run));
    }
}

/// A checkpoint: curve, sums, fields and memory.
fn saved(run: &Run) -> Vec<u8> {
    let mut bytes = Vec::new();
    run.save(&[], &mut bytes).unwrap();
    bytes
}

fn finish(run: &mut Run, frames: &Frames) -> (Response, Vec<u8>) {
    let response = run.to_end(&Silent, frames);
    assert_eq!(response.result.ended, Ended::Completed);
    (response, saved(run))
}

/// A device that rounds as the processor does.
fn device() -> Option<DeviceName> {
    let found = devices().into_iter().find(|device| device.faults.is_empty());
    if found.is_none() {
        eprintln!("skipped: no device keeps the promise here (Debian: pocl-opencl-icd, ocl-icd-libopencl1)");
    }
    found
}

#[test]
fn a_device_has_the_bytes_of_the_processor_under_every_law_smoothing_test_and_control() {
    use Control::{Servo, Steady};
    use Smoothing::{Edges, None};
    use TestKind::{Compression, Tension};
    let Some(device) = device() else { return };
    let cube = cube(20.0, 4.0);
    for (law, smoothing, kind, control, threads) in [
        (LawName::Cdp, Edges, Compression, Servo, 64),
        (LawName::Cdp, Edges, Tension, Steady, 128),
        (LawName::Cdp, None, Compression, Steady, 64),
        (LawName::Cdp, None, Tension, Servo, 64),
        (LawName::Cdpm2, Edges, Compression, Servo, 64),
        (LawName::Cdpm2, None, Tension, Servo, 64),
        (LawName::Elastic, Edges, Compression, Servo, 32),
    ] {
        let test = cube.short(Test { law, smoothing: Some(smoothing), kind, control, frames: 2, ..Test::default() });
        let (mut here, mut there) = (cube.run(&test), cube.run(&test));
        attach(&mut there, &DeviceName { threads, ..device.clone() }).unwrap();
        let (own, others) = (Frames::default(), Frames::default());
        let (expected, got) = (finish(&mut here, &own), finish(&mut there, &others));
        for (row, (a, b)) in expected.0.curve.iter().zip(&got.0.curve).enumerate() {
            assert_eq!(a, b, "row {row} of {test:?}");
        }
        assert!(expected.1 == got.1, "{test:?}");
        assert!(own.fields == others.fields && own.fields.borrow().len() >= 2, "{test:?}");
        assert!(expected.0.result.energies.dissipated > 0.0 || law == LawName::Elastic, "{test:?}");
    }
}

#[test]
fn a_checkpoint_moves_from_the_processor_to_a_device_and_back() {
    let Some(device) = device() else { return };
    let cube = cube(20.0, 4.0);
    let test = cube.short(Test { frames: 2, ..Test::default() });
    let states = [false, true].map(|is_there| {
        let (mut run, frames) = (cube.run(&test), Frames { keeps: true, ..Frames::default() });
        if is_there {
            attach(&mut run, &device).unwrap();
        }
        let (_, end) = finish(&mut run, &frames);
        (frames.kept.into_inner().unwrap(), end)
    });
    let [(kept, end), other] = &states;
    assert!((kept, end) == (&other.0, &other.1));
    for goes_on_there in [false, true] {
        let mut run = cube.run(&test);
        run.resume(&mut &kept[..]).unwrap();
        if goes_on_there {
            attach(&mut run, &device).unwrap();
        }
        assert!(finish(&mut run, &Frames::default()).1 == *end, "{goes_on_there}");
    }
}

#[test]
fn a_mesh_that_devices_have_no_code_for_is_refused_with_the_remedy() {
    let specimen = Specimen::cube(20.0);
    let options = MeshOptions { method: Method::VOXEL, element_size_mm: 5.0, itz: ItzForm::None, ..Default::default() };
    let mesh = mesh::build((&[][..], &specimen), &options, &Tools::default()).unwrap();
    let run = Run::new(Sample::of(&mesh, &specimen, &options), &brittle(), &Test::default()).unwrap();
    let Err(error) = run.upload() else { panic!("accepted") };
    assert!(error.to_string().contains("the device cpu"), "{error}");
}
