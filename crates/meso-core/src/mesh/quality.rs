//! How good a mesh is: the angles and shapes of its cells, and the report on them.

mod report;

pub use report::{BAD_DEG, DIHEDRAL_BINS, QualityReport};

use super::volumes::cell_volume;
use super::{CellKind, Mesh};
use crate::math::Vec3;
use crate::stop;
use rayon::prelude::*;

/// One cell's measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellQuality {
    /// Smallest angle between two faces, degrees; 90 for voxels.
    pub min_dihedral_deg: f64,
    /// Largest angle between two faces, degrees.
    pub max_dihedral_deg: f64,
    /// Three times the inscribed over the circumscribed sphere's radius; 1 for the regular tetrahedron and for voxels.
    pub radius_ratio: f64,
    /// Shortest distance from a node (a face) to the opposite face, mm.
    pub shortest_altitude_mm: f64,
    /// mm3; negative where the nodes are out of order.
    pub volume_mm3: f64,
}

/// Every cell's measures, in the cells' order.
pub fn cells(mesh: &Mesh) -> Vec<CellQuality> {
    mesh.cells.par_chunks_exact(mesh.kind.nodes()).map(|cell| measured(mesh, cell)).collect()
}

fn measured(mesh: &Mesh, cell: &[u32]) -> CellQuality {
    stop::point();
    match mesh.kind {
        CellKind::Hexahedron => voxel(cell, mesh),
        _ => tetrahedron([0, 1, 2, 3].map(|i| mesh.points[cell[i] as usize])),
    }
}

/// The cells whose smallest dihedral angle lies below `degrees`, as indices.
pub fn bad_cells(cells: &[CellQuality], degrees: f64) -> Vec<usize> {
    (0..).zip(cells).filter(|(_, q)| q.min_dihedral_deg < degrees).map(|(index, _)| index).collect()
}

/// Smallest and largest cosine of a tetrahedron's dihedral angles.
///
/// With outward face vectors n_i (of twice the area), the angle at the edge shared by faces i and j has the cosine
/// -n_i . n_j / |n_i| |n_j|.
pub(crate) fn dihedral_cosines(p: [Vec3; 4]) -> [f64; 2] {
    let normals = face_vectors(p).map(|n| n / n.norm());
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    for i in 0..4 {
        for j in 0..i {
            let cosine = -normals[i].dot(&normals[j]);
            range = [range[0].min(cosine), range[1].max(cosine)];
        }
    }
    range
}

/// Outward vectors of twice the area, the face opposite to node i at i.
fn face_vectors([a, b, c, d]: [Vec3; 4]) -> [Vec3; 4] {
    let cross = |u: Vec3, v: Vec3, w: Vec3| (v - u).cross(&(w - u));
    [cross(b, c, d), cross(a, d, c), cross(a, b, d), cross(a, c, b)]
}

/// Shortest altitude of the tetrahedron with these corners, mm: six times its volume over twice its largest face's area.
pub(crate) fn shortest_altitude(p: [Vec3; 4]) -> f64 {
    let six_volumes = (p[1] - p[0]).cross(&(p[2] - p[0])).dot(&(p[3] - p[0]));
    six_volumes / face_vectors(p).map(|n| n.norm_squared()).into_iter().fold(0.0, f64::max).sqrt()
}

/// Measures of the tetrahedron with these corners, mm.
pub fn tetrahedron(p: [Vec3; 4]) -> CellQuality {
    let degrees = |cosine: f64| libm::acos(cosine.clamp(-1.0, 1.0)).to_degrees();
    let [low, high] = dihedral_cosines(p);
    let areas = face_vectors(p).map(|n| n.norm() / 2.0);
    let volume = (p[1] - p[0]).cross(&(p[2] - p[0])).dot(&(p[3] - p[0])) / 6.0;
    let inscribed = 3.0 * volume / areas.iter().sum::<f64>();
    CellQuality {
        min_dihedral_deg: degrees(high),
        max_dihedral_deg: degrees(low),
        radius_ratio: 3.0 * inscribed / circumradius(p),
        shortest_altitude_mm: shortest_altitude(p),
        volume_mm3: volume,
    }
}

/// |u^2 (v x w) + v^2 (w x u) + w^2 (u x v)| / (2 |u . v x w|), edges from the first corner.
fn circumradius([a, b, c, d]: [Vec3; 4]) -> f64 {
    let (u, v, w) = (b - a, c - a, d - a);
    let numerator = v.cross(&w) * u.norm_squared() + w.cross(&u) * v.norm_squared() + u.cross(&v) * w.norm_squared();
    numerator.norm() / (2.0 * u.dot(&v.cross(&w)).abs())
}

/// Measures of a box-shaped hexahedron.
fn voxel(cell: &[u32], mesh: &Mesh) -> CellQuality {
    let edge = |i: usize| (mesh.points[cell[i] as usize] - mesh.points[cell[0] as usize]).norm();
    CellQuality {
        min_dihedral_deg: 90.0,
        max_dihedral_deg: 90.0,
        radius_ratio: 1.0,
        shortest_altitude_mm: edge(1).min(edge(3)).min(edge(4)),
        volume_mm3: cell_volume(mesh.kind, cell, &mesh.points),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_regular_tetrahedron_has_the_known_angle_and_ratio_one() {
        let p = [[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0], [-1.0, -1.0, 1.0]].map(Vec3::from);
        let q = tetrahedron(p);
        assert!((q.min_dihedral_deg - 70.528_779_365_509_31).abs() < 1e-9, "{q:?}");
        assert!((q.max_dihedral_deg - q.min_dihedral_deg).abs() < 1e-9);
        assert!((q.radius_ratio - 1.0).abs() < 1e-12);
        assert!((q.volume_mm3 - 8.0 / 3.0).abs() < 1e-12);
        assert!((q.shortest_altitude_mm - 4.0 / 3.0_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_flat_tetrahedron_has_angles_near_zero_and_180() {
        let p = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, 0.3, 1e-4]].map(Vec3::from);
        let q = tetrahedron(p);
        assert!(q.min_dihedral_deg < 0.05 && q.max_dihedral_deg > 179.9);
        assert!((q.shortest_altitude_mm - 1e-4).abs() < 1e-8);
    }
}
