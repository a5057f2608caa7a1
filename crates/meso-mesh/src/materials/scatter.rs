//! `[materials.scatter]`: strengths of mortar and ITZ that differ from place to place.
//!
//! A Gaussian field of mean 0 and variance 1 is a sum of waves whose vectors and phases are drawn from the seed (Shinozuka
//! and Jan 1972, remembered). Its covariance is the mean of cos(k r) over the vectors k, so that their density is chosen:
//!
//! ```text
//! g(x) = sqrt(2 / n) sum cos(k_i x + phi_i)
//! exp(-(r / l)^2)    k = sqrt(2) z / l       z: three standard normal numbers
//! exp(-r / l)        k = z / (l |w|)         w: another one
//! ```
//!
//! The factor of a strength is the quantile of its distribution at the normal probability of g. It is a function of the
//! place, and no mesh is in it.

use super::{LawName, MATERIALS, Materials};
use crate::cells::Phase;
use meso_collision::math::Vec3;
use meso_concrete::aggregate::random::{Draw, Stream};
use meso_concrete::{OutOfRange, PhaseNames};
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2, TAU};

/// Scatter of the strengths of mortar and ITZ over the specimen, for the law `meso`.
///
/// One factor multiplies strengths, peak strain and energies of a place, so that openings of cracks keep their law.
/// Stiffness has no scatter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Scatter {
    /// Standard deviation of the strengths over their mean; 0 is no scatter.
    pub coefficient_of_variation: f64,
    /// Distance at which the covariance has fallen to 1/e, mm.
    pub correlation_length_mm: f64,
    /// Distribution of the strengths; weibull unless given.
    #[serde(default)]
    pub distribution: StrengthDistribution,
    /// Covariance of the Gaussian field over the distance; squared-exponential unless given.
    #[serde(default)]
    pub covariance: Covariance,
    /// Phases that scatter, by one field; mortar and itz unless given.
    #[serde(default = "both")]
    pub phases: Vec<ScatteredPhase>,
    /// Seed of the field, which the packing does not depend on; 1 unless given.
    #[serde(default = "first")]
    pub seed: u64,
}

/// Distribution of strengths about a mean of 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum StrengthDistribution {
    /// Of the weakest link, with the modulus that has the coefficient of variation.
    #[default]
    Weibull,
    /// Of products of many factors.
    Lognormal,
}

/// Covariance over the distance r.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Covariance {
    /// `exp(-(r / l)^2)`: a smooth field.
    #[default]
    SquaredExponential,
    /// `exp(-r / l)`: a rough field.
    Exponential,
}

/// A phase whose strengths can scatter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ScatteredPhase {
    /// The matrix.
    Mortar,
    /// The shell around aggregates, as elements.
    Itz,
}

/// Waves of a field. In one field the covariance then errs by 0.03 (rms); over seeds its mean is exact.
const WAVES: usize = 512;
/// Standard deviations at which the field is cut: 6 values of 100,000 lie beyond them.
const MOST: f64 = 4.0;
/// Largest coefficient of variation.
const WIDEST: f64 = 0.5;
/// Least one above 0: for smaller ones the modulus would be a difference of nearly equal numbers.
const NARROWEST: f64 = 1e-3;
/// Elements over the correlation length, at which a doubt and a refusal begin.
const COARSE: [f64; 2] = [0.5, 2.0];
/// Correlation length over the specimen's length, from which on places of a specimen are nearly alike.
const UNIFORM: f64 = 10.0;

fn both() -> Vec<ScatteredPhase> {
    vec![ScatteredPhase::Mortar, ScatteredPhase::Itz]
}

fn first() -> u64 {
    1
}

/// Factors of the strengths over places.
#[derive(Clone, Debug)]
pub struct StrengthField {
    /// Vectors and phases of the waves.
    waves: Vec<(Vec3, f64)>,
    marginal: Marginal,
}

/// A distribution of mean 1.
#[derive(Clone, Copy, Debug)]
enum Marginal {
    /// 1 / modulus, and 1 / gamma(1 + 1 / modulus).
    Weibull(f64, f64),
    /// Standard deviation of the logarithm, and e to the power of its mean.
    Lognormal(f64, f64),
}

