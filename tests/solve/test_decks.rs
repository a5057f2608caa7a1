//! Decks of named tests: the elastic ones solved by CalculiX, the explicit ones read back card by card.

use crate::deck_reader::cards;
use crate::loads::{column, cylinder, notched};
use crate::samples::{Meshed, brittle};
use meso_core::export::abaqus::{self, DeckOptions};
use meso_core::mesh::Method;
use meso_solve::{Control, Course, Expansion, LawName, Smoothing, Test, TestKind, Turn, TurnOf};
use std::process::Command;

/// A deck of the test.
fn deck(meshed: &Meshed, test: &Test) -> String {
    let mut options = DeckOptions { analysis: test.clone().into(), materials: brittle(), ..DeckOptions::default() };
    options.load(&meshed.sample()).unwrap();
    let mut deck = Vec::new();
    abaqus::write(&meshed.mesh, &options, &mut deck).unwrap();
    let deck = String::from_utf8(deck).unwrap();
    // It keeps the rules of lengths.
    cards(&deck);
    deck
}

/// The numbers that CalculiX prints for a deck; none without it.
fn printed(deck: &str) -> Option<String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("job.inp"), deck).unwrap();
    let Ok(run) = Command::new("ccx").args(["-i", "job"]).current_dir(folder.path()).output() else {
        eprintln!("skipped: no `ccx` here (Debian: calculix-ccx)");
        return None;
    };
    let log = String::from_utf8_lossy(&run.stdout).into_owned();
    let errors: Vec<&str> = log.lines().filter(|line| line.contains("*ERROR")).collect();
    assert!(run.status.success() && errors.is_empty(), "{errors:?}");
    Some(std::fs::read_to_string(folder.path().join("job.dat")).unwrap())
}

/// Reactions of a node set along x, y and z, N, after each step that CalculiX takes; none without it.
fn reactions(deck: &str, set: &str) -> Option<Vec<[f64; 3]>> {
    let text = printed(deck)?;
    let blocks = text.split("total force (fx,fy,fz) for set ").skip(1).filter(|block| block.starts_with(set));
    let row = |block: &str| {
        let numbers = block.lines().nth(2).unwrap().split_whitespace().map(|x| x.parse::<f64>().unwrap());
        <[f64; 3]>::try_from(numbers.collect::<Vec<_>>()).unwrap()
    };
    Some(blocks.map(row).collect())
}

#[test]
fn elastic_decks_of_named_tests_are_as_stiff_in_calculix_as_in_the_engine() {
    let elastic = |kind, strain| Test {
        kind,
        law: LawName::Elastic,
        smoothing: Some(Smoothing::None),
        strain: Some(strain),
        control: Some(Control::Steady),
        ..Test::default()
    };
    let beam = notched([90.0, 9.0, 24.0], [6.0, 0.0, 3.0], 3.0);
    let halves = notched([20.0, 6.0, 24.0], [6.0, 6.0, 4.0], 2.0);
    let (disc, column) = (cylinder(32.0, 8.0, 2.0), cylinder(12.0, 18.0, 3.0));
    let block = Meshed::mortar([12.0, 9.0, 18.0], Method::FITTED, 3.0);
    for (meshed, test, set, pressure) in [
        (&disc, Test { duration_s: Some(6e-4), ..elastic(TestKind::Splitting, 2e-4) }, "N_LEFT", 0.0),
        (&beam, Test { span_mm: Some(78.0), ..elastic(TestKind::Bending, 2e-4) }, "N_LEFT", 0.0),
        (
            &column,
            Test { friction: Some(0.0), duration_s: Some(4e-4), ..elastic(TestKind::Triaxial, 1e-3) },
            "N_BOTTOM",
            5.0,
        ),
        (&block, Test { friction: Some(0.0), ..elastic(TestKind::Compression, 1e-3) }, "N_BOTTOM", 0.0),
        (&block, elastic(TestKind::Tension, 1e-3), "N_BOTTOM", 0.0),
        (&halves, elastic(TestKind::Shear, 1e-4), "N_BOTTOM", 0.0),
    ] {
        let response = meshed.solve(&brittle(), &test);
        let loads = test.loads(&meshed.sample()).unwrap();
        let Some(forces) = reactions(&deck(meshed, &test), set) else { return };
        let last = response.curve.last().unwrap();
        let begun = if pressure > 0.0 { forces[0][loads.axis] } else { 0.0 };
        // The beam's left roller carries half of the load.
        let share = if test.kind == TestKind::Bending { 0.5 } else { 1.0 };
        let force = (forces.last().unwrap()[loads.axis] - begun).abs() / share;
        let theirs = force / loads.section_mm2 / (loads.path_mm[0] / loads.length_mm);
        let filled = if pressure > 0.0 { meshed.mesh_volume_mm3() / meshed.specimen.volume() } else { 1.0 };
        let ours = (last.stress_mpa - pressure * filled) / last.strain;
        assert!((ours / theirs - 1.0).abs() < 0.01, "{:?}: ours {ours}, theirs {theirs}", test.kind);
        if pressure > 0.0 {
            assert!((begun.abs() / loads.section_mm2 / pressure / filled - 1.0).abs() < 0.01, "{begun}");
        }
    }
}

