//! Mortar between stiff grains: cracks by principal stress, and crushing that takes cohesion and leaves friction.
//!
//! The law is plasticity on two surfaces, in effective stress s: stress is g s, with the stiffness g that crushing and ended
//! cracks leave.
//! p is the mean of s, q its Mises stress, s1 >= s2 >= s3 are its principal values, P = g <-s1> is the least confinement,
//! h the width of the band, L = max(h, crushing length).
//!
//! ```text
//! g         max(y, 0.1) e,  e = 1 - 5 <h kt f_t / G_f - 5>, at least 0.001
//! cracks    R_i = g s_i - f_t y_t(kt) y(kc) <= 0,  flow along the axis of s_i,  d kt = the largest of the three flows
//! crushing  F = g (s1 - s3 + 3 alpha p + gamma s1 / (1 + B P / f_c)) / (1 - alpha) - e rise(kc) y(kc) <= 0
//!           alpha = (fb - 1) / (2 fb - 1),  gamma = 3 (1 - Kc) / (2 Kc - 1)
//!           N = 1.5 dev s / q + tan(psi) / 3,  tan psi = y tan(psi_0) / ((1 + B P / f_c) (1 + A P / f_c))
//!           d kc = <-N_3> / (1 + A P / f_c) per step of flow
//! y_t       crack law of fib Model Code 2010, 5.1.8.2, on the width h
//! y         exp(-<kc - peak> L f_c / G_c)
//! ```
//!
//! 1. A crack opens without lateral strain, carries no tension whatever the compression along it is, and leaves the
//!    strength along it.
//! 2. `rise` is the rising branch of the decks. Beyond the peak the surface shrinks towards its cone: cohesion and tensile
//!    strength go, friction stays. The share y of cohesion that is left scales the dilation, too.
//! 3. Crushing costs 1 + A P / f_c times as much strain under confinement.
//! 4. Its energy counts on the band L, which small elements share: their curve is one of strain.
//! 5. gamma falls to half at P = f_c / B, as the compressive meridian of tests bends.
//! 6. With fb = 1, alpha is 0 and F is Coulomb's friction: one gamma for both signs of s1, which the cracks cut off at f_t.
//!    Concrete loses more strength to lateral tension and gains more from a second pressure, both through its grains.
//!    The grains are in the mesh, so mortar with features of concrete would have them twice.
//!
//! 7. A crack that is wider than its law's last opening, 5 G_f / f_t, takes the stiffness with it. Its tension is spent by
//!    then. Tetrahedra across a crack deform in other ways than it opens, and locked there: bars dissipated 1.4 to 1.9 G_f.
//!
//! The cracks' return is closed: all principal stresses fall by m, those above t = f_t y_t y / g further to it, with
//!
//! ```text
//! m = b sum <s_i - t - m>,  b = nu / (1 - 2 nu),  so  m = max over n = 0..3 of b (s_1 + .. + s_n - n t) / (1 + n b)
//! ```
//!
//! A step has three parts:
//!
//! 1. The trial stress returns to the cracks.
//! 2. The cone's flow begins there.
//! 3. The trial stress less this flow returns to the cracks. The flow lowers s1, so this return is the shorter one.
//!
//! Closed loops never give energy back, in steps of any size: g only falls, and each flow works against the stress at the
//! end of its step, cracks against t, and the cone's since dilation fades faster than friction. With the return of part 1,
//! whose openings the dilation of part 2 closes again, cracks would work against a pressure that they make themselves.

use super::curves::{Crack, Rise};
use super::elastic::{elastic_part, energy};
use super::invariants::{Invariants, moved};
use super::{Hooke, Law, LawName, PointResponse, State, Tensor, cdp, softening};
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
    /// b / (1 + n b) for n = 1, 2, 3.
    shares: [R; 3],
    /// tan(psi_0).
    dilation: R,
    three_alpha: R,
    one_less_alpha: R,
    gamma: R,
    /// B / f_c, per MPa.
    bend: R,
    /// f_t, MPa.
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

/// What a law whose strengths grow with the rate of strain changes.
#[derive(Clone, Copy)]
pub(super) struct Rates<R> {
    /// Over the tensile strength at rest.
    pub(super) tensile: R,
    /// Over the width of a band of cracking, and of crushing.
    pub(super) crack: R,
    pub(super) crush: R,
    /// Unit of stress and strain, and what is in one of them.
    pub(super) unit: R,
    pub(super) per: R,
}

