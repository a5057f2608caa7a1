//! Laws of the ratios between a grain's axes.

use super::random::Stream;
use serde::{Deserialize, Serialize};

/// A named distribution of an aspect ratio, within `min..=max`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "law", rename_all = "kebab-case", deny_unknown_fields)]
pub enum AspectRatio {
    /// Normal, redrawn until it lies within the limits.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation.
        sd: f64,
        /// Lower limit.
        min: f64,
        /// Upper limit.
        max: f64,
    },
    /// Uniform within the limits.
    Uniform {
        /// Lower limit.
        min: f64,
        /// Upper limit.
        max: f64,
    },
    /// One value.
    Constant {
        /// The value.
        value: f64,
    },
}

/// Redraws of a ratio outside its limits; then it is clipped.
const RATIO_DRAWS: usize = 100;

impl AspectRatio {
    /// Draws one ratio.
    pub fn draw(&self, stream: &mut Stream) -> f64 {
        match *self {
            Self::Constant { value } => value,
            Self::Uniform { min, max } => stream.uniform(min, max),
            Self::Normal { mean, sd, min, max } => {
                let mut ratio = mean;
                for _ in 0..RATIO_DRAWS {
                    ratio = stream.normal(mean, sd);
                    if (min..=max).contains(&ratio) {
                        return ratio;
                    }
                }
                ratio.clamp(min, max)
            }
        }
    }
}
