//! LS-DYNA decks and ANSYS archives: columns, materials, templates. tests/python/test_foreign_readers.py reads them back.

use crate::mesh::voxel::loaded;
use crate::pack::models::two_boxes;
use meso_core::export::abaqus::{Analysis, DeckOptions};
use meso_core::export::lsdyna::LsdynaLaw;
use meso_core::formats::MeshFormat;
use meso_core::materials::{self, LawName, Materials};
use meso_core::mesh::{self, Mesh, MeshTable, Purpose, Tools};
use meso_core::trial::TestKind;
use serde_json::json;
use std::path::Path;

fn meshed(options: serde_json::Value) -> Mesh {
    let model = two_boxes();
    let table: MeshTable = meso_core::spec::options_from_value(&options).unwrap();
    let options = table.resolve(Purpose::Mesh, &model.spec.itz).unwrap();
    mesh::build(&model, &options, &Tools::default()).unwrap()
}

fn text(mesh: &Mesh, deck: &DeckOptions, format: MeshFormat) -> std::io::Result<String> {
    let mut bytes = Vec::new();
    let path = format!("deck.{}", format.extension());
    let files = format.files(Path::new(&path), mesh, deck);
    files.last().unwrap().write(mesh, &loaded(mesh, deck), false, &mut bytes)?;
    Ok(String::from_utf8(bytes).unwrap())
}

/// Fields of ten columns on the cards behind a keyword.
fn cards(text: &str, keyword: &str, count: usize) -> Vec<Vec<f64>> {
    let mut lines = text.lines().skip_while(|line| *line != keyword).skip(1);
    let field = |at: usize, line: &str| {
        line.get(10 * at..line.len().min(10 * at + 10)).unwrap_or("").trim().parse().unwrap_or(0.0)
    };
    (0..count).map(|_| lines.next().map(|line| (0..8).map(|at| field(at, line)).collect()).unwrap()).collect()
}

fn deck(analysis: Analysis, lsdyna_law: LsdynaLaw) -> DeckOptions {
    DeckOptions { analysis, lsdyna_law, allow_joined: true, ..DeckOptions::default() }
}

fn voxels() -> Mesh {
    meshed(json!({ "method": "voxel", "element_size_mm": 2.0, "itz": "none" }))
}

#[test]
fn a_273_dissipates_the_energies_of_the_mortar_in_a_band_of_the_mesh() {
    let mesh = voxels();
    let text = text(&mesh, &deck(TestKind::Compression.into(), LsdynaLaw::Cdpm), MeshFormat::K).unwrap();
    let cards = cards(&text, "*MAT_CDPM", 3);
    let given = Materials::default().mortar_strength.of(LawName::Cdpm2);
    let [ft, fc, ductility] = [cards[0][6], cards[0][7], cards[1][5]];
    assert_eq!((cards[0][0], ft, fc, cards[2][0]), (3.0, given.tensile_mpa, given.compressive_mpa, 1.0));
    // The area of the bilinear crack law, of a crack spread over the edge of a cube of 2 mm, is the energy of our band.
    let band = materials::width_mm(&mesh, 8.0);
    let area = 0.5 * (ft * cards[2][3] + cards[2][4] * cards[2][2]);
    assert!((area / 2.0 * band / given.fracture_energy_n_per_mm - 1.0).abs() < 5e-3, "{area}");
    // Crushing beyond the peak: f_c exp(-e f_t / (f_c A_s e_fc)) over the inelastic strain e.
    let crushed = band * fc * fc * ductility * cards[2][7] / ft;
    assert!((crushed / given.crushing_energy_n_per_mm - 1.0).abs() < 5e-3, "{crushed}");
}

