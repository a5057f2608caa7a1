//! Periodic decks of conforming meshes: every upper node tied, and their results in CalculiX beside the other meshes of
//! the same packing. (Skipped where `gmsh` or `ccx` is not installed.)

use crate::mesh::voxel::deck;
use crate::write::calculix::{as_stiff, gmsh};
use crate::write::cohesive_decks::with_springs;
use crate::write::periodic_decks::{SIDE_MM, equations, modulus, modulus_by_force, solve_deck, tied};
use meso_core::aggregate::Grading;
use meso_core::export::abaqus::Analysis;
use meso_core::math::Vec3;
use meso_core::mesh::{self, ItzForm, Mesh, MeshError, MeshOptions, Method, Tools};
use meso_core::specimen::{Periodic, Specimen};
use meso_core::{Model, Silent, Spec};
use std::collections::BTreeSet;

/// The packing of [`periodic_decks::packed`](crate::write::periodic_decks::packed) with room for gmsh.
fn packed(axes: [bool; 3]) -> Model {
    let specimen = Specimen::Cube { side_mm: SIDE_MM, periodic: Periodic(axes) };
    let mut spec = Spec { fraction: 0.3, specimen, ..Default::default() };
    spec.grading = Grading { d_min_mm: 6.0, d_max_mm: 12.0, classes_mm: vec![6.0, 12.0], ..spec.grading };
    (spec.placement.min_gap_mm, spec.placement.wall_gap_mm) = (0.05, 0.05);
    meso_core::pack(&spec, &Silent).unwrap()
}

/// `None` without gmsh.
fn meshed(model: &Model, options: MeshOptions) -> Option<Mesh> {
    let no_gmsh = |error: MeshError| eprintln!("skipped: no `gmsh` here (Debian: gmsh): {error}");
    mesh::build(model, &options, &Tools { gmsh: &gmsh, ..Tools::default() }).map_err(no_gmsh).ok()
}

fn conforming(model: &Model, itz: ItzForm, element_size_mm: f64) -> Option<Mesh> {
    meshed(model, MeshOptions { method: Method::CONFORMING, itz, element_size_mm, ..Default::default() })
}

#[test]
fn every_node_on_an_upper_face_of_a_conforming_mesh_is_tied_to_its_image() {
    // Cohesive elements bring copies of nodes on one face, on edges and in corners.
    for (axes, forms) in [
        ([true; 3], &[ItzForm::None, ItzForm::Cohesive][..]),
        ([true, false, true], &[ItzForm::Cohesive]),
        ([false, true, false], &[ItzForm::Cohesive]),
    ] {
        for &itz in forms {
            let Some(mesh) = conforming(&packed(axes), itz, 4.0) else { return };
            let upper = |p: &Vec3| (0..3).filter(|&axis| axes[axis] && p[axis] == SIDE_MM).count();
            let on_upper: BTreeSet<u32> =
                (1..).zip(&mesh.points).filter(|(_, p)| upper(p) > 0).map(|(node, _)| node).collect();
            assert!(on_upper.len() > 100, "{axes:?}: {}", on_upper.len());
            let equations = equations(&deck(&mesh, &tied(Analysis::None)));
            let tied: BTreeSet<(u32, u32)> = equations.iter().map(|terms| (terms[0].0, terms[0].1)).collect();
            let all: BTreeSet<(u32, u32)> = on_upper.iter().flat_map(|node| (1..=3).map(move |i| (*node, i))).collect();
            assert!(tied == all && equations.len() == all.len(), "{axes:?} {itz:?}: {} {}", tied.len(), all.len());
            for terms in &equations {
                let [node, image] = [0, 1].map(|i| mesh.points[terms[i].0 as usize - 1]);
                let jump = Vec3::from_fn(|axis, _| if axes[axis] && node[axis] == SIDE_MM { SIDE_MM } else { 0.0 });
                assert_eq!(node - jump, image, "{axes:?}: to the last bit");
            }
        }
    }
}

#[test]
fn calculix_finds_the_modulus_of_the_other_meshes_in_a_conforming_one_of_a_periodic_box() {
    let model = packed([true; 3]);
    let mut moduli = Vec::new();
    for method in [Method::CONFORMING, Method::Voxel { thin_itz: false, subsamples: 4 }, Method::FITTED] {
        let options = MeshOptions { itz: ItzForm::None, ..as_stiff(method) };
        let Some(mesh) = meshed(&model, options) else { return };
        let Some(solved) = solve_deck(&deck(&mesh, &tied(Analysis::Elastic))) else { return };
        moduli.push(modulus(&solved));
    }
    let [least, most] = [f64::min, f64::max].map(|pick| moduli.iter().copied().reduce(pick).unwrap());
    assert!(most / least < 1.03, "{moduli:?}");
}

#[test]
fn springs_in_place_of_cohesive_elements_give_the_bonded_modulus_of_a_conforming_mesh_too() {
    let model = packed([true; 3]);
    let Some(bonded) = conforming(&model, ItzForm::None, 4.0) else { return };
    let joined = conforming(&model, ItzForm::Cohesive, 4.0).unwrap();
    let Some(bonded) = modulus_by_force(&deck(&bonded, &tied(Analysis::Elastic))) else { return };
    let joined = modulus_by_force(&with_springs(&joined, &deck(&joined, &tied(Analysis::Elastic)), 1e10)).unwrap();
    assert!((joined / bonded - 1.0).abs() < 1e-5, "{joined}, bonded {bonded}");
}
