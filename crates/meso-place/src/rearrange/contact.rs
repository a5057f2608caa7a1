//! Contact between two convex bodies for the dynamics: a direction, the gap along it, and the points it acts on.
//!
//! Single precision, uncertified: it only says where to push. [`gjk`](meso_collision::gjk) certifies the positions afterwards.
//!
//! The direction is that of the nearest points of the two bodies with their centres moved apart by a factor `spread`,
//! just enough that they do not overlap. Scaling the distance of two bodies by s is the same as scaling both bodies by
//! 1/s, which keeps every face normal and edge direction; so the nearest features of the spread bodies are, for shallow
//! overlaps, those that touch, and their direction separates with the least movement. One distance query, started from
//! the features of the last sweep, replaces a penetration query (MPR or EPA).

/// Vertices of a body about its centre, one array per coordinate, padded to a multiple of [`LANES`] with copies of the
/// first.
#[derive(Clone, Copy)]
pub(super) struct Points<'a> {
    pub(super) x: &'a [f32],
    pub(super) y: &'a [f32],
    pub(super) z: &'a [f32],
}

/// Width of the support loop; fixed, so that ties fall to the same vertex on every machine.
pub(super) const LANES: usize = 8;

pub(super) type V = [f32; 3];

/// Two bodies' common tangent plane, remembered between sweeps.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FoundContact {
    /// Unit direction from the first body to the second.
    pub(super) normal: V,
    /// Distance of the bodies along `normal`, mm; negative where they overlap along it.
    pub(super) gap: f32,
    /// Where the contact acts on the first body, about its centre, mm.
    pub(super) on_a: V,
    /// Where it acts on the second.
    pub(super) on_b: V,
    /// Vertices (of the first, of the second) that span the nearest features; the start of the next query.
    features: [(u16, u16); 3],
    count: u8,
}

/// Vertex farthest in direction `d`, and how far; the lowest index among equals.
#[inline(always)]
fn extreme(p: &Points, d: V) -> (usize, f32) {
    let mut best = [f32::NEG_INFINITY; LANES];
    // Vertex numbers are in single precision, too: vector selection needs one width and kind.
    let (mut block, mut number) = ([0.0; LANES], 0.0);
    for reaches in p.along(d) {
        for lane in 0..LANES {
            let better = reaches[lane] > best[lane];
            best[lane] = if better { reaches[lane] } else { best[lane] };
            block[lane] = if better { number } else { block[lane] };
        }
        number += LANES as f32;
    }
    let most = highest(best);
    let mut vertex = [0.0; LANES];
    for lane in 0..LANES {
        vertex[lane] = if best[lane] == most { -block[lane] - lane as f32 } else { f32::NEG_INFINITY };
    }
    (-highest(vertex) as u32 as usize, most)
}

/// The highest lane, by halves: no branch depends on the values.
#[inline(always)]
pub(super) fn highest(lanes: [f32; LANES]) -> f32 {
    let max = |p: f32, q: f32| if p > q { p } else { q };
    let [a, b, c, d, e, f, g, h] = lanes;
    max(max(max(a, e), max(c, g)), max(max(b, f), max(d, h)))
}

/// Support value of the body in direction `d`.
#[inline(always)]
fn reach(p: &Points, d: V) -> f32 {
    let mut best = [f32::NEG_INFINITY; LANES];
    for reaches in p.along(d) {
        for lane in 0..LANES {
            best[lane] = if reaches[lane] > best[lane] { reaches[lane] } else { best[lane] };
        }
    }
    highest(best)
}

