//! Phases of one's own: shares as asked, the same bodies as without them, and labels, sets and values of their own everywhere.

use crate::write::deck_reader::Deck;
use meso_core::aggregate::Aggregate;
use meso_core::check::{Finding, check};
use meso_core::export::abaqus::{self, Analysis, DeckOptions};
use meso_core::formats::{Format, MeshFormat, SurfaceOptions};
use meso_core::materials::{Elastic, Materials};
use meso_core::mesh::{self, ItzForm, Mesh, MeshOptions, Method, Phase, PhaseVolumes, Tools};
use meso_core::statistics::{Statistics, StatisticsOptions};
use meso_core::voxel_image::{ImageOptions, VoxelImage, Voxels};
use meso_core::{Model, Silent, Spec, pack, page, saved};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::LazyLock;

const PLAIN: &str = "fraction = 0.4\nspecimen = { kind = 'cube', side_mm = 60 }\n";
const OWN: &str =
    "[[phases]]\nname = 'limestone'\nshare = 0.3\n[[phases]]\nname = 'brick'\nshare = 0.5\nsizes_mm = [5, 10]\n";
const LIMESTONE: Elastic = Elastic { youngs_modulus_mpa: 40_000.0, poisson_ratio: 0.25, density_t_per_mm3: 2.5e-9 };
const BRICK: Elastic = Elastic { youngs_modulus_mpa: 10_000.0, poisson_ratio: 0.15, density_t_per_mm3: 1.8e-9 };

fn packed(text: &str) -> Model {
    pack(&Spec::from_toml(text).unwrap(), &Silent).unwrap()
}

fn own() -> &'static Model {
    static MODEL: LazyLock<Model> = LazyLock::new(|| packed(&format!("{PLAIN}{OWN}")));
    &MODEL
}

fn materials() -> Materials {
    let own = [("limestone", LIMESTONE), ("brick", BRICK)].map(|(name, values)| (name.to_owned(), values.into()));
    Materials { own: BTreeMap::from(own), ..Materials::default() }
}

fn volume<'a>(bodies: impl Iterator<Item = &'a Aggregate>) -> f64 {
    bodies.map(|body| body.body.volume()).sum()
}

fn file(mesh: &Mesh, format: MeshFormat, deck: &DeckOptions) -> String {
    let (files, mut bytes) = (format.files(Path::new("m"), mesh, deck), Vec::new());
    files[0].write(mesh, deck, false, &mut bytes).unwrap();
    String::from_utf8_lossy(&bytes).into_owned()
}

fn meshed(model: &Model, method: Method, element_size_mm: f64, itz: ItzForm) -> Mesh {
    let options = MeshOptions { method, element_size_mm, itz, ..MeshOptions::default() };
    mesh::build(model, &options, &Tools::default()).unwrap()
}

#[test]
fn every_class_and_all_grains_have_the_shares_asked_for_within_one_grain() {
    for text in
        [format!("{PLAIN}{OWN}"), format!("{PLAIN}{OWN}[placement]\nstrategy = 'take-and-place'\nsurplus = 0.0")]
    {
        let model = packed(&text);
        // Classes of 5, 10, 15, 20 mm: limestone is in all, brick in the finest.
        for (class, shares) in [[0.3, 0.5], [0.3, 0.0], [0.3, 0.0]].into_iter().enumerate() {
            let grains = || model.aggregates.iter().filter(|grain| usize::from(grain.class) == class);
            let largest = grains().map(|grain| grain.body.volume()).fold(0.0, f64::max);
            for (own, share) in shares.into_iter().enumerate() {
                let volume_of = volume(grains().filter(|grain| grain.own == Some(own as u8)));
                let off = volume_of - share * volume(grains());
                assert!(off.abs() <= largest && (share > 0.0) == (volume_of > 0.0), "{class} {own} {off}");
            }
        }
        let whole = model.spec.specimen.volume();
        for (own, reported) in model.report.own_phases.iter().enumerate() {
            let bodies = || model.aggregates.iter().filter(|grain| grain.own == Some(own as u8));
            assert_eq!((reported.fraction, reported.aggregates), (volume(bodies()) / whole, bodies().count()));
            assert!((reported.fraction - reported.target_fraction).abs() < 2e-3, "{reported:?}");
        }
        assert_eq!(check(&model).findings, []);
    }
}

