//! CDPM2: Grassl, Xenos, Nystrom, Rempling and Gylltoft 2013, "CDPM2: A damage-plasticity approach to modelling the failure
//! of concrete", Int. J. Solids Struct. 50:3805, without its rate effect.
//!
//! Plasticity in effective stress, with s = mean stress / f_c, u = rho / (sqrt(6) f_c) (rho = sqrt(2 J2)), the Lode angle
//! theta (y_1 = cos theta), the shape r(theta) of Willam and Warnke (from 1 to 1/e) and hardening q1, q2 of kappa:
//!
//! ```text
//! L = (1 - q1) (s + u)^2 + 3 u
//! f = L^2 + q1^2 q2 m0 (s + u r) - q1^2 q2^2
//! g = L^2 + q1^2 (m0 u + Ag Bg exp((s - q2 f_t / (3 f_c)) / Bg))
//! d kappa = |d ep| (2 cos theta)^2 / x_h(s)
//! ```
//!
//! Two damages of the tensile and compressive parts of effective stress, stress = (1 - wt) s+ + (1 - wc) s-, each over a
//! largest equivalent strain k (elastic below k0 = f_t / E), the plastic strain beyond it, k1, and its own share, k2:
//! (1 - w) E k = f_t softening(k1 + w k2). Steps of k1 and k2 are divided by the ductility x_s = 1 + (A_s - 1) <-s> / u. Tension
//! softens bilinearly to 0.3 f_t at 0.15 w_f and 0 at w_f; compression exponentially, over the strain e_fc.
//!
//! Mapping of `[materials]`: w_f = G_f / (0.225 f_t), the area of the bilinear curve. In uniaxial compression beyond the peak
//! the model gives 1 - wc = exp(-e (f_t / f_c) / (A_s e_fc)) over the inelastic strain e (for small H_p), so the crushing
//! energy G_c on a width h asks for e_fc = G_c f_t / (h f_c^2 A_s). The paper's own e_fc = 1e-4 has no width; it can be given.
//!
//! Differences to the paper: a point's equivalent strain below first yield is counted with the ratios of the step in which
//! it yields (exact on straight paths), so that points at rest cost nothing; the return takes a fixed number of cutting-plane
//! steps with the trial stress's Lode angle, so a large step ends near the surface, and the next step takes up the rest.

use super::elastic::{elastic_part, flow};
use super::invariants::{Invariants, split};
use super::{Hooke, Law, LawName, PointResponse, State, Tensor, softening};
use crate::real::Real;
use meso_concrete::OutOfRange;
use meso_mesh::materials::{self, MATERIALS, Materials, Strength};

/// The paper's parameters that the strengths do not give.
pub use meso_mesh::materials::Cdpm2Parameters as Options;

/// Finds out whether the law can have these values.
///
/// # Errors
/// Names the first one that it cannot have.
pub fn validate(materials: &Materials) -> Result<(), OutOfRange> {
    materials.validate_elastic()?;
    materials.validate_strength(LawName::Cdpm2)?;
    materials.validate_peak_strains(LawName::Cdpm2)?;
    let given = materials.mortar_strength.of(LawName::Cdpm2);
    let biaxial = materials.plasticity.biaxial_ratio;
    let accepted = "it must lie above 1 and at most at 1.5; 1.16 is usual";
    MATERIALS.require("plasticity.biaxial_ratio", biaxial, biaxial > 1.0 && biaxial <= 1.5, accepted)?;
    let most = given.compressive_mpa / 3.0;
    let accepted = format!("it must be at most {most:.4}, a third of the compressive strength");
    MATERIALS.require("mortar_strength.tensile_mpa", given.tensile_mpa, given.tensile_mpa <= most, accepted)?;
    materials.validate_cdpm2()
}

