//! The law `meso` with strengths that grow with the rate of strain, by the first branch of fib Model Code 2010, 5.1.11.
//!
//! ```text
//! f_c (r / 30e-6)^0.014 up to r = 30 /s,   f_t (r / 1e-6)^0.018 up to r = 10 /s
//! ```
//!
//! Water in pores gives this branch. The second, steeper one of the code is mostly the inertia of the specimens that it was
//! fitted to, which a mesh has; in a law it would count twice. G_f and G_c stay.
//!
//! The rate r is that of the equivalent strain sqrt(stress : strain / E), which is the axial one under axial stress. It is
//! low-passed over [`LAG_S`], and frozen where cracks or crushing begin, so that a law with constant strengths follows:
//! closed loops give no energy back, at any rate.
//!
//! That law is `meso` in other units. With c and t as the factors of f_c and f_t, stresses and strains are in units of c:
//! the tensile strength is t / c of the one at rest, and a band softens as one of c t times its width in tension, and of
//! c^2 times in compression.
//!
//! A factor s of [`Scatter`](meso_mesh::materials::Scatter), which stays, multiplies c and t, the peak strain and the
//! energies. A band then softens as one of c t / s and c^2 / s times its width.

use super::invariants::Invariants;
use super::meso::{CRACKED, CRUSHED, Meso, Rates};
use super::{Hooke, Law, PointResponse, State, Tensor};
use crate::real::Real;
use meso_mesh::materials::{self, Mesoscale, Strength};

/// Time over which the rate is low-passed, s: waves cross a grain within it.
const LAG_S: f64 = 3e-6;
/// Exponent, rate at which the strength is that at rest, and rate at which the branch ends, 1/s.
const COMPRESSION: [f64; 3] = [0.014, 30e-6, 30.0];
const TENSION: [f64; 3] = [0.018, 1e-6, 10.0];

/// Factors of f_c and f_t at a rate of strain, 1/s, by one logarithm.
#[inline(always)]
fn growth<R: Real>(rate: R) -> [R; 2] {
    let ([c, least, most], [t, least_t, most_t]) = (COMPRESSION, TENSION);
    let ln = (rate.between(least_t, most) * R::splat(1.0 / least_t)).ln();
    let compressed = (ln - R::splat(libm::log(least / least_t))).positive();
    let pulled = ln.min(R::splat(libm::log(most_t / least_t)));
    [(compressed * R::splat(c)).exp(), (pulled * R::splat(t)).exp()]
}

/// Mortar's f_c and f_t at a rate of strain, 1/s, over those at rest.
pub fn strengths_over_rest(rate_per_s: f64) -> [f64; 2] {
    growth(rate_per_s)
}

/// The law with strengths that grow with the rate of strain.
pub type Rated<R> = Scaled<R, 10>;
/// The law with strengths that scatter.
pub type Scattered<R> = Scaled<R, 9>;
/// The law with strengths that scatter and grow.
pub type RatedScattered<R> = Scaled<R, 11>;

/// The law with its step, and a history of `N` registers.
#[derive(Clone, Copy, Debug)]
pub struct Scaled<R, const N: usize> {
    meso: Meso<R>,
    elastic: Hooke<R>,
    /// The square of the equivalent strain over those of the mean stress and of the Mises stress, per MPa2.
    equivalent: [R; 2],
    per_step: R,
    /// Share of a step's rate in the low-passed one.
    share: R,
    /// Largest factor of the scatter.
    most: f64,
}

/// Where equivalent strain and rate stand in a history, after that of `meso`. Where cracks or crushing have begun, the
/// factor of f_c and that of f_t over it. The factor of the scatter, less 1, is last.
const LAST: usize = 8;
const RATE: usize = 9;

/// Factor of f_c and that of f_t over it, by the rate, and factor of both by the scatter.
struct Factors<R> {
    growth: [R; 2],
    own: R,
}

impl<R: Real, const N: usize> Scaled<R, N> {
    const IS_RATED: bool = N > RATE;
    const IS_SCATTERED: bool = N != RATE + 1;

