//! A test step by step: the state of a run, its loop, and the response of the specimen.

mod beyond_peak;
mod curve;
mod drive;
mod frame;
mod gauges;
mod lateral;
mod nodes;
mod observer;
mod path;
mod response;
mod run;
mod servo;
mod supports;

pub use beyond_peak::BeyondPeak;
pub(crate) use curve::validate_columns;
pub use curve::{Extra, Figures, Row};
pub use frame::{Frame, Mean};
pub use lateral::Lateral;
pub use meso_element::block::probe::Point;
pub use observer::Observer;
pub use response::{Ended, Energies, PhaseResult, Response, Summary};
pub use run::{Run, checkpoint_note, device};
