//! Properties of packings whose aggregates have phases of their own.

use crate::bodies::{aggregate, entry, phases};
use meso_concrete::{Parts, PhaseNames};
use meso_core::aggregate::Aggregate;
use meso_core::geometry::convex_hull;
use meso_core::math::Vec3;
use meso_core::specimen::Specimen;
use meso_core::{Model, Silent, Spec, pack};
use meso_effective::{
    Effective, EffectiveOptions, GivenModuli, PhaseModuli, Phases, Property, StiffnessOptions, effective,
    effective_in_tetrahedra, stiffness, stiffness_in_tetrahedra,
};
use std::borrow::Cow;
use std::sync::LazyLock;

const SIDE: f64 = 20.0;
const PACKED: &str = "fraction = 0.35\nspecimen = { kind = 'cube', side_mm = 30 }\nitz.thickness_mm = [0.4, 0.4]\n";
const OWN: &str = "[[phases]]\nname = 'soft'\nshare = 0.5\n";

fn packed() -> &'static Model {
    static MODEL: LazyLock<Model> =
        LazyLock::new(|| pack(&Spec::from_toml(&format!("{PACKED}{OWN}")).unwrap(), &Silent).unwrap());
    &MODEL
}

fn plain() -> Model {
    pack(&Spec::from_toml(PACKED).unwrap(), &Silent).unwrap()
}

/// `phases` with values of some own ones.
fn with(mut phases: Phases, own: &[(&str, f64)]) -> Phases {
    phases.diffusivity.own = own.iter().map(|(name, value)| ((*name).to_owned(), Some(*value))).collect();
    phases
}

fn moduli(own: &[(&str, f64)]) -> PhaseModuli {
    let given = |(name, e): &(&str, f64)| {
        let given = GivenModuli { youngs_modulus_mpa: Some(*e), poisson_ratio: Some(0.2), eigenstrain: None };
        ((*name).to_owned(), given)
    };
    PhaseModuli { own: own.iter().map(given).collect(), ..PhaseModuli::default() }
}

/// Two slabs across z, 4 and 6 mm thick, of two phases of their own.
fn slabs<'a>(specimen: &'a Specimen) -> Parts<'a> {
    let slab = |own: u8, from: f64, to: f64| -> Aggregate {
        let corner = |number: usize| {
            Vec3::from_fn(|axis, _| match (axis, number >> axis & 1) {
                (2, 0) => from,
                (2, _) => to,
                (_, side) => side as f64 * 40.0 - 10.0,
            })
        };
        let body = convex_hull(&(0..8).map(corner).collect::<Vec<_>>()).unwrap();
        Aggregate { id: own.into(), own: Some(own), ..aggregate(body, 0.0) }
    };
    let names: PhaseNames = ["first", "second"].map(str::to_owned).into_iter().collect();
    Parts { bodies: Cow::Owned(vec![slab(0, 2.0, 6.0), slab(1, 9.3, 15.3)]), specimen, phases: names }
}

fn along(found: &Effective) -> [f64; 2] {
    [entry(found, 0, 0), entry(found, 2, 2)]
}

#[test]
fn layers_of_two_phases_of_their_own_are_as_in_parallel_and_in_series() {
    let specimen = Specimen::cuboid([SIDE; 3]);
    let values = with(phases(1.0, 7.0, 1.0), &[("first", 0.25), ("second", 4.0)]);
    let options = EffectiveOptions::new(Property::Diffusivity, 2.0);
    let found = effective(slabs(&specimen), &values, &options, &Silent).unwrap().0;
    let parallel = 0.5 + 0.2 * 0.25 + 0.3 * 4.0;
    let series = 1.0 / (0.5 + 0.2 / 0.25 + 0.3 / 4.0);
    let [across, through] = along(&found);
    assert!((across / parallel - 1.0).abs() < 1e-6 && (through / series - 1.0).abs() < 1e-6, "{found:?}");
}

