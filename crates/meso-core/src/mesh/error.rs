//! What a mesh cannot be made of.

/// Why there is no mesh: what, where, and the way out.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// An option is out of its range.
    #[error("mesh.{key} is {value}; {accepted}")]
    Option {
        /// The option's name.
        key: &'static str,
        /// What was given.
        value: String,
        /// What is accepted.
        accepted: String,
    },
}

impl MeshError {
    pub(crate) fn option(key: &'static str, value: impl ToString, accepted: impl Into<String>) -> Self {
        Self::Option { key, value: value.to_string(), accepted: accepted.into() }
    }
}
