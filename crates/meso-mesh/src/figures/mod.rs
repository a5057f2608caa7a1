//! Figures of a finished mesh: shapes of its cells, cost of mass scaling, distance from its bodies.

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
