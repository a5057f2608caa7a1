//! A device gives the bytes of the processor.

use meso_core::aggregate::Grading;
use meso_core::materials::{
    Covariance, Materials, OwnMaterial, Scatter, ScatteredPhase, Stone, StoneKind, StrengthDistribution,
};
use meso_core::mesh::{self, ItzForm, Joined, Mesh, MeshOptions, Method, Phase, Tools};
use meso_core::specimen::Specimen;
use meso_core::{Silent, Spec};
use meso_gpu::{DeviceName, attach, devices};
use meso_solve::{
    Along, Below, Control, Course, Ended, Expansion, Frame, Gauge, Geometry, LawName, Observer, Response, Rule, Run,
    Sample, Side, Smoothing, SupportSpec, Test, TestKind, Turn, TurnOf,
};
use std::cell::RefCell;

pub(crate) struct Cube {
    pub(crate) mesh: Mesh,
    pub(crate) specimen: Specimen,
    pub(crate) options: MeshOptions,
    pub(crate) materials: Materials,
}

pub(crate) fn cube(side_mm: f64, element_size_mm: f64) -> Cube {
    meshed(Specimen::cube(side_mm), element_size_mm, ItzForm::Smeared)
}

/// A notched beam of mortar along x.
fn beam() -> Cube {
    let specimen = Specimen::NotchedPrism {
        length_mm: 57.6,
        width_mm: 12.0,
        depth_mm: 16.0,
        notch_depth_mm: 4.0,
        upper_notch_depth_mm: 0.0,
        notch_at_mm: 0.0,
        notch_width_mm: 4.0,
    };
    let options =
        MeshOptions { method: Method::FITTED, element_size_mm: 4.0, itz: ItzForm::None, ..Default::default() };
    let mesh = mesh::build((&[][..], &specimen), &options, &Tools::default()).unwrap();
    Cube { mesh, specimen, options, materials: brittle() }
}

pub(crate) fn meshed(specimen: Specimen, element_size_mm: f64, itz: ItzForm) -> Cube {
    let mut spec = Spec { specimen: specimen.clone(), fraction: 0.3, seed: 3, ..Spec::default() };
    spec.grading = Grading { d_min_mm: 4.0, d_max_mm: 10.0, classes_mm: vec![4.0, 7.0, 10.0], ..Grading::default() };
    spec.placement.min_gap_mm = 1.0;
    let model = meso_core::pack(&spec, &Silent).unwrap();
    let options =
        MeshOptions { method: Method::FITTED, element_size_mm, itz, joined: Joined::Mortar, ..Default::default() };
    let mesh = mesh::build(&model, &options, &Tools::default()).unwrap();
    Cube { mesh, specimen, options, materials: brittle() }
}

pub(crate) fn brittle() -> Materials {
    let mut materials = Materials::default();
    materials.mortar_strength.crushing_energy_n_per_mm = Some(0.5);
    materials.plasticity.meridian_ratio = 0.8;
    materials
}

impl Cube {
    pub(crate) fn run(&self, test: &Test) -> Run<'_> {
        Run::new(Sample::of(&self.mesh, &self.specimen, &self.options), &self.materials, test).unwrap()
    }

    /// A test of some 1,000 steps.
    fn short(&self, test: Test) -> Test {
        self.within(1000.0, test)
    }

    /// A test of so many steps along its path, with three frames.
    fn within(&self, steps: f64, test: Test) -> Test {
        let duration = test.duration_s(&Geometry::of(&self.specimen));
        Test { time_step_s: Some(duration / steps), rows: 50, frames: 3, ..test }
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
        let test =
            cube.short(Test { law, smoothing: Some(smoothing), kind, control: Some(control), ..Test::default() });
        let response = same(&cube, &test, &DeviceName { threads, ..device.clone() });
        assert!(response.result.energies.dissipated > 0.0 || law == LawName::Elastic, "{test:?}");
    }
}

/// A thousand steps beyond the peak of every combination, with two sizes of groups.
#[test]
#[ignore = "slow tier: sixty-four tests, minutes of processor time"]
fn every_combination_has_the_bytes_of_the_processor_far_beyond_its_peak() {
    let Some(device) = device() else { return };
    let cube = cube(20.0, 5.0);
    for number in 0..32_usize {
        let law = [LawName::Cdp, LawName::Cdpm2, LawName::Meso, LawName::Elastic][number % 4];
        let smoothing = Some([Smoothing::Edges, Smoothing::None][number / 4 % 2]);
        let kind = [TestKind::Compression, TestKind::Tension][number / 8 % 2];
        let control = Some([Control::Servo, Control::Steady][number / 16]);
        let test = cube.within(4000.0, Test { law, smoothing, kind, control, ..Test::default() });
        for threads in [32, 128] {
            let response = same(&cube, &test, &DeviceName { threads, ..device.clone() });
            let rows = &response.curve;
            let peak = (0..rows.len()).max_by(|&a, &b| rows[a].stress_mpa.total_cmp(&rows[b].stress_mpa)).unwrap();
            let beyond = response.result.steps as usize * (rows.len() - peak) / rows.len();
            assert!(beyond >= 1000 || law == LawName::Elastic, "{test:?}: {beyond}");
        }
    }
}