impl<R: Real> Rates<R> {
    /// At rest.
    fn none() -> Self {
        let one = R::splat(1.0);
        Self { tensile: one, crack: one, crush: one, unit: one, per: one }
    }

    /// A tensor times one of the units.
    #[inline(always)]
    fn scaled<const RATED: bool>(mut tensor: Tensor<R>, unit: R) -> Tensor<R> {
        if RATED {
            for component in &mut tensor {
                *component = *component * unit;
            }
        }
        tensor
    }

    /// A band's width in cracking.
    #[inline(always)]
    fn cracking<const RATED: bool>(&self, width: R) -> R {
        if RATED { width * self.crack } else { width }
    }

    /// A tensile strength or strain.
    #[inline(always)]
    fn tension<const RATED: bool>(&self, tensile: R) -> R {
        if RATED { tensile * self.tensile } else { tensile }
    }
}

/// Least share of the cohesion.
const LEAST_COHESION: f64 = 1e-3;
/// Least share of the stiffness: crushed mortar is loose.
const LEAST_STIFFNESS: f64 = 0.1;
/// Most that s1 - s3 is over the Mises stress: 2 / sqrt(3).
const WIDEST_SECTION: f64 = 1.154_700_538_379_251_6;

/// Finds out whether the law can have these values.
///
/// # Errors
/// Names the first one that it cannot have.
pub fn validate(materials: &Materials) -> Result<(), OutOfRange> {
    materials.validate_elastic()?;
    materials.validate_strength(LawName::Meso)?;
    materials.validate_peak_strains(LawName::Meso)?;
    materials.validate_mesoscale()
}

impl<R: Real> Meso<R> {
    /// The law of a phase with these values, which [`validate`] has seen.
    pub fn new(elastic: &materials::Elastic, strength: &Strength, own: &Mesoscale) -> Self {
        let (e, nu) = (elastic.youngs_modulus_mpa, elastic.poisson_ratio);
        let (bulk, shear) = (e / (3.0 * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)));
        let (fc, ft, kc) = (strength.compressive_mpa, strength.tensile_mpa, own.meridian_ratio);
        let (alpha, b) = (cdp::alpha(own.biaxial_ratio), nu / (1.0 - 2.0 * nu));
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
            shares: [1.0, 2.0, 3.0].map(|n| splat(b / (1.0 + n * b))),
            dilation: splat(libm::tan(own.dilation_angle_deg.to_radians())),
            three_alpha: splat(3.0 * alpha),
            one_less_alpha: splat(1.0 - alpha),
            gamma: splat(3.0 * (1.0 - kc) / (2.0 * kc - 1.0)),
            bend: splat(own.meridian_bend / fc),
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

/// A stress by its principal values; its axes are those of the trial stress.
#[derive(Clone, Copy)]
struct Stress<R> {
    mean: R,
    mises: R,
    /// Principal deviators in falling order, MPa.
    principal: [R; 3],
}

/// A stress after its return to the cracks: to the last bit the one before, where none opens.
struct Opened<R> {
    /// What the mean stress lost, MPa.
    lost: R,
    mises: R,
    /// Principal deviators, MPa: 0 and no rounding where all cracks open.
    principal: [R; 3],
    /// The largest of the openings' strains.
    strain: R,
}

/// Start and direction of the cone's flow.
#[derive(Clone, Copy)]
struct ConeFlow<R> {
    /// (1 - alpha) F without the strength, and how fast it falls.
    pressed: R,
    fall: R,
    /// How fast the mean stress falls, and the share of the Mises stress.
    mean_fall: R,
    share_fall: R,
    /// Crushing strain at the start, and per step of flow.
    crushed: R,
    harden: R,
    /// Share of the effective strength at the start, and its softening per crushing strain.
    left: R,
    per_scale: R,
}

impl<R: Real> Meso<R> {
    /// Softening of crushing on this width, per strain.
    #[inline(always)]
    fn per_scale<const RATED: bool>(&self, width: R, rates: &Rates<R>) -> R {
        let width = width.max(self.length);
        let width = if RATED { width * rates.crush } else { width };
        width.min(self.widest[1]) * self.per_crushing_opening
    }

