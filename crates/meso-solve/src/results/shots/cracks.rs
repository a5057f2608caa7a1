//! Surfaces of the cracks: where the opening, as a continuous field, has one value.
//!
//! Nodes take the mean opening of the mortar's cells around them. In each tetrahedron the field is linear, and a plane piece of
//! one or two triangles parts nodes above the value from those below; a box is six tetrahedra around its diagonal.

use super::{packed, place};
use meso_collision::math::{Aabb, Vec3};
use meso_mesh::{Mesh, Phase};
use meso_view::embedded::base64;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Openings below this are no cracks, mm.
const LEAST_MM: f32 = 0.002;
/// Share of the nodes that the surfaces enclose at most: distributed cracks would hide those that split the specimen. A share
/// of the widest opening would show a few crumbs alone, which are open by millimetres at the end of a test.
const ENCLOSED: f64 = 0.06;
/// Most tetrahedra that a surface passes through: the page stays below 15 MB.
const MOST_CELLS: usize = 50_000;
/// Factor by which the value rises until the surface is small enough.
const RISE: f32 = 1.25;

/// A surface around the cracks of a moment, as a page holds it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Cracks {
    /// Opening on the surface, and the widest of a cell, mm.
    pub(crate) openings_mm: [f32; 2],
    /// Number of triangles.
    pub(crate) count: usize,
    /// In base64: places of the corners, the opening inside at each as a share of the widest, displacements, and triangles.
    pub(crate) corners: String,
    pub(crate) openings: String,
    pub(crate) moved: String,
    pub(crate) triangles: String,
}

impl Cracks {
    /// The cracks of a moment; `None` where no crack is open enough.
    pub(super) fn of(mesh: &Mesh, opening_mm: &[f32], displacement: &[[f32; 3]], most_mm: f32) -> Option<Self> {
        let widest = opening_mm.iter().copied().fold(0.0, f32::max);
        let nodal = at_nodes(mesh, opening_mm);
        let most = nodal.iter().copied().fold(0.0, f32::max);
        let mut level = LEAST_MM.max(exceeded(&nodal));
        while most > level && crossed(mesh, &nodal, level).nth(MOST_CELLS).is_some() {
            level *= RISE;
        }
        let surface = Surface::of(mesh, &nodal, level);
        if surface.triangles.is_empty() {
            return None;
        }
        let aabb = Aabb::around(&mesh.points);
        let corners = surface.points.iter().flat_map(|(edge, t)| {
            let [a, b]: [Vec3; 2] = edge.map(|node| mesh.points[node as usize]);
            place(&(a + (b - a) * f64::from(*t)), &aabb)
        });
        let moved = surface.points.iter().map(|(edge, t)| {
            let [a, b] = edge.map(|node| displacement[node as usize]);
            [0, 1, 2].map(|axis| a[axis] + t * (b[axis] - a[axis]))
        });
        let inside = surface.points.iter().map(|(edge, _)| edge.map(|node| nodal[node as usize]));
        let triangles = surface.triangles.iter().flatten();
        Some(Self {
            openings_mm: [level, widest],
            count: surface.triangles.len(),
            corners: base64(&corners.flat_map(u16::to_le_bytes).collect::<Vec<u8>>()),
            openings: base64(&inside.map(|[a, b]| (255.0 * a.max(b) / most) as u8).collect::<Vec<u8>>()),
            moved: packed(moved, most_mm),
            triangles: base64(&triangles.copied().flat_map(u32::to_le_bytes).collect::<Vec<u8>>()),
        })
    }
}

/// The opening that a share of [`ENCLOSED`] of the nodes exceeds, mm.
fn exceeded(nodal: &[f32]) -> f32 {
    let mut sorted = nodal.to_vec();
    let place = ((1.0 - ENCLOSED) * sorted.len() as f64) as usize;
    if place >= sorted.len() {
        return 0.0;
    }
    *sorted.select_nth_unstable_by(place, f32::total_cmp).1
}

/// Mean opening of the cells of mortar, ITZ and broken bodies around every node; 0 inside sound bodies.
fn at_nodes(mesh: &Mesh, opening_mm: &[f32]) -> Vec<f32> {
    let (mut sum, mut count) = (vec![0.0_f32; mesh.points.len()], vec![0_u32; mesh.points.len()]);
    for ((cell, opening), phase) in mesh.cells().zip(opening_mm).zip(&mesh.phase) {
        if matches!(phase, Phase::Mortar | Phase::Itz) || *opening > 0.0 {
            for &node in cell {
                sum[node as usize] += opening;
                count[node as usize] += 1;
            }
        }
    }
    sum.iter().zip(count).map(|(sum, count)| if count > 0 { sum / count as f32 } else { 0.0 }).collect()
}

