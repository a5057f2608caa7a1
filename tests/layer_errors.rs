//! How far the inner side of a solid ITZ lies from the exact one: that of the aggregate's half-space erosion by the ITZ's
//! thickness. For the tests and for the bench of conforming meshes.

use meso_core::Model;
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

/// Parts of a triangle's edge.
const PARTS: u32 = 6;

/// The centroids of the equal triangles that a triangle is cut into, [`PARTS`] along each edge.
fn points_of([a, b, c]: [Vec3; 3]) -> impl Iterator<Item = Vec3> {
    let upright = (0..PARTS).flat_map(|i| (0..PARTS - i).map(move |j| (3 * i + 1, 3 * j + 1)));
    let turned = (1..PARTS).flat_map(|i| (0..PARTS - i).map(move |j| (3 * i - 1, 3 * j + 2)));
    let share = f64::from(3 * PARTS);
    upright.chain(turned).map(move |(i, j)| a + (b - a) * (f64::from(i) / share) + (c - a) * (f64::from(j) / share))
}

/// The triangles between an aggregate's core and its layer, with its id; by their nodes.
fn inner_side(mesh: &Mesh) -> Vec<(u32, [Vec3; 3])> {
    let mut sides = Vec::new();
    for ((cell, phase), id) in mesh.cells().zip(&mesh.phase).zip(&mesh.owner) {
        for face in mesh.kind.faces().iter().filter(|_| *phase != Phase::Mortar) {
            let mut nodes = [0, 1, 2].map(|i| cell[face[i]]);
            nodes.sort_unstable();
            sides.push((nodes, *id, *phase));
        }
    }
    sides.sort_unstable();
    let between =
        |pair: &&[([u32; 3], u32, Phase)]| pair[0].0 == pair[1].0 && pair[0].1 == pair[1].1 && pair[0].2 != pair[1].2;
    let inner = sides.windows(2).filter(between);
    inner.map(|pair| (pair[0].1, pair[0].0.map(|node| mesh.points[node as usize]))).collect()
}
