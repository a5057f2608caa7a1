//! The observer of a test: it receives rows of the curve and frames, and may keep the test's state.

use crate::march::curve::Row;
use crate::march::frame::Frame;
use crate::march::run::Run;
use meso_concrete::watch::Silent;

/// Receives rows, frames and states of a test on its way. Every method has a default that does nothing.
pub trait Observer {
    /// Receives every row of the curve, and the share of the test that is done, 0 to 1, in time at the plates' full speed.
    fn row(&self, _: &Row, _done: f64) {}

    /// Whether to hand over the state by [`keep`](Observer::keep); asked after every row.
    fn keeps(&self) -> bool {
        false
    }

    /// Receives the state, which [`Run::save`] writes.
    fn keep(&self, _: &Run) {}

    /// Whether to receive this moment by [`moment`](Observer::moment); asked after every row.
    fn wants(&self, _: &Row) -> bool {
        false
    }

    /// Receives the moment after a row that the observer wants; its fields are computed on demand.
    fn moment(&self, _: &Frame) {}

    /// Receives every frame; its fields are computed on demand.
    fn frame(&self, _: &Frame) {}
}

impl Observer for Silent {}