#[test]
fn phases_move_no_body_and_a_share_of_one_takes_all() {
    let plain = packed(PLAIN);
    let strip = |model: &Model| -> Vec<Aggregate> {
        model.aggregates.iter().map(|grain| Aggregate { own: None, ..grain.clone() }).collect()
    };
    assert_eq!(strip(own()), plain.aggregates);
    let all = packed(&format!("{PLAIN}[[phases]]\nname = 'basalt'\nshare = 1"));
    assert!(all.aggregates.iter().all(|grain| grain.own == Some(0)) && strip(&all) == plain.aggregates);
}

#[test]
fn a_model_with_phases_is_read_back_equal_and_a_swapped_or_unknown_phase_is_found() {
    let mut bytes = Vec::new();
    saved::write(own(), &mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    const GRAIN: &str = ",\"phase\":\"limestone\",\"vertices\"";
    assert!(text.contains(GRAIN));
    let read = |text: &str| saved::read(text.as_bytes());
    assert_eq!(read(&text).unwrap().aggregates, own().aggregates);
    let unsealed = text.split(",\n\"crc32\"").next().unwrap().to_owned() + "}";
    let swapped = read(&unsealed.replacen(GRAIN, &GRAIN.replace("limestone", "brick"), 1)).unwrap();
    let findings = check(&swapped).findings;
    assert!(findings.iter().any(|finding| matches!(finding, Finding::NotTaken { .. })), "{findings:?}");
    let unknown = read(&unsealed.replacen(GRAIN, &GRAIN.replace("limestone", "marble"), 1)).unwrap_err();
    assert!(unknown.to_string().ends_with("its phase is \"marble\"; the spec has none of this name in phases"));
}

#[test]
fn wrong_phases_are_refused_by_name_with_the_way_out() {
    for (entries, said) in [
        ("name = 'a'\nshare = 0", "phases.share of a is 0; the accepted range is above 0 and at most 1"),
        ("name = 'a'\nshare = 1.5", "phases.share of a is 1.5; the accepted range is above 0 and at most 1"),
        ("name = 'a'\nshare = 30", "for 30 % write 0.3"),
        ("name = 'a'\nshare = nan", "phases.share"),
        ("name = 'Lime stone'\nshare = 0.3", "phases.name is \"Lime stone\"; it takes lower-case letters"),
        ("name = 'mortar'\nshare = 0.3", "phases.name is \"mortar\"; this name has a meaning of its own"),
        ("name = 'mortar_old'\nshare = 0.3", "phases.name is \"mortar_old\"; it begins like mortar"),
        ("name = 'a'\nshare = 0.3\n[[phases]]\nname = 'a'\nshare = 0.3", "another entry has this name"),
        ("name = 'a'\nshare = 0.7\n[[phases]]\nname = 'b'\nshare = 0.4", "of all phases add up to 1.1 in the class"),
        (
            "name = 'a'\nshare = 0.3\nsizes_mm = [5, 12]",
            "12 is no limit of a class; grading.classes_mm has 5, 10, 15, 20",
        ),
        ("name = 'a'\nshare = 0.3\nsizes_mm = [10, 5]", "the smaller size comes first"),
        ("name = 'a'\nshares = 0.3", "phases.shares is not a known key; did you mean share?"),
        ("name = 'a'", "phases.share is missing"),
    ] {
        let error = Spec::from_toml(&format!("{PLAIN}[[phases]]\n{entries}")).unwrap_err().to_string();
        assert!(error.contains(said), "{entries}: {error}");
    }
}

#[test]
fn no_phase_has_the_name_of_a_key_of_materials() {
    let all = Materials { aggregate_strength: Some(Default::default()), ..Materials::default() };
    let keys = serde_json::to_value(all).unwrap();
    let keys: Vec<&str> = keys.as_object().unwrap().keys().map(String::as_str).chain(["scatter"]).collect();
    assert!(keys.len() > 10, "{keys:?}");
    for key in keys {
        let error =
            Spec::from_toml(&format!("{PLAIN}[[phases]]\nname = '{key}'\nshare = 0.3")).unwrap_err().to_string();
        assert!(error.contains(&format!("phases.name is \"{key}\"")), "{error}");
    }
}

#[test]
fn cells_of_grains_have_the_phases_of_their_grains_in_every_mesh() {
    let plain = packed(PLAIN);
    for (method, itz) in [
        (Method::VOXEL, ItzForm::None),
        (Method::FITTED, ItzForm::Solid),
        (Method::FITTED, ItzForm::Cohesive),
        (Method::FITTED, ItzForm::Smeared),
    ] {
        let (mesh, same) = (meshed(own(), method, 3.0, itz), meshed(&plain, method, 3.0, itz));
        assert_eq!((&mesh.points, &mesh.cells, &mesh.cohesive), (&same.points, &same.cells, &same.cohesive));
        for ((phase, owner), without) in mesh.phase.iter().zip(&mesh.owner).zip(&same.phase) {
            let expected = match *without {
                Phase::Aggregate => own().aggregates[*owner as usize].phase(),
                phase => phase,
            };
            assert_eq!(*phase, expected);
        }
        let (volumes, all) = (PhaseVolumes::of_mesh(&mesh), PhaseVolumes::of_mesh(&same));
        let sum: f64 = [Phase::Aggregate, Phase::Own(0), Phase::Own(1)].map(|phase| volumes.of(phase)).iter().sum();
        assert!((sum / all.aggregate - 1.0).abs() < 1e-12 && volumes.of(Phase::Own(1)) > 0.0);
        let exact = PhaseVolumes::exact_for(&mesh, &own().aggregates, &own().spec.specimen).unwrap();
        let shell = |grain: &Aggregate| if itz == ItzForm::Solid { grain.itz_thickness_mm } else { 0.0 };
        let limestone = own().aggregates.iter().filter(|grain| grain.own == Some(0));
        let cores: f64 = limestone.map(|grain| grain.core_volume(shell(grain)).unwrap()).sum();
        assert!((exact.of(Phase::Own(0)) / cores - 1.0).abs() < 1e-12, "{exact:?} {cores}");
    }
}

#[test]
fn decks_have_a_set_a_section_and_a_material_for_each_phase_and_refuse_one_without_values() {
    let mesh = meshed(own(), Method::VOXEL, 3.0, ItzForm::None);
    let with = |materials: Materials, analysis| DeckOptions { materials, analysis, ..DeckOptions::default() };
    let text = |options: &DeckOptions| {
        let mut text = Vec::new();
        abaqus::write(&mesh, options, &mut text).map(|()| String::from_utf8(text).unwrap())
    };
    let deck = text(&with(materials(), Analysis::Elastic)).unwrap();
    let read = Deck::read(&deck);
    for (set, phase) in [("LIMESTONE", Phase::Own(0)), ("BRICK", Phase::Own(1)), ("AGGREGATE", Phase::Aggregate)] {
        let cells = (1..).zip(&mesh.phase).filter(|(_, own)| **own == phase).map(|(number, _)| number);
        assert!(cells.eq(read.element_sets[set].iter().copied()), "{set}");
        assert!(deck.contains(&format!("*SOLID SECTION, ELSET={set}, MATERIAL={set}\n")), "{set}");
    }
    assert!(deck.contains("*MATERIAL, NAME=BRICK\n*DENSITY\n1.8e-9,\n*ELASTIC\n10000.0, 0.15\n"), "{deck}");
    let refused = text(&with(Materials::default(), Analysis::Elastic)).unwrap_err().to_string();
    assert!(refused.starts_with("materials.limestone is missing; the packing has this phase: add"), "{refused}");
    let geometry = DeckOptions { geometry_only: true, ..DeckOptions::default() };
    assert!(text(&geometry).unwrap().contains("ELSET=LIMESTONE"));

    let mut strong = materials();
    strong.own.get_mut("brick").unwrap().strength_ratio = Some(0.25);
    let damaged = DeckOptions { with_damage: true, ..with(strong.clone(), Analysis::None) };
    let of_brick = text(&damaged).unwrap();
    let of_brick = of_brick.split("*MATERIAL, NAME=BRICK").nth(1).unwrap().split("*MATERIAL").next().unwrap();
    // A quarter of the 3.4 MPa of the mortar.
    assert!(of_brick.contains("*CONCRETE TENSION STIFFENING, TYPE=DISPLACEMENT\n8.500000e-1, 0"), "{of_brick}");
    let cards = file(&mesh, MeshFormat::K, &damaged);
    assert!(cards.contains("*MAT_CDPM\n       102    1.8e-9   10000.0      0.15"), "{cards}");
    strong.own.get_mut("brick").unwrap().strength_ratio = Some(f64::NAN);
    let refused = text(&with(strong, Analysis::None)).unwrap_err().to_string();
    assert!(refused.starts_with("deck.materials.brick.strength_ratio is NaN; it must be 0.01 to 100"), "{refused}");
    let cards = file(&mesh, MeshFormat::K, &with(materials(), Analysis::None));
    assert!(cards.contains("*PART\nBRICK\n"), "{cards}");
    assert!(cards.contains("*MAT_ELASTIC\n       102    1.8e-9   10000.0      0.15"), "{cards}");
}

#[test]
fn values_of_other_phases_and_slips_of_keys_are_refused() {
    let more = Materials { own: BTreeMap::from([("marble".to_owned(), BRICK.into())]), ..Materials::default() };
    let said = more.suits(&own().spec.phases()).unwrap_err().to_string();
    assert!(said.starts_with("materials.limestone is missing;"), "{said}");
    let said = more.suits(&packed(PLAIN).spec.phases()).unwrap_err().to_string();
    assert!(said.starts_with("materials.marble is given; is no phase of the packing, whose own are: none"), "{said}");
    let read = meso_core::spec::options_from_toml::<Materials>;
    let text = "[limestone]\nyoungs_modulus_mpa = 40000.0\npoisson_ratio = 0.25\ndensity_t_per_mm3 = 2.5e-9\n\
                [brick]\nyoungs_modulus_mpa = 10000\npoisson_ratio = 0.15\ndensity_t_per_mm3 = 1.8e-9\n";
    assert_eq!(read(text).unwrap(), materials());
    assert_eq!(read(&toml::to_string(&materials()).unwrap()).unwrap(), materials());
    for (text, said) in [
        ("[limestone]\nyoungs_modulus_mpa = 1e4", "limestone.poisson_ratio is missing"),
        (
            "[limestone]\nyoungs_modulus_mpa = 1e4\npoisson_ratio = 0.2\ndensity_t_per_mm3 = 2e-9\nstrength = 1",
            "limestone.strength is not a known key; did you mean strength_ratio?",
        ),
        ("limestone = 3", "limestone is 3; it must be a table"),
        ("mortar_strenght = { tensile_mpa = 3 }", "mortar_strenght is not a known key; did you mean mortar_strength?"),
        ("[aggregates]\nyoungs_modulus_mpa = 1e4", "aggregates is not a known key; did you mean aggregate?"),
    ] {
        let error = read(text).unwrap_err().to_string();
        assert!(error.contains(said), "{text}: {error}");
    }
}

#[test]
fn images_and_files_of_bodies_and_meshes_have_numbers_or_names_of_the_phases() {
    let plain = packed(PLAIN);
    let labels = |model: &Model| {
        let image = VoxelImage::new(model, &ImageOptions::default()).unwrap();
        let Voxels::Label(labels) = image.layers(0..image.counts()[2]) else { panic!("labels") };
        labels
    };
    let (with, without) = (labels(own()), labels(&plain));
    assert!([2, 5, 6].iter().all(|label| with.contains(label)) && !without.contains(&5));
    let merged: Vec<u8> = with.into_iter().map(|label| if label > 4 { 2 } else { label }).collect();
    assert!(merged == without);

    let written = |format: Format| {
        let mut bytes = Vec::new();
        format.write(own(), SurfaceOptions::default(), &mut bytes).unwrap();
        String::from_utf8_lossy(&bytes).into_owned()
    };
    let first = own().aggregates.iter().find(|grain| grain.own == Some(1)).unwrap();
    assert!(written(Format::Csv).lines().nth(first.id as usize + 1).unwrap().ends_with(",brick"));
    assert!(written(Format::Obj).contains(&format!("o brick_{}_class_0\ng brick\n", first.id)));

    let mesh = meshed(own(), Method::VOXEL, 3.0, ItzForm::None);
    let file = |format| file(&mesh, format, &DeckOptions::default());
    assert!(file(MeshFormat::Msh).contains("3 6 \"LIMESTONE\"\n3 7 \"BRICK\"\n"));
    let cdb = file(MeshFormat::Cdb);
    assert!(cdb.contains("CMBLOCK,LIMESTONE,ELEM") && cdb.contains("/COM,no values for material 101 of LIMESTONE"));

    let mut html = Vec::new();
    let few = StatisticsOptions { lines: 50, points: 500, ..StatisticsOptions::quick() };
    page::write(own(), &Statistics::of(own(), &few).unwrap(), Some(&mesh), &mut html).unwrap();
    let html = String::from_utf8(html).unwrap();
    assert!(html.contains("of these limestone") && html.contains(".p5{fill:") && html.contains("class=\"p6\""));
}
