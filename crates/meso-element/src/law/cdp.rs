//! Concrete damaged plasticity: Lubliner et al. 1989 (Int. J. Solids Struct. 25:299), Lee and Fenves 1998 (J. Eng. Mech.
//! 124:892), as Abaqus documents it and as the decks of `meso-core` ask for it.
//!
//! In effective stress s (q Mises, p mean, s1 the largest principal one), with c and f_t the effective strengths:
//!
//! ```text
//!     F = (q + 3 alpha p + beta <s1> - gamma <-s1>) / (1 - alpha) - c(kc) <= 0
//!     alpha = (fb - 1) / (2 fb - 1),  beta = (1 - alpha) c / f_t - (1 + alpha),  gamma = 3 (1 - Kc) / (2 Kc - 1)
//!     G = sqrt((ecc f_t tan psi)^2 + q^2) + p tan psi
//!     d kt = r max(d ep_1, 0),  d kc = (1 - r) max(-d ep_3, 0),  r = sum <s_i> / sum |s_i|
//!     stress = (1 - dc) (1 - r dt) s         (stiffness recovery w_c = 1, w_t = 0)
//! ```
//!
//! The decks' damage is d = 1 - stress / strength. So effective strength rises to the peak and stays there, and damage does
//! all the softening: plasticity and damage part just so in Abaqus on these decks. dt follows the decks' bilinear crack
//! law, dc their exponential one, both over inelastic strain, plastic strain plus the elastic strain that damage gave up.
//!
//! Differences to Abaqus with the same deck:
//! - The rising branch is one polynomial through the deck's polygon, within 2.6 % of the strength (peak and its strain agree).
//! - A crack's plastic opening is its opening less d f_t h / E; Abaqus takes a unit length in place of h. So here the whole
//!   stress-opening curve spends the fracture energy on any width, there f_t^2 (h - 1 mm) / 2E more.
//! - Tensile damage goes on to 0.9999, where Abaqus keeps the deck's last 0.99.
//! - A step's direction of flow and Lode angle are the trial stress's: explicit steps are small.
//! - No viscosity, which Abaqus/Explicit has not either.

use super::curves::{Crack, Rise};
use super::elastic::{elastic_part, energy, flow};
use super::invariants::Invariants;
use super::{Hooke, Law, LawName, PointResponse, State, Tensor, softening};
use crate::real::Real;
use meso_concrete::OutOfRange;
use meso_mesh::materials::{self, MATERIALS, Materials, Plasticity, Strength};

/// Parameters, as registers.
#[derive(Clone, Copy, Debug)]
pub struct Cdp<R> {
    elastic: Hooke<R>,
    /// 1 / (3 K), 1 / (2 G), both per MPa.
    per_volume: R,
    per_shear: R,
    /// 3 K, 3 G over tan psi and 1: how fast mean and Mises stress fall along the flow.
    mean_fall: R,
    three_shear: R,
    /// tan(psi) / 3 and the square of the potential's rounding.
    dilation: R,
    rounding: R,
    three_alpha: R,
    one_less_alpha: R,
    one_more_alpha: R,
    gamma: R,
    /// (1 - alpha) / f_t
    beta_slope: R,
    rise: Rise<R>,
    crack: Crack<R>,
    /// f_c / E.
    compressive_strain: R,
    /// Strength over crushing energy, per mm.
    per_crushing_opening: R,
    /// Widest bands of cracking and of crushing, mm.
    widest: [R; 2],
    widest_mm: [f64; 2],
}

/// Newton's steps; the equation is convex, so each ends on the safe side. A third changes no strength at steps of 1e-4.
const STEPS: usize = 2;

