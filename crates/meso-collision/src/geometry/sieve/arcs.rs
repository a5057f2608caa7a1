//! Arcs of the Gauss map, and the pieces of them on which a body is narrow.
//!
//! An arc is the set of directions along which one edge is outermost: the great arc between the normals of its two faces.

use crate::geometry::{Plane, Polyhedron};
use crate::math::Vec3;
use crate::simd::{Lanes, Mask, Simd};

/// The most numbers in a register of f64.
pub(super) const LANES: usize = 8;
/// Vertices that can exclude whole arcs; each has one bit.
const BITS: usize = 64;
/// Bodies with at most this many vertices find the face beyond an edge in a table, others by sorting.
const TABLE: usize = 64;

/// Vertices relative to the first, by axis, in registers. The last vertex fills the last register.
pub(super) struct CirclePoints<S: Simd> {
    registers: Vec<[S::F64; 3]>,
}

/// Directions along which an edge is outermost.
///
/// The direction at t is (1 - t^2) n + 2 t m over 1 + t^2, where t is the tangent of half the angle from n: n = `start`,
/// m = `across`.
#[derive(Clone, Copy)]
pub(super) struct Arc {
    /// A vertex of the edge, relative to the body's first vertex.
    corner: Vec3,
    /// Unit normal of the first face.
    start: Vec3,
    /// Unit vector orthogonal to `start` and to the edge, on the side of the second normal.
    across: Vec3,
    /// Cosine and sine of the angle between the normals.
    turn: [f64; 2],
    /// Tangent of half this angle.
    end: f64,
}

/// A part of an arc, by its t at both ends.
#[derive(Clone, Copy)]
pub(super) struct ArcPiece {
    from: f64,
    to: f64,
}

/// Directions at both ends of a piece.
pub(super) type Ends = [Vec3; 2];

impl<S: Simd> CirclePoints<S> {
    #[inline(always)]
    pub(super) fn of(simd: S, body: &Polyhedron) -> Self {
        let vertices = body.vertices();
        let (first, last) = (&vertices[0], vertices.len() - 1);
        let mut registers = Vec::with_capacity(vertices.len().div_ceil(S::F64::LANES));
        for at in starts::<S>(vertices.len()) {
            let lane = |axis: usize| S::F64::of_lanes(simd, |l| vertices[(at + l).min(last)][axis] - first[axis]);
            registers.push([lane(0), lane(1), lane(2)]);
        }
        Self { registers }
    }

    /// Width along the unit vector `u`.
    #[inline(always)]
    pub(super) fn width(&self, simd: S, u: &Vec3) -> f64 {
        let [x, y, z] = all(simd, u);
        let zero = S::F64::all(simd, 0.0);
        let [mut most, mut least] = [S::F64::all(simd, f64::NEG_INFINITY); 2];
        for &[px, py, pz] in &self.registers {
            let along = px.times_plus(x, py.times_plus(y, pz * z));
            most = most.max(along);
            least = least.max(zero - along);
        }
        most.largest() + least.largest()
    }

    /// The first vertices that are more than `side` below a plane, one bit each; the plane's origin is `first`.
    #[inline(always)]
    fn excluding(&self, simd: S, plane: &Plane, first: &Vec3, side: f64) -> u64 {
        let [x, y, z] = all(simd, &plane.normal);
        let limit = S::F64::all(simd, side - (plane.offset - plane.normal.dot(first)));
        let zero = S::F64::all(simd, 0.0);
        let mut bits = 0;
        for (&[px, py, pz], at) in self.registers.iter().zip(0..BITS / S::F64::LANES) {
            let along = px.times_plus(x, py.times_plus(y, pz * z));
            bits |= u64::from((zero - along).above(limit).bits()) << (at * S::F64::LANES);
        }
        bits
    }
}

/// The first lanes of the registers that hold `count` numbers.
#[inline(always)]
fn starts<S: Simd>(count: usize) -> impl Iterator<Item = usize> {
    (0..count.div_ceil(S::F64::LANES)).map(|register| register * S::F64::LANES)
}

/// The vertex that is outermost along `u`, relative to the first.
pub(super) fn support(body: &Polyhedron, u: &Vec3) -> Vec3 {
    let first = body.vertices()[0];
    let (mut most, mut best) = (f64::NEG_INFINITY, Vec3::zeros());
    for p in body.vertices() {
        let along = (p - first).dot(u);
        if along > most {
            (most, best) = (along, p - first);
        }
    }
    best
}

/// The coordinates of a vector in all lanes.
#[inline(always)]
pub(super) fn all<S: Simd>(simd: S, v: &Vec3) -> [S::F64; 3] {
    [S::F64::all(simd, v.x), S::F64::all(simd, v.y), S::F64::all(simd, v.z)]
}

