//! Concrete: aggregates in mortar, with all that can be wrong with a mesh.

use crate::samples::{
    Meshed, StopAtOnce, brittle, concrete, cube, damaged_plasticity, meshed, options, small_cube, voxels,
};
use meso_core::Silent;
use meso_core::aggregate::{Fibres, Voids};
use meso_core::mesh::{self, ItzForm, Joined, MeshOptions, Method, Phase, Tools};
use meso_core::specimen::Specimen;
use meso_solve::results::sample_of;
use meso_solve::{Control, Ended, Frame, Geometry, Interface, Observer, Run, Smoothing, Test, TestKind};
use std::cell::RefCell;

fn solve(meshed: &Meshed, test: &Test) -> meso_solve::Response {
    meshed.solve(&brittle(), test)
}

#[test]
fn concrete_softens_and_its_energies_balance() {
    for meshed in [
        concrete(1.0, Method::FITTED, 2.5, ItzForm::Smeared),
        concrete(1.0, Method::VOXEL, 1.5, ItzForm::Smeared),
        concrete(0.5, Method::FITTED, 3.0, ItzForm::Cohesive),
    ] {
        let result = solve(&meshed, &damaged_plasticity()).result;
        let figures = result.figures;
        assert!(figures.softened && (25.0..55.0).contains(&figures.peak_mpa), "{result:?}");
        assert!((0.001..0.0035).contains(&figures.peak_strain), "{result:?}");
        assert!(result.energy_balance_error < 1e-3 && result.kinetic_over_internal_max < 0.01, "{result:?}");
        assert!(result.errors.is_empty(), "{:?}", result.errors);
        assert!(result.hourglass_over_internal < 0.02, "{result:?}");
    }
}

#[test]
fn hourglass_modes_hold_less_than_2_percent_of_the_internal_energy() {
    let pulled = Test { kind: TestKind::Tension, ..damaged_plasticity() };
    little_hourglass(&voxels(24.0, 4, 1.5), &damaged_plasticity());
    little_hourglass(&voxels(24.0, 3, 1.5), &pulled);
}

#[test]
#[ignore = "slow tier: 8,000 boxes, and rough plates"]
fn hourglass_modes_hold_less_than_2_percent_in_larger_specimens_and_between_rough_plates() {
    little_hourglass(&voxels(24.0, 3, 1.5), &Test { friction: Some(0.6), ..damaged_plasticity() });
    little_hourglass(&voxels(40.0, 3, 2.0), &damaged_plasticity());
}

#[track_caller]
fn little_hourglass(meshed: &Meshed, test: &Test) {
    let result = solve(meshed, test).result;
    assert!(result.hourglass_over_internal < 0.02 && result.energy_balance_error < 1e-3, "{result:?}");
}

#[test]
#[ignore = "slow tier: boxes of 1 mm"]
fn coarse_boxes_bear_what_fine_ones_bear() {
    let [coarse, fine] = [1.5, 1.0].map(|size| solve(&voxels(24.0, 3, size), &damaged_plasticity()).result);
    assert!(fine.hourglass_over_internal < 0.02 && fine.figures.softened, "{fine:?}");
    assert!((coarse.figures.peak_mpa / fine.figures.peak_mpa - 1.0).abs() < 0.05, "{coarse:?} {fine:?}");
}

/// Linear tetrahedra that flow between stiff grains are too strong, the coarser the more; patches hardly.
#[test]
#[ignore = "slow tier: four tests of a cube of 24 mm"]
fn smoothed_strains_take_away_most_of_what_peaks_owe_to_the_elements() {
    let [coarse, fine] = [2.4, 1.6].map(|size| concrete(1.0, Method::FITTED, size, ItzForm::Smeared));
    let apart = |smoothing: Smoothing| {
        let [coarse, fine] = [&coarse, &fine].map(|meshed| {
            let result = solve(meshed, &Test { smoothing: Some(smoothing), ..damaged_plasticity() }).result;
            assert!(result.errors.is_empty() && result.energy_balance_error < 1e-3, "{result:?}");
            result.figures.peak_mpa
        });
        coarse / fine - 1.0
    };
    let [plain, smoothed] = [Smoothing::None, Smoothing::Edges].map(apart);
    assert!(plain > 0.03 && smoothed.abs() < 0.3 * plain, "{plain} {smoothed}");
}

