//! Round bodies: balls and ellipsoids, exact, with facets for whoever needs triangles.
//!
//! A round body is the image x = c + A u of the unit ball, the columns of A its semi-axes. It is stored as its six *ends*
//! c - A e1, c + A e1, c - A e2, ..., so that moving vertices moves the body; on the grains' lattice that is exact.

use crate::math::{Aabb, Mat3, Vec3};
use std::f64::consts::PI;
use std::sync::LazyLock;

/// A ball or an ellipsoid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Round {
    centre: Vec3,
    /// Semi-axes as columns, mm.
    axes: Mat3,
    inverse: Mat3,
    /// Radius of a ball, mm.
    radius: Option<f64>,
}

/// Number of ends.
pub(crate) const ENDS: usize = 6;

/// Ends of a ball that is off the lattice are rounded by less than this share of its radius.
const ROUNDING_OF_ENDS: f64 = 1e-10;

impl Round {
    /// The ball of this radius, mm, about the origin.
    pub fn ball(radius: f64) -> Self {
        Self::of_semi_axes(&Vec3::repeat(radius))
    }

    /// The ellipsoid about the origin with these semi-axes along x, y and z, mm.
    pub fn of_semi_axes(semi_axes: &Vec3) -> Self {
        Self::new(Vec3::zeros(), Mat3::from_diagonal(semi_axes))
    }

    fn new(centre: Vec3, axes: Mat3) -> Self {
        let (diagonal, mut beside) = (axes.diagonal(), axes);
        beside.set_diagonal(&Vec3::zeros());
        let is_ball = beside == Mat3::zeros() && diagonal.max() - diagonal.min() <= ROUNDING_OF_ENDS * diagonal.max();
        let radius = is_ball.then(|| diagonal.max());
        Self { centre, axes, inverse: axes.try_inverse().unwrap_or_default(), radius }
    }

    /// The body with these ends, which come first among the vertices.
    pub fn of_ends(ends: &[Vec3]) -> Self {
        let axis = |k: usize| (ends[2 * k + 1] - ends[2 * k]) / 2.0;
        Self::new((ends[0] + ends[1]) / 2.0, Mat3::from_columns(&[axis(0), axis(1), axis(2)]))
    }

    /// The ends of its three axes.
    pub fn ends(&self) -> [Vec3; ENDS] {
        let end = |k: usize, sign: f64| self.centre + self.axes.column(k) * sign;
        [end(0, -1.0), end(0, 1.0), end(1, -1.0), end(1, 1.0), end(2, -1.0), end(2, 1.0)]
    }

    /// Its middle, mm.
    pub fn centre(&self) -> &Vec3 {
        &self.centre
    }

    /// Radius of a ball, mm; `None` for an ellipsoid.
    pub fn radius(&self) -> Option<f64> {
        self.radius
    }

    /// Lengths of the semi-axes, descending, mm.
    pub fn semi_axes(&self) -> [f64; 3] {
        let mut lengths = [0, 1, 2].map(|k| self.axes.column(k).norm());
        lengths.sort_by(|p, q| q.total_cmp(p));
        lengths
    }

    /// True where the ends are those of an ellipsoid: axes that cross in the middle and are orthogonal, to `slack` mm.
    pub fn is_sound(&self, ends: &[Vec3], slack: f64) -> bool {
        let is_there = self.ends().iter().zip(ends).all(|(own, end)| (own - end).norm() <= slack);
        let tilted = |p: usize, q: usize| self.axes.column(p).dot(&self.axes.column(q)).abs();
        let most = slack * self.axes.norm();
        let is_orthogonal = tilted(0, 1).max(tilted(1, 2)).max(tilted(2, 0)) <= most;
        is_there && is_orthogonal && self.axes.determinant() > 0.0
    }

