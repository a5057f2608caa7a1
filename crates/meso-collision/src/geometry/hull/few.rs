//! The [`surface`](super::surface) around few points in general position: the same facets in the same order, in half
//! the time.
//!
//! When a facet is made, all waiting points are compared with its plane, several at a time. Facets that see a point are
//! the bits of one word. Later steps only look at these bits: which facets a point sees, and which points to list. A
//! sign that rounding could change ends the growth without an answer; then the exact surface is grown.
//!
//! No two facets of an answer lie in one plane. If they did, take the last added of their corners: the others were a
//! facet before, and while it waited it was in the plane of that facet, with an uncertain sign.

use super::loops::Loops;
use super::surface::{SHUFFLED_FROM, error_bound, far_basis};
use crate::geometry::exact::predicates::orient3d;
use crate::math::{Aabb, Vec3};
use crate::simd::{Lanes, Mask, Simd, Vectorized, dispatch};
use std::ops::{Deref, Index, IndexMut};

/// A point is one bit of a word.
const BITS: usize = u64::BITS as usize;
// The surface adds so few points in the order in which they are given.
const _: () = assert!(BITS <= SHUFFLED_FROM);

/// The growing surface and its scratch memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Few {
    /// The points relative to the middle of their box, rounded; then the same by axis.
    local: Vec<Vec3>,
    axes: Axes,
    /// Bound that |normal . p - offset| must exceed for its sign to be certain.
    error_bound: f64,
    /// The points that are still to be added.
    waiting: u64,
    facets: Triangles,
    visible: List<u8>,
    /// The edges of visible facets along the rim.
    horizon: List<Edge>,
    fresh: List<u8>,
    /// The fresh facet whose rim edge starts at a point, by point.
    fresh_at: Table<u8>,
}

/// The triangles of the surface. Each property has a list of its own: values just stored in parts are slow to load as a
/// whole.
#[derive(Clone, Debug, Default)]
struct Triangles {
    /// Point indices, counter-clockwise from outside, and the first again.
    vertices: Table<[u8; 4]>,
    /// The facet across the edge from `vertices[k]` to `vertices[k + 1]`.
    across: Table<[Edge; 3]>,
    is_removed: Table<bool>,
    /// The points that were waiting when the facet was made, and see it.
    seen_by: Table<u64>,
    /// The points that wait, each listed at one facet that it sees.
    listed: Table<u64>,
    /// One more than the largest facet index; removed facets below it whose places are free, the last to be taken
    /// first.
    bound: u8,
    unused: List<u8>,
}

/// Edge `k` of a facet, as 4 times the facet + k.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Edge(u16);

/// A list for each.
#[derive(Clone, Debug)]
struct Axes([[f64; BITS]; 3]);

impl Default for Axes {
    fn default() -> Self {
        Self([[0.0; BITS]; 3])
    }
}

impl Few {
    /// The facets around `points`, counter-clockwise from outside, and the loops of facets around the points, as
    /// [`Loops::around`] finds them; `None` where there are many points, facets that are no triangles, or signs that
    /// rounding leaves undecided.
    pub(super) fn facets_and_dual(&mut self, points: &[Vec3]) -> Option<[Loops; 2]> {
        if !(4..BITS).contains(&points.len()) {
            return None;
        }
        self.clear(points);
        let basis = far_basis(points, &self.local)?;
        let done = dispatch(Growing { few: self, points, basis });
        done.then(|| self.facets.lists(points.len()))
    }

    fn clear(&mut self, points: &[Vec3]) {
        let aabb = Aabb::around(points);
        let middle = (aabb.min + aabb.max) * 0.5;
        self.error_bound = error_bound(&aabb);
        self.local.clear();
        self.local.extend(points.iter().map(|p| p - middle));
        for (i, p) in self.local.iter().enumerate() {
            (0..3).for_each(|axis| self.axes.0[axis][i] = p[axis]);
        }
        self.facets.clear();
    }
}

/// The growth, in vector registers; false where a sign is uncertain.
struct Growing<'a> {
    few: &'a mut Few,
    points: &'a [Vec3],
    basis: [u32; 4],
}

