//! Mortar between stiff grains: cracks that open, and crushing that takes cohesion and leaves friction.
//!
//! The law is plasticity in effective stress s, the stress of the material between cracks, and damage of its tensile part
//! alone. p is the mean stress, q the Mises stress, s1 the largest and s3 the smallest principal stress, P = <-s1> the
//! least confinement, h the width of the band, L = max(h, crushing length).
//!
//! ```text
//! F  = (q + 3 alpha p + beta <s1> - gamma P / (1 + P / f_c)) / (1 - alpha) - c(kc) <= 0
//!      alpha = (fb - 1) / (2 fb - 1),  gamma = 3 (1 - Kc) / (2 Kc - 1),  beta = (1 - alpha) rise / f_t - (1 + alpha)
//! c  = rise(kc) y(kc),   y = exp(-<kc - peak> L f_c / G_c),   t = f_t y
//! N  = 1.5 dev s / sqrt(q^2 + a^2) + tan(psi) / 3,   r = min(<s1> / t, 1)
//! tan psi = (1 - r) y tan(psi_0) / ((1 + P / f_c) (1 + A P / f_c)) + 1.5 r
//! d kt = r <d ep_1>,   d kc = (1 - r) <-d ep_3> / (1 + A P / f_c)
//! ```
//!
//! 1. `rise` is the rising branch of the decks. Beyond the peak the surface shrinks towards its cone: cohesion and tensile
//!    strength go, friction stays. The share y of cohesion that is left also scales the dilation.
//! 2. Crushing costs 1 + A P / f_c times as much strain under confinement.
//! 3. Its energy counts on the band L, which small elements share: their curve is one of strain.
//! 4. gamma falls to half at P = f_c, as the compressive meridian of tests bends.
//! 5. In tension the flow opens a crack without lateral strain: N = (1.5, 0, 0).
//!
//! Damage d follows the crack law over kt on the width h. Stress comes from the complementary energy of Ladeveze and
//! Lemaitre (1984), in which only tensile principal stresses are softer, with 1 / (1 - d):
//!
//! ```text
//! psi = ((1 + nu) (|sigma+|^2 / (1 - d) + |sigma-|^2) - nu (tr sigma)^2) / 2 E
//! sigma_i = (s_i - m) - d <s_i - m>,   m = b sum <s_i - m>,   b = d nu / (1 - 2 nu)
//! m = max over n = 0..3 of b (s_1 + .. + s_n) / (1 + n b)
//! ```
//!
//! So cracks open and close on a path that costs nothing, an open crack carries no tension whatever the compression
//! along it is, and stress is continuous where signs change. Uniaxial tension leaves the share y_t of stress for
//! 1 - d = y_t (1 - nu) / (1 - 2 nu + nu y_t).

use super::curves::{Crack, Rise};
use super::elastic::{elastic_part, energy, flow};
use super::invariants::{Invariants, split};
use super::{Hooke, Law, PointResponse, State, Tensor, cdp, softening};
use crate::real::Real;
use meso_concrete::OutOfRange;
use meso_mesh::materials::{self, Materials, Mesoscale, Strength};

/// Parameters, as registers.
#[derive(Clone, Copy, Debug)]
pub struct Meso<R> {
    elastic: Hooke<R>,
    /// 1 / (3 K), 1 / (2 G), both per MPa.
    per_volume: R,
    per_shear: R,
    /// K and 3 G, MPa.
    bulk: R,
    three_shear: R,
    /// nu / (1 - 2 nu), nu and 1 - 2 nu.
    lateral: R,
    poisson: R,
    rest: R,
    /// tan(psi_0).
    dilation: R,
    /// Rounding of the potential, MPa.
    rounding: R,
    three_alpha: R,
    one_less_alpha: R,
    one_more_alpha: R,
    gamma: R,
    /// (1 - alpha) / f_t
    beta_slope: R,
    /// 1 / f_c, and f_t, MPa.
    per_strength: R,
    tensile: R,
    rise: Rise<R>,
    crack: Crack<R>,
    /// A / f_c, per MPa.
    ductility: R,
    /// f_c / G_c, per mm, and the least band, mm.
    per_crushing_opening: R,
    length: R,
    /// Widest bands of cracking and of crushing, mm.
    widest: [R; 2],
    widest_mm: [f64; 2],
}

/// Newton's steps of the return.
const STEPS: usize = 2;
/// tan(psi) of a crack: its flow has no lateral strain.
const CRACK_DILATION: f64 = 1.5;
/// Rounding of the potential's tip over f_t.
const TIP: f64 = 0.05;
/// Least share of the cohesion, for which quotients by the tensile strength stay finite.
const LEAST_COHESION: f64 = 1e-3;