#[test]
fn the_crack_mouth_of_an_elastic_beam_opens_as_in_calculix() {
    let beam = notched([90.0, 9.0, 24.0], [6.0, 0.0, 3.0], 3.0);
    let test = Test {
        kind: TestKind::Bending,
        law: LawName::Elastic,
        smoothing: Some(Smoothing::None),
        strain: Some(2e-4),
        span_mm: Some(78.0),
        control: Some(Control::Steady),
        ..Test::default()
    };
    let response = beam.solve(&brittle(), &test);
    let loads = test.loads(&beam.sample()).unwrap();
    // Nodes of the lower side at the notch.
    let at = |side: f64| {
        let all = (1..).zip(&beam.mesh.points);
        let own = all.filter(|(_, point)| point.z.abs() < 1e-9 && (side * (point.x - 45.0) - 1.5).abs() < 1e-6);
        own.map(|(number, _): (usize, _)| number.to_string()).collect::<Vec<_>>()
    };
    let [left, right] = [-1.0, 1.0].map(at);
    assert!(left.len() == right.len() && left.len() >= 4, "{left:?} {right:?}");
    let sets = format!("*NSET, NSET=M_LEFT\n{}\n*NSET, NSET=M_RIGHT\n{}\n*STEP", left.join(",\n"), right.join(",\n"));
    let print = "*NODE PRINT, NSET=M_LEFT\nU\n*NODE PRINT, NSET=M_RIGHT\nU\n*END STEP";
    let deck = deck(&beam, &test).replacen("*STEP", &sets, 1).replace("*END STEP", print);
    let Some(text) = printed(&deck) else { return };
    let mean = |set: &str| {
        let block = text.split(&format!("displacements (vx,vy,vz) for set {set}")).last().unwrap();
        let rows = block.lines().skip(2).take_while(|line| !line.trim().is_empty());
        let along: Vec<f64> = rows.map(|row| row.split_whitespace().nth(1).unwrap().parse().unwrap()).collect();
        along.iter().sum::<f64>() / along.len() as f64
    };
    let theirs = (mean("M_RIGHT") - mean("M_LEFT")) / (loads.path_mm[0] / loads.length_mm);
    let ours = column(&response, "crack_mouth_mm").last().unwrap() / response.curve.last().unwrap().strain;
    assert!(theirs > 0.0 && (ours / theirs - 1.0).abs() < 0.01, "ours {ours}, theirs {theirs}");
}

#[test]
fn rows_of_times_and_layers_are_refused_in_a_deck() {
    let meshed = Meshed::mortar([12.0, 9.0, 6.0], Method::FITTED, 3.0);
    let rows = Expansion { mortar: Course::Through(vec![[10.0, 1e-4]]), ..Expansion::default() };
    let layer = Expansion { mortar: 1e-4.into(), layer_mm: Some(2.0), ..Expansion::default() };
    for expansion in [rows, layer] {
        let test = Test { kind: TestKind::Expansion, expansion: Some(expansion), ..Test::default() };
        let error = test.loads(&meshed.sample()).unwrap_err().to_string();
        assert!(error.contains("test.expansion is mortar 1e-4") && error.contains("give numbers"), "{error}");
        assert_eq!(test.suits_deck(&meshed.specimen).unwrap_err().to_string(), error);
    }
}

#[test]
fn phases_swell_by_their_strains_in_calculix() {
    let meshed = Meshed::mortar([12.0, 9.0, 6.0], Method::FITTED, 3.0);
    let expansion = Some(Expansion { mortar: 1e-3.into(), ..Expansion::default() });
    let free =
        Test { kind: TestKind::Expansion, law: LawName::Elastic, expansion: expansion.clone(), ..Test::default() };
    let free = deck(&meshed, &free);
    assert!(free.contains("*EXPANSION, ZERO=0.0\n0.001,\n") && !free.contains("N_BOTTOM"), "{free}");
    // Glued plates that stay where they are restrain it along z.
    let restrained =
        Test { kind: TestKind::Tension, strain: Some(1e-9), law: LawName::Elastic, expansion, ..Test::default() };
    let Some(forces) = reactions(&deck(&meshed, &restrained), "N_BOTTOM") else { return };
    let stress = forces[0][2] / (12.0 * 9.0) / (brittle().mortar.youngs_modulus_mpa * 1e-3);
    // Between 1 (free sides) and 1 / (1 - 2 nu) (restrained ones).
    assert!((1.0..1.67).contains(&stress), "{stress}");
}