impl Vectorized for Growing<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        let Self { few, points, basis } = self;
        let mut is_certain = few.start(simd, points, basis);
        while few.waiting != 0 && is_certain {
            is_certain = few.add(simd, few.waiting.trailing_zeros() as u8);
        }
        is_certain
    }
}

impl Few {
    /// The tetrahedron over `basis`, and every other point at the first facet that it sees.
    #[inline(always)]
    fn start<S: Simd>(&mut self, simd: S, points: &[Vec3], basis: [u32; 4]) -> bool {
        let [pa, pb, pc, pd] = basis.map(|i| &points[i as usize]);
        let [a, mut b, mut c, d] = basis.map(|i| i as u8);
        if orient3d(pa, pb, pc, pd) > 0.0 {
            std::mem::swap(&mut b, &mut c);
        }
        self.waiting = basis.iter().fold((1 << points.len()) - 1, |others, i| others & !(1 << i));
        self.fresh.len = 0;
        // Now d is below (a, b, c).
        let is_certain = [
            ([a, b, c], [(1, 0), (2, 0), (3, 0)]),
            ([b, a, d], [(0, 0), (3, 2), (2, 1)]),
            ([c, b, d], [(0, 1), (1, 2), (3, 1)]),
            ([a, c, d], [(0, 2), (2, 2), (1, 1)]),
        ]
        .into_iter()
        .all(|(vertices, across)| self.push(simd, vertices, across.map(|(f, k)| Edge::new(f, k))));
        self.list(self.waiting);
        is_certain
    }

    /// Adds a point that waits.
    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, point: u8) -> bool {
        self.waiting &= !(1 << point);
        let listed = self.find_visible(point);
        let is_certain = self.fan(simd, point);
        self.list(listed & self.waiting);
        self.facets.unused.append(&self.visible);
        is_certain
    }

    /// Removes the facets that `point` sees, and collects them and the edges around them; returns the points listed
    /// there.
    #[inline(always)]
    fn find_visible(&mut self, point: u8) -> u64 {
        let Self { visible, horizon, facets: Triangles { across, is_removed, seen_by, listed, .. }, .. } = self;
        let first = place_of(point, listed);
        is_removed[first] = true;
        (visible.len, horizon.len) = (0, 0);
        visible.push(first);
        let (mut done, mut points) = (0, 0);
        while done < visible.len {
            let f = visible.items[done];
            points |= std::mem::take(&mut listed[f]);
            for (k, beyond) in (0..).zip(across[f]) {
                let g = beyond.facet();
                let is_seen = seen_by[g] >> point & 1 == 1;
                // No guess would be right: both are written, and one is kept or none.
                visible.push_if(is_seen & !is_removed[g], g);
                horizon.push_if(!is_seen, Edge::new(f, k));
                is_removed[g] = is_seen;
            }
            done += 1;
        }
        points
    }

    /// Joins every edge of the horizon to `point`.
    #[inline(always)]
    fn fan<S: Simd>(&mut self, simd: S, point: u8) -> bool {
        self.fresh.len = 0;
        for h in 0..self.horizon.len {
            let edge = self.horizon.items[h];
            let (rim, k) = (&self.facets.vertices[edge.facet()], edge.k());
            let (from, to, beyond) = (rim[k], rim[k + 1], self.facets.across[edge.facet()][k]);
            if !self.push(simd, [from, to, point], [beyond; 3]) {
                return false;
            }
            let f = self.fresh.items[h];
            self.facets.across[beyond.facet()][beyond.k()] = Edge::new(f, 0);
            self.fresh_at[from] = f;
        }
        for &f in self.fresh.iter() {
            let next = self.fresh_at[self.facets.vertices[f][1]];
            self.facets.across[f][1] = Edge::new(next, 2);
            self.facets.across[next][2] = Edge::new(f, 1);
        }
        true
    }

    /// Makes a fresh facet; false where rounding may see a waiting point in its plane.
    #[inline(always)]
    fn push<S: Simd>(&mut self, simd: S, vertices: [u8; 3], across: [Edge; 3]) -> bool {
        let (above, below) = self.sides(simd, self.plane(vertices));
        self.fresh.push(self.facets.push(vertices, across, above));
        above | below == self.waiting
    }

    /// Twice the vector area of a triangle, and its product with a corner.
    #[inline(always)]
    fn plane(&self, vertices: [u8; 3]) -> (Vec3, f64) {
        let [a, b, c] = vertices;
        let (a, b, c) = (&self.local[usize::from(a)], &self.local[usize::from(b)], &self.local[usize::from(c)]);
        let normal = (b - a).cross(&(c - a));
        (normal, normal.dot(c))
    }

    /// The waiting points that are certainly above a plane, and those that are certainly below.
    #[inline(always)]
    fn sides<S: Simd>(&self, simd: S, (normal, offset): (Vec3, f64)) -> (u64, u64) {
        let (nx, ny, nz) = (S::F64::all(simd, normal.x), S::F64::all(simd, normal.y), S::F64::all(simd, normal.z));
        // Each rounds as the difference to the offset would.
        let (high, low) = (offset + self.error_bound, offset - self.error_bound);
        let (high, low) = (S::F64::all(simd, high), S::F64::all(simd, low));
        let Axes([x, y, z]) = &self.axes;
        let (mut above, mut below) = (0, 0);
        // From the first that waits on.
        let mut at = self.waiting.trailing_zeros() as usize / S::SIGNS_AT_ONCE * S::SIGNS_AT_ONCE;
        while at < self.local.len() {
            let (mut higher, mut lower) = (0, 0);
            for k in (0..S::SIGNS_AT_ONCE).step_by(S::F64::LANES) {
                let i = at + k;
                let (x, y, z) = (S::F64::load(simd, x, i), S::F64::load(simd, y, i), S::F64::load(simd, z, i));
                let height = nx * x + ny * y + nz * z;
                higher |= height.above(high).bits() << k;
                lower |= low.above(height).bits() << k;
            }
            above |= u64::from(higher) << at;
            below |= u64::from(lower) << at;
            at += S::SIGNS_AT_ONCE;
        }
        (above & self.waiting, below & self.waiting)
    }

    /// Lists each of the points at the first fresh facet that it sees; a point that sees none is inside for good.
    #[inline(always)]
    fn list(&mut self, mut points: u64) {
        for &f in self.fresh.iter() {
            let listed = points & self.facets.seen_by[f];
            self.facets.listed[f] = listed;
            points &= !listed;
        }
        self.waiting &= !points;
    }
}

