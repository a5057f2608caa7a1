//! Decks against Abaqus' keyword rules: two-element decks checked by hand, and every kind of deck by a reader of its own.

use crate::mesh::{aggregate, block, deck, turned_blocks};
use crate::mesh_specimens::rooms;
use meso_core::export::abaqus::{Analysis, DeckOptions};
use meso_core::materials::Strength;
use meso_core::math::Vec3;
use meso_core::mesh::{self, CellKind, Fit, ItzForm, Mesh, MeshOptions, Method, NO_AGGREGATE, Notes, Order, Phase};
use meso_core::packing::{Periodic, Specimen};
use std::collections::{BTreeMap, BTreeSet};

/// Two tetrahedra over one face, the first of them aggregate; with a cohesive element between them or without.
fn two_tetrahedra(cohesive: bool) -> Mesh {
    let mut points =
        [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0], [2.0, 2.0, 2.0]].map(Vec3::from).to_vec();
    let mut cells = vec![0, 1, 2, 3, 1, 2, 3, 4];
    if cohesive {
        points.extend_from_within(1..4);
        cells[1..4].copy_from_slice(&[5, 6, 7]);
    }
    Mesh {
        points,
        kind: CellKind::Tetrahedron,
        cells,
        phase: vec![Phase::Aggregate, Phase::Mortar],
        aggregate: vec![0, NO_AGGREGATE],
        cohesive: if cohesive { vec![5, 6, 7, 1, 2, 3] } else { Vec::new() },
        cohesive_aggregate: if cohesive { vec![0] } else { Vec::new() },
        periodic: [false; 3],
        notes: Notes::default(),
    }
}

/// Two voxels of 1 mm, one over the other, the upper one aggregate.
fn two_voxels(periodic: bool) -> Mesh {
    let specimen = Specimen::Box { size_mm: [1.0, 1.0, 2.0], periodic: Periodic([periodic; 3]) };
    let options = MeshOptions { element_size_mm: 1.0, itz: ItzForm::None, ..Default::default() };
    mesh::build_parts(&[aggregate(0, block([0.0, 0.0, 1.0], [1.0, 1.0, 2.0]), 0.1)], &specimen, &options).unwrap()
}

#[test]
fn an_elastic_deck_of_two_linear_tetrahedra_reads_as_by_hand() {
    // S1 1-2-3 on ZMIN, S2 1-4-2 on YMIN, S4 3-4-1 on XMIN of element 1; node 1 pinned, node 2 kept from turning;
    // -0.001 of the height of 2 mm on ZMAX.
    let text = deck(&two_tetrahedra(false), &DeckOptions { analysis: Analysis::Elastic, ..Default::default() });
    assert_eq!(text, include_str!("snapshots/two_tetrahedra_elastic.inp"));
}

#[test]
fn a_tension_deck_of_a_cohesive_triangle_reads_as_by_hand() {
    // COH3D6: the aggregate's face 6-7-8 is the bottom, its normal (1, 1, 1) out of the aggregate; 2-3-4 lie over it.
    let text = deck(&two_tetrahedra(true), &DeckOptions { analysis: Analysis::Tension, ..Default::default() });
    assert_eq!(text, include_str!("snapshots/two_tetrahedra_cohesive_tension.inp"));
}

#[test]
fn a_geometry_of_two_reduced_voxels_reads_as_by_hand() {
    let options = DeckOptions { geometry_only: true, reduced_integration: true, ..Default::default() };
    assert_eq!(deck(&two_voxels(false), &options), include_str!("snapshots/two_reduced_voxels_geometry.inp"));
}

