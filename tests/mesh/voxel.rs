//! Voxel meshes, and the decks of them.

use meso_core::aggregate::{Aggregate, Kind};
use meso_core::export::{abaqus, vtu_mesh};
use meso_core::geometry::{Plane, Polyhedron};
use meso_core::materials::{Materials, Plasticity, Strength};
use meso_core::math::{Aabb, Rotation, Vec3};
use meso_core::mesh::{self, ItzForm, Mesh, MeshError, MeshOptions, Method, Phase, PhaseVolumes, Tools, figures};
use meso_core::specimen::Specimen;
use meso_core::trial::Sample;
use std::io;
use std::path::PathBuf;

/// The axis-aligned block between two corners.
pub(crate) fn block(min: [f64; 3], max: [f64; 3]) -> Polyhedron {
    let pick = |bits: usize| Vec3::from_fn(|i, _| if bits >> i & 1 == 1 { max[i] } else { min[i] });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
    Polyhedron::from_parts((0..8).map(pick).collect(), faces.map(|f: [u32; 4]| f))
}

pub(crate) fn aggregate(id: u32, body: Polyhedron, itz_thickness_mm: f64) -> Aggregate {
    Aggregate { id, kind: Kind::Aggregate, own: None, class: 0, itz_thickness_mm, shells: Vec::new(), body }
}

/// Blocks turned at random in the cells of a 3 x 3 x 3 grid of 10 mm: disjoint, and not aligned with any mesh.
pub(crate) fn turned_blocks() -> (Vec<Aggregate>, Specimen) {
    let at = |id: u32| {
        let centre = Vec3::new((id % 3) as f64, (id / 3 % 3) as f64, (id / 9) as f64) * 10.0 + Vec3::repeat(5.0);
        let half = [2.0 + f64::from(id % 3) * 0.3, 2.5, 2.8];
        let turn = Rotation::from_euler_angles(f64::from(id) * 0.7, f64::from(id) * 1.3, f64::from(id) * 2.1);
        aggregate(id, block(half.map(|h| -h), half).rotated(&turn).translated(&centre), 0.5)
    };
    ((0..27).map(at).collect(), Specimen::cube(30.0))
}

fn sampled(subsamples: u32) -> Method {
    Method::Voxel { thin_itz: false, subsamples }
}

fn thin(subsamples: u32) -> Method {
    Method::Voxel { thin_itz: true, subsamples }
}

fn voxels(aggregates: &[Aggregate], specimen: &Specimen, options: MeshOptions) -> Mesh {
    mesh::build((aggregates, specimen), &options, &Tools::default()).unwrap()
}

/// A deck written by hand, for this version.
pub(crate) fn by_hand(snapshot: &str) -> String {
    snapshot.replace("VERSION", env!("CARGO_PKG_VERSION"))
}