/// The facet where a point is listed.
#[inline(always)]
fn place_of(point: u8, listed: &Table<u64>) -> u8 {
    // Not in vector registers: words that were just stored one by one are slow to load together.
    let has = |word: &u64| word >> point & 1 == 1;
    let (fours, _) = listed.0.as_chunks::<4>();
    let four = fours.iter().position(|[a, b, c, d]| has(&(a | b | c | d))).unwrap_or_default();
    let [a, b, c, _] = fours[four].map(|word| u8::from(!has(&word)));
    4 * four as u8 + a * (1 + b * (1 + c))
}

impl Triangles {
    fn clear(&mut self) {
        // Nothing is listed at the end of a growth, but where it broke off.
        self.listed.0[..usize::from(self.bound)].fill(0);
        self.bound = 0;
        self.unused.len = 0;
    }

    /// The triangles, and the loops of them around the points.
    fn lists(&self, points: usize) -> [Loops; 2] {
        let (number, count) = self.numbered();
        let mut facets =
            Loops { corners: Vec::with_capacity(3 * count), ends: (1..=count as u32).map(|f| 3 * f).collect() };
        let mut around = Around::default();
        for f in (0..self.bound).filter(|f| !self.is_removed[*f]) {
            let [a, b, c, _] = self.vertices[f];
            facets.corners.extend([a, b, c].map(u32::from));
            around.add(
                number[f],
                [a, b, c],
                self.across[f].map(|edge| Edge::new(number[edge.facet()], edge.k() as u8)),
            );
        }
        [facets, around.loops(points, 3 * count)]
    }

