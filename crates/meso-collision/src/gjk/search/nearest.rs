//! Distance sub-algorithms: the point of a simplex nearest the origin, and the smallest part that holds it.
//!
//! Both are in floating point and prove nothing: they steer [`classical`](crate::gjk::search::classical).

use crate::gjk::search::simplex::{Simplex, Vertex};
use crate::math::Vec3;

/// How [`classical`](crate::gjk::search::classical) reduces its simplex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SubAlgorithm {
    /// Johnson's recursive determinants, as in the GJK of 1988.
    Johnson,
    /// Signed volumes: Montanari, Petrinic, Barbieri, ACM Trans. Graph. 36 (2017).
    SignedVolumes,
}

impl SubAlgorithm {
    /// Reduces the simplex and returns its point nearest the origin; 0 when the origin lies in a tetrahedron.
    #[inline(always)]
    pub(crate) fn reduce(self, simplex: &mut Simplex) -> Vec3 {
        match self {
            Self::Johnson => johnson(simplex),
            Self::SignedVolumes => signed_volumes(simplex),
        }
    }
}

/// The first part X, in order of size, with Delta_i(X) > 0 inside and Delta_j(X + j) <= 0 for all other corners.
///
/// Delta_j(X + j) = sum over X of Delta_i(X) (w_i . w_k - w_i . w_j), k the first corner of X. Where rounding lets no
/// part pass, the nearest of the parts with positive Deltas is taken (the backup procedure of the original paper).
fn johnson(simplex: &mut Simplex) -> Vec3 {
    let corners: Vec3s = Vec3s::of(simplex);
    let full = (1usize << corners.n) - 1;
    let delta = deltas(&corners, full);
    let mut best: Option<(usize, Vec3)> = None;
    for part in 1..=full {
        if !corners.in_part(part).all(|i| delta[part][i] > 0.0) {
            continue;
        }
        let v = corners.combine(part, &delta[part]);
        if corners.in_part(full & !part).all(|j| delta[part | 1 << j][j] <= 0.0) {
            best = Some((part, v));
            break;
        }
        if best.is_none_or(|(_, b)| v.norm_squared() < b.norm_squared()) {
            best = Some((part, v));
        }
    }
    let (part, v) = best.expect("the Delta of a single corner is 1");
    keep_part(simplex, part);
    if part.count_ones() == 4 { Vec3::zeros() } else { v }
}

/// Delta_i of every part, by part (a bit mask) and corner.
fn deltas(corners: &Vec3s, full: usize) -> [[f64; 4]; 16] {
    let dot: [[f64; 4]; 4] = std::array::from_fn(|i| std::array::from_fn(|j| corners.w[i].dot(&corners.w[j])));
    let mut delta = [[0.0; 4]; 16];
    for i in 0..corners.n {
        delta[1 << i][i] = 1.0;
    }
    for part in 1..=full {
        let k = part.trailing_zeros() as usize;
        for j in corners.in_part(full & !part) {
            let larger = corners.in_part(part).map(|i| delta[part][i] * (dot[i][k] - dot[i][j])).sum();
            delta[part | 1 << j][j] = larger;
        }
    }
    delta
}

/// The corners' positions, as a fixed array.
struct Vec3s {
    w: [Vec3; 4],
    n: usize,
}

impl Vec3s {
    fn of(simplex: &Simplex) -> Self {
        let mut w = [Vec3::zeros(); 4];
        for (w, vertex) in w.iter_mut().zip(simplex.vertices()) {
            *w = vertex.w;
        }
        Self { w, n: simplex.vertices().len() }
    }

    fn in_part(&self, part: usize) -> impl Iterator<Item = usize> + use<> {
        (0..self.n).filter(move |i| part >> i & 1 == 1)
    }

    fn combine(&self, part: usize, weights: &[f64; 4]) -> Vec3 {
        let total: f64 = self.in_part(part).map(|i| weights[i]).sum();
        self.in_part(part).map(|i| self.w[i] * (weights[i] / total)).sum()
    }
}