impl Arc {
    /// The unit direction at `t`.
    #[inline(always)]
    fn direction(&self, t: f64) -> Vec3 {
        let scale = 1.0 / (1.0 + t * t);
        self.start * ((1.0 - t * t) * scale) + self.across * (2.0 * t * scale)
    }

    /// Directions at both ends of a piece.
    #[inline(always)]
    pub(super) fn ends(&self, piece: &ArcPiece) -> Ends {
        [self.direction(piece.from), self.direction(piece.to)]
    }

    /// The direction on the arc's great circle that is orthogonal to `u`; not finite where all are.
    #[inline(always)]
    pub(super) fn orthogonal_to(&self, u: &Vec3) -> Vec3 {
        (self.start * self.across.dot(u) - self.across * self.start.dot(u)).normalize()
    }

    /// Replaces `pieces` by those on which the body is at most `side` wide.
    #[inline(always)]
    pub(super) fn narrow<S: Simd>(
        &self,
        simd: S,
        points: &CirclePoints<S>,
        side: f64,
        excluded: &mut Excluded,
        pieces: &mut Vec<ArcPiece>,
    ) {
        self.exclude(simd, points, side, excluded);
        excluded.solve(simd, side);
        pieces.clear();
        let mut at = 0.0;
        loop {
            at = excluded.end_of(simd, at);
            if at >= self.end {
                return;
            }
            let next = excluded.next_after(simd, at).min(self.end);
            pieces.push(ArcPiece { from: at, to: next });
            at = next;
        }
    }

    /// Replaces `excluded` by the vertices whose distance from the corner, projected, exceeds `side` on the arc.
    #[inline(always)]
    fn exclude<S: Simd>(&self, simd: S, points: &CirclePoints<S>, side: f64, excluded: &mut Excluded) {
        let (corner, start, across) = (all(simd, &self.corner), all(simd, &self.start), all(simd, &self.across));
        let (cosine, sine) = (S::F64::all(simd, self.turn[0]), S::F64::all(simd, self.turn[1]));
        let (limit, square, zero) = (S::F64::all(simd, side), S::F64::all(simd, side * side), S::F64::all(simd, 0.0));
        excluded.count = 0;
        for &[x, y, z] in &points.registers {
            let (dx, dy, dz) = (corner[0] - x, corner[1] - y, corner[2] - z);
            let c = dx.times_plus(start[0], dy.times_plus(start[1], dz * start[2]));
            let s = dx.times_plus(across[0], dy.times_plus(across[1], dz * across[2]));
            let at_ends = c.above(limit) | c.times_plus(cosine, s * sine).above(limit);
            let between = s.above(zero) & (c * sine).above(s * cosine) & c.times_plus(c, s * s).above(square);
            excluded.push(c, s, (at_ends | between).bits());
        }
        excluded.fill(simd);
    }
}

/// Pieces of an arc on which the distance between two vertices, projected, exceeds a side.
///
/// The projection at an angle is c cos + s sin. After the last piece come zeros, whose ends are not a number.
pub(super) struct Excluded {
    c: Vec<f64>,
    s: Vec<f64>,
    from: Vec<f64>,
    to: Vec<f64>,
    count: usize,
}

impl Excluded {
    /// Room for the pieces of all points.
    pub(super) fn of<S: Simd>(points: &CirclePoints<S>) -> Self {
        let room = || vec![0.0; points.registers.len() * S::F64::LANES + LANES];
        Self { c: room(), s: room(), from: room(), to: room(), count: 0 }
    }

    /// Adds the lanes of these bits.
    #[inline(always)]
    fn push<L: Lanes<T = f64>>(&mut self, c: L, s: L, bits: u32) {
        c.front(bits).store(&mut self.c, self.count);
        s.front(bits).store(&mut self.s, self.count);
        self.count += bits.count_ones() as usize;
    }

    /// Fills the last register with zeros.
    #[inline(always)]
    fn fill<S: Simd>(&mut self, simd: S) {
        S::F64::all(simd, 0.0).store(&mut self.c, self.count);
        S::F64::all(simd, 0.0).store(&mut self.s, self.count);
    }

    /// Finds the ends of the pieces: tangents of half the angles where the projection is `side`.
    #[inline(always)]
    fn solve<S: Simd>(&mut self, simd: S, side: f64) {
        let (limit, zero) = (S::F64::all(simd, side), S::F64::all(simd, 0.0));
        for at in starts::<S>(self.count) {
            let (c, s) = (S::F64::load(simd, &self.c, at), S::F64::load(simd, &self.s, at));
            let square = c * c + s * s;
            let root = (square - limit * limit).max(zero).sqrt();
            let from = (s * limit - c * root) / (square + (c * limit + s * root));
            let to = (s * limit + c * root) / (square + (c * limit - s * root));
            // A piece that contains the angle of 180 degrees ends beyond every arc.
            let to = to.or(from.above(to), S::F64::all(simd, f64::INFINITY));
            from.store(&mut self.from, at);
            to.store(&mut self.to, at);
        }
    }

