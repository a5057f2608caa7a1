//! Bodies inside a specimen, borrowed from whoever owns them.

use crate::aggregate::Aggregate;
use crate::specimen::Specimen;
use std::borrow::Cow;

/// Disjoint bodies and the specimen that contains them: the input of meshing and of the figures on a mesh.
#[derive(Clone, Debug)]
pub struct Parts<'a> {
    /// Aggregates first, then voids and fibres; the body with id i is the i-th.
    pub bodies: Cow<'a, [Aggregate]>,
    /// The specimen around them.
    pub specimen: &'a Specimen,
}

impl<'a, B: AsRef<[Aggregate]> + ?Sized> From<(&'a B, &'a Specimen)> for Parts<'a> {
    fn from((bodies, specimen): (&'a B, &'a Specimen)) -> Self {
        Self { bodies: Cow::Borrowed(bodies.as_ref()), specimen }
    }
}