/// Parameters, as registers.
#[derive(Clone, Copy, Debug)]
pub struct Cdpm2<R> {
    elastic: Hooke<R>,
    /// 1 / f_c, 1 / (sqrt(6) f_c) sqrt(2/3) (from Mises), f_c.
    per_strength: R,
    compressive: R,
    /// f_c / (3 K), f_c / (2 G), f_c / E.
    per_volume: R,
    per_shear: R,
    per_young: R,
    /// K / E and G / (3 E): how s and u fall along the flow.
    mean_fall: R,
    shear_fall: R,
    friction: R,
    /// f_t / (3 f_c)
    third_tensile: R,
    /// 3 f_t / f_c
    thrice_tensile: R,
    /// 3 / (1 + f_t / f_c), ln((Df + 1) / (2 Df - 1))
    per_dilation: R,
    dilation: R,
    shape: Shape<R>,
    initial: R,
    modulus: R,
    ductility: Ductility<R>,
    /// A_s - 1
    brittle: R,
    /// f_t / E, and the factor from plastic strain to crushing strain: f_t / (3 f_c sqrt(1 + 2 Df^2)).
    onset: R,
    crushing_share: R,
    /// 1 / w_f
    per_opening: R,
    /// 1 / (e_fc h), or 1 / e_fc where it is given.
    per_crushing: R,
    per_crushing_strain: R,
    /// Widest bands of cracking and of crushing, mm.
    widest: [R; 2],
    widest_mm: [f64; 2],
}

/// r(theta) with c = cos theta: (a c^2 + b^2) / (a c / 2 + b sqrt(a c^2 + d)).
#[derive(Clone, Copy, Debug)]
struct Shape<R> {
    /// 4 (1 - e^2), 2 e - 1, 5 e^2 - 4 e, 1 / e.
    quadratic: R,
    linear: R,
    constant: R,
    widest: R,
}

/// x_h = far + (near - far) exp(R / scale), for R = -s - 1/3 below and above 0.
#[derive(Clone, Copy, Debug)]
struct Ductility<R> {
    /// D_h and E_h, A_h and B_h - A_h.
    pulled: [R; 2],
    pressed: [R; 2],
    /// 1 / F_h, -1 / C_h.
    scales: [R; 2],
}

/// Cutting-plane steps of the return.
const STEPS: usize = 2;
/// The first piece of the crack law ends at these shares of w_f and f_t.
const KINK: [f64; 2] = [0.15, 0.3];
/// Straight pieces of the crack law: the share a - b w of f_t at the opening w, in w_f.
const PIECES: [(f64, f64); 2] =
    [(1.0, (1.0 - KINK[1]) / KINK[0]), (KINK[1] / (1.0 - KINK[0]), KINK[1] / (1.0 - KINK[0]))];
/// Area of the crack law over w_f f_t.
const AREA: f64 = 0.5 * (KINK[0] + KINK[1]);

/// Eccentricity of the surface from the strengths (eq. 20).
fn eccentricity(fc: f64, ft: f64, fb: f64) -> f64 {
    let share = ft * (fb * fb - fc * fc) / (fb * (fc * fc - ft * ft));
    (1.0 + share) / (2.0 - share)
}

