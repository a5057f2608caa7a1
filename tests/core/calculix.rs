//! CalculiX, a solver we did not write, on our elastic decks. Skipped, with a message, where `ccx` is not installed.

use meso_core::aggregate::Grading;
use meso_core::export::abaqus::{self, Analysis, DeckOptions};
use meso_core::materials::Materials;
use meso_core::mesh::{self, ItzForm, Mesh, MeshOptions, Method, Phase, PhaseVolumes};
use meso_core::packing::Specimen;
use meso_core::{Model, Silent, Spec};
use std::path::Path;
use std::process::Command;

/// Sums of the reactions (x, y, z) of ZMIN and ZMAX, N; `None` without a solver.
fn reactions(mesh: &Mesh) -> Option<[[f64; 3]; 2]> {
    let folder = tempfile::tempdir().unwrap();
    let options = DeckOptions { analysis: Analysis::Elastic, ..Default::default() };
    abaqus::write(mesh, &options, std::fs::File::create(folder.path().join("job.inp")).unwrap()).unwrap();
    let Ok(run) = Command::new("ccx").args(["-i", "job"]).current_dir(folder.path()).output() else {
        eprintln!("skipped: no `ccx` here (Debian: calculix-ccx)");
        return None;
    };
    let log = String::from_utf8_lossy(&run.stdout).into_owned();
    let errors: Vec<&str> = log.lines().filter(|line| line.contains("*ERROR")).take(5).collect();
    assert!(run.status.success() && errors.is_empty(), "{errors:?}");
    assert!(!log.contains("*WARNING reading"));
    Some(totals(&folder.path().join("job.dat")))
}

/// The rows below "total force (fx,fy,fz) for set ...".
fn totals(dat: &Path) -> [[f64; 3]; 2] {
    let text = std::fs::read_to_string(dat).unwrap();
    let mut rows = text.split("total force (fx,fy,fz) for set").skip(1).map(|block| {
        let numbers = block.lines().nth(2).unwrap().split_whitespace().map(|x| x.parse::<f64>().unwrap());
        let row: Vec<f64> = numbers.collect();
        [row[0], row[1], row[2]]
    });
    [rows.next().unwrap(), rows.next().unwrap()]
}

/// Effective modulus, MPa, after checking that the reactions balance.
fn modulus(mesh: &Mesh, area: f64) -> Option<f64> {
    let [bottom, top] = reactions(mesh)?;
    for axis in 0..3 {
        assert!((bottom[axis] + top[axis]).abs() < 1e-6 * bottom[2].abs(), "{bottom:?} {top:?}");
    }
    Some(bottom[2] / area / 0.001)
}

/// Hashin-Shtrikman bounds of Young's modulus from the mesh's own fractions: Z(z) = (sum f_i / (k_i + z))^-1 - z, with
/// z from the softest and the stiffest phase; E = 9 K G / (3 K + G).
fn hashin_shtrikman(volumes: &PhaseVolumes, materials: &Materials) -> [f64; 2] {
    let fractions = [volumes.aggregate, volumes.itz, volumes.mortar].map(|v| v / volumes.total());
    let moduli = Phase::ALL.map(|phase| {
        let elastic = materials.elastic(phase);
        let (e, nu) = (elastic.youngs_modulus_mpa, elastic.poisson_ratio);
        (e / (3.0 * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)))
    });
    let mean = |x: [f64; 3], z: f64| 1.0 / (0..3).map(|i| fractions[i] / (x[i] + z)).sum::<f64>() - z;
    let present = |i: &usize| fractions[*i] > 0.0;
    [false, true].map(|upper| {
        let pick = |x: [f64; 3]| {
            let values = (0..3).filter(present).map(|i| x[i]);
            if upper { values.fold(0.0, f64::max) } else { values.fold(f64::MAX, f64::min) }
        };
        let (bulk, shear) = (moduli.map(|m| m.0), moduli.map(|m| m.1));
        let (k, g) = (pick(bulk), pick(shear));
        let bulk = mean(bulk, 4.0 / 3.0 * g);
        let shear = mean(shear, g * (9.0 * k + 8.0 * g) / (6.0 * (k + 2.0 * g)));
        9.0 * bulk * shear / (3.0 * bulk + shear)
    })
}

/// A packing of 40 mm with grains of 8 to 16 mm, at 35 %.
fn packed() -> Model {
    let mut spec = Spec { fraction: 0.35, specimen: Specimen::cube(40.0), ..Default::default() };
    spec.grading = Grading { d_min_mm: 8.0, d_max_mm: 16.0, classes_mm: vec![8.0, 16.0], ..spec.grading };
    meso_core::pack(&spec, &Silent).unwrap()
}

#[test]
fn calculix_finds_moduli_between_the_hashin_shtrikman_bounds_that_agree() {
    let model = packed();
    let mut moduli = Vec::new();
    for method in [Method::Voxel, Method::Lattice] {
        // At 2 mm, a quarter of the smallest grain, the staircase of voxels is 3.3 % stiffer than the fitted lattice.
        let options = MeshOptions { method, itz: ItzForm::None, element_size_mm: 1.6, ..Default::default() };
        let mesh = mesh::build(&model, &options).unwrap();
        let Some(modulus) = modulus(&mesh, 1600.0) else { return };
        let [low, high] = hashin_shtrikman(&PhaseVolumes::of_mesh(&mesh), &Materials::default());
        assert!(low < modulus && modulus < high, "{method:?}: {low} < {modulus} < {high}");
        moduli.push(modulus);
    }
    assert!((moduli[0] / moduli[1] - 1.0).abs() < 0.03, "{moduli:?}");
}
