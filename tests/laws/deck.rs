//! The law and the deck of one material are twins: the deck's tables, read from its text, against one point's curve.

use crate::subject::{Number, cdp, from_peak, mortar, peak};
use meso_core::export::abaqus::{DeckOptions, write};
use meso_core::mesh::{ItzForm, Mesh, MeshOptions, Method, Tools, build};
use meso_core::specimen::Specimen;
use meso_core::trial::{Sample, TestKind};
use meso_element::law::point::{HeldStress, Reading, curve, ramp};

const E: f64 = 26_000.0;

/// The two numbers of every row of the first card `keyword`.
fn rows(deck: &str, keyword: &str) -> Vec<[f64; 2]> {
    let lines = deck.lines().skip_while(|line| !line.starts_with(keyword)).skip(1);
    let data = lines.take_while(|line| !line.starts_with('*'));
    data.map(|line| {
        let mut cells = line.split(',').map(|cell| cell.trim().parse().unwrap());
        [cells.next().unwrap(), cells.next().unwrap()]
    })
    .collect()
}

/// Edge of a cube of mortar, mm.
const EDGE: f64 = 4.0;

fn mesh(method: Method) -> Mesh {
    let options = MeshOptions { method, element_size_mm: 1.0, itz: ItzForm::None, ..Default::default() };
    build((&[], &Specimen::cube(EDGE)), &options, &Tools::default()).unwrap()
}

fn deck(mesh: &Mesh) -> String {
    let mut options = DeckOptions { analysis: TestKind::Compression.into(), materials: mortar(), ..Default::default() };
    options.load(&Sample::of(mesh, &Specimen::cube(EDGE), &MeshOptions::default())).unwrap();
    let mut text = Vec::new();
    write(mesh, &options, &mut text).unwrap();
    String::from_utf8(text).unwrap()
}

/// Size of the stress at an inelastic strain, between samples.
fn at(curve: &[Reading], inelastic: f64) -> f64 {
    let of = |s: &Reading| s.strain.abs() - s.stress.abs() / E;
    let after = curve.iter().position(|s| of(s) >= inelastic).unwrap().max(1);
    let [a, b] = [&curve[after - 1], &curve[after]];
    let share = (inelastic - of(a)) / (of(b) - of(a));
    (a.stress + share * (b.stress - a.stress)).abs()
}

/// An element of mean volume: its crack band in our engine, of `edges` of its shape, and Abaqus' characteristic length.
fn twins<R: Number>(method: Method, edges: f64) {
    let mesh = mesh(method);
    let (of, deck) = (cdp::<R>(&mortar()), deck(&mesh));
    let across = (EDGE.powi(3) / mesh.cell_count() as f64).cbrt();
    let width = edges * across;
    let held = HeldStress::Lateral(0.0);
    let crushed = curve(&of, width, held, &ramp(0.0, -0.05, 10_000).collect::<Vec<_>>());
    let table = rows(&deck, "*CONCRETE COMPRESSION HARDENING");
    let top = table.iter().position(|row| row[0] == 40.0).unwrap();
    let before = &crushed[..crushed.len() - from_peak(&crushed).len() + 1];
    for [stress, strain] in &table[1..top] {
        assert!((at(before, *strain) - stress).abs() < 0.026 * 40.0, "{stress} at {strain}: {}", at(before, *strain));
    }
    let peak = peak(&crushed);
    assert!((peak.strain.abs() - peak.stress.abs() / E - table[top][1]).abs() < 1e-5);
    for [stress, strain] in table[top + 1..].iter().filter(|row| row[1] < 0.045) {
        assert!((at(from_peak(&crushed), *strain) - stress).abs() < 1e-3 * 40.0, "{stress} at {strain}");
    }
    let pulled = curve(&of, width, held, &ramp(0.0, 0.1, 10_000).collect::<Vec<_>>());
    let table = rows(&deck, "*CONCRETE TENSION STIFFENING");
    for [stress, opening] in &table[1..] {
        let found = at(from_peak(&pulled), opening / across);
        assert!((found - stress).abs() < 1e-3 * 3.0, "{stress} at {opening}: {found}");
    }
}

#[test]
fn deck_and_law_have_the_same_curves() {
    // The regular tetrahedron's edge is (6 sqrt 2)^(1/3) = 2.0396 times the cube root of its volume.
    for (method, edges) in [(Method::VOXEL, 1.19), (Method::FITTED, 1.4 * 2.039_649)] {
        twins::<f64>(method, edges);
        twins::<f32>(method, edges);
    }
}