/// Finds out whether the law can have these values.
///
/// # Errors
/// Names the first one that it cannot have.
pub fn validate(materials: &Materials) -> Result<(), OutOfRange> {
    materials.validate_elastic()?;
    materials.validate_strength(LawName::Cdp)?;
    materials.validate_peak_strains(LawName::Cdp)?;
    let Plasticity { dilation_angle_deg: angle, eccentricity, biaxial_ratio, meridian_ratio, .. } =
        materials.plasticity;
    let accepted = "it must lie above 0 and below 60; 15 to 40 is usual";
    MATERIALS.require("plasticity.dilation_angle_deg", angle, angle > 0.0 && angle < 60.0, accepted)?;
    let accepted = "it must be 0 to 1; 0.1 is usual";
    MATERIALS.require("plasticity.eccentricity", eccentricity, (0.0..=1.0).contains(&eccentricity), accepted)?;
    let accepted = "it must be 1 to 2; 1.16 is usual";
    MATERIALS.require("plasticity.biaxial_ratio", biaxial_ratio, (1.0..=2.0).contains(&biaxial_ratio), accepted)?;
    let accepted = "it must lie above 0.5 and at most at 1; 2/3 to 0.8 is usual";
    MATERIALS.require(
        "plasticity.meridian_ratio",
        meridian_ratio,
        meridian_ratio > 0.5 && meridian_ratio <= 1.0,
        accepted,
    )?;
    let (alpha, given) = (alpha(materials.plasticity.biaxial_ratio), materials.mortar_strength.of(LawName::Cdp));
    let most = Strength::ELASTIC_LIMIT * given.compressive_mpa * (1.0 - alpha) / (1.0 + alpha);
    let accepted = format!("it must be at most {most:.4}: the surface has no beta below 0 where hardening begins");
    MATERIALS.require("mortar_strength.tensile_mpa", given.tensile_mpa, given.tensile_mpa <= most, accepted)
}

/// alpha of the biaxial over the uniaxial compressive strength.
pub(super) fn alpha(biaxial: f64) -> f64 {
    (biaxial - 1.0) / (2.0 * biaxial - 1.0)
}

impl<R: Real> Cdp<R> {
    /// The law of a phase with these values, which [`validate`] has seen.
    pub fn new(elastic: &materials::Elastic, strength: &Strength, plasticity: &Plasticity) -> Self {
        let (e, nu) = (elastic.youngs_modulus_mpa, elastic.poisson_ratio);
        let (bulk, shear) = (e / (3.0 * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)));
        let (fc, ft, kc) = (strength.compressive_mpa, strength.tensile_mpa, plasticity.meridian_ratio);
        let tan = libm::tan(plasticity.dilation_angle_deg.to_radians());
        let alpha = alpha(plasticity.biaxial_ratio);
        let crushing_opening = strength.crushing_energy_n_per_mm / fc;
        let snapping = [Crack::<R>::snapping_mm(strength, e), crushing_opening / (fc / e)];
        let widest_mm = snapping.map(|width| softening::SNAP_BACK * width);
        let splat = R::splat;
        Self {
            elastic: Hooke::new(elastic),
            per_volume: splat(1.0 / (3.0 * bulk)),
            per_shear: splat(1.0 / (2.0 * shear)),
            mean_fall: splat(bulk * tan),
            three_shear: splat(3.0 * shear),
            dilation: splat(tan / 3.0),
            rounding: splat((plasticity.eccentricity * ft * tan).powi(2)),
            three_alpha: splat(3.0 * alpha),
            one_less_alpha: splat(1.0 - alpha),
            one_more_alpha: splat(1.0 + alpha),
            gamma: splat(3.0 * (1.0 - kc) / (2.0 * kc - 1.0)),
            beta_slope: splat((1.0 - alpha) / ft),
            rise: Rise::new(strength, e),
            crack: Crack::new(strength, e),
            compressive_strain: splat(fc / e),
            per_crushing_opening: splat(1.0 / crushing_opening),
            widest: widest_mm.map(splat),
            widest_mm,
        }
    }
}

/// Quantities of a step of plasticity.
#[derive(Clone, Copy)]
struct PlasticTrial<R> {
    invariants: Invariants<R>,
    /// Hardening of compression per step of flow.
    harden: R,
    /// How fast Mises and the largest principal stress fall.
    mises_fall: R,
    largest_fall: R,
    largest: R,
    crushed: R,
    /// How fast the share of the Mises stress that is left falls.
    share_fall: R,
}

