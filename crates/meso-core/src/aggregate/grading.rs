//! The grading curve and the volume it asks of every size class (Sec. 2.1, Table 1).

use serde::{Deserialize, Serialize};

/// What is asked of the aggregate sizes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Grading {
    /// Smallest aggregate, mm.
    pub d_min_mm: f64,
    /// Largest aggregate, mm.
    pub d_max_mm: f64,
    /// Fuller's exponent n.
    pub exponent: f64,
    /// How the part of the curve below `d_min_mm` is treated.
    pub form: FullerForm,
    /// Class limits, mm, ascending from `d_min_mm` to `d_max_mm`.
    pub classes_mm: Vec<f64>,
    /// Which length of an aggregate is its size.
    pub size: SizeDefinition,
}

/// Fuller's curve truncated to the placed sizes, or as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FullerForm {
    /// P(d) = (d^n - d_min^n) / (d_max^n - d_min^n): the whole target is placed.
    Normalised,
    /// P(d) = (d / d_max)^n: what lies below `d_min` is not placed.
    Raw,
}

/// Which length of an aggregate is its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SizeDefinition {
    /// The longest axis 2a (the paper's).
    LongestAxis,
    /// The width of the smallest square hole the polyhedron passes.
    Sieve,
}

/// One size class and its part of the aggregate volume.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SizeClass {
    /// Lower limit, mm.
    pub d_min_mm: f64,
    /// Upper limit, mm.
    pub d_max_mm: f64,
    /// Volume of the class over the target volume of all aggregates; the shares of the raw form sum to less than 1.
    pub share: f64,
}

impl Default for Grading {
    fn default() -> Self {
        Self {
            d_min_mm: 5.0,
            d_max_mm: 20.0,
            exponent: 0.5,
            form: FullerForm::Normalised,
            classes_mm: vec![5.0, 10.0, 15.0, 20.0],
            size: SizeDefinition::LongestAxis,
        }
    }
}

impl Grading {
    /// Share of aggregate volume finer than sieve size `d` (mm), 0 to 1; sizes above `d_max_mm` give 1.
    pub fn passing(&self, d: f64) -> f64 {
        let power = |d: f64| libm::pow(d, self.exponent);
        let d = d.min(self.d_max_mm);
        match self.form {
            FullerForm::Raw => power(d / self.d_max_mm),
            FullerForm::Normalised => {
                let (low, high) = (power(self.d_min_mm), power(self.d_max_mm));
                ((power(d) - low) / (high - low)).max(0.0)
            }
        }
    }

    /// The classes from the finest to the coarsest.
    pub fn classes(&self) -> Vec<SizeClass> {
        self.classes_mm
            .windows(2)
            .map(|w| SizeClass { d_min_mm: w[0], d_max_mm: w[1], share: self.passing(w[1]) - self.passing(w[0]) })
            .collect()
    }

    /// The curve in words, for the report.
    pub fn describe(&self) -> String {
        let form = match self.form {
            FullerForm::Normalised => "normalised",
            FullerForm::Raw => "raw",
        };
        format!("Fuller, {form}, n = {}, {} to {} mm", self.exponent, self.d_min_mm, self.d_max_mm)
    }
}