impl<R: Real> Cdpm2<R> {
    /// The law of a phase with these values, which [`validate`] has seen.
    pub fn new(elastic: &materials::Elastic, strength: &Strength, biaxial_ratio: f64, options: &Options) -> Self {
        let (e, nu) = (elastic.youngs_modulus_mpa, elastic.poisson_ratio);
        let (bulk, shear) = (e / (3.0 * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)));
        let (fc, ft) = (strength.compressive_mpa, strength.tensile_mpa);
        let ecc = eccentricity(fc, ft, biaxial_ratio * fc);
        let df = options.dilation;
        let opening = strength.fracture_energy_n_per_mm / (AREA * ft);
        let crushing = strength.crushing_energy_n_per_mm * ft / (fc * fc * options.softening_ductility);
        let crushed_mm =
            options.crushing_strain.map_or(crushing * options.softening_ductility * e / ft, |_| f64::INFINITY);
        let cracked_mm = KINK[0] / (1.0 - KINK[1]) * opening * e / ft;
        let widest_mm = [cracked_mm, crushed_mm].map(|width| softening::SNAP_BACK * width);
        let splat = R::splat;
        Self {
            elastic: Hooke::new(elastic),
            per_strength: splat(1.0 / fc),
            compressive: splat(fc),
            per_volume: splat(fc / (3.0 * bulk)),
            per_shear: splat(fc / (2.0 * shear)),
            per_young: splat(fc / e),
            mean_fall: splat(bulk / e),
            shear_fall: splat(shear / (3.0 * e)),
            friction: splat(3.0 * (fc * fc - ft * ft) / (fc * ft) * ecc / (ecc + 1.0)),
            third_tensile: splat(ft / (3.0 * fc)),
            thrice_tensile: splat(3.0 * ft / fc),
            per_dilation: splat(3.0 / (1.0 + ft / fc)),
            dilation: splat(libm::log((df + 1.0) / (2.0 * df - 1.0))),
            shape: Shape::new(ecc),
            initial: splat(options.initial_hardening),
            modulus: splat(options.hardening_modulus),
            ductility: Ductility::new(options.hardening_ductility),
            brittle: splat(options.softening_ductility - 1.0),
            onset: splat(ft / e),
            crushing_share: splat(ft / (3.0 * fc * (1.0 + 2.0 * df * df).sqrt())),
            per_opening: splat(1.0 / opening),
            per_crushing: splat(if options.crushing_strain.is_some() { 0.0 } else { 1.0 / crushing }),
            per_crushing_strain: splat(options.crushing_strain.map_or(0.0, |strain| 1.0 / strain)),
            widest: widest_mm.map(splat),
            widest_mm,
        }
    }
}

impl<R: Real> Shape<R> {
    fn new(e: f64) -> Self {
        Self {
            quadratic: R::splat(4.0 * (1.0 - e * e)),
            linear: R::splat(2.0 * e - 1.0),
            constant: R::splat(5.0 * e * e - 4.0 * e),
            widest: R::splat(1.0 / e),
        }
    }

    #[inline(always)]
    fn at(&self, cosine: R) -> R {
        let square = self.quadratic * cosine * cosine;
        let root = (square + self.constant).positive().sqrt();
        let below = (R::splat(0.5) * self.quadratic).mul_add(cosine, self.linear * root);
        self.linear.mul_add(self.linear, square) / below
    }
}

impl<R: Real> Ductility<R> {
    fn new([ah, bh, ch, dh]: [f64; 4]) -> Self {
        Self {
            pulled: [dh, bh - dh].map(R::splat),
            pressed: [ah, bh - ah].map(R::splat),
            scales: [(ah - bh) / ((bh - dh) * ch), -1.0 / ch].map(R::splat),
        }
    }

    /// (far, near - far, 1 / scale, R) of the branch of mean stress `s`.
    #[inline(always)]
    fn branch(&self, s: R) -> [R; 4] {
        let r = -s - R::splat(1.0 / 3.0);
        let pulled = r.lt(R::splat(0.0));
        let far = R::select(pulled, self.pulled[0], self.pressed[0]);
        let step = R::select(pulled, self.pulled[1], self.pressed[1]);
        [far, step, R::select(pulled, self.scales[0], self.scales[1]), r]
    }
}

/// e^x near x = 0; for all x positive and not falling.
#[inline(always)]
fn exp_near_zero<R: Real>(x: R) -> R {
    let (half, x) = (R::splat(0.5), x.max(R::splat(-1.0)));
    half.mul_add(x, R::splat(1.0)).mul_add(x, R::splat(1.0))
}

/// A stress on the way back, by s, u and the hardening variable.
#[derive(Clone, Copy)]
struct ReturnPoint<R> {
    s: R,
    u: R,
    kappa: R,
}

