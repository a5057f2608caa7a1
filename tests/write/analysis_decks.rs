//! Decks of analyses, read back from their cards: they hold nothing that an analyst would refuse.

use crate::mesh::voxel::{deck, loaded, options_by_hand};
use crate::write::deck_reader::{Card, Deck};
use meso_core::aggregate::Aggregate;
use meso_core::export::abaqus::{Analysis, DeckOptions};
use meso_core::materials::{Elastic, Materials};
use meso_core::math::Vec3;
use meso_core::mesh::figures::{self, MassScaling};
use meso_core::mesh::{
    self, ItzForm, Joined, Mesh, MeshOptions, Method, NarrowGaps, Phase, PhaseVolumes, Tools, Volumes,
};
use meso_core::specimen::Specimen;
use meso_core::trial::TestKind;
use meso_core::{Silent, Spec};
use nalgebra::{DMatrix, Matrix3x4, SMatrix};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

/// A small packing of the paper's grains: some are so close that elements of 2 mm join them.
fn grains() -> (Vec<Aggregate>, Specimen) {
    static GRAINS: LazyLock<(Vec<Aggregate>, Specimen)> = LazyLock::new(|| {
        let mut spec = Spec { fraction: 0.4, specimen: Specimen::cube(32.0), ..Default::default() };
        spec.placement.min_gap_mm = 0.3;
        (meso_core::pack(&spec, &Silent).unwrap().aggregates, spec.specimen)
    });
    GRAINS.clone()
}

fn meshed(options: MeshOptions) -> Mesh {
    let (grains, specimen) = self::grains();
    mesh::build((&grains, &specimen), &options, &Tools::default()).unwrap()
}

fn lattice(itz: ItzForm, joined: Joined, volumes: Volumes) -> Mesh {
    meshed(MeshOptions {
        method: Method::FITTED,
        itz,
        joined,
        volumes: Some(volumes),
        element_size_mm: 2.0,
        ..Default::default()
    })
}

// Meshes that several tests share. Joined aggregates kept, without and with cohesive elements.
static KEPT: LazyLock<Mesh> = LazyLock::new(|| lattice(ItzForm::None, Joined::Keep, Volumes::Fitted));
static COHESIVE: LazyLock<Mesh> = LazyLock::new(|| lattice(ItzForm::Cohesive, Joined::Keep, Volumes::Fitted));
// Parted by whole cells, without and with an ITZ, and by cut ones; cut, with the grains' volumes.
static MORTAR: LazyLock<Mesh> = LazyLock::new(|| lattice(ItzForm::None, Joined::Mortar, Volumes::Fitted));
static SMEARED: LazyLock<Mesh> = LazyLock::new(|| lattice(ItzForm::Smeared, Joined::Mortar, Volumes::Fitted));
static CUT: LazyLock<Mesh> = LazyLock::new(|| lattice(ItzForm::None, Joined::Cut, Volumes::Fitted));
static EXACT: LazyLock<Mesh> = LazyLock::new(|| lattice(ItzForm::Smeared, Joined::Cut, Volumes::Exact));

fn compression() -> DeckOptions {
    DeckOptions { analysis: TestKind::Compression.into(), ..Default::default() }
}

/// Counts nodes shared by cores from the mesh's cells, not from its notes.
fn shared_by_cores(mesh: &Mesh) -> usize {
    let mut owners: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    for ((cell, phase), id) in mesh.cells().zip(&mesh.phase).zip(&mesh.owner) {
        if *phase == Phase::Aggregate {
            cell.iter().for_each(|node| owners.entry(*node).or_default().extend([*id]));
        }
    }
    owners.values().filter(|ids| ids.len() > 1).count()
}

