//! Gaps around aggregates: a mesh asks for them, a packing leaves them.

/// Gaps that a mesh needs, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Room {
    /// This gap between aggregates and to the specimen's surface; the mesh cannot be built with less.
    Everywhere(f64),
    /// Up to this gap between aggregates; less if the packing would get too dense.
    Between(f64),
}