    /// The end of the pieces that contain `at`, one after the other; `at` if there is none.
    #[inline(always)]
    fn end_of<S: Simd>(&self, simd: S, at: f64) -> f64 {
        let mut end = at;
        loop {
            let now = S::F64::all(simd, end);
            let mut most = now;
            for k in starts::<S>(self.count) {
                let (from, to) = (S::F64::load(simd, &self.from, k), S::F64::load(simd, &self.to, k));
                most = most.or(to.above(most).but_not(from.above(now)), to);
            }
            let most = most.largest();
            if most <= end {
                return end;
            }
            end = most;
        }
    }

    /// The start of the first piece after `at`; infinity if there is none.
    #[inline(always)]
    fn next_after<S: Simd>(&self, simd: S, at: f64) -> f64 {
        let (now, zero) = (S::F64::all(simd, -at), S::F64::all(simd, 0.0));
        let mut most = S::F64::all(simd, f64::NEG_INFINITY);
        for k in starts::<S>(self.count) {
            let before = zero - S::F64::load(simd, &self.from, k);
            most = most.or(before.above(most) & now.above(before), before);
        }
        -most.largest()
    }
}

impl Arc {
    /// The arcs of a body that no single vertex excludes at `side`.
    ///
    /// The projected distance from a vertex to an edge is a cosine along the arc, so it exceeds `side` between two
    /// directions where it does.
    #[inline(always)]
    pub(super) fn open<S: Simd>(simd: S, body: &Polyhedron, points: &CirclePoints<S>, side: f64) -> Vec<Self> {
        let (planes, vertices): (Vec<_>, _) = (body.planes().collect(), body.vertices());
        let mut excluding = Vec::with_capacity(planes.len());
        for plane in &planes {
            excluding.push(points.excluding(simd, plane, &vertices[0], side));
        }
        let mut arcs = Vec::new();
        each_edge(body, |[i, k], [f, g]| {
            if excluding[f as usize] & excluding[g as usize] == 0 {
                let normals = [planes[f as usize].normal, planes[g as usize].normal];
                arcs.push(Self::of(
                    &(vertices[i as usize] - vertices[0]),
                    &(vertices[k as usize] - vertices[0]),
                    normals,
                ));
            }
        });
        arcs
    }

    /// The arc of the edge between two vertices, from the `start` normal to the other.
    #[inline(always)]
    fn of(corner: &Vec3, to: &Vec3, [start, other]: [Vec3; 2]) -> Self {
        let across = (to - corner).cross(&start).normalize();
        let across = if across.dot(&other) < 0.0 { -across } else { across };
        let turn = [start.dot(&other), across.dot(&other)];
        Self { corner: *corner, start, across, turn, end: turn[1] / (1.0 + turn[0]) }
    }
}

/// Visits each edge with its two faces.
fn each_edge(body: &Polyhedron, mut visit: impl FnMut([u32; 2], [u32; 2])) {
    let count = body.vertices().len();
    if count > TABLE {
        let mut sides = Vec::new();
        each_side(body, |from, to, face| sides.push((from.min(to), from.max(to), face)));
        sides.sort_unstable();
        return sides.chunks_exact(2).for_each(|pair| visit([pair[0].0, pair[0].1], [pair[0].2, pair[1].2]));
    }
    let mut faces = vec![0_u16; count * count];
    each_side(body, |from, to, face| faces[from as usize * count + to as usize] = face as u16);
    each_side(body, |from, to, face| {
        if from < to {
            visit([from, to], [face, u32::from(faces[to as usize * count + from as usize])]);
        }
    });
}

/// Visits the sides of each face.
fn each_side(body: &Polyhedron, mut visit: impl FnMut(u32, u32, u32)) {
    if let Some(triangles) = body.face_lists().byte_triangles() {
        for (triangle, face) in triangles.iter().zip(0..) {
            let [a, b, c] = triangle.map(u32::from);
            [[a, b], [b, c], [c, a]].into_iter().for_each(|[from, to]| visit(from, to, face));
        }
        return;
    }
    for (corners, face) in body.faces().zip(0..) {
        let last = corners.vertex(corners.len() - 1);
        corners.iter().fold(last, |from, to| {
            visit(from, to, face);
            to
        });
    }
}