/// Faces that one cell alone has, by their nodes; panics where three cells share one.
fn outer_faces(mesh: &Mesh) -> Vec<Vec<u32>> {
    let mut cells: BTreeMap<Vec<u32>, usize> = BTreeMap::new();
    for cell in mesh.cells() {
        for face in mesh.kind.faces() {
            let mut nodes: Vec<u32> = face.iter().map(|&corner| cell[corner]).collect();
            nodes.sort_unstable();
            *cells.entry(nodes).or_default() += 1;
        }
    }
    assert!(cells.values().all(|count| *count <= 2));
    cells.into_iter().filter(|(_, count)| *count == 1).map(|(nodes, _)| nodes).collect()
}

#[test]
fn an_analysis_of_joined_aggregates_is_refused_with_the_way_out() {
    let mesh = &*KEPT;
    let shared = shared_by_cores(mesh);
    assert!(shared > 20, "{shared}: nothing to refuse");
    let error = compression().validate(mesh).unwrap_err().to_string();
    assert!(error.contains(&format!("share {shared} nodes")) && error.contains("joined mortar"), "{error}");
    assert_eq!(loaded(mesh, &DeckOptions { allow_joined: true, ..compression() }).validate(mesh), Ok(()));
    // A modulus of the skeleton is too stiff, and is doubted; so is a test that was asked for all the same.
    let elastic = DeckOptions { analysis: Analysis::Elastic, ..Default::default() };
    assert_eq!(elastic.validate(mesh), Ok(()));
    for deck in [elastic, DeckOptions { allow_joined: true, ..compression() }] {
        let doubts = deck.doubts(mesh, None);
        assert!(
            doubts[0].contains(&format!("share {shared} nodes")) && doubts[0].contains("joined mortar"),
            "{doubts:?}"
        );
    }
    assert_eq!(DeckOptions::default().doubts(mesh, None), Vec::<String>::new());
    assert_eq!(loaded(&COHESIVE, &compression()).validate(&COHESIVE), Ok(()));
}

#[test]
fn mortar_parts_joined_aggregates_in_meshes_of_every_kind() {
    let voxels = |joined| {
        meshed(MeshOptions {
            method: Method::VOXEL,
            itz: ItzForm::None,
            joined,
            element_size_mm: 1.0,
            ..Default::default()
        })
    };
    let voxels = [Joined::Keep, Joined::Mortar].map(voxels);
    for (what, kept, parted) in
        [("whole cells", &*KEPT, &*MORTAR), ("cut cells", &KEPT, &CUT), ("voxels", &voxels[0], &voxels[1])]
    {
        assert!(shared_by_cores(kept) > 20, "{what}");
        assert_eq!((shared_by_cores(parted), parted.joined_aggregates()), (0, (0, 0)), "{what}");
        assert_eq!(parted.notes.parted_nodes, shared_by_cores(kept));
        let volumes = [kept, parted].map(PhaseVolumes::of_mesh);
        assert!((volumes[0].total() - volumes[1].total()).abs() < 1e-8 * volumes[0].total());
        let lost = volumes[0].aggregate - volumes[1].aggregate - parted.notes.stiff_mm3;
        assert!((lost - parted.notes.parted_mm3).abs() < 1e-8 * volumes[0].total() && lost > 0.0, "{what}");
        assert_eq!(outer_faces(kept).len(), outer_faces(parted).len(), "{what}: it holds together as before");
    }
}

#[test]
fn mortar_parts_voxels_of_aggregates_that_would_press_on_each_other_through_cohesive_elements() {
    let cohesive = |method, joined| {
        let options =
            MeshOptions { method, itz: ItzForm::Cohesive, joined, element_size_mm: 1.0, ..Default::default() };
        let mesh = meshed(options);
        let deck = DeckOptions { analysis: TestKind::Compression.into(), ..DeckOptions::default() };
        (mesh.touching_share(), deck.doubts(&mesh, None).iter().any(|doubt| doubt.contains("form a skeleton")))
    };
    let kept = cohesive(Method::VOXEL, Joined::Keep);
    assert!(kept.0 > Mesh::FEW_TOUCH && kept.1, "{kept:?}");
    assert_eq!(cohesive(Method::VOXEL, Joined::Mortar), (0.0, false));
    let fitted = cohesive(Method::FITTED, Joined::Mortar);
    assert!(fitted.0 < Mesh::FEW_TOUCH && !fitted.1, "{fitted:?}");
}

