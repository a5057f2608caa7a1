//! CalculiX, a solver we did not write, on our elastic decks. Skipped, with a message, where `ccx` is not installed.

use crate::mesh::voxel::{deck, loaded};
use meso_core::aggregate::Grading;
use meso_core::export::abaqus::{self, Analysis, DeckOptions};
use meso_core::materials::Materials;
use meso_core::mesh::conforming::Surfaces;
use meso_core::mesh::{
    self, ItzForm, Joined, Mesh, MeshError, MeshOptions, Method, Phase, PhaseNames, PhaseVolumes, Tools,
};
use meso_core::specimen::Specimen;
use meso_core::trial::TestKind;
use meso_core::{Model, Silent, Spec};
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// Sums of the reactions (x, y, z) of ZMIN and ZMAX that a deck gives, N; `files` lie beside it. `None` without a solver.
fn reactions(deck: &str, files: &[(&str, &str)]) -> Option<[[f64; 3]; 2]> {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files.iter().chain(&[("job.inp", deck)]) {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let Ok(run) = Command::new("ccx").args(["-i", "job"]).current_dir(folder.path()).output() else {
        eprintln!("skipped: no `ccx` here (Debian: calculix-ccx)");
        return None;
    };
    let log = String::from_utf8_lossy(&run.stdout).into_owned();
    let errors: Vec<&str> = log.lines().filter(|line| line.contains("*ERROR")).take(5).collect();
    assert!(run.status.success() && errors.is_empty(), "{errors:?}");
    let warnings = warnings(&log);
    assert!(warnings.iter().all(|warning| !warning.contains("reading")), "{warnings:?}");
    Some(totals(&folder.path().join("job.dat")))
}

/// The warnings of a run, but for two: that `*OUTPUT, FIELD`, which Abaqus needs, has a parameter unknown to CalculiX.
pub(crate) fn warnings(log: &str) -> Vec<&str> {
    let lines: Vec<&str> = log.lines().map(str::trim).collect();
    let known = |i: usize| {
        let after = |n: usize| lines.get(i + n).copied().unwrap_or("");
        lines[i].contains("*NODE FILE or *EL FILE") && after(2) == "FIELD"
            || lines[i].contains("reading *OUTPUT .") && after(1) == "*OUTPUT,FIELD"
    };
    (0..lines.len()).filter(|&i| lines[i].starts_with("*WARNING") && !known(i)).map(|i| lines[i]).collect()
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
pub(crate) fn modulus(mesh: &Mesh, area: f64) -> Option<f64> {
    modulus_of(&deck(mesh, &elastic()), &[], area)
}

pub(crate) fn elastic() -> DeckOptions {
    DeckOptions { analysis: Analysis::Elastic, ..Default::default() }
}

/// Young's modulus from a deck and the files beside it, MPa.
pub(crate) fn modulus_of(deck: &str, files: &[(&str, &str)], area: f64) -> Option<f64> {
    let [bottom, top] = reactions(deck, files)?;
    for axis in 0..3 {
        assert!((bottom[axis] + top[axis]).abs() < 1e-6 * bottom[2].abs(), "{bottom:?} {top:?}");
    }
    Some(bottom[2] / area / 0.001)
}

/// Hashin-Shtrikman bounds of Young's modulus from the mesh's own fractions: Z(z) = (sum f_i / (k_i + z))^-1 - z, with
/// z from the softest and the stiffest phase; E = 9 K G / (3 K + G).
pub(crate) fn hashin_shtrikman(volumes: &PhaseVolumes, materials: &Materials) -> [f64; 2] {
    let fractions = Phase::SOLID.map(|phase| volumes.of(phase) / volumes.total());
    let moduli = Phase::SOLID.map(|phase| {
        let elastic = materials.elastic(phase, PhaseNames::COMMON);
        let (e, nu) = (elastic.youngs_modulus_mpa, elastic.poisson_ratio);
        (e / (3.0 * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)))
    });
    let mean = |x: [f64; 4], z: f64| 1.0 / (0..4).map(|i| fractions[i] / (x[i] + z)).sum::<f64>() - z;
    let present = |i: &usize| fractions[*i] > 0.0;
    [false, true].map(|upper| {
        let pick = |x: [f64; 4]| {
            let values = (0..4).filter(present).map(|i| x[i]);
            if upper { values.fold(0.0, f64::max) } else { values.fold(f64::MAX, f64::min) }
        };
        let (bulk, shear) = (moduli.map(|m| m.0), moduli.map(|m| m.1));
        let (k, g) = (pick(bulk), pick(shear));
        let bulk = mean(bulk, 4.0 / 3.0 * g);
        let shear = mean(shear, g * (9.0 * k + 8.0 * g) / (6.0 * (k + 2.0 * g)));
        9.0 * bulk * shear / (3.0 * bulk + shear)
    })
}

/// Cross-section of [`packed`], mm2.
pub(crate) const AREA_MM2: f64 = 900.0;

/// A packing of 30 mm with grains of 8 to 16 mm, at 35 %.
pub(crate) fn packed() -> Model {
    let mut spec = Spec { fraction: 0.35, specimen: Specimen::cube(30.0), ..Default::default() };
    // Room for the conforming mesh.
    (spec.placement.min_gap_mm, spec.placement.wall_gap_mm) = (0.05, 0.05);
    spec.grading = Grading { d_min_mm: 8.0, d_max_mm: 16.0, classes_mm: vec![8.0, 16.0], ..spec.grading };
    meso_core::pack(&spec, &Silent).unwrap()
}

#[test]
fn calculix_finds_moduli_between_the_hashin_shtrikman_bounds_that_agree() {
    let model = packed();
    let mut moduli = Vec::new();
    for method in [Method::Voxel { thin_itz: false, subsamples: 4 }, Method::FITTED, Method::CONFORMING] {
        let options = MeshOptions { itz: ItzForm::None, ..as_stiff(method) };
        let Ok(mesh) = mesh::build(&model, &options, &Tools { gmsh: &gmsh, ..Tools::default() }) else {
            eprintln!("{method:?} skipped: no `gmsh` here (Debian: gmsh)");
            continue;
        };
        let Some(modulus) = modulus(&mesh, AREA_MM2) else { return };
        let [low, high] = hashin_shtrikman(&PhaseVolumes::of_mesh(&mesh), &Materials::default());
        assert!(low < modulus && modulus < high, "{method:?}: {low} < {modulus} < {high}");
        moduli.push(modulus);
    }
    let [least, most] = [f64::min, f64::max].map(|pick| moduli.iter().copied().reduce(pick).unwrap());
    assert!(most / least < 1.03, "{moduli:?}");
}

/// Element sizes at which linear elements are alike: voxels of 2 mm that keep the volumes are 0.2 % stiffer than the upper
/// bound, and 3.8 % stiffer than the fitted lattice in a periodic box.
pub(crate) fn as_stiff(method: Method) -> MeshOptions {
    let element_size_mm = if matches!(method, Method::Voxel { .. }) { 1.5 } else { 2.0 };
    MeshOptions { method, element_size_mm, ..Default::default() }
}

#[test]
fn calculix_reads_the_geometry_through_include() {
    let options = MeshOptions { itz: ItzForm::None, element_size_mm: 5.0, ..Default::default() };
    let mesh = mesh::build(&packed(), &options, &Tools::default()).unwrap();
    let whole = deck(&mesh, &elastic());
    let geometry = deck(&mesh, &DeckOptions { geometry_only: true, ..elastic() });
    // A user's own deck: one line that includes the geometry, then the rest of the deck.
    let rest = &whole[whole.find("*MATERIAL").unwrap()..];
    let own = format!("*INCLUDE, INPUT=geometry.inp\n{rest}");
    let Some(included) = modulus_of(&own, &[("geometry.inp", &geometry)], AREA_MM2) else { return };
    assert_eq!(Some(included), modulus_of(&whole, &[], AREA_MM2));
}

/// Runs gmsh; where it cannot be run there is no output.
pub(crate) fn gmsh(surfaces: &Surfaces) -> Result<Vec<u8>, MeshError> {
    let folder = tempfile::tempdir().unwrap();
    surfaces.write(std::fs::File::create(folder.path().join("surfaces.msh")).unwrap()).unwrap();
    std::fs::write(folder.path().join("volumes.geo"), surfaces.script("surfaces.msh")).unwrap();
    let mut command = Command::new("gmsh");
    command.current_dir(folder.path()).arg("volumes.geo").args(Surfaces::GMSH_OPTIONS).args(["-o", "volumes.msh"]);
    let run = command.output().map_err(|error| MeshError::Gmsh(error.to_string()))?;
    assert!(run.status.success());
    Ok(std::fs::read(folder.path().join("volumes.msh")).unwrap())
}

/// Keywords of the explicit decks that CalculiX 2.20 cannot read; docs/measured/decks-measured.md lists them, too.
const UNKNOWN_TO_CALCULIX: [&str; 15] = [
    "*COHESIVESECTION",
    "*CONCRETECOMPRESSIONDAMAGE",
    "*CONCRETECOMPRESSIONHARDENING",
    "*CONCRETEDAMAGEDPLASTICITY",
    "*CONCRETETENSIONDAMAGE",
    "*CONCRETETENSIONSTIFFENING",
    "*DAMAGEEVOLUTION",
    "*DAMAGEINITIATION",
    "*ENERGYOUTPUT",
    "*FIXEDMASSSCALING",
    "*INCREMENTATIONOUTPUT",
    "*SECTIONCONTROLS",
    "COH3D6",
    "COH3D8",
    "R3D3",
];

#[test]
fn calculix_knows_all_of_the_explicit_decks_but_the_documented_keywords() {
    let model = packed();
    let (mut unknown, mut refused) = (BTreeSet::new(), BTreeSet::new());
    for (analysis, itz, method) in [
        (TestKind::Compression.into(), ItzForm::None, Method::VOXEL),
        (TestKind::Tension.into(), ItzForm::Cohesive, Method::VOXEL),
        (TestKind::Compression.into(), ItzForm::Cohesive, Method::FITTED),
    ] {
        let options = MeshOptions { method, itz, joined: Joined::Mortar, element_size_mm: 3.0, ..Default::default() };
        let mesh = mesh::build(&model, &options, &Tools::default()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let deck = std::fs::File::create(folder.path().join("job.inp")).unwrap();
        abaqus::write(&mesh, &loaded(&mesh, &DeckOptions { analysis, ..Default::default() }), deck).unwrap();
        let Ok(run) = Command::new("ccx").args(["-i", "job"]).current_dir(folder.path()).output() else {
            eprintln!("skipped: no `ccx` here (Debian: calculix-ccx)");
            return;
        };
        let log = String::from_utf8_lossy(&run.stdout).into_owned();
        let lines: Vec<&str> = log.lines().map(str::trim).collect();
        for (i, line) in lines.iter().enumerate() {
            if line.starts_with("*WARNING in calinput. Card image cannot be") && lines[i + 2].starts_with('*') {
                unknown.insert(lines[i + 2].split(',').next().unwrap().to_owned());
            } else if let Some(element) = line.strip_suffix("is an unknown element type") {
                unknown.insert(element.trim().to_owned());
            } else if let Some(card) = line.strip_prefix("*ERROR reading ") {
                refused.insert(card.split(['.', ':']).next().unwrap().to_owned());
            }
        }
    }
    assert_eq!(unknown.iter().map(String::as_str).collect::<Vec<_>>(), UNKNOWN_TO_CALCULIX);
    // Cards that it knows and wants otherwise; of *ELEMENT the unknown types.
    assert_eq!(Vec::from_iter(&refused), ["*CONTACT PAIR", "*DYNAMIC", "*ELASTIC", "*ELEMENT"]);
}
