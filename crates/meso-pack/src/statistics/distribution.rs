//! A sample of numbers in seven.

use serde::{Deserialize, Serialize};

/// Mean, spread and quantiles of a sample; a quantile between two values is between them as it is between their ranks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Distribution {
    /// Mean of the values.
    pub mean: f64,
    /// Standard deviation (of the sample, over n).
    pub sd: f64,
    /// Smallest value.
    pub min: f64,
    /// A tenth is less.
    pub p10: f64,
    /// Median: half of the values are less.
    pub median: f64,
    /// Nine tenths are less.
    pub p90: f64,
    /// Largest value.
    pub max: f64,
}

impl Distribution {
    /// Sums up `values` in any order; `None` where there is none.
    pub(super) fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n;
        let quantile = |share: f64| {
            let position = share * (n - 1.0);
            let (below, above) = (values[position as usize], values[position.ceil() as usize]);
            below + (above - below) * position.fract()
        };
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_of_an_even_number_is_between_its_two_middle_values() {
        let four = Distribution::of([4.0, 1.0, 2.0, 8.0]).unwrap();
        assert_eq!((four.min, four.median, four.max), (1.0, 3.0, 8.0));
        let eleven = Distribution::of((0..11).map(f64::from)).unwrap();
        assert_eq!((eleven.p10, eleven.median, eleven.p90), (1.0, 5.0, 9.0));
        assert_eq!(Distribution::of([]), None);
    }
}