    /// Share of the cohesion that is left.
    #[inline(always)]
    fn cohesion(&self, crushed: R, per_scale: R) -> R {
        let share = (-((crushed - self.rise.peak) * per_scale)).exp();
        share.max(R::splat(LEAST_COHESION)).min(R::splat(1.0))
    }

    /// Share of the cohesion that a step leaves: the first terms of exp(-x), which is less.
    #[inline(always)]
    fn softened(x: R) -> R {
        let one = R::splat(1.0);
        let x = x.min(one);
        R::splat(0.5).mul_add(x, -one).mul_add(x, one)
    }

    /// Share of the stiffness that is left beside this share of the cohesion.
    #[inline(always)]
    fn stiffness(left: R) -> R {
        left.max(R::splat(LEAST_STIFFNESS))
    }

    /// Share of the stiffness that cracks leave.
    #[inline(always)]
    fn standing(&self, cracked: R, width: R) -> R {
        self.crack.standing(cracked, width.min(self.widest[0]))
    }

    /// Share of tension that cracks leave.
    #[inline(always)]
    fn bridged<const RATED: bool>(&self, cracked: R, width: R, rates: &Rates<R>) -> R {
        let elastic_strain = rates.tension::<RATED>(self.crack.elastic_strain);
        self.crack.with(elastic_strain).integrity(cracked, width.min(self.widest[0]))
    }

    /// Where a point can yield or has softened: F without the share of a pressed s1, and with s1 at most p + 2 q / 3.
    #[inline(always)]
    fn active(&self, of: &Invariants<R>, tensile: R, [cracked, crushed]: [R; 2]) -> R::Mask {
        let zero = R::splat(0.0);
        let risen = self.rise.at(crushed).0;
        let largest = R::splat(2.0 / 3.0).mul_add(of.mises, of.mean);
        let pressed = self.three_alpha.mul_add(of.mean, R::splat(WIDEST_SECTION) * of.mises);
        let bound = self.gamma.mul_add(largest.positive(), pressed) - self.one_less_alpha * risen;
        zero.lt(bound) | tensile.lt(largest) | zero.lt(cracked) | self.rise.peak.lt(crushed)
    }

    /// Return to the cracks.
    #[inline(always)]
    fn open(&self, trial: &Stress<R>, strength: R) -> Opened<R> {
        let (zero, third) = (R::splat(0.0), R::splat(1.0 / 3.0));
        let above = trial.mean - strength;
        let [first, second, last] = trial.principal.map(|d| d + above);
        let opens = zero.lt(first);
        // Seldom anywhere.
        if !R::any(opens) {
            return Opened { lost: zero, mises: trial.mises, principal: trial.principal, strain: zero };
        }
        let (two, three) = (first + second, first + second + last);
        let [a, b, c] = self.shares;
        let m = (a * first).max(b * two).max(c * three).positive();
        // Loops, since closures would be compiled without the instruction set.
        let (mut after, mut principal) = ([first, second, last], trial.principal);
        for s in &mut after {
            *s = (*s - m).min(zero);
        }
        let mean = (after[0] + after[1] + after[2]) * third;
        for s in &mut after {
            *s = *s - mean;
        }
        let [x, y, z] = after;
        let mises = (R::splat(1.5) * x.mul_add(x, y.mul_add(y, z * z))).sqrt();
        for (own, after) in principal.iter_mut().zip(after) {
            *own = R::select(opens, after, *own);
        }
        Opened {
            lost: R::select(opens, above - mean, zero),
            mises: R::select(opens, mises, trial.mises),
            principal,
            strain: (first.max(m) - m) * self.per_shear,
        }
    }

    /// (1 - alpha) F and how fast it falls along the flow, from the stress without the strength, the crushing strain, and the
    /// share of the effective strength that the flow leaves.
    #[inline(always)]
    fn excess(&self, of: &ConeFlow<R>, pressed: R, crushed: R, share: R) -> (R, R) {
        let (risen, rising) = self.rise.at(crushed);
        let softens = self.rise.peak.lt(crushed);
        let strength = risen * of.left * share;
        let slope = R::select(softens, -(strength * of.per_scale), rising);
        ((-self.one_less_alpha).mul_add(strength, pressed), (self.one_less_alpha * slope).mul_add(of.harden, of.fall))
    }