#[test]
fn few_whole_cells_part_aggregates_and_cut_ones_cost_less_still() {
    let (kept, whole, cut) = (&*KEPT, &*MORTAR, &*CUT);
    assert!(whole.points == kept.points && whole.cells == kept.cells, "no element is made smaller");
    let became_mortar = kept.phase.iter().zip(&whole.phase).filter(|(a, b)| a != b).count();
    let parted = became_mortar - whole.notes.stiff_cells;
    assert_eq!((parted, parted), (whole.notes.parted_cells, kept.joining_cells().len()));
    let mut owners: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    for (cell, id) in kept.cells().zip(&kept.owner).filter(|(_, id)| **id != Mesh::NO_BODY) {
        cell.iter().for_each(|node| owners.entry(*node).or_default().extend([*id]));
    }
    let qualities = figures::CellQuality::of_cells(kept);
    let shared = |cell: &[u32]| cell.iter().any(|node| owners.get(node).is_some_and(|ids| ids.len() > 1));
    let cells = kept.cells().zip(&kept.owner).zip(&qualities);
    let both: f64 =
        cells.filter(|((cell, id), _)| **id != Mesh::NO_BODY && shared(cell)).map(|(_, q)| q.volume_mm3).sum();
    let lost = [whole, cut].map(|mesh| mesh.notes.parted_mm3 / both);
    assert!(lost[0] < 0.5 && lost[1] < 0.5 * lost[0], "{lost:?}");
}

#[test]
fn exact_volumes_are_within_half_a_percent_where_chords_cut_more_off() {
    let exact: f64 = grains().0.iter().map(|grain| grain.body.volume()).sum();
    let error = |mesh: &Mesh| PhaseVolumes::of_mesh(mesh).aggregate / exact - 1.0;
    let fitted = lattice(ItzForm::Smeared, Joined::Cut, Volumes::Fitted);
    let restored = &*EXACT;
    assert!(error(&fitted) < -0.01, "{}", error(&fitted));
    assert!(error(restored).abs() < 0.005, "{}", error(restored));
    let sharpest =
        |mesh: &Mesh| figures::CellQuality::of_cells(mesh).iter().map(|q| q.min_dihedral_deg).fold(90.0, f64::min);
    assert!(sharpest(restored) > sharpest(&fitted).min(9.0) - 1e-9);
    assert_eq!(restored.cells, fitted.cells);
}

#[test]
fn no_cell_of_an_aggregate_asks_for_a_shorter_step_than_mortar() {
    let materials = Materials::default();
    let shortest = |mesh: &Mesh, wanted: fn(&str) -> bool| {
        let phases = MassScaling::of(mesh, &materials, 5e-7).phases;
        phases.iter().filter(|phase| wanted(&phase.phase)).map(|phase| phase.shortest_step_s).fold(1.0, f64::min)
    };
    let mut spared = 0;
    for mesh in [&*MORTAR, &*SMEARED, &*CUT, &*EXACT] {
        let [stiff, soft] =
            [shortest(mesh, |phase| phase == "AGGREGATE"), shortest(mesh, |phase| phase != "AGGREGATE")];
        assert!(stiff >= soft, "{stiff} {soft}");
        spared += mesh.notes.stiff_cells;
    }
    assert!(spared > 0, "nothing was spared");
}

