//! Voids and fibres in numbers.

use super::{Orientation, ordered_sum};
use meso_concrete::aggregate::{Aggregate, Kind};
use serde::{Deserialize, Serialize};

/// The figures of one phase beside the aggregates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhaseFigures {
    /// Voids or fibres.
    pub phase: Kind,
    /// Number of bodies.
    pub bodies: usize,
    /// Volume of the phase's bodies, mm3.
    pub volume_mm3: f64,
    /// Volume of the phase's bodies over the specimen's.
    pub fraction: f64,
    /// Surface of the phase's bodies over the specimen's volume, 1/mm.
    pub specific_surface_per_mm: f64,
    /// Directions of the longest axes; absent for voids, which have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<Orientation>,
}

impl PhaseFigures {
    /// Figures of every phase among `inclusions`, which come phase by phase, in a specimen of `room_mm3`.
    pub(super) fn all(inclusions: &[Aggregate], room_mm3: f64) -> Vec<Self> {
        inclusions.chunk_by(|a, b| a.kind == b.kind).map(|bodies| Self::of(bodies, room_mm3)).collect()
    }

    fn of(bodies: &[Aggregate], room_mm3: f64) -> Self {
        let (phase, volume_mm3) = (bodies[0].kind, ordered_sum(bodies, |body| body.body.volume()));
        Self {
            phase,
            bodies: bodies.len(),
            volume_mm3,
            fraction: volume_mm3 / room_mm3,
            specific_surface_per_mm: ordered_sum(bodies, |body| body.body.area()) / room_mm3,
            orientation: (phase != Kind::Void).then(|| Orientation::of(bodies)),
        }
    }
}
