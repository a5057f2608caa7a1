//! The hull as a closed surface of triangles, grown point by point (Clarkson and Shor 1989; Barber et al. 1996).
//!
//! A waiting point is listed under one facet that it sees. Adding it removes the facets it sees (a disc), joins the
//! disc's rim to it, and hands the points of the removed facets to the new ones. A point in the plane of a facet does
//! not see it: so no new triangle is degenerate, and the surface stays (weakly) convex for any input.

use super::HullError;
use crate::geometry::exact::predicates::{collinear, orient3d};
use crate::math::{Aabb, Vec3};

/// No facet, no point.
const NONE: u32 = u32::MAX;
/// The mark of a facet that was removed.
const REMOVED: u32 = u32::MAX;
/// From this many points on they are added in a shuffled order: a bad order costs O(n^2) facets, a random one O(n).
pub(super) const SHUFFLED_FROM: usize = 64;

/// A triangle of the surface.
#[derive(Clone, Debug)]
pub(super) struct Triangle {
    /// Point indices, counter-clockwise from outside.
    pub(super) vertices: [u32; 3],
    /// `neighbours[k]` shares the edge from `vertices[k]` to `vertices[k + 1]`.
    pub(super) neighbours: [u32; 3],
    /// Twice the vector area, and its product with a vertex; both rounded.
    normal: Vec3,
    offset: f64,
    /// First of the waiting points that see this facet.
    waiting: u32,
    mark: u32,
}

/// The growing surface and its scratch memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Surface {
    facets: Vec<Triangle>,
    unused: Vec<u32>,
    /// The points relative to the middle of their box, rounded.
    local: Vec<Vec3>,
    /// Bound that |normal . p - offset| must exceed for its sign to be certain.
    error_bound: f64,
    /// A facet that sees the waiting point, by point.
    seen_facet: Vec<u32>,
    /// The next waiting point of the same facet, by point.
    next_waiting: Vec<u32>,
    order: Vec<u32>,
    visible: Vec<u32>,
    horizon: Vec<(u32, u8)>,
    fresh: Vec<u32>,
    /// The fresh facet whose rim edge starts at a point, by point.
    fresh_at: Vec<u32>,
    stamp: u32,
}

impl Surface {
    /// Grows the surface around `points`.
    pub(super) fn build(&mut self, points: &[Vec3]) -> Result<(), HullError> {
        self.clear(points);
        let basis = match far_basis(points, &self.local) {
            Some(basis) => basis,
            None => affine_basis(points).map_err(|dimension| HullError::LowerDimensional { dimension })?,
        };
        self.start(points, basis);
        for k in 0..points.len() {
            let point = self.order[k];
            if self.seen_facet[point as usize] != NONE {
                self.add(points, point);
            }
        }
        Ok(())
    }

    /// The facets with their indices, in no particular order.
    pub(super) fn facets(&self) -> impl Iterator<Item = (u32, &Triangle)> {
        (0..).zip(&self.facets).filter(|(_, facet)| facet.mark != REMOVED)
    }

    pub(super) fn facet(&self, f: u32) -> &Triangle {
        &self.facets[f as usize]
    }

    /// One more than the largest facet index.
    pub(super) fn facet_bound(&self) -> usize {
        self.facets.len()
    }

    /// True when `point`, which must not be above facet `f`, lies in its plane.
    pub(super) fn in_plane(&self, points: &[Vec3], f: u32, point: u32) -> bool {
        let facet = self.facet(f);
        let height = facet.normal.dot(&self.local[point as usize]) - facet.offset;
        height >= -self.error_bound && exact_height(points, facet, point) == 0.0
    }

    fn clear(&mut self, points: &[Vec3]) {
        let n = points.len();
        let aabb = Aabb::around(points);
        let middle = (aabb.min + aabb.max) * 0.5;
        self.facets.clear();
        self.facets.reserve(2 * n.min(1024));
        self.unused.clear();
        self.local.clear();
        self.local.extend(points.iter().map(|p| p - middle));
        self.error_bound = error_bound(&aabb);
        self.seen_facet.clear();
        self.seen_facet.resize(n, NONE);
        // An entry is read only after it was written.
        for list in [&mut self.next_waiting, &mut self.fresh_at] {
            list.resize(n.max(list.len()), NONE);
        }
        self.order.clear();
        self.order.extend(0..n as u32);
        if n >= SHUFFLED_FROM {
            shuffle(&mut self.order);
        }
        self.stamp = 0;
    }