impl<R: Real> Cdp<R> {
    /// (1 - alpha) F and how fast it falls along the flow, at `flow`.
    #[inline(always)]
    fn excess(&self, trial: &PlasticTrial<R>, flow: R) -> (R, R) {
        let zero = R::splat(0.0);
        let (strength, hardening) = self.rise.at(trial.harden.mul_add(flow, trial.crushed));
        let mises = (-trial.mises_fall).mul_add(flow, trial.invariants.mises);
        let mean = (-self.mean_fall).mul_add(flow, trial.invariants.mean);
        let largest = (-trial.largest_fall).mul_add(flow, trial.largest);
        let beta = self.beta_slope.mul_add(strength, -self.one_more_alpha).positive();
        let tensile = zero.lt(largest);
        let weight = R::select(tensile, beta, self.gamma);
        let pressed = self.three_alpha.mul_add(mean, mises);
        let excess = weight.mul_add(largest, pressed) - self.one_less_alpha * strength;
        let lift = R::select(tensile, self.beta_slope * largest, zero) - self.one_less_alpha;
        let fall = self.three_alpha.mul_add(self.mean_fall, trial.mises_fall);
        let fall = weight.mul_add(trial.largest_fall, fall) - lift * hardening * trial.harden;
        (excess, fall)
    }

    /// Where a point can yield or is damaged. The bound is an upper one, since the largest principal stress is at most
    /// p + 2 q / 3, and gamma takes away only.
    #[inline(always)]
    fn active(&self, of: &Invariants<R>, cracked: R, crushed: R) -> R::Mask {
        let zero = R::splat(0.0);
        let (strength, _) = self.rise.at(crushed);
        let beta = self.beta_slope.mul_add(strength, -self.one_more_alpha).positive();
        let largest = R::splat(2.0 / 3.0).mul_add(of.mises, of.mean).positive();
        let pressed = self.three_alpha.mul_add(of.mean, of.mises);
        let bound = beta.mul_add(largest, pressed) - self.one_less_alpha * strength;
        zero.lt(bound) | zero.lt(cracked) | self.rise.peak.lt(crushed)
    }

    /// The trial stress's directions.
    #[inline(always)]
    fn trial(&self, invariants: Invariants<R>, shape: &[R; 3], tension: R, crushed: R) -> PlasticTrial<R> {
        let q = invariants.mises;
        let two_thirds = R::splat(2.0 / 3.0);
        // dG/dq = q / sqrt(q^2 + a^2)
        let per_potential = R::splat(1.0) / q.mul_add(q, self.rounding).sqrt().max(R::splat(1e-8));
        let along = q * per_potential;
        let least = along.mul_add(shape[2], self.dilation);
        let mises_fall = self.three_shear * along;
        PlasticTrial {
            harden: (R::splat(1.0) - tension) * (-least).positive(),
            mises_fall,
            largest_fall: two_thirds.mul_add(mises_fall * shape[0], self.mean_fall),
            largest: (two_thirds * q).mul_add(shape[0], invariants.mean),
            crushed,
            share_fall: self.three_shear * per_potential,
            invariants,
        }
    }

    /// Mean stress at the surface's tip, on the side of tension.
    #[inline(always)]
    fn tip(&self, crushed: R) -> R {
        let strength = self.rise.at(crushed).0;
        let beta = self.beta_slope.mul_add(strength, -self.one_more_alpha).positive();
        self.one_less_alpha * strength / (self.three_alpha + beta)
    }

    /// Share of the Mises stress that the return leaves, and the mean stress after it.
    #[inline(always)]
    fn back(&self, trial: &PlasticTrial<R>, active: R::Mask) -> (R, R) {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let mut flow = zero;
        for _ in 0..STEPS {
            let (excess, fall) = self.excess(trial, flow);
            flow = (flow + excess / fall).positive();
        }
        let flow = R::select(active, flow, zero);
        let mean = trial.invariants.mean;
        let left = (-trial.share_fall).mul_add(flow, one);
        let returned = (-self.mean_fall).mul_add(flow, mean);
        let beyond = left.lt(zero);
        // Seldom anywhere, and one division less.
        if !R::any(beyond) {
            return (left, returned);
        }
        let tip = self.tip(trial.harden.mul_add(flow, trial.crushed)).min(mean);
        (R::select(beyond, zero, left), R::select(beyond, tip, returned))
    }

