//! Deck and engine read one table: every key of `[materials]` changes both, or stands here as one that only decks have.

use crate::samples::{concrete, damaged_plasticity, small_cube};
use meso_core::export::abaqus::{self, DeckOptions};
use meso_core::materials::Materials;
use meso_core::mesh::{ItzForm, Method};
use meso_core::{Silent, Spec};
use meso_solve::TestKind;
use meso_solve::{Interface, LawName, Test};
use serde_json::Value;

use crate::samples::{Meshed, options};

/// Abaqus/Explicit, which runs the decks' tests, ignores the viscosity too: it is for a Standard step of one's own.
const DECK_ALONE: [&str; 1] = ["plasticity.viscosity_s"];

/// Names and values of all keys, dotted.
fn keys(value: &Value, name: &str) -> Vec<String> {
    match value {
        Value::Object(table) => table.iter().flat_map(|(key, value)| keys(value, &format!("{name}.{key}"))).collect(),
        Value::Array(values) => (0..values.len()).flat_map(|i| keys(&values[i], &format!("{name}.{i}"))).collect(),
        // Values that are absent have no number to change.
        Value::Null => Vec::new(),
        _ => vec![name.trim_start_matches('.').to_owned()],
    }
}

/// The default materials with the value of `key` 4 % larger.
fn changed(key: &str) -> Materials {
    let mut all = serde_json::to_value(Materials::default()).unwrap();
    let place = all.pointer_mut(&format!("/{}", key.replace('.', "/"))).unwrap();
    *place = (1.04 * place.as_f64().unwrap()).into();
    serde_json::from_value(all).unwrap()
}

/// The small cube with cohesive elements, and with a solid ITZ and fibres: together they have every kind of element.
fn meshes() -> [Meshed; 2] {
    let mut spec: Spec = small_cube(1.0).spec;
    spec.fibres = Some(serde_json::from_str(r#"{"fraction": 0.02, "diameter_mm": 2.0, "length_mm": 10.0}"#).unwrap());
    let model = meso_core::pack(&spec, &Silent).unwrap();
    let solid = options(Method::VOXEL, 1.5, ItzForm::Solid);
    [
        concrete(0.5, Method::FITTED, 3.0, ItzForm::Cohesive),
        Meshed::of(&model.bodies(), model.spec.specimen.clone(), solid),
    ]
}

fn decks(meshes: &[Meshed], materials: &Materials) -> Vec<u8> {
    let mut text = Vec::new();
    for meshed in meshes {
        let mut deck = DeckOptions {
            analysis: TestKind::Compression.into(),
            allow_joined: true,
            materials: materials.clone(),
            ..DeckOptions::default()
        };
        deck.load(&meshed.sample()).unwrap();
        abaqus::write(&meshed.mesh, &deck, &mut text).unwrap();
    }
    text
}

/// Few steps and much strain: into softening, physics apart.
fn fast() -> Test {
    Test { duration_s: Some(6e-5), time_step_s: Some(3e-7), rows: 50, ..damaged_plasticity() }
}

fn curve(meshed: &Meshed, materials: &Materials, test: &Test) -> Vec<u64> {
    let rows = meshed.solve(materials, test).curve;
    rows.iter().flat_map(|row| row.values()).map(f64::to_bits).collect()
}

#[test]
fn every_key_of_materials_changes_deck_and_engine() {
    let meshes = meshes();
    let usual = Materials::default();
    let deck = decks(&meshes, &usual);
    // A deck cannot follow the laws whose tables these are.
    let laws = [("meso.", LawName::Meso), ("cdpm2.", LawName::Cdpm2), ("", LawName::Cdp)].map(|(table, law)| {
        let test = Test { law, ..fast() };
        let usual = meshes.each_ref().map(|meshed| curve(meshed, &usual, &test));
        (table, test, usual)
    });
    let keys = keys(&serde_json::to_value(&usual).unwrap(), "");
    assert!(keys.len() >= 26, "{keys:?}");
    for key in &keys {
        let materials = changed(key);
        assert_ne!(materials, usual, "{key}");
        let (table, test, curves) = laws.iter().find(|(table, ..)| key.starts_with(table)).unwrap();
        assert_eq!(decks(&meshes, &materials) != deck, table.is_empty(), "{key} in the decks");
        let moves = meshes.iter().zip(curves).any(|(meshed, usual)| curve(meshed, &materials, test) != *usual);
        assert_eq!(moves, !DECK_ALONE.contains(&key.as_str()), "{key} in the engine");
    }
}

/// The engine alone, not a deck, has friction between separated faces.
#[test]
fn friction_in_cracks_is_the_engine_s_alone() {
    let meshes = meshes();
    let usual = Materials::default();
    let test = |friction| Test { interface: Interface { friction }, ..fast() };
    assert!(meshes.iter().any(|meshed| curve(meshed, &usual, &test(0.0)) != curve(meshed, &usual, &test(0.6))));
}