/// Takes a test here and there, and compares curves, further columns, frames and the state at the end.
fn same(cube: &Cube, test: &Test, device: &DeviceName) -> Response {
    let (mut here, mut there) = (cube.run(test), cube.run(test));
    attach(&mut there, device).unwrap();
    let (own, others) = (Frames::default(), Frames::default());
    let (expected, got) = (finish(&mut here, &own), finish(&mut there, &others));
    for (row, (a, b)) in expected.0.curve.iter().zip(&got.0.curve).enumerate() {
        assert_eq!(a, b, "row {row} of {test:?}");
    }
    assert_eq!(expected.0.extra, got.0.extra, "{test:?}");
    assert!(expected.1 == got.1, "{test:?}");
    assert!(own.fields == others.fields && !own.fields.borrow().is_empty(), "{test:?}");
    expected.0
}

/// Matter of a phase, or its cohesive faces, are damaged.
fn dissipates(response: &Response, name: &str) {
    let phase = response.result.phases.iter().find(|phase| phase.name == name).unwrap();
    assert!(phase.dissipated_mj > 0.0, "{phase:?}");
}

/// Every gauge and support has a value other than 0, and some matter is damaged.
fn acts(response: &Response) {
    let extra = &response.extra;
    let column = |column: usize| extra.values.iter().skip(column).step_by(extra.names.len());
    let idle = (0..extra.names.len()).filter(|&own| column(own).all(|value| *value == 0.0)).count();
    assert!(idle == 0 && response.result.energies.dissipated > 0.0, "{idle} of {:?}", extra.names);
}

#[test]
fn gauges_turns_and_controls_by_gauges_have_the_bytes_of_the_processor_on_a_device() {
    let Some(device) = device() else { return };
    let cube = cube(20.0, 4.0);
    let lvdt = Gauge::Lvdt { name: "lvdt".to_owned(), axis: Along::Z, from_mm: 5.0, to_mm: 15.0 };
    let sides = Gauge::Sides { name: "sides".to_owned(), axis: Along::X };
    let turn = |at, of| Turn { at, of };
    let to_and_fro = vec![turn(0.001, TurnOf::Strain), turn(2.0, TurnOf::Stress), turn(0.003, TurnOf::Strain)];
    for test in [
        Test { gauges: vec![lvdt, sides], ..Test::default() },
        Test { control: Some(Control::LateralStrain), law: LawName::Meso, ..Test::default() },
        Test { turns: to_and_fro, ..Test::default() },
    ] {
        acts(&same(&cube, &cube.within(400.0, test), &device));
    }
}

#[test]
fn strips_rollers_and_glued_halves_have_the_bytes_of_the_processor_on_a_device() {
    let Some(device) = device() else { return };
    let (cube, beam) = (cube(20.0, 4.0), beam());
    let control = Some(Control::CrackMouth);
    let bending = Test { kind: TestKind::Bending, strain: Some(0.0015), ..Test::default() };
    let opened = vec![Turn { at: 0.03, of: TurnOf::Opening }, Turn { at: 0.5, of: TurnOf::Stress }];
    for (body, steps, test) in [
        (&cube, 400.0, Test { kind: TestKind::Splitting, ..Test::default() }),
        (&cube, 400.0, Test { kind: TestKind::Shear, ..Test::default() }),
        (&beam, 2000.0, Test { control, ..bending.clone() }),
        (&beam, 2000.0, Test { turns: opened, ..bending }),
    ] {
        acts(&same(body, &body.within(steps, test), &device));
    }
}

