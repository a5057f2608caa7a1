//! Eight pairs at a time through the ellipsoids and the portal search, on AVX-512.
//!
//! The same steps as [`ellipsoid`](super::super::ellipsoid) and [`portal`](super::super::portal), lane by lane. After
//! every step the pairs that are decided leave, the rest close ranks, and new ones are let in, so that no lane idles.
//! Whatever is in doubt is left to the single query.

use super::super::batch::Ask;
use super::super::body::{Body, Group};
use super::super::certificate::{ENCLOSING, UNDERFLOW};
use super::super::ellipsoid::SLACK;
use super::x86::keys512;
use super::{HEIGHT_ERROR, INDEX};
use crate::math::Vec3;
use std::arch::x86_64::*;

/// Pairs carried through the search together: so few that their points stay in the first-level cache.
const CROWD: usize = 32;
/// Steps after which a pair is left to the single query.
const MAX_STEPS: f64 = 32.0;
const LANES: usize = 8;

/// One number for each of eight pairs.
#[derive(Clone, Copy)]
struct Eight(__m512d);

/// One vector for each of eight pairs.
#[derive(Clone, Copy)]
struct Vectors {
    x: Eight,
    y: Eight,
    z: Eight,
}

macro_rules! operator {
    ($trait:ident, $method:ident, $intrinsic:ident) => {
        impl std::ops::$trait for Eight {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: made only where AVX-512 was detected; so for all of this file.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    };
}
operator!(Add, add, _mm512_add_pd);
operator!(Sub, sub, _mm512_sub_pd);
operator!(Mul, mul, _mm512_mul_pd);

impl Eight {
    #[inline(always)]
    fn all(value: f64) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_set1_pd(value) })
    }

    /// Bit mask of the lanes where `self` is larger; false for NaN.
    #[inline(always)]
    fn above(self, other: Self) -> u8 {
        // SAFETY: see `operator`.
        unsafe { _mm512_cmp_pd_mask::<_CMP_GT_OQ>(self.0, other.0) }
    }

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_abs_pd(self.0) })
    }

    /// `other` in the lanes of the mask.
    #[inline(always)]
    fn or(self, mask: u8, other: Self) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_mask_mov_pd(self.0, mask, other.0) })
    }

    #[inline(always)]
    fn load(from: &[f64], at: usize) -> Self {
        assert!(at + LANES <= from.len());
        // SAFETY: eight numbers are there.
        Self(unsafe { _mm512_loadu_pd(from.as_ptr().add(at)) })
    }

    #[inline(always)]
    fn store(self, to: &mut [f64], at: usize) {
        assert!(at + LANES <= to.len());
        // SAFETY: there is room for eight numbers.
        unsafe { _mm512_storeu_pd(to.as_mut_ptr().add(at), self.0) };
    }

    /// The lanes of the mask, moved to the front.
    #[inline(always)]
    fn front(self, mask: u8) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_maskz_compress_pd(mask, self.0) })
    }
}

