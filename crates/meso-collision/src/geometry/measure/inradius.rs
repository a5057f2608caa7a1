//! The largest ball inside a convex body, and the exact answer to whether an erosion leaves anything.
//!
//! The ball solves a linear program in four unknowns: maximise r under n_i . x + |n_i| r <= d_i. By duality any four
//! faces with weights w_i >= 0, sum w_i n_i = 0, bound it: r <= (sum w_i d_i) / (sum w_i |n_i|). The dual simplex
//! method walks along such quadruples ("bases") with a falling bound until its ball fits.

use crate::geometry::Polyhedron;
use crate::geometry::exact::double_double::{self, Dd, Dd3};
use crate::geometry::exact::integer::{
    Int3, bits, cross, dot, minus, quotient, to_integer, to_integers, unit_exponent,
};
use crate::math::Vec3;
use nalgebra::{Matrix4, Vector4};
use num_bigint::BigInt;
use num_traits::{One, Signed};

/// Faces are named by number; the four numbers from the face count on name the walls of [`ExactPlanes::push_walls`].
type Basis = [usize; 4];

/// From this share of the body's size on, a radius in f64 (right to about 1e-14 of that size) is trusted.
const TRUSTED: f64 = 1e-4;

/// A ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Its centre, mm.
    pub center: Vec3,
    /// Its radius, mm.
    pub radius: f64,
}

impl Polyhedron {
    /// The largest ball inside the body, its radius to about 1e-10.
    ///
    /// The centre of long bodies is one of many. Bodies too flat for floating point go through exact arithmetic.
    pub fn inscribed_ball(&self) -> Ball {
        let corners = plane_corners(self);
        let size = self.aabb().size().amax();
        match float_ball(&corners) {
            Some((ball, _)) if ball.radius > TRUSTED * size => ball,
            _ => {
                let planes = ExactPlanes::new(&corners, 0.0);
                let mut basis = planes.walls();
                planes.ball(&planes.roots(64), &mut basis, 64, &corners)
            }
        }
    }
}

/// Remainder of an eroded body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Erosion {
    /// Nothing, or a set without volume.
    Nothing,
    /// A solid around (nearly) this point.
    Around(Vec3),
}

/// Decides exactly whether the erosion by `thickness` of the body within the planes through `corners` has volume.
pub(crate) fn erosion(corners: &[[Vec3; 3]], thickness: f64) -> Erosion {
    let planes = ExactPlanes::new(corners, thickness);
    let mut basis = float_ball(corners).map_or(planes.walls(), |(_, basis)| basis);
    for precision in [64, 1024, planes.decisive_precision()] {
        let roots = planes.roots(precision);
        if !planes.is_dual_feasible(&roots, &basis) {
            basis = planes.walls();
        }
        if let Some(erosion) = planes.decide(&roots, &mut basis, precision, corners) {
            return erosion;
        }
    }
    // Closer to the thickness than two different numbers of this kind can be: equal.
    Erosion::Nothing
}

/// Three corners of every face that span its plane: the widest triangle of its fan.
pub(crate) fn plane_corners(body: &Polyhedron) -> Vec<[Vec3; 3]> {
    if let Some(triangles) = body.face_lists().byte_triangles() {
        return triangles.iter().map(|corners| corners.map(|i| body.vertices()[usize::from(i)])).collect();
    }
    let at = |t: [u32; 3]| t.map(|i| body.vertices()[i as usize]);
    let doubled_area = |[a, b, c]: &[Vec3; 3]| (b - a).cross(&(c - a)).norm_squared();
    let widest = |x: [Vec3; 3], y: [Vec3; 3]| if doubled_area(&y) > doubled_area(&x) { y } else { x };
    let mut corners = Vec::with_capacity(body.faces().len());
    corners.extend(body.faces().filter_map(|face| face.triangles().map(at).reduce(widest)));
    corners
}

/// The ball and its basis by the dual simplex method in f64, or `None` where that does not settle.
fn float_ball(corners: &[[Vec3; 3]]) -> Option<(Ball, Basis)> {
    let middle = corners.iter().flatten().sum::<Vec3>() / (3 * corners.len()) as f64;
    let size = corners.iter().flatten().map(|p| (p - middle).amax()).fold(0.0, f64::max);
    let scale = libm::scalbn(1.0, -libm::ilogb(size));
    let mut rows = Vec::with_capacity(corners.len() + 4);
    for [a, b, c] in corners {
        let normal = unit_normal([a, b, c], scale)?;
        rows.push((normal.push(1.0), normal.dot(&((a - middle) / size))));
    }
    let third = 1.0 / libm::sqrt(3.0);
    for signs in [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]] {
        rows.push(((Vec3::from(signs) * third).push(1.0), 8.0));
    }
    let (solution, basis) = dual_simplex(&rows)?;
    Some((Ball { center: middle + solution.xyz() * size, radius: solution.w * size }, basis))
}