/// The surface and the flow at a place.
struct Surface<R> {
    f: R,
    f_s: R,
    f_u: R,
    f_kappa: R,
    g_s: R,
    g_u: R,
}

/// Quantities of a step that the return mapping leaves unchanged.
#[derive(Clone, Copy)]
struct Frame<R> {
    /// r(theta) and (2 cos theta)^2.
    shape: R,
    turn: R,
    /// Mean stress of the trial, its dg/ds less the first term, and 1 / Bg.
    s: R,
    dilating: R,
    per_scale: R,
    /// x_h: far, near - far times its exponential at `s`, 1 / scale.
    ductility: [R; 3],
}

impl<R: Real> Frame<R> {
    /// 1 / x_h at mean stress `s`.
    #[inline(always)]
    fn per_ductility(&self, s: R) -> R {
        let [far, step, per_scale] = self.ductility;
        R::splat(1.0) / step.mul_add(exp_near_zero((self.s - s) * per_scale), far)
    }
}

impl<R: Real> Cdpm2<R> {
    /// q1, q2 and their slopes.
    #[inline(always)]
    fn hardening(&self, kappa: R) -> [R; 4] {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let x = kappa.min(one);
        let rest = one - x;
        // q1 = 1 - (1 - q0) (1 - x)^3 - Hp x (1 - x) (2 - x)
        let square = rest * rest;
        let gap = one - self.initial;
        let bump = self.modulus * x * (rest + one);
        let first = one - rest * gap.mul_add(square, bump);
        let three = R::splat(3.0);
        let curve = three.mul_add(square, -one);
        let first_slope = three.mul_add(gap * square, -(self.modulus * curve));
        let hard = one.lt(kappa);
        let second = self.modulus.mul_add((kappa - one).positive(), one);
        [first, second, R::select(hard, zero, first_slope), R::select(hard, self.modulus, zero)]
    }

    /// f with r = `shape`.
    #[inline(always)]
    fn excess(&self, s: R, u: R, shape: R, [first, second, ..]: [R; 4]) -> R {
        let one = R::splat(1.0);
        let a = s + u;
        let l = ((one - first) * a).mul_add(a, R::splat(3.0) * u);
        let load = self.friction.mul_add(u.mul_add(shape, s), -second);
        l.mul_add(l, first * first * second * load)
    }

    #[inline(always)]
    fn surface(&self, at: &ReturnPoint<R>, frame: &Frame<R>) -> Surface<R> {
        let (one, two) = (R::splat(1.0), R::splat(2.0));
        let [first, second, first_slope, second_slope] = self.hardening(at.kappa);
        let a = at.s + at.u;
        let open = one - first;
        let l = (open * a).mul_add(a, R::splat(3.0) * at.u);
        let square = first * first;
        let load = self.friction * at.u.mul_add(frame.shape, at.s);
        let bulge = two * l * (two * open * a);
        let steep = (two * l).mul_add(R::splat(3.0), bulge);
        let by_first = two * first * second * (load - second) - two * l * a * a;
        let by_second = square * (load - second - second);
        let dilating = frame.dilating * exp_near_zero((at.s - frame.s) * frame.per_scale);
        Surface {
            f: l.mul_add(l, square * second * (load - second)),
            f_s: (square * second).mul_add(self.friction, bulge),
            f_u: (square * second * frame.shape).mul_add(self.friction, steep),
            f_kappa: by_first.mul_add(first_slope, by_second * second_slope).min(R::splat(0.0)),
            g_s: square.mul_add(dilating, bulge),
            g_u: square.mul_add(self.friction, steep),
        }
    }

