//! A sample of numbers in seven.

use serde::{Deserialize, Serialize};

/// Mean, spread and quantiles of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Distribution {
    /// Mean.
    pub mean: f64,
    /// Standard deviation (of the sample, over n).
    pub sd: f64,
    /// Smallest.
    pub min: f64,
    /// A tenth is at most this.
    pub p10: f64,
    /// Half is at most this.
    pub median: f64,
    /// Nine tenths are at most this.
    pub p90: f64,
    /// Largest.
    pub max: f64,
}

impl Distribution {
    /// Of `values` in any order; `None` of none.
    pub(super) fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n;
        let quantile = |share: f64| values[(share * (n - 1.0)).round() as usize];
        let (min, max) = (*values.first()?, *values.last()?);
        Some(Self {
            mean,
            sd: variance.sqrt(),
            min,
            p10: quantile(0.1),
            median: quantile(0.5),
            p90: quantile(0.9),
            max,
        })
    }
}
