//! Many pairs at a time past their bounds: the steps of [`ellipsoid`](crate::gjk::prove::ellipsoid), lane by lane, in
//! f64.

use super::pending::Pending;
use super::vectors::{Vectors, first_lanes};
use crate::gjk::ask::pair_query::PairQuery;
use crate::gjk::prove::ellipsoid::SLACK;
use crate::simd::{Lanes, MOST_LANES, Mask, Simd, Vectorized};

/// Stores the answers of the bounds: true where a pair is not more than `gap` apart; the rest goes to `pending`, which
/// is empty.
///
/// Returns how many pairs the inscribed spheres decided.
pub(crate) struct Glance<'a, 'q> {
    pub(crate) queries: &'a [PairQuery<'q>],
    pub(crate) gap: f64,
    pub(crate) answers: &'a mut [Option<bool>],
    pub(crate) pending: &'a mut Pending,
}

impl Vectorized for Glance<'_, '_> {
    type Output = u64;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> u64 {
        // Not compiled where it is not taken.
        if !S::LOCKSTEP_PAYS {
            return 0;
        }
        let Self { queries, gap, answers, pending } = self;
        let lanes = S::F64::LANES;
        pending.make_room(queries.len() + lanes);
        // The last register, filled up: whole ones need no look at how many pairs they have.
        let Some(&filling) = queries.last() else { return 0 };
        let rest = queries.len() - queries.len() % lanes;
        let (mut last, mut answers_of_last) = ([filling; MOST_LANES], [None; MOST_LANES]);
        last[..queries.len() - rest].copy_from_slice(&queries[rest..]);
        let mut by_spheres = 0;
        for first in (0..queries.len()).step_by(lanes) {
            let (queries, answers, filled) = match answers.get_mut(first..first + lanes) {
                Some(answers) => (&queries[first..first + lanes], answers, lanes),
                None => (&last[..lanes], &mut answers_of_last[..lanes], queries.len() - rest),
            };
            let filled = first_lanes(filled);
            by_spheres += u64::from(glance_at_lanes(simd, first, queries, filled, gap, answers, pending).count_ones());
        }
        answers[rest..].copy_from_slice(&answers_of_last[..queries.len() - rest]);
        by_spheres
    }
}

/// The answers of four lanes, by the bits of those that are decided, and by four more of those of these that overlap.
static ANSWERS: [[Option<bool>; 4]; 256] = answers_by_bits();

const fn answers_by_bits() -> [[Option<bool>; 4]; 256] {
    let (mut all, mut bits) = ([[None; 4]; 256], 0);
    while bits < 256 {
        let mut lane = 0;
        while lane < 4 {
            if bits >> lane & 1 == 1 {
                all[bits][lane] = Some(bits >> (4 + lane) & 1 == 1);
            }
            lane += 1;
        }
        bits += 1;
    }
    all
}