    #[inline(always)]
    fn frame(&self, s: R, cosine: R, second: R) -> Frame<R> {
        let half = R::splat(0.5) * self.friction;
        let slope = self.thrice_tensile.mul_add(second, half);
        let ratio = slope / R::splat(3.0).mul_add(second, half);
        let per_scale = self.per_dilation * (ratio.ln() + self.dilation) / second;
        // On the surface the exponent is below 1; a trial far off it must not lead out of all bounds.
        let exponent = (-second).mul_add(self.third_tensile, s) * per_scale;
        let dilating = slope * exponent.min(R::splat(4.0)).exp();
        let [far, step, per_decay, r] = self.ductility.branch(s);
        Frame {
            shape: self.shape.at(cosine),
            turn: R::splat(4.0) * cosine * cosine,
            s,
            dilating,
            per_scale,
            ductility: [far, step * (r * per_decay).exp(), per_decay],
        }
    }

    /// The place on the surface that the trial returns to; the trial itself where it is not outside.
    #[inline(always)]
    fn back(&self, trial: ReturnPoint<R>, frame: &Frame<R>, outside: R::Mask) -> ReturnPoint<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let mut at = trial;
        for _ in 0..STEPS {
            let on = self.surface(&at, frame);
            let axis = !zero.lt(at.u);
            let g_u = R::select(axis, zero, on.g_u);
            let turn = R::select(axis, one, frame.turn);
            let norm = (on.g_s * on.g_s).mul_add(R::splat(1.0 / 3.0), g_u * g_u * R::splat(1.0 / 6.0)).sqrt();
            let rate = self.per_young * norm * turn * frame.per_ductility(at.s);
            let fall = (self.mean_fall * on.f_s)
                .mul_add(on.g_s, (self.shear_fall * on.f_u).mul_add(g_u, -(on.f_kappa * rate)));
            let step = on.f / fall.max(R::splat(1e-6));
            at.s = at.s - self.mean_fall * on.g_s * step;
            at.u = (at.u - self.shear_fall * g_u * step).positive();
            at.kappa = rate.mul_add(step, at.kappa).max(trial.kappa);
        }
        let pick = |a: R, b: R| R::select(outside, a, b);
        ReturnPoint { s: pick(at.s, trial.s), u: pick(at.u.min(trial.u), trial.u), kappa: pick(at.kappa, trial.kappa) }
    }

    /// Equivalent strain over that of the tensile strength.
    #[inline(always)]
    fn equivalent(&self, s: R, u: R, shape: R) -> R {
        let half = R::splat(0.5) * self.friction * u.mul_add(shape, s);
        let nine = R::splat(9.0) * u * u;
        let root = half.mul_add(half, nine).sqrt();
        // root + half, without cancellation where half is negative.
        R::select(half.lt(R::splat(0.0)), nine / (root - half).max(R::splat(1e-12)), root + half)
    }

    /// 1 / e_fc on this width.
    #[inline(always)]
    fn per_crushing(&self, width: R) -> R {
        self.per_crushing.mul_add(width, self.per_crushing_strain)
    }

    /// Integrities 1 - wt and 1 - wc. Equivalent strains are over f_t / E, k1 and k2 strains.
    #[inline(always)]
    fn integrity(&self, history: &History<R>, width: R) -> [R; 2] {
        let (one, onset) = (R::splat(1.0), R::splat(ONSET));
        let [cracking, crushing] = self.widest.map(|widest| width.min(widest));
        let [pulled, first, second] = [history[PULLED], history[PULLED + 1], history[PULLED + 2]];
        let scale = cracking * self.per_opening;
        let mut damage = one;
        for (from, slope) in PIECES {
            let slope = R::splat(slope) * scale;
            let opened = slope.mul_add(first, pulled - R::splat(from));
            damage = damage.min(opened / (-slope).mul_add(second, pulled).max(R::splat(1e-6)));
        }
        let crack = (one - damage).between(LEAST_INTEGRITY, 1.0);
        let [pressed, first, second] = [history[PRESSED], history[PRESSED + 1], history[PRESSED + 2]];
        let per_crushing = self.per_crushing(crushing);
        let start = (one - (first + second) * per_crushing).exp() / pressed.max(one);
        let crush = softening::relaxed(start, second * per_crushing).between(LEAST_INTEGRITY, 1.0);
        [R::select(onset.lt(pulled), crack, one), R::select(onset.lt(pressed), crush, one)]
    }

    /// Elastic energy, N/mm2: that of sqrt(1 - wt) s+ + sqrt(1 - wc) s-, which is never below 0 and is exact where principal
    /// stresses have one sign. (Stress times elastic strain is not: a cracked direction adds to it by Poisson's ratio.)
    #[inline(always)]
    fn stored(&self, effective: &Tensor<R>, crack: R, crush: R) -> R {
        let of = Invariants::of(&effective.map(|x| x * self.per_strength));
        let deviators = of.shape().map(|y| R::splat(2.0 / 3.0) * of.mises * y);
        let weighed = split(of.mean, &of.deviator, &deviators, crack.sqrt(), crush.sqrt());
        let Invariants { mean, mises, .. } = Invariants::of(&weighed);
        let volume = R::splat(1.5) * self.per_volume * mean * mean;
        self.compressive * (R::splat(1.0 / 3.0) * self.per_shear * mises).mul_add(mises, volume)
    }

    /// Lets the damage variables follow a step that ends at `end`, with `flowed` of plastic strain.
    #[inline(always)]
    fn damage(&self, history: &mut History<R>, end: &ReturnPoint<R>, shape: R, pressed: R, flowed: R) {
        let (zero, one, onset) = (R::splat(0.0), R::splat(1.0), R::splat(ONSET));
        let now = self.equivalent(end.s, end.u, shape);
        // u x_s, and 1 / x_s
        let stretched = self.brittle.mul_add((-end.s).positive(), end.u).max(R::splat(1e-7));
        let per_stretch = R::select(zero.lt(-end.s), end.u / stretched, one);
        let [_, second, ..] = self.hardening(end.kappa);
        // The way from tension to compression leads through no stress at all, though a step may leap over that.
        let leapt = zero.lt(history[EQUIVALENT]) & R::splat(0.9).lt(pressed);
        let before = R::select(leapt, zero, history[EQUIVALENT].abs());
        let crushing = pressed.mul_add(now - before, history[EQUIVALENT + 1]);
        let crushed = flowed * pressed * self.crushing_share * second / stretched;
        let steps = [(PULLED, now, flowed * per_stretch), (PRESSED, crushing, crushed)];
        for (place, strain, plastic) in steps {
            let (old, new) = (history[place], history[place].max(strain));
            let grown = new - old;
            // Plastic strain counts from the onset on.
            let share = ((new - onset) / grown.max(R::splat(1e-12))).between(0.0, 1.0);
            let counts = R::select(strain.lt(old * onset), zero, share);
            history[place] = new;
            history[place + 1] = counts.mul_add(plastic, history[place + 1]);
            history[place + 2] = (grown * self.onset).mul_add(per_stretch, history[place + 2]);
        }
        history[EQUIVALENT] = R::select(pressed.lt(R::splat(0.1)), now, -now);
        history[EQUIVALENT + 1] = crushing;
    }
}