    /// The law of a phase with these values, in steps of `dt_s`, with factors of `most` at most.
    pub fn new(elastic: &materials::Elastic, strength: &Strength, own: &Mesoscale, [dt_s, most]: [f64; 2]) -> Self {
        let (e, nu) = (elastic.youngs_modulus_mpa, elastic.poisson_ratio);
        // stress : strain = p^2 / K + q^2 / (3 G).
        let equivalent = [3.0 * (1.0 - 2.0 * nu), 2.0 * (1.0 + nu) / 3.0].map(|share| R::splat(share / (e * e)));
        Self {
            meso: Meso::new(elastic, strength, own),
            elastic: Hooke::new(elastic),
            equivalent,
            per_step: R::splat(1.0 / dt_s),
            share: R::splat(-libm::expm1(-dt_s / LAG_S)),
            most,
        }
    }

    /// Factors at the rate and the place of a history; where it has yielded, those it yielded with.
    #[inline(always)]
    fn factors(history: &[R; N], free: bool) -> Factors<R> {
        let one = R::splat(1.0);
        let mut growth = [one; 2];
        if Self::IS_RATED {
            growth = [history[LAST], history[RATE]];
            if free {
                let (yielded, [c, t]) = (Meso::yielded(history), self::growth(history[RATE]));
                growth = [R::select(yielded, growth[0], c), R::select(yielded, growth[1], t / c)];
            }
        }
        Factors { growth, own: if Self::IS_SCATTERED { one + history[N - 1] } else { one } }
    }

    /// Whether cracks or crushing have not begun somewhere.
    #[inline(always)]
    fn is_free(history: &[R; N]) -> bool {
        R::any(history[CRACKED].max(history[CRUSHED]).lt(R::splat(f64::from(f32::MIN_POSITIVE))))
    }

    /// What `meso` becomes with these factors.
    #[inline(always)]
    fn rates(Factors { growth: [c, t], own }: &Factors<R>) -> Rates<R> {
        let unit = if Self::IS_SCATTERED { *c * *own } else { *c };
        let crush = *c * unit;
        Rates { tensile: *t, crack: crush * *t, crush, unit, per: R::splat(1.0) / unit }
    }
}

impl<R: Real, const N: usize> Law<R> for Scaled<R, N> {
    /// That of `meso`, the strains of cracking and crushing in units of the factor of f_c; with rates the equivalent strain
    /// and the rate; with scatter its factor, less 1.
    type History = [R; N];

    fn virgin() -> [R; N] {
        [R::splat(0.0); N]
    }

    const RUNNING: [usize; 2] = if Self::IS_RATED { [LAST, RATE + 1] } else { [0; 2] };

    #[inline(always)]
    fn stress(&self, strain: &Tensor<R>, history: &mut [R; N], width: R) -> PointResponse<R> {
        let one = R::splat(1.0);
        let (yielded, free) = (Meso::yielded(history), Self::is_free(history));
        let mut elastic = *strain;
        if free {
            elastic = self.elastic.of(strain);
            let mut invariants = Invariants::of(&elastic);
            if Self::IS_RATED {
                let ([p, q], Invariants { mean, mises, .. }) = (self.equivalent, invariants);
                let now = (mean * p).mul_add(mean, mises * q * mises).sqrt();
                let rate = (now - history[LAST]).abs() * self.per_step;
                let passed = self.share.mul_add(rate - history[RATE], history[RATE]);
                history[LAST] = R::select(yielded, history[LAST], now);
                history[RATE] = R::select(yielded, history[RATE], passed);
            }
            if !R::any(yielded) {
                // Strengths only grow: where none is reached at rest, none is.
                if Self::IS_SCATTERED {
                    let per = one / (one + history[N - 1]);
                    invariants.mean = invariants.mean * per;
                    invariants.mises = invariants.mises * per;
                }
                if !R::any(self.meso.yields(&invariants)) {
                    return PointResponse { stress: elastic, integrity: one };
                }
            }
        }
        let factors = Self::factors(history, free);
        let PointResponse { mut stress, integrity } =
            self.meso.answer::<true, N>(strain, history, width, &Self::rates(&factors));
        if free {
            let flows = Meso::yielded(history);
            for i in 0..6 {
                // A point at rest has the same bits as where all of its register are.
                stress[i] = R::select(flows, stress[i], elastic[i]);
            }
            if Self::IS_RATED {
                history[LAST] = R::select(flows, factors.growth[0], history[LAST]);
                history[RATE] = R::select(flows, factors.growth[1], history[RATE]);
            }
        }
        PointResponse { stress, integrity }
    }

