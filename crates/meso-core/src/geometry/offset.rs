//! The inward offset: the ITZ's inner surface (Sec. 2.1, Fig. 2).

use super::Polyhedron;

/// Why an offset has no trustworthy answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OffsetError {
    /// The thickness is negative, NaN or infinite.
    #[error("the offset thickness is {thickness}; it must be finite and not negative")]
    Thickness {
        /// The value given, mm.
        thickness: f64,
    },
    /// The result cannot be given to the promised accuracy.
    #[error("the offset is ill-conditioned: {reason}")]
    IllConditioned {
        /// What was met.
        reason: String,
    },
}

/// The half-space erosion { x : n_i . x <= d_i - thickness |n_i| } of `body`, or `None` where it vanishes.
///
/// `thickness` in mm.
///
/// # Errors
/// See [`OffsetError`].
pub fn inward_offset(body: &Polyhedron, thickness: f64) -> Result<Option<Polyhedron>, OffsetError> {
    let _ = (body, thickness);
    todo!("landed by the geometry change")
}