#[test]
fn split_gaps_leave_no_edge_of_mortar_from_one_aggregate_to_another() {
    let split = |method, itz, joined| {
        let narrow_gaps = NarrowGaps::Split;
        meshed(MeshOptions { method, itz, joined, narrow_gaps, element_size_mm: 2.0, ..Default::default() })
    };
    let solid = lattice(ItzForm::Solid, Joined::Keep, Volumes::Fitted);
    for (itz, joined, kept) in [
        (ItzForm::None, Joined::Cut, &*CUT),
        (ItzForm::Smeared, Joined::Mortar, &SMEARED),
        (ItzForm::Solid, Joined::Keep, &solid),
    ] {
        let mesh = split(Method::FITTED, itz, joined);
        assert!(mesh.notes.split_gap_edges > 100, "{itz:?}: {}", mesh.notes.split_gap_edges);
        assert_eq!(bridges(kept), mesh.notes.split_gap_edges, "{itz:?}");
        assert_eq!(bridges(&mesh), 0, "{itz:?}");
        assert_eq!(mesh.points[..kept.points.len()], kept.points, "nodes stay where they are");
        assert!((outer_area(&mesh) / outer_area(kept) - 1.0).abs() < 1e-9, "{itz:?}: neighbours agree on their faces");
        let volumes = [&mesh, kept].map(PhaseVolumes::of_mesh);
        // Halved edges make mortar's steps shorter, so fewer cells of aggregates are spared.
        let [split, whole] = [&mesh, kept].map(|mesh| PhaseVolumes::of_mesh(mesh).aggregate + mesh.notes.stiff_mm3);
        assert!((split - whole).abs() < 1e-9 * volumes[1].total());
        assert!((volumes[0].total() - volumes[1].total()).abs() < 1e-9 * volumes[1].total());
        assert!(figures::CellQuality::of_cells(&mesh).iter().all(|cell| cell.volume_mm3 > 0.0));
    }
    let voxels = split(Method::VOXEL, ItzForm::None, Joined::Mortar);
    assert_eq!(voxels.notes.split_gap_edges, 0);
}

/// Edges of cells of no aggregate whose ends lie on two aggregates, one each.
fn bridges(mesh: &Mesh) -> usize {
    let mut owners: Vec<BTreeSet<u32>> = vec![BTreeSet::new(); mesh.points.len()];
    for (cell, id) in mesh.cells().zip(&mesh.owner).filter(|(_, id)| **id != Mesh::NO_BODY) {
        cell.iter().for_each(|&node| _ = owners[node as usize].insert(*id));
    }
    let parts = |a: u32, b: u32| {
        let [a, b] = [a, b].map(|node| &owners[node as usize]);
        a.len() == 1 && b.len() == 1 && a != b
    };
    let mut found = BTreeSet::new();
    for (cell, _) in mesh.cells().zip(&mesh.owner).filter(|(_, id)| **id == Mesh::NO_BODY) {
        for (i, &a) in cell.iter().enumerate() {
            found.extend(cell[..i].iter().filter(|&&b| parts(a, b)).map(|&b| (a.min(b), a.max(b))));
        }
    }
    found.len()
}

/// Area of the outside, mm2: more where a node hangs in a neighbour's face.
fn outer_area(mesh: &Mesh) -> f64 {
    let p = |node: u32| mesh.points[node as usize];
    outer_faces(mesh).iter().map(|face| (p(face[1]) - p(face[0])).cross(&(p(face[2]) - p(face[0]))).norm() / 2.0).sum()
}

#[test]
fn the_smeared_itz_is_the_mortar_with_a_face_on_an_aggregate() {
    let mesh = &*SMEARED;
    let mut aggregates: Vec<BTreeSet<u32>> = vec![BTreeSet::new(); mesh.points.len()];
    let cores = mesh.cells().zip(&mesh.owner).zip(&mesh.phase).filter(|(_, phase)| **phase == Phase::Aggregate);
    for ((cell, &aggregate), _) in cores {
        for &node in cell {
            aggregates[node as usize].insert(aggregate);
        }
    }
    let lies_on_one = |cell: &[u32], face: &[usize]| {
        let of = |corner: &usize| aggregates[cell[*corner] as usize].clone();
        !face.iter().map(of).reduce(|a, b| &a & &b).unwrap().is_empty()
    };
    let at_aggregate: BTreeSet<usize> = (0..mesh.cell_count())
        .filter(|&cell| mesh.phase[cell] != Phase::Aggregate)
        .filter(|&cell| mesh.kind.faces().iter().any(|face| lies_on_one(mesh.cell(cell), face)))
        .collect();
    let smeared: BTreeSet<usize> = (0..mesh.cell_count()).filter(|&cell| mesh.phase[cell] == Phase::Itz).collect();
    assert!(smeared == at_aggregate && smeared.len() > 1000, "{} {}", smeared.len(), at_aggregate.len());
    let deck = Deck::read(&deck(mesh, &compression()));
    assert_eq!(deck.element_sets["ITZ"].len(), smeared.len());
    // As stiff as mortar, and of 0.7 times its strength.
    let elastic = |name: &str| card(&deck, name, "ELASTIC").data.clone();
    assert_eq!(elastic("ITZ"), elastic("MORTAR"));
    assert_eq!([peak(&deck, "ITZ"), peak(&deck, "MORTAR")], [28.0, 40.0]);
}

