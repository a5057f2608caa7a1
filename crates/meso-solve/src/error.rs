//! Refusals of a test.

use meso_concrete::OutOfRange;
pub(crate) use meso_trial::TEST;
use meso_trial::TrialError;

/// Why a test is refused before its first step.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// A value of the test or of its materials is out of its range.
    #[error(transparent)]
    Value(#[from] OutOfRange),
    /// A mesh that the engine has no elements for.
    #[error("the mesh cannot be solved: {0}")]
    Mesh(String),
    /// A saved state that does not belong to this test, or is damaged.
    #[error("the saved state cannot be resumed: {0}")]
    Resume(String),
    /// A test that the device cannot take.
    #[error("{0}")]
    Device(String),
}

impl SolveError {
    pub(crate) fn mesh(why: impl Into<String>) -> Self {
        Self::Mesh(why.into())
    }
}

impl From<TrialError> for SolveError {
    fn from(error: TrialError) -> Self {
        match error {
            TrialError::Value(wrong) => Self::Value(wrong),
            TrialError::Mesh(why) => Self::Mesh(why),
        }
    }
}
