//! Curves of the share that passes a sieve.

use super::{SizeDefinition, Standard};
use serde::{Deserialize, Serialize};

/// Share of the aggregate volume finer than a size, over all sizes; 1 at and above the largest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Curve {
    /// P(d) = (d / d_max)^n (Fuller and Thompson 1907 with n = 0.5; codes use 0.45 to 0.70).
    Fuller {
        /// The exponent n.
        #[serde(default = "half")]
        exponent: f64,
    },
    /// P(d) = A + (1 - A) sqrt(d / d_max) (Bolomey 1935).
    Bolomey {
        /// A, 0.08 for stiff to 0.16 for fluid concrete.
        a: f64,
    },
    /// A sieve analysis; between two sieves P is linear in log d, as such curves are drawn.
    Sieves {
        /// Sieve openings, mm, ascending.
        sieves_mm: Vec<f64>,
        /// Share that passes each sieve, 0 to 1.
        passing: Vec<f64>,
    },
    /// A curve of a standard; of a band the middle.
    Standard {
        /// Which.
        name: Standard,
    },
}

fn half() -> f64 {
    0.5
}

impl Default for Curve {
    fn default() -> Self {
        Self::Fuller { exponent: half() }
    }
}

impl Curve {
    /// Share finer than `d` (mm), 0 to 1; `d_max` (mm) is where the formulas reach 1.
    pub fn passing(&self, d: f64, d_max: f64) -> f64 {
        match self {
            Self::Fuller { exponent } => libm::pow(d / d_max, *exponent).min(1.0),
            Self::Bolomey { a } => (a + (1.0 - a) * (d / d_max).sqrt()).min(1.0),
            Self::Sieves { sieves_mm, passing } => {
                interpolate(sieves_mm.iter().copied().zip(passing.iter().copied()), d)
            }
            Self::Standard { name } => interpolate(name.points(), d),
        }
    }

    /// The sieves on which the curve is given, mm, ascending; formulas have none.
    pub fn sieves(&self) -> Option<Vec<f64>> {
        match self {
            Self::Fuller { .. } | Self::Bolomey { .. } => None,
            Self::Sieves { sieves_mm, .. } => Some(sieves_mm.clone()),
            Self::Standard { name } => Some(name.points().map(|point| point.0).collect()),
        }
    }

    /// Which length is a size where nothing is said: tables and standards are of openings, the papers' formulas of longest axes.
    pub fn usual_size(&self) -> SizeDefinition {
        match self {
            Self::Fuller { .. } | Self::Bolomey { .. } => SizeDefinition::LongestAxis,
            Self::Sieves { .. } | Self::Standard { .. } => SizeDefinition::Sieve,
        }
    }

    /// Describes the curve by its name and parameters.
    pub fn describe(&self) -> String {
        match self {
            Self::Fuller { exponent } => format!("Fuller, n = {exponent}"),
            Self::Bolomey { a } => format!("Bolomey, A = {a}"),
            Self::Sieves { sieves_mm, .. } => format!("sieve table of {} rows", sieves_mm.len()),
            Self::Standard { name } => name.title().to_owned(),
        }
    }
}

/// P at `d` between points (size, P) of ascending size, linear in log d; constant beyond the ends.
pub(in super::super) fn interpolate(points: impl Iterator<Item = (f64, f64)>, d: f64) -> f64 {
    let mut below: Option<(f64, f64)> = None;
    for (size, share) in points {
        if d <= size {
            return match below {
                Some((low, at_low)) => at_low + (share - at_low) * libm::log(d / low) / libm::log(size / low),
                None => share,
            };
        }
        below = Some((size, share));
    }
    below.map_or(1.0, |(_, share)| share)
}
