//! Exact volumes of the phases.

use meso_concrete::aggregate::{Aggregate, Kind};
use meso_concrete::parallel;
use meso_concrete::specimen::Specimen;
use meso_concrete::{Phase, PhaseNames};

/// Volume of every phase over the specimen's, by [`Phase::index`].
pub(crate) fn volume_fractions(bodies: &[Aggregate], specimen: &Specimen, names: &PhaseNames) -> Vec<f64> {
    let volume = specimen.volume();
    let of = |kind: Kind| {
        let bodies = bodies.iter().filter(move |body| body.kind == kind);
        // A sum of nothing is -0.
        (0.0 + bodies.map(|body| body.body.volume()).sum::<f64>()) / volume
    };
    let layers = |number: usize| {
        let body = &bodies[number];
        let is_core = body.kind == Kind::Aggregate;
        let core = || body.core_volume(body.itz_thickness_mm).unwrap_or_else(|_| body.body.volume());
        let core = if is_core { core() } else { 0.0 };
        let shelled = (!body.shells.is_empty()).then(|| body.layer_volumes(body.itz_thickness_mm).ok()).flatten();
        (core, shelled.unwrap_or_else(|| vec![(body.phase(), core)]))
    };
    let (cores, layers): (Vec<f64>, Vec<_>) = parallel::map(bodies.len(), layers).into_iter().unzip();
    let layers = layers.concat();
    let inside = cores.iter().sum::<f64>() / volume;
    let [outer, void, fibre] = [Kind::Aggregate, Kind::Void, Kind::Fibre].map(of);
    let own = |phase: Phase| {
        let own = layers.iter().filter(|(of, _)| *of == phase);
        0.0 + own.map(|(_, volume)| volume).sum::<f64>() / volume
    };
    let aggregate = if names.own().len() == 0 { inside } else { own(Phase::Aggregate) };
    let own = names.own().map(own);
    [1.0 - outer - void - fibre, outer - inside, aggregate, void, fibre].into_iter().chain(own).collect()
}
