//! Random convex aggregates: vertices on an ellipsoid, their hull, a random rotation (Sec. 2.1, Fig. 1).

use serde::{Deserialize, Serialize};

/// What is asked of the aggregates' shape.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Shape {
    /// Fewest and most vertices.
    pub vertices: [u32; 2],
    /// Law of b/a, the intermediate over the longest axis.
    pub elongation: AspectRatio,
    /// Law of c/b, the shortest over the intermediate axis.
    pub flatness: AspectRatio,
}

/// A named distribution of an aspect ratio, clipped to `min..=max`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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

impl Default for Shape {
    fn default() -> Self {
        let ratio = AspectRatio::Normal { mean: 0.75, sd: 0.1, min: 0.4, max: 1.0 };
        Self { vertices: [20, 30], elongation: ratio, flatness: ratio }
    }
}
