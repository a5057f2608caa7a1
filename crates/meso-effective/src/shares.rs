//! Exact volumes of the phases.

use meso_concrete::Phase;
use meso_concrete::aggregate::{Aggregate, Kind};
use meso_concrete::parallel;
use meso_concrete::specimen::Specimen;

/// Volume of every phase over the specimen's.
pub(crate) fn volume_fractions(bodies: &[Aggregate], specimen: &Specimen) -> [f64; Phase::ALL.len()] {
    let volume = specimen.volume();
    let of = |kind: Kind| {
        let bodies = bodies.iter().filter(move |body| body.kind == kind);
        // A sum of nothing is -0.
        (0.0 + bodies.map(|body| body.body.volume()).sum::<f64>()) / volume
    };
    let core = |number: usize| {
        let body = &bodies[number];
        if body.kind != Kind::Aggregate {
            return 0.0;
        }
        body.core_volume(body.itz_thickness_mm).unwrap_or_else(|_| body.body.volume())
    };
    let aggregate = parallel::map(bodies.len(), core).iter().sum::<f64>() / volume;
    let [outer, void, fibre] = [Kind::Aggregate, Kind::Void, Kind::Fibre].map(of);
    [1.0 - outer - void - fibre, outer - aggregate, aggregate, void, fibre]
}
