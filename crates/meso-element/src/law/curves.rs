//! Uniaxial curves that laws share: the rising branch of compression and the bilinear law of a crack, as decks have them.

use crate::real::Real;
use meso_mesh::materials::Strength;

/// Compressive stress at which inelastic strain begins, over the strength.
const ELASTIC_LIMIT: f64 = Strength::ELASTIC_LIMIT;
/// How far damage of a crack goes.
const LEAST_INTEGRITY: f64 = 1e-4;
/// Straight pieces of the crack law of fib Model Code 2010, 5.1.8.2: the share a - b w of f_t at the opening w, in G_f / f_t.
const BRANCHES: [(f64, f64); 2] = [(1.0, 0.8), (0.25, 0.05)];
/// Opening beyond the law's last one over which a crack takes the stiffness, in G_f / f_t.
const FADING: f64 = 0.2;
/// Least share of the stiffness beside an ended crack.
const LEAST_STANDING: f64 = 1e-3;

/// Compressive strength over crushing strain, up to the peak.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rise<R> {
    /// f_c, MPa.
    compressive: R,
    /// Part of f_c that hardening adds, MPa.
    hardening: R,
    /// 1 / (plastic strain at the peak).
    per_peak: R,
    /// Plastic strain at the peak.
    pub(super) peak: R,
    /// The a of [`bend`].
    bend: R,
}

impl<R: Real> Rise<R> {
    /// From a strength and Young's modulus, MPa.
    pub(super) fn new(strength: &Strength, youngs_modulus: f64) -> Self {
        let fc = strength.compressive_mpa;
        let peak = strength.peak_strain - fc / youngs_modulus;
        Self {
            compressive: R::splat(fc),
            hardening: R::splat((1.0 - ELASTIC_LIMIT) * fc),
            per_peak: R::splat(1.0 / peak),
            peak: R::splat(peak),
            bend: R::splat(bend(youngs_modulus * strength.peak_strain / fc)),
        }
    }

    /// Effective compressive strength and its slope at the crushing strain `crushed`.
    #[inline(always)]
    pub(super) fn at(&self, crushed: R) -> (R, R) {
        let one = R::splat(1.0);
        let x = (crushed * self.per_peak).min(one);
        let rest = one - x;
        let bent = self.bend.mul_add(x, one);
        let fall = self.hardening * rest;
        let slope = (bent + bent - self.bend * rest) * fall * self.per_peak;
        ((-fall).mul_add(rest * bent, self.compressive), slope)
    }
}

/// The a of c = 1 - 0.6 (1 - x)^2 (1 + a x), x from 0 to 1, closest to the deck's rising branch; k = E e_peak / f.
///
/// The branch is fib Model Code 2010, eq. 5.1-26, over plastic strain: with s = stress / f at plastic strain
/// x (1 - 1/k) e_peak it solves ((k - 1) / k)^2 s^2 + B X s - X (k - X) = 0, X = x (1 - 1/k), B = (k^2 - 2 k + 2) / k.
fn bend(k: f64) -> f64 {
    let (square, linear) = (((k - 1.0) / k).powi(2), (k * k - 2.0 * k + 2.0) / k);
    let (mut above, mut below) = (0.0, 0.0);
    for step in 1..100 {
        let x = f64::from(step) / 100.0;
        let strain = x * (1.0 - 1.0 / k);
        let half = linear * strain / (2.0 * square);
        let stress = (half * half + strain * (k - strain) / square).sqrt() - half;
        let weight = (1.0 - ELASTIC_LIMIT) * (1.0 - x).powi(2);
        above += weight * x * (1.0 - weight - stress.max(ELASTIC_LIMIT));
        below += (weight * x).powi(2);
    }
    // Within these the branch rises all the way.
    (above / below).clamp(-1.0, 2.0)
}

/// Share of the stress across a crack over its plastic strain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crack<R> {
    /// f_t / E.
    pub(super) elastic_strain: R,
    /// G_f / f_t, mm.
    opening: R,
    /// f_t / G_f, per mm.
    per_opening: R,
}

impl<R: Real> Crack<R> {
    /// From a strength and Young's modulus, MPa.
    pub(super) fn new(strength: &Strength, youngs_modulus: f64) -> Self {
        let ft = strength.tensile_mpa;
        Self {
            elastic_strain: R::splat(ft / youngs_modulus),
            opening: R::splat(strength.fracture_energy_n_per_mm / ft),
            per_opening: R::splat(ft / strength.fracture_energy_n_per_mm),
        }
    }

    /// The law beside another elastic strain of the strength.
    #[inline(always)]
    pub(super) fn with(self, elastic_strain: R) -> Self {
        Self { elastic_strain, ..self }
    }

    /// Width of a band at which the law snaps back, mm.
    pub(super) fn snapping_mm(strength: &Strength, youngs_modulus: f64) -> f64 {
        let ft = strength.tensile_mpa;
        strength.fracture_energy_n_per_mm / ft / (BRANCHES[0].1 * ft / youngs_modulus)
    }

    /// A piece of the crack law, share = from - slope w / (G_f / f_t) with the opening w = h (cracked + (1 - share)
    /// f_t / E): where it begins, and numerator and denominator of its fall.
    #[inline(always)]
    fn branch(&self, (from, slope): (f64, f64), cracked: R, width: R) -> (R, R, R) {
        let (from, slope) = (R::splat(from), R::splat(slope));
        let held = (R::splat(1.0) - from).mul_add(self.elastic_strain, cracked);
        let run = (-slope).mul_add(width * self.elastic_strain, self.opening);
        (from, slope * width * held, run)
    }

    /// Share of the stiffness that a crack leaves: all until the law ends, and nearly nothing once it is wider by
    /// [`FADING`].
    #[inline(always)]
    pub(super) fn standing(&self, cracked: R, width: R) -> R {
        const FADED: f64 = BRANCHES[1].0 / BRANCHES[1].1 / FADING + 1.0;
        let opening = cracked * width * self.per_opening;
        opening.mul_add(R::splat(-1.0 / FADING), R::splat(FADED)).between(LEAST_STANDING, 1.0)
    }

    /// Integrity at the plastic strain `cracked` in a band of this width.
    #[inline(always)]
    pub(super) fn integrity(&self, cracked: R, width: R) -> R {
        let (from, steep, steep_run) = self.branch(BRANCHES[0], cracked, width);
        let (to, flat, flat_run) = self.branch(BRANCHES[1], cracked, width);
        // Both quotients by one division.
        let over = R::splat(1.0) / (steep_run * flat_run);
        (from - steep * flat_run * over).max(to - flat * steep_run * over).between(LEAST_INTEGRITY, 1.0)
    }
}
