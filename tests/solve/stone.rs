//! Aggregates that break.

use crate::samples::{Meshed, damaged_plasticity, options, small_cube};
use meso_core::materials::{Materials, Stone, StoneKind};
use meso_core::mesh::{ItzForm, Method, Phase};
use meso_solve::{LawName, Run, Smoothing, Test, TestKind};

fn with(stone: Stone) -> Materials {
    Materials { aggregate_strength: Some(stone), ..Materials::default() }
}

/// A cube of stone alone.
fn block(method: Method, size: f64) -> Meshed {
    let mut meshed = Meshed::mortar([12.0; 3], method, size);
    meshed.mesh.phase.fill(Phase::Aggregate);
    meshed.mesh.owner.fill(0);
    meshed.mesh.id_of = vec![0];
    meshed
}

#[test]
fn a_block_of_stone_breaks_at_its_strength_under_every_law() {
    let stone = Stone { compressive_mpa: 120.0, tensile_mpa: 11.0, ..Stone::default() };
    let [none, edges] = [Smoothing::None, Smoothing::Edges];
    for (method, size, smoothing) in
        [(Method::VOXEL, 3.0, none), (Method::FITTED, 3.0, none), (Method::FITTED, 3.0, edges)]
    {
        for law in [LawName::Cdp, LawName::Cdpm2] {
            let test =
                Test { law, friction: Some(0.0), smoothing: Some(smoothing), strain: Some(0.006), ..Test::default() };
            let peak = block(method, size).solve(&with(stone.clone()), &test).result.figures.peak_mpa;
            assert!((peak / 120.0 - 1.0).abs() < 0.05, "{method:?} {law:?} {peak}");
        }
        let kind = TestKind::Tension;
        let test = Test { kind, smoothing: Some(smoothing), strain: Some(0.002), ..Test::default() };
        let pulled = block(method, size).solve(&with(stone.clone()), &test).result;
        // The plates hold the ends.
        assert!((0.97..1.2).contains(&(pulled.figures.peak_mpa / 11.0)), "{method:?} {:?}", pulled.figures);
        assert!(pulled.broken_stone.unwrap() > 0.05, "{method:?} {:?}", pulled.broken_stone);
    }
}

#[test]
fn weak_stone_breaks_and_lowers_the_peak_and_strong_stone_is_as_good_as_elastic() {
    let model = small_cube(1.0);
    let meshed =
        Meshed::of(&model.aggregates, model.spec.specimen.clone(), options(Method::FITTED, 2.5, ItzForm::Smeared));
    let solve = |materials: &Materials| meshed.solve(materials, &damaged_plasticity()).result;
    let elastic = solve(&Materials::default());
    assert_eq!(elastic.broken_stone, None);
    let of = |ratio: f64, weibull_modulus| {
        let kinds = vec![StoneKind { share: 1.0, strength_ratio: ratio }];
        solve(&with(Stone { kinds, weibull_modulus, ..Stone::default() }))
    };
    let strong = of(4.0, None);
    assert!(strong.broken_stone.unwrap() < 5e-3, "{:?}", strong.broken_stone);
    assert!((strong.figures.peak_mpa / elastic.figures.peak_mpa - 1.0).abs() < 2e-3, "{:?}", strong.figures);
    let weak = of(0.1, None);
    assert!(weak.broken_stone.unwrap() > 0.02, "{:?}", weak.broken_stone);
    assert!(weak.figures.peak_mpa < 0.95 * elastic.figures.peak_mpa, "{:?} {:?}", weak.figures, elastic.figures);
    let drawn = of(0.4, Some(3.0));
    assert!((0.0..weak.broken_stone.unwrap()).contains(&drawn.broken_stone.unwrap()), "{:?}", drawn.broken_stone);
}

#[test]
fn a_strength_of_stone_that_a_law_cannot_have_is_named() {
    let meshed = block(Method::FITTED, 4.0);
    let refused = |stone: Stone, law| {
        let test = Test { law, ..Test::default() };
        let run = Run::new(meshed.sample(), &with(stone), &test);
        run.err().map(|error| error.to_string()).unwrap_or_default()
    };
    let text = refused(Stone { tensile_mpa: 100.0, ..Stone::default() }, LawName::Cdp);
    assert!(text.contains("materials.aggregate_strength.tensile_mpa is 100; it must be at most"), "{text}");
    let text = refused(Stone { peak_strain: 0.001, ..Stone::default() }, LawName::Cdpm2);
    assert!(text.contains("materials.aggregate_strength.peak_strain is 0.001; AGGREGATE needs"), "{text}");
    assert_eq!(refused(Stone { tensile_mpa: 100.0, ..Stone::default() }, LawName::Elastic), "");
}
