//! The wall effect: less aggregate near a mould, since no grain's middle comes closer to it than its radius.

use super::{Sample, holds};
use crate::aggregate::random::{Purpose, Stream};
use crate::math::{Aabb, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Points to a batch: each batch has its own random stream.
const BATCH: u32 = 4096;
/// Halvings of the depth's bracket: to 1e-12 of the specimen.
const HALVINGS: u32 = 40;

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
    let batches = sample.options.points.div_ceil(BATCH);
    let counts: Vec<Counts> = (0..batches).into_par_iter().map(|batch| count(sample, batch)).collect();
    let layers = counts.iter().map(Vec::len).max().unwrap_or(0);
    let sum = |layer: usize, k: usize| counts.iter().filter_map(|c| c.get(layer)).map(|c| c[k]).sum::<u64>();
    let mut effect = WallEffect::default();
    for layer in (0..layers).filter(|&layer| sum(layer, 0) > 0) {
        effect.depth_mm.push((layer as f64 + 0.5) * width);
        effect.fraction.push(sum(layer, 1) as f64 / sum(layer, 0) as f64);
        effect.points.push(sum(layer, 0));
    }
    effect
}

fn count(sample: &Sample, batch: u32) -> Counts {
    let mut stream = Stream::new(sample.options.seed, Purpose::Sample, 0, u64::from(batch));
    let (room, width, mut counts) = (sample.specimen.aabb(), layer_width(sample), Counts::new());
    let points = BATCH.min(sample.options.points - batch * BATCH);
    for point in (0..points).map(|_| stream.point(&room.min, &room.max)) {
        if holds(sample.specimen, &point, 0.0) {
            let layer = (depth(sample, &point) / width) as usize;
            counts.resize(counts.len().max(layer + 1), [0; 2]);
            counts[layer][0] += 1;
            counts[layer][1] += u64::from(is_covered(sample, &point));
        }
    }
    counts
}

/// As asked, but never so thin that the layers do not fit into memory.
fn layer_width(sample: &Sample) -> f64 {
    (1e-3 * sample.specimen.aabb().size().max()).max(sample.options.layer_mm)
}

/// Distance from a point of the specimen to its surface, mm.
fn depth(sample: &Sample, point: &Vec3) -> f64 {
    let (mut low, mut high) = (0.0, sample.specimen.aabb().size().max());
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        *(if holds(sample.specimen, point, middle) { &mut low } else { &mut high }) = middle;
    }
    low
}

fn is_covered(sample: &Sample, point: &Vec3) -> bool {
    let mut near = Vec::new();
    sample.index.near(&Aabb { min: *point, max: *point }, &mut near);
    near.iter().any(|&a| sample.aggregates[a as usize].body.contains(point))
}