    /// Volume, mm3.
    pub fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.axes.determinant()
    }

    /// Inertia tensor of unit density about the centre, mm5.
    pub(crate) fn inertia(&self) -> Mat3 {
        let covariance = self.axes * self.axes.transpose() * (self.volume() / 5.0);
        Mat3::identity() * covariance.trace() - covariance
    }

    /// Surface area, mm2; that of an ellipsoid to 1e-3.
    pub fn area(&self) -> f64 {
        if let Some(radius) = self.radius {
            return 4.0 * PI * radius * radius;
        }
        // The element of area at A u is |A^-T u| |A| times that of the unit ball, whose facets share it out.
        let stretch = |u: &Vec3| self.inverse.tr_mul(u).norm() * self.axes.determinant();
        let Facets { directions, triangles, .. } = &*FACETS;
        let corners = |t: &[u8; 3]| t.map(|i| directions[usize::from(i)]);
        let area = |[a, b, c]: &[Vec3; 3]| (b - a).cross(&(c - a)).norm();
        let mean = |corners: &[Vec3; 3]| {
            let middle = corners.iter().sum::<Vec3>().normalize();
            // Exact for quadratics on a plane triangle.
            (stretch(&middle) * 9.0 + corners.iter().map(stretch).sum::<f64>()) / 12.0
        };
        let whole: f64 = triangles.iter().map(|t| area(&corners(t))).sum();
        let sum: f64 = triangles.iter().map(corners).map(|corners| area(&corners) * mean(&corners)).sum();
        4.0 * PI * sum / whole
    }

    /// Side of the smallest square hole that it passes, mm.
    ///
    /// Squared widths along orthogonal u, v, w sum to 4 (a^2 + b^2 + c^2). So the larger of two is least where the third
    /// is along the longest axis and both are equal.
    pub fn sieve_size(&self) -> f64 {
        let [_, b, c] = self.semi_axes();
        (2.0 * (b * b + c * c)).sqrt()
    }

    /// The smallest box, rounded outwards.
    pub fn aabb(&self) -> Aabb {
        let half = self.half_extents();
        Aabb { min: self.centre - half, max: self.centre + half }
    }

    /// Half of its extents along x, y and z, mm, rounded up.
    pub fn half_extents(&self) -> Vec3 {
        Vec3::from_fn(|i, _| match self.radius {
            Some(radius) => radius,
            None => self.axes.row(i).norm() * (1.0 + 4.0 * f64::EPSILON),
        })
    }

    /// A A^T of the axes, mm2.
    pub(crate) fn shape(&self) -> Mat3 {
        self.axes * self.axes.transpose()
    }

    /// An arm from the centre where the body is a unit ball.
    pub(crate) fn unit_arm(&self, arm: &Vec3) -> Vec3 {
        self.inverse * arm
    }

    /// The normal of a plane here whose normal is `normal` where the body is a unit ball, of any length.
    pub(crate) fn normal_of_unit(&self, normal: &Vec3) -> Vec3 {
        self.inverse.tr_mul(normal)
    }

    /// How far it reaches from its centre along `direction`, times that one's length.
    pub(crate) fn reach(&self, direction: &Vec3) -> f64 {
        self.axes.tr_mul(direction).norm()
    }

    /// The point farthest along `direction`, about the centre.
    pub(crate) fn farthest(&self, direction: &Vec3) -> Vec3 {
        let along = self.axes.tr_mul(direction);
        self.axes * (along / along.norm().max(f64::MIN_POSITIVE))
    }

    /// True for points of the closed body, up to rounding.
    pub fn contains(&self, point: &Vec3) -> bool {
        match self.radius {
            Some(radius) => (point - self.centre).norm_squared() <= radius * radius,
            None => (self.inverse * (point - self.centre)).norm_squared() <= 1.0,
        }
    }

    /// Distance of `point` from the surface, mm, negative inside.
    pub fn height(&self, point: &Vec3) -> f64 {
        match self.radius {
            Some(radius) => (point - self.centre).norm() - radius,
            None => {
                let distance = (self.nearest(point) - point).norm();
                if self.contains(point) { -distance } else { distance }
            }
        }
    }

    /// The point of the surface nearest to `point`; of several, one.
    ///
    /// In the frame of the axes it is y_k = a_k^2 x_k / (t + a_k^2), at the root t of F(t) = sum (a_k x_k / (t + a_k^2))^2 - 1
    /// (D. Eberly, Distance from a Point to an Ellipse, 2013). Newton's method rises to the root: F falls and is convex, and
    /// at the start one term of the sum is 1 and none is larger.
    pub fn nearest(&self, point: &Vec3) -> Vec3 {
        let arm = point - self.centre;
        if let Some(radius) = self.radius {
            let length = arm.norm();
            return self.centre + if length > 0.0 { arm * (radius / length) } else { Vec3::ith(0, radius) };
        }
        let lengths = Vec3::from_fn(|k, _| self.axes.column(k).norm());
        // Through the inverse, so that a point of the surface is its own nearest one although ends are rounded.
        let x = lengths.component_mul(&(self.inverse * arm));
        let squares = lengths.component_mul(&lengths);
        // A point on a plane of symmetry may have two nearest ones: it is moved off that plane by less than shows.
        let x = x.map(|c| if c.abs() < 1e-12 * lengths.max() { 1e-12 * lengths.max() } else { c });
        let mut root = (x.abs().component_mul(&lengths) - squares).max();
        for _ in 0..MOST_STEPS {
            let (mut value, mut slope) = (-1.0, 0.0);
            for k in 0..3 {
                let reach = root + squares[k];
                let square = (lengths[k] * x[k] / reach).powi(2);
                (value, slope) = (value + square, slope + 2.0 * square / reach);
            }
            let next = root + value / slope;
            if next.is_nan() || next <= root {
                break;
            }
            root = next;
        }
        let y = Vec3::from_fn(|k, _| lengths[k] * x[k] / (root + squares[k]));
        self.centre + self.axes * y.normalize()
    }

    /// The outward unit normal of the scaled copy of the surface that passes through `point`.
    pub fn normal(&self, point: &Vec3) -> Vec3 {
        let gradient = self.normal_of_unit(&self.unit_arm(&(point - self.centre)));
        gradient.try_normalize(0.0).unwrap_or_else(Vec3::x)
    }

    /// The part of the line `origin` + s `direction` inside, as values of s.
    pub fn chord(&self, origin: &Vec3, direction: &Vec3) -> Option<(f64, f64)> {
        let (from, way) = (self.inverse * (origin - self.centre), self.inverse * direction);
        let (square, product) = (way.norm_squared(), from.dot(&way));
        let nearest = from - way * (product / square);
        let rest = 1.0 - nearest.norm_squared();
        if !(rest >= 0.0 && square > 0.0) {
            return None;
        }
        let (middle, half) = (-product / square, (rest / square).sqrt());
        Some((middle - half, middle + half))
    }

    /// The body of the points deeper than `thickness` mm, which only a ball has in this form.
    pub(crate) fn core(&self, thickness: f64) -> Option<Self> {
        let radius = self.radius? - thickness;
        Some(Self::new(self.centre, Mat3::from_diagonal_element(radius)))
    }

    /// Points on the surface, the ends first: the corners of its facets.
    pub(crate) fn vertices(&self, ends: &[Vec3]) -> Box<[Vec3]> {
        let others = FACETS.directions[ENDS..].iter().map(|u| self.centre + self.axes * u);
        ends[..ENDS].iter().copied().chain(others).collect()
    }

    /// Corners of a polyhedron around the body, about its centre: its facets, moved outwards.
    pub fn circumscribed(&self) -> Vec<Vec3> {
        FACETS.directions.iter().map(|u| self.axes * (u * FACETS.outwards)).collect()
    }

    /// The body moved by `shift`, mm.
    #[must_use]
    pub fn moved(&self, shift: &Vec3) -> Self {
        Self { centre: self.centre + shift, ..*self }
    }
}