impl Points<'_> {
    /// A vertex.
    #[inline(always)]
    pub(super) fn at(&self, i: usize) -> V {
        [self.x[i], self.y[i], self.z[i]]
    }

    /// How far the vertices reach in direction `d`, several at a time.
    #[inline(always)]
    fn along(&self, d: V) -> impl Iterator<Item = [f32; LANES]> {
        let (x, y, z) = (self.x.as_chunks::<LANES>().0, self.y.as_chunks::<LANES>().0, self.z.as_chunks::<LANES>().0);
        x.iter().zip(y).zip(z).map(move |((x, y), z)| {
            let mut reaches = [0.0; LANES];
            for lane in 0..LANES {
                reaches[lane] = x[lane] * d[0] + y[lane] * d[1] + z[lane] * d[2];
            }
            reaches
        })
    }
}

/// Gap between `a` and `b`, whose centre is at `x` from that of `a`, along the unit direction `n`.
#[inline(always)]
pub(super) fn gap_along(a: &Points, b: &Points, x: V, n: V) -> f32 {
    dot(n, x) - reach(b, neg(n)) - reach(a, n)
}

/// Least spread beyond touching, as a share of the bodies' reach along the contact.
const LEAST_SPREAD: f32 = 0.05;
/// Spread grows by this where the bodies still overlap.
const MORE_SPREAD: f32 = 1.5;
/// Long bodies whose remembered direction has less than this share of `w` begin with the direction of `w`.
const LEAST_ALONG: f32 = 0.2;
const MOST_STEPS: usize = 12;
/// The query ends when a support point is no nearer than this share of the distance.
const TOLERANCE: f64 = 1e-4;

impl FoundContact {
    /// A first guess: only a direction.
    pub(super) fn towards(normal: V) -> Self {
        Self { normal, gap: f32::INFINITY, ..Self::default() }
    }

    /// Recomputes the contact, starting from the remembered one, whose `gap` must be current. The bodies are moved
    /// apart along `w`: `x`, from centre to centre, for compact ones.
    #[inline(always)]
    pub(super) fn refresh(&mut self, a: &Points, b: &Points, x: V, w: V) {
        let aside = add_scaled(x, w, -1.0);
        if aside != [0.0; 3] && dot(self.normal, w) < LEAST_ALONG * length(w) {
            self.normal = direction_or_up(w);
            self.gap = gap_along(a, b, x, self.normal);
            self.count = 0;
        }
        let along = dot(self.normal, w).max(1e-6);
        let mut spread = 1.0 + (LEAST_SPREAD * (along - self.gap.max(-along)) + 1.2 * (-self.gap).max(0.0)) / along;
        for _ in 0..16 {
            if self.query(a, b, add_scaled(scale(w, spread), aside, 1.0), x) {
                return;
            }
            self.count = 0;
            spread *= MORE_SPREAD;
        }
        self.normal = direction_or_up(w);
        self.gap = gap_along(a, b, x, self.normal);
        (self.on_a, self.on_b) = ([0.0; 3], [0.0; 3]);
    }