fn keep_part(simplex: &mut Simplex, part: usize) {
    let vertices = *simplex;
    let mut kept = [vertices.vertices()[0]; 4];
    let mut n = 0;
    for (i, vertex) in vertices.vertices().iter().enumerate() {
        if part >> i & 1 == 1 {
            kept[n] = *vertex;
            n += 1;
        }
    }
    simplex.keep(&kept[..n]);
}

#[inline(always)]
fn signed_volumes(simplex: &mut Simplex) -> Vec3 {
    match *simplex.vertices() {
        [a] => a.w,
        [a, b] => segment(simplex, a, b),
        [a, b, c] => triangle(simplex, a, b, c),
        [a, b, c, d] => tetrahedron(simplex, [a, b, c, d]),
        _ => Vec3::zeros(),
    }
}

#[inline(always)]
fn segment(simplex: &mut Simplex, a: Vertex, b: Vertex) -> Vec3 {
    let e = b.w - a.w;
    let (from_a, from_b) = (-a.w.dot(&e), b.w.dot(&e));
    if from_a <= 0.0 {
        simplex.keep(&[a]);
        return a.w;
    }
    if from_b <= 0.0 {
        simplex.keep(&[b]);
        return b.w;
    }
    simplex.keep(&[a, b]);
    a.w + e * (from_a / (from_a + from_b))
}

/// Signed areas, projected on the coordinate plane where the triangle is largest.
#[inline(always)]
fn triangle(simplex: &mut Simplex, a: Vertex, b: Vertex, c: Vertex) -> Vec3 {
    let n = (b.w - a.w).cross(&(c.w - a.w));
    let n2 = n.norm_squared();
    let foot = n * (a.w.dot(&n) / n2);
    let axis = n.iamax();
    let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
    let area = |p: &Vec3, q: &Vec3| {
        ((p[j] - foot[j]) * (q[k] - foot[k]) - (p[k] - foot[k]) * (q[j] - foot[j])) * n[axis].signum()
    };
    let areas = [area(&b.w, &c.w), area(&c.w, &a.w), area(&a.w, &b.w)];
    if areas.iter().all(|&x| x > 0.0) && foot.x.is_finite() {
        simplex.keep(&[a, b, c]);
        return foot;
    }
    let edges = [(b, c), (c, a), (a, b)];
    let visible = (0..3).filter(|&i| areas[i].is_nan() || areas[i] <= 0.0).map(|i| edges[i]);
    nearest_of(simplex, visible, |s, (p, q)| segment(s, p, q))
}

#[inline(always)]
fn tetrahedron(simplex: &mut Simplex, p: [Vertex; 4]) -> Vec3 {
    let [a, b, c, d] = p.map(|v| v.w);
    let (ab, cd) = (a.cross(&b), c.cross(&d));
    let volumes = [b.dot(&cd), -a.dot(&cd), d.dot(&ab), -c.dot(&ab)];
    let total: f64 = volumes.iter().sum();
    let inside = volumes.map(|v| v * total.signum() > 0.0);
    if inside.iter().all(|&i| i) {
        return Vec3::zeros();
    }
    let [a, b, c, d] = p;
    let faces = [(b, c, d), (a, c, d), (a, b, d), (a, b, c)];
    // A flat tetrahedron has no reliable sides: look at all faces.
    let size = volumes.iter().map(|v| v.abs()).fold(0.0, f64::max);
    let flat = total.abs() <= 1e-12 * size;
    let visible = (0..4).filter(|&i| flat || !inside[i]).map(|i| faces[i]);
    nearest_of(simplex, visible, |s, (p, q, r)| triangle(s, p, q, r))
}

/// The nearest of several parts, each reduced by `reduce`.
#[inline(always)]
fn nearest_of<T>(
    simplex: &mut Simplex,
    parts: impl Iterator<Item = T>,
    reduce: impl Fn(&mut Simplex, T) -> Vec3,
) -> Vec3 {
    let mut best = (f64::INFINITY, *simplex, Vec3::zeros());
    for part in parts {
        let mut reduced = *simplex;
        let v = reduce(&mut reduced, part);
        if v.norm_squared() < best.0 {
            best = (v.norm_squared(), reduced, v);
        }
    }
    *simplex = best.1;
    best.2
}
