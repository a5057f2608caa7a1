//! Second-order tetrahedra: nodes in the middle of edges, in decks and in CalculiX.

use crate::mesh::voxel::{by_hand, deck, options_by_hand, turned_blocks};
use crate::write::calculix::{AREA_MM2, hashin_shtrikman, modulus, packed};
use meso_core::aggregate::Itz;
use meso_core::export::abaqus::DeckOptions;
use meso_core::materials::Materials;
use meso_core::math::Vec3;
use meso_core::mesh::cells::Sides;
use meso_core::mesh::{
    self, CellKind, Fit, ItzForm, Mesh, MeshOptions, MeshTable, Method, MethodName, Notes, Order, Phase, PhaseNames,
    PhaseVolumes, Purpose, Tools,
};
use meso_core::trial::TestKind;

/// Two tetrahedra that share a face, the first of them aggregate.
fn two_tetrahedra() -> Mesh {
    let points = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0], [2.0, 2.0, 2.0]];
    Mesh {
        points: points.map(Vec3::from).to_vec(),
        kind: CellKind::Tetrahedron,
        cells: vec![0, 1, 2, 3, 1, 2, 3, 4],
        phase: vec![Phase::Aggregate, Phase::Mortar],
        owner: vec![0, Mesh::NO_BODY],
        id_of: vec![0],
        cohesive: Vec::new(),
        cohesive_owner: Vec::new(),
        periodic: [false; 3],
        phases: PhaseNames::default(),
        notes: Notes::default(),
    }
}

#[test]
fn a_deck_of_two_quadratic_tetrahedra_reads_as_by_hand() {
    // By hand: corners 1-4, then the middles of 1-2, 2-3, 3-1, 1-4, 2-4, 3-4; nine edges for nine middles, three of them
    // shared; S1 1-2-3 on ZMIN, S2 1-4-2 on YMIN, S4 3-4-1 on XMIN.
    let mut mesh = two_tetrahedra();
    mesh.raise_order();
    let text = deck(&mesh, &options_by_hand());
    assert_eq!(text, by_hand(include_str!("snapshots/two_quadratic_tetrahedra.inp")));
}

#[test]
fn explicit_decks_take_the_second_order_tetrahedron_made_for_contact() {
    let mesh = lattice(Order::Quadratic);
    let text = deck(&mesh, &DeckOptions { analysis: TestKind::Tension.into(), ..Default::default() });
    assert!(text.contains("*ELEMENT, TYPE=C3D10M, ELSET=MORTAR\n") && !text.contains("C3D10,"));
}

fn lattice(order: Order) -> Mesh {
    let (grains, specimen) = turned_blocks();
    let method = Method::Lattice { fit: Fit::Fitted, order };
    let options = MeshOptions { method, element_size_mm: 2.5, itz: ItzForm::None, ..Default::default() };
    mesh::build((&grains, &specimen), &options, &Tools::default()).unwrap()
}

#[test]
fn every_edge_has_one_node_in_its_middle() {
    let (linear, quadratic) = (lattice(Order::Linear), lattice(Order::Quadratic));
    let corners = linear.points.len();
    assert_eq!(quadratic.points[..corners], linear.points);
    let edges = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
    let mut ends = std::collections::BTreeMap::new();
    for (cell, old) in quadratic.cells().zip(linear.cells()) {
        assert_eq!(&cell[..4], old);
        for (middle, [i, j]) in cell[4..].iter().zip(edges) {
            let edge = (cell[i].min(cell[j]), cell[i].max(cell[j]));
            assert_eq!(*ends.entry(edge).or_insert(*middle), *middle);
            let [a, b, m] = [cell[i], cell[j], *middle].map(|node| quadratic.points[node as usize]);
            assert_eq!((a + b) / 2.0, m);
        }
    }
    assert_eq!(ends.len(), quadratic.points.len() - corners, "no edge has two nodes, and no node is without an edge");
    assert_eq!(PhaseVolumes::of_mesh(&quadratic), PhaseVolumes::of_mesh(&linear));
}

#[test]
fn the_sides_hold_their_middle_nodes() {
    let mesh = lattice(Order::Quadratic);
    let sides = Sides::of(&mesh);
    let on_top: std::collections::BTreeSet<u32> = sides.members(5).collect();
    let faces = &sides.faces()[5];
    let places = mesh.kind.face_nodes();
    let of_faces = faces.iter().flat_map(|&(cell, face)| {
        let cell = &mesh.cells[10 * cell as usize..][..10];
        places[face].iter().map(move |&i| cell[i])
    });
    assert_eq!(on_top, of_faces.collect(), "the nodes on ZMAX are those of S_ZMAX");
}

#[test]
fn the_names_of_options_of_one_method_give_them_again() {
    let quadratic = Order::Quadratic;
    for method in [
        Method::Voxel { thin_itz: true, subsamples: 3 },
        Method::Lattice { fit: Fit::Plain, order: quadratic },
        Method::Conforming { order: quadratic, slabs: Some(2) },
    ] {
        let options = MeshOptions { method, ..Default::default() };
        let again = MeshTable::from(options.clone()).resolve(Purpose::Test, &Itz::default()).unwrap();
        assert_eq!(again.for_bodies(&[]), options.for_bodies(&[]));
    }
}

#[test]
fn orders_that_no_element_has_are_named() {
    let (grains, specimen) = turned_blocks();
    let error =
        |options: MeshOptions| mesh::build((&grains, &specimen), &options, &Tools::default()).unwrap_err().to_string();
    let resolve = |method, order| {
        let table = MeshTable { method: Some(method), order: Some(order), ..Default::default() };
        table.resolve(Purpose::Mesh, &Itz::default())
    };
    let refused = |method, order| resolve(method, order).unwrap_err().to_string();
    assert_eq!(refused(MethodName::Lattice, 3), "mesh.order is 3; it must be 1 or 2");
    let voxels = refused(MethodName::Voxel, 2);
    assert_eq!(voxels, "mesh.order is 2; voxels take 1; the methods lattice and conforming take 2");
    let quadratic = resolve(MethodName::Lattice, 2).unwrap();
    let cohesive = error(MeshOptions { itz: ItzForm::Cohesive, ..quadratic });
    assert_eq!(cohesive, "mesh.order is 2; with a cohesive itz it must be 1; itz solid or none take 2");
}

#[test]
fn calculix_finds_second_order_softer_than_first_and_above_the_lower_bound() {
    let model = packed();
    let solve = |order| {
        let method = Method::Lattice { fit: Fit::Fitted, order };
        let options = MeshOptions { method, itz: ItzForm::None, element_size_mm: 5.0, ..Default::default() };
        let mesh = mesh::build(&model, &options, &Tools::default()).unwrap();
        modulus(&mesh, AREA_MM2).map(|modulus| (modulus, PhaseVolumes::of_mesh(&mesh)))
    };
    let (Some((first, _)), Some((second, volumes))) = (solve(Order::Linear), solve(Order::Quadratic)) else { return };
    let [low, high] = hashin_shtrikman(&volumes, &Materials::default());
    assert!(low < second && second < high, "{low} < {second} < {high}");
    // Equal geometry with more ways to deform is softer.
    assert!(second < first && first < 1.05 * second, "{first} {second}");
}
