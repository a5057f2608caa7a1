//! Decks of tests in real time: bars, masses and speeds have the numbers of the test, in both formats.

use crate::mesh::voxel::loaded;
use crate::pack::models::two_boxes;
use crate::write::deck_reader;
use meso_core::export::abaqus::{Analysis, DeckOptions};
use meso_core::formats::MeshFormat;
use meso_core::mesh::{self, Mesh, MeshOptions, Tools};
use meso_core::trial::{Test, TestKind};
use std::path::Path;

/// Two boxes in mortar, in voxels of 10 mm.
fn voxels() -> Mesh {
    let options = MeshOptions { element_size_mm: 10.0, ..Default::default() };
    mesh::build(&two_boxes(), &options, &Tools::default()).unwrap()
}

fn text(test: Test, format: MeshFormat) -> String {
    let mesh = voxels();
    let deck = DeckOptions { analysis: test.into(), allow_joined: true, ..DeckOptions::default() };
    let path = format!("deck.{}", format.extension());
    let files = format.files(Path::new(&path), &mesh, &deck);
    let mut bytes = Vec::new();
    files.last().unwrap().write(&mesh, &loaded(&mesh, &deck), false, &mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

/// The numbers of the Abaqus card with this keyword, one of whose parameters has this value.
fn card(text: &str, keyword: &str, value: &str) -> Vec<f64> {
    let cards = deck_reader::cards(text);
    let is_it = |card: &&deck_reader::Card| card.keyword == keyword && card.parameters.values().any(|own| own == value);
    let card = cards.iter().find(is_it).unwrap_or_else(|| panic!("{keyword} {value}"));
    card.data.iter().flatten().filter_map(|entry| entry.parse().ok()).collect()
}

/// Numbers of the first line behind an LS-DYNA keyword, `skip` lines further.
fn fields(text: &str, keyword: &str, skip: usize) -> Vec<f64> {
    let line = text.lines().skip_while(|line| *line != keyword).nth(1 + skip).unwrap_or_else(|| panic!("{keyword}"));
    line.split_whitespace().map(|entry| entry.parse().unwrap()).collect()
}

#[test]
fn a_bar_is_a_dashpot_of_its_impedance_and_a_force_of_twice_its_wave() {
    let hopkinson = || Test { kind: TestKind::Hopkinson, speed_m_per_s: Some(6.0), ..Test::default() };
    let [inp, k] = [MeshFormat::Inp, MeshFormat::K].map(|format| text(hopkinson(), format));
    let size = two_boxes().spec.specimen.aabb().size();
    let impedance = size.x * size.y * (2.1e5 * 7.85e-9_f64).sqrt();
    let near = |found: f64, asked: f64| assert!((found / asked - 1.0).abs() < 1e-4, "{found} {asked}");
    near(card(&inp, "DASHPOT", "BAR_INPUT")[0], impedance);
    near(card(&inp, "CLOAD", "DRIVE_INPUT")[1], 2.0 * impedance);
    // Half of the striker's speed, in mm/s, after the rise.
    assert_eq!(card(&inp, "AMPLITUDE", "DRIVE_INPUT"), [0.0, 0.0, 2e-5, 3000.0, 1e-4, 3000.0, 1.2e-4, 0.0]);
    assert!(!inp.contains("MASS SCALING") && !inp.contains("DRIVE_OUTPUT"), "{inp}");
    near(fields(&k, "*MAT_DAMPER_VISCOUS", 0)[1], impedance);
    near(fields(&k, "*LOAD_RIGID_BODY", 0)[3], 2.0 * impedance);
    assert_eq!(fields(&k, "*CONTROL_TIMESTEP", 0)[4], 0.0);
    // The mass that the impedance stops while a wave passes an element, which `loaded` takes to have 2 mm.
    let mass = card(&inp, "MASS", "MASS_INPUT")[0];
    near(mass, impedance * 2.0 / 5e6);
    let (low, high) = (0.1 * size, 0.1 * size.max());
    near(fields(&k, "*MAT_RIGID", 0)[1], mass / ((size.x + 2.0 * low.x) * (size.y + 2.0 * low.y) * high));
}

#[test]
fn a_mass_strikes_with_its_speed_and_a_plate_follows_its_own() {
    let drop = Test { kind: TestKind::Drop, mass_kg: Some(2.0), speed_m_per_s: Some(3.0), ..Test::default() };
    let mut upper = Test { kind: TestKind::Drop, ..Test::default() };
    let [inp, k] = [MeshFormat::Inp, MeshFormat::K].map(|format| text(drop.clone(), format));
    assert_eq!(card(&inp, "MASS", "MASS_LOAD"), [2e-3]);
    assert!(inp.contains("*INITIAL CONDITIONS, TYPE=VELOCITY\nREF_LOAD, 3, -3000.0\n"), "{inp}");
    assert_eq!(fields(&k, "*INITIAL_VELOCITY_RIGID_BODY", 0)[1..], [0.0, 0.0, -3000.0]);
    // By a file the word for the analysis is another one than the striker of a .k.
    upper.kind = TestKind::Impact;
    let [inp, k] = [MeshFormat::Inp, MeshFormat::K].map(|format| text(upper.clone(), format));
    assert_eq!(card(&inp, "AMPLITUDE", "DRIVE_PLATE"), [0.0, 0.0, 1e-5, 8000.0]);
    assert!(inp.contains("*BOUNDARY, TYPE=VELOCITY, AMPLITUDE=DRIVE_PLATE\nREF_PLATE, 3, 3, -1.0\n"), "{inp}");
    assert_eq!(fields(&k, "*BOUNDARY_PRESCRIBED_MOTION_RIGID", 0)[1..5], [3.0, 0.0, 4.0, -1.0]);
}

#[test]
fn a_deck_of_a_test_in_real_time_has_neither_rates_nor_statics() {
    let refused = |test: Test| DeckOptions { analysis: Analysis::from(test), ..Default::default() }.follows();
    let fast = || Test { kind: TestKind::Hopkinson, ..Test::default() };
    assert!(refused(fast()).is_ok());
    for (test, part) in [
        (Test { rate_effect: true, ..fast() }, "laws of a deck here have no rate"),
        (Test { law: meso_core::materials::LawName::Elastic, ..fast() }, "a deck of this law is static"),
    ] {
        let error = refused(test).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
}
