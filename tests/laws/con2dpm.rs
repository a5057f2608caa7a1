//! CDPM2 against OOFEM's own implementation, from the curves that `tests/oracles/con2dpm.py` keeps.

use crate::subject::{Number, WIDTH, cdpm2, mortar};
use meso_core::export::abaqus::DeckOptions;
use meso_core::formats::MeshFormat;
use meso_core::mesh::{ItzForm, MeshOptions, Method, Tools, build};
use meso_core::specimen::Specimen;
use meso_core::trial::{Sample, TestKind};
use meso_element::law::point::{HeldStress, curve};
use meso_element::law::{Cdpm2, Law, cdpm2 as law};
use std::path::Path;

/// Strain, then stress, xx yy zz xy yz zx.
type Row = [f64; 12];

fn rows(name: &str) -> Vec<Row> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/oracles/con2dpm");
    let text = std::fs::read_to_string(folder.join(format!("{name}.csv"))).unwrap();
    let row = |line: &str| -> Row {
        line.split(',').map(|cell| cell.parse().unwrap()).collect::<Vec<f64>>().try_into().unwrap()
    };
    text.lines().skip(2).map(row).collect()
}

/// The oracle's parameters: the paper's softening in compression, on no width.
fn subject<R: Number>() -> Cdpm2<R> {
    cdpm2(&mortar(), &law::Options { crushing_strain: Some(1e-4), ..Default::default() })
}

/// Steps from one row to the next: the oracle is implicit, we take small ones.
const STEPS: usize = 100;

/// Largest error of stress along x over the curve, as a share of its largest stress; and of the largest stress itself.
fn error_with_free_sides<R: Number>(name: &str, held: HeldStress) -> [f64; 2] {
    error_of(&subject::<R>(), WIDTH, name, held)
}

fn error_of<R: Number>(law: &Cdpm2<R>, width: f64, name: &str, held: HeldStress) -> [f64; 2] {
    let rows = rows(name);
    let mut strains = Vec::new();
    let mut from = 0.0;
    for row in &rows {
        strains.extend(meso_element::law::point::ramp(from, row[0], STEPS));
        from = row[0];
    }
    let found = curve(law, width, held, &strains);
    let at_rows: Vec<f64> = found.iter().skip(STEPS - 1).step_by(STEPS).map(|sample| sample.stress).collect();
    let size = |stresses: &[f64]| stresses.iter().map(|s| s.abs()).fold(0.0, f64::max);
    let theirs: Vec<f64> = rows.iter().map(|row| row[6]).collect();
    let apart: Vec<f64> = at_rows.iter().zip(&theirs).map(|(a, b)| a - b).collect();
    assert_eq!(at_rows.len(), rows.len());
    [size(&apart) / size(&theirs), size(&at_rows) / size(&theirs) - 1.0]
}

#[test]
fn curves_with_free_sides_are_within_a_percent() {
    let free = HeldStress::Lateral(0.0);
    for (name, held) in [
        ("tension", free),
        ("compression", free),
        ("biaxial", HeldStress::Third(0.0)),
        ("confined_5", HeldStress::Lateral(-5.0)),
        ("confined_10", HeldStress::Lateral(-10.0)),
        ("confined_20", HeldStress::Lateral(-20.0)),
        ("reversal", free),
        ("reload", free),
    ] {
        for [curve, peak] in [error_with_free_sides::<f64>(name, held), error_with_free_sides::<f32>(name, held)] {
            assert!(curve < 0.005 && peak.abs() < 0.005, "{name}: {curve} of the curve, {peak} of the peak");
        }
    }
}

fn error_on_a_path<R: Number>(name: &str) -> f64 {
    let (of, rows) = (subject::<R>(), rows(name));
    let mut history = <Cdpm2<R> as Law<R>>::virgin();
    let (mut from, mut worst, mut size) = ([0.0; 6], 0.0_f64, 0.0_f64);
    for row in &rows {
        let mut stress = [0.0; 6];
        for step in 1..=STEPS {
            let share = step as f64 / STEPS as f64;
            let strain = std::array::from_fn(|i| R::splat(from[i] + share * (row[i] - from[i])));
            stress = of.stress(&strain, &mut history, R::splat(WIDTH)).stress.map(Into::into);
        }
        from.copy_from_slice(&row[..6]);
        for (ours, theirs) in stress.iter().zip(&row[6..]) {
            worst = worst.max((ours - theirs).abs());
            size = size.max(theirs.abs());
        }
    }
    worst / size
}

#[test]
fn all_six_stresses_on_told_strains_are_within_half_a_percent() {
    for name in ["sheared", "wandering", "pulled_all_round", "squeezed_all_round"] {
        for error in [error_on_a_path::<f64>(name), error_on_a_path::<f32>(name)] {
            assert!(error < 0.005, "{name}: {error}");
        }
    }
}

/// Crack band of a voxel of 1 mm.
const VOXEL_WIDTH: f64 = 1.19;

/// The oracle reads its parameters from the card alone, which is the one that a deck has.
#[test]
fn the_card_of_mat_273_has_the_curves_of_the_law() {
    let options = MeshOptions { method: Method::VOXEL, element_size_mm: 1.0, itz: ItzForm::None, ..Default::default() };
    let mesh = build((&[], &Specimen::cube(4.0)), &options, &Tools::default()).unwrap();
    let mut deck = DeckOptions { analysis: TestKind::Compression.into(), materials: mortar(), ..Default::default() };
    deck.load(&Sample::of(&mesh, &Specimen::cube(4.0), &options)).unwrap();
    let mut text = Vec::new();
    let file = MeshFormat::K.files(Path::new("mesh.k"), &mesh, &deck).pop().unwrap();
    file.write(&mesh, &deck, false, &mut text).unwrap();
    let card = include_str!("../oracles/con2dpm/card.k");
    assert!(
        String::from_utf8(text).unwrap().contains(card),
        "the deck has another card than tests/oracles/con2dpm/card.k"
    );
    let law = cdpm2::<f64>(&mortar(), &law::Options::default());
    for name in ["card_tension", "card_compression"] {
        let [curve, peak] = error_of(&law, VOXEL_WIDTH, name, HeldStress::Lateral(0.0));
        assert!(curve < 0.005 && peak.abs() < 0.005, "{name}: {curve} of the curve, {peak} of the peak");
    }
}