    #[inline(always)]
    fn state(&self, strain: &Tensor<R>, history: &[R; N], width: R) -> State<R> {
        let rates = Self::rates(&Self::factors(history, Self::is_free(history)));
        self.meso.shown::<true, N>(strain, history, width, &rates)
    }

    fn widest_mm(&self) -> [f64; 2] {
        let most = |[exponent, least, most]: [f64; 3]| {
            if Self::IS_RATED { libm::pow(most / least, exponent) } else { 1.0 }
        };
        let [c, t] = [COMPRESSION, TENSION].map(most);
        let [cracks, crushes] = self.meso.widest_mm();
        [cracks / (t * t * self.most), crushes / (c * c * self.most)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::point::{self, HeldStress};
    use meso_mesh::materials::{LawName, Materials};

    const DT_S: f64 = 1e-7;

    fn law(rate: bool) -> (Rated<f64>, Meso<f64>, Strength) {
        let materials = Materials::default();
        let strength = materials.mortar_strength.of(LawName::Meso);
        let dt = if rate { DT_S } else { 1e3 };
        let rated = Rated::new(&materials.mortar, &strength, &materials.meso, [dt, 1.0]);
        (rated, Meso::new(&materials.mortar, &strength, &materials.meso), strength)
    }

    /// The largest stress of a point that is strained at a rate, positive in tension.
    fn peak(rate: f64) -> f64 {
        let step = rate * DT_S;
        let most: f64 = if rate > 0.0 { 3e-4 } else { 5e-3 };
        let strains: Vec<f64> = (1..=(most / step.abs()) as usize).map(|k| step * k as f64).collect();
        let readings = point::curve(&law(true).0, 3.0, HeldStress::Lateral(0.0), &strains);
        readings.iter().map(|reading| reading.stress * rate.signum()).fold(0.0, f64::max)
    }

    #[test]
    fn a_point_at_a_constant_rate_has_the_strengths_of_the_formula() {
        let (_, _, strength) = law(true);
        for rate in [3.0, 10.0, 60.0] {
            let expected = strength.tensile_mpa * (f64::min(rate, 10.0) / 1e-6).powf(0.018);
            let found = peak(rate);
            assert!((found / expected - 1.0).abs() < 1e-4, "{rate}: {found} {expected}");
        }
        for rate in [30.0, 100.0] {
            let expected = strength.compressive_mpa * (f64::min(rate, 30.0) / 30e-6).powf(0.014);
            let found = peak(-rate);
            assert!((found / expected - 1.0).abs() < 1e-4, "{rate}: {found} {expected}");
        }
    }

    #[test]
    fn at_rest_it_is_the_law_without_rates() {
        let (rated, meso, _) = law(false);
        for sign in [1.0, -1.0] {
            let strains: Vec<f64> = point::ramp(0.0, sign * 4e-3, 500).collect();
            let held = || HeldStress::Lateral(0.0);
            let own = point::curve(&rated, 3.0, held(), &strains);
            let usual = point::curve(&meso, 3.0, held(), &strains);
            for (own, usual) in own.iter().zip(&usual) {
                assert!((own.stress - usual.stress).abs() < 1e-9 * (1.0 + usual.stress.abs()), "{own:?} {usual:?}");
            }
        }
    }

    #[test]
    fn a_crack_costs_its_fracture_energy_at_any_rate() {
        let (rated, _, strength) = law(true);
        let opening = 5.5 * strength.fracture_energy_n_per_mm / strength.tensile_mpa;
        for rate in [3.0, 10.0] {
            let step = rate * DT_S;
            let strains: Vec<f64> = (1..=(opening / 3.0 / step) as usize).map(|k| step * k as f64).collect();
            let readings = point::curve(&rated, 3.0, HeldStress::Lateral(0.0), &strains);
            let work: f64 = readings.iter().map(|reading| reading.stress * 3.0 * step).sum();
            // The law's opening has the elastic strain that its fall gives back in it.
            let most = strength.tensile_mpa * (rate / 1e-6).powf(0.018);
            let back = 1.5 * most * most / Materials::default().mortar.youngs_modulus_mpa;
            let expected = strength.fracture_energy_n_per_mm - back;
            assert!((work / expected - 1.0).abs() < 2e-3, "{rate}: {work} {expected}");
        }
    }
}
