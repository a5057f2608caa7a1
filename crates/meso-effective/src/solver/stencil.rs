//! Fluxes out of voxels through their six links, row by row, and sums over layers.

use crate::links::Links;
use meso_collision::simd::{Wide, widest};
use meso_concrete::parallel;
use std::ops::{Add, Mul, Range, Sub};
use std::sync::{Mutex, PoisonError};

/// `f32` or `f64`.
pub(crate) trait Real:
    Copy + Default + Send + Sync + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + From<f32> + Into<f64>
{
    /// The nearest number.
    fn of(value: f64) -> Self;
}
impl Real for f32 {
    fn of(value: f64) -> Self {
        value as f32
    }
}
impl Real for f64 {
    fn of(value: f64) -> Self {
        value
    }
}

/// A layer of voxels: `of` maps the potential of each, its `given` numbers, and the flux out of it.
pub(super) struct Layer<'a, T, F, const N: usize> {
    pub(super) links: &'a Links,
    pub(super) number: usize,
    pub(super) u: &'a [T],
    pub(super) given: [&'a [T]; N],
    pub(super) out: &'a mut [f32],
    pub(super) of: F,
}

impl<T: Real, F: Fn(T, [T; N], T) -> f32, const N: usize> Wide for Layer<'_, T, F, N> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let nx = self.links.counts[0];
        let outside = vec![T::default(); nx];
        for (j, out) in self.out.chunks_exact_mut(nx).enumerate() {
            let given = self.given.map(|given| &given[j * nx..][..nx]);
            self.links.row(self.u, &outside, j, self.number).map(out, given, &self.of);
        }
    }
}

/// The potentials and links around a row of voxels.
struct Row<'a, T> {
    own: &'a [T],
    sides: [&'a [T]; 4],
    x: &'a [f32],
    links: [&'a [f32]; 4],
}

impl Links {
    #[inline(always)]
    fn row<'a, T>(&'a self, u: &'a [T], outside: &'a [T], j: usize, k: usize) -> Row<'a, T> {
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

    /// Sums of the links of every voxel of a row.
    #[inline(always)]
    pub(super) fn scales(&self, j: usize, k: usize, out: &mut [f32]) {
        let row = self.row(&self.across[0], &self.across[0], j, k);
        let n = out.len();
        let (x, [a, b, c, d]) = (&row.x[..n], row.links.map(|links| &links[..n]));
        for i in 0..n - 1 {
            out[i] = (x[i] + x[i + 1]) + (a[i] + b[i]) + (c[i] + d[i]);
        }
        let i = n - 1;
        out[i] = (x[i] + x[0]) + (a[i] + b[i]) + (c[i] + d[i]);
    }
}

impl<T: Real> Row<'_, T> {
    /// The ends come last: then the loop, whose accesses are foreseen, has brought them into the cache.
    #[inline(always)]
    fn map<const N: usize>(&self, out: &mut [f32], given: [&[T]; N], of: &impl Fn(T, [T; N], T) -> f32) {
        let nx = out.len();
        if nx > 2 {
            self.middle(&mut out[1..nx - 1], given.map(|given| &given[1..nx - 1]), of);
        }
        self.voxel(0, [nx - 1, usize::from(nx > 1)], out, given, of);
        if nx > 1 {
            self.voxel(nx - 1, [nx - 2, 0], out, given, of);
        }
    }

    /// All voxels but the ends: slices of one length, so that the loop has no checks and becomes vector instructions.
    #[inline(always)]
    fn middle<const N: usize>(&self, out: &mut [f32], given: [&[T]; N], of: &impl Fn(T, [T; N], T) -> f32) {
        let n = out.len();
        let given = given.map(|given| &given[..n]);
        let (u, left, right) = (&self.own[1..=n], &self.own[..n], &self.own[2..2 + n]);
        let [a, b, c, d] = self.sides.map(|side| &side[1..=n]);
        let (x, next) = (&self.x[1..=n], &self.x[2..2 + n]);
        let [ka, kb, kc, kd] = self.links.map(|links| &links[1..=n]);
        for i in 0..n {
            let links = [x[i], next[i], ka[i], kb[i], kc[i], kd[i]];
            let flux = through(u[i], [left[i], right[i], a[i], b[i], c[i], d[i]], links);
            out[i] = of(u[i], given.map(|given| given[i]), flux);
        }
    }

    /// A voxel at an end of the row, whose neighbours along it are `left` and `right`.
    #[inline(always)]
    fn voxel<const N: usize>(
        &self,
        i: usize,
        [left, right]: [usize; 2],
        out: &mut [f32],
        given: [&[T]; N],
        of: &impl Fn(T, [T; N], T) -> f32,
    ) {
        let ([a, b, c, d], [ka, kb, kc, kd]) = (self.sides.map(|side| side[i]), self.links.map(|links| links[i]));
        let around = [self.own[left], self.own[right], a, b, c, d];
        let flux = through(self.own[i], around, [self.x[i], self.x[right], ka, kb, kc, kd]);
        out[i] = of(self.own[i], given.map(|given| given[i]), flux);
    }
}