#[test]
fn a_phase_with_the_aggregates_values_changes_nothing_by_any_method() {
    let plain = plain();
    let options = EffectiveOptions::new(Property::Diffusivity, 2.0);
    for values in [phases(1.0, 0.1, 3.0), phases(1.0, 0.1, 1.0), phases(1.0, 0.0, 5.0)] {
        let same = with(values.clone(), &[("soft", values.diffusivity.aggregate.unwrap())]);
        let voxels = effective(packed(), &same, &options, &Silent).unwrap().0;
        let without = effective(&plain, &values, &options, &Silent).unwrap().0;
        assert_eq!(voxels.tensor, without.tensor);
        assert!((voxels.bounds.voigt - without.bounds.voigt).abs() < 1e-12);
        let [aggregate, soft, all] =
            [&voxels.phases[2], &voxels.phases[5], &without.phases[2]].map(|share| share.volume_fraction);
        assert!((aggregate + soft - all).abs() < 1e-12 && soft > 0.4 * all, "{aggregate} {soft} {all}");
        let lattice = |model, values| effective_in_tetrahedra(model, values, &options, 3.0, &Silent).unwrap().0;
        assert_eq!(lattice(packed(), &same).tensor, lattice(&plain, &values).tensor);
    }
    let options = StiffnessOptions::new(3.0);
    let (usual, same) = (PhaseModuli::default(), moduli(&[("soft", 60_000.0)]));
    let voxels = |model, values| stiffness(model, values, &options, &Silent).unwrap().0.tensor;
    // Layers of a voxel add up in another order.
    let (with, without) = (voxels(packed(), &same), voxels(&plain, &usual));
    let off = (0..36).map(|i| (with[i / 6][i % 6] - without[i / 6][i % 6]).abs()).fold(0.0, f64::max);
    assert!(off < 1e-8 * without[0][0], "{off}");
    let lattice = |model, values| stiffness_in_tetrahedra(model, values, &options, 3.0, &Silent).unwrap().0.tensor;
    assert_eq!(lattice(packed(), &same), lattice(&plain, &usual));
}

#[test]
fn a_phase_between_two_values_lies_between_the_packings_of_these_by_every_method() {
    let options = EffectiveOptions::new(Property::Diffusivity, 2.0);
    let values = |soft: f64| with(phases(1.0, 0.05, 2.0), &[("soft", soft)]);
    let voxels = |soft| entry(&effective(packed(), &values(soft), &options, &Silent).unwrap().0, 0, 0);
    let lattice =
        |soft| entry(&effective_in_tetrahedra(packed(), &values(soft), &options, 2.5, &Silent).unwrap().0, 0, 0);
    let stiff = |soft| {
        let options = StiffnessOptions::new(3.0);
        let voxels = stiffness(packed(), &moduli(&[("soft", soft)]), &options, &Silent).unwrap().0;
        let lattice = stiffness_in_tetrahedra(packed(), &moduli(&[("soft", soft)]), &options, 3.0, &Silent).unwrap().0;
        [voxels, lattice].map(|found| found.tensor[0][0])
    };
    for [low, middle, high] in [[0.05, 0.5, 4.0].map(voxels), [0.05, 0.5, 4.0].map(lattice)] {
        assert!(low * 1.02 < middle && middle * 1.02 < high, "{low} {middle} {high}");
    }
    let [soft, middle, hard] = [5e3, 2e4, 6e4].map(stiff);
    for method in 0..2 {
        assert!(soft[method] * 1.02 < middle[method] && middle[method] * 1.02 < hard[method]);
        // The two methods agree.
        assert!((soft[1] / soft[0] - 1.0).abs() < 0.03, "{soft:?}");
    }
}

#[test]
fn a_phase_without_a_value_and_a_value_without_a_phase_are_refused_by_name() {
    let options = EffectiveOptions::new(Property::Diffusivity, 2.0);
    let refused = |values: &Phases| effective(packed(), values, &options, &Silent).err().unwrap().to_string();
    let said = refused(&phases(1.0, 0.1, 1.0));
    assert!(said.starts_with("diffusivity.soft is missing; the packing has this phase: add soft = 0.1"), "{said}");
    let said = refused(&with(phases(1.0, 0.1, 1.0), &[("soft", 1.0), ("marble", 1.0)]));
    assert!(said.starts_with("diffusivity.marble is given; is no phase of the packing"), "{said}");
    let said = refused(&with(phases(1.0, 0.1, 1.0), &[("soft", -1.0)]));
    assert!(said.starts_with("diffusivity.soft is -1; it must be 0 to"), "{said}");
    let said = stiffness(packed(), &PhaseModuli::default(), &StiffnessOptions::new(3.0), &Silent).err().unwrap();
    assert!(said.to_string().starts_with("stiffness.soft is missing;"), "{said}");
}
