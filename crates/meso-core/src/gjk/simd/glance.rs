//! Eight pairs at a time past the headers: the steps of [`ellipsoid`](super::super::ellipsoid), lane by lane.

use super::super::batch::Ask;
use super::super::body::Body;
use super::super::ellipsoid::SLACK;
use super::eight::{Eight, LANES, Vectors};
use super::open::Open;
use std::arch::x86_64::*;

/// Answers what the headers tell: true where a pair is not more than `gap` apart; the rest goes to `open`, which is empty.
#[target_feature(enable = "avx512f,avx2,fma")]
pub(super) fn glance(asks: &[Ask<'_>], gap: f64, answers: &mut [Option<bool>], open: &mut Open) -> u64 {
    open.make_room(asks.len() + LANES);
    let mut by_spheres = 0;
    for (i, (asks, answers)) in asks.chunks(LANES).zip(answers.chunks_mut(LANES)).enumerate() {
        by_spheres += u64::from(glance_at_eight(i * LANES, asks, gap, answers, open).count_ones());
    }
    by_spheres
}

/// Returns the lanes that the inscribed spheres decide.
#[inline(always)]
fn glance_at_eight(first: usize, asks: &[Ask<'_>], gap: f64, answers: &mut [Option<bool>], open: &mut Open) -> u8 {
    let lanes: [&Ask<'_>; LANES] = std::array::from_fn(|l| &asks[l.min(asks.len() - 1)]);
    let (a, b) = (headers(|l| lanes[l].a), headers(|l| lanes[l].b));
    let x = Vectors::from_lanes(|l| &lanes[l].b_from_a);
    let (n, determinant) = axis(&a, &b, x);
    let (along, q_a, q_b) = (n.dot(x), n.dot(times(matrix(&a), n)), n.dot(times(matrix(&b), n)));
    let zero = Eight::all(0.0);
    let (sum, product) = (q_a + q_b, q_a * q_b);
    let beyond = along.above(zero);
    let apart = beyond & apart(along, sum, product, gap, n);
    let square = determinant * determinant;
    let inside = a[7] + b[7];
    let spheres = (inside * inside * Eight::all(1.0 - SLACK)).above(x.dot(x));
    let common = (a[6] * square).above(q_a) & (b[6] * square).above(q_b) & beyond;
    let hit = (spheres | common) & !apart;
    let decided = apart | hit;
    for (l, answer) in answers.iter_mut().enumerate() {
        *answer = (decided >> l & 1 == 1).then_some(hit >> l & 1 == 1);
    }
    let filled = u8::MAX >> (LANES - asks.len());
    push(open, filled & !decided, first, x.or(beyond, n), along * along / sum);
    spheres & filled
}

/// Lists the lanes of the mask.
#[inline(always)]
fn push(open: &mut Open, mut mask: u8, first: usize, v: Vectors, closeness: Eight) {
    let end = open.len();
    for (column, value) in open.columns.iter_mut().zip([v.x, v.y, v.z, closeness]) {
        value.front(mask).store(column, end);
    }
    while mask != 0 {
        open.add(first as u32 + mask.trailing_zeros());
        mask &= mask - 1;
    }
}

/// along > sqrt(q_a) + sqrt(q_b) + gap |n|, certainly, where along is positive.
#[inline(always)]
fn apart(along: Eight, sum: Eight, product: Eight, gap: f64, n: Vectors) -> u8 {
    if gap == 0.0 {
        let rest = along * along * Eight::all(1.0 - SLACK) - sum;
        return rest.above(Eight::all(0.0)) & (rest * rest).above(product * Eight::all(4.0 + 4.0 * SLACK));
    }
    // sqrt(q_a) + sqrt(q_b), squared.
    let squared = sum + product.sqrt() * Eight::all(2.0);
    along.above((squared.sqrt() + n.dot(n).sqrt() * Eight::all(gap)) * Eight::all(1.0 + SLACK))
}

/// The eight floats of each of eight headers, as eight numbers for eight bodies each.
#[inline(always)]
fn headers<'a>(body: impl Fn(usize) -> &'a Body) -> [Eight; 8] {
    let row = |l: usize| body(l).bounds.floats();
    // SAFETY: AVX-512 was detected; a row is eight floats.
    unsafe {
        let (r0, r1) = (_mm256_loadu_ps(row(0)), _mm256_loadu_ps(row(1)));
        let (r2, r3) = (_mm256_loadu_ps(row(2)), _mm256_loadu_ps(row(3)));
        let (r4, r5) = (_mm256_loadu_ps(row(4)), _mm256_loadu_ps(row(5)));
        let (r6, r7) = (_mm256_loadu_ps(row(6)), _mm256_loadu_ps(row(7)));
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
    let (c0, c1, c2) = (yy.times_minus(zz, yz * yz), xx.times_minus(zz, xz * xz), xx.times_minus(yy, xy * xy));
    let (c3, c4, c5) = (xz.times_minus(yz, xy * zz), xy.times_minus(yz, xz * yy), xy.times_minus(xz, yz * xx));
    (times([c0, c1, c2, c3, c4, c5], x), xx.times_plus(c0, xy.times_plus(c3, xz * c4)))
}

#[inline(always)]
fn matrix(&[xx, yy, zz, xy, xz, yz, ..]: &[Eight; 8]) -> [Eight; 6] {
    [xx, yy, zz, xy, xz, yz]
}

#[inline(always)]
fn times([xx, yy, zz, xy, xz, yz]: [Eight; 6], v: Vectors) -> Vectors {
    let (x, y, z) = (Vectors { x: xx, y: xy, z: xz }, Vectors { x: xy, y: yy, z: yz }, Vectors { x: xz, y: yz, z: zz });
    Vectors { x: x.dot(v), y: y.dot(v), z: z.dot(v) }
}
