//! How far the inner side of a solid ITZ lies from the exact one: that of the aggregate's half-space erosion by the ITZ's
//! thickness. For the tests and for the bench of conforming meshes.

#![allow(dead_code, reason = "each program asks for one of the two errors")]

use meso_core::Model;
use meso_core::geometry::Triangles;
use meso_core::math::Vec3;
use meso_core::mesh::{Mesh, Phase};

/// How far the layer's inner side lies from the surface of the exact inward offset.
#[derive(Debug)]
pub(crate) struct LayerErrors {
    pub(crate) area_mm2: f64,
    /// Over the area of the inner side.
    pub(crate) rms_mm: f64,
}

impl LayerErrors {
    /// Of tetrahedra.
    pub(crate) fn of(mesh: &Mesh, model: &Model) -> Self {
        let (mut squares, mut area) = (0.0, 0.0);
        for (id, corners) in inner_side(mesh) {
            let aggregate = &model.aggregates[id as usize];
            let height = |x: Vec3| aggregate.body.height(&x) + aggregate.itz_thickness_mm;
            let triangle = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).norm() / 2.0;
            squares += triangle * points_of(corners).map(|x| height(x).powi(2)).sum::<f64>() / (PARTS * PARTS) as f64;
            area += triangle;
        }
        Self { area_mm2: area, rms_mm: (squares / area).sqrt() }
    }
}

/// Difference of the layer's thickness from the one asked for, as a share of it: root mean square over the area of the inner side.
///
/// The thickness is the distance to the mesh's own outer side, which chords over a surface move with the inner one.
pub(crate) fn thickness_error(mesh: &Mesh, model: &Model) -> f64 {
    let mut outer = vec![Vec::new(); model.aggregates.len()];
    outer_side(mesh).into_iter().for_each(|(id, corners)| outer[id as usize].push(corners));
    let outer: Vec<Triangles> = outer.into_iter().map(Triangles::new).collect();
    let (mut squares, mut area) = (0.0, 0.0);
    for (id, corners) in inner_side(mesh) {
        let asked = model.aggregates[id as usize].itz_thickness_mm;
        let distance = |x: Vec3| outer[id as usize].nearest(&x).expect("a layer has an outer side").1;
        let triangle = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).norm() / 2.0;
        let error = |x: Vec3| (distance(x) / asked - 1.0).powi(2);
        squares += triangle * points_of(corners).map(error).sum::<f64>() / (PARTS * PARTS) as f64;
        area += triangle;
    }
    (squares / area).sqrt()
}

/// Parts of a triangle's edge.
const PARTS: u32 = 6;

/// The centroids of the equal triangles that a triangle is cut into, [`PARTS`] along each edge.
fn points_of([a, b, c]: [Vec3; 3]) -> impl Iterator<Item = Vec3> {
    let upright = (0..PARTS).flat_map(|i| (0..PARTS - i).map(move |j| (3 * i + 1, 3 * j + 1)));
    let turned = (1..PARTS).flat_map(|i| (0..PARTS - i).map(move |j| (3 * i - 1, 3 * j + 2)));
    let share = f64::from(3 * PARTS);
    upright.chain(turned).map(move |(i, j)| a + (b - a) * (f64::from(i) / share) + (c - a) * (f64::from(j) / share))
}

/// A triangle by its nodes, with the aggregate and the phase of its cell.
type Side = ([u32; 3], u32, Phase);

/// The sides of all cells of layers and cores, sorted: those of one triangle follow each other.
fn sides(mesh: &Mesh) -> Vec<Side> {
    let mut sides = Vec::new();
    for ((cell, phase), id) in mesh.cells().zip(&mesh.phase).zip(&mesh.owner) {
        for face in mesh.kind.faces().iter().filter(|_| *phase != Phase::Mortar) {
            let mut nodes = [0, 1, 2].map(|i| cell[face[i]]);
            nodes.sort_unstable();
            sides.push((nodes, *id, *phase));
        }
    }
    sides.sort_unstable();
    sides
}

/// The triangles for which `is_wanted` is true of the cells on their sides, with their aggregate.
fn triangles(mesh: &Mesh, is_wanted: impl Fn(&[Side]) -> bool) -> Vec<(u32, [Vec3; 3])> {
    let sides = sides(mesh);
    let wanted = sides.chunk_by(|p, q| (p.0, p.1) == (q.0, q.1)).filter(|cells| is_wanted(cells));
    wanted.map(|cells| (cells[0].1, cells[0].0.map(|node| mesh.points[node as usize]))).collect()
}

/// The triangles between an aggregate's core and its layer.
fn inner_side(mesh: &Mesh) -> Vec<(u32, [Vec3; 3])> {
    triangles(mesh, |cells| cells.len() == 2 && cells[0].2 != cells[1].2)
}

/// The triangles between an aggregate's layer and the mortar.
fn outer_side(mesh: &Mesh) -> Vec<(u32, [Vec3; 3])> {
    triangles(mesh, |cells| cells.len() == 1 && cells[0].2 == Phase::Itz)
}