#[test]
fn pressures_and_plates_with_a_servo_have_the_bytes_of_the_processor_on_a_device() {
    let Some(device) = device() else { return };
    let cube = cube(20.0, 4.0);
    let on = |name: &str, on, moves| SupportSpec {
        name: name.to_owned(),
        on,
        strip: None,
        rule: Rule::Plate,
        friction: 0.2,
        moves,
        pressure_mpa: 0.0,
        stress_ratio: None,
        drive: None,
    };
    let pressed = |name, side, pressure_mpa| SupportSpec { pressure_mpa, ..on(name, side, 0.0) };
    // Nodes at edges meet two plates, or a plate and two loads; a plate is pressed by a servo before the path begins.
    let supports = vec![
        on("bottom", Side::ZMin, 0.5),
        SupportSpec { pressure_mpa: 2.0, ..on("top", Side::ZMax, -0.5) },
        on("wall", Side::XMin, 0.0),
        SupportSpec { rule: Rule::Pressure, friction: 0.0, ..pressed("front", Side::YMin, 3.0) },
        SupportSpec { rule: Rule::Pressure, friction: 0.0, ..pressed("right", Side::XMax, 1.0) },
        SupportSpec { stress_ratio: Some(0.1), ..on("back", Side::YMax, 0.0) },
    ];
    for test in [
        Test { kind: TestKind::Triaxial, ..Test::default() },
        Test { kind: TestKind::Biaxial, strain: Some(0.003), ..Test::default() },
        Test { supports, ..Test::default() },
    ] {
        acts(&same(&cube, &cube.within(250.0, test), &device));
    }
}

#[test]
fn plates_in_real_time_and_strengths_that_grow_with_the_rate_have_the_bytes_of_the_processor_on_a_device() {
    let Some(device) = device() else { return };
    let test = Test { kind: TestKind::Impact, rate_effect: true, frames: 2, duration_s: Some(4e-5), ..Test::default() };
    let response = same(&cube(20.0, 4.0), &test, &device);
    assert!(response.result.energies.dissipated > 0.0, "{:?}", response.result);
}

#[test]
fn bars_and_masses_have_the_bytes_of_the_processor_on_a_device() {
    let Some(device) = device() else { return };
    let (cube, rate_effect, frames) = (cube(20.0, 4.0), true, 2);
    for (kind, duration_s) in [
        (TestKind::Hopkinson, 6e-5),
        (TestKind::HopkinsonSplitting, 4e-5),
        (TestKind::Spall, 4e-5),
        (TestKind::Drop, 4e-5),
    ] {
        let test = Test { kind, rate_effect, frames, duration_s: Some(duration_s), ..Test::default() };
        let response = same(&cube, &test, &device);
        let pushed = response.result.energies.external;
        assert!(pushed > 0.0, "{kind:?}: {:?}", response.result);
    }
}

#[test]
fn phases_that_swell_or_shrink_have_the_bytes_of_the_processor_on_a_device() {
    let Some(device) = device() else { return };
    let cube = cube(16.0, 4.0);
    let whole =
        Expansion { mortar: (-8e-4).into(), itz: Some(2e-4.into()), aggregate: 3e-4.into(), ..Expansion::default() };
    let mortar = Course::Through(vec![[1.0, -2e-4], [3.0, -8e-4]]);
    let below = Some(Below { aggregate: 2e-4.into(), ..Below::default() });
    let layer = Expansion { mortar, layer_mm: Some(4.0), below, ..whole.clone() };
    for (kind, smoothing, expansion) in [
        (TestKind::Expansion, Smoothing::Edges, whole.clone()),
        (TestKind::Expansion, Smoothing::Edges, layer),
        (TestKind::Tension, Smoothing::None, whole),
    ] {
        let test = Test { kind, expansion: Some(expansion), smoothing: Some(smoothing), ..Test::default() };
        let steps = if kind == TestKind::Tension { 120.0 } else { 60.0 };
        acts(&same(&cube, &cube.within(steps, test), &device));
    }
}

#[test]
fn stone_that_breaks_has_the_bytes_of_the_processor_on_a_device() {
    let Some(device) = device() else { return };
    let kinds = [(0.4, 0.15), (0.6, 0.4)].map(|(share, strength_ratio)| StoneKind { share, strength_ratio }).to_vec();
    let stone = Stone { kinds, weibull_modulus: Some(8.0), ..Stone::default() };
    let cube = cube(20.0, 4.0);
    let cube = Cube { materials: Materials { aggregate_strength: Some(stone), ..brittle() }, ..cube };
    for (law, smoothing) in [(LawName::Cdp, Smoothing::Edges), (LawName::Meso, Smoothing::None)] {
        let test = Test { law, smoothing: Some(smoothing), ..Test::default() };
        let response = same(&cube, &cube.within(400.0, test), &device);
        dissipates(&response, "aggregate");
    }
}

