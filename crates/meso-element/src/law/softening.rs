//! Integrity left by softening that is exponential over inelastic strain, from the plastic strain, in one step.
//!
//! Stress is y f with y = exp(-e / a) over the inelastic strain e, and of e the share (1 - y) f / E is elastic strain that
//! damage gave up: e = k + (1 - y) f / E with the plastic strain k. So y solves y = exp(-(k + (1 - y) f / E) / a), that is
//! z exp(-z) = b exp(-b - k / a) with z = b y and the brittleness b = f / (E a): a Lambert function. It is one branch for
//! b <= 1; above, stress would have to snap back.

use crate::real::{Real, polynomial};

/// The widest crack band's share of the width at which it would snap back: there, stress would drop at no strain.
pub(super) const SNAP_BACK: f64 = 0.98;

/// The y of `y = exp(-x - b (1 - y))`, for x >= 0 and b from 0 to 1.
///
/// Within 1e-6 in f32, 2e-14 in f64, relative.
#[inline(always)]
pub(super) fn integrity<R: Real>(x: R, b: R) -> R {
    let one = R::splat(1.0);
    relaxed((one - b - x).exp(), b)
}

/// The y of `y = s exp(b y - 1)`, for b s <= 1: s P with P = z / (b s) and z exp(1 - z) = b s, smooth over sqrt(1 - b s).
#[inline(always)]
pub(super) fn relaxed<R: Real>(s: R, b: R) -> R {
    let p = (-b).mul_add(s, R::splat(1.0)).positive().sqrt();
    s * if R::SINGLE { polynomial(p, &LAMBERT_SINGLE) } else { polynomial(p, &LAMBERT_DOUBLE) }
}

/// -W(-T / e) / T over sqrt(1 - T), from fits on Chebyshev nodes in 60 decimal digits: within 6e-7.
const LAMBERT_SINGLE: [f64; 9] = [
    0.999999424642174031,
    -1.41411975944225578,
    1.66408412447746036,
    -1.81814603058471763,
    1.82481274871714564,
    -1.55326268471003969,
    0.987232118973462471,
    -0.395196114425409842,
    0.0724758959951340433,
];
/// -W(-T / e) / T over sqrt(1 - T), within 2e-14.
const LAMBERT_DOUBLE: [f64; 19] = [
    0.999999999999984977,
    -1.41421356236223296,
    1.6666666653540211,
    -1.8463343098087405,
    1.98518356316809401,
    -2.09805194953706822,
    2.19279378834418059,
    -2.27296418765248752,
    2.33585983687200222,
    -2.36476099547720707,
    2.31854326482911642,
    -2.13541198833648729,
    1.77192016218744264,
    -1.26274182117736435,
    0.734326493658289258,
    -0.329025911051680425,
    0.105354599223353035,
    -0.0212957840106239348,
    0.00203157694885780114,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrity_solves_its_equation() {
        for brittleness in [0.001, 0.1, 0.5, 0.9, 0.99, 1.0] {
            for step in 0..400 {
                let x = f64::from(step) * 0.03;
                let residual = |y: f64| y * (x + brittleness * (1.0 - y)).exp() - 1.0;
                let slope = |y: f64| 1.0 - brittleness * y;
                // Where b y is 1 the equation has a double root, which squares the residual.
                let y = integrity(x, brittleness);
                assert!(
                    (residual(y) / slope(y).max(1e-7)).abs() < 1e-6 && residual(y).abs() < 1e-12,
                    "{x} {brittleness}"
                );
                let y = f64::from(integrity(x as f32, brittleness as f32));
                assert!(residual(y).abs() < 4e-6, "{x} {brittleness}: {y} {}", residual(y));
            }
        }
    }

    #[test]
    fn integrity_begins_at_1_and_falls() {
        for b in [0.0_f32, 0.3, 0.7] {
            assert!((integrity(0.0, b) - 1.0).abs() < 3e-6);
            assert!(integrity(0.5, b) < integrity(0.4, b) && integrity(60.0, b) < 1e-20);
        }
    }
}
