//! Measures of one tetrahedron.

use crate::math::Vec3;

/// The [`min_dihedral_cos2`] of a tetrahedron without a positive volume: above that of any other.
pub(in crate::mesh) const INVERTED: f64 = 2.0;

/// Signed square of the cosine of the smallest dihedral angle, cos |cos|, so that no root is needed: -1 to 1, larger for
/// smaller angles, [`INVERTED`] where the tetrahedron has no positive volume.
pub(in crate::mesh) fn min_dihedral_cos2([a, b, c, d]: [Vec3; 4]) -> f64 {
    let (u, v, w) = (b - a, c - a, d - a);
    let (vw, wu, uv) = (v.cross(&w), w.cross(&u), u.cross(&v));
    if vw.dot(&u) <= 0.0 {
        return INVERTED;
    }
    // Face vectors; over a closed surface they sum to nothing.
    let faces = [-vw, -wu, -uv, vw + wu + uv];
    let inverse = faces.map(|face| 1.0 / face.norm_squared());
    let mut worst: f64 = -1.0;
    for i in 0..4 {
        for j in 0..i {
            let product = -faces[i].dot(&faces[j]);
            worst = worst.max(product * product.abs() * (inverse[i] * inverse[j]));
        }
    }
    worst
}

/// The [`min_dihedral_cos2`] of an angle, degrees.
pub(in crate::mesh) fn cos2_of(degrees: f64) -> f64 {
    let cosine = libm::cos(degrees.to_radians());
    cosine * cosine.abs()
}

/// Smallest and largest cosine of a tetrahedron's dihedral angles.
///
/// With outward face vectors n_i (of twice the area), the angle at the edge shared by faces i and j has the cosine
/// -n_i . n_j / |n_i| |n_j|.
pub(in crate::mesh) fn dihedral_cosines(p: [Vec3; 4]) -> [f64; 2] {
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
pub(in crate::mesh) fn face_vectors([a, b, c, d]: [Vec3; 4]) -> [Vec3; 4] {
    let cross = |u: Vec3, v: Vec3, w: Vec3| (v - u).cross(&(w - u));
    [cross(b, c, d), cross(a, d, c), cross(a, b, d), cross(a, c, b)]
}

/// Shortest altitude of the tetrahedron with these corners, mm: six times its volume over twice its largest face's area.
pub(in crate::mesh) fn shortest_altitude(p: [Vec3; 4]) -> f64 {
    let six_volumes = (p[1] - p[0]).cross(&(p[2] - p[0])).dot(&(p[3] - p[0]));
    six_volumes / face_vectors(p).map(|n| n.norm_squared()).into_iter().fold(0.0, f64::max).sqrt()
}

/// Volume, mm3; negative where the corners are out of order.
pub(in crate::mesh) fn volume([a, b, c, d]: [Vec3; 4]) -> f64 {
    (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
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