#[test]
fn a_spike_has_no_face_for_a_plate_to_press_on() {
    // As a specimen with an oblique tip has it: its deck would have named a surface that is not there.
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, 0.3, 9.0]].map(Vec3::from).to_vec();
    let (phase, aggregate) = (vec![Phase::Mortar], vec![NO_AGGREGATE]);
    let spike = Mesh { points, cells: vec![0, 1, 2, 3], phase, aggregate, ..two_tetrahedra(false) };
    let of = |analysis| DeckOptions { analysis, ..Default::default() }.validate(&spike);
    let error = of(Analysis::Compression).unwrap_err().to_string();
    assert!(error.starts_with("deck.analysis is compression; a plate presses on S_ZMAX, and no face"), "{error}");
    assert_eq!(of(Analysis::Tension), Ok(()));
}

#[test]
fn headings_are_ascii_and_hold_no_keyword() {
    let of = |line: &str| DeckOptions { heading: vec![line.into()], ..Default::default() }.validate(&two_voxels(false));
    assert_eq!(of("50 % of gravel, seed 3"), Ok(()));
    for line in ["*STEP", "Gr\u{f6}\u{df}e", "one\ntwo"] {
        assert!(of(line).unwrap_err().to_string().contains("a line must be ASCII"), "{line}");
    }
}

#[test]
fn a_periodic_deck_of_two_voxels_reads_as_by_hand() {
    // Ten of the twelve nodes lie on upper faces, each tied to 1 or 5, the nodes on none of them: three equations each.
    let options = DeckOptions { periodic_equations: true, analysis: Analysis::Elastic, ..Default::default() };
    assert_eq!(deck(&two_voxels(true), &options), include_str!("snapshots/two_voxels_periodic_elastic.inp"));
}

/// A keyword with its parameters, and its data lines.
struct Card<'a> {
    keyword: &'a str,
    parameters: BTreeMap<&'a str, &'a str>,
    data: Vec<Vec<&'a str>>,
}

/// The cards of a deck; every line is held against the rules of length.
fn cards(text: &str) -> Vec<Card<'_>> {
    let mut cards: Vec<Card> = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with("**")) {
        assert!(line.is_ascii() && line.len() <= if line.starts_with('*') { 79 } else { 256 }, "{line}");
        let entries: Vec<&str> = line.split(',').map(str::trim).collect();
        if let Some(keyword) = entries[0].strip_prefix('*') {
            let parameter =
                |entry: &&'_ str| -> (usize, usize) { (entry.find('=').unwrap_or(entry.len()), entry.len()) };
            let split = |entry| {
                let (at, length) = parameter(entry);
                (&entry[..at], &entry[length.min(at + 1)..])
            };
            cards.push(Card { keyword, parameters: entries[1..].iter().map(split).collect(), data: Vec::new() });
            continue;
        }
        let card = cards.last_mut().expect("a deck begins with a keyword");
        assert!(entries.len() <= 16, "{line}");
        let too_long = |entry: &&&str| entry.parse::<f64>().is_ok() && entry.len() > 20;
        assert!(card.keyword == "HEADING" || entries.iter().find(too_long).is_none(), "{line}");
        card.data.push(entries);
    }
    cards
}

const NODES: [(&str, usize); 8] =
    [("C3D4", 4), ("C3D10", 10), ("C3D10M", 10), ("C3D8", 8), ("C3D8R", 8), ("COH3D6", 6), ("COH3D8", 8), ("R3D4", 4)];

/// Keywords that need no data line.
const WITHOUT_DATA: [&str; 14] = [
    "MATERIAL",
    "SOLID SECTION",
    "RIGID BODY",
    "SURFACE INTERACTION",
    "STEP",
    "STATIC",
    "FIXED MASS SCALING",
    "OUTPUT",
    "END STEP",
    "BOUNDARY",
    "HEADING",
    "EQUATION",
    "NODE",
    "ELEMENT",
];