/// Finds out whether the law can have these values.
///
/// # Errors
/// Names the first one that it cannot have.
pub fn validate(materials: &Materials) -> Result<(), OutOfRange> {
    cdp::validate(materials)?;
    materials.validate_mesoscale()
}

impl<R: Real> Meso<R> {
    /// The law of a phase with these values, which [`validate`] has seen.
    pub fn new(elastic: &materials::Elastic, strength: &Strength, biaxial_ratio: f64, own: &Mesoscale) -> Self {
        let (e, nu) = (elastic.youngs_modulus_mpa, elastic.poisson_ratio);
        let (bulk, shear) = (e / (3.0 * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)));
        let (fc, ft, kc) = (strength.compressive_mpa, strength.tensile_mpa, own.meridian_ratio);
        let alpha = cdp::alpha(biaxial_ratio);
        let opening = strength.crushing_energy_n_per_mm / fc;
        let snapping = [Crack::<R>::snapping_mm(strength, e), opening / (fc / e)];
        let widest_mm = snapping.map(|width| softening::SNAP_BACK * width);
        let splat = R::splat;
        Self {
            elastic: Hooke::new(elastic),
            per_volume: splat(1.0 / (3.0 * bulk)),
            per_shear: splat(1.0 / (2.0 * shear)),
            bulk: splat(bulk),
            three_shear: splat(3.0 * shear),
            lateral: splat(nu / (1.0 - 2.0 * nu)),
            poisson: splat(nu),
            rest: splat(1.0 - 2.0 * nu),
            dilation: splat(libm::tan(own.dilation_angle_deg.to_radians())),
            rounding: splat(TIP * ft),
            three_alpha: splat(3.0 * alpha),
            one_less_alpha: splat(1.0 - alpha),
            one_more_alpha: splat(1.0 + alpha),
            gamma: splat(3.0 * (1.0 - kc) / (2.0 * kc - 1.0)),
            beta_slope: splat((1.0 - alpha) / ft),
            per_strength: splat(1.0 / fc),
            tensile: splat(ft),
            rise: Rise::new(strength, e),
            crack: Crack::new(strength, e),
            ductility: splat(own.confined_ductility / fc),
            per_crushing_opening: splat(1.0 / opening),
            length: splat(own.crushing_length_mm),
            widest: widest_mm.map(splat),
            widest_mm,
        }
    }
}

/// A direction of flow.
#[derive(Clone, Copy)]
struct Along<R> {
    /// Crushing strain per step of flow.
    harden: R,
    /// How fast Mises, mean and largest principal stress fall.
    mises_fall: R,
    mean_fall: R,
    largest_fall: R,
    /// How fast the share of the Mises stress that is left falls.
    share_fall: R,
}

/// The state that a step begins with, and its trial stress.
#[derive(Clone, Copy)]
struct Start<R> {
    invariants: Invariants<R>,
    /// Largest and smallest principal deviators over 2 q / 3.
    ends: [R; 2],
    largest: R,
    crushed: R,
    /// Softening of crushing, per strain, and the share of cohesion that is left.
    per_scale: R,
    left: R,
    /// gamma at the trial's confinement.
    gamma: R,
    /// Crushing strain over flow, and dilation, both over those without confinement.
    cheap: R,
    dilating: R,
}

impl<R: Real> Meso<R> {
    /// Softening of crushing on this width, per strain.
    #[inline(always)]
    fn per_scale(&self, width: R) -> R {
        width.max(self.length).min(self.widest[1]) * self.per_crushing_opening
    }

    /// Share of the cohesion that is left.
    #[inline(always)]
    fn cohesion(&self, crushed: R, per_scale: R) -> R {
        let share = (-((crushed - self.rise.peak) * per_scale)).exp().min(R::splat(1.0));
        share.max(R::splat(LEAST_COHESION))
    }

    /// Share of cracking in the flow at this largest principal stress, with the share `left` of the cohesion.
    #[inline(always)]
    fn cracking(&self, largest: R, left: R) -> R {
        (largest / (self.tensile * left)).between(0.0, 1.0)
    }

    /// Weight of a tensile largest stress.
    #[inline(always)]
    fn beta(&self, risen: R) -> R {
        self.beta_slope.mul_add(risen, -self.one_more_alpha).positive()
    }

