//! The grading curve and the volume it asks of every size class (Sec. 2.1, Table 1).

mod curve;
mod standards;

pub use curve::Curve;
pub(super) use curve::interpolate;
pub use standards::Standard;

use super::random::Stream;
use serde::{Deserialize, Serialize};

/// Sizes of the aggregates: limits, curve and classes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Grading {
    /// Share of the volume finer than a size, over all sizes.
    pub curve: Curve,
    /// Smallest aggregate, mm.
    pub d_min_mm: f64,
    /// Largest aggregate, mm.
    pub d_max_mm: f64,
    /// How the part of the curve outside `d_min_mm` to `d_max_mm` is treated.
    pub form: Form,
    /// Class limits, mm, ascending from `d_min_mm` to `d_max_mm`; left out: every 5 mm or usual sieves.
    #[serde(default)]
    pub classes_mm: Vec<f64>,
    /// Which length of an aggregate is its size; left out, the longest axis for Fuller's and Bolomey's curves, else the sieve's.
    pub size: SizeDefinition,
    /// How sizes are distributed within a class.
    pub size_law: SizeLaw,
}

/// The curve truncated to the placed sizes, or as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// (P(d) - P(d_min)) / (P(d_max) - P(d_min)): the whole target is placed. Fuller's: (d^n - d_min^n) / (d_max^n -
    /// d_min^n).
    Normalised,
    /// P(d): volume below `d_min` or above `d_max` is not placed.
    Raw,
}

/// Which length of an aggregate is its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum SizeDefinition {
    /// The longest axis 2a (the paper's).
    LongestAxis,
    /// The width of the smallest square hole the polyhedron passes lengthwise.
    Sieve,
}

/// The distribution of sizes within a class.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum SizeLaw {
    /// Every size is drawn equally often (the paper's).
    Uniform,
    /// Number density ~ d^-4: volume is uniform in log d, so that a curve drawn straight on a logarithmic axis stays
    /// so.
    VolumeUniform,
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
            curve: Curve::default(),
            d_min_mm: 5.0,
            d_max_mm: 20.0,
            form: Form::Normalised,
            classes_mm: vec![5.0, 10.0, 15.0, 20.0],
            size: SizeDefinition::LongestAxis,
            size_law: SizeLaw::Uniform,
        }
    }
}

/// Sieves between which classes lie where nothing else is asked, mm: the basic set and set 1 of EN 12620, from 63 down.
const SIEVES: [f64; 14] = [0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 5.6, 8.0, 11.2, 16.0, 22.4, 31.5, 45.0, 63.0];

impl Grading {
    /// Share of aggregate volume finer than sieve size `d` (mm), 0 to 1; in the normalised form sizes up to `d_min_mm`
    /// give 0 and sizes from `d_max_mm` give 1.
    pub fn passing(&self, d: f64) -> f64 {
        let raw = |d: f64| self.curve.passing(d, self.d_max_mm);
        match self.form {
            Form::Raw => raw(d.min(self.d_max_mm)),
            Form::Normalised => {
                let (low, high) = (raw(self.d_min_mm), raw(self.d_max_mm));
                ((raw(d.min(self.d_max_mm)) - low) / (high - low)).max(0.0)
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

    /// The size of a grain in `class`, mm: the first number that its stream gives.
    pub(super) fn draw(&self, class: &SizeClass, stream: &mut Stream) -> f64 {
        self.size_law.size(class.d_min_mm, class.d_max_mm, stream.unit())
    }

    /// The limits of a spec that names none: every 5 mm as in the paper where both ends are multiples of 5 (up to 100
    /// mm), else the curve's own sieves, else those of EN 12620.
    pub fn usual_classes(&self) -> Vec<f64> {
        let (low, high) = (self.d_min_mm, self.d_max_mm);
        let sieves = match self.curve.sieves() {
            Some(sieves) => sieves,
            None if low % 5.0 == 0.0 && high % 5.0 == 0.0 && high <= 100.0 => {
                (1..20).map(|i| f64::from(i) * 5.0).collect()
            }
            None => SIEVES.to_vec(),
        };
        let between = sieves.into_iter().filter(|&sieve| sieve > low && sieve < high);
        std::iter::once(low).chain(between).chain([high]).collect()
    }

    /// The curve in words, for the report.
    pub fn describe(&self) -> String {
        let form = match self.form {
            Form::Normalised => "normalised",
            Form::Raw => "raw",
        };
        let law = match self.size_law {
            SizeLaw::Uniform => "",
            SizeLaw::VolumeUniform => ", volume uniform within classes",
        };
        format!("{}, {form}, {} to {} mm{law}", self.curve.describe(), self.d_min_mm, self.d_max_mm)
    }
}

impl SizeLaw {
    /// The size within `low` to `high` (mm) that belongs to a uniform random number `x` in 0 to 1.
    ///
    /// Volume-uniform: the share of grains finer than d is (low^-3 - d^-3) / (low^-3 - high^-3).
    pub fn size(self, low: f64, high: f64, x: f64) -> f64 {
        match self {
            Self::Uniform => low + (high - low) * x,
            Self::VolumeUniform => {
                let (l, h) = (low * low * low, high * high * high);
                low * high / libm::cbrt((1.0 - x) * h + x * l)
            }
        }
    }

    /// Mean of d^3 over the class, mm3.
    pub fn mean_cube(self, low: f64, high: f64) -> f64 {
        match self {
            Self::Uniform => (low * low + high * high) * (low + high) / 4.0,
            Self::VolumeUniform => {
                let cube = |d: f64| d * d * d;
                3.0 * libm::log(high / low) / (1.0 / cube(low) - 1.0 / cube(high))
            }
        }
    }
}
