//! What is asked of a finished mesh: the shapes of its cells, what mass scaling costs, and how true it is to its bodies.

mod closed_gaps;
mod interface_distance;
mod mass_scaling;
mod phase_volumes;
mod quality;

pub(crate) use closed_gaps::note_closed_gaps;
pub use interface_distance::InterfaceDistance;
pub use mass_scaling::{MassScaling, PhaseScaling};
pub use phase_volumes::PhaseVolumes;
pub use quality::{CellQuality, QualityReport};