    /// (1 - alpha) F and how fast it falls along the flow, at `flow`.
    #[inline(always)]
    fn excess(&self, start: &Start<R>, along: &Along<R>, flow: R) -> (R, R) {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let hardened = along.harden * flow;
        let crushed = start.crushed + hardened;
        let (risen, rising) = self.rise.at(crushed);
        // Steps are small: the exponential's first terms.
        let x = (hardened * start.per_scale).min(one);
        let softens = self.rise.peak.lt(crushed);
        let share = R::select(softens, R::splat(0.5).mul_add(x, -one).mul_add(x, one), one);
        let strength = risen * start.left * share;
        let slope = R::select(softens, -(strength * start.per_scale), rising);
        let mises = (-along.mises_fall).mul_add(flow, start.invariants.mises);
        let mean = (-along.mean_fall).mul_add(flow, start.invariants.mean);
        let largest = (-along.largest_fall).mul_add(flow, start.largest);
        let tensile = zero.lt(largest);
        let weight = R::select(tensile, self.beta(risen), start.gamma);
        let pressed = self.three_alpha.mul_add(mean, mises);
        let excess = weight.mul_add(largest, pressed) - self.one_less_alpha * strength;
        let lift = R::select(tensile, self.beta_slope * largest * rising, zero) - self.one_less_alpha * slope;
        let fall = self.three_alpha.mul_add(along.mean_fall, along.mises_fall);
        (excess, weight.mul_add(along.largest_fall, fall) - lift * along.harden)
    }

    /// Where a point can yield or is damaged: an upper bound of F, without gamma and with s1 at most p + 2 q / 3.
    #[inline(always)]
    fn active(&self, of: &Invariants<R>, cracked: R, crushed: R) -> R::Mask {
        let zero = R::splat(0.0);
        let risen = self.rise.at(crushed).0;
        let largest = R::splat(2.0 / 3.0).mul_add(of.mises, of.mean).positive();
        let pressed = self.three_alpha.mul_add(of.mean, of.mises);
        let bound = self.beta(risen).mul_add(largest, pressed) - self.one_less_alpha * risen;
        zero.lt(bound) | zero.lt(cracked) | self.rise.peak.lt(crushed)
    }

    /// The start of a step.
    #[inline(always)]
    fn start(&self, invariants: Invariants<R>, shape: &[R; 3], crushed: R, per_scale: R) -> Start<R> {
        let one = R::splat(1.0);
        let largest = (R::splat(2.0 / 3.0) * invariants.mises).mul_add(shape[0], invariants.mean);
        let confined = (-largest).positive();
        let bent = self.per_strength.mul_add(confined, one);
        let costly = self.ductility.mul_add(confined, one);
        // All quotients by one division.
        let over = one / (bent * costly);
        let left = self.cohesion(crushed, per_scale);
        Start {
            ends: [shape[0], shape[2]],
            largest,
            crushed,
            per_scale,
            left,
            gamma: self.gamma * costly * over,
            cheap: bent * over,
            dilating: self.dilation * left * over,
            invariants,
        }
    }

    /// The flow in the trial stress's directions with the share r of `cracking`.
    #[inline(always)]
    fn along(&self, start: &Start<R>, cracking: R) -> Along<R> {
        let (one, q, two_thirds) = (R::splat(1.0), start.invariants.mises, R::splat(2.0 / 3.0));
        let crushing = one - cracking;
        let tan = crushing.mul_add(start.dilating, R::splat(CRACK_DILATION) * cracking);
        // dG/dq = q / sqrt(q^2 + a^2)
        let tip = self.rounding * start.left;
        let per_potential = one / q.mul_add(q, tip * tip).sqrt();
        let along = q * per_potential;
        let least = along.mul_add(start.ends[1], tan * R::splat(1.0 / 3.0));
        let (mises_fall, mean_fall) = (self.three_shear * along, self.bulk * tan);
        Along {
            harden: crushing * (-least).positive() * start.cheap,
            mises_fall,
            mean_fall,
            largest_fall: two_thirds.mul_add(mises_fall * start.ends[0], mean_fall),
            share_fall: self.three_shear * per_potential,
        }
    }

    /// One of Newton's steps from `flow`.
    #[inline(always)]
    fn newton(&self, start: &Start<R>, along: &Along<R>, flow: R) -> R {
        let (excess, fall) = self.excess(start, along, flow);
        (flow + excess / fall).positive()
    }

    /// Mean stress at the surface's tip, on the side of tension.
    #[inline(always)]
    fn tip(&self, start: &Start<R>) -> R {
        let risen = self.rise.at(start.crushed).0;
        self.one_less_alpha * risen * start.left / (self.three_alpha + self.beta(risen))
    }