    /// GJK distance query with the centres `far` apart; false where the bodies overlap even so.
    #[inline(always)]
    fn query(&mut self, a: &Points, b: &Points, far: V, x: V) -> bool {
        let mut simplex = WeightedSimplex::default();
        for &(i, j) in &self.features[..usize::from(self.count)] {
            simplex.push(a, b, i, j, far);
        }
        if simplex.count == 0 {
            let d = self.normal;
            simplex.push(a, b, extreme(a, d).0 as u16, extreme(b, neg(d)).0 as u16, far);
        }
        let mut v = simplex.nearest();
        for _ in 0..MOST_STEPS {
            let length2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
            if length2 < 1e-12 || simplex.count == 4 {
                return false;
            }
            // v points from b to a: the contact direction is -v.
            let inverse = 1.0 / length2.sqrt();
            let n = [(-v[0] * inverse) as f32, (-v[1] * inverse) as f32, (-v[2] * inverse) as f32];
            let ((i, reach_a), (j, reach_b)) = (extreme(a, n), extreme(b, neg(n)));
            let support = dot(n, far) - reach_a - reach_b;
            let fresh = !simplex.holds(i as u16, j as u16);
            if !fresh || f64::from(support) >= (1.0 - TOLERANCE) * length2.sqrt() {
                self.settle(&simplex, a, b, n, dot(n, x) - reach_a - reach_b);
                return true;
            }
            simplex.push(a, b, i as u16, j as u16, far);
            v = simplex.nearest();
        }
        // The last support may have closed a tetrahedron around the origin.
        if simplex.count == 4 {
            return false;
        }
        let inverse = 1.0 / (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt().max(1e-12);
        let n = [(-v[0] * inverse) as f32, (-v[1] * inverse) as f32, (-v[2] * inverse) as f32];
        self.settle(&simplex, a, b, n, gap_along(a, b, x, n));
        true
    }

    #[inline(always)]
    fn settle(&mut self, simplex: &WeightedSimplex, a: &Points, b: &Points, normal: V, gap: f32) {
        (self.normal, self.gap) = (normal, gap);
        (self.on_a, self.on_b) = ([0.0; 3], [0.0; 3]);
        self.count = simplex.count.min(self.features.len()) as u8;
        for k in 0..simplex.count.min(3) {
            let ((i, j), weight) = (simplex.features[k], simplex.weights[k] as f32);
            self.features[k] = (i, j);
            self.on_a = add_scaled(self.on_a, at(a, i), weight);
            self.on_b = add_scaled(self.on_b, at(b, j), weight);
        }
    }
}

/// Up to four points of A - B - far, and the weights of the one nearest the origin.
#[derive(Default)]
struct WeightedSimplex {
    points: [[f64; 3]; 4],
    features: [(u16, u16); 4],
    weights: [f64; 4],
    count: usize,
}

impl WeightedSimplex {
    #[inline(always)]
    fn push(&mut self, a: &Points, b: &Points, i: u16, j: u16, far: V) {
        let (p, q) = (at(a, i), at(b, j));
        let apart = |k: usize| f64::from(p[k]) - f64::from(q[k]) - f64::from(far[k]);
        self.points[self.count] = [apart(0), apart(1), apart(2)];
        self.features[self.count] = (i, j);
        self.count += 1;
    }

    #[inline(always)]
    fn holds(&self, i: u16, j: u16) -> bool {
        self.features[..self.count].contains(&(i, j))
    }

    /// Reduces to the face that holds the point nearest the origin, and returns that point; a tetrahedron around the
    /// origin stays whole.
    #[inline(always)]
    fn nearest(&mut self) -> [f64; 3] {
        match self.count {
            1 => self.weights[0] = 1.0,
            2 => self.segment(),
            3 => self.triangle(),
            _ => self.tetrahedron(),
        }
        let mut v = [0.0; 3];
        for k in 0..self.count {
            for (coordinate, p) in v.iter_mut().zip(self.points[k]) {
                *coordinate += self.weights[k] * p;
            }
        }
        v
    }

    #[inline(always)]
    fn keep(&mut self, kept: &[usize], weights: &[f64]) {
        for (to, (&from, &weight)) in kept.iter().zip(weights).enumerate() {
            self.points[to] = self.points[from];
            self.features[to] = self.features[from];
            self.weights[to] = weight;
        }
        self.count = kept.len();
    }

    #[inline(always)]
    fn segment(&mut self) {
        let [a, b, ..] = self.points;
        let ab = sub(b, a);
        let (t, length2) = (-dot3(a, ab), dot3(ab, ab));
        if t <= 0.0 {
            self.keep(&[0], &[1.0]);
        } else if t >= length2 {
            self.keep(&[1], &[1.0]);
        } else {
            self.keep(&[0, 1], &[1.0 - t / length2, t / length2]);
        }
    }

    #[inline(always)]
    fn triangle(&mut self) {
        let (kept, weights, count) = nearest_on_triangle([self.points[0], self.points[1], self.points[2]]);
        self.keep(&kept[..count], &weights[..count]);
    }