pub(crate) fn deck(mesh: &Mesh, options: &abaqus::DeckOptions) -> String {
    let mut out = Vec::new();
    abaqus::write(mesh, &loaded(mesh, options), &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

/// The options with the loads of their test on `mesh`, which fills its box, of elements of 2 mm.
pub(crate) fn loaded(mesh: &Mesh, options: &abaqus::DeckOptions) -> abaqus::DeckOptions {
    let aabb = Aabb::around(&mesh.points);
    let specimen = Specimen::cuboid(aabb.size().into());
    let mut options = options.clone();
    options.load(&Sample::of(mesh, &specimen, &MeshOptions::default())).unwrap();
    options
}

/// Options of the decks that were written by hand: the materials of that time.
pub(crate) fn options_by_hand() -> abaqus::DeckOptions {
    let mut materials = Materials::default();
    materials.aggregate.youngs_modulus_mpa = 70_000.0;
    materials.mortar.youngs_modulus_mpa = 26_000.0;
    materials.itz.youngs_modulus_mpa = 20_000.0;
    materials.mortar_strength = Strength {
        compressive_mpa: 40.0,
        peak_strain: 0.0022,
        tensile_mpa: 3.0,
        fracture_energy_n_per_mm: 0.06,
        crushing_energy_n_per_mm: 0.5,
    }
    .into();
    materials.plasticity = Plasticity { dilation_angle_deg: 30.0, meridian_ratio: 0.75, ..materials.plasticity };
    abaqus::DeckOptions { materials, ..Default::default() }
}

#[test]
fn an_aligned_block_is_meshed_exactly() {
    let grains = [aggregate(0, block([2.0; 3], [8.0; 3]), 1.0)];
    let specimen = Specimen::cube(10.0);
    let mesh = voxels(&grains, &specimen, MeshOptions { element_size_mm: 1.0, ..Default::default() });
    let volumes = PhaseVolumes::of_mesh(&mesh);
    assert_eq!((volumes.aggregate, volumes.itz, volumes.mortar), (64.0, 216.0 - 64.0, 1000.0 - 216.0));
}

/// The planes of every aggregate, with its id.
fn planes(aggregates: &[Aggregate]) -> Vec<(u32, Vec<Plane>)> {
    aggregates.iter().map(|aggregate| (aggregate.id, aggregate.body.planes().collect())).collect()
}

#[test]
fn every_voxel_has_the_phase_of_its_centre() {
    let (grains, specimen) = turned_blocks();
    let options = MeshOptions { element_size_mm: 0.8, method: thin(1), ..Default::default() };
    let mesh = voxels(&grains, &specimen, options);
    let planes = planes(&grains);
    for (c, cell) in mesh.cells().enumerate() {
        let centre = cell.iter().map(|&node| mesh.points[node as usize]).sum::<Vec3>() / 8.0;
        let depth = |planes: &[Plane]| planes.iter().map(|p| p.normal.dot(&centre) - p.offset).fold(f64::MIN, f64::max);
        let depths = planes.iter().map(|(id, planes)| (*id, depth(planes)));
        let (id, depth) = depths.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        let expected = match depth {
            d if d <= -0.5 => Phase::Aggregate,
            d if d <= 0.0 => Phase::Itz,
            _ => Phase::Mortar,
        };
        assert_eq!(mesh.phase[c], expected, "depth {depth} at {centre}");
        assert_eq!(mesh.owner[c] == id, expected != Phase::Mortar);
    }
}

#[test]
fn the_solid_itz_is_never_thinner_than_a_voxel() {
    let (grains, specimen) = turned_blocks();
    let mesh = voxels(&grains, &specimen, MeshOptions { element_size_mm: 1.0, ..Default::default() });
    let neighbours = |c: usize| [1, 30, 900].into_iter().map(move |step| c + step).filter(|&n| n < 27_000);
    let touches = |c: usize, n: usize| {
        let pair = [mesh.phase[c], mesh.phase[n]];
        pair.contains(&Phase::Aggregate) && pair.contains(&Phase::Mortar)
    };
    assert!(mesh.phase.contains(&Phase::Aggregate), "the blocks must keep a core for this test to say anything");
    // Blocks stay clear of the cube's faces, so that stepping over the end of a row meets mortar on both sides.
    assert!((0..27_000).all(|c| neighbours(c).all(|n| !touches(c, n))));
}

#[test]
fn sub_samples_outvote_the_centre() {
    // The block holds the voxel's centre but only 5 of 8 samples along x and along y: 25 of 64 columns.
    let grains = [aggregate(0, block([0.0; 3], [0.6, 0.6, 1.0]), 0.0)];
    let phase = |subsamples| {
        let options = MeshOptions { element_size_mm: 1.0, method: sampled(subsamples), ..Default::default() };
        voxels(&grains, &Specimen::cube(1.0), options).phase
    };
    assert_eq!(phase(1), [Phase::Aggregate]);
    assert_eq!(phase(8), [Phase::Mortar]);
}

#[test]
fn a_thin_shell_takes_no_votes_from_its_aggregate() {
    // Along x, 2 of 7 samples lie in the core, 2 in the shell, 3 in the mortar.
    let grains = [aggregate(0, block([-9.0; 3], [0.55, 9.0, 9.0]), 0.25)];
    let options = MeshOptions { element_size_mm: 1.0, method: thin(7), ..Default::default() };
    assert_eq!(voxels(&grains, &Specimen::cube(1.0), options).phase, [Phase::Aggregate]);
}

#[test]
fn meshes_are_identical_at_one_and_eight_threads() {
    let (grains, specimen) = turned_blocks();
    let mesh = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| voxels(&grains, &specimen, MeshOptions { method: sampled(2), ..Default::default() }))
    };
    assert_eq!(mesh(1), mesh(8));
}

#[test]
fn an_element_size_beyond_the_specimen_is_named() {
    let error = mesh::build(
        (&[], &Specimen::cube(10.0)),
        &MeshOptions { element_size_mm: 20.0, ..Default::default() },
        &Tools::default(),
    );
    let text = error.unwrap_err().to_string();
    assert_eq!(text, "mesh.element_size_mm is 20; it must lie within 0.00666666666667 and 10 mm for this specimen");
}

/// Two voxels of 1 mm side by side, the second one aggregate.
fn two_voxels() -> Mesh {
    let grains = [aggregate(0, block([1.0, 0.0, 0.0], [2.0, 1.0, 1.0]), 0.0)];
    voxels(&grains, &Specimen::cuboid([2.0, 1.0, 1.0]), MeshOptions { element_size_mm: 1.0, ..Default::default() })
}

#[test]
fn a_deck_of_two_voxels_reads_as_by_hand() {
    // Checked by hand against the keyword rules: node order bottom counter-clockwise from above then top; S1 1-4-3-2,
    // S2 5-6-7-8, S3 1-2-6-5, S4 2-3-7-6, S5 3-4-8-7, S6 4-1-5-8.
    let text = deck(&two_voxels(), &abaqus::DeckOptions { heading: vec!["two voxels".into()], ..options_by_hand() });
    let expected = by_hand(include_str!("../write/snapshots/two_voxels.inp"));
    assert_eq!(text, expected);
}