/// The tetrahedra with nodes on both sides of `level`.
fn crossed<'a>(mesh: &'a Mesh, nodal: &'a [f32], level: f32) -> impl Iterator<Item = [u32; 4]> {
    let parts = mesh.kind.tetrahedra();
    let is_above = move |&node: &u32| nodal[node as usize] >= level;
    let mixed = move |nodes: &[u32; 4]| {
        let above = nodes.iter().filter(|node| is_above(node)).count();
        above > 0 && above < 4
    };
    mesh.cells().flat_map(move |cell| parts.iter().map(move |part| part.map(|i| cell[i]))).filter(mixed)
}

/// Triangles whose corners lie on edges of the mesh.
#[derive(Default)]
struct Surface {
    /// The edge of each corner, and its place from the first end to the second one, 0 to 1.
    points: Vec<([u32; 2], f32)>,
    triangles: Vec<[u32; 3]>,
}

impl Surface {
    fn of(mesh: &Mesh, nodal: &[f32], level: f32) -> Self {
        let mut surface = Self::default();
        let mut numbers = BTreeMap::new();
        for nodes in crossed(mesh, nodal, level) {
            let (above, below): (Vec<u32>, Vec<u32>) = nodes.iter().partition(|&&node| nodal[node as usize] >= level);
            let mut corner = |a: u32, b: u32| {
                let edge = [a.min(b), a.max(b)];
                *numbers.entry(edge).or_insert_with(|| {
                    let [from, to] = edge.map(|node| nodal[node as usize]);
                    surface.points.push((edge, (level - from) / (to - from)));
                    surface.points.len() as u32 - 1
                })
            };
            match (&above[..], &below[..]) {
                (&[a], &[b, c, d]) | (&[b, c, d], &[a]) => {
                    let triangle = [corner(a, b), corner(a, c), corner(a, d)];
                    surface.triangles.push(triangle);
                }
                (&[a, b], &[c, d]) => {
                    let [ac, ad, bd, bc] = [corner(a, c), corner(a, d), corner(b, d), corner(b, c)];
                    surface.triangles.extend([[ac, ad, bd], [ac, bd, bc]]);
                }
                _ => {}
            }
        }
        surface
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_concrete::specimen::Specimen;
    use meso_mesh::{ItzForm, MeshOptions, Method, Tools};

    fn mesh(method: Method) -> Mesh {
        let options = MeshOptions { method, element_size_mm: 2.0, itz: ItzForm::None, ..MeshOptions::default() };
        meso_mesh::build((&[], &Specimen::cube(20.0)), &options, &Tools::default()).unwrap()
    }

    /// Edges of the triangles, with the number of triangles at each.
    fn edges(surface: &Surface) -> BTreeMap<[u32; 2], usize> {
        let mut edges = BTreeMap::new();
        for &[a, b, c] in &surface.triangles {
            for [a, b] in [[a, b], [b, c], [c, a]] {
                *edges.entry([a.min(b), a.max(b)]).or_default() += 1;
            }
        }
        edges
    }

    #[test]
    fn a_surface_inside_the_mesh_is_closed_and_lies_where_the_field_has_its_value() {
        for method in [Method::FITTED, Method::VOXEL] {
            let mesh = mesh(method);
            // Falls from 10 at the centre by 1 a millimetre.
            let distance = |x: &Vec3| (x - Vec3::repeat(10.0)).norm();
            let nodal: Vec<f32> = mesh.points.iter().map(|x| (10.0 - distance(x)) as f32).collect();
            let surface = Surface::of(&mesh, &nodal, 4.0);
            assert!(surface.triangles.len() > 100);
            assert!(edges(&surface).values().all(|&count| count == 2), "{method:?}");
            for (edge, t) in &surface.points {
                let [a, b] = edge.map(|node| mesh.points[node as usize]);
                let off = distance(&(a + (b - a) * f64::from(*t))) - 6.0;
                assert!(off.abs() < 0.4, "{off}");
            }
        }
    }

    #[test]
    fn a_mesh_without_an_open_crack_has_no_surface() {
        let mesh = mesh(Method::FITTED);
        let moved = vec![[0.0; 3]; mesh.points.len()];
        assert!(Cracks::of(&mesh, &vec![0.0; mesh.cell_count()], &moved, 1.0).is_none());
        let mut opening = vec![0.0; mesh.cell_count()];
        opening[mesh.cell_count() / 2] = 0.1;
        let cracks = Cracks::of(&mesh, &opening, &moved, 1.0).unwrap();
        assert!(cracks.count > 0 && cracks.openings_mm[1] == 0.1);
    }
}