fn card<'a>(deck: &'a Deck, material: &str, keyword: &str) -> &'a Card {
    deck.materials[material].iter().find(|card| card.keyword == keyword).unwrap()
}

/// The rows of a curve: value and inelastic strain.
fn rows(deck: &Deck, material: &str, keyword: &str) -> Vec<[f64; 2]> {
    let card = card(deck, material, keyword);
    (0..card.data.len()).map(|row| card.numbers(row).try_into().unwrap()).collect()
}

fn peak(deck: &Deck, material: &str) -> f64 {
    rows(deck, material, "CONCRETE COMPRESSION HARDENING").iter().fold(0.0, |peak, row| row[0].max(peak))
}

#[test]
fn the_itz_of_thin_cells_is_no_tougher_than_mortar() {
    let mut spec = Spec { fraction: 0.3, specimen: Specimen::cube(20.0), ..Default::default() };
    (spec.grading.d_max_mm, spec.grading.classes_mm) = (10.0, vec![5.0, 10.0]);
    let options = MeshOptions { method: Method::FITTED, joined: Joined::Mortar, ..Default::default() };
    let mesh = mesh::build(&meso_core::pack(&spec, &Silent).unwrap(), &options, &Tools::default()).unwrap();
    let deck = Deck::read(&deck(&mesh, &compression()));
    let softened =
        |material| rows(&deck, material, "CONCRETE COMPRESSION DAMAGE").into_iter().filter(|row| row[0] > 0.0);
    let [itz, mortar] = ["ITZ", "MORTAR"].map(|material| softened(material).collect::<Vec<_>>());
    // From the first softened row on: the peaks lie where the moduli put them.
    let after = |rows: &[[f64; 2]], row: usize| rows[row][1] - rows[0][1];
    assert_eq!(itz.len(), mortar.len());
    for row in 1..itz.len() {
        let [itz, mortar] = [&itz, &mortar].map(|rows| after(rows, row));
        assert!(itz <= mortar * 1.0001, "{row}: {itz} {mortar}");
    }
}

#[test]
fn an_elastic_deck_with_a_cohesive_itz_is_elastic() {
    let mesh = &*COHESIVE;
    let keywords = |options: &DeckOptions| -> BTreeSet<String> {
        let deck = Deck::read(&deck(mesh, options));
        deck.materials.into_values().flatten().map(|card| card.keyword).collect()
    };
    let elastic = BTreeSet::from(["DENSITY", "ELASTIC"].map(String::from));
    for analysis in [Analysis::Elastic, Analysis::None] {
        assert_eq!(keywords(&DeckOptions { analysis, ..Default::default() }), elastic);
    }
    let with_damage = keywords(&DeckOptions { with_damage: true, ..Default::default() });
    assert!(with_damage.contains("DAMAGE EVOLUTION") && with_damage.contains("CONCRETE DAMAGED PLASTICITY"));
    let both = DeckOptions { with_damage: true, analysis: Analysis::Elastic, ..Default::default() };
    assert!(both.validate(mesh).unwrap_err().to_string().contains("with_damage is true; elastic has no damage"));
}