#[test]
fn decks_keep_the_line_lengths_of_the_keyword_rules() {
    let (grains, specimen) = turned_blocks();
    let text = deck(&voxels(&grains, &specimen, MeshOptions::default()), &abaqus::DeckOptions::default());
    for line in text.lines() {
        assert!(line.len() <= if line.starts_with('*') { 79 } else { 256 }, "{line}");
        assert!(line.split(", ").count() <= 16, "{line}");
    }
    for set in ["ELSET=AGGREGATE", "ELSET=ITZ", "ELSET=MORTAR", "NSET=XMIN", "NSET=ZMAX", "NAME=S_XMIN", "NAME=S_ZMAX"]
    {
        assert!(text.contains(&format!("{set}\n")), "{set}");
    }
}

#[test]
fn a_geometry_only_deck_has_no_material() {
    let text = deck(&two_voxels(), &abaqus::DeckOptions { geometry_only: true, ..Default::default() });
    assert!(!text.contains("*MATERIAL") && !text.contains("*SOLID SECTION"));
}

#[test]
fn a_vtu_declares_where_every_array_starts() {
    let mesh = two_voxels();
    let mut out = Vec::new();
    vtu_mesh::write(&mesh, false, &mut out).unwrap();
    let start = 1 + out.windows(2).position(|w| w == b"\n_").unwrap() + 1;
    let head = String::from_utf8_lossy(&out[..start]).into_owned();
    let offsets: Vec<usize> =
        head.split("offset=\"").skip(1).map(|rest| rest[..rest.find('"').unwrap()].parse().unwrap()).collect();
    let size = |offset: usize| u64::from_le_bytes(out[start + offset..][..8].try_into().unwrap()) as usize;
    for pair in offsets.windows(2) {
        assert_eq!(pair[1], pair[0] + 8 + size(pair[0]));
    }
    assert_eq!(size(*offsets.last().unwrap()), 8);
}

fn lattice(element_size_mm: f64, method: Method) -> Mesh {
    let (grains, specimen) = turned_blocks();
    let options = MeshOptions { method, element_size_mm, itz: ItzForm::None, ..Default::default() };
    voxels(&grains, &specimen, options)
}

#[test]
fn a_fitted_lattice_fills_the_specimen_without_inverted_cells() {
    let mesh = lattice(1.0, Method::FITTED);
    assert!((PhaseVolumes::of_mesh(&mesh).total() / 27_000.0 - 1.0).abs() < 1e-9);
    assert!(figures::CellQuality::of_cells(&mesh).iter().all(|q| q.volume_mm3 > 0.0));
}

#[test]
fn the_faces_of_a_fitted_lattice_match_in_pairs() {
    // A diagonal that two neighbours chose differently would leave its four triangles alone inside the cube.
    let mesh = lattice(2.0, Method::FITTED);
    let mut faces: Vec<[u32; 3]> = mesh
        .cells()
        .flat_map(|cell| mesh.kind.faces().iter().map(|face| [0, 1, 2].map(|i| cell[face[i]])))
        .map(|mut face| {
            face.sort_unstable();
            face
        })
        .collect();
    faces.sort_unstable();
    let at = |node: u32, axis: usize| mesh.points[node as usize][axis];
    for group in faces.chunk_by(|a, b| a == b) {
        let outer = (0..3).any(|axis| [0.0, 30.0].iter().any(|x| group[0].iter().all(|&n| at(n, axis) == *x)));
        assert_eq!(group.len(), if outer { 1 } else { 2 }, "{:?}", group[0]);
    }
}

#[test]
fn a_plain_lattice_has_the_phase_of_every_centroid() {
    let (grains, _) = turned_blocks();
    let mesh = lattice(1.5, Method::PLAIN);
    let planes = planes(&grains);
    for (c, cell) in mesh.cells().enumerate() {
        let centre = cell.iter().map(|&node| mesh.points[node as usize]).sum::<Vec3>() / 4.0;
        let inside = |(_, planes): &&(u32, Vec<Plane>)| planes.iter().all(|p| p.normal.dot(&centre) <= p.offset);
        assert_eq!(mesh.owner[c], planes.iter().find(inside).map_or(Mesh::NO_BODY, |(id, _)| *id));
    }
}

#[test]
fn a_front_names_options_and_no_folders() {
    let named = |key: &str| format!("--{}", key.replace('_', "-"));
    let seam = MeshError::Seam { at: [0.0; 3] };
    assert!(seam.message(named).ends_with("choose another --element-size-mm or fewer slabs"));
    assert_eq!(seam.message(str::to_owned), seam.to_string());
    let folder = PathBuf::from("/tmp/element_size_mm");
    let files = MeshError::Files { folder, error: io::Error::other("full") };
    assert_eq!(files.message(named), files.to_string());
}