/// The flux out of a voxel.
#[inline(always)]
fn through<T: Real>(u: T, [left, right, a, b, c, d]: [T; 6], links: [f32; 6]) -> T {
    let [x, next, ka, kb, kc, kd] = links.map(T::from);
    let along = x * (u - left) + next * (u - right);
    let rows = ka * (u - a) + kb * (u - b);
    let layers = kc * (u - c) + kd * (u - d);
    along + rows + layers
}

/// The scalar product, by layers of `len`.
pub(crate) fn dot<S: Real, T: Real>(a: &[S], b: &[T], len: usize) -> f64 {
    let [sum] = layers_sum(a.len(), len, |range| [product(&a[range.clone()], &b[range])]);
    sum
}

/// Two scalar products with `b`, by layers of `len`.
pub(super) fn dots<S: Real, T: Real>(a: [&[S]; 2], b: &[T], len: usize) -> [f64; 2] {
    layers_sum(b.len(), len, |range| a.map(|a| product(&a[range.clone()], &b[range.clone()])))
}

/// The scalar product of a layer.
pub(super) fn product<S: Real, T: Real>(a: &[S], b: &[T]) -> f64 {
    widest(Product(a, b))
}

/// Sums side by side in a scalar product.
const SIDES: usize = 16;

struct Product<'a, S, T>(&'a [S], &'a [T]);

impl<S: Real, T: Real> Wide for Product<'_, S, T> {
    type Output = f64;
    #[inline(always)]
    fn run(self) -> f64 {
        let (a, a_rest) = self.0.as_chunks::<SIDES>();
        let (b, b_rest) = self.1.as_chunks::<SIDES>();
        let mut sums = [0.0_f64; SIDES];
        for (a, b) in a.iter().zip(b) {
            for i in 0..SIDES {
                sums[i] += a[i].into() * b[i].into();
            }
        }
        let rest = a_rest.iter().zip(b_rest).map(|(a, b)| (*a).into() * (*b).into());
        sums.iter().sum::<f64>() + rest.sum::<f64>()
    }
}

/// Fewer values than this are handled by one thread: threads that wake up for less take longer than the work, and coarse
/// levels are visited hundreds of times.
const FEW: usize = 1 << 15;

/// Sums over the layers of `len` among `count` values, in their order.
fn layers_sum<const N: usize>(count: usize, len: usize, of: impl Fn(Range<usize>) -> [f64; N] + Sync) -> [f64; N] {
    let layers = count.div_ceil(len);
    let layer = |k: usize| of(k * len..count.min((k + 1) * len));
    let add = |sums: [f64; N], layer: [f64; N]| std::array::from_fn(|i| sums[i] + layer[i]);
    if count < FEW {
        return (0..layers).map(layer).fold([0.0; N], add);
    }
    parallel::map(layers, layer).into_iter().fold([0.0; N], add)
}

/// Calls `of` for every layer of `len` values, and its number.
pub(crate) fn layers_mut<T: Send>(values: &mut [T], len: usize, of: impl Fn(usize, &mut [T]) + Sync) {
    if values.len() < FEW {
        values.chunks_mut(len).enumerate().for_each(|(k, layer)| of(k, layer));
    } else {
        parallel::chunks_mut(values, len, of);
    }
}

/// Calls `of` like [`layers_mut`]; returns the sums of its results in the order of the layers.
pub(super) fn layers_mut_sum<T: Send, const N: usize>(
    values: &mut [T],
    len: usize,
    of: impl Fn(usize, &mut [T]) -> [f64; N] + Sync,
) -> [f64; N] {
    let sums: Vec<Mutex<[f64; N]>> = (0..values.len().div_ceil(len)).map(|_| Mutex::new([0.0; N])).collect();
    let locked = |k: usize| sums[k].lock().unwrap_or_else(PoisonError::into_inner);
    layers_mut(values, len, |k, layer| *locked(k) = of(k, layer));
    (0..sums.len()).fold([0.0; N], |sum, k| std::array::from_fn(|i| sum[i] + locked(k)[i]))
}

/// `to += factor * from`.
pub(super) fn add<S: Real, T: Real>(to: &mut [S], factor: f64, from: &[T], len: usize) {
    layers_mut(to, len, |k, to| widest(Added { to, factor, from: &from[k * len..] }));
}

struct Added<'a, S, T> {
    to: &'a mut [S],
    factor: f64,
    from: &'a [T],
}

impl<S: Real, T: Real> Wide for Added<'_, S, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let add = |(to, from): (&mut S, &T)| *to = S::of((*to).into() + self.factor * (*from).into());
        self.to.iter_mut().zip(self.from).for_each(add);
    }
}

/// `p = z + ratio p`; returns `p . r`.
pub(super) fn follow<T: Real>(p: &mut [T], z: &[f32], ratio: f64, r: &[T], len: usize) -> f64 {
    let [sum] = layers_mut_sum(p, len, |k, p| {
        widest(Follow { p: &mut *p, z: &z[k * len..], ratio: T::of(ratio) });
        [product(p, &r[k * len..][..p.len()])]
    });
    sum
}

struct Follow<'a, T> {
    p: &'a mut [T],
    z: &'a [f32],
    ratio: T,
}

impl<T: Real> Wide for Follow<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        self.p.iter_mut().zip(self.z).for_each(|(p, z)| *p = T::from(*z) + self.ratio * *p);
    }
}
