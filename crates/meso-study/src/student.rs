//! Student's t distribution, as far as confidence intervals need it.

use std::f64::consts::PI;

/// The 0.975 quantile of Student's t with so many degrees of freedom, at least 1: half of a 95 % interval, in standard
/// errors. Relative error below 1e-9.
///
/// The distribution function is a finite sum for whole degrees of freedom (Abramowitz and Stegun, 26.7.3 and 26.7.4);
/// Newton's method inverts it. From 1,000 degrees on, the expansion of 26.7.5 has converged.
pub fn quantile_975(degrees: u64) -> f64 {
    /// The normal distribution's.
    const NORMAL: f64 = 1.959_963_984_540_054;
    let n = degrees as f64;
    let z = NORMAL;
    let (z3, z5, z7) = (z * z * z, z.powi(5), z.powi(7));
    let expanded = z
        + (z3 + z) / (4.0 * n)
        + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * n * n)
        + (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * n * n * n);
    match degrees {
        0 => f64::NAN,
        1 => libm::tan(0.475 * PI),
        1000.. => expanded,
        _ => (0..50).fold(expanded, |t, _| t - (within(t, degrees) - 0.95) / (2.0 * density(t, degrees))),
    }
}

/// Probability of -t to t.
fn within(t: f64, degrees: u64) -> f64 {
    let theta = libm::atan(t / (degrees as f64).sqrt());
    let (sin, cos) = (libm::sin(theta), libm::cos(theta));
    if degrees % 2 == 1 {
        let sum = series(cos, cos * cos, degrees, 3, |k| (k - 1) as f64 / k as f64);
        return 2.0 / PI * (theta + if degrees > 1 { sin * sum } else { 0.0 });
    }
    sin * series(1.0, cos * cos, degrees, 2, |k| (k - 1) as f64 / k as f64)
}

/// `first (1 + r(k) c (1 + r(k + 2) c (...)))` with the last k below `degrees`.
fn series(first: f64, c: f64, degrees: u64, k: u64, ratio: impl Fn(u64) -> f64) -> f64 {
    let (mut term, mut sum) = (first, first);
    for k in (k..degrees).step_by(2) {
        term *= ratio(k) * c;
        sum += term;
    }
    sum
}

fn density(t: f64, degrees: u64) -> f64 {
    let n = degrees as f64;
    let log = libm::lgamma((n + 1.0) / 2.0) - libm::lgamma(n / 2.0) - 0.5 * libm::log(n * PI);
    libm::exp(log - (n + 1.0) / 2.0 * libm::log1p(t * t / n))
}
