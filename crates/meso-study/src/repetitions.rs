//! Mean and scatter of repetitions: of one seed, or of two that are combined with each other.
//!
//! The result of packing i with material j is m + a_i + b_j + e_ij, and the scatters of the three come from mean squares
//! (two-way analysis of variance with random effects, one result for each pair; Scheffe 1959, remembered):
//!
//! ```text
//! s_a^2 = (A - E) / q,  s_b^2 = (B - E) / p,  s_e^2 = E    A, B, E: mean squares of p packings, q materials, the rest
//! variance of the mean = (A + B - E) / (p q)
//! ```
//!
//! A repetition is a specimen with a packing and a material of its own: its scatter is s^2 = s_a^2 + s_b^2 + s_e^2.

use crate::student::quantile_975;

/// Share of the mean to which it is to be known.
const KNOWN: f64 = 0.01;
/// More repetitions than anybody runs.
const MOST: u64 = 1_000_000_000;

/// Mean and scatter of a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Figure {
    pub(crate) n: u64,
    pub(crate) mean: Option<f64>,
    /// Of one repetition.
    pub(crate) std: Option<f64>,
    /// Standard error of the mean, and its degrees of freedom.
    error: Option<(f64, u64)>,
    /// Standard deviations from packings and from materials, and their standard errors.
    pub(crate) parts: [Option<[f64; 2]>; 2],
}

/// A sum of squares over its degrees of freedom, and these.
#[derive(Clone, Copy)]
struct MeanSquare(f64, f64);

impl MeanSquare {
    /// The variance of a mean square as an estimate.
    fn variance(self) -> f64 {
        2.0 * self.0 * self.0 / self.1
    }
}

impl Figure {
    /// Of repetitions.
    pub(crate) fn of(sample: &[f64]) -> Self {
        let n = sample.len();
        let mean = (n > 0).then(|| sample.iter().sum::<f64>() / n as f64);
        let squares = mean.map(|mean| sample.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>());
        let std = squares.filter(|_| n > 1).map(|squares| (squares / (n - 1) as f64).sqrt());
        let error = std.map(|std| (std / (n as f64).sqrt(), n as u64 - 1));
        Self { n: n as u64, mean, std, error, parts: [None; 2] }
    }

    /// Of results with the places of their packing and their material among all of them. Where these are neither combined in
    /// every pair nor new in every result, only the mean is known.
    pub(crate) fn of_pairs(sample: &[(usize, usize, f64)]) -> Self {
        let values: Vec<f64> = sample.iter().map(|result| result.2).collect();
        let plain = Self::of(&values);
        let count = |place: fn(&(usize, usize, f64)) -> usize| {
            let mut places: Vec<usize> = sample.iter().map(place).collect();
            places.sort_unstable();
            places.dedup();
            places.len()
        };
        let (packings, materials, n) = (count(|result| result.0), count(|result| result.1), sample.len());
        // The error of a standard deviation from n - 1 degrees of freedom.
        let own = plain.std.map(|std| [std, std / (2.0 * (n as f64 - 1.0)).sqrt()]);
        match (packings, materials) {
            (_, 1) if packings == n => Self { parts: [own, None], ..plain },
            (1, _) if materials == n => Self { parts: [None, own], ..plain },
            _ if packings == n && materials == n => plain,
            _ if packings * materials == n => Self::crossed(sample, plain, [packings as f64, materials as f64]),
            _ => Self { n: plain.n, mean: plain.mean, ..Self::default() },
        }
    }

    fn crossed(sample: &[(usize, usize, f64)], plain: Self, [p, q]: [f64; 2]) -> Self {
        let mean = plain.mean.unwrap_or_default();
        let squares = |place: fn(&(usize, usize, f64)) -> usize, each: f64| -> f64 {
            let mut sums = std::collections::BTreeMap::new();
            sample.iter().for_each(|result| *sums.entry(place(result)).or_insert(0.0) += result.2 - mean);
            sums.values().map(|sum: &f64| sum * sum / each).sum()
        };
        let all: f64 = sample.iter().map(|result| (result.2 - mean) * (result.2 - mean)).sum();
        let (of_packings, of_materials) = (squares(|result| result.0, q), squares(|result| result.1, p));
        let a = MeanSquare(of_packings / (p - 1.0), p - 1.0);
        let b = MeanSquare(of_materials / (q - 1.0), q - 1.0);
        let degrees = a.1 * b.1;
        let e = MeanSquare((all - of_packings - of_materials).max(0.0) / degrees, degrees);
        let part = |own: MeanSquare, each: f64| {
            let variance = (own.0 - e.0) / each;
            let error = (own.variance() + e.variance()).sqrt() / each;
            // Of a scatter below its error, the error is that of 0.
            let std = variance.max(0.0).sqrt();
            [std, if variance > error { error / (2.0 * std) } else { error.sqrt() }]
        };
        let parts = [part(a, q), part(b, p)];
        let std = (parts[0][0].powi(2) + parts[1][0].powi(2) + e.0).sqrt();
        // Never less than one result's share, and with degrees of freedom by Satterthwaite.
        let squared = (a.0 + b.0 - e.0).max(e.0);
        let spread = a.0 * a.0 / a.1 + b.0 * b.0 / b.1 + e.0 * e.0 / e.1;
        let freedom = if spread > 0.0 { (squared * squared / spread).floor().max(1.0) as u64 } else { degrees as u64 };
        let error = Some(((squared / (p * q)).sqrt(), freedom));
        Self { std: Some(std), error, parts: parts.map(Some), ..plain }
    }

    /// Standard deviation over the mean.
    pub(crate) fn cv(&self) -> Option<f64> {
        Some(self.std? / self.mean?.abs()).filter(|cv| cv.is_finite())
    }

    /// Half of the mean's 95 % confidence interval.
    pub(crate) fn half_width(&self) -> Option<f64> {
        let (error, degrees) = self.error.filter(|(_, degrees)| *degrees > 0)?;
        Some(quantile_975(degrees) * error)
    }

    /// The smallest number of repetitions of this scatter whose mean is known.
    pub(crate) fn needed(&self) -> Option<i128> {
        let cv = self.cv()?;
        let is_known = |n: u64| quantile_975(n - 1) * cv <= KNOWN * (n as f64).sqrt();
        // The interval narrows with n, so that halving finds the first.
        let (mut low, mut high) = (2, MOST);
        if !is_known(high) {
            return None;
        }
        while low < high {
            let middle = low + (high - low) / 2;
            (low, high) = if is_known(middle) { (low, middle) } else { (middle + 1, high) };
        }
        Some(low.into())
    }
}
