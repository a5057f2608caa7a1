//! Strengths that scatter: the elements have the field's values, and no scatter leaves every byte as it was.

use crate::checkpoint::Killed;
use crate::determinism::{bytes_of, fast, rows};
use crate::samples::{Meshed, brittle, concrete, options};
use meso_core::materials::{Covariance, Materials, Scatter, ScatteredPhase, StrengthDistribution};
use meso_core::math::Vec3;
use meso_core::mesh::{ItzForm, Method, Phase};
use meso_core::watch::Silent;
use meso_solve::results::Snapshot;
use meso_solve::{Ended, InstructionSet, LawName, Run, Smoothing, Test, TestKind};

pub(crate) fn scatter(coefficient_of_variation: f64, correlation_length_mm: f64) -> Scatter {
    Scatter {
        coefficient_of_variation,
        correlation_length_mm,
        distribution: StrengthDistribution::Weibull,
        covariance: Covariance::SquaredExponential,
        phases: vec![ScatteredPhase::Mortar, ScatteredPhase::Itz],
        seed: 1,
    }
}

fn with(scatter: Scatter) -> Materials {
    Materials { scatter: Some(scatter), ..brittle() }
}

fn meso(smoothing: Smoothing) -> Test {
    Test { law: LawName::Meso, smoothing: Some(smoothing), ..fast() }
}

#[test]
fn no_scatter_leaves_the_bytes_of_one_strength() {
    let meshed = concrete(1.0, Method::FITTED, 3.0, ItzForm::Smeared);
    let test = meso(Smoothing::Edges);
    let of = |materials: &Materials| rows(&meshed.solve(materials, &test));
    assert!(of(&brittle()) == of(&with(scatter(0.0, 6.0))));
    assert!(of(&brittle()) != of(&with(scatter(0.1, 6.0))));
    // A decimal of the mean: the same specimen but for single precision.
    let peak = |materials: &Materials| meshed.solve(materials, &test).result.figures.peak_mpa;
    let off = peak(&with(scatter(0.001, 6.0))) / peak(&brittle()) - 1.0;
    assert!(off.abs() < 2e-3, "{off}");
}

#[test]
fn scattered_strengths_give_the_same_bytes_on_any_threads_and_instruction_set() {
    let rated = Test {
        kind: TestKind::Impact,
        rate_effect: true,
        duration_s: Some(4e-5),
        smoothing: Some(Smoothing::None),
        frames: 2,
        ..Test::default()
    };
    for (method, size, test) in [
        (Method::FITTED, 3.0, meso(Smoothing::Edges)),
        (Method::FITTED, 3.0, rated),
        (Method::VOXEL, 1.5, meso(Smoothing::None)),
    ] {
        let meshed = concrete(1.0, method, size, ItzForm::Smeared);
        let of = |threads, set| bytes_of(&meshed, &with(scatter(0.2, 5.0)), &test, threads, set);
        let best = of(1, InstructionSet::best());
        assert!(best == of(2, InstructionSet::best()) && best == of(1, InstructionSet::Portable), "{method:?}");
    }
}

#[test]
fn a_resumed_test_of_scattered_strengths_has_the_bytes_of_a_whole_one() {
    let meshed = concrete(1.0, Method::FITTED, 3.0, ItzForm::Smeared);
    let (materials, test) = (with(scatter(0.2, 5.0)), meso(Smoothing::Edges));
    let (whole, killed) = (meshed.solve(&materials, &test), Killed::default());
    meshed.watched(&materials, &test, &killed, &killed);
    let mut run = Run::new(meshed.sample(), &materials, &test).unwrap();
    run.resume(&mut &killed.state()[..]).unwrap();
    assert!(rows(&whole) == rows(&run.to_end(&Silent, &Silent)));
    // Another field went on with the first one's factors.
    let others = [Scatter { seed: 2, ..scatter(0.2, 5.0) }, scatter(0.2, 6.0)];
    for other in others {
        let mut run = Run::new(meshed.sample(), &with(other), &test).unwrap();
        assert!(run.resume(&mut &killed.state()[..]).unwrap_err().to_string().contains("other materials"));
    }
}

fn centroid(meshed: &Meshed, cell: usize) -> Vec3 {
    let nodes = meshed.mesh.cell(cell);
    nodes.iter().map(|&node| meshed.mesh.points[node as usize]).sum::<Vec3>() / nodes.len() as f64
}