    /// Return to the surface: the crushing strain it adds, the share of the Mises stress that it leaves, and the mean stress
    /// after it. A first flow says how much of it is cracking: were that the trial's share, a flow that ends in
    /// compression could open cracks against it and give energy.
    #[inline(always)]
    fn back(&self, start: &Start<R>, active: R::Mask) -> (R, R, R) {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let first = self.along(start, self.cracking(start.largest, start.left));
        let flow = self.newton(start, &first, zero);
        let largest = (-first.largest_fall).mul_add(flow, start.largest);
        let along = self.along(start, self.cracking(largest, start.left));
        let mut flow = zero;
        for _ in 0..STEPS {
            flow = self.newton(start, &along, flow);
        }
        let flow = R::select(active, flow, zero);
        let mean = start.invariants.mean;
        let left = (-along.share_fall).mul_add(flow, one);
        let returned = (-along.mean_fall).mul_add(flow, mean);
        let beyond = left.lt(zero);
        let crushed = along.harden * flow;
        // Seldom anywhere.
        if !R::any(beyond) {
            return (crushed, left, returned);
        }
        let tip = self.tip(start).min(mean);
        (crushed, R::select(beyond, zero, left), R::select(beyond, tip, returned))
    }

    /// Share of uniaxial tension that a crack leaves, and the damage 1 - d of tensile stress.
    #[inline(always)]
    fn cracked(&self, cracked: R, width: R) -> (R, R) {
        let share = self.crack.integrity(cracked, width.min(self.widest[0]));
        let sound = R::splat(1.0) - self.poisson;
        (share, share * sound / self.poisson.mul_add(share, self.rest))
    }

    /// The m by which cracks shift principal stresses, of effective ones in falling order and the damage d.
    #[inline(always)]
    fn shift(&self, principal: &[R; 3], damage: R) -> R {
        let one = R::splat(1.0);
        let b = damage * self.lateral;
        let [first, second, third] = *principal;
        let (two, three) = (first + second, first + second + third);
        let [under_two, under_three] = [2.0, 3.0].map(|n| R::splat(n).mul_add(b, one));
        let under_one = one + b;
        // Three quotients by one division.
        let over = b / (under_one * under_two * under_three);
        let most = (first * under_two * under_three).max(two * under_one * under_three);
        most.max(three * under_one * under_two).positive() * over
    }
}

/// Where the two hardening strains stand in a history, after the plastic strain.
const CRACKED: usize = 6;
const CRUSHED: usize = 7;

impl<R: Real> Law<R> for Meso<R> {
    /// Plastic strain, then the strains of cracking and of crushing.
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
        let per_scale = self.per_scale(width);
        let start = self.start(invariants, &shape, history[CRUSHED], per_scale);
        let (crushed, left, new_mean) = self.back(&start, active);

        let volumetric = (mean - new_mean) * self.per_volume;
        let lost = (one - left) * self.per_shear;
        flow(history, &deviator, lost, volumetric);
        let two_thirds = R::splat(2.0 / 3.0);
        let largest = (two_thirds * mises * lost).mul_add(shape[0], volumetric).positive();
        let returned = (two_thirds * left * mises).mul_add(shape[0], new_mean);
        let cracking = self.cracking(returned, start.left);
        history[CRACKED] = cracking.mul_add(largest, history[CRACKED]);
        history[CRUSHED] = history[CRUSHED] + crushed;

        let (share, kept) = self.cracked(history[CRACKED], width);
        let scale = two_thirds * left * mises;
        let deviators = shape.map(|y| scale * y);
        let m = self.shift(&deviators.map(|d| d + new_mean), one - kept);
        let mut nominal = deviator.map(|d| left * d);
        nominal = split(new_mean - m, &nominal, &deviators, kept, one);
        for i in 0..6 {
            // A point at rest has the same bits as where all of its register are.
            nominal[i] = R::select(active, nominal[i], stress[i]);
        }
        let pulled = pulled(&deviators.map(|d| d + new_mean - m));
        let integrity = R::select(active, (-pulled).mul_add(one - share, one), one);
        PointResponse { stress: nominal, integrity }
    }

    fn state(&self, strain: &Tensor<R>, history: &[R; 8], width: R) -> State<R> {
        let one = R::splat(1.0);
        let (share, _) = self.cracked(history[CRACKED], width);
        let stress = self.stress(strain, &mut { *history }, width).stress;
        State {
            tension: one - share,
            compression: one - self.cohesion(history[CRUSHED], self.per_scale(width)),
            opening: width.min(self.widest[0]) * (one - share).mul_add(self.crack.elastic_strain, history[CRACKED]),
            stored: energy(&stress, &elastic_part(strain, history)),
        }
    }

    fn widest_mm(&self) -> [f64; 2] {
        self.widest_mm
    }
}

/// Share of tension among principal stresses, by squares.
#[inline(always)]
fn pulled<R: Real>(principal: &[R; 3]) -> R {
    let [mut above, mut all] = [R::splat(0.0); 2];
    for &s in principal {
        let positive = s.positive();
        above = positive.mul_add(positive, above);
        all = s.mul_add(s, all);
    }
    above / all.max(R::splat(1e-20))
}
