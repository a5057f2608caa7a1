//! The observer of a test: it receives progress and frames, and may stop the test or keep its state.

use crate::march::curve::Row;
use crate::march::frame::Frame;
use crate::march::run::Run;

/// How far a test is.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// Share of the way that is over, 0 to 1, in time at the plates' full speed.
    pub done: f64,
    /// The latest row of the curve.
    pub row: &'a Row,
}

/// The answer of an observer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// Go on.
    GoOn,
    /// Hand over the state by [`Observer::keep`], then go on.
    Keep,
    /// Stop; the curve so far stays valid.
    Stop,
}

/// Watches a test. Every method has a default that does nothing.
pub trait Observer {
    /// Called for every row of the curve.
    fn progress(&self, _: &Progress) -> Wish {
        Wish::GoOn
    }

    /// Whether to stop, asked after every step: rows of a large mesh may be seconds apart.
    fn stops(&self) -> bool {
        false
    }

    /// Called for every frame; its fields are computed on demand.
    fn frame(&self, _: &Frame) {}

    /// Called after [`Wish::Keep`]; [`Run::save`] writes the state.
    fn keep(&self, _: &Run) {}
}

/// Watches nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {}
