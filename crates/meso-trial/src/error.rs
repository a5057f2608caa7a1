//! Refusals of a test.

use meso_concrete::{OutOfRange, Ranges};

/// Checks values by their names in a [`Test`](crate::Test).
pub const TEST: Ranges = Ranges("test");

/// Why a specimen or its mesh cannot have a test.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TrialError {
    /// A value of the test is out of its range.
    #[error(transparent)]
    Value(#[from] OutOfRange),
    /// A mesh that cannot be tested.
    #[error("the mesh cannot be solved: {0}")]
    Mesh(String),
}

impl TrialError {
    pub(crate) fn mesh(why: impl Into<String>) -> Self {
        Self::Mesh(why.into())
    }
}
