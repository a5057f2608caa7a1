//! The mesh itself: nodes, cells, and the body that owns each cell; and the measures of one tetrahedron.

use crate::cells::{CellKind, Cells, drop_lone_nodes, volume};
use meso_collision::math::Vec3;

/// A cell that was removed; [`TetMesh::drop_removed`] takes it out.
const REMOVED: [u32; 4] = [u32::MAX; 4];

/// A tetrahedral mesh.
#[derive(Clone, Debug, Default)]
pub(crate) struct TetMesh {
    /// Positions, mm.
    pub(crate) points: Vec<Vec3>,
    /// Node indices; positive volume in Abaqus' order.
    pub(crate) cells: Vec<[u32; 4]>,
    /// Index of the body (an aggregate, a fibre, a void, or an image of one) that each cell lies in, or
    /// [`NO_BODY`](crate::cells::NO_BODY) in the mortar.
    pub(crate) owner: Vec<u32>,
}

impl TetMesh {
    /// The cells by their bodies' indices.
    pub(crate) fn by_body(&self) -> Cells<'_> {
        Cells {
            kind: CellKind::Tetrahedron,
            points: &self.points,
            nodes: self.cells.as_flattened(),
            owner: &self.owner,
        }
    }

    pub(crate) fn position(&self, node: u32) -> Vec3 {
        self.points[node as usize]
    }

    pub(crate) fn cell(&self, cell: u32) -> [u32; 4] {
        self.cells[cell as usize]
    }

    /// The nodes of a cell, and its owner.
    pub(crate) fn owned(&self, cell: u32) -> ([u32; 4], u32) {
        (self.cells[cell as usize], self.owner[cell as usize])
    }

    pub(crate) fn corners(&self, nodes: [u32; 4]) -> [Vec3; 4] {
        // By name: `map` is a call for each in the tests' profile, and this is where meshing spends its time.
        let [a, b, c, d] = nodes;
        [self.position(a), self.position(b), self.position(c), self.position(d)]
    }

    /// The [`min_dihedral_cos2`] of a cell.
    pub(crate) fn cos2(&self, cell: u32) -> f64 {
        min_dihedral_cos2(self.corners(self.cell(cell)))
    }

    /// The [`min_dihedral_cos2`] of the worst of `cells`.
    pub(crate) fn worst(&self, cells: impl IntoIterator<Item = u32>) -> f64 {
        cells.into_iter().map(|cell| self.cos2(cell)).fold(-1.0, f64::max)
    }

    /// Volume of a cell, mm3.
    #[cfg(test)]
    pub(crate) fn volume(&self, cell: u32) -> f64 {
        volume(self.corners(self.cell(cell)))
    }

    /// The numbers of all cells.
    pub(crate) fn numbers(&self) -> std::ops::Range<u32> {
        0..self.cells.len() as u32
    }

    /// Adds a cell; its number.
    pub(crate) fn push(&mut self, nodes: [u32; 4], owner: u32) -> u32 {
        self.cells.push(nodes);
        self.owner.push(owner);
        self.cells.len() as u32 - 1
    }

    /// Removes a cell; its number stays taken until [`drop_removed`](Self::drop_removed).
    pub(crate) fn remove(&mut self, cell: u32) {
        self.cells[cell as usize] = REMOVED;
    }

    pub(crate) fn is_removed(&self, cell: u32) -> bool {
        self.cells[cell as usize] == REMOVED
    }

    /// Contracts `node` onto `into`, `around` being the cells of `node`: those that have both are removed.
    pub(crate) fn contract(&mut self, node: u32, into: u32, around: &[u32]) {
        for &cell in around {
            let nodes = &mut self.cells[cell as usize];
            if nodes.contains(&into) {
                *nodes = REMOVED;
            } else {
                nodes.iter_mut().filter(|of| **of == node).for_each(|of| *of = into);
            }
        }
    }

    /// Takes the removed cells out; for every cell whether it stayed.
    pub(crate) fn drop_removed(&mut self) -> Vec<bool> {
        let kept: Vec<bool> = self.cells.iter().map(|cell| *cell != REMOVED).collect();
        let mut keep = kept.iter();
        self.owner.retain(|_| keep.next() == Some(&true));
        self.cells.retain(|cell| *cell != REMOVED);
        kept
    }

    /// Takes the nodes without cells out, and numbers the others anew in their order; the new numbers, or [`DROPPED`](crate::cells::DROPPED).
    pub(crate) fn drop_lone_nodes(&mut self) -> Vec<u32> {
        drop_lone_nodes(&mut self.points, self.cells.as_flattened_mut())
    }
}