    /// Start and direction of the cone's flow from `stress`.
    #[inline(always)]
    fn flow(&self, stress: &Stress<R>, crushed: R, [left, standing]: [R; 2], per_scale: R) -> ConeFlow<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let largest = stress.mean + stress.principal[0];
        let stiffness = Self::stiffness(left);
        let confined = stiffness * standing * (-largest).positive();
        let bent = self.bend.mul_add(confined, one);
        let costly = self.ductility.mul_add(confined, one);
        let size = stress.mises.max(R::splat(1e-8));
        // All quotients by one division.
        let over = one / (bent * costly * size);
        let (per_mises, per_both) = (bent * costly * over, size * over);
        let tan = self.dilation * left * per_both;
        let (mean_fall, share_fall) = (self.bulk * tan, self.three_shear * per_mises);
        let least = tan.mul_add(R::splat(1.0 / 3.0), R::splat(1.5) * per_mises * stress.principal[2]);
        // The flow lowers s1, so that gamma is that of the start all the way.
        let gamma = self.gamma * (costly * per_both);
        let pressed =
            |mean: R, first: R, last: R| self.three_alpha.mul_add(mean, gamma.mul_add(mean + first, first - last));
        ConeFlow {
            pressed: pressed(stress.mean, stress.principal[0], stress.principal[2]),
            fall: pressed(mean_fall, share_fall * stress.principal[0], share_fall * stress.principal[2]),
            mean_fall,
            share_fall,
            crushed,
            harden: (-least).positive() * (bent * per_both),
            left: left / stiffness,
            per_scale: R::select(left.lt(R::splat(LEAST_STIFFNESS)), per_scale, zero),
        }
    }

    /// Length of the cone's flow, by two of Newton's steps.
    #[inline(always)]
    fn back(&self, of: &ConeFlow<R>) -> R {
        let one = R::splat(1.0);
        let (excess, fall) = self.excess(of, of.pressed, of.crushed, one);
        let flow = (excess / fall).positive();
        let hardened = of.harden * flow;
        let crushed = of.crushed + hardened;
        let share = R::select(self.rise.peak.lt(crushed), Self::softened(hardened * of.per_scale), one);
        let (excess, fall) = self.excess(of, (-of.fall).mul_add(flow, of.pressed), crushed, share);
        (flow + excess / fall).positive()
    }
}

/// Where the two hardening strains stand in a history, after the plastic strain.
pub(super) const CRACKED: usize = 6;
pub(super) const CRUSHED: usize = 7;

impl<R: Real> Meso<R> {
    /// Whether cracks or crushing have begun in a history that begins as this law's.
    #[inline(always)]
    pub(super) fn yielded(history: &[R]) -> R::Mask {
        let zero = R::splat(0.0);
        zero.lt(history[CRACKED]) | zero.lt(history[CRUSHED])
    }

    /// Whether a sound point can yield at this stress.
    #[inline(always)]
    pub(super) fn yields(&self, stress: &Invariants<R>) -> R::Mask {
        self.active(stress, self.tensile, [R::splat(0.0); 2])
    }