/// The unit normal to the last bit even of a narrow triangle, multiplied by `scale` before; `None` where it has none.
fn unit_normal([a, b, c]: [&Vec3; 3], scale: f64) -> Option<Vec3> {
    let edge = |p: &Vec3| -> Dd3 { [0, 1, 2].map(|k| Dd::difference(p[k], a[k]) * scale) };
    Vec3::from(double_double::cross(&edge(b), &edge(c)).map(Dd::value)).try_normalize(0.0)
}

/// Maximises the last unknown under row . x <= offset, starting from the last four rows.
fn dual_simplex(rows: &[(Vector4<f64>, f64)]) -> Option<(Vector4<f64>, Basis)> {
    let first_wall = rows.len() - 4;
    let mut basis = [0, 1, 2, 3].map(|k| first_wall + k);
    // A few times the pivots that any body needed; the exact method takes over from here.
    for _ in 0..20 + 4 * rows.len() {
        let inverse = Matrix4::from_rows(&basis.map(|i| rows[i].0.transpose())).try_inverse()?;
        let solution = inverse * Vector4::from(basis.map(|i| rows[i].1));
        let excess = |row: &(Vector4<f64>, f64)| row.0.dot(&solution) - row.1;
        let (entering, worst) = rows
            .iter()
            .map(excess)
            .enumerate()
            .fold((0, f64::NEG_INFINITY), |best, x| if x.1 > best.1 { x } else { best });
        if worst <= 1e-14 {
            return Some((solution, basis));
        }
        let share = rows[entering].0.transpose() * inverse;
        let ratio = |k: &usize| inverse[(3, *k)] / share[*k];
        let leaving = (0..4).filter(|&k| share[k] > 1e-12).min_by(|a, b| ratio(a).total_cmp(&ratio(b)))?;
        basis[leaving] = entering;
    }
    None
}

/// The planes n . x = d of a body in integers, x from its first corner.
struct ExactPlanes {
    /// Exponent of the unit of length.
    unit: i32,
    normals: Vec<Int3>,
    offsets: Vec<BigInt>,
    thickness: BigInt,
}

/// A basis solved: `inverse` over `determinant` is the inverse of its four rows.
struct Solved {
    determinant: BigInt,
    inverse: [[BigInt; 4]; 4],
    /// The solution, times the determinant.
    unknowns: [BigInt; 4],
}

impl ExactPlanes {
    fn new(corners: &[[Vec3; 3]], thickness: f64) -> Self {
        let coordinates = corners.iter().flatten().flat_map(|p| [p.x, p.y, p.z]);
        let unit = unit_exponent(coordinates.chain([thickness]));
        let origin = to_integers(&corners[0][0], unit);
        let mut planes =
            Self { unit, normals: Vec::new(), offsets: Vec::new(), thickness: to_integer(thickness, unit) };
        for triangle in corners {
            let [a, b, c] = triangle.map(|p| minus(&to_integers(&p, unit), &origin));
            let normal = cross(&minus(&b, &a), &minus(&c, &a));
            planes.offsets.push(dot(&normal, &a));
            planes.normals.push(normal);
        }
        planes.push_walls(bits(corners.iter().flatten().flat_map(|p| to_integers(p, unit)).collect::<Vec<_>>().iter()));
        planes
    }

    /// Four planes far outside a body whose coordinates have this many bits: the basis that every search can start
    /// from.
    fn push_walls(&mut self, coordinate_bits: u64) {
        for normal in [[-1, 0, 0], [0, -1, 0], [0, 0, -1], [1, 1, 1]] {
            self.normals.push(normal.map(BigInt::from));
            self.offsets.push(BigInt::one() << (coordinate_bits + 6));
        }
    }

    fn walls(&self) -> Basis {
        [4, 3, 2, 1].map(|k| self.normals.len() - k)
    }

    /// |n_i| in units of 2^-`precision`, rounded down; 1 for the walls, which only have to be far.
    fn roots(&self, precision: u64) -> Vec<BigInt> {
        let walls = self.normals.len() - 4;
        let root = |(i, n): (usize, &Int3)| {
            if i < walls { (dot(n, n) << (2 * precision)).sqrt() } else { BigInt::one() << precision }
        };
        self.normals.iter().enumerate().map(root).collect()
    }

    /// The precision beyond which radius and thickness are either separated or equal.
    ///
    /// Their difference times sum w_i |n_i| is S = sum w_i d_i - t sum w_i |n_i|: an integer and four square roots of
    /// integers, so an algebraic integer with at most 16 conjugates of at most K. If S is not 0 its norm is at least 1,
    /// hence |S| >= K^-15, and |r - t| >= K^-16.
    fn decisive_precision(&self) -> u64 {
        let normal = bits(self.normals.iter().flatten());
        let weight = 3 * normal + 3;
        let k = weight + 3 + bits(&self.offsets).max(bits([&self.thickness]) + normal + 1);
        17 * k + 2
    }

    fn row(&self, roots: &[BigInt], i: usize) -> [BigInt; 4] {
        let [x, y, z] = self.normals[i].clone();
        [x, y, z, roots[i].clone()]
    }