    /// How many triangles stand before each, and how many there are.
    fn numbered(&self) -> (Table<u8>, usize) {
        let (mut number, mut count) = (Table::default(), 0);
        for f in 0..self.bound {
            number[f] = count;
            count += u8::from(!self.is_removed[f]);
        }
        (number, usize::from(count))
    }

    #[inline(always)]
    fn push(&mut self, [a, b, c]: [u8; 3], across: [Edge; 3], seen_by: u64) -> u8 {
        let f = self.unused.pop().unwrap_or_else(|| {
            self.bound += 1;
            self.bound - 1
        });
        self.vertices[f] = [a, b, c, a];
        self.across[f] = across;
        self.is_removed[f] = false;
        self.seen_by[f] = seen_by;
        f
    }
}

/// More than the corners of all triangles, four places to each.
const CORNERS: usize = 4 * 2 * BITS;

/// The corners around every point, linked: a corner is the edge that starts there.
struct Around {
    /// By corner, that of the next triangle around the same point.
    next: [Edge; CORNERS],
    /// By point, the smallest point that follows it in a triangle, and that corner, in the low half.
    first: [u32; BITS],
}

impl Default for Around {
    fn default() -> Self {
        Self { next: [Edge(0); CORNERS], first: [u32::MAX; BITS] }
    }
}

impl Around {
    /// Adds a triangle, of which `across` lies beyond the edges.
    #[inline(always)]
    fn add(&mut self, triangle: u8, [a, b, c]: [u8; 3], [ab, bc, ca]: [Edge; 3]) {
        for (k, point, after, edge_before) in [(0, a, b, ca), (1, b, c, ab), (2, c, a, bc)] {
            let corner = Edge::new(triangle, k).0;
            // The facet beyond the edge that ends here starts here.
            self.next[usize::from(corner) % CORNERS] = edge_before;
            let first = &mut self.first[usize::from(point) % BITS];
            *first = u32::min(*first, u32::from(after) << 16 | u32::from(corner));
        }
    }

    /// The loops of triangles around the first points, which have so many `corners`.
    fn loops(&self, points: usize, corners: usize) -> Loops {
        // The corners are there: no look at the room for each.
        let mut loops = Loops { corners: vec![0; corners], ends: Vec::with_capacity(points) };
        let (mut places, mut end) = (loops.corners.iter_mut(), 0);
        for first in self.first[..points].iter().filter(|first| **first != u32::MAX) {
            let first = Edge(*first as u16);
            let mut corner = first;
            for place in &mut places {
                *place = u32::from(corner.facet());
                corner = self.next[usize::from(corner.0) % CORNERS];
                end += 1;
                if corner == first {
                    break;
                }
            }
            loops.ends.push(end);
        }
        loops
    }
}

impl Edge {
    #[inline(always)]
    fn new(facet: u8, k: u8) -> Self {
        Self(u16::from(facet) << 2 | u16::from(k))
    }

    #[inline(always)]
    fn facet(self) -> u8 {
        (self.0 >> 2) as u8
    }

    #[inline(always)]
    fn k(self) -> usize {
        usize::from(self.0 & 3)
    }
}

/// As many entries as a byte has values: no index is out of bounds.
#[derive(Clone, Debug)]
struct Table<T>([T; 256]);

impl<T: Copy + Default> Default for Table<T> {
    fn default() -> Self {
        Self([T::default(); 256])
    }
}

impl<T> Index<u8> for Table<T> {
    type Output = T;
    #[inline(always)]
    fn index(&self, i: u8) -> &T {
        &self.0[usize::from(i)]
    }
}

impl<T> IndexMut<u8> for Table<T> {
    #[inline(always)]
    fn index_mut(&mut self, i: u8) -> &mut T {
        &mut self.0[usize::from(i)]
    }
}

/// The first `len` entries of a table.
#[derive(Clone, Debug, Default)]
struct List<T: Copy + Default> {
    items: Table<T>,
    len: u8,
}

impl<T: Copy + Default> List<T> {
    #[inline(always)]
    fn push(&mut self, item: T) {
        self.push_if(true, item);
    }

    #[inline(always)]
    fn push_if(&mut self, is_kept: bool, item: T) {
        self.items[self.len] = item;
        self.len += u8::from(is_kept);
    }