impl std::ops::Sub for Vectors {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

impl Vectors {
    #[inline(always)]
    fn dot(self, o: Self) -> Eight {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    #[inline(always)]
    fn cross(self, o: Self) -> Self {
        Self { x: self.y * o.z - self.z * o.y, y: self.z * o.x - self.x * o.z, z: self.x * o.y - self.y * o.x }
    }

    #[inline(always)]
    fn or(self, mask: u8, o: Self) -> Self {
        Self { x: self.x.or(mask, o.x), y: self.y.or(mask, o.y), z: self.z.or(mask, o.z) }
    }
}

/// What the headers tell of every pair: `Some` where they decide.
#[target_feature(enable = "avx512f,avx2,fma")]
pub(super) fn compare(asks: &[Ask<'_>], answers: &mut [Option<bool>]) {
    for (asks, answers) in asks.chunks(LANES).zip(answers.chunks_mut(LANES)) {
        compare_eight(asks, answers);
    }
}

/// The whole query for every pair; `None` is left where it ends in doubt.
#[target_feature(enable = "avx512f,avx2,fma")]
pub(super) fn overlap(asks: &[Ask<'_>], answers: &mut [Option<bool>]) {
    let mut crowd = Crowd::new();
    for start in (0..asks.len()).step_by(LANES) {
        let end = (start + LANES).min(asks.len());
        let open = compare_eight(&asks[start..end], &mut answers[start..end]);
        crowd.admit(asks, start, &open);
        while crowd.len > CROWD - LANES {
            crowd.step(asks, answers);
        }
    }
    while crowd.len > 0 {
        crowd.step(asks, answers);
    }
}

/// The open pairs of eight, as a mask, and the directions to start from.
struct Open {
    mask: u8,
    v: Vectors,
}

#[inline(always)]
fn compare_eight(asks: &[Ask<'_>], answers: &mut [Option<bool>]) -> Open {
    let lane = |l: usize| &asks[l.min(asks.len() - 1)];
    let (a, b) = (headers(|l| lane(l).a), headers(|l| lane(l).b));
    let mut columns = [[0.0; LANES]; 3];
    for l in 0..LANES {
        for (column, value) in columns.iter_mut().zip(lane(l).b_from_a.iter()) {
            column[l] = *value;
        }
    }
    let [x, y, z] = columns.map(|c| Eight::load(&c, 0));
    let x = Vectors { x, y, z };
    let (n, determinant) = axis(&a, &b, x);
    let (along, q_a, q_b) = (n.dot(x), n.dot(times(matrix(&a), n)), n.dot(times(matrix(&b), n)));
    let zero = Eight::all(0.0);
    let rest = along * along * Eight::all(1.0 - SLACK) - (q_a + q_b);
    let apart = along.above(zero) & rest.above(zero) & (rest * rest).above(q_a * q_b * Eight::all(4.0 + 4.0 * SLACK));
    let square = determinant * determinant;
    let inside = a[7] + b[7];
    let spheres = (inside * inside * Eight::all(1.0 - SLACK)).above(x.dot(x));
    let common = !q_a.above(a[6] * square) & !q_b.above(b[6] * square) & along.above(zero);
    let hit = (spheres | common) & !apart;
    let filled = u8::MAX >> (LANES - asks.len());
    for (l, answer) in answers.iter_mut().enumerate() {
        if (apart | hit) >> l & 1 == 1 {
            *answer = Some(hit >> l & 1 == 1);
        }
    }
    let v = x.or(along.above(zero), n);
    Open { mask: filled & !(apart | hit), v }
}

/// The eight floats of each of eight headers, as eight numbers for eight bodies each.
#[inline(always)]
fn headers<'a>(lane: impl Fn(usize) -> &'a Body) -> [Eight; 8] {
    let rows: [[f32; 8]; 8] = std::array::from_fn(|l| lane(l).bounds.floats());
    // SAFETY: see `operator`; each row is eight floats.
    unsafe {
        let (r0, r1) = (_mm256_loadu_ps(rows[0].as_ptr()), _mm256_loadu_ps(rows[1].as_ptr()));
        let (r2, r3) = (_mm256_loadu_ps(rows[2].as_ptr()), _mm256_loadu_ps(rows[3].as_ptr()));
        let (r4, r5) = (_mm256_loadu_ps(rows[4].as_ptr()), _mm256_loadu_ps(rows[5].as_ptr()));
        let (r6, r7) = (_mm256_loadu_ps(rows[6].as_ptr()), _mm256_loadu_ps(rows[7].as_ptr()));
        let (p0, p1) = (_mm256_unpacklo_ps(r0, r1), _mm256_unpackhi_ps(r0, r1));
        let (p2, p3) = (_mm256_unpacklo_ps(r2, r3), _mm256_unpackhi_ps(r2, r3));
        let (p4, p5) = (_mm256_unpacklo_ps(r4, r5), _mm256_unpackhi_ps(r4, r5));
        let (p6, p7) = (_mm256_unpacklo_ps(r6, r7), _mm256_unpackhi_ps(r6, r7));
        let (q0, q1) = (_mm256_shuffle_ps::<0x44>(p0, p2), _mm256_shuffle_ps::<0xEE>(p0, p2));
        let (q2, q3) = (_mm256_shuffle_ps::<0x44>(p1, p3), _mm256_shuffle_ps::<0xEE>(p1, p3));
        let (q4, q5) = (_mm256_shuffle_ps::<0x44>(p4, p6), _mm256_shuffle_ps::<0xEE>(p4, p6));
        let (q6, q7) = (_mm256_shuffle_ps::<0x44>(p5, p7), _mm256_shuffle_ps::<0xEE>(p5, p7));
        [
            Eight(_mm512_cvtps_pd(_mm256_permute2f128_ps::<0x20>(q0, q4))),
            Eight(_mm512_cvtps_pd(_mm256_permute2f128_ps::<0x20>(q1, q5))),
            Eight(_mm512_cvtps_pd(_mm256_permute2f128_ps::<0x20>(q2, q6))),
            Eight(_mm512_cvtps_pd(_mm256_permute2f128_ps::<0x20>(q3, q7))),
            Eight(_mm512_cvtps_pd(_mm256_permute2f128_ps::<0x31>(q0, q4))),
            Eight(_mm512_cvtps_pd(_mm256_permute2f128_ps::<0x31>(q1, q5))),
            Eight(_mm512_cvtps_pd(_mm256_permute2f128_ps::<0x31>(q2, q6))),
            Eight(_mm512_cvtps_pd(_mm256_permute2f128_ps::<0x31>(q3, q7))),
        ]
    }
}

/// (S_a + S_b)^-1 x times the determinant, and the determinant.
#[inline(always)]
fn axis(a: &[Eight; 8], b: &[Eight; 8], x: Vectors) -> (Vectors, Eight) {
    let (xx, yy, zz) = (a[0] + b[0], a[1] + b[1], a[2] + b[2]);
    let (xy, xz, yz) = (a[3] + b[3], a[4] + b[4], a[5] + b[5]);
    let (c0, c1, c2) = (yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy);
    let (c3, c4, c5) = (xz * yz - xy * zz, xy * yz - xz * yy, xy * xz - yz * xx);
    (times([c0, c1, c2, c3, c4, c5], x), xx * c0 + xy * c3 + xz * c4)
}

#[inline(always)]
fn matrix(&[xx, yy, zz, xy, xz, yz, ..]: &[Eight; 8]) -> [Eight; 6] {
    [xx, yy, zz, xy, xz, yz]
}

#[inline(always)]
fn times([xx, yy, zz, xy, xz, yz]: [Eight; 6], v: Vectors) -> Vectors {
    Vectors { x: xx * v.x + xy * v.y + xz * v.z, y: xy * v.x + yy * v.y + yz * v.z, z: xz * v.x + yz * v.y + zz * v.z }
}

/// The columns of a [`Crowd`], each of one number per pair; vectors take three.
const DIRECTION: usize = 0;
const V0: usize = 3;
const V1: usize = 6;
const V2: usize = 9;
const V3: usize = 12;
const REACH: usize = 15;
/// 1 once the portal is found.
const FOUND: usize = 16;
/// Index of the question.
const ASK: usize = 17;
/// Supports so far.
const STEP: usize = 18;
const COLUMNS: usize = 19;

/// Pairs on their way through the portal search.
struct Crowd {
    columns: Box<[[f64; CROWD + LANES]; COLUMNS]>,
    len: usize,
}

/// Eight pairs of a crowd.
struct Rank {
    v0: Vectors,
    v1: Vectors,
    v2: Vectors,
    v3: Vectors,
    found: u8,
}

/// A point of A - B for each of eight pairs, and by how much the direction separates them.
struct Supports {
    w: Vectors,
    separation: Eight,
}

impl Crowd {
    fn new() -> Self {
        Self { columns: Box::new([[0.0; CROWD + LANES]; COLUMNS]), len: 0 }
    }

    /// Takes the open pairs in; those that this search is not for are left to the single query.
    #[inline(always)]
    fn admit(&mut self, asks: &[Ask<'_>], start: usize, open: &Open) {
        let mut directions = [[0.0; LANES]; 3];
        open.v.x.store(&mut directions[0], 0);
        open.v.y.store(&mut directions[1], 0);
        open.v.z.store(&mut directions[2], 0);
        for l in (0..LANES).filter(|l| open.mask >> l & 1 == 1) {
            let ask = &asks[start + l];
            let (a, b) = (ask.a, ask.b);
            if a.bounds.inradius > 0.0 && b.bounds.inradius > 0.0 && a.is_one_group() && b.is_one_group() {
                let v = Vec3::new(directions[0][l], directions[1][l], directions[2][l]);
                self.push(&v, ask, start + l);
            }
        }
    }

    #[inline(always)]
    fn push(&mut self, v: &Vec3, ask: &Ask<'_>, index: usize) {
        let x = &ask.b_from_a;
        for i in 0..3 {
            self.columns[DIRECTION + i][self.len] = v[i];
            self.columns[V0 + i][self.len] = -x[i];
        }
        let norm1 = x.x.abs() + x.y.abs() + x.z.abs();
        self.columns[REACH][self.len] = ask.a.circumradius() + ask.b.circumradius() + norm1;
        self.columns[FOUND][self.len] = 0.0;
        self.columns[ASK][self.len] = index as f64;
        self.columns[STEP][self.len] = 0.0;
        self.len += 1;
    }

    /// One support for everybody.
    #[inline(always)]
    fn step(&mut self, asks: &[Ask<'_>], answers: &mut [Option<bool>]) {
        let mut staying = 0;
        for at in (0..self.len).step_by(LANES) {
            let filled = u8::MAX >> (LANES - (self.len - at).min(LANES));
            let stays = self.advance(at, filled, asks, answers);
            self.close_ranks(at, stays, staying);
            staying += stays.count_ones() as usize;
        }
        self.len = staying;
    }

    /// Moves the lanes of the mask from `at` to the front of the columns at `to`.
    #[inline(always)]
    fn close_ranks(&mut self, at: usize, stays: u8, to: usize) {
        for column in self.columns.iter_mut() {
            Eight::load(column, at).front(stays).store(column, to);
        }
    }

    #[inline(always)]
    fn vectors(&self, column: usize, at: usize) -> Vectors {
        let c = &self.columns;
        Vectors {
            x: Eight::load(&c[column], at),
            y: Eight::load(&c[column + 1], at),
            z: Eight::load(&c[column + 2], at),
        }
    }

    #[inline(always)]
    fn keep(&mut self, column: usize, at: usize, v: Vectors) {
        v.x.store(&mut self.columns[column], at);
        v.y.store(&mut self.columns[column + 1], at);
        v.z.store(&mut self.columns[column + 2], at);
    }

    /// One support for each of eight pairs, and what follows from it; returns who stays.
    #[inline(always)]
    fn advance(&mut self, at: usize, filled: u8, asks: &[Ask<'_>], answers: &mut [Option<bool>]) -> u8 {
        let supports = self.supports(at, filled, asks);
        let (direction, reach) = (self.vectors(DIRECTION, at), Eight::load(&self.columns[REACH], at));
        let norm1 = direction.x.abs() + direction.y.abs() + direction.z.abs();
        let doubt = norm1 * reach * Eight::all(HEIGHT_ERROR) + Eight::all(f64::MIN_POSITIVE);
        let reaches_not = supports.separation.above(Eight::all(0.0)) & filled;
        let apart = supports.separation.above(doubt) & filled;
        let mut rank = Rank {
            v0: self.vectors(V0, at),
            v1: self.vectors(V1, at),
            v2: self.vectors(V2, at),
            v3: self.vectors(V3, at),
            found: Eight::load(&self.columns[FOUND], at).above(Eight::all(0.5)),
        };
        let steps = Eight::load(&self.columns[STEP], at);
        let (first, second) = (Eight::all(0.5).above(steps), Eight::all(1.5).above(steps));
        let stuck = rank.take([first, second & !first], supports.w, direction);
        let next = rank.direction(first);
        let (inside, enclosed) = rank.encloses_origin(next, reach);
        self.answer(at, apart, enclosed & filled & !reaches_not, answers);
        self.keep(DIRECTION, at, next);
        self.keep(V1, at, rank.v1);
        self.keep(V2, at, rank.v2);
        self.keep(V3, at, rank.v3);
        Eight::all(0.0).or(rank.found, Eight::all(1.0)).store(&mut self.columns[FOUND], at);
        (steps + Eight::all(1.0)).store(&mut self.columns[STEP], at);
        filled & !(reaches_not | inside | stuck | steps.above(Eight::all(MAX_STEPS)))
    }

    #[inline(always)]
    fn answer(&self, at: usize, apart: u8, overlap: u8, answers: &mut [Option<bool>]) {
        let mut decided = apart | overlap;
        while decided != 0 {
            let l = decided.trailing_zeros() as usize;
            answers[self.columns[ASK][at + l] as usize] = Some(overlap >> l & 1 == 1);
            decided &= decided - 1;
        }
    }

    #[inline(always)]
    fn supports(&self, at: usize, filled: u8, asks: &[Ask<'_>]) -> Supports {
        let c = &self.columns;
        let nothing = Eight::all(0.0).0;
        let (mut keys_a, mut keys_b) = ([nothing; LANES], [nothing; LANES]);
        for l in 0..LANES {
            if filled >> l & 1 == 1 {
                let ask = &asks[c[ASK][at + l] as usize];
                let v = Vec3::new(c[DIRECTION][at + l], c[DIRECTION + 1][at + l], c[DIRECTION + 2][at + l]);
                // SAFETY: see `operator`.
                unsafe {
                    keys_a[l] = keys512(ask.a.first_group(), &v);
                    keys_b[l] = keys512(ask.b.first_group(), &-v);
                }
            }
        }
        let (top_a, top_b) = (largest_of_each(&keys_a), largest_of_each(&keys_b));
        let w = self.points(at, filled, asks, top_a, top_b);
        let x_along = self.vectors(V0, at).dot(self.vectors(DIRECTION, at));
        Supports { w, separation: Eight::all(0.0) - (top_a + top_b + x_along) }
    }

    /// The points a - b - x of the slots in the keys.
    #[inline(always)]
    fn points(&self, at: usize, filled: u8, asks: &[Ask<'_>], top_a: Eight, top_b: Eight) -> Vectors {
        let (mut of_a, mut of_b, mut w) = ([0.0; LANES], [0.0; LANES], [[0.0; LANES]; 3]);
        top_a.store(&mut of_a, 0);
        top_b.store(&mut of_b, 0);
        for l in 0..LANES {
            if filled >> l & 1 == 1 {
                let ask = &asks[self.columns[ASK][at + l] as usize];
                let slot = |key: f64| (key.to_bits() & INDEX) as usize;
                let (i, j) = (slot(of_a[l]), slot(of_b[l]));
                let (Group(a), Group(b)) = (ask.a.first_group(), ask.b.first_group());
                for k in 0..3 {
                    w[k][l] = a[k][i] - b[k][j];
                }
            }
        }
        let difference = Vectors { x: Eight::load(&w[0], 0), y: Eight::load(&w[1], 0), z: Eight::load(&w[2], 0) };
        let v0 = self.vectors(V0, at);
        Vectors { x: difference.x + v0.x, y: difference.y + v0.y, z: difference.z + v0.z }
    }
}

impl Rank {
    /// Puts the new points where they belong; returns the lanes that make no progress.
    ///
    /// The first two points as they come; then discovery in the lanes without a portal and refinement in the others: see
    /// [`portal`](super::super::portal).
    #[inline(always)]
    fn take(&mut self, [first, second]: [u8; 2], w: Vectors, direction: Vectors) -> u8 {
        let seeking = !(self.found | first | second);
        let zero = Eight::all(0.0);
        let across = self.v0.cross(w);
        let [e1, e2, e3] = [self.v1.dot(across), self.v2.dot(across), self.v3.dot(across)];
        let stuck = self.found & !(w - self.v1).dot(direction).above(zero);
        // Discovery: outside of the plane v0 v3 v1, of v0 v2 v3, or found.
        let outside31 = seeking & e1.above(zero);
        let outside23 = seeking & !outside31 & zero.above(e2);
        let just_found = seeking & !outside31 & !outside23;
        // Refinement: with the opposite signs, since it crosses the other way round.
        let leaves3 = self.found & zero.above(e1) & !zero.above(e2);
        let leaves1 = self.found & !leaves3 & zero.above(e2) & !zero.above(e3);
        let leaves2 = self.found & !leaves3 & !leaves1;
        self.v1 = self.v1.or(first | outside23 | leaves1, w);
        self.v2 = self.v2.or(second | outside31 | leaves2, w);
        self.v3 = self.v3.or(just_found | leaves3, w);
        self.found |= just_found;
        stuck
    }

    /// Perpendicular to the plane of v0, v1 and the origin; then to that of v0, v1, v2; or outward from the portal.
    #[inline(always)]
    fn direction(&self, first: u8) -> Vectors {
        let from = self.v0.or(self.found, self.v1);
        let one = (self.v1.or(self.found, self.v2) - from).or(first, self.v1);
        let other = (self.v2.or(self.found, self.v3) - from).or(first, self.v0);
        one.cross(other)
    }

    /// The lanes whose portal lies beyond the origin, and those of them where that is proved.
    #[inline(always)]
    fn encloses_origin(&self, outward: Vectors, reach: Eight) -> (u8, u8) {
        let height = outward.dot(self.v1);
        let inside = self.found & height.above(Eight::all(0.0));
        if inside == 0 {
            return (0, 0);
        }
        let bound = reach * reach * reach * Eight::all(ENCLOSING) + Eight::all(UNDERFLOW);
        let cone = |p: Vectors, q: Vectors| q.cross(p).dot(self.v0);
        let [e12, e23, e31] = [cone(self.v1, self.v2), cone(self.v2, self.v3), cone(self.v3, self.v1)];
        let determinant = self.v1.dot(self.v2.cross(self.v3));
        let proved = e12.above(bound) & e23.above(bound) & e31.above(bound) & determinant.above(bound);
        (inside, inside & proved)
    }
}

/// The largest number of each of eight registers, in their order.
#[inline(always)]
fn largest_of_each(k: &[__m512d; LANES]) -> Eight {
    // SAFETY: see `operator`.
    unsafe {
        let (t0, t1) = (largest_of_two(k[0], k[1]), largest_of_two(k[2], k[3]));
        let (t2, t3) = (largest_of_two(k[4], k[5]), largest_of_two(k[6], k[7]));
        let (u0, u1) = (halves(t0, t1), halves(t2, t3));
        Eight(halves(u0, u1))
    }
}

/// Per 128 bits: the larger of each register's two numbers.
#[inline(always)]
unsafe fn largest_of_two(p: __m512d, q: __m512d) -> __m512d {
    // SAFETY: see `operator`.
    unsafe { _mm512_max_pd(_mm512_unpacklo_pd(p, q), _mm512_unpackhi_pd(p, q)) }
}

/// The larger of neighbouring blocks of 128 bits, of `p` and then of `q`.
#[inline(always)]
unsafe fn halves(p: __m512d, q: __m512d) -> __m512d {
    // SAFETY: see `operator`.
    unsafe {
        let (even, odd) = (_mm512_shuffle_f64x2::<0b10_00_10_00>(p, q), _mm512_shuffle_f64x2::<0b11_01_11_01>(p, q));
        _mm512_max_pd(even, odd)
    }
}