/// The nodes of a cell in the order of positive volume.
pub(crate) fn oriented(cell: [u32; 4], points: &[Vec3]) -> [u32; 4] {
    let [a, b, c, d] = cell;
    let p = |node: u32| points[node as usize] - points[a as usize];
    if p(b).cross(&p(c)).dot(&p(d)) < 0.0 { [a, c, b, d] } else { cell }
}

/// The mean of a tetrahedron's corners.
pub(crate) fn centroid(cell: [u32; 4], points: &[Vec3]) -> Vec3 {
    cell.into_iter().map(|node| points[node as usize]).sum::<Vec3>() / 4.0
}

/// The [`min_dihedral_cos2`] of a tetrahedron without a positive volume: above that of any other.
pub(crate) const INVERTED: f64 = 2.0;

/// Signed square of the cosine of the smallest dihedral angle, cos |cos|, so that no root is needed: -1 to 1, larger for
/// smaller angles, [`INVERTED`] where the tetrahedron has no positive volume.
pub(crate) fn min_dihedral_cos2(corners: [Vec3; 4]) -> f64 {
    lane_cos2(corners)
}

/// [`min_dihedral_cos2`] as one lane of a loop over several tetrahedra, hence without branches.
#[inline(always)]
pub(crate) fn lane_cos2([a, b, c, d]: [Vec3; 4]) -> f64 {
    let (u, v, w) = (b - a, c - a, d - a);
    let (vw, wu, uv) = (v.cross(&w), w.cross(&u), u.cross(&v));
    // Face vectors; over a closed surface they sum to nothing.
    let faces = [-vw, -wu, -uv, vw + wu + uv];
    let mut inverse = [0.0; 4];
    for i in 0..4 {
        inverse[i] = 1.0 / faces[i].norm_squared();
    }
    let mut worst: f64 = -1.0;
    for i in 0..4 {
        for j in 0..i {
            let product = -faces[i].dot(&faces[j]);
            worst = worst.max(product * product.abs() * (inverse[i] * inverse[j]));
        }
    }
    if vw.dot(&u) <= 0.0 { INVERTED } else { worst }
}

/// The [`min_dihedral_cos2`] of an angle, degrees.
pub(crate) fn cos2_of(degrees: f64) -> f64 {
    let cosine = libm::cos(degrees.to_radians());
    cosine * cosine.abs()
}

/// Smallest and largest cosine of a tetrahedron's dihedral angles.
///
/// With outward face vectors n_i (of twice the area), the angle at the edge shared by faces i and j has the cosine
/// -n_i . n_j / |n_i| |n_j|.
#[inline(always)]
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
#[inline(always)]
pub(crate) fn face_vectors([a, b, c, d]: [Vec3; 4]) -> [Vec3; 4] {
    let cross = |u: Vec3, v: Vec3, w: Vec3| (v - u).cross(&(w - u));
    [cross(b, c, d), cross(a, d, c), cross(a, b, d), cross(a, c, b)]
}

/// Shortest altitude of the tetrahedron with these corners, mm: six times its volume over twice its largest face's area.
#[inline(always)]
pub(crate) fn shortest_altitude(p: [Vec3; 4]) -> f64 {
    let six_volumes = (p[1] - p[0]).cross(&(p[2] - p[0])).dot(&(p[3] - p[0]));
    six_volumes / face_vectors(p).map(|n| n.norm_squared()).into_iter().fold(0.0, f64::max).sqrt()
}

/// The length L of a tetrahedron that bounds its stable time step: L / c is stable for dilatational waves of speed c.
///
/// With lumped masses m = rho V / 4 its highest frequency w has w^2 <= 4 c^2 sum |grad N|^2 (the trace bounds the largest
/// eigenvalue, for Poisson's ratios of 0 or more), and central differences are stable up to 2 / w. So L = 1 / sqrt(sum
/// |grad N|^2), where |grad N| is one over an altitude. The shortest altitude is up to twice as long, and no bound.
#[inline(always)]
pub(crate) fn stable_length(p: [Vec3; 4]) -> f64 {
    6.0 * volume(p) / face_vectors(p).map(|n| n.norm_squared()).into_iter().sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_signed_square_orders_tetrahedra_as_their_smallest_angle_does() {
        // At the edge from a to b the faces meet at `angle`; the other angles are larger.
        for angle in [5.0_f64, 20.0, 40.0] {
            let (sin, cos) = (libm::sin(angle.to_radians()), libm::cos(angle.to_radians()));
            let p = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.5, cos, sin]].map(Vec3::from);
            assert!((min_dihedral_cos2(p) - cos2_of(angle)).abs() < 1e-12, "{angle}");
            assert_eq!(min_dihedral_cos2([p[1], p[0], p[2], p[3]]), INVERTED);
        }
    }
}