#[test]
fn debonded_faces_still_bear_compression_and_sliding_takes_more_energy_than_opening() {
    let options = DeckOptions { analysis: TestKind::Compression.into(), ..options_by_hand() };
    let deck = Deck::read(&deck(&COHESIVE, &options));
    let section = deck.sections.iter().find(|section| section.cohesive).unwrap();
    let controls = section.controls.as_ref().expect("it has section controls");
    assert_eq!([controls.parameter("ELEMENT DELETION"), controls.parameter("MAX DEGRADATION")], ["NO", "1.0"]);
    let evolution = card(&deck, "ITZ", "DAMAGE EVOLUTION");
    assert_eq!(evolution.parameter("MIXED MODE BEHAVIOR"), "BK");
    assert_eq!(evolution.numbers(0), [0.042, 0.42, 0.42]);
    // E / t in all directions: then shares of the separation are shares of the energy, as our engine has it.
    assert_eq!(card(&deck, "ITZ", "ELASTIC").numbers(0), [2e5; 3]);
}

/// Parted aggregates at the side leave the faces there in pieces, which Abaqus refuses of a contact pair.
#[test]
fn plates_press_on_nodes_where_faces_are_in_pieces() {
    let deck = Deck::read(&deck(&side_cut(), &compression()));
    assert!(deck.sheets("S_ZMIN") > 1, "the faces hang together here");
    let pairs = deck.step.unwrap().cards.into_iter().filter(|card| card.keyword == "CONTACT PAIR");
    assert_eq!(pairs.map(|card| card.data[0][0].clone()).collect::<Vec<_>>(), ["S_N_BOTTOM", "S_N_TOP"]);
}

/// Voxels with cohesive elements around grains that reach the lower side.
fn side_cut() -> Mesh {
    let (mut grains, specimen) = self::grains();
    grains.iter_mut().for_each(|grain| grain.body = grain.body.translated(&Vec3::new(0.0, 0.0, -4.0)));
    let itz = ItzForm::Cohesive;
    mesh::build(
        (&grains, &specimen),
        &MeshOptions { itz, element_size_mm: 2.0, ..Default::default() },
        &Tools::default(),
    )
    .unwrap()
}

#[test]
fn a_deck_has_the_cards_of_its_step() {
    let mut options = compression();
    (options.duration_s, options.time_increment_s, options.frames) = (Some(0.01), Some(2e-7), Some(3));
    let deck = Deck::read(&deck(&SMEARED, &options));
    let step = deck.step.as_ref().unwrap();
    assert_eq!(step.card("DYNAMIC").unwrap().data, [["", "0.01"]]);
    assert_eq!(step.card("FIXED MASS SCALING").unwrap().parameter("DT"), "2e-7");
    assert_eq!(step.card("RESTART").unwrap().parameter("NUMBER INTERVAL"), "4");
    let outputs: Vec<&Card> = step.cards.iter().filter(|card| card.keyword == "OUTPUT").collect();
    let filtered = |card: &&&Card| card.parameters.get("FILTER").is_some_and(|name| name == "ANTIALIASING");
    assert_eq!((outputs.len(), outputs.iter().filter(filtered).count()), (4, 1));
    let asked: BTreeSet<&str> = step
        .cards
        .iter()
        .filter(|card| card.keyword.ends_with(" OUTPUT"))
        .flat_map(|card| card.data.iter().flatten().map(String::as_str))
        .collect();
    for variable in ["PEEQ", "PEEQT", "DAMAGEC", "DAMAGET", "U3", "RF3", "ALLKE", "ALLSE", "ALLMW", "DT", "DMASS"] {
        assert!(asked.contains(variable), "{variable}");
    }
    assert!(!asked.contains("STATUS"), "there are no cohesive elements");
    assert!(deck.heading.iter().any(|line| line.contains("double=both")), "{:?}", deck.heading);
    assert!(deck.rigid_bodies.iter().all(|(_, card)| card.data == [["0."]]), "no thickness");
}

