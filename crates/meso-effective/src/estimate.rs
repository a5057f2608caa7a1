//! Value and error of a quantity, from solutions on cells of three sizes or from bounds.
//!
//! The order at which a quantity converges is measured. With changes `d1` to the fine cells and `d2` to the cells of twice the
//! size, and sizes 1, a, b, the order `p` solves
//!
//! ```text
//! d2 / d1 = (b^p - a^p) / (a^p - 1)
//! ```
//!
//! If it lies from 0.5 to 3, the value is `fine + d1 / (a^p - 1)` with `p` from 1 to 1.5: packings have 1.5 with impermeable grains,
//! whose gaps close at every size, and 0.5 to 1 with thin shells that conduct. Else the fine value stands, with a larger error. The
//! shares of the changes in the error come from 87 random packings beside a quarter of the size (`benches/effective_errors.py`).

use std::ops::RangeInclusive;

/// A quantity with its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Estimate {
    pub(crate) value: f64,
    pub(crate) error: f64,
}

/// Sizes of the coarse and the coarsest cells over that of the fine ones, and what errors are multiplied by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sizes(pub(crate) [f64; 2], pub(crate) f64);

/// Orders that count as measured.
const SEEN: RangeInclusive<f64> = 0.5..=3.0;
/// Shares in the error of the last change and of the one before, with a measured order.
const MEASURED: [f64; 2] = [1.0, 0.25];
/// Shares in the error of the last change and of the one before, without an order.
const WITHOUT: [f64; 2] = [2.0, 0.5];
/// Rounding of numbers in single precision, which links and materials have.
const SINGLE: f64 = 6e-8;

impl Sizes {
    /// Elements of one, two and four times a size.
    pub(crate) const DOUBLED: Self = Self([2.0, 4.0], 1.0);

    /// The order, if the last change and the one before show one.
    fn order(&self, last: f64, before: f64) -> Option<f64> {
        let Self([a, b], _) = self;
        let ratio = before / last;
        let of = |p: f64| (libm::pow(*b, p) - libm::pow(*a, p)) / (libm::pow(*a, p) - 1.0);
        let (mut low, mut high) = SEEN.into_inner();
        if !(of(low)..=of(high)).contains(&ratio) {
            return None;
        }
        // Halving the interval 40 times leaves 2e-12 of it.
        for _ in 0..40 {
            let middle = (low + high) / 2.0;
            *(if of(middle) < ratio { &mut low } else { &mut high }) = middle;
        }
        Some(low)
    }

    /// Estimates of like quantities, each on the fine cells, on coarser ones and on the coarsest, where there are such. A quantity
    /// whose last change is small by chance has the mean change of all of them in its error.
    pub(crate) fn estimates(&self, of: &[(f64, Option<f64>, Option<f64>)]) -> Vec<Estimate> {
        let last = |(fine, coarse, _): &(f64, Option<f64>, Option<f64>)| coarse.map_or(0.0, |coarse| fine - coarse);
        let mean = of.iter().map(|of| last(of).abs()).sum::<f64>() / of.len().max(1) as f64;
        let estimate = |of: &(f64, Option<f64>, Option<f64>)| {
            let (fine, last) = (of.0, last(of));
            let before = of.1.zip(of.2).map(|(coarse, coarsest)| coarse - coarsest);
            let error = |[own, earlier]: [f64; 2]| {
                self.1 * (own * last.abs().max(mean)).max(before.map_or(0.0, |before| earlier * before.abs()))
            };
            match before.and_then(|before| self.order(last, before)) {
                Some(order) => {
                    let step = last / (libm::pow(self.0[0], order.clamp(1.0, 1.5)) - 1.0);
                    Estimate { value: fine + step, error: error(MEASURED).max(step.abs()) }
                }
                None => Estimate { value: fine, error: error(WITHOUT) },
            }
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
    fn an_order_is_measured_and_the_error_contains_the_limit() {
        for order in [0.5, 0.7, 1.0, 1.2, 1.5, 2.0, 2.9] {
            let Estimate { value, error } = of(order);
            assert!((value - 2.0).abs() <= error * 1.5, "{value} {error} of order {order}");
            if (1.0..=1.5).contains(&order) {
                assert!((value - 2.0).abs() < 1e-9, "{value} of order {order}");
            }
        }
    }

    #[test]
    fn without_an_order_the_fine_value_stands() {
        let found = Sizes::DOUBLED.estimates(&[(1.0, Some(1.1), Some(1.0))])[0];
        assert!(found.value == 1.0 && (found.error - 0.2).abs() < 1e-12, "{found:?}");
        // Two sizes show no order.
        let found = Sizes::DOUBLED.estimates(&[(1.0, Some(1.1), None)])[0];
        assert!(found.value == 1.0 && (found.error - 0.2).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn sizes_that_are_not_twice_as_large_show_the_same_order() {
        let sizes = Sizes([1.8, 3.1], 1.0);
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