/// Steps towards a root; it takes 4 to 8 until rounding ends them.
const MOST_STEPS: usize = 50;

/// Facets of the unit ball: an icosahedron with its triangles divided twice, 162 corners on 320 triangles.
pub(crate) struct Facets {
    directions: Vec<Vec3>,
    pub(crate) triangles: Vec<[u8; 3]>,
    /// Factor that takes the facets off the unit ball.
    pub(crate) outwards: f64,
}

pub(crate) static FACETS: LazyLock<Facets> = LazyLock::new(Facets::new);

/// Divisions of the icosahedron's triangles.
const DIVISIONS: usize = 2;

impl Facets {
    fn new() -> Self {
        let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
        let signs = [[1.0, golden], [1.0, -golden], [-1.0, golden], [-1.0, -golden]];
        let corner =
            |axis: usize, [one, other]: [f64; 2]| Vec3::from_fn(|i, _| [0.0, one, other][(i + axis) % 3]).normalize();
        let mut directions: Vec<Vec3> = (0..3).flat_map(|axis| signs.map(|sign| corner(axis, sign))).collect();
        for _ in 0..DIVISIONS {
            let triangles = outward_triangles(&directions);
            let edges = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).filter(|[a, b]| a < b);
            let middles: Vec<Vec3> = edges.map(|[a, b]| (directions[a] + directions[b]).normalize()).collect();
            directions.extend(middles);
        }
        // The ends come first: they are middles of edges of the icosahedron.
        let is_end = |u: &Vec3| u.amax() > 1.0 - 1e-9;
        let others = directions.iter().filter(|u| !is_end(u));
        let ends = (0..ENDS).map(|k| Vec3::ith(k / 2, if k % 2 == 0 { -1.0 } else { 1.0 }));
        let directions: Vec<Vec3> = ends.chain(others.copied()).collect();
        let triangles = outward_triangles(&directions);
        let corners = triangles.iter().map(|t| t.map(|i| directions[i]));
        let depth = |[a, b, c]: [Vec3; 3]| (b - a).cross(&(c - a)).normalize().dot(&a);
        let outwards = (1.0 + 1e-12) / corners.map(depth).fold(1.0, f64::min);
        Self { triangles: triangles.into_iter().map(|t| t.map(|i| i as u8)).collect(), directions, outwards }
    }
}

