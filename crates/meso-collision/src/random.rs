//! Seeded numbers for the unit tests.

use crate::math::Vec3;
use rand_chacha::ChaCha8Rng;
use rand_core::{RngCore, SeedableRng};

pub(crate) struct Stream(ChaCha8Rng);

impl Stream {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Uniform in [low, high).
    pub(crate) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        low + (high - low) * unit
    }

    /// A point uniform in the box from `low` to `high`.
    pub(crate) fn point(&mut self, low: &Vec3, high: &Vec3) -> Vec3 {
        Vec3::from_fn(|i, _| self.uniform(low[i], high[i]))
    }

    /// A unit vector uniform over the sphere.
    pub(crate) fn direction(&mut self) -> Vec3 {
        let (z, angle) = (self.uniform(-1.0, 1.0), self.uniform(0.0, std::f64::consts::TAU));
        let radius = (1.0 - z * z).sqrt();
        Vec3::new(radius * libm::cos(angle), radius * libm::sin(angle), z)
    }
}
