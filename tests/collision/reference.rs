//! Answers from first principles, in integers: they share no code and no idea with the crate's exact search.

use super::exact::{Big3, cross, dot, minus, parts};
use meso_collision::math::Vec3;
use num_bigint::BigInt;
use num_traits::{One, Signed, Zero};

type Int = BigInt;

/// Coordinates as integers in units of a common power of two, 2^`exponent`.
fn integers(sets: [&[Vec3]; 2]) -> ([Vec<Big3>; 2], i32) {
    let all = sets.iter().flat_map(|s| s.iter().flat_map(|p| p.iter().copied()));
    let exponent = all.filter(|&v| v != 0.0).map(|v| parts(v).1).min().unwrap_or(0);
    let integer = |v: f64| if v == 0.0 { Int::zero() } else { Int::from(parts(v).0) << (parts(v).1 - exponent) };
    (sets.map(|s| s.iter().map(|p| [integer(p.x), integer(p.y), integer(p.z)]).collect()), exponent)
}

/// Do the hulls share a point? Is there a solution of sum l a = sum m b, sum l = sum m = 1, l and m not negative:
/// phase one of the simplex method with Bland's rule (it cannot cycle) and fraction-free pivots.
pub(super) fn intersects(a: &[Vec3], b: &[Vec3]) -> bool {
    let ([a, b], _) = integers([a, b]);
    let columns = a.len() + b.len();
    let mut rows: Vec<Vec<Int>> = (0..3)
        .map(|k| a.iter().map(|p| p[k].clone()).chain(b.iter().map(|p| -&p[k])).chain([Int::zero()]).collect())
        .collect();
    for (from, to) in [(0, a.len()), (a.len(), columns)] {
        rows.push((0..=columns).map(|j| Int::from(u8::from(j == columns || (from..to).contains(&j)))).collect());
    }
    // The artificial variables are the first basis; the objective is their sum.
    let objective = (0..=columns).map(|j| rows.iter().map(|row| &row[j]).sum()).collect();
    rows.push(objective);
    let mut basis: Vec<Option<usize>> = vec![None; 5];
    let mut previous = Int::one();
    while !rows[5][columns].is_zero() {
        let Some(enter) = (0..columns).find(|&j| rows[5][j].is_positive()) else { return false };
        let rising = (0..5).filter(|&i| rows[i][enter].is_positive());
        // Smallest ratio; among equals the artificial first, then the lowest index.
        let leave = rising.min_by(|&i, &k| {
            let (left, right) = (&rows[i][columns] * &rows[k][enter], &rows[k][columns] * &rows[i][enter]);
            left.cmp(&right).then(basis[i].cmp(&basis[k]))
        });
        let leave = leave.expect("the feasible region is bounded");
        pivot(&mut rows, leave, enter, &mut previous);
        basis[leave] = Some(enter);
    }
    true
}

fn pivot(rows: &mut [Vec<Int>], r: usize, s: usize, previous: &mut Int) {
    let row = rows[r].clone();
    for (_, other) in rows.iter_mut().enumerate().filter(|(i, _)| *i != r) {
        let factor = other[s].clone();
        for (value, at_pivot) in other.iter_mut().zip(&row) {
            *value = (&*value * &row[s] - &factor * at_pivot) / &*previous;
        }
    }
    *previous = row[s].clone();
}

/// The distance of two hulls that share no point: the least over all points, edges and triangles of A - B.
pub(super) fn distance_of_disjoint(a: &[Vec3], b: &[Vec3]) -> f64 {
    let ([a, b], exponent) = integers([a, b]);
    let w: Vec<Big3> = a.iter().flat_map(|p| b.iter().map(move |q| minus(p, q))).collect();
    let mut best: Option<(Int, Int)> = None;
    let mut offer = |(n, d): (Int, Int)| {
        if best.as_ref().is_none_or(|(bn, bd)| &n * bd < bn * &d) {
            best = Some((n, d));
        }
    };
    for i in 0..w.len() {
        offer((dot(&w[i], &w[i]), Int::one()));
        for j in 0..i {
            let e = minus(&w[i], &w[j]);
            if dot(&w[i], &e).is_positive() && dot(&w[j], &e).is_negative() {
                let c = cross(&w[i], &e);
                offer((dot(&c, &c), dot(&e, &e)));
            }
            for k in 0..j {
                let n = cross(&e, &minus(&w[k], &w[j]));
                let inside = [(i, j), (j, k), (k, i)].map(|(p, q)| dot(&cross(&w[p], &w[q]), &n).signum());
                if inside[0] == inside[1] && inside[1] == inside[2] && !inside[0].is_zero() {
                    let h = dot(&w[i], &n);
                    offer((&h * &h, dot(&n, &n)));
                }
            }
        }
    }
    let (n, d) = best.expect("both bodies have points");
    root(&n, &d, exponent)
}

/// sqrt(n / d) 2^exponent, to 100 bits before the last rounding.
fn root(n: &Int, d: &Int, exponent: i32) -> f64 {
    let shift = 2 * (d.bits() as i64 - n.bits() as i64 + 220).div_euclid(2);
    let quotient = if shift >= 0 { (n << shift) / d } else { n / (d << -shift) };
    let root = quotient.sqrt();
    let surplus = root.bits() as i64 - 60;
    let head = (&root >> surplus).iter_u64_digits().next().unwrap_or(0) as f64;
    let power = i64::from(exponent) + surplus - shift / 2;
    (0..power.unsigned_abs()).fold(head, |x, _| if power > 0 { x * 2.0 } else { x / 2.0 })
}

#[test]
fn the_reference_knows_touching_from_apart() {
    let cube = |x: f64| -> Vec<Vec3> {
        (0..8).map(|i| Vec3::new(x + f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2))).collect()
    };
    assert!(intersects(&cube(0.0), &cube(1.0)));
    assert!(!intersects(&cube(0.0), &cube(1.0 + f64::EPSILON)));
    assert_eq!(distance_of_disjoint(&cube(0.0), &cube(4.0)), 3.0);
}
