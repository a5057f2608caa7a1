//! The connected parts of the surface that bounds mortar in a periodic box.

use crate::math::{Aabb, Vec3};
use crate::mesh::MeshError;
use std::collections::BTreeMap;

/// A closed surface.
#[derive(Default)]
pub(super) struct Part {
    /// Its triangles by what they are part of.
    pub(super) sheets: BTreeMap<Option<usize>, Vec<[u32; 3]>>,
}

/// The parts of the surface that `sheets` make, their triangles counter-clockwise from outside or all from inside; the one
/// with the most triangles first.
///
/// # Errors
/// Says where the surface is open.
pub(super) fn parts(
    sheets: impl Iterator<Item = (Option<usize>, Vec<[u32; 3]>)>,
    points: &[Vec3],
) -> Result<Vec<Part>, MeshError> {
    let of_sheet = |(sheet, triangles): (Option<usize>, Vec<[u32; 3]>)| triangles.into_iter().map(move |t| (sheet, t));
    let triangles: Vec<(Option<usize>, [u32; 3])> = sheets.flat_map(of_sheet).collect();
    let mut sides: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * triangles.len());
    for (index, (_, [a, b, c])) in (0..).zip(&triangles) {
        sides.extend([[a, b], [b, c], [c, a]].map(|[a, b]| ([*a.min(b), *a.max(b)], index)));
    }
    sides.sort_unstable();
    let mut root: Vec<u32> = (0..triangles.len() as u32).collect();
    for pair in sides.chunk_by(|a, b| a.0 == b.0) {
        let [(_, a), (_, b)] = *pair else {
            return Err(MeshError::triangulation("the surface for gmsh is open", &points[pair[0].0[0] as usize]));
        };
        let (a, b) = (find(&mut root, a), find(&mut root, b));
        root[a.max(b) as usize] = a.min(b);
    }
    let mut parts: BTreeMap<u32, Part> = BTreeMap::new();
    for (index, (sheet, triangle)) in (0..).zip(triangles) {
        let part = parts.entry(find(&mut root, index)).or_default();
        part.sheets.entry(sheet).or_default().push(triangle);
    }
    let mut parts: Vec<Part> = parts.into_values().collect();
    parts.sort_by_key(|part| std::cmp::Reverse(part.triangles().count()));
    Ok(parts)
}

fn find(root: &mut [u32], mut index: u32) -> u32 {
    while root[index as usize] != index {
        root[index as usize] = root[root[index as usize] as usize];
        index = root[index as usize];
    }
    index
}

/// The index of the part around `place`, which lies in one: the first where no other holds it.
pub(super) fn around(parts: &[Part], place: &Vec3, points: &[Vec3]) -> usize {
    let holds = |part: &Part| part.winding(place, points) > 0.5;
    (1..parts.len()).find(|&index| holds(&parts[index])).unwrap_or(0)
}

impl Part {
    fn triangles(&self) -> impl Iterator<Item = &[u32; 3]> {
        self.sheets.values().flatten()
    }

    /// How often the surface goes around `place`: its solid angle over that of a sphere (van Oosterom and Strackee 1983).
    fn winding(&self, place: &Vec3, points: &[Vec3]) -> f64 {
        let aabb = Aabb::around(self.triangles().flatten().map(|&node| &points[node as usize]));
        if !aabb.intersects(&Aabb { min: *place, max: *place }) {
            return 0.0;
        }
        let angle = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|node| points[node as usize] - place);
            let [x, y, z] = [a.norm(), b.norm(), c.norm()];
            2.0 * libm::atan2(a.dot(&b.cross(&c)), x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y)
        };
        self.triangles().map(angle).sum::<f64>().abs() / (4.0 * std::f64::consts::PI)
    }
}
