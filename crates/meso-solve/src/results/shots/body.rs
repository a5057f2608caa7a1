//! The specimen's surface in few triangles, to be deformed.

use super::place;
use meso_collision::math::Aabb;
use meso_mesh::Mesh;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Most corners; a surface of more is drawn by one corner in each cell of a coarse grid.
const MOST_CORNERS: usize = 16_000;
/// Cells of this grid along the longest side.
const COARSE: f64 = 48.0;

/// Corners and triangles of a surface.
pub(crate) struct Body {
    /// The node of each corner.
    nodes: Vec<u32>,
    /// Places of the corners.
    pub(crate) corners: Vec<[u16; 3]>,
    /// Corners of the triangles.
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Body {
    pub(crate) fn of(mesh: &Mesh) -> Self {
        let triangles = outside(mesh);
        let aabb = Aabb::around(&mesh.points);
        let mut nodes: Vec<u32> = triangles.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let step = aabb.size().max() / COARSE;
        let cell = |node: u32| {
            let at = (mesh.points[node as usize] - aabb.min) / step;
            [0, 1, 2].map(|axis| at[axis].round() as u32)
        };
        let is_fine = nodes.len() > MOST_CORNERS;
        let key = |node: u32| if is_fine { cell(node) } else { [node, 0, 0] };
        let mut corner_of = BTreeMap::new();
        let mut corners = Vec::new();
        for &node in &nodes {
            corner_of.entry(key(node)).or_insert_with(|| {
                corners.push(node);
                corners.len() as u32 - 1
            });
        }
        let mut triangles: Vec<[u32; 3]> = triangles
            .into_iter()
            .map(|triangle| triangle.map(|node| corner_of[&key(node)]))
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect();
        triangles.sort_unstable();
        triangles.dedup();
        Self {
            corners: corners.iter().map(|&node| place(&mesh.points[node as usize], &aabb)).collect(),
            nodes: corners,
            triangles,
        }
    }

    /// The nodes of the corners.
    pub(super) fn nodes(&self) -> impl Iterator<Item = u32> {
        self.nodes.iter().copied()
    }
}

/// The faces that only one cell has, as triangles.
///
/// The numbers of the two cells' shares of a face cancel in the sum of the face's lowest node. So only faces at nodes
/// with another sum are compared.
fn outside(mesh: &Mesh) -> Vec<[u32; 3]> {
    let faces = mesh.kind.faces();
    let cells = || mesh.cells.par_chunks_exact(mesh.kind.nodes());
    let of_cell = |cell| faces.iter().map(move |face| keyed(cell, face));
    let sums: Vec<AtomicU64> = mesh.points.iter().map(|_| AtomicU64::new(0)).collect();
    let sum = |key: &[u32; 4]| &sums[key[0] as usize];
    let add = |(key, _): ([u32; 4], _)| {
        sum(&key).fetch_xor(number(&key), Relaxed);
    };
    cells().for_each(|cell| of_cell(cell).for_each(add));
    let at_outside = |cell| of_cell(cell).filter(|(key, _)| sum(key).load(Relaxed) != 0);
    let mut open: Vec<([u32; 4], [u32; 4])> = cells().flat_map_iter(at_outside).collect();
    open.par_sort_unstable();
    let single = open.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1);
    let corners = faces.first().map_or(3, |face| face.len());
    let triangles = |same: &[([u32; 4], [u32; 4])]| {
        let face = same[0].1;
        (2..corners).map(move |i| [face[0], face[i - 1], face[i]])
    };
    single.flat_map(triangles).collect()
}

/// A number that faces hardly ever have in common.
fn number(key: &[u32; 4]) -> u64 {
    key.iter().fold(0, |hash, &node| {
        let mixed = (hash ^ u64::from(node)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed ^ mixed >> 32
    })
}

/// A face with a key that both cells at it share.
fn keyed(cell: &[u32], face: &[usize]) -> ([u32; 4], [u32; 4]) {
    let mut corners = [u32::MAX; 4];
    corners.iter_mut().zip(face).for_each(|(corner, &i)| *corner = cell[i]);
    let mut key = corners;
    key.sort_unstable();
    (key, corners)
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_concrete::specimen::Specimen;
    use meso_mesh::{ItzForm, MeshOptions, Method, Tools};

    fn body(side_mm: f64, element_size_mm: f64) -> Body {
        let options =
            MeshOptions { method: Method::FITTED, element_size_mm, itz: ItzForm::None, ..MeshOptions::default() };
        Body::of(&meso_mesh::build((&[], &Specimen::cube(side_mm)), &options, &Tools::default()).unwrap())
    }

    /// Area over that of a face of the box.
    fn area(body: &Body) -> f64 {
        let at = |corner: u32| body.corners[corner as usize].map(|place| f64::from(place) / 65_535.0);
        let of = |&[a, b, c]: &[u32; 3]| {
            let [a, b, c] = [a, b, c].map(at);
            let [u, v] = [b, c].map(|x| [0, 1, 2].map(|i| x[i] - a[i]));
            let cross = [0, 1, 2].map(|i| u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]);
            cross.iter().map(|x| x * x).sum::<f64>().sqrt() / 2.0
        };
        body.triangles.iter().map(of).sum()
    }

    #[test]
    fn a_cube_has_the_surface_of_its_six_sides() {
        assert!((area(&body(10.0, 2.0)) - 6.0).abs() < 1e-3);
    }

    #[test]
    fn a_fine_surface_is_drawn_by_few_corners_and_stays_closed() {
        let body = body(60.0, 1.0);
        assert!(body.corners.len() < MOST_CORNERS, "{}", body.corners.len());
        assert!((area(&body) - 6.0).abs() < 0.1, "{}", area(&body));
    }
}