/// Equivalent strain over that of the tensile strength at which damage begins, and over its largest one at which plastic
/// strain still counts: without hardening it stays at 1 but for rounding.
const ONSET: f64 = 0.9999;
/// How far damage goes.
const LEAST_INTEGRITY: f64 = 1e-6;

/// Plastic strain; the hardening variable; the equivalent strain, positive in pure tension and else negative, and that of
/// compression; the largest one, k1 and k2 of tension; the same of compression.
type History<R> = [R; REGISTERS];
const REGISTERS: usize = 15;
const KAPPA: usize = 6;
const EQUIVALENT: usize = 7;
const PULLED: usize = 9;
const PRESSED: usize = 12;

/// Share of compression among principal stresses, by squares.
#[inline(always)]
fn compression<R: Real>(principal: &[R; 3]) -> R {
    let [x, y, z] = *principal;
    let [a, b, c] = [x.min(R::splat(0.0)), y.min(R::splat(0.0)), z.min(R::splat(0.0))];
    let below = a.mul_add(a, b.mul_add(b, c * c));
    below / (x * x + y * y + z * z).max(R::splat(1e-20))
}

impl<R: Real> Law<R> for Cdpm2<R> {
    type History = History<R>;

    fn virgin() -> History<R> {
        [R::splat(0.0); REGISTERS]
    }

