//! Waves along a round bar, whose short parts are slower: the first longitudinal mode of Pochhammer and Chree (Graff 1975, Wave
//! Motion in Elastic Solids, 8.2).

use std::f64::consts::TAU;

/// Samples of a wave.
const SAMPLES: usize = 2048;
/// Times that long waves take for the way, in which the slowest parts have come, too.
const LATEST: f64 = 3.0;
/// Frequency, in sound over radius, beyond which parts are as fast as waves on a surface.
const SHORT: f64 = 8.0;

/// Time between the samples of a wave whose last change is at `last_s`, after a way that takes `way_s`, s.
pub(super) fn sample_s(last_s: f64, way_s: f64) -> f64 {
    (2.0 * last_s + LATEST * way_s) / SAMPLES as f64
}

/// Rows of time and speed of a wave after a way that long waves take `way_s` for, in a bar whose radius they take `radius_s` for:
/// its speed over time and its last change, s. It arrives so much later, and a small part of it before.
pub(super) fn dispersed(
    (speed, last_s): (impl Fn(f64) -> f64, f64),
    way_s: f64,
    radius_s: f64,
    ratio: f64,
) -> Vec<[f64; 2]> {
    let period = SAMPLES as f64 * sample_s(last_s, way_s);
    let at = |k: usize| speed(k as f64 * period / SAMPLES as f64);
    let turns: Vec<(f64, f64)> = (0..SAMPLES).map(|k| libm::sincos(TAU * k as f64 / SAMPLES as f64)).collect();
    // Changes have an end where a speed that stays has none.
    let changes: Vec<f64> = (0..SAMPLES).map(|k| if k == 0 { at(0) } else { at(k) - at(k - 1) }).collect();
    let mut pace = 1.0;
    let parts: Vec<[f64; 2]> = (0..=SAMPLES / 2)
        .map(|m| {
            let [re, im] = changes.iter().enumerate().fold([0.0; 2], |[re, im], (k, change)| {
                let (s, c) = turns[(k * m) % SAMPLES];
                [re + change * c, im - change * s]
            });
            let w = TAU * m as f64 / period;
            pace = slower(w * radius_s, ratio, pace);
            let (s, c) = libm::sincos(-w * way_s / pace);
            // Frequencies above half of the samples mirror those below.
            let weight = if m == 0 || m == SAMPLES / 2 { 1.0 } else { 2.0 } / SAMPLES as f64;
            [weight * (re * c - im * s), weight * (re * s + im * c)]
        })
        .collect();
    let mut reached = 0.0;
    let row = |k: usize| {
        let change = parts.iter().enumerate().fold(0.0, |sum, (m, [re, im])| {
            let (s, c) = turns[(k * m) % SAMPLES];
            sum + re * c - im * s
        });
        reached += change;
        [k as f64 * period / SAMPLES as f64, reached]
    };
    (0..SAMPLES).map(row).collect()
}

/// Phase speed over that of long waves at the frequency `w`, in sound over radius, of which a lower frequency has `pace`.
fn slower(w: f64, ratio: f64, pace: f64) -> f64 {
    // Squares of the speeds of waves of pressure and of shear.
    let (pressed, sheared) = ((1.0 - ratio) / ((1.0 + ratio) * (1.0 - 2.0 * ratio)), 0.5 / (1.0 + ratio));
    if w == 0.0 || w > SHORT || ratio == 0.0 {
        return pace;
    }
    let equation = |pace: f64| {
        let z = (w / pace).powi(2);
        let (x, y) = (w * w / pressed - z, w * w / sheared - z);
        let ([x0, x1], [y0, y1]) = (bessel(x), bessel(y));
        2.0 * x * (y + z) * x1 * y1 - (y - z).powi(2) * x0 * y1 - 4.0 * z * x * x1 * y0
    };
    // A wave on a surface is about so fast (Viktorov 1967), and the slowest of these.
    let mut range = [0.97 * (0.87 + 1.12 * ratio) / (1.0 + ratio) * sheared.sqrt(), (1.0005 * pace).min(1.0)];
    let low = equation(range[0]);
    for _ in 0..50 {
        let middle = 0.5 * (range[0] + range[1]);
        range[usize::from(equation(middle) * low <= 0.0)] = middle;
    }
    range[0]
}

/// J0(s) and J1(s) / s of s^2 = x, which may be negative.
fn bessel(x: f64) -> [f64; 2] {
    let (mut terms, mut sums) = ([1.0, 0.5], [1.0, 0.5]);
    for m in 1..200 {
        let m = f64::from(m);
        terms = [-0.25 * x / (m * m) * terms[0], -0.25 * x / (m * (m + 1.0)) * terms[1]];
        sums = [sums[0] + terms[0], sums[1] + terms[1]];
        if terms[0].abs() < 1e-17 * sums[0].abs() {
            break;
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_waves_are_as_slow_as_rayleigh_says_and_short_ones_as_waves_on_a_surface() {
        let ratio = 0.29;
        let mut pace = 1.0;
        for k in 1..=400 {
            let w = 0.02 * f64::from(k);
            pace = slower(w, ratio, pace);
            // The radius over the length of the wave.
            let short = w / pace / TAU;
            let rayleigh = 1.0 - (ratio * std::f64::consts::PI * short).powi(2);
            assert!(short > 0.1 || (pace - rayleigh).abs() < 1e-3, "{short}: {pace} {rayleigh}");
        }
        assert!((pace - 0.574).abs() < 0.004, "{pace}");
    }

    #[test]
    fn a_wave_without_a_way_or_a_ratio_comes_as_it_was_and_keeps_its_level() {
        let pulse = |time: f64| (2e5 * time.max(0.0)).min(2.0) - (1e5 * (time - 3e-5)).clamp(0.0, 1.0);
        for (way, ratio) in [(1e-9, 0.29), (1e-4, 0.0)] {
            let rows = dispersed((pulse, 4e-5), way, 2e-6, ratio);
            let off = rows.iter().map(|[time, speed]| (speed - pulse(*time - way)).abs()).fold(0.0, f64::max);
            assert!(off < 0.01, "{off}");
        }
        let rows = dispersed((pulse, 4e-5), 1e-4, 2e-6, 0.29);
        assert!((rows[SAMPLES - 1][1] - 1.0).abs() < 0.01 && rows[1][1].abs() < 0.05, "{:?}", rows[SAMPLES - 1]);
    }
}
