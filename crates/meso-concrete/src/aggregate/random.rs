//! Portable randomness: ChaCha8 with one stream per use, and the few laws drawn from it.
//!
//! A grain's numbers depend on the seed and its own stream only, never on who was drawn before it or on which thread.
//! Hence a model is the same on any number of threads. Transcendental functions come from `libm`, since the platform's
//! differ in the last bit.

use meso_collision::math::{Rotation, Vec3};
use rand_chacha::ChaCha8Rng;
use rand_core::{RngCore, SeedableRng};
use std::f64::consts::TAU;

/// One stream of random numbers.
#[derive(Clone, Debug)]
pub struct Stream(ChaCha8Rng);

/// Draw of a stream; streams of different purposes never share numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum Draw {
    /// Size, shape, orientation and ITZ of a grain.
    Take = 0,
    /// Positions tried for a grain.
    Place = 1,
    /// Points looked at for a grain that found no position.
    Drop = 2,
    /// Sampling for statistics.
    Sample = 3,
    /// Waves of a field of strengths.
    Field = 4,
    /// Thicknesses of a grain's shells.
    Shells = 5,
}

impl Stream {
    /// The stream of `seed` for item `index` of `group` (a class, say).
    pub fn new(seed: u64, purpose: Draw, group: u16, index: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream((purpose as u64) << 60 | u64::from(group) << 44 | index);
        Self(rng)
    }

    /// Uniform in [0, 1), a multiple of 2^-53.
    #[inline]
    pub fn unit(&mut self) -> f64 {
        // Through i64, which is an instruction where u64 is six.
        (self.0.next_u64() >> 11) as i64 as f64 * f64::from_bits(0x3CA0_0000_0000_0000)
    }

    /// Uniform in [low, high).
    #[inline]
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform integer in low..=high.
    #[inline]
    pub fn integer(&mut self, low: u32, high: u32) -> u32 {
        low + (self.unit() * f64::from(high - low + 1)) as u32
    }

    /// Normal, by the Box-Muller transform.
    pub fn normal(&mut self, mean: f64, sd: f64) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.unit()));
        mean + sd * radius * libm::cos(TAU * self.unit())
    }

    /// A point uniform in the box from `low` to `high`.
    #[inline]
    pub fn point(&mut self, low: &Vec3, high: &Vec3) -> Vec3 {
        Vec3::from_fn(|i, _| self.uniform(low[i], high[i]))
    }

    /// A unit vector uniform over the sphere.
    pub fn direction(&mut self) -> Vec3 {
        let (z, angle) = (self.uniform(-1.0, 1.0), TAU * self.unit());
        let radius = (1.0 - z * z).sqrt();
        Vec3::new(radius * libm::cos(angle), radius * libm::sin(angle), z)
    }

    /// A rotation uniform over all orientations (K. Shoemake, Uniform random rotations, Graphics Gems III, 1992).
    pub fn rotation(&mut self) -> Rotation {
        let (u, alpha, beta) = (self.unit(), TAU * self.unit(), TAU * self.unit());
        let (s, c) = ((1.0 - u).sqrt(), u.sqrt());
        let (w, i, j, k) = (c * libm::cos(beta), s * libm::sin(alpha), s * libm::cos(alpha), c * libm::sin(beta));
        Rotation::from_quaternion(nalgebra::Quaternion::new(w, i, j, k))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_are_uniform_over_all_orientations() {
        // For a uniform rotation every image of a fixed vector is uniform on the sphere (first two moments: 0 and 1/3),
        // and the rotation angle has density (1 - cos t) / pi, whose mean is pi/2 + 2/pi.
        let mut stream = Stream::new(7, Draw::Sample, 0, 0);
        let n = 40_000;
        let (mut mean, mut square, mut angle) = (Vec3::zeros(), Vec3::zeros(), 0.0);
        for _ in 0..n {
            let rotation = stream.rotation();
            let image = rotation * Vec3::new(0.36, 0.48, 0.8);
            mean += image / f64::from(n);
            square += image.component_mul(&image) / f64::from(n);
            angle += rotation.angle() / f64::from(n);
        }
        assert!(mean.norm() < 0.015, "{mean}");
        assert!((square - Vec3::repeat(1.0 / 3.0)).norm() < 0.01, "{square}");
        let expected = std::f64::consts::FRAC_PI_2 + std::f64::consts::FRAC_2_PI;
        assert!((angle - expected).abs() < 0.02, "{angle} against {expected}");
    }

    #[test]
    fn streams_do_not_depend_on_each_other() {
        let numbers = |index| {
            let mut stream = Stream::new(1, Draw::Take, 3, index);
            [stream.unit(), stream.unit()]
        };
        assert_eq!(numbers(5), numbers(5));
        assert_ne!(numbers(5), numbers(6));
    }
}
