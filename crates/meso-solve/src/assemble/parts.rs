//! What an assembly is made of.

use crate::block::Common;
use crate::sample::Sample;
use crate::test::Smoothing;
use meso_mesh::Phase;

/// A mesh, its phases in the test, and the choices that its elements depend on.
pub(crate) struct Parts<'a> {
    pub(crate) sample: &'a Sample<'a>,
    /// Of every cell.
    pub(crate) phases: &'a [Phase],
    pub(crate) common: &'a Common,
    /// Time step, s.
    pub(crate) dt: f64,
    /// Of tetrahedra.
    pub(crate) smoothing: Smoothing,
}