    #[inline(always)]
    fn stress(&self, strain: &Tensor<R>, history: &mut History<R>, width: R) -> PointResponse<R> {
        let (zero, one, two) = (R::splat(0.0), R::splat(1.0), R::splat(2.0));
        let stress = self.elastic.of(&elastic_part(strain, history));
        let invariants = Invariants::of(&stress);
        let (s, u) = (invariants.mean * self.per_strength, invariants.mises * self.per_strength * R::splat(1.0 / 3.0));
        let hardening = self.hardening(history[KAPPA]);
        // r is at most 1 / e.
        let bound = self.excess(s, u, self.shape.widest, hardening);
        let onset = R::splat(ONSET);
        let active = zero.lt(bound) | onset.lt(history[PULLED]) | onset.lt(history[PRESSED]);
        if !R::any(active) {
            return PointResponse { stress, integrity: one };
        }
        let of = invariants.shape();
        let frame = self.frame(s, of[0], hardening[1]);
        let outside = active & zero.lt(self.excess(s, u, frame.shape, hardening));
        let end = self.back(ReturnPoint { s, u, kappa: history[KAPPA] }, &frame, outside);

        let mut next = *history;
        let left = end.u / u.max(R::splat(1e-12));
        let left = R::select(outside, left, one);
        let (volumetric, lost) = ((s - end.s) * self.per_volume, (one - left) * self.per_shear * self.per_strength);
        flow(&mut next, &invariants.deviator, lost, volumetric);
        // |d ep|: rho / (2 G) is sqrt(6) f_c u / (2 G).
        let sheared = (u - end.u) * self.per_shear;
        let flowed = (R::splat(3.0) * volumetric).mul_add(volumetric, R::splat(6.0) * sheared * sheared).sqrt();
        next[KAPPA] = end.kappa;
        let (mut deviators, mut principal) = (of, of);
        for i in 0..3 {
            deviators[i] = two * end.u * of[i];
            principal[i] = deviators[i] + end.s;
        }
        let pressed = compression(&principal);
        self.damage(&mut next, &end, frame.shape, pressed, flowed);
        for i in 0..REGISTERS {
            history[i] = R::select(active, next[i], history[i]);
        }

        let [crack, crush] = self.integrity(history, width);
        let scale = left * self.per_strength;
        let mut deviator = invariants.deviator;
        for d in &mut deviator {
            *d = *d * scale;
        }
        let mut nominal = split(end.s, &deviator, &deviators, crack, crush);
        for i in 0..6 {
            nominal[i] = R::select(active, nominal[i] * self.compressive, stress[i]);
        }
        PointResponse { stress: nominal, integrity: pressed.mul_add(crush - crack, crack) }
    }

    #[inline(always)]
    fn state(&self, strain: &Tensor<R>, history: &History<R>, width: R) -> State<R> {
        let one = R::splat(1.0);
        let [crack, crush] = self.integrity(history, width);
        let opened = (one - crack).mul_add(history[PULLED + 2], history[PULLED + 1]);
        State {
            tension: one - crack,
            compression: one - crush,
            weakened: R::splat(0.0),
            opening: width.min(self.widest[0]) * opened,
            stored: self.stored(&self.elastic.of(&elastic_part(strain, history)), crack, crush),
        }
    }

    fn widest_mm(&self) -> [f64; 2] {
        self.widest_mm
    }
}