    /// The tetrahedron over `basis`, and every other point listed under a facet it sees.
    fn start(&mut self, points: &[Vec3], basis: [u32; 4]) {
        let [a, mut b, mut c, d] = basis;
        let [pa, pb, pc, pd] = [a, b, c, d].map(|i| &points[i as usize]);
        if orient3d(pa, pb, pc, pd) > 0.0 {
            std::mem::swap(&mut b, &mut c);
        }
        // Now d is below (a, b, c).
        for (vertices, neighbours) in
            [([a, b, c], [1, 2, 3]), ([b, a, d], [0, 3, 2]), ([c, b, d], [0, 1, 3]), ([a, c, d], [0, 2, 1])]
        {
            self.push(vertices, neighbours);
            self.fresh.push(self.facets.len() as u32 - 1);
        }
        for point in 0..points.len() as u32 {
            if !basis.contains(&point) {
                self.list(points, point);
            }
        }
        self.fresh.clear();
    }

    /// Adds a point that sees at least one facet.
    fn add(&mut self, points: &[Vec3], point: u32) {
        self.find_visible(points, point);
        self.fan(point);
        for k in 0..self.visible.len() {
            let f = self.visible[k];
            let mut waiting = self.facets[f as usize].waiting;
            while waiting != NONE {
                let next = self.next_waiting[waiting as usize];
                if waiting != point {
                    self.list(points, waiting);
                }
                waiting = next;
            }
            self.facets[f as usize].mark = REMOVED;
            self.unused.push(f);
        }
        self.fresh.clear();
    }

    /// Collects the facets that `point` sees, and the edges around them.
    fn find_visible(&mut self, points: &[Vec3], point: u32) {
        self.stamp += 2;
        let (seen, hidden) = (self.stamp - 1, self.stamp);
        self.visible.clear();
        self.horizon.clear();
        let at = self.local[point as usize];
        let first = self.seen_facet[point as usize];
        self.facets[first as usize].mark = seen;
        self.visible.push(first);
        let mut done = 0;
        while done < self.visible.len() {
            let f = self.visible[done];
            for k in 0..3 {
                let g = self.facets[f as usize].neighbours[k];
                let mark = self.facets[g as usize].mark;
                if mark == seen {
                    continue;
                }
                if mark != hidden && self.sees(points, g, point, &at) {
                    self.facets[g as usize].mark = seen;
                    self.visible.push(g);
                } else {
                    self.facets[g as usize].mark = hidden;
                    self.horizon.push((f, k as u8));
                }
            }
            done += 1;
        }
    }

    /// Joins every edge of the horizon to `point`.
    fn fan(&mut self, point: u32) {
        for h in 0..self.horizon.len() {
            let (f, k) = self.horizon[h];
            let k = usize::from(k);
            let old = &self.facets[f as usize];
            let (a, b, beyond) = (old.vertices[k], old.vertices[(k + 1) % 3], old.neighbours[k]);
            let f = self.push([a, b, point], [beyond, NONE, NONE]);
            let beyond = &mut self.facets[beyond as usize];
            let back = beyond.vertices.iter().position(|&v| v == b).expect("neighbours share an edge");
            beyond.neighbours[back] = f;
            self.fresh_at[a as usize] = f;
            self.fresh.push(f);
        }
        for &f in &self.fresh {
            let next = self.fresh_at[self.facets[f as usize].vertices[1] as usize];
            self.facets[f as usize].neighbours[1] = next;
            self.facets[next as usize].neighbours[2] = f;
        }
    }

    /// Makes a facet; returns its index.
    fn push(&mut self, vertices: [u32; 3], neighbours: [u32; 3]) -> u32 {
        let [a, b, c] = vertices.map(|i| self.local[i as usize]);
        let normal = (b - a).cross(&(c - a));
        let facet = Triangle { vertices, neighbours, normal, offset: normal.dot(&c), waiting: NONE, mark: 0 };
        if let Some(f) = self.unused.pop() {
            self.facets[f as usize] = facet;
            f
        } else {
            self.facets.push(facet);
            self.facets.len() as u32 - 1
        }
    }

