//! Value and error of a quantity, from solutions on cells of three sizes or from bounds.
//!
//! Errors are the grid convergence index (Roache, Annu. Rev. Fluid Mech. 29, 1997, 123). With changes `d1` to the fine cells and `d2`
//! to the cells of twice the size, and sizes 1, a, b, the order `p` solves
//!
//! ```text
//! d2 / d1 = (b^p - a^p) / (a^p - 1)
//! ```
//!
//! - If it lies from 0.5 to 2, the order is observed. With the step `s = d1 / (a^p - 1)` the error is 1.25 `s`. The value is Richardson's,
//!   `fine + s`, but never goes further than the last change. An order above 1.5 counts as 1.5, which packings have whose gaps close at
//!   every size.
//! - If the changes fall faster, the value is the same. The error is three times the change that order 2 would leave of `d2`.
//! - If they turn back or fall more slowly, the fine value stands. The error is three times the largest difference of any two sizes (Eca and Hoekstra, J. Comput. Phys.
//!   262, 2014, 104, whose factors are 1.25 and 3, too).
//!
//! A thin shell that conducts more than its grain joins neighbouring grains in the voxels that they share. Such voxels show no error by
//! their changes, which begin with the wrong sign. Bounds that hold for every specimen limit it alone.
//!
//! The factors are those of the literature; `benches/effective_errors.py` judges them by random cases.

use std::ops::RangeInclusive;

/// A quantity with its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Estimate {
    pub(crate) value: f64,
    pub(crate) error: f64,
}

/// Sizes of the coarse and the coarsest cells over that of the fine ones.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sizes {
    pub(crate) of: [f64; 2],
    /// Whether changes from size to size show an error.
    pub(crate) show: bool,
}

/// Orders that count as observed.
const OBSERVED: RangeInclusive<f64> = 0.5..=2.0;
/// Largest order that errors count with.
const FORMAL: f64 = 1.5;
/// Error over the extrapolated step, with an observed order.
const SAFE: f64 = 1.25;
/// Error over the change, without an observed order.
const UNSAFE: f64 = 3.0;
/// Rounding of numbers in single precision, which links and materials have.
const SINGLE: f64 = 6e-8;

impl Sizes {
    /// Elements of one, two and four times a size.
    pub(crate) const DOUBLED: Self = Self::new([2.0, 4.0]);

    pub(crate) const fn new(of: [f64; 2]) -> Self {
        Self { of, show: true }
    }

    /// The change before the last one over it, at an order.
    fn ratio(&self, order: f64) -> f64 {
        let [a, b] = self.of.map(|size| libm::pow(size, order));
        (b - a) / (a - 1.0)
    }

    /// The order by the last change and the one before; infinite beyond those that are observed, none where changes turn back or fall
    /// more slowly.
    fn order(&self, last: f64, before: f64) -> Option<f64> {
        let ratio = before / last;
        let (mut low, mut high) = OBSERVED.into_inner();
        if ratio > self.ratio(high) {
            return Some(f64::INFINITY);
        }
        let is_observed = ratio >= self.ratio(low);
        if !is_observed {
            return None;
        }
        // Halving the interval 40 times leaves 2e-12 of it.
        for _ in 0..40 {
            let middle = (low + high) / 2.0;
            *(if self.ratio(middle) < ratio { &mut low } else { &mut high }) = middle;
        }
        Some(low)
    }

    /// Estimates of like quantities, each on the fine cells, on coarser ones and on the coarsest, where there are such. A quantity
    /// whose last change is small by chance has the mean change of all of them in its error.
    pub(crate) fn estimates(&self, of: &[(f64, Option<f64>, Option<f64>)]) -> Vec<Estimate> {
        let last = |(fine, coarse, _): &(f64, Option<f64>, Option<f64>)| coarse.map_or(0.0, |coarse| fine - coarse);
        let mean = of.iter().map(|of| last(of).abs()).sum::<f64>() / of.len().max(1) as f64;
        let estimate = |of: &(f64, Option<f64>, Option<f64>)| {
            if !self.show {
                return Estimate { value: of.0, error: f64::INFINITY };
            }
            let last = last(of);
            let over = |order: f64| 1.0 / (libm::pow(self.of[0], order) - 1.0);
            let unsafe_error = |change: f64| UNSAFE * over(1.0) * change.abs().max(mean);
            let Some(before) = of.1.zip(of.2).map(|(coarse, coarsest)| coarse - coarsest) else {
                return Estimate { value: of.0, error: unsafe_error(last) };
            };
            let Some(order) = self.order(last, before) else {
                let most = last.abs().max(before.abs()).max((last + before).abs());
                return Estimate { value: of.0, error: unsafe_error(most) };
            };
            let value = of.0 + over(order.clamp(1.0, FORMAL)) * last;
            let error = match order.is_finite() {
                true => SAFE * over(order.min(FORMAL)) * last.abs().max(mean),
                false => unsafe_error(before / self.ratio(*OBSERVED.end())),
            };
            Estimate { value, error }
        };
        of.iter().map(estimate).collect()
    }
}

