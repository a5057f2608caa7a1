//! Shells of grains as layers of tetrahedra of their own thickness, below a solid ITZ.

use crate::sampled_shells::models;
use crate::shells::packed;
use crate::write::deck_reader::Deck;
use meso_core::Model;
use meso_core::export::abaqus::{self, DeckOptions};
use meso_core::mesh::{self, Mesh, MeshOptions, Method, Phase, PhaseVolumes, Tools, figures};
use std::collections::BTreeSet;

const GRAINS: &str = "fraction = 0.35\nspecimen = { kind = 'cube', side_mm = 40 }\n\
    grading = { d_min_mm = 8, d_max_mm = 16, classes_mm = [8, 16] }\n";

/// The grains with an ITZ and shells of these thicknesses, mm.
fn with_shells(grains: &str, itz_mm: f64, shells: &[f64]) -> Model {
    let entry =
        |(shell, mm): (usize, &f64)| format!("[[shape.shells]]\nname = 's{shell}'\nthickness_mm = [{mm}, {mm}]\n");
    let entries: String = shells.iter().enumerate().map(entry).collect();
    packed(&format!("{grains}itz.thickness_mm = [{itz_mm}, {itz_mm}]\n{entries}"))
}

fn meshed(model: &Model, element_size_mm: f64) -> Mesh {
    let options = MeshOptions { method: Method::FITTED, element_size_mm, ..MeshOptions::default() };
    mesh::build(model, &options, &Tools::default()).unwrap()
}

/// The volumes of the mesh over the exact ones, of phases that there are; no cell is turned over or flatter than a layer's.
fn ratios(model: &Model, mesh: &Mesh) -> Vec<(Phase, f64)> {
    let (volumes, specimen) = (PhaseVolumes::of_mesh(mesh), &model.spec.specimen);
    let exact = PhaseVolumes::exact_for(mesh, &model.aggregates, specimen).unwrap();
    let cells = figures::CellQuality::of_cells(mesh);
    let least = |of: &dyn Fn(&figures::CellQuality) -> f64| cells.iter().map(of).fold(f64::INFINITY, f64::min);
    let (volume, angle) = (least(&|cell| cell.volume_mm3), least(&|cell| cell.min_dihedral_deg));
    assert!((volumes.total() / specimen.volume() - 1.0).abs() < 1e-9);
    assert!(volume > 0.0 && angle > 1.99, "{volume} mm3, {angle} degrees");
    let there = mesh.phases.all().filter(|phase| exact.of(*phase) > 0.0);
    there.map(|phase| (phase, volumes.of(phase) / exact.of(phase))).collect()
}

#[test]
fn shells_are_layers_of_their_volumes_and_move_hardly_a_node_of_the_itz() {
    let model = crate::shells::recycled();
    let mesh = meshed(model, 2.0);
    let found = ratios(model, &mesh);
    assert_eq!(found.len(), 6, "mortar, ITZ, cores of two kinds, two shells of half of the grains: {found:?}");
    assert!(found.iter().all(|(_, ratio)| (ratio - 1.0).abs() < 0.01), "{found:?}");
    let mut stripped = model.clone();
    stripped.aggregates.iter_mut().for_each(|grain| grain.shells.clear());
    let itz = |mesh: &Mesh| -> Vec<[[u64; 3]; 4]> {
        let cells = mesh.cells().zip(&mesh.phase).filter(|(_, phase)| **phase == Phase::Itz);
        let corners = |cell: &[u32]| [0, 1, 2, 3].map(|i| mesh.points[cell[i] as usize].map(f64::to_bits).into());
        cells.map(|(cell, _)| corners(cell)).collect()
    };
    let (with, without) = (itz(&mesh), itz(&meshed(&stripped, 2.0)));
    let moved = with.iter().zip(&without).filter(|(a, b)| a != b).count();
    assert!(with.len() == without.len() && moved * 1000 < with.len(), "{moved} of {}", with.len());
}

