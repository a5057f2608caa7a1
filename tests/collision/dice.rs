//! Seeded random numbers, points and bodies of the tests.

use meso_collision::math::{Rotation, Vec3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

/// A seeded source of numbers.
#[derive(Clone)]
pub(crate) struct Dice(ChaCha8Rng);

impl Dice {
    /// A source of its own for every seed.
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// In 0..n.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.0.next_u64() % n as u64) as usize
    }

    /// Uniform in 0..1.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in -1..1.
    pub(crate) fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// In -n..=n, whole.
    pub(crate) fn integer(&mut self, n: i64) -> f64 {
        (self.below(2 * n as usize + 1) as i64 - n) as f64
    }

    /// 10 to a power between the two.
    pub(crate) fn decade(&mut self, from: f64, to: f64) -> f64 {
        libm::pow(10.0, from + (to - from) * self.unit())
    }

    pub(crate) fn vector(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }

    pub(crate) fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.vector();
            if (0.01..1.0).contains(&v.norm_squared()) {
                return v.normalize();
            }
        }
    }

    pub(crate) fn rotation(&mut self) -> Rotation {
        Rotation::new(self.direction() * (3.0 * self.unit()))
    }

    pub(crate) fn integers(&mut self, n: i64) -> Vec3 {
        Vec3::new(self.integer(n), self.integer(n), self.integer(n))
    }

    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }

    /// Points on an ellipsoid of semi-axes up to `size`.
    pub(crate) fn body(&mut self, n: usize, size: f64) -> Vec<Vec3> {
        let axes = Vec3::new(size, size * (0.5 + 0.5 * self.unit()), size * (0.5 + 0.5 * self.unit()));
        (0..n).map(|_| self.direction().component_mul(&axes)).collect()
    }

    /// Points on a turned ellipsoid: the paper's aggregates.
    pub(crate) fn grain(&mut self, vertices: usize) -> Vec<Vec3> {
        let axes = Vec3::new(1.0, 0.5 + 0.5 * self.unit(), 0.3 + 0.2 * self.unit()) * (2.5 + 7.5 * self.unit());
        let turn = self.rotation();
        (0..vertices).map(|_| turn * self.direction().component_mul(&axes)).collect()
    }

    /// Points with coordinates 0 to `side` - 1.
    pub(crate) fn lattice(&mut self, n: usize, side: usize) -> Vec<Vec3> {
        (0..n).map(|_| Vec3::from([(); 3].map(|()| self.below(side) as f64))).collect()
    }
}