#[test]
fn mortar_that_will_hardly_soften_in_the_step_is_doubted() {
    let mesh = &*SMEARED;
    let with = |crushing_energy_n_per_mm: f64| {
        let mut materials = Materials::default();
        materials.mortar_strength.crushing_energy_n_per_mm = Some(crushing_energy_n_per_mm);
        DeckOptions { materials, ..compression() }
    };
    assert!(with(0.5).doubts(mesh, None).is_empty(), "{:?}", with(0.5).doubts(mesh, None));
    let strain = with(0.5).half_strength_strain(mesh).unwrap();
    assert!((0.001..0.009).contains(&strain), "{strain}");
    let doubts = with(60.0).doubts(mesh, None);
    assert!(doubts.len() == 1 && doubts[0].contains("hardly soften"), "{doubts:?}");
    let remedy = doubts[0].split("crushing_energy_n_per_mm (").nth(1).and_then(|text| text.split(' ').next());
    let remedy = remedy.and_then(|energy| energy.parse().ok()).expect("an energy that softens");
    assert!(
        with(remedy).doubts(mesh, None).is_empty() && !with(2.0 * remedy).doubts(mesh, None).is_empty(),
        "{remedy}"
    );
    let bonded = compression().doubts(&MORTAR, None);
    assert!(bonded.len() == 1 && bonded[0].contains("without an ITZ"), "{bonded:?}");
}

/// The highest frequency of a free tetrahedron with lumped masses, by its stiffness matrix.
fn highest_frequency(p: [Vec3; 4], elastic: &Elastic) -> f64 {
    let edges = SMatrix::<f64, 3, 3>::from_columns(&[p[1] - p[0], p[2] - p[0], p[3] - p[0]]);
    let inverse = edges.try_inverse().unwrap().transpose();
    let mut gradients = Matrix3x4::zeros();
    for i in 0..3 {
        gradients.set_column(i + 1, &inverse.column(i));
        gradients.set_column(0, &(gradients.column(0) - inverse.column(i)));
    }
    let (e, nu) = (elastic.youngs_modulus_mpa, elastic.poisson_ratio);
    let (lambda, mu) = (e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)));
    let stiffness = DMatrix::from_fn(12, 12, |row, column| {
        let (a, i, b, j) = (row / 3, row % 3, column / 3, column % 3);
        let g = |node: usize, axis: usize| gradients[(axis, node)];
        let shear = if i == j { gradients.column(a).dot(&gradients.column(b)) } else { 0.0 };
        lambda * g(a, i) * g(b, j) + mu * (g(a, j) * g(b, i) + shear)
    });
    // The mass of a node is a quarter of the cell's, and the volume cancels.
    (stiffness.symmetric_eigenvalues().max() * 4.0 / elastic.density_t_per_mm3).sqrt()
}

#[test]
fn the_stable_time_step_is_a_bound_and_not_far_from_the_longest() {
    let elastic = Materials::default().mortar;
    let mesh = lattice(ItzForm::Solid, Joined::Mortar, Volumes::Fitted);
    let (mut tightest, mut altitudes_too_long) = (0.0_f64, 0);
    for (cell, quality) in mesh.cells().zip(figures::CellQuality::of_cells(&mesh)).step_by(97) {
        let p = [0, 1, 2, 3].map(|i| mesh.points[cell[i] as usize]);
        let longest = 2.0 / highest_frequency(p, &elastic);
        let told = quality.stable_length_mm / elastic.wave_speed_mm_per_s();
        assert!(told <= longest * (1.0 + 1e-9), "{told} {longest}");
        tightest = tightest.max(told / longest);
        altitudes_too_long += usize::from(quality.shortest_altitude_mm / elastic.wave_speed_mm_per_s() > longest);
    }
    assert!(tightest > 0.8 && altitudes_too_long > 0, "{tightest} {altitudes_too_long}");
}

