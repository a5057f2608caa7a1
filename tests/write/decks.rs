//! Decks against Abaqus' keyword rules: two-element decks checked by hand, and every kind of deck by a reader of its own.

use crate::mesh::specimens::every_kind;
use crate::mesh::voxel::{aggregate, block, by_hand, deck, loaded, options_by_hand, turned_blocks};
use crate::write::deck_reader::{Deck, NODES};
use meso_core::export::abaqus::{Analysis, DeckOptions};
use meso_core::materials::MortarStrength;
use meso_core::math::Vec3;
use meso_core::mesh::{
    self, CellKind, Fit, ItzForm, Joined, Mesh, MeshOptions, Method, Notes, Order, Phase, PhaseNames, Tools,
};
use meso_core::specimen::{Periodic, Specimen};
use meso_core::trial::{Sample, TestKind};
use std::collections::BTreeSet;

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
        owner: vec![0, Mesh::NO_BODY],
        id_of: vec![0],
        cohesive: if cohesive { vec![5, 6, 7, 1, 2, 3] } else { Vec::new() },
        cohesive_owner: if cohesive { vec![0] } else { Vec::new() },
        periodic: [false; 3],
        phases: PhaseNames::default(),
        notes: Notes::default(),
    }
}

/// Two voxels of 1 mm, one over the other, the upper one aggregate.
fn two_voxels(periodic: bool) -> Mesh {
    let specimen = Specimen::Box { size_mm: [1.0, 1.0, 2.0], periodic: Periodic([periodic; 3]) };
    let options = MeshOptions { element_size_mm: 1.0, itz: ItzForm::None, ..Default::default() };
    mesh::build((&[aggregate(0, block([0.0, 0.0, 1.0], [1.0, 1.0, 2.0]), 0.1)], &specimen), &options, &Tools::default())
        .unwrap()
}

#[test]
fn an_elastic_deck_of_two_linear_tetrahedra_reads_as_by_hand() {
    // S1 1-2-3 on ZMIN, S2 1-4-2 on YMIN, S4 3-4-1 on XMIN of element 1; node 1 pinned, node 2 kept from turning;
    // -0.001 of the height of 2 mm on ZMAX.
    let text = deck(&two_tetrahedra(false), &DeckOptions { analysis: Analysis::Elastic, ..options_by_hand() });
    assert_eq!(text, by_hand(include_str!("snapshots/two_tetrahedra_elastic.inp")));
}

#[test]
fn a_deck_of_a_cohesive_triangle_with_damage_reads_as_by_hand() {
    // COH3D6: the aggregate's face 6-7-8 is the bottom, its normal (1, 1, 1) out of the aggregate; 2-3-4 lie over it.
    let text = deck(&two_tetrahedra(true), &DeckOptions { with_damage: true, ..options_by_hand() });
    assert_eq!(text, by_hand(include_str!("snapshots/two_tetrahedra_cohesive.inp")));
}

#[test]
fn a_geometry_of_two_reduced_voxels_reads_as_by_hand() {
    let options = DeckOptions { geometry_only: true, reduced_integration: true, ..Default::default() };
    assert_eq!(deck(&two_voxels(false), &options), by_hand(include_str!("snapshots/two_reduced_voxels_geometry.inp")));
}

#[test]
fn a_spike_has_no_face_for_a_plate_to_press_on() {
    // As a specimen with an oblique tip has it: its deck would have named a surface that is not there.
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, 0.3, 9.0]].map(Vec3::from).to_vec();
    let (phase, owner) = (vec![Phase::Mortar], vec![Mesh::NO_BODY]);
    let spike = Mesh { points, cells: vec![0, 1, 2, 3], phase, owner, ..two_tetrahedra(false) };
    let specimen = Specimen::cuboid([1.0, 1.0, 9.0]);
    let of = |kind: TestKind| {
        let mut deck = DeckOptions { analysis: kind.into(), ..Default::default() };
        deck.load(&Sample::of(&spike, &specimen, &MeshOptions::default())).map_err(|error| error.to_string())
    };
    let error = of(TestKind::Compression).unwrap_err();
    assert!(error.contains("no face points to its upper plate"), "{error}");
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
    let options = DeckOptions { periodic_equations: true, analysis: Analysis::Elastic, ..options_by_hand() };
    assert_eq!(deck(&two_voxels(true), &options), by_hand(include_str!("snapshots/two_voxels_periodic_elastic.inp")));
}

