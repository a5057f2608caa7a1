//! Reasons why a question has no answer: faults of the points.

use crate::math::Vec3;

/// Which of the two bodies an error speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operand {
    /// The first.
    A,
    /// The second.
    B,
    /// The body of this index, of many.
    Many(usize),
    /// The displacements.
    Shifts,
}

impl std::fmt::Display for Operand {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::A => f.write_str("a"),
            Self::B => f.write_str("b"),
            Self::Shifts => f.write_str("shifts"),
            Self::Many(index) => write!(f, "bodies[{index}]"),
        }
    }
}

/// Why a question has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GjkError {
    /// A body without points.
    #[error("{body} has no points; a body needs at least one")]
    Empty {
        /// Which body.
        body: Operand,
    },
    /// A coordinate is NaN or infinite.
    #[error("{body}: point {index} has the coordinate {value}; coordinates must be finite")]
    NotFinite {
        /// Which body.
        body: Operand,
        /// Row of the point.
        index: usize,
        /// The coordinate.
        value: f64,
    },
    /// No method has this name.
    #[error("method is {name:?}; accepted are \"enhanced\", \"classical\", \"signed-volumes\" and \"exact\"")]
    UnknownMethod {
        /// The name given.
        name: String,
    },
}

/// Refuses points that form no body.
pub(crate) fn check(points: &[Vec3], body: Operand) -> Result<(), GjkError> {
    if points.is_empty() {
        return Err(GjkError::Empty { body });
    }
    check_finite(points, body)
}

/// Refuses NaN and infinity.
pub(crate) fn check_finite(points: &[Vec3], body: Operand) -> Result<(), GjkError> {
    for (index, point) in points.iter().enumerate() {
        if let Some(&value) = point.iter().find(|value| !value.is_finite()) {
            return Err(GjkError::NotFinite { body, index, value });
        }
    }
    Ok(())
}