/// Returns the lanes that the inscribed spheres decide.
#[inline(always)]
fn glance_at_lanes<S: Simd>(
    simd: S,
    first: usize,
    queries: &[PairQuery<'_>],
    filled: u32,
    gap: f64,
    answers: &mut [Option<bool>],
    pending: &mut Pending,
) -> u32 {
    assert!(queries.len() == S::F64::LANES && answers.len() == S::F64::LANES);
    let (mut rows_a, mut rows_b, mut vectors) =
        ([&[0.0; 8]; MOST_LANES], [&[0.0; 8]; MOST_LANES], [&[0.0; 3]; MOST_LANES]);
    for l in 0..S::F64::LANES {
        (rows_a[l], rows_b[l]) = (&queries[l].a.bounds.row, &queries[l].b.bounds.row);
        [vectors[l]] = queries[l].b_from_a.data.0.each_ref();
    }
    let (a, b) = (simd.columns(&rows_a), simd.columns(&rows_b));
    let [x, y, z] = simd.coordinates(&vectors);
    let x = Vectors { x, y, z };
    let zero = S::F64::all(simd, 0.0);
    let (n, determinant) = axis(&a, &b, x);
    let (along, q_a, q_b) = (n.dot(x), n.dot(times(matrix(&a), n)), n.dot(times(matrix(&b), n)));
    let (sum, product) = (q_a + q_b, q_a * q_b);
    let beyond = along.above(zero);
    let apart = beyond & apart(simd, along, sum, product, gap, n);
    let square = determinant * determinant;
    let inside = a[7] + b[7];
    let spheres = (inside * inside * S::F64::all(simd, 1.0 - SLACK)).above(x.dot(x));
    let common = (a[6] * square).above(q_a) & (b[6] * square).above(q_b) & beyond;
    let hit = (spheres | common).but_not(apart);
    let (decided, hit, spheres) = ((apart | hit).bits(), hit.bits(), spheres.bits());
    for (four, answers) in answers.chunks_mut(4).enumerate() {
        let bits = decided >> (4 * four) & 15 | (hit >> (4 * four) & 15) << 4;
        answers.copy_from_slice(&ANSWERS[bits as usize][..answers.len()]);
    }
    let v = x.or(beyond, n);
    pending.add(
        simd,
        filled & !decided,
        first,
        [v.x, v.y, v.z, zero - x.x, zero - x.y, zero - x.z, along * along / sum],
    );
    spheres & filled
}

/// along > sqrt(q_a) + sqrt(q_b) + gap |n|, certainly, where along is positive.
#[inline(always)]
fn apart<S: Simd>(
    simd: S,
    along: S::F64,
    sum: S::F64,
    product: S::F64,
    gap: f64,
    n: Vectors<S::F64>,
) -> <S::F64 as Lanes>::Mask {
    if gap == 0.0 {
        let rest = along * along * S::F64::all(simd, 1.0 - SLACK) - sum;
        return rest.above(S::F64::all(simd, 0.0))
            & (rest * rest).above(product * S::F64::all(simd, 4.0 + 4.0 * SLACK));
    }
    // sqrt(q_a) + sqrt(q_b), squared.
    let squared = sum + product.sqrt() * S::F64::all(simd, 2.0);
    along.above((squared.sqrt() + n.dot(n).sqrt() * S::F64::all(simd, gap)) * S::F64::all(simd, 1.0 + SLACK))
}

/// (S_a + S_b)^-1 x times the determinant, and the determinant.
#[inline(always)]
fn axis<L: Lanes>(a: &[L; 8], b: &[L; 8], x: Vectors<L>) -> (Vectors<L>, L) {
    let (xx, yy, zz) = (a[0] + b[0], a[1] + b[1], a[2] + b[2]);
    let (xy, xz, yz) = (a[3] + b[3], a[4] + b[4], a[5] + b[5]);
    let (c0, c1, c2) = (yy.times_minus(zz, yz * yz), xx.times_minus(zz, xz * xz), xx.times_minus(yy, xy * xy));
    let (c3, c4, c5) = (xz.times_minus(yz, xy * zz), xy.times_minus(yz, xz * yy), xy.times_minus(xz, yz * xx));
    (times([c0, c1, c2, c3, c4, c5], x), xx.times_plus(c0, xy.times_plus(c3, xz * c4)))
}

#[inline(always)]
fn matrix<L: Lanes>(&[xx, yy, zz, xy, xz, yz, ..]: &[L; 8]) -> [L; 6] {
    [xx, yy, zz, xy, xz, yz]
}

#[inline(always)]
fn times<L: Lanes>([xx, yy, zz, xy, xz, yz]: [L; 6], v: Vectors<L>) -> Vectors<L> {
    let (x, y, z) = (Vectors { x: xx, y: xy, z: xz }, Vectors { x: xy, y: yy, z: yz }, Vectors { x: xz, y: yz, z: zz });
    Vectors { x: x.dot(v), y: y.dot(v), z: z.dot(v) }
}
