//! Fluxes out of a row of voxels through their six links.

use crate::links::Links;
use meso_concrete::parallel;
use std::ops::{Add, Mul, Sub};

/// `f32` or `f64`.
pub(crate) trait Real:
    Copy + Default + Send + Sync + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + From<f32> + Into<f64>
{
}
impl Real for f32 {}
impl Real for f64 {}

/// The potentials and links around a row of voxels.
pub(super) struct Row<'a, T> {
    own: &'a [T],
    sides: [&'a [T]; 4],
    x: &'a [f32],
    links: [&'a [f32]; 4],
}

impl Links {
    pub(super) fn row<'a, T>(&'a self, u: &'a [T], outside: &'a [T], j: usize, k: usize) -> Row<'a, T> {
        let [nx, ny, nz] = self.counts;
        let [x, y, z] = &self.across;
        let at = |j: usize, k: usize| (k * ny + j) * nx;
        let next = |i: usize, n: usize| if i + 1 == n { 0 } else { i + 1 };
        let before = |i: usize, n: usize| if i == 0 { n - 1 } else { i - 1 };
        let slice = |start: usize| &u[start..start + nx];
        let below = if k == 0 && !self.wraps { outside } else { slice(at(j, before(k, nz))) };
        let above = if k + 1 == nz && !self.wraps { outside } else { slice(at(j, next(k, nz))) };
        let link = |of: &'a [f32], start: usize| &of[start..start + nx];
        Row {
            own: slice(at(j, k)),
            sides: [slice(at(before(j, ny), k)), slice(at(next(j, ny), k)), below, above],
            x: link(x, at(j, k)),
            links: [link(y, at(j, k)), link(y, at(next(j, ny), k)), link(z, at(j, k)), link(z, at(j, k + 1))],
        }
    }
}

impl<T: Real> Row<'_, T> {
    #[inline]
    pub(super) fn fluxes(&self, mut visit: impl FnMut(usize, T, f32)) {
        let nx = self.own.len();
        let [a, b, c, d] = self.sides.map(|side| &side[..nx]);
        let [ka, kb, kc, kd] = self.links.map(|links| &links[..nx]);
        let (own, x) = (self.own, &self.x[..nx]);
        let mut at = |i: usize, left: T, right: T, next: f32| {
            let u = own[i];
            let along = T::from(x[i]) * (u - left) + T::from(next) * (u - right);
            let rows = T::from(ka[i]) * (u - a[i]) + T::from(kb[i]) * (u - b[i]);
            let layers = T::from(kc[i]) * (u - c[i]) + T::from(kd[i]) * (u - d[i]);
            visit(i, along + rows + layers, (x[i] + next) + (ka[i] + kb[i]) + (kc[i] + kd[i]));
        };
        if nx == 1 {
            return at(0, own[0], own[0], x[0]);
        }
        at(0, own[nx - 1], own[1], x[1]);
        for i in 1..nx - 1 {
            at(i, own[i - 1], own[i + 1], x[i + 1]);
        }
        at(nx - 1, own[nx - 2], own[0], x[0]);
    }
}

/// The scalar product, by layers of `len`.
pub(crate) fn dot<S: Real, T: Real>(a: &[S], b: &[T], len: usize) -> f64 {
    let layer = |k: usize| {
        let range = k * len..a.len().min((k + 1) * len);
        // Eight sums side by side.
        let (a, b) = (&a[range.clone()], &b[range]);
        let mut sums = [0.0_f64; 8];
        for (a, b) in a.chunks(8).zip(b.chunks(8)) {
            a.iter().zip(b).zip(&mut sums).for_each(|((a, b), sum)| *sum += (*a).into() * (*b).into());
        }
        sums.iter().sum::<f64>()
    };
    let count = a.len().div_ceil(len);
    if a.len() < FEW { (0..count).map(layer).sum() } else { parallel::map(count, layer).iter().sum() }
}

/// Fewer values than this are handled by one thread: threads that wake up for less take longer than the work, and coarse
/// levels are visited hundreds of times.
const FEW: usize = 1 << 15;

/// Calls `of` for every layer of `len` values, and its number.
pub(crate) fn layers_mut<T: Send>(values: &mut [T], len: usize, of: impl Fn(usize, &mut [T]) + Sync) {
    if values.len() < FEW {
        values.chunks_mut(len).enumerate().for_each(|(k, layer)| of(k, layer));
    } else {
        parallel::chunks_mut(values, len, of);
    }
}

/// `to += factor * from`.
pub(super) fn add<T: Real>(to: &mut [T], factor: T, from: &[T], len: usize) {
    layers_mut(to, len, |k, to| {
        let from = &from[k * len..][..to.len()];
        to.iter_mut().zip(from).for_each(|(to, from)| *to = *to + factor * *from);
    });
}