    fn solve(&self, roots: &[BigInt], basis: &Basis) -> Solved {
        let rows = basis.map(|i| self.row(roots, i));
        let mut inverse = [0, 1, 2, 3].map(|k| [0, 1, 2, 3].map(|i| cofactor(&rows, i, k)));
        let mut determinant = (0..4).map(|k| &rows[0][k] * &inverse[k][0]).sum::<BigInt>();
        if determinant.is_negative() {
            determinant = -determinant;
            inverse = inverse.map(|row| row.map(|x| -x));
        }
        let unknowns = [0, 1, 2, 3].map(|k| (0..4).map(|i| &inverse[k][i] * &self.offsets[basis[i]]).sum());
        Solved { determinant, inverse, unknowns }
    }

    fn is_dual_feasible(&self, roots: &[BigInt], basis: &Basis) -> bool {
        let solved = self.solve(roots, basis);
        solved.determinant.is_positive() && solved.inverse[3].iter().all(|weight| !weight.is_negative())
    }

    /// The result of the erosion, or `None` where this precision cannot decide.
    ///
    /// Norms rounded down make the radius too large, by less than a factor 1 + 2^-precision.
    fn decide(&self, roots: &[BigInt], basis: &mut Basis, precision: u64, corners: &[[Vec3; 3]]) -> Option<Erosion> {
        loop {
            let solved = self.solve(roots, basis);
            let radius: BigInt = &solved.unknowns[3] << precision;
            let thickness = &self.thickness * &solved.determinant;
            if radius <= thickness {
                return Some(Erosion::Nothing);
            }
            if self.pivot(roots, basis, &solved) {
                continue;
            }
            let exact = self.roots_are_exact(roots, precision);
            let certain = exact || (radius << precision) > thickness * ((BigInt::one() << precision) + 1_u8);
            return certain.then(|| Erosion::Around(self.point(&solved, corners)));
        }
    }

    fn roots_are_exact(&self, roots: &[BigInt], precision: u64) -> bool {
        let planes = self.normals.len() - 4;
        (0..planes).all(|i| &roots[i] * &roots[i] == dot(&self.normals[i], &self.normals[i]) << (2 * precision))
    }

    /// The ball of the optimal basis, to the precision of the norms.
    fn ball(&self, roots: &[BigInt], basis: &mut Basis, precision: u64, corners: &[[Vec3; 3]]) -> Ball {
        loop {
            let solved = self.solve(roots, basis);
            if !self.pivot(roots, basis, &solved) {
                let radius: BigInt = &solved.unknowns[3] << precision;
                return Ball {
                    center: self.point(&solved, corners),
                    radius: quotient(&radius, &solved.determinant, self.unit),
                };
            }
        }
    }

    fn point(&self, solved: &Solved, corners: &[[Vec3; 3]]) -> Vec3 {
        let [x, y, z] = [0, 1, 2].map(|k| quotient(&solved.unknowns[k], &solved.determinant, self.unit));
        corners[0][0] + Vec3::new(x, y, z)
    }

    /// Exchanges one plane of the basis for one that its ball violates; false where there is none.
    ///
    /// Always the first that qualifies (Bland's rule), so that no basis comes back.
    fn pivot(&self, roots: &[BigInt], basis: &mut Basis, solved: &Solved) -> bool {
        let rows = (0..self.normals.len()).map(|i| (i, self.row(roots, i)));
        let violated = |(i, row): &(usize, [BigInt; 4])| {
            (0..4).map(|k| &row[k] * &solved.unknowns[k]).sum::<BigInt>() > &self.offsets[*i] * &solved.determinant
        };
        let Some((entering, row)) = rows.into_iter().find(violated) else {
            return false;
        };
        let share = |k: usize| (0..4).map(|j| &row[j] * &solved.inverse[j][k]).sum::<BigInt>();
        let weight = &solved.inverse[3];
        let mut leaving: Option<(usize, BigInt)> = None;
        for k in 0..4 {
            let share_k = share(k);
            if !share_k.is_positive() {
                continue;
            }
            let better = leaving.as_ref().is_none_or(|(best, share_best)| {
                let (this, that) = (&weight[k] * share_best, &weight[*best] * &share_k);
                this < that || (this == that && basis[k] < basis[*best])
            });
            if better {
                leaving = Some((k, share_k));
            }
        }
        let (leaving, _) = leaving.expect("a bounded body keeps the program bounded");
        basis[leaving] = entering;
        true
    }
}

/// The cofactor of row `i`, column `k`.
fn cofactor(rows: &[[BigInt; 4]; 4], i: usize, k: usize) -> BigInt {
    const OTHERS: [[usize; 3]; 4] = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];
    let minor: [Int3; 3] = OTHERS[i].map(|row| OTHERS[k].map(|column| rows[row][column].clone()));
    let determinant = dot(&minor[0], &cross(&minor[1], &minor[2]));
    if (i + k).is_multiple_of(2) { determinant } else { -determinant }
}