/// Holds the deck against what its cards say of each other: numbers once, nodes and sets that are there.
fn consistent(text: &str) {
    let cards = cards(text);
    let of = |keyword: &'static str| cards.iter().filter(move |card| card.keyword == keyword);
    let number = |entry: &str| entry.parse::<u64>().unwrap();
    let nodes: Vec<u64> = of("NODE").flat_map(|card| card.data.iter().map(|row| number(row[0]))).collect();
    let known: BTreeSet<u64> = nodes.iter().copied().collect();
    assert_eq!(nodes.len(), known.len(), "every node has its own number");
    let (mut elements, mut sets) = (BTreeSet::new(), BTreeSet::new());
    for card in of("ELEMENT") {
        let (_, count) = NODES.iter().find(|(kind, _)| *kind == card.parameters["TYPE"]).unwrap();
        for row in &card.data {
            assert!(elements.insert(number(row[0])), "{}", row[0]);
            let corners: BTreeSet<u64> = row[1..].iter().map(|entry| number(entry)).collect();
            assert!(corners.len() == *count && row.len() == count + 1 && corners.is_subset(&known), "{row:?}");
        }
        assert!(!card.data.is_empty() && sets.insert(card.parameters["ELSET"]));
    }
    for card in of("NSET") {
        assert!(!card.data.is_empty(), "an empty set is an error");
        assert!(card.data.iter().flatten().all(|entry| known.contains(&number(entry))));
        sets.insert(card.parameters["NSET"]);
    }
    sets.extend(of("NODE").filter_map(|card| card.parameters.get("NSET")));
    let materials: BTreeSet<&str> = of("MATERIAL").map(|card| card.parameters["NAME"]).collect();
    let surfaces: BTreeSet<&str> = of("SURFACE").map(|card| card.parameters["NAME"]).collect();
    let sections = || of("SOLID SECTION").chain(of("COHESIVE SECTION"));
    assert!(sections().all(|card| materials.contains(card.parameters["MATERIAL"])));
    for card in &cards {
        let needs_data = !WITHOUT_DATA.contains(&card.keyword);
        assert!(!needs_data || !card.data.is_empty(), "{} without data", card.keyword);
        for key in ["ELSET", "NSET", "PIN NSET"] {
            assert!(card.parameters.get(key).is_none_or(|set| sets.contains(set)), "{} {key}", card.keyword);
        }
        if card.keyword == "CONTACT PAIR" {
            assert!(card.data.iter().flatten().all(|surface| surfaces.contains(surface)));
        }
    }
    let with_section: BTreeSet<&str> = sections().map(|card| card.parameters["ELSET"]).collect();
    let rigid = |set: &str| set.starts_with("PLATE_");
    let geometry_only = materials.is_empty();
    let all = of("ELEMENT").map(|card| card.parameters["ELSET"]);
    assert!(geometry_only || all.filter(|set| !rigid(set)).all(|set| with_section.contains(set)));
}

#[test]
fn every_kind_of_deck_keeps_the_keyword_rules_and_names_only_what_it_has() {
    let (grains, specimen) = turned_blocks();
    let mut seen = BTreeSet::new();
    let quadratic = Method::Lattice { fit: Fit::Fitted, order: Order::Quadratic };
    for method in [Method::VOXEL, Method::FITTED, quadratic] {
        for itz in [ItzForm::None, ItzForm::Solid, ItzForm::Cohesive] {
            if (method, itz) == (quadratic, ItzForm::Cohesive) {
                continue;
            }
            let options = MeshOptions { method, itz, element_size_mm: 4.0 };
            let mesh = mesh::build_parts(&grains, &specimen, &options).unwrap();
            for analysis in [Analysis::None, Analysis::Elastic, Analysis::Compression, Analysis::Tension] {
                for reduced_integration in [false, true] {
                    let options = DeckOptions { analysis, reduced_integration, ..Default::default() };
                    let text = deck(&mesh, &options);
                    consistent(&text);
                    seen.extend(
                        cards(&text).iter().filter_map(|card| card.parameters.get("TYPE").map(|t| t.to_string())),
                    );
                    consistent(&deck(&mesh, &DeckOptions { geometry_only: true, ..options }));
                }
            }
        }
    }
    assert!(NODES.iter().all(|(kind, _)| seen.contains(*kind)), "{seen:?}");
    consistent(&deck(
        &two_voxels(true),
        &DeckOptions { periodic_equations: true, analysis: Analysis::Elastic, ..Default::default() },
    ));
}