#[test]
fn twice_the_steps_change_the_peak_by_less_than_1_percent() {
    let meshed = concrete(1.0, Method::FITTED, 2.5, ItzForm::Smeared);
    let test = damaged_plasticity();
    let peak = |test: &Test| solve(&meshed, test).result.figures.peak_mpa;
    let twice = Test { duration_s: Some(2.0 * test.duration_s(&Geometry::of(&Specimen::cube(24.0)))), ..test.clone() };
    let [once, slow] = [&test, &twice].map(peak);
    assert!((once / slow - 1.0).abs() < 0.01, "{once} {slow}");
}

#[test]
fn results_count_the_joined_aggregates_and_warn_of_their_cells() {
    let model = small_cube(0.0);
    let result = |joined| {
        let meshed = meshed(&model, MeshOptions { joined, ..options(Method::FITTED, 3.0, ItzForm::None) });
        let result =
            Run::new(meshed.sample(), &brittle(), &damaged_plasticity()).unwrap().to_end(&StopAtOnce, &Silent).result;
        (meshed.mesh.notes, result)
    };
    let (notes, parted) = result(Joined::Mortar);
    assert!(notes.separated_pairs > 0 && notes.parted_cells > 0, "the trial needs closed gaps");
    assert_eq!((parted.joined_pairs, parted.joined_cells), (notes.separated_pairs, notes.parted_cells));
    assert!(parted.warnings.iter().any(|text| text.contains("became mortar")), "{:?}", parted.warnings);
    let (kept_notes, kept) = result(Joined::Keep);
    assert_eq!((kept.joined_pairs, kept.joined_cells), (kept_notes.closed_gap_pairs, 0));
    assert!(kept.warnings.iter().any(|text| text.contains("cannot break")), "{:?}", kept.warnings);
}

/// Voxels of two aggregates with a cohesive face between them, and no mortar, press on each other for ever.
#[test]
#[ignore = "slow tier: boxes with cohesive faces beyond the peak"]
fn voxels_with_a_cohesive_itz_soften_where_mortar_parts_the_aggregates() {
    let model = small_cube(0.3);
    let voxels = |joined| meshed(&model, MeshOptions { joined, ..options(Method::VOXEL, 1.5, ItzForm::Cohesive) });
    let touch = |text: &String| text.contains("lie between two aggregates");
    let kept = Run::new(voxels(Joined::Keep).sample(), &brittle(), &damaged_plasticity())
        .unwrap()
        .to_end(&StopAtOnce, &Silent)
        .result;
    assert!(kept.warnings.iter().any(touch), "{:?}", kept.warnings);
    let result = solve(&voxels(Joined::Mortar), &damaged_plasticity()).result;
    assert!(result.figures.softened && result.figures.peak_mpa < 55.0 && result.joined_pairs > 0, "{result:?}");
    assert!(!result.warnings.iter().any(touch) && result.energy_balance_error < 1e-3, "{result:?}");
}

#[test]
fn a_smeared_itz_is_mortar_at_the_aggregates_with_less_strength() {
    let test = Test { kind: TestKind::Tension, ..damaged_plasticity() };
    let peak = |itz| solve(&concrete(1.0, Method::FITTED, 2.5, itz), &test).result.figures.peak_mpa;
    let (smeared, none) = (peak(ItzForm::Smeared), peak(ItzForm::None));
    assert!(smeared < 0.98 * none && smeared > 0.6 * none, "{smeared} {none}");
}

