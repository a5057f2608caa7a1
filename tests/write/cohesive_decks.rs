//! Cohesive decks in a solver that we did not write. CalculiX has no cohesive elements: springs between the nodes they
//! join stand in for them. (Skipped where `ccx` is not installed.)

use crate::mesh::voxel::deck;
use crate::write::calculix::{AREA_MM2, elastic, modulus, modulus_of, packed};
use crate::write::periodic_decks::{self, modulus_by_force, tied};
use meso_core::export::abaqus::Analysis;
use meso_core::mesh::{self, ItzForm, Mesh, MeshOptions, Method, Tools};
use std::collections::BTreeSet;

/// `text` with a spring of `stiffness` N/mm in every direction between every two nodes that a cohesive element joins.
pub(crate) fn with_springs(mesh: &Mesh, text: &str, stiffness: f64) -> String {
    let kind = text.find("*ELEMENT, TYPE=COH3D").unwrap();
    let after = kind + text[kind..].find("\n*NSET").unwrap() + 1;
    let material = text.find("*MATERIAL, NAME=ITZ").unwrap();
    let section = text.find("*SOLID SECTION").unwrap();
    let cohesive_section = text.find("*COHESIVE SECTION").unwrap();
    let rest = &text[cohesive_section..];
    let rest = &rest[rest.find("\n1.0,\n").unwrap() + "\n1.0,\n".len()..];
    let (elements, sections) = (springs(mesh), spring_sections(stiffness));
    [&text[..kind], &elements, &text[after..material], &text[section..cohesive_section], &sections, rest].concat()
}

fn springs(mesh: &Mesh) -> String {
    let joined = mesh.cohesive().flat_map(|nodes| {
        let (bottom, top) = nodes.split_at(nodes.len() / 2);
        bottom.iter().copied().zip(top.iter().copied()).collect::<Vec<_>>()
    });
    let joined: BTreeSet<(u32, u32)> = joined.collect();
    let mut number = mesh.cell_count() + mesh.cohesive().len();
    let mut lines = String::new();
    for direction in 1..=3 {
        lines += &format!("*ELEMENT, TYPE=SPRING2, ELSET=SPRING{direction}\n");
        for (below, above) in &joined {
            number += 1;
            lines += &format!("{number}, {}, {}\n", below + 1, above + 1);
        }
    }
    lines
}

/// Stiffnesses have a decimal point: CalculiX distinguishes them from directions by it.
fn spring_sections(stiffness: f64) -> String {
    (1..=3).map(|i| format!("*SPRING, ELSET=SPRING{i}\n{i}, {i}\n{stiffness:.1e}\n")).collect()
}

#[test]
fn springs_in_place_of_cohesive_elements_give_the_bonded_modulus_when_stiff_and_a_lower_one_when_soft() {
    let model = packed();
    for method in [Method::VOXEL, Method::FITTED] {
        let meshed = |itz| {
            let options = MeshOptions { method, itz, element_size_mm: 4.0, ..Default::default() };
            mesh::build(&model, &options, &Tools::default()).unwrap()
        };
        let Some(bonded) = modulus(&meshed(ItzForm::None), AREA_MM2) else { return };
        let apart = meshed(ItzForm::Cohesive);
        let text = deck(&apart, &elastic());
        let [stiff, soft] = [1e10, 1.0].map(|k| modulus_of(&with_springs(&apart, &text, k), &[], AREA_MM2).unwrap());
        // A node without its spring, or with another's, would show here: the grains would hang on fewer nodes.
        assert!((stiff / bonded - 1.0).abs() < 1e-5, "{method:?}: {stiff}, bonded {bonded}");
        assert!(soft < 0.7 * bonded, "{method:?}: {soft}, bonded {bonded}");
    }
}

#[test]
fn springs_in_place_of_cohesive_elements_give_the_bonded_modulus_of_a_periodic_box_too() {
    let model = periodic_decks::packed([true; 3]);
    for method in [Method::VOXEL, Method::PLAIN] {
        let text = |itz| {
            let options = MeshOptions { method, itz, element_size_mm: 3.0, ..Default::default() };
            let mesh = mesh::build(&model, &options, &Tools::default()).unwrap();
            let text = deck(&mesh, &tied(Analysis::Elastic));
            if itz == ItzForm::Cohesive { with_springs(&mesh, &text, 1e10) } else { text }
        };
        let Some(bonded) = modulus_by_force(&text(ItzForm::None)) else { return };
        // The energy is that of aggregates and mortar.
        let joined = modulus_by_force(&text(ItzForm::Cohesive)).unwrap();
        assert!((joined / bonded - 1.0).abs() < 1e-5, "{method:?}: {joined}, bonded {bonded}");
    }
}