    /// Copies sixteen items at a time: nearly always at once.
    #[inline(always)]
    fn append(&mut self, other: &Self) {
        for from in (0..usize::from(other.len)).step_by(16) {
            let to = usize::from(self.len) + from;
            self.items.0[to..to + 16].copy_from_slice(&other.items.0[from..from + 16]);
        }
        self.len += other.len;
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<T> {
        self.len = self.len.checked_sub(1)?;
        Some(self.items[self.len])
    }
}

impl<T: Copy + Default> Deref for List<T> {
    type Target = [T];
    #[inline(always)]
    fn deref(&self) -> &[T] {
        &self.items.0[..usize::from(self.len)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::hull::surface::Surface;
    use crate::random::Stream;

    fn by_surface(points: &[Vec3]) -> [Loops; 2] {
        let mut surface = Surface::default();
        surface.build(points).unwrap();
        let corners: Vec<u32> = surface.facets().flat_map(|(_, facet)| facet.vertices).collect();
        let facets = Loops { ends: (3..=corners.len() as u32).step_by(3).collect(), corners };
        let around = facets.around(points.len());
        [facets, around]
    }

    #[test]
    fn the_facets_their_order_and_what_is_around_points_are_those_of_the_surface() {
        let (mut stream, mut few) = (Stream::new(9), Few::default());
        let corner = Vec3::new(3.0, 2.0, 1.0);
        let (mut found, mut inside) = (0, 0);
        for case in 0..600 {
            let count = 4 + case % (BITS - 4);
            // In turn on an ellipsoid and in a box, where most points end up inside.
            let point = |_| match case % 2 {
                0 => stream.direction().component_mul(&corner),
                _ => stream.point(&-corner, &corner),
            };
            let points: Vec<Vec3> = (0..count).map(point).collect();
            if let Some(loops) = few.facets_and_dual(&points) {
                assert_eq!(loops, by_surface(&points), "case {case}");
                found += 1;
                inside += usize::from(loops[0].len() < 2 * count - 4);
            }
        }
        assert!(found > 590 && inside > 200, "{found} found, {inside} with points inside");
    }

    #[test]
    fn signs_that_rounding_hides_are_left_to_the_surface() {
        let (mut stream, mut few) = (Stream::new(10), Few::default());
        let corners = |size: f64| {
            (0..8).map(move |i| Vec3::new(size * f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
        };
        for case in 0..100 {
            let size = stream.uniform(0.5, 2.0);
            let apex = Vec3::new(size / 2.0, 0.5, 2.0 + stream.uniform(0.0, 1.0));
            // A box has faces of four corners; so has the rest of it under an apex.
            let flat: Vec<Vec3> = corners(size).chain([apex]).collect();
            assert_eq!(few.facets_and_dual(&flat), None, "case {case}");
            // Entries left behind do no harm.
            let points: Vec<Vec3> = (0..40).map(|_| stream.direction()).collect();
            assert_eq!(few.facets_and_dual(&points), Some(by_surface(&points)), "case {case}");
        }
    }

    #[test]
    fn facets_in_one_plane_are_found_in_any_order_of_their_corners() {
        let mut few = Few::default();
        let square = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]].map(Vec3::from);
        let mut points = [Vec3::new(0.1, 0.2, 1.0), square[0], square[1], square[2], square[3]];
        for turn in 0..5 {
            points.rotate_left(1);
            assert_eq!(few.facets_and_dual(&points), None, "turn {turn}");
            points.swap(turn % 5, (turn + 2) % 5);
        }
    }

    #[test]
    fn too_few_and_too_many_points_are_left_alone() {
        let (mut stream, mut few) = (Stream::new(11), Few::default());
        let points: Vec<Vec3> = (0..=BITS).map(|_| stream.direction()).collect();
        assert_eq!(few.facets_and_dual(&points[..3]), None);
        assert!(few.facets_and_dual(&points[..4]).is_some());
        assert!(few.facets_and_dual(&points[..BITS - 1]).is_some());
        assert_eq!(few.facets_and_dual(&points[..BITS]), None);
    }
}