#[test]
fn every_cell_of_a_frame_has_the_factor_of_its_place_and_grains_have_none() {
    let of = scatter(0.2, 6.0);
    let field = of.field();
    for smoothing in [Smoothing::None, Smoothing::Edges] {
        let meshed = concrete(1.0, Method::FITTED, 3.0, ItzForm::Smeared);
        let run = Run::new(meshed.sample(), &with(of.clone()), &meso(smoothing)).unwrap();
        let last = Snapshot::last(&run, &Ended::Stopped).unwrap();
        let (mut worst, mut sum, mut count) = (0.0_f64, 0.0, 0.0);
        for (cell, found) in last.strength.iter().enumerate() {
            let phase = meshed.mesh.phase[cell];
            let expected = if phase == Phase::Aggregate { 1.0 } else { field.factor(&centroid(&meshed, cell)) };
            worst = worst.max((f64::from(*found) - expected).abs());
            sum += (f64::from(*found) - expected).powi(2);
            count += 1.0;
        }
        // Patches of a cell lie around it; those of mortar and ITZ at a grain are mixed.
        let limits = if smoothing == Smoothing::None { [1e-6, 1e-6] } else { [0.25, 0.04] };
        assert!(
            worst < limits[0] && (sum / count).sqrt() < limits[1],
            "{smoothing:?} {worst} {}",
            (sum / count).sqrt()
        );
    }
    let meshed = concrete(1.0, Method::FITTED, 3.0, ItzForm::Smeared);
    let run = Run::new(meshed.sample(), &brittle(), &meso(Smoothing::None)).unwrap();
    assert!(Snapshot::last(&run, &Ended::Stopped).unwrap().strength.is_empty());
}

/// Bars of boxes in a row, each with a strength of its own, as good as independent of its neighbours'.
#[test]
fn a_pulled_bar_is_as_strong_as_its_weakest_element() {
    let mut materials = brittle();
    materials.mortar.poisson_ratio = 0.0;
    for (links, seed) in [(4, 1), (4, 2), (8, 3), (8, 4), (16, 5)] {
        let meshed = Meshed::mortar([4.0, 4.0, 4.0 * f64::from(links)], Method::VOXEL, 4.0);
        let of = Scatter { seed, ..scatter(0.2, 2.0) };
        let field = of.field();
        let weakest = (0..meshed.mesh.cell_count()).map(|cell| field.factor(&centroid(&meshed, cell)));
        let expected = 3.0 * weakest.fold(f64::INFINITY, f64::min);
        let duration_s = Some(8e-4 * f64::from(links));
        let test = Test { kind: TestKind::Tension, strain: Some(2e-4), duration_s, ..Test::default() };
        let materials = Materials { scatter: Some(of), ..materials.clone() };
        let result = meshed.solve(&materials, &test).result;
        let peak = result.figures.peak_mpa;
        assert!((peak / expected - 1.0).abs() < 0.02, "{links} {seed}: {peak} instead of {expected}");
        assert!(result.warnings.iter().any(|text| text.contains("take elements of 1 mm")), "{:?}", result.warnings);
    }
}

#[test]
fn a_field_that_a_mesh_or_a_law_cannot_have_is_refused_before_the_first_step() {
    let mortar = Meshed::mortar([12.0; 3], Method::FITTED, 3.0);
    let refused = |meshed: &Meshed, scatter: Scatter, law| {
        let test = Test { law, ..Test::default() };
        let run = Run::new(meshed.sample(), &with(scatter), &test);
        run.err().map(|error| error.to_string()).unwrap_or_default()
    };
    let text = refused(&mortar, scatter(0.1, 1.0), LawName::Meso);
    assert!(text.contains("correlation_length_mm is 1; with elements of 3 mm it must be 1.5 or more"), "{text}");
    let text = refused(&mortar, scatter(0.1, 6.0), LawName::Cdp);
    assert!(text.contains("strengths scatter in tests with the law meso only"), "{text}");
    assert_eq!(refused(&mortar, scatter(0.1, 1.0), LawName::Elastic), "");
    let cohesive = concrete(0.5, Method::FITTED, 3.0, ItzForm::Cohesive);
    let text = refused(&cohesive, scatter(0.1, 6.0), LawName::Meso);
    assert!(text.contains(r#"take phases = ["mortar"], or a solid or smeared ITZ"#), "{text}");
    let own = Scatter { phases: vec![ScatteredPhase::Mortar], ..scatter(0.1, 6.0) };
    assert_eq!(refused(&cohesive, own, LawName::Meso), "");
    // Its strengths were told to scatter, and there are none.
    let bare = concrete(1.0, Method::FITTED, 3.0, ItzForm::None);
    let itz = Scatter { phases: vec![ScatteredPhase::Itz], ..scatter(0.1, 6.0) };
    assert!(refused(&bare, itz, LawName::Meso).contains("the mesh has no ITZ of cells"));
    let twice = Scatter { phases: vec![ScatteredPhase::Mortar; 2], ..scatter(0.1, 6.0) };
    assert!(refused(&bare, twice, LawName::Meso).contains("each of them once"));
}

#[test]
fn warnings_name_a_field_that_is_longer_than_the_specimen() {
    let meshed =
        Meshed::of(&[], meso_core::specimen::Specimen::cube(12.0), options(Method::FITTED, 4.0, ItzForm::None));
    let run = Run::new(meshed.sample(), &with(scatter(0.1, 200.0)), &Test::default()).unwrap();
    assert!(run.doubts().iter().any(|text| text.contains("far more than the specimen's 12 mm")), "{:?}", run.doubts());
}