    #[inline(always)]
    /// The nearest of the faces whose plane has the origin on the outer side.
    fn tetrahedron(&mut self) {
        let mut best: Option<([usize; 3], [f64; 3], usize, f64)> = None;
        for (face, apex) in [([0, 1, 2], 3), ([0, 1, 3], 2), ([0, 2, 3], 1), ([1, 2, 3], 0)] {
            let [p, q, r] = [self.points[face[0]], self.points[face[1]], self.points[face[2]]];
            let normal = cross3(sub(q, p), sub(r, p));
            let (to_origin, to_apex) = (-dot3(normal, p), dot3(normal, sub(self.points[apex], p)));
            if to_origin * to_apex > 0.0 {
                continue;
            }
            let (kept, weights, count) = nearest_on_triangle([p, q, r]);
            let mut v = [0.0; 3];
            for k in 0..count {
                let point = self.points[face[kept[k]]];
                v = [v[0] + weights[k] * point[0], v[1] + weights[k] * point[1], v[2] + weights[k] * point[2]];
            }
            let distance2 = dot3(v, v);
            if best.is_none_or(|(.., least)| distance2 < least) {
                best = Some(([face[kept[0]], face[kept[1]], face[kept[2]]], weights, count, distance2));
            }
        }
        if let Some((kept, weights, count, _)) = best {
            self.keep(&kept[..count], &weights[..count]);
        } else {
            self.weights = [0.25; 4];
        }
    }
}

/// The vertices and weights of the point of triangle `abc` nearest the origin (C. Ericson, Real-Time Collision
/// Detection, 2005, Sec. 5.1.5).
#[inline(always)]
fn nearest_on_triangle([a, b, c]: [[f64; 3]; 3]) -> ([usize; 3], [f64; 3], usize) {
    let (ab, ac) = (sub(b, a), sub(c, a));
    let (d1, d2) = (-dot3(ab, a), -dot3(ac, a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return ([0, 0, 0], [1.0, 0.0, 0.0], 1);
    }
    let (d3, d4) = (-dot3(ab, b), -dot3(ac, b));
    if d3 >= 0.0 && d4 <= d3 {
        return ([1, 0, 0], [1.0, 0.0, 0.0], 1);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return ([0, 1, 0], [1.0 - t, t, 0.0], 2);
    }
    let (d5, d6) = (-dot3(ab, c), -dot3(ac, c));
    if d6 >= 0.0 && d5 <= d6 {
        return ([2, 0, 0], [1.0, 0.0, 0.0], 1);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return ([0, 2, 0], [1.0 - t, t, 0.0], 2);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return ([1, 2, 0], [1.0 - t, t, 0.0], 2);
    }
    let sum = va + vb + vc;
    ([0, 1, 2], [va / sum, vb / sum, vc / sum], 3)
}

/// The direction of `x`, or upwards where it has none.
#[inline(always)]
pub(super) fn direction_or_up(x: V) -> V {
    let length = dot(x, x).sqrt();
    if length > 1e-6 { scale(x, 1.0 / length) } else { [0.0, 0.0, 1.0] }
}

#[inline(always)]
fn at(p: &Points, i: u16) -> V {
    p.at(usize::from(i))
}

#[inline(always)]
pub(super) fn dot(a: V, b: V) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(super) fn length(a: V) -> f32 {
    dot(a, a).sqrt()
}

#[inline(always)]
pub(super) fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn neg(a: V) -> V {
    [-a[0], -a[1], -a[2]]
}

#[inline(always)]
pub(super) fn scale(a: V, s: f32) -> V {
    [a[0] * s, a[1] * s, a[2] * s]
}

#[inline(always)]
pub(super) fn add_scaled(a: V, b: V, s: f32) -> V {
    [a[0] + b[0] * s, a[1] + b[1] * s, a[2] + b[2] * s]
}

#[inline(always)]
fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot3(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross3(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
