//! Tests of specimens whose aggregates have phases of their own.

use crate::samples::Meshed;
use meso_core::materials::{Elastic, Materials, OwnMaterial, Strength};
use meso_core::mesh::{self, ItzForm, MeshOptions, Method, Phase, Tools};
use meso_core::{Model, Silent, Spec, pack};
use meso_solve::results::sample_of;
use meso_solve::{LawName, Response, Run, Smoothing, SolveError, Test};
use std::collections::BTreeMap;

const PLAIN: &str = "fraction = 0.35\nspecimen = { kind = 'cube', side_mm = 30 }\ngrading.d_max_mm = 10\n";
const OWN: &str = "[[phases]]\nname = 'soft'\nshare = 0.5\n";

fn packed(text: &str) -> Model {
    pack(&Spec::from_toml(text).unwrap(), &Silent).unwrap()
}

fn values(soft_mpa: f64) -> Materials {
    let usual = Materials::default();
    let soft = Elastic { youngs_modulus_mpa: soft_mpa, ..usual.aggregate };
    Materials { own: BTreeMap::from([("soft".to_owned(), soft.into())]), ..usual }
}

fn solve(model: &Model, method: Method, materials: &Materials, law: LawName) -> Result<Response, SolveError> {
    let options = MeshOptions { method, element_size_mm: 3.0, itz: ItzForm::Smeared, ..MeshOptions::default() };
    let mesh = mesh::build(model, &options, &Tools::default()).unwrap();
    let test = Test { law, strain: Some(0.001), ..Test::default() };
    Run::new(sample_of(&mesh, model, &options), materials, &test).map(|mut run| run.to_end(&Silent, &Silent))
}

#[test]
fn a_phase_with_the_aggregates_values_gives_the_same_curve_and_a_softer_one_a_lower_modulus() {
    let (plain, own) = (packed(PLAIN), packed(&format!("{PLAIN}{OWN}")));
    for method in [Method::VOXEL, Method::FITTED] {
        let of = |model, materials: &Materials| solve(model, method, materials, LawName::Meso).unwrap();
        let (without, same, soft) =
            (of(&plain, &Materials::default()), of(&own, &values(60_000.0)), of(&own, &values(5_000.0)));
        let near = |a: f64, b: f64, share: f64| (a / b - 1.0).abs() < share;
        assert!(near(same.result.figures.modulus_mpa, without.result.figures.modulus_mpa, 1e-4));
        assert!(near(same.result.figures.peak_mpa, without.result.figures.peak_mpa, 5e-3));
        assert!(
            soft.result.figures.modulus_mpa < 0.9 * same.result.figures.modulus_mpa,
            "{:?}",
            soft.result.figures.modulus_mpa
        );
        let [aggregate, own] = ["aggregate", "soft"]
            .map(|name| soft.result.phases.iter().find(|phase| phase.name == name).unwrap().clone());
        let all = plain.report.fraction;
        assert!(near(aggregate.exact_fraction.unwrap() + own.exact_fraction.unwrap(), all, 1e-9));
        assert!(own.volume_fraction > 0.3 * all && own.dissipated_mj == 0.0);
    }
}

#[test]
fn a_phase_without_values_is_refused_before_the_first_step() {
    let own = packed(&format!("{PLAIN}{OWN}"));
    let said = solve(&own, Method::VOXEL, &Materials::default(), LawName::Elastic).err().unwrap().to_string();
    assert!(said.starts_with("materials.soft is missing; the packing has this phase"), "{said}");
}

/// Values of the mortar for a phase that is `ratio` as strong.
fn like_mortar(ratio: f64) -> Materials {
    let usual = Materials::default();
    let soft = OwnMaterial { strength_ratio: Some(ratio), ..usual.mortar.into() };
    Materials { own: BTreeMap::from([("soft".to_owned(), soft)]), ..usual }
}