impl Marginal {
    /// The value that is as probable as `normal` standard deviations.
    fn at(&self, normal: f64) -> f64 {
        match *self {
            Self::Weibull(power, scale) => {
                let tail = 0.5 * libm::erfc(FRAC_1_SQRT_2 * normal.abs());
                let hazard = if normal < 0.0 { -libm::log1p(-tail) } else { -libm::log(tail) };
                scale * libm::pow(hazard, power)
            }
            Self::Lognormal(deviation, median) => median * libm::exp(deviation * normal),
        }
    }
}

/// Square of the coefficient of variation of Weibull's distribution.
fn variation(modulus: f64) -> f64 {
    let gamma = |n: f64| libm::tgamma(1.0 + n / modulus);
    gamma(2.0) / gamma(1.0).powi(2) - 1.0
}

impl Scatter {
    /// Weibull modulus of the coefficient of variation.
    pub fn weibull_modulus(&self) -> f64 {
        let wanted = self.coefficient_of_variation.powi(2);
        let (mut low, mut high) = (1.0, 2e3);
        for _ in 0..60 {
            let middle = f64::midpoint(low, high);
            (low, high) = if variation(middle) > wanted { (middle, high) } else { (low, middle) };
        }
        low
    }

    /// The distribution with its values.
    fn marginal(&self) -> Marginal {
        match self.distribution {
            StrengthDistribution::Weibull => {
                let power = 1.0 / self.weibull_modulus();
                Marginal::Weibull(power, 1.0 / libm::tgamma(1.0 + power))
            }
            StrengthDistribution::Lognormal => {
                let variance = libm::log1p(self.coefficient_of_variation.powi(2));
                Marginal::Lognormal(variance.sqrt(), libm::exp(-0.5 * variance))
            }
        }
    }

    /// The field.
    pub fn field(&self) -> StrengthField {
        let mut stream = Stream::new(self.seed, Draw::Field, 0, 0);
        let per_length = 1.0 / self.correlation_length_mm;
        let wave = |_| {
            let mut normal = || stream.normal(0.0, 1.0);
            let z = Vec3::new(normal(), normal(), normal());
            let k = match self.covariance {
                Covariance::SquaredExponential => SQRT_2 * per_length,
                // Waves shorter than a millionth of the length are noise at any two places.
                Covariance::Exponential => per_length / normal().abs().max(1e-6),
            };
            (z * k, TAU * stream.unit())
        };
        StrengthField { waves: (0..WAVES).map(wave).collect(), marginal: self.marginal() }
    }

    /// Largest factor of a field.
    pub fn most(&self) -> f64 {
        self.marginal().at(MOST)
    }

    /// Whether the strengths of `phase` scatter.
    pub fn has(&self, phase: Phase) -> bool {
        match phase {
            Phase::Mortar => self.phases.contains(&ScatteredPhase::Mortar),
            Phase::Itz => self.phases.contains(&ScatteredPhase::Itz),
            Phase::Aggregate | Phase::Void | Phase::Fibre | Phase::Own(_) => false,
        }
    }

    fn scattered(&self) -> impl Iterator<Item = Phase> {
        [Phase::Mortar, Phase::Itz].into_iter().filter(|phase| self.has(*phase))
    }

    /// The field in a few words.
    pub fn words(&self) -> String {
        let phases: Vec<_> = self.scattered().map(|phase| PhaseNames::COMMON.in_words(phase)).collect();
        let distribution = match self.distribution {
            StrengthDistribution::Weibull => format!("Weibull, modulus {:.1}", self.weibull_modulus()),
            StrengthDistribution::Lognormal => "lognormal".to_owned(),
        };
        format!(
            "strengths of {} scatter by {:.1} % ({distribution}) over {} mm, seed {}",
            phases.join(" and "),
            100.0 * self.coefficient_of_variation,
            self.correlation_length_mm,
            self.seed
        )
    }