#[test]
fn a_confined_deck_presses_first_and_moves_its_plates_then() {
    let meshed = cylinder(12.0, 12.0, 3.0);
    let test = Test { kind: TestKind::Triaxial, pressure_mpa: Some(7.0), ..Test::default() };
    let text = deck(&meshed, &test);
    assert_eq!(cards(&text).iter().filter(|card| card.keyword == "STEP").count(), 2, "{text}");
    assert!(text.contains("S_PRESSURE_1, P, 7.0"), "{text}");
    // The area of the end, which chords bound, times the pressure.
    let force: f64 = text.split("REF_TOP, 3, -").nth(1).unwrap().lines().next().unwrap().parse().unwrap();
    assert!((0.9..1.0).contains(&(force / 7.0 / (36.0 * std::f64::consts::PI))), "{force}");
    // Speeds over the time are the plates' ways, half of the path each.
    let table = text.split("*AMPLITUDE, NAME=PATH\n").nth(1).unwrap().split('*').next().unwrap();
    let values: Vec<f64> = table.split([',', '\n']).filter_map(|value| value.trim().parse().ok()).collect();
    let points: Vec<&[f64]> = values.chunks(2).collect();
    let mean: f64 = points.windows(2).map(|w| 0.5 * (w[0][1] + w[1][1]) * (w[1][0] - w[0][0])).sum();
    let end = text.split("*BOUNDARY, TYPE=VELOCITY, AMPLITUDE=PATH\n").nth(1).unwrap();
    let ways: Vec<f64> = end
        .lines()
        .take(2)
        .map(|line| mean * line.rsplit(',').next().unwrap().trim().parse::<f64>().unwrap())
        .collect();
    assert!((ways[0] - 0.06).abs() < 1e-5 && (ways[1] + 0.06).abs() < 1e-5, "{ways:?}");
}

#[test]
fn plates_of_a_biaxial_deck_are_linked_by_their_ratio_of_forces() {
    let meshed = Meshed::mortar([12.0, 9.0, 18.0], Method::FITTED, 3.0);
    let text = deck(&meshed, &Test { kind: TestKind::Biaxial, stress_ratio: Some(0.5), ..Test::default() });
    let equation: Vec<&str> = text.split("*EQUATION\n").nth(1).unwrap().lines().take(4).collect();
    let nodes = meshed.mesh.points.len();
    // The side has 9 by 18 mm, the upper end 12 by 9 mm.
    let (top, right, path) = (nodes + 2, nodes + 4, equation[3].split(',').next().unwrap());
    assert_eq!(equation[..3], ["3", &format!("{top}, 3, 1.0"), &format!("{right}, 1, 0.75")], "{equation:?}");
    assert!(text.contains(&format!("{path}, 1, 1, ")) && text.contains("*NSET, NSET=REF_PATH"), "{text}");
}

#[test]
fn a_cyclic_deck_turns_at_its_strains() {
    let meshed = Meshed::mortar([6.0; 3], Method::FITTED, 3.0);
    let turns = [0.002, 0.001, 0.004].map(|at| Turn { at, of: TurnOf::Strain }).to_vec();
    let text = deck(&meshed, &Test { kind: TestKind::Cyclic, turns, duration_s: Some(0.6), ..Test::default() });
    let table =
        text.split("*AMPLITUDE, NAME=PATH, DEFINITION=SMOOTH STEP\n").nth(1).unwrap().split('*').next().unwrap();
    let values: Vec<f64> = table.split([',', '\n']).filter_map(|value| value.trim().parse().ok()).collect();
    let expected = [0.0, 0.0, 0.2, 0.5, 0.3, 0.25, 0.6, 1.0];
    assert!(values.len() == 8 && values.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{values:?}");
}

#[test]
fn histories_that_a_deck_cannot_follow_are_refused_with_a_remedy() {
    let meshed = Meshed::mortar([6.0; 3], Method::FITTED, 3.0);
    let cyclic = Test { kind: TestKind::Cyclic, ..Test::default() };
    let led = Test { control: Some(Control::LateralStrain), ..Test::default() };
    for (test, why) in [(cyclic, "give turns of a strain"), (led, "test.control is lateral-strain; a deck's plates")] {
        let error = test.loads(&meshed.sample()).unwrap_err().to_string();
        assert!(error.contains(why), "{error}");
    }
    let biaxial = Test { kind: TestKind::Biaxial, law: LawName::Elastic, ..Test::default() };
    let mut options = DeckOptions { analysis: biaxial.into(), ..DeckOptions::default() };
    options.load(&meshed.sample()).unwrap();
    let error = abaqus::write(&meshed.mesh, &options, std::io::sink()).unwrap_err().to_string();
    assert!(error.contains("*STATIC has no servo"), "{error}");
}