#[test]
fn two_shells_have_the_volume_of_one_as_thick() {
    let [one, two] = [&[0.4][..], &[0.2, 0.2]].map(|shells| with_shells(GRAINS, 0.25, shells));
    let [of_one, of_two] = [&one, &two].map(|model| {
        let mesh = meshed(model, 1.5);
        assert!(ratios(model, &mesh).iter().all(|(_, ratio)| (ratio - 1.0).abs() < 0.005));
        PhaseVolumes::of_mesh(&mesh)
    });
    let both = of_two.of(Phase::Own(0)) + of_two.of(Phase::Own(1));
    assert!((both / of_one.of(Phase::Own(0)) - 1.0).abs() < 1e-3, "{of_one:?} {of_two:?}");
    assert!((of_two.of(Phase::Aggregate) / of_one.of(Phase::Aggregate) - 1.0).abs() < 1e-3, "{of_one:?} {of_two:?}");
}

#[test]
fn shells_without_an_itz_are_layers_with_sets_in_a_deck() {
    let model = with_shells(GRAINS, 0.0, &[0.1, 0.1]);
    let mesh = meshed(&model, 2.0);
    let found = ratios(&model, &mesh);
    assert!(found.iter().all(|(_, ratio)| (ratio - 1.0).abs() < 0.01), "{found:?}");
    assert!(!mesh.phase.contains(&Phase::Itz));
    let mut deck = Vec::new();
    abaqus::write(&mesh, &DeckOptions { geometry_only: true, ..DeckOptions::default() }, &mut deck).unwrap();
    let deck = String::from_utf8(deck).unwrap();
    let sets = Deck::read(&deck).element_sets;
    for (set, phase) in [("S0", Phase::Own(0)), ("S1", Phase::Own(1)), ("AGGREGATE", Phase::Aggregate)] {
        let cells = (1..).zip(&mesh.phase).filter(|(_, own)| **own == phase).map(|(number, _)| number);
        assert!(cells.eq(sets[set].iter().copied()), "{set}");
    }
}

#[test]
fn ellipsoids_and_grains_with_dents_have_layers() {
    for model in models(&[("a", [0.2, 0.3]), ("b", [0.3, 0.3])]) {
        let found = ratios(&model, &meshed(&model, 1.5));
        assert!(found.len() == 5 && found.iter().all(|(_, ratio)| (ratio - 1.0).abs() < 0.002), "{found:?}");
    }
}

#[test]
fn layers_across_periodic_faces_match() {
    let periodic = GRAINS.replace("side_mm = 40", "side_mm = 40, periodic = ['x', 'y', 'z']");
    let model = with_shells(&periodic, 0.25, &[0.2, 0.3]);
    let mesh = meshed(&model, 2.0);
    let found = ratios(&model, &mesh);
    let is_near =
        |(phase, ratio): &(Phase, f64)| (ratio - 1.0).abs() < if *phase == Phase::Aggregate { 0.02 } else { 0.005 };
    assert!(found.iter().all(is_near), "{found:?}");
    for axis in 0..3 {
        let side = |place: f64| {
            let faces = mesh.cells().zip(&mesh.phase).zip(&mesh.owner).flat_map(|((cell, phase), owner)| {
                let of = mesh.kind.faces().iter().map(|face| [0, 1, 2].map(|i| mesh.points[cell[face[i]] as usize]));
                of.map(move |corners| (corners, *phase, *owner))
            });
            let there = faces.filter(|(corners, ..)| corners.iter().all(|corner| corner[axis] == place));
            let others = there.map(|(corners, phase, owner)| {
                let mut corners = corners.map(|p| [1, 2].map(|next| p[(axis + next) % 3].to_bits()));
                corners.sort_unstable();
                (corners, phase, owner)
            });
            others.collect::<BTreeSet<_>>()
        };
        let [low, high] = [0.0, 40.0].map(side);
        let corners = |side: &BTreeSet<([[u64; 2]; 3], Phase, u32)>| side.iter().map(|of| of.0).collect::<Vec<_>>();
        assert!(corners(&low) == corners(&high));
        // Where an aggregate ends at a face, there is mortar behind the other.
        let mut unlike = low.symmetric_difference(&high);
        assert!(unlike.all(|(_, phase, _)| matches!(phase, Phase::Mortar | Phase::Aggregate)));
        assert!(low.iter().any(|(_, phase, _)| *phase == Phase::Own(1)));
    }
}
