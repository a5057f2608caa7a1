//! Input of an assembly.

use crate::sample::Sample;
use crate::test::Smoothing;
use meso_element::block::Common;

/// A mesh and the choices that its elements depend on.
pub(crate) struct Parts<'a> {
    pub(crate) sample: &'a Sample<'a>,
    pub(crate) common: &'a Common,
    /// Time step, s.
    pub(crate) dt: f64,
    /// Smoothing of tetrahedra.
    pub(crate) smoothing: Smoothing,
}