#[test]
fn every_template_has_the_law_and_the_loading_that_it_is_named_after() {
    let mesh = voxels();
    let all = "*CONTROL_TERMINATION *CONTROL_TIMESTEP *CONTROL_ENERGY *DATABASE_GLSTAT *DATABASE_BINARY_D3PLOT";
    for (analysis, law, words) in [
        (
            TestKind::Compression.into(),
            LsdynaLaw::Rel3,
            "*MAT_CONCRETE_DAMAGE_REL3 *BOUNDARY_PRESCRIBED_MOTION_RIGID *MAT_RIGID",
        ),
        (
            TestKind::Tension.into(),
            LsdynaLaw::Cscm,
            "*MAT_CSCM_CONCRETE *BOUNDARY_SPC_SET *BOUNDARY_PRESCRIBED_MOTION_SET",
        ),
        (
            Analysis::Striker,
            LsdynaLaw::Cdpm,
            "*MAT_CDPM *INITIAL_VELOCITY_RIGID_BODY *CONTACT_AUTOMATIC_NODES_TO_SURFACE_ID",
        ),
    ] {
        let text = text(&mesh, &deck(analysis.clone(), law), MeshFormat::K).unwrap();
        let missing: Vec<&str> =
            words.split(' ').chain(all.split(' ')).filter(|word| !text.lines().any(|line| line == *word)).collect();
        assert!(
            missing.is_empty() && text.starts_with("*KEYWORD\n") && text.ends_with("*END\n"),
            "{analysis:?}: {missing:?}"
        );
        let long = text.lines().find(|line| line.len() > 80 && !line.starts_with('$') || !line.is_ascii());
        assert_eq!(long, None, "{analysis:?}");
    }
    let geometry = DeckOptions { geometry_only: true, ..DeckOptions::default() };
    assert!(!text(&mesh, &geometry, MeshFormat::K).unwrap().contains("*MAT_"));
}

/// d3plot had no damage, bricks of one point no hourglass stiffness, and curves numbers of rounding as 0.04423679999999999.
#[test]
fn frames_have_damage_reduced_bricks_a_stiffness_and_curves_plain_numbers() {
    let mesh = voxels();
    let of = |reduced_integration: bool, analysis: Analysis| {
        let options = DeckOptions { reduced_integration, ..deck(analysis, LsdynaLaw::Cdpm) };
        text(&mesh, &options, MeshFormat::K).unwrap()
    };
    let text = of(true, TestKind::Compression.into());
    assert_eq!(cards(&text, "*DATABASE_EXTENT_BINARY", 1)[0][0], 20.0);
    assert_eq!(cards(&text, "*CONTROL_HOURGLASS", 1)[0][..2], [4.0, 0.03]);
    let curve: Vec<&str> = text.split("*DEFINE_CURVE").nth(1).unwrap().lines().skip(2).collect();
    let rows = curve.iter().take_while(|line| !line.starts_with(['*', '$']));
    let long = rows.clone().flat_map(|line| line.split_whitespace()).find(|number| number.len() > 14);
    assert!(rows.count() > 50 && long.is_none(), "{long:?}");
    assert!(!of(false, TestKind::Compression.into()).contains("HOURGLASS"));
    assert!(!of(true, Analysis::None).contains("EXTENT_BINARY"));
    // Without an analysis bricks of one point had none.
    assert!(of(true, Analysis::None).contains("*CONTROL_HOURGLASS"));
}

#[test]
fn options_that_a_format_cannot_have_are_refused() {
    let mesh = voxels();
    let mut strong = deck(TestKind::Compression.into(), LsdynaLaw::Cscm);
    strong.materials.mortar_strength.compressive_mpa = Some(80.0);
    strong.materials.mortar_strength.peak_strain = 0.006;
    for (format, deck, part) in [
        (MeshFormat::K, deck(Analysis::Elastic, LsdynaLaw::Cdpm), "a .k takes none, striker or a test"),
        (MeshFormat::K, strong, "generates parameters for 20 to 58 MPa, and MORTAR has 80 MPa"),
        (MeshFormat::Inp, deck(Analysis::Striker, LsdynaLaw::Cdpm), "only a .k takes it"),
        (MeshFormat::Inp, deck(Analysis::None, LsdynaLaw::Rel3), "only a .k takes it"),
    ] {
        let refused = format.check(&deck).unwrap_err().to_string();
        assert!(refused.contains(part), "{refused}");
        let written = text(&mesh, &deck, format).unwrap_err().to_string();
        assert!(written.contains(part), "{written}");
    }
}

#[test]
fn an_archive_counts_its_nodes_elements_and_components() {
    let mesh = meshed(json!({ "method": "voxel", "element_size_mm": 2.0, "itz": "cohesive", "joined": "mortar" }));
    let text = text(&mesh, &DeckOptions::default(), MeshFormat::Cdb).unwrap();
    let elements = mesh.cell_count() + mesh.cohesive().len();
    let nodes = mesh.points.len();
    assert!(text.contains(&format!("NBLOCK,6,SOLID,{nodes:>10},{nodes:>10}\n")));
    assert!(text.contains(&format!("EBLOCK,19,SOLID,{elements:>10},{elements:>10}\n")));
    assert!(["ET,2,205", "CMBLOCK,XMIN    ,NODE", "CMBLOCK,ITZ     ,ELEM"].iter().all(|part| text.contains(part)));
}
