//! Random convex aggregates: vertices on an ellipsoid, a random rotation, their hull (Sec. 2.1, Fig. 1).

use super::random::Stream;
use crate::geometry::ellipsoid::Ellipsoid;
use crate::math::Vec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

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

/// A named distribution of an aspect ratio, within `min..=max`.
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

/// The default laws are illustrative: the paper takes its ratios from measurements it does not print. Means of 0.75
/// put the average grain near Zingg's limits of 2/3 on the equant side, as crushed rock mostly is.
impl Default for Shape {
    fn default() -> Self {
        let ratio = AspectRatio::Normal { mean: 0.75, sd: 0.1, min: 0.4, max: 1.0 };
        Self { vertices: [20, 30], elongation: ratio, flatness: ratio }
    }
}

/// Fixed vertices on the axes (Sec. 2.1).
const AXIS_VERTICES: usize = 6;
/// Redraws of one vertex that comes too near to another; then the last draw is kept. At the default spacing of
/// 0.2 mm on a 5 mm grain about one draw in a hundred is refused.
const SPACING_DRAWS: usize = 100;
/// Redraws of an aspect ratio outside its limits; then it is clipped.
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

impl Shape {
    /// Draws the ellipsoid of a grain whose longest axis 2a is `length` mm.
    pub fn ellipsoid(&self, length: f64, stream: &mut Stream) -> Ellipsoid {
        let a = length / 2.0;
        let b = a * self.elongation.draw(stream);
        let c = b * self.flatness.draw(stream);
        Ellipsoid { semi_axes: Vec3::new(a, b, c) }
    }

    /// Draws the vertices on `ellipsoid`: the six axis ends, then points of uniform longitude and polar angle that keep
    /// `class_limit / vertex count` (mm) between each other.
    pub fn vertices(&self, ellipsoid: &Ellipsoid, class_limit: f64, stream: &mut Stream) -> Vec<Vec3> {
        let count = stream.integer(self.vertices[0], self.vertices[1]) as usize;
        let spacing = class_limit / count as f64;
        let mut vertices = axis_vertices(ellipsoid);
        while vertices.len() < count {
            let vertex = spaced_vertex(ellipsoid, &vertices, spacing, stream);
            vertices.push(vertex);
        }
        vertices
    }
}

fn axis_vertices(ellipsoid: &Ellipsoid) -> Vec<Vec3> {
    let mut vertices = Vec::with_capacity(32);
    for axis in 0..AXIS_VERTICES / 2 {
        let end = Vec3::ith(axis, ellipsoid.semi_axes[axis]);
        vertices.extend([-end, end]);
    }
    vertices
}

fn spaced_vertex(ellipsoid: &Ellipsoid, others: &[Vec3], spacing: f64, stream: &mut Stream) -> Vec3 {
    let mut vertex = Vec3::zeros();
    for _ in 0..SPACING_DRAWS {
        vertex = ellipsoid.point(stream.uniform(0.0, TAU), stream.uniform(0.0, PI));
        if others.iter().all(|other| (vertex - other).norm_squared() >= spacing * spacing) {
            break;
        }
    }
    vertex
}