/// Faces that have parted rub: without damping, pressure and friction tear an aggregate's ear off before 0.5 %.
#[test]
fn aggregates_that_rub_in_their_cracks_do_not_flutter() {
    let meshed = meshed(&cube(40.0, 2, 1.0), options(Method::FITTED, 4.0, ItzForm::Cohesive));
    let test = Test { strain: Some(0.006), interface: Interface { friction: 0.8 }, ..damaged_plasticity() };
    let result = meshed.solve(&brittle(), &test).result;
    assert!(result.ended == Ended::Completed && result.energy_balance_error < 1e-3, "{result:?}");
    assert!(result.kinetic_over_internal_max < 0.01, "{result:?}");
}

/// A frame's strain, and phase and damage of its cells.
type Cells = (f64, Vec<(Phase, f32)>);

/// Damage of the cells in every frame.
#[derive(Default)]
struct Damage(RefCell<Vec<Cells>>);

impl Observer for Damage {
    fn frame(&self, frame: &Frame) {
        assert_eq!(frame.number() as usize, self.0.borrow().len() + 1);
        let damage = frame.cells(|point| point.damage);
        self.0.borrow_mut().push((frame.strain(), frame.mesh().phase.iter().copied().zip(damage).collect()));
    }
}

#[test]
fn frames_come_evenly_and_damage_grows_in_mortar_alone() {
    let meshed = concrete(1.0, Method::FITTED, 3.0, ItzForm::None);
    let damage = Damage::default();
    // A servo adds frames.
    let control = Some(Control::Steady);
    let test = Test { frames: 4, kind: TestKind::Tension, control, ..damaged_plasticity() };
    meshed.watched(&brittle(), &test, &Silent, &damage);
    let frames = damage.0.into_inner();
    assert_eq!(frames.len(), 4);
    assert!((frames[3].0 / test.strain() - 1.0).abs() < 1e-6, "{}", frames[3].0);
    let last = frames.last().unwrap();
    for &(phase, d) in &last.1 {
        assert!((0.0..=1.0).contains(&d) && (d == 0.0 || phase == Phase::Mortar), "{phase:?} {d}");
    }
    let worst: Vec<f32> = frames.iter().map(|(_, d)| d.iter().fold(0.0, |a: f32, b| a.max(b.1))).collect();
    assert!(worst.is_sorted() && worst[3] > 0.5, "{worst:?}");
}

#[test]
fn a_step_that_is_too_long_is_met_by_mass_that_is_told() {
    let meshed = concrete(1.0, Method::FITTED, 3.0, ItzForm::Smeared);
    let added = |step: f64| {
        let test = Test { time_step_s: Some(step), ..damaged_plasticity() };
        let run = Run::new(meshed.sample(), &brittle(), &test).unwrap();
        run.added_mass_percent()
    };
    let [short, usual, long] = [1e-9, 3e-7, 1e-6].map(added);
    assert!(short == 0.0 && usual > 1.0 && usual < 300.0 && long > 3.0 * usual, "{short} {usual} {long}");
}

/// Fibres thinner than the elements, voids smaller than them, and aggregates of which no element is left.
#[test]
fn bodies_that_the_elements_lose_are_told() {
    let mut spec = small_cube(1.0).spec;
    spec.fibres = Some(Fibres { fraction: 0.005, length_mm: 8.0, diameter_mm: 0.4, orientation: None });
    spec.voids = Some(Voids { fraction: 0.01, diameter_mm: Some([0.8, 1.2]), grading: None });
    let model = meso_core::pack(&spec, &Silent).unwrap();
    let lost = |method, size| {
        let options = options(method, size, ItzForm::None);
        let mesh = mesh::build(&model, &options, &Tools::default()).unwrap();
        let mut run = Run::new(sample_of(&mesh, &model, &options), &brittle(), &damaged_plasticity()).unwrap();
        let warnings = run.to_end(&StopAtOnce, &Silent).result.warnings;
        ["aggregates", "fibres", "voids"]
            .map(|name| warnings.iter().any(|text| text.starts_with(&format!("the {name} are"))))
    };
    assert_eq!(lost(Method::Voxel { thin_itz: false, subsamples: 2 }, 0.4), [false; 3]);
    assert_eq!(lost(Method::FITTED, 3.0)[1..], [true; 2]);
    assert_eq!(lost(Method::VOXEL, 24.0), [true; 3]);
}
