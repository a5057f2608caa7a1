//! Why a test cannot be run.

/// Why a test is refused before its first step.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// A value out of its range.
    #[error("{key} is {value}; {accepted}")]
    Value {
        /// Its name.
        key: String,
        /// The value given.
        value: String,
        /// The accepted values, or the way out.
        accepted: String,
    },
    /// A mesh that the engine has no elements for.
    #[error("the mesh cannot be solved: {0}")]
    Mesh(String),
    /// A saved state that does not belong to this test, or is damaged.
    #[error("the saved state cannot be resumed: {0}")]
    Resume(String),
}

impl SolveError {
    pub(crate) fn value(key: &str, value: impl ToString, accepted: impl Into<String>) -> Self {
        Self::Value { key: key.into(), value: value.to_string(), accepted: accepted.into() }
    }

    pub(crate) fn mesh(why: impl Into<String>) -> Self {
        Self::Mesh(why.into())
    }
}

/// Refuses a `value` that is not as `met` wants it; NaN meets nothing.
pub(crate) fn require(key: &str, value: f64, met: bool, accepted: &str) -> Result<(), SolveError> {
    if met { Ok(()) } else { Err(SolveError::value(key, value, accepted)) }
}