#[test]
fn grains_of_a_phase_of_its_own_with_a_strength_have_the_bytes_of_the_processor_on_a_device() {
    let Some(device) = device() else { return };
    let mut cube = cube(20.0, 4.0);
    let own = OwnMaterial { strength_ratio: Some(0.4), ..cube.materials.mortar.into() };
    cube.materials.own = [("weak".to_owned(), own)].into_iter().collect();
    cube.mesh.phases = ["weak".to_owned()].into_iter().collect();
    for (phase, owner) in cube.mesh.phase.iter_mut().zip(&cube.mesh.owner) {
        *phase = if *phase == Phase::Aggregate && owner % 2 == 0 { Phase::Own(0) } else { *phase };
    }
    dissipates(&same(&cube, &cube.within(400.0, Test::default()), &device), "weak");
}

/// A specimen whose strengths scatter.
pub(crate) fn scattered(cube: Cube) -> Cube {
    let scatter = Scatter {
        coefficient_of_variation: 0.2,
        correlation_length_mm: 8.0,
        distribution: StrengthDistribution::Weibull,
        covariance: Covariance::Exponential,
        phases: vec![ScatteredPhase::Mortar, ScatteredPhase::Itz],
        seed: 1,
    };
    Cube { materials: Materials { scatter: Some(scatter), ..brittle() }, ..cube }
}

#[test]
fn strengths_that_scatter_have_the_bytes_of_the_processor_on_a_device() {
    let Some(device) = device() else { return };
    let cube = scattered(cube(20.0, 4.0));
    let pressed = cube.within(400.0, Test { smoothing: Some(Smoothing::Edges), ..Test::default() });
    let hit = Test { kind: TestKind::Impact, rate_effect: true, frames: 2, duration_s: Some(4e-5), ..Test::default() };
    for test in [pressed, Test { smoothing: Some(Smoothing::None), ..hit }] {
        dissipates(&same(&cube, &test, &device), "mortar");
    }
}

#[test]
fn cohesive_faces_have_the_bytes_of_the_processor_on_a_device() {
    let Some(device) = device() else { return };
    let cube = meshed(Specimen::cube(16.0), 4.0, ItzForm::Cohesive);
    assert!(!cube.mesh.cohesive.is_empty());
    let expansion = Some(Expansion { aggregate: 2e-4.into(), ..Expansion::default() });
    let [edges, none] = [Smoothing::Edges, Smoothing::None].map(Some);
    for (steps, test) in [
        (700.0, Test { smoothing: edges, ..Test::default() }),
        (700.0, Test { smoothing: none, law: LawName::Cdpm2, kind: TestKind::Tension, ..Test::default() }),
        (90.0, Test { smoothing: edges, kind: TestKind::Expansion, expansion, ..Test::default() }),
    ] {
        let response = same(&cube, &cube.within(steps, test), &device);
        dissipates(&response, "itz");
    }
}

#[test]
fn a_checkpoint_moves_from_the_processor_to_a_device_and_back() {
    let Some(device) = device() else { return };
    let cube = cube(20.0, 4.0);
    for test in [Test::default(), Test { kind: TestKind::Biaxial, ..Test::default() }] {
        let test = cube.within(500.0, test);
        let states = [false, true].map(|is_there| {
            let (mut run, frames) = (cube.run(&test), Frames { keeps: true, ..Frames::default() });
            if is_there {
                attach(&mut run, &device).unwrap();
            }
            let (_, end) = finish(&mut run, &frames);
            (frames.kept.into_inner().unwrap(), end)
        });
        let [(kept, end), other] = &states;
        assert!((kept, end) == (&other.0, &other.1), "{test:?}");
        for goes_on_there in [false, true] {
            let mut run = cube.run(&test);
            run.resume(&mut &kept[..]).unwrap();
            if goes_on_there {
                attach(&mut run, &device).unwrap();
            }
            assert!(finish(&mut run, &Frames::default()).1 == *end, "{goes_on_there} {test:?}");
        }
    }
}

#[test]
fn a_tetrahedron_holds_80_bytes_on_a_device_and_an_elastic_step_moves_105() {
    let cube = cube(24.0, 2.0);
    let traffic = meso_gpu::traffic(&cube.run(&Test::default()), meso_gpu::THREADS).unwrap();
    let each = |bytes: usize| bytes as f64 / cube.mesh.cell_count() as f64;
    let [held, moved, damaged] = [traffic.held, traffic.moved, traffic.moved_with_damage].map(each);
    assert!((60.0..80.0).contains(&held) && (80.0..105.0).contains(&moved), "{held} {moved}");
    assert!((moved + 5.0..115.0).contains(&damaged), "{damaged}");
    if let Some(device) = device() {
        let mut run = cube.run(&Test::default());
        assert_eq!(attach(&mut run, &device).unwrap(), traffic.held);
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