#[test]
fn a_mesh_report_has_the_mass_scaling_of_each_phase() {
    // Voxels of 1 mm: 1 / (c sqrt(3)), and the mass grows with the square of the missing factor.
    let mesh = meshed(MeshOptions { itz: ItzForm::None, element_size_mm: 1.0, ..Default::default() });
    let materials = Materials::default();
    let step = 5e-7;
    let scaling = MassScaling::of(&mesh, &materials, step);
    let volumes = PhaseVolumes::of_mesh(&mesh);
    let (mut before, mut after) = (0.0, 0.0);
    for (phase, elastic) in [(Phase::Aggregate, materials.aggregate), (Phase::Mortar, materials.mortar)] {
        let told = scaling.phases.iter().find(|told| told.phase == mesh.phases.set_name(phase)).unwrap();
        let factor = (step * elastic.wave_speed_mm_per_s()).powi(2) * 3.0;
        assert!((told.factor / factor - 1.0).abs() < 1e-9 && told.scaled == 1.0, "{told:?} {factor}");
        let mass = volumes.of(phase) * elastic.density_t_per_mm3;
        assert!((told.mass_t / mass - 1.0).abs() < 1e-9);
        (before, after) = (before + mass, after + mass * factor);
    }
    assert!((scaling.factor / (after / before) - 1.0).abs() < 1e-9);
    let short = MassScaling::of(&mesh, &materials, 1e-9);
    assert!(
        short.factor == 1.0 && short.added_percent() == 0.0 && short.phases.iter().all(|phase| phase.scaled == 0.0)
    );
}

/// A density of 2.4e-6 (kg/mm3) passed, and "+1421080148 % by mass scaling" was a plain line.
#[test]
fn a_step_that_needs_much_mass_is_doubted_with_one_that_needs_little_and_far_too_much_is_refused() {
    let mesh = meshed(MeshOptions { itz: ItzForm::None, element_size_mm: 1.0, ..Default::default() });
    let at = |step: f64| {
        let options = DeckOptions { time_increment_s: Some(step), allow_joined: true, ..compression() };
        loaded(&mesh, &options)
    };
    let scaled = |step: f64| MassScaling::of(&mesh, &Materials::default(), step).factor;
    let named = |text: &str| -> f64 {
        let (_, words) = text.split_once("take ").or_else(|| text.split_once("a time increment of ")).unwrap();
        words.split(' ').next().unwrap().parse().unwrap()
    };
    let of_mass = |step: f64| at(step).doubts(&mesh, None).into_iter().find(|doubt| doubt.contains("times the mass"));
    let doubt = of_mass(5e-7).unwrap();
    assert!(doubt.contains("steps of 5e-7 s need") && scaled(5e-7) > 2.0 && scaled(5e-7) < 100.0, "{doubt}");
    let little = named(&doubt);
    assert!((1.02..=1.2).contains(&scaled(little)) && of_mass(little).is_none(), "{doubt} {}", scaled(little));
    let refused = at(1e-5).validate(&mesh).unwrap_err().to_string();
    assert!(refused.starts_with("deck.time_increment_s is 1e-5; such steps need") && scaled(1e-5) > 100.0, "{refused}");
    assert_eq!(named(&refused), little);
    assert_eq!(at(5e-7).validate(&mesh), Ok(()));
}

/// From the cards alone: the volumes of the sets, as a solver that is driven by the deck would find them.
#[test]
fn a_deck_holds_the_whole_specimen() {
    let deck = Deck::read(&deck(&EXACT, &compression()));
    let volume = |set: &str| -> f64 {
        let cell = |number: &u64| {
            let [a, b, c, d] = [0, 1, 2, 3].map(|i| Vec3::from(deck.nodes[&deck.elements[number].nodes[i]]));
            (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
        };
        deck.element_sets[set].iter().map(cell).inspect(|volume| assert!(*volume > 0.0)).sum()
    };
    let (aggregate, mortar) = (volume("AGGREGATE"), volume("MORTAR") + volume("ITZ"));
    let (grains, specimen) = grains();
    let exact: f64 = grains.iter().map(|grain| grain.body.volume()).sum();
    assert!((aggregate + mortar - specimen.volume()).abs() < 1e-3 && (aggregate / exact - 1.0).abs() < 0.005);
    assert_eq!(deck.friction, Some(0.1));
    assert_eq!(deck.rigid_bodies.len(), 2);
}