    /// Lists `point` under the first fresh facet that it sees; a point that sees none is inside for good.
    ///
    /// A point above a removed facet and outside the new hull sees a fresh facet. On the segment from it into the
    /// removed facet's inside, the part just before that facet is outside the old hull, so the segment enters the new
    /// hull through a facet the old one did not have.
    fn list(&mut self, points: &[Vec3], point: u32) {
        let at = self.local[point as usize];
        let f = self.fresh.iter().copied().find(|&f| self.sees(points, f, point, &at)).unwrap_or(NONE);
        self.seen_facet[point as usize] = f;
        if f != NONE {
            self.next_waiting[point as usize] = self.facets[f as usize].waiting;
            self.facets[f as usize].waiting = point;
        }
    }

    /// True when `point`, `at` in local coordinates, is strictly above facet `f`.
    fn sees(&self, points: &[Vec3], f: u32, point: u32, at: &Vec3) -> bool {
        let facet = &self.facets[f as usize];
        let height = facet.normal.dot(at) - facet.offset;
        if height.abs() > self.error_bound { height > 0.0 } else { exact_height(points, facet, point) > 0.0 }
    }
}

/// Bound that |normal . p - offset| must exceed for its sign to be certain, for points about the middle of their box.
///
/// In units of the box's edges X, Y, Z and of u = 2^-53: local coordinates err by u/2, their differences by 2u, a
/// normal's component (at most 2) by 12u, `normal . p` and `offset` by 29u each, their difference by 64u.
pub(super) fn error_bound(aabb: &Aabb) -> f64 {
    80.0 * (f64::EPSILON / 2.0) * aabb.size().product()
}

/// The exact sign of a point's height above a facet.
fn exact_height(points: &[Vec3], facet: &Triangle, point: u32) -> f64 {
    let [a, b, c] = facet.vertices.map(|i| &points[i as usize]);
    orient3d(a, b, c, &points[point as usize])
}

/// Four points far from each other, or `None` where rounding hides whether they span a volume; `local` are the points
/// about a place nearby.
pub(super) fn far_basis(points: &[Vec3], local: &[Vec3]) -> Option<[u32; 4]> {
    let i = farthest(local, |p| -p.x);
    let a = local[i];
    let j = farthest(local, |p| (p - a).norm_squared());
    let u = local[j] - a;
    let k = farthest(local, |p| u.cross(&(p - a)).norm_squared());
    let normal = u.cross(&(local[k] - a));
    let l = farthest(local, |p| normal.dot(&(p - a)).abs());
    let solid = orient3d(&points[i], &points[j], &points[k], &points[l]) != 0.0;
    solid.then_some([i, j, k, l].map(|i| i as u32))
}

/// The first point of the largest measure.
fn farthest(points: &[Vec3], measure: impl Fn(&Vec3) -> f64) -> usize {
    let mut best = (0, f64::NEG_INFINITY);
    for (i, p) in points.iter().enumerate() {
        let value = measure(p);
        if value > best.1 {
            best = (i, value);
        }
    }
    best.0
}

/// The first four points that span a volume, or the dimension that all of them span.
pub(super) fn affine_basis(points: &[Vec3]) -> Result<[u32; 4], u8> {
    let a = &points[0];
    let find = |from: usize, apart: &dyn Fn(&Vec3) -> bool| (from..points.len()).find(|&i| apart(&points[i]));
    let i = find(1, &|p| p != a).ok_or(0)?;
    let b = &points[i];
    let j = find(i + 1, &|p| !collinear(a, b, p)).ok_or(1)?;
    let c = &points[j];
    let k = find(j + 1, &|p| orient3d(a, b, c, p) != 0.0).ok_or(2)?;
    Ok([0, i, j, k].map(|i| i as u32))
}

/// A fixed shuffle (Fisher-Yates, splitmix64): the hull does not depend on the order, only its cost does.
fn shuffle(order: &mut [u32]) {
    let mut state = 0_u64;
    for i in (1..order.len()).rev() {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        order.swap(i, ((z ^ (z >> 31)) % (i as u64 + 1)) as usize);
    }
}
