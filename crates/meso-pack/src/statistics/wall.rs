//! The wall effect: less aggregate near a mould, since no grain's middle comes closer to it than its radius.

use super::{Sample, in_order};
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::aggregate::random::{Draw, Stream};
use serde::{Deserialize, Serialize};

/// Points to a batch: each batch has its own random stream.
const BATCH: u32 = 4096;

/// Aggregate fraction by layers parallel to the surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WallEffect {
    /// Middle of the layer below the specimen's surface, mm.
    pub depth_mm: Vec<f64>,
    /// Share of the layer's sampled points that lie in an aggregate.
    pub fraction: Vec<f64>,
    /// Sampled points in the layer: the fraction's standard error is sqrt(f (1 - f) / points).
    pub points: Vec<u64>,
}

/// Points of a batch by layer: all, and those in aggregates.
type Counts = Vec<[u64; 2]>;

pub(super) fn wall_effect(sample: &Sample) -> WallEffect {
    let width = layer_width(sample);
    let mut total = Counts::new();
    in_order(sample.options.points.div_ceil(BATCH), |batch| count(sample, batch), |counts| join(&mut total, &counts));
    let mut effect = WallEffect::default();
    for (layer, [all, covered]) in total.into_iter().enumerate().filter(|(_, [all, _])| *all > 0) {
        effect.depth_mm.push((layer as f64 + 0.5) * width);
        effect.fraction.push(covered as f64 / all as f64);
        effect.points.push(all);
    }
    effect
}

fn join(total: &mut Counts, counts: &Counts) {
    total.resize(total.len().max(counts.len()), [0; 2]);
    for (sum, count) in total.iter_mut().zip(counts) {
        *sum = [sum[0] + count[0], sum[1] + count[1]];
    }
}

fn count(sample: &Sample, batch: u32) -> Counts {
    let mut stream = Stream::new(sample.options.seed, Draw::Sample, 0, u64::from(batch));
    let (container, width, mut counts) = (sample.container.aabb(), layer_width(sample), Counts::new());
    let points = BATCH.min(sample.options.points - batch * BATCH);
    for point in (0..points).map(|_| stream.point(&container.min, &container.max)) {
        let depth = sample.container.depth(&point);
        if depth >= 0.0 && depth.is_finite() {
            let layer = (depth / width) as usize;
            counts.resize(counts.len().max(layer + 1), [0; 2]);
            counts[layer][0] += 1;
            counts[layer][1] += u64::from(is_covered(sample, &point));
        }
    }
    counts
}

/// As asked, but never so thin that the layers do not fit into memory.
fn layer_width(sample: &Sample) -> f64 {
    (1e-3 * sample.container.aabb().size().max()).max(sample.options.layer_mm)
}

fn is_covered(sample: &Sample, point: &Vec3) -> bool {
    let mut near = Vec::new();
    sample.index.near(&Aabb { min: *point, max: *point }, &mut near);
    near.iter().any(|&a| sample.aggregates[a as usize].body.contains(point))
}