    /// See [`Law::stress`].
    #[inline(always)]
    pub(super) fn answer<const RATED: bool, const N: usize>(
        &self,
        strain: &Tensor<R>,
        history: &mut [R; N],
        width: R,
        rates: &Rates<R>,
    ) -> PointResponse<R> {
        let one = R::splat(1.0);
        let stress = self.elastic.of(&Rates::scaled::<RATED>(elastic_part(strain, history), rates.per));
        let invariants = Invariants::of(&stress);
        let tensile = rates.tension::<RATED>(self.tensile);
        let active = self.active(&invariants, tensile, [history[CRACKED], history[CRUSHED]]);
        if !R::any(active) {
            return PointResponse { stress: Rates::scaled::<RATED>(stress, rates.unit), integrity: one };
        }
        let Invariants { mean, deviator, mises } = invariants;
        let scale = R::splat(2.0 / 3.0) * mises;
        let trial = Stress { mean, mises, principal: invariants.shape().map(|y| scale * y) };
        let (per_scale, cracking) = (self.per_scale::<RATED>(width, rates), rates.cracking::<RATED>(width));
        let left = self.cohesion(history[CRUSHED], per_scale);
        let standing = self.standing(history[CRACKED], cracking);
        let bridged = self.bridged::<RATED>(history[CRACKED], cracking, rates);
        let strength = tensile * (left / (Self::stiffness(left) * standing)) * bridged;
        let cracked = self.open(&trial, strength);
        let cracked = Stress { mean: mean - cracked.lost, mises: cracked.mises, principal: cracked.principal };
        let flow = self.flow(&cracked, history[CRUSHED], [left, standing], per_scale);
        let length = self.back(&flow);
        let (share, fallen) = ((length * flow.share_fall).min(one), flow.mean_fall * length);
        let mut principal = trial.principal;
        for (own, cracked) in principal.iter_mut().zip(cracked.principal) {
            *own = (-share).mul_add(cracked, *own);
        }
        let end = self.open(&Stress { mean: mean - fallen, mises, principal }, strength);
        let ended = moved(&deviator, &trial.principal, &end.principal);

        // A point at rest has the same bits as where all of its register are: all that it loses is 0, and its integrity 1.
        history[CRACKED] = history[CRACKED] + end.strain;
        let before = (history[CRUSHED] - self.rise.peak).positive();
        history[CRUSHED] = history[CRUSHED] + flow.harden * length;
        let beyond = (history[CRUSHED] - self.rise.peak).positive();
        let left = left * Self::softened((beyond - before) * per_scale);
        let integrity = Self::stiffness(left) * self.standing(history[CRACKED], cracking);

        let fallen = fallen + end.lost;
        let volumetric = fallen * self.per_volume;
        let kept = if RATED { integrity * rates.unit } else { integrity };
        let mut nominal = stress;
        for i in 0..6 {
            let lost = deviator[i] - ended[i];
            let (whole, sheared) = (stress[i] - lost, lost * self.per_shear);
            let (flowed, whole) =
                if i < 3 { (sheared + volumetric, whole - fallen) } else { (sheared + sheared, whole) };
            nominal[i] = kept * whole;
            history[i] = if RATED { flowed.mul_add(rates.unit, history[i]) } else { history[i] + flowed };
        }
        PointResponse { stress: nominal, integrity }
    }

    /// See [`Law::state`].
    #[inline(always)]
    pub(super) fn shown<const RATED: bool, const N: usize>(
        &self,
        strain: &Tensor<R>,
        history: &[R; N],
        width: R,
        rates: &Rates<R>,
    ) -> State<R> {
        let one = R::splat(1.0);
        let bridged = self.bridged::<RATED>(history[CRACKED], rates.cracking::<RATED>(width), rates);
        let left = self.cohesion(history[CRUSHED], self.per_scale::<RATED>(width, rates));
        let elastic_strain = rates.tension::<RATED>(self.crack.elastic_strain);
        let stress = self.answer::<RATED, N>(strain, &mut { *history }, width, rates).stress;
        let opening = width.min(self.widest[0]) * (one - bridged).mul_add(elastic_strain, history[CRACKED]);
        State {
            tension: one - bridged,
            compression: one - left,
            weakened: (-bridged).mul_add(left, one),
            opening: if RATED { opening * rates.unit } else { opening },
            stored: energy(&stress, &elastic_part(strain, history)),
        }
    }
}

impl<R: Real> Law<R> for Meso<R> {
    /// Plastic strain, then the strains of cracking and of crushing.
    type History = [R; 8];

    fn virgin() -> [R; 8] {
        [R::splat(0.0); 8]
    }

    #[inline(always)]
    fn stress(&self, strain: &Tensor<R>, history: &mut [R; 8], width: R) -> PointResponse<R> {
        self.answer::<false, 8>(strain, history, width, &Rates::none())
    }

    #[inline(always)]
    fn state(&self, strain: &Tensor<R>, history: &[R; 8], width: R) -> State<R> {
        self.shown::<false, 8>(strain, history, width, &Rates::none())
    }

    fn widest_mm(&self) -> [f64; 2] {
        self.widest_mm
    }
}
