//! Tests of specimens whose aggregates have phases of their own.

use meso_core::materials::{Elastic, Materials};
use meso_core::mesh::{self, ItzForm, MeshOptions, Method, Tools};
use meso_core::{Model, Silent, Spec, pack};
use meso_solve::results::sample_of;
use meso_solve::{LawName, Response, Run, SolveError, Test};
use std::collections::BTreeMap;

const PLAIN: &str = "fraction = 0.35\nspecimen = { kind = 'cube', side_mm = 30 }\ngrading.d_max_mm = 10\n";
const OWN: &str = "[[phases]]\nname = 'soft'\nshare = 0.5\n";

fn packed(text: &str) -> Model {
    pack(&Spec::from_toml(text).unwrap(), &Silent).unwrap()
}

fn values(soft_mpa: f64) -> Materials {
    let usual = Materials::default();
    let soft = Elastic { youngs_modulus_mpa: soft_mpa, ..usual.aggregate };
    Materials { own: BTreeMap::from([("soft".to_owned(), soft)]), ..usual }
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
