//! CalculiX, a solver we did not write, on the same mesh. Skipped, with a message, where `ccx` is not installed.

use crate::samples::{Meshed, brittle, concrete};
use meso_core::export::abaqus::{self, Analysis, DeckOptions};
use meso_core::materials::Materials;
use meso_core::mesh::{ItzForm, Method};
use meso_solve::{LawName, Smoothing, Test};
use std::process::Command;

/// Modulus that CalculiX gives with our element types, MPa.
fn theirs(meshed: &Meshed, materials: &Materials) -> Option<f64> {
    let folder = tempfile::tempdir().unwrap();
    let options = DeckOptions {
        analysis: Analysis::Elastic,
        reduced_integration: true,
        materials: materials.clone(),
        ..DeckOptions::default()
    };
    let mut deck = Vec::new();
    abaqus::write(&meshed.mesh, &options, &mut deck).unwrap();
    let deck = String::from_utf8(deck).unwrap();
    let deck = deck.replace("TYPE=C3D8R, ELSET=AGGREGATE", "TYPE=C3D8I, ELSET=AGGREGATE");
    std::fs::write(folder.path().join("job.inp"), deck).unwrap();
    let Ok(run) = Command::new("ccx").args(["-i", "job"]).current_dir(folder.path()).output() else {
        eprintln!("skipped: no `ccx` here (Debian: calculix-ccx)");
        return None;
    };
    assert!(run.status.success());
    let text = std::fs::read_to_string(folder.path().join("job.dat")).unwrap();
    let block = text.split("total force (fx,fy,fz) for set").nth(1).unwrap();
    let row: Vec<f64> = block.lines().nth(2).unwrap().split_whitespace().map(|x| x.parse().unwrap()).collect();
    Some(row[2].abs() / (24.0 * 24.0) / 0.001)
}

#[test]
fn moduli_are_those_of_calculix_on_the_same_mesh() {
    // Boxes of mortar are C3D8R, those of aggregate C3D8I.
    for (method, size) in [(Method::FITTED, 3.0), (Method::VOXEL, 2.0), (Method::VOXEL, 1.5)] {
        let meshed = concrete(1.0, method, size, ItzForm::None);
        let materials = brittle();
        let Some(theirs) = theirs(&meshed, &materials) else { return };
        let test = Test {
            law: LawName::Elastic,
            smoothing: Some(Smoothing::None),
            friction: Some(0.0),
            strain: Some(1e-3),
            duration_s: Some(1.2e-3),
            ..Test::default()
        };
        let response = meshed.solve(&materials, &test);
        let last = response.curve.last().unwrap();
        let ours = last.stress_mpa / last.strain;
        assert!((ours / theirs - 1.0).abs() < 1e-3, "{method:?} {size}: ours {ours}, theirs {theirs}");
    }
}
