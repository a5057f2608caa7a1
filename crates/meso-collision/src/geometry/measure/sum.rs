//! Sums of terms with a bound of their rounding.

/// Relative to the magnitudes of its products a term errs by 8 roundings, and a little for their products.
pub(crate) const TERM_ERROR: f64 = 9.0 * (f64::EPSILON / 2.0);

/// A compensated sum (Neumaier 1974) of terms, and of their magnitudes.
#[derive(Default)]
pub(crate) struct Sum {
    sum: f64,
    compensation: f64,
    magnitude: f64,
}

impl Sum {
    #[inline(always)]
    pub(crate) fn add(&mut self, term: f64, magnitude: f64) {
        self.magnitude += magnitude;
        let (sum, next) = (self.sum, self.sum + term);
        self.compensation += if sum.abs() >= term.abs() { (sum - next) + term } else { (term - next) + sum };
        self.sum = next;
    }

    /// Six volumes and a bound of the error.
    pub(crate) fn bounded(&self) -> (f64, f64) {
        (self.sum + self.compensation, TERM_ERROR * self.magnitude)
    }
}