    /// Integrities of tension and compression, on this width.
    #[inline(always)]
    fn integrity(&self, cracked: R, crushed: R, width: R) -> [R; 2] {
        let [cracking, crushing] = self.widest.map(|widest| width.min(widest));
        let crack = self.crack.integrity(cracked, cracking);
        let per_scale = crushing * self.per_crushing_opening;
        let x = (crushed - self.rise.peak).positive() * per_scale;
        let crush = softening::integrity(x, self.compressive_strain * per_scale).min(R::splat(1.0));
        [crack, R::select(self.rise.peak.lt(crushed), crush, R::splat(1.0))]
    }
}

/// Share of tension among the principal stresses, 0 to 1.
#[inline(always)]
fn tension<R: Real>(mean: R, mises: R, shape: &[R; 3]) -> R {
    let scale = R::splat(2.0 / 3.0) * mises;
    let [mut pulled, mut all] = [R::splat(0.0); 2];
    for y in shape {
        let principal = scale.mul_add(*y, mean);
        pulled = pulled + principal.positive();
        all = all + principal.abs();
    }
    pulled / all.max(R::splat(1e-8))
}

/// Where plastic strain ends and the two hardening strains stand in a history.
const CRACKED: usize = 6;
const CRUSHED: usize = 7;

impl<R: Real> Law<R> for Cdp<R> {
    /// Plastic strain, then the plastic strains of cracking and of crushing.
    type History = [R; 8];

    fn virgin() -> [R; 8] {
        [R::splat(0.0); 8]
    }

    #[inline(always)]
    fn stress(&self, strain: &Tensor<R>, history: &mut [R; 8], width: R) -> PointResponse<R> {
        let one = R::splat(1.0);
        let stress = self.elastic.of(&elastic_part(strain, history));
        let invariants = Invariants::of(&stress);
        let active = self.active(&invariants, history[CRACKED], history[CRUSHED]);
        if !R::any(active) {
            return PointResponse { stress, integrity: one };
        }
        let shape = invariants.shape();
        let Invariants { mean, deviator, mises } = invariants;
        let trial = self.trial(invariants, &shape, tension(mean, mises, &shape), history[CRUSHED]);
        let (left, new_mean) = self.back(&trial, active);

        let volumetric = (mean - new_mean) * self.per_volume;
        let lost = (one - left) * self.per_shear;
        flow(history, &deviator, lost, volumetric);
        let scale = R::splat(2.0 / 3.0) * mises * lost;
        let largest = scale.mul_add(shape[0], volumetric).positive();
        let least = (-scale.mul_add(shape[2], volumetric)).positive();
        let pulled = tension(new_mean, left * mises, &shape);
        history[CRACKED] = pulled.mul_add(largest, history[CRACKED]);
        history[CRUSHED] = (one - pulled).mul_add(least, history[CRUSHED]);

        let [crack, crush] = self.integrity(history[CRACKED], history[CRUSHED], width);
        let integrity = crush * (-pulled).mul_add(one - crack, one);
        let (kept, pressed) = (integrity * left, integrity * new_mean);
        let mut nominal = stress;
        for i in 0..6 {
            let own = if i < 3 { kept.mul_add(deviator[i], pressed) } else { kept * deviator[i] };
            // A point at rest has the same bits as where all of its register are.
            nominal[i] = R::select(active, own, stress[i]);
        }
        PointResponse { stress: nominal, integrity }
    }

    #[inline(always)]
    fn state(&self, strain: &Tensor<R>, history: &[R; 8], width: R) -> State<R> {
        let one = R::splat(1.0);
        let [crack, crush] = self.integrity(history[CRACKED], history[CRUSHED], width);
        let stress = self.stress(strain, &mut { *history }, width).stress;
        State {
            tension: one - crack,
            compression: one - crush,
            weakened: R::splat(0.0),
            opening: width.min(self.widest[0]) * (one - crack).mul_add(self.crack.elastic_strain, history[CRACKED]),
            stored: energy(&stress, &elastic_part(strain, history)),
        }
    }

    fn widest_mm(&self) -> [f64; 2] {
        self.widest_mm
    }
}