impl Estimate {
    /// From bounds on the quantity. Errors of two discretisations that bound it nearly cancel in their geometric mean, which is exact
    /// for chequered planes.
    pub(crate) fn between(low: f64, high: f64) -> Self {
        let high = high.max(low);
        let value = (low * high).max(0.0).sqrt().clamp(low, high);
        Self { value, error: (high - value).max(value - low) }
    }

    /// With the error of the equations, and the rounding of their coefficients, in a quantity of size `whole`.
    pub(crate) fn solved(self, solver_error: f64, whole: f64) -> Self {
        Self { error: self.error + (solver_error + SINGLE) * whole.abs(), ..self }
    }

    /// Within bounds that hold for every specimen: the error reaches no further than they do.
    pub(crate) fn within(self, low: f64, high: f64) -> Self {
        let high = high.max(low);
        let value = self.value.clamp(low, high);
        Self { value, error: self.error.min((high - value).max(value - low)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(order: f64) -> Estimate {
        let at = |size: f64| 2.0 + 0.1 * size.powf(order);
        Sizes::DOUBLED.estimates(&[(at(1.0), Some(at(2.0)), Some(at(4.0)))])[0]
    }

    #[test]
    fn an_observed_order_gives_the_limit_and_an_error_of_five_quarters_of_the_step() {
        for order in [0.51, 0.7, 1.0, 1.2, 1.5] {
            let Estimate { value, error } = of(order);
            assert!((value - 2.0).abs() <= error && (error - 0.125).abs() < 1e-9, "{value} {error} of order {order}");
            assert!((value - 2.0).abs() < 1e-9 || order < 1.0, "{value} of order {order}");
        }
        // A higher order counts as 1.5.
        let Estimate { value, error } = of(1.99);
        assert!((value - 2.0).abs() < error && error < 0.21, "{value} {error}");
    }

    #[test]
    fn changes_that_fall_faster_count_as_if_they_fell_with_order_two() {
        let Estimate { value, error } = Sizes::DOUBLED.estimates(&[(1.0, Some(1.1), Some(1.7))])[0];
        assert!(value < 1.0 && value > 0.94 && (error - 0.45).abs() < 1e-12, "{value} {error}");
    }

    #[test]
    fn without_an_order_the_fine_value_stands() {
        // The changes fall too slowly, and turn back; two sizes show no order.
        for (coarsest, error) in [(Some(1.22), 0.66), (Some(1.0), 0.3), (Some(0.9), 0.6), (None, 0.3)] {
            let found = Sizes::DOUBLED.estimates(&[(1.0, Some(1.1), coarsest)])[0];
            assert!(found.value == 1.0 && (found.error - error).abs() < 1e-12, "{found:?} of {coarsest:?}");
        }
        let alike = Sizes::DOUBLED.estimates(&[(1.0, Some(1.0), Some(1.0)), (1.0, Some(1.0), None), (1.0, None, None)]);
        assert!(alike.iter().all(|alike| *alike == Estimate { value: 1.0, error: 0.0 }), "{alike:?}");
    }

    #[test]
    fn sizes_that_are_not_twice_as_large_show_the_same_order() {
        let sizes = Sizes::new([1.8, 3.1]);
        let at = |size: f64| 2.0 - 0.1 * size.powf(1.25);
        let found = sizes.estimates(&[(at(1.0), Some(at(1.8)), Some(at(3.1)))])[0];
        assert!((found.value - 2.0).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn a_small_change_by_chance_has_the_change_of_its_like() {
        let found = Sizes::DOUBLED.estimates(&[(1.0, Some(1.0), Some(1.1)), (1.0, Some(1.2), Some(1.5))]);
        assert!(found[0].error >= 0.1, "{found:?}");
    }
}