    /// Refuses a field that elements of this size, and cohesive faces as ITZ, cannot have.
    ///
    /// # Errors
    /// The correlation length is far below the size, or the ITZ has no elements.
    pub fn suits(&self, element_size_mm: f64, is_cohesive: bool) -> Result<(), OutOfRange> {
        let accepted =
            r#"strengths of a cohesive ITZ do not scatter; take phases = ["mortar"], or a solid or smeared ITZ"#;
        let phases: Vec<&str> = self.scattered().map(|phase| PhaseNames::COMMON.name(phase)).collect();
        let met = !(is_cohesive && self.has(Phase::Itz));
        MATERIALS.require("scatter.phases", format!("{phases:?}"), met, accepted)?;
        let (length, [fine, coarse]) = (self.correlation_length_mm, COARSE);
        let (least, size) = (element_size_mm / coarse, fine * length);
        let accepted = format!(
            "with elements of {element_size_mm} mm it must be {least} or more, since each would break by itself and scatter \
             would follow from the mesh; elements of {size} mm resolve it"
        );
        MATERIALS.require("scatter.correlation_length_mm", length, length >= least, accepted)
    }

    /// A warning about a field in elements of this size, and in a specimen of this largest length.
    pub fn doubt(&self, element_size_mm: f64, specimen_mm: f64) -> Option<String> {
        let (length, size) = (self.correlation_length_mm, COARSE[0] * self.correlation_length_mm);
        if element_size_mm > size * (1.0 + 1e-9) {
            return Some(format!(
                "strengths change over {length} mm, and elements of {element_size_mm} mm do not resolve that: the scatter depends \
                 on the mesh; take elements of {size} mm"
            ));
        }
        let longest = UNIFORM * specimen_mm;
        (length > longest).then(|| {
            format!(
                "strengths change over {length} mm, far more than the specimen's {specimen_mm} mm: specimens differ, and places \
                 within one hardly do; take a materials.scatter.correlation_length_mm below {specimen_mm}"
            )
        })
    }
}

impl StrengthField {
    /// The Gaussian field at a place: mean 0, variance 1.
    pub fn gaussian(&self, at: &Vec3) -> f64 {
        let sum: f64 = self.waves.iter().map(|(k, phase)| libm::cos(k.dot(at) + phase)).sum();
        (2.0 / self.waves.len() as f64).sqrt() * sum
    }

    /// Factor of strengths, peak strain and energies at a place.
    pub fn factor(&self, at: &Vec3) -> f64 {
        self.marginal.at(self.gaussian(at).clamp(-MOST, MOST))
    }
}

impl Materials {
    /// The scatter, unless it is none.
    pub fn scattered(&self) -> Option<&Scatter> {
        self.scatter.as_ref().filter(|scatter| scatter.coefficient_of_variation != 0.0)
    }

    /// Checks the scatter, and that `law` can have it; elastic tests have no strengths.
    ///
    /// # Errors
    /// Names the first value outside its range.
    pub fn validate_scatter(&self, law: LawName) -> Result<(), OutOfRange> {
        let Some(scatter) = &self.scatter else { return Ok(()) };
        let (cv, length) = (scatter.coefficient_of_variation, scatter.correlation_length_mm);
        let met = cv == 0.0 || (NARROWEST..=WIDEST).contains(&cv);
        let accepted = "it must be 0, or 0.001 to 0.5: 0.1 is 10 %";
        MATERIALS.require("scatter.coefficient_of_variation", cv, met, accepted)?;
        MATERIALS.positive("scatter.correlation_length_mm", length)?;
        let count = scatter.phases.len();
        let is_right = count == 1 || count == 2 && scatter.phases[0] != scatter.phases[1];
        let named = if count == 0 { "[]" } else { "a list" };
        MATERIALS.require("scatter.phases", named, is_right, r#"name "mortar", "itz" or each of them once"#)?;
        let has_factor = cv == 0.0 || matches!(law, LawName::Meso | LawName::Elastic);
        let accepted =
            "strengths scatter in tests with the law meso only; for decks and other laws set 0, or remove the table";
        MATERIALS.require("scatter.coefficient_of_variation", cv, has_factor, accepted)
    }
}
