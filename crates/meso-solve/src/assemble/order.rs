//! Morton's curve: neighbours in space are neighbours in memory.

use meso_collision::math::{Aabb, Vec3};
use rayon::prelude::*;

/// Bits per axis.
const BITS: u32 = 21;

/// Numbers of `count` points, along the curve; of points at one position the lower number comes first.
pub(crate) fn along_curve(count: usize, aabb: &Aabb, point: impl Fn(usize) -> Vec3 + Sync) -> Vec<u32> {
    let mut keys: Vec<(u64, u32)> =
        (0..count).into_par_iter().map(|number| (key(aabb, &point(number)), number as u32)).collect();
    keys.par_sort_unstable();
    keys.into_iter().map(|(_, number)| number).collect()
}

/// Place of a point along the curve through `aabb`.
pub(crate) fn key(aabb: &Aabb, point: &Vec3) -> u64 {
    let scale = f64::from((1 << BITS) - 1) / aabb.size().max().max(f64::MIN_POSITIVE);
    let step = |axis: usize| spread(((point[axis] - aabb.min[axis]) * scale) as u64);
    step(0) | step(1) << 1 | step(2) << 2
}

/// The bits of `x`, two zeros after each.
fn spread(x: u64) -> u64 {
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}