/// The triangles of the hull of `points`, corners of a divided icosahedron, in the order of a hull's faces: three
/// corners are one where no two are farther apart than the longest edge.
fn outward_triangles(points: &[Vec3]) -> Vec<[usize; 3]> {
    let apart = |p: usize, q: usize| (points[p] - points[q]).norm();
    let count = points.len();
    // The longest edge is 1.18 times the shortest one, and the next corner lies at 1.7 times.
    let most = 1.4 * (1..count).map(|other| apart(0, other)).fold(f64::INFINITY, f64::min);
    let near = |p: usize| (p + 1..count).filter(move |&q| apart(p, q) < most);
    let mut triangles: Vec<[usize; 3]> = (0..count)
        .flat_map(|a| near(a).flat_map(move |b| near(b).filter(move |&c| apart(a, c) < most).map(move |c| [a, b, c])))
        .map(|[a, b, c]| if points[a].dot(&points[b].cross(&points[c])) > 0.0 { [a, b, c] } else { [a, c, b] })
        .collect();
    triangles.sort_unstable();
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::convex_hull;

    #[test]
    fn facets_of_a_ball_are_the_faces_of_their_hull() {
        let hull = convex_hull(&FACETS.directions).unwrap();
        assert_eq!(hull.vertices(), FACETS.directions);
        assert!(hull.triangles().eq(FACETS.triangles.iter().map(|t| t.map(u32::from))));
        assert_eq!(FACETS.triangles.len(), 320);
    }
}