#[test]
fn a_block_of_a_phase_half_as_strong_as_mortar_is_a_block_of_a_mortar_of_half_the_strengths_under_every_law() {
    for (law, method, smoothing) in [
        (LawName::Meso, Method::FITTED, Smoothing::Edges),
        (LawName::Cdp, Method::FITTED, Smoothing::None),
        (LawName::Cdpm2, Method::VOXEL, Smoothing::None),
    ] {
        let of_mortar = Meshed::mortar([12.0; 3], method, 4.0);
        let mut of_own = Meshed::mortar([12.0; 3], method, 4.0);
        of_own.mesh.phase.fill(Phase::Own(0));
        of_own.mesh.phases = ["soft".to_owned()].into_iter().collect();
        let usual = Materials::default();
        let Strength { compressive_mpa, peak_strain, tensile_mpa, fracture_energy_n_per_mm, crushing_energy_n_per_mm } =
            usual.mortar_strength.of(law);
        let half = Strength {
            compressive_mpa: 0.5 * compressive_mpa,
            peak_strain,
            tensile_mpa: 0.5 * tensile_mpa,
            fracture_energy_n_per_mm: 0.5 * fracture_energy_n_per_mm,
            crushing_energy_n_per_mm: 0.5 * crushing_energy_n_per_mm,
        };
        let test = Test { law, smoothing: Some(smoothing), strain: Some(0.006), ..Test::default() };
        let (own, mortar) = (
            of_own.solve(&like_mortar(0.5), &test),
            of_mortar.solve(&Materials { mortar_strength: half.into(), ..usual }, &test),
        );
        assert_eq!(own.curve, mortar.curve, "{law:?}");
        let soft = own.result.phases.iter().find(|phase| phase.name == "soft").unwrap();
        assert!(soft.dissipated_mj > 0.0 && own.result.figures.peak_mpa < 0.6 * compressive_mpa, "{soft:?}");
    }
}

#[test]
fn grains_with_a_strength_break_and_lower_the_peak_on_any_number_of_threads() {
    let own = packed(&format!("{PLAIN}{OWN}"));
    let on = |threads: usize, materials: &Materials| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solve(&own, Method::FITTED, materials, LawName::Meso).unwrap())
    };
    let weak = like_mortar(0.3);
    let mut sound = weak.clone();
    sound.own.get_mut("soft").unwrap().strength_ratio = None;
    let (broken, elastic) = (on(1, &weak), on(2, &sound));
    let spent =
        |response: &Response| response.result.phases.iter().find(|own| own.name == "soft").unwrap().dissipated_mj;
    assert!(spent(&broken) > 0.0 && spent(&elastic) == 0.0);
    assert_eq!(broken.curve, on(2, &weak).curve);
    let at_end = |response: &Response| response.curve.last().unwrap().stress_mpa;
    assert!(at_end(&broken) < 0.95 * at_end(&elastic), "{} {}", at_end(&broken), at_end(&elastic));
}

#[test]
fn strength_ratios_out_of_their_range_are_refused_before_the_first_step() {
    let mut block = Meshed::mortar([12.0; 3], Method::VOXEL, 4.0);
    block.mesh.phases = ["soft".to_owned()].into_iter().collect();
    let refused = |ratio: f64, law: LawName| {
        let test = Test { law, ..Test::default() };
        Run::new(block.sample(), &like_mortar(ratio), &test).err().map(|error| error.to_string()).unwrap_or_default()
    };
    for law in [LawName::Meso, LawName::Cdp, LawName::Cdpm2] {
        for ratio in [0.0, -1.0, f64::NAN, 1e3] {
            let said = refused(ratio, law);
            assert!(
                said.starts_with(&format!("materials.soft.strength_ratio is {ratio}; it must be 0.01 to 100")),
                "{said}"
            );
        }
    }
    let said = refused(2.0, LawName::Meso);
    assert!(
        said.starts_with("materials.soft.strength_ratio is 2; it must be 1.7316 at most: 66 MPa over 20000"),
        "{said}"
    );
    assert_eq!(refused(f64::NAN, LawName::Elastic), "");
}