#[test]
fn decks_of_specimens_of_every_kind_have_nodes_and_faces_on_all_six_sides() {
    for specimen in rooms() {
        for method in [Method::VOXEL, Method::FITTED] {
            let options = MeshOptions { method, element_size_mm: 4.0, ..Default::default() };
            let mesh = mesh::build_parts(&[], &specimen, &options).unwrap();
            let text = deck(&mesh, &DeckOptions { analysis: Analysis::Compression, ..Default::default() });
            consistent(&text);
            for side in ["XMIN", "XMAX", "YMIN", "YMAX", "ZMIN", "ZMAX"] {
                let there = |line: String| text.lines().any(|l| l == line);
                let set = there(format!("*NSET, NSET={side}"));
                let surface = there(format!("*SURFACE, TYPE=ELEMENT, NAME=S_{side}"));
                assert!(set && surface, "{} {method:?} {side}: {set} {surface}", specimen.kind());
            }
        }
    }
}

/// Plastic strain of every row of a compression curve: the inelastic one less d / (1 - d) s / E.
fn plastic_strains(text: &str, modulus: f64) -> Vec<f64> {
    let cards = cards(text);
    let rows = |keyword: &str| -> Vec<[f64; 2]> {
        let card = cards.iter().find(|card| card.keyword == keyword).unwrap();
        card.data.iter().map(|row| [0, 1].map(|k| row[k].parse().unwrap())).collect()
    };
    let (hardening, damage) = (rows("CONCRETE COMPRESSION HARDENING"), rows("CONCRETE COMPRESSION DAMAGE"));
    let plastic = |([s, strain], [d, _]): (&[f64; 2], &[f64; 2])| strain - d / (1.0 - d) * s / modulus;
    hardening.iter().zip(&damage).map(plastic).collect()
}

/// Abaqus ends with an error where plastic strain falls: a crushing energy of 0.05 N/mm in elements of 1 mm was written all
/// the same, and a peak strain below the elastic one was raised in silence.
#[test]
fn curves_that_abaqus_refuses_are_named() {
    let mesh = two_voxels(false);
    let with = |change: fn(&mut Strength)| {
        let mut options = DeckOptions { analysis: Analysis::Compression, ..Default::default() };
        change(&mut options.materials.mortar_strength);
        options
    };
    let error = |options: DeckOptions| options.validate(&mesh).unwrap_err().to_string();
    // Strength^2 times width over modulus is 40^2 / 26000 = 0.0615 N/mm.
    let crushing = error(with(|strength| strength.crushing_energy_n_per_mm = 0.06));
    assert!(crushing.contains("crushing_energy_n_per_mm is 0.06; MORTAR needs 6.154e-2 or more"), "{crushing}");
    let peak = error(with(|strength| strength.peak_strain = 0.0016));
    assert!(peak.contains("peak_strain is 0.0016; MORTAR needs 1.615e-3 or more"), "{peak}");
    let fracture = error(with(|strength| strength.fracture_energy_n_per_mm = 2e-4));
    assert!(fracture.contains("fracture_energy_n_per_mm is 0.0002; MORTAR needs 2.769e-4 or more"), "{fracture}");
    let just = with(|strength| strength.crushing_energy_n_per_mm = 0.062);
    let plastic = plastic_strains(&deck(&mesh, &just), just.materials.mortar.youngs_modulus_mpa);
    assert!(plastic.windows(2).all(|w| w[0] <= w[1]), "{plastic:?}");
    let elastic = DeckOptions { analysis: Analysis::Elastic, ..with(|strength| strength.peak_strain = 0.0016) };
    assert!(elastic.validate(&mesh).is_ok(), "it has no curves");
}

#[test]
#[should_panic(expected = "an empty set is an error")]
fn the_reader_refuses_an_empty_set() {
    consistent("*NODE, NSET=ALLNODES\n1, 0.0, 0.0, 0.0\n*NSET, NSET=XMAX\n");
}