#[test]
fn every_kind_of_deck_keeps_the_keyword_rules_and_names_only_what_it_has() {
    // Eight of them are enough for every element and set.
    let (mut grains, specimen) = (turned_blocks().0, Specimen::cube(20.0));
    grains.retain(|grain| [grain.id % 3, grain.id / 3 % 3, grain.id / 9].iter().all(|place| *place < 2));
    let mut seen = BTreeSet::new();
    let quadratic = Method::Lattice { fit: Fit::Fitted, order: Order::Quadratic };
    for method in [Method::VOXEL, Method::FITTED, quadratic] {
        for itz in [ItzForm::None, ItzForm::Solid, ItzForm::Smeared, ItzForm::Cohesive] {
            if (method, itz) == (quadratic, ItzForm::Cohesive) {
                continue;
            }
            let joined = Joined::Mortar;
            let options = MeshOptions { method, itz, joined, element_size_mm: 3.0, ..Default::default() };
            let mesh = mesh::build((&grains, &specimen), &options, &Tools::default()).unwrap();
            for analysis in [Analysis::None, Analysis::Elastic, TestKind::Compression.into(), TestKind::Tension.into()]
            {
                for reduced_integration in [false, true] {
                    let options = DeckOptions { analysis: analysis.clone(), reduced_integration, ..Default::default() };
                    let text = deck(&mesh, &options);
                    seen.extend(Deck::read(&text).elements.into_values().map(|element| element.kind));
                    Deck::read(&deck(&mesh, &DeckOptions { geometry_only: true, ..options }));
                }
            }
        }
    }
    assert!(NODES.iter().all(|(kind, _)| seen.contains(*kind)), "{seen:?}");
    let tied = DeckOptions { periodic_equations: true, analysis: Analysis::Elastic, ..Default::default() };
    assert_eq!(Deck::read(&deck(&two_voxels(true), &tied)).equations, 1);
}

#[test]
fn decks_of_specimens_of_every_kind_have_nodes_and_faces_on_all_six_sides() {
    for specimen in every_kind() {
        for method in [Method::VOXEL, Method::FITTED] {
            let options = MeshOptions { method, element_size_mm: 4.0, ..Default::default() };
            let mesh = mesh::build((&[], &specimen), &options, &Tools::default()).unwrap();
            let text = deck(&mesh, &DeckOptions { analysis: TestKind::Compression.into(), ..Default::default() });
            Deck::read(&text);
            for side in ["XMIN", "XMAX", "YMIN", "YMAX", "ZMIN", "ZMAX"] {
                let there = |line: String| text.lines().any(|l| l == line);
                let set = there(format!("*NSET, NSET={side}"));
                let surface = there(format!("*SURFACE, TYPE=ELEMENT, NAME=S_{side}"));
                assert!(set && surface, "{} {method:?} {side}: {set} {surface}", specimen.kind());
            }
        }
    }
}

/// Abaqus ends with an error where plastic strain falls: a peak strain below the elastic one was raised in silence, and
/// curves of a crushing energy of 0.05 N/mm in elements of 1 mm were written that it refuses.
#[test]
fn curves_that_abaqus_refuses_are_named() {
    let mesh = two_voxels(false);
    let with = |change: fn(&mut MortarStrength)| {
        let mut options = DeckOptions { analysis: TestKind::Compression.into(), ..Default::default() };
        options.materials.mortar.youngs_modulus_mpa = 26_000.0;
        options.materials.mortar_strength.tensile_mpa = 3.0;
        change(&mut options.materials.mortar_strength);
        options
    };
    let error = |options: DeckOptions| loaded(&mesh, &options).validate(&mesh).unwrap_err().to_string();
    let peak = error(with(|strength| strength.peak_strain = 0.0016));
    assert!(peak.contains("peak_strain is 0.0016; MORTAR needs 1.615e-3 or more"), "{peak}");
    let fracture = error(with(|strength| strength.fracture_energy_n_per_mm = Some(2e-4)));
    assert!(fracture.contains("fracture_energy_n_per_mm is 0.0002; MORTAR needs 2.769e-4 or more"), "{fracture}");
    // In the mesh, crack openings are 1 / 1.19 of the crack's own.
    let fracture = error(with(|strength| strength.fracture_energy_n_per_mm = Some(3e-4)));
    assert!(fracture.contains("fracture_energy_n_per_mm is 0.0003; MORTAR needs 3.295e-4 or more"), "{fracture}");
    // Strength^2 times width over modulus is 1.19 40^2 / 26000 = 0.0732 N/mm; the reader looks at the plastic strains.
    let brittle = with(|strength| strength.crushing_energy_n_per_mm = Some(0.05));
    assert_eq!(Deck::read(&deck(&mesh, &brittle)).materials.len(), 2);
    let doubts = brittle.doubts(&mesh, None);
    assert!(
        doubts[0].starts_with("elements too large for this crushing energy: crack bands of 1.19 mm, limit 0.80 mm"),
        "{doubts:?}"
    );
    let elastic = DeckOptions { analysis: Analysis::Elastic, ..with(|strength| strength.peak_strain = 0.0016) };
    assert!(elastic.validate(&mesh).is_ok(), "it has no curves");
}
