//! `[materials.aggregate_strength]`: aggregates that break, all alike, of several kinds, or each of a strength of its own.

use super::{MATERIALS, Materials, Strength};
use meso_concrete::OutOfRange;
use serde::{Deserialize, Serialize};

/// Strength of the aggregates' rock.
///
/// A grain's kind and its place in the scatter follow from the seed and its number, and from nothing else.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Stone {
    /// Compressive strength, MPa.
    pub compressive_mpa: f64,
    /// Strain at the compressive strength.
    pub peak_strain: f64,
    /// Tensile strength, MPa.
    pub tensile_mpa: f64,
    /// Fracture energy in tension, N/mm.
    pub fracture_energy_n_per_mm: f64,
    /// Energy of crushing beyond the peak, N/mm.
    pub crushing_energy_n_per_mm: f64,
    /// Weibull modulus of the grains' strengths about their mean; absent, grains of a kind are alike.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weibull_modulus: Option<f64>,
    /// Kinds of stone; none are one kind of the strength above.
    pub kinds: Vec<StoneKind>,
    /// Seed of the draw.
    pub seed: u64,
}

/// A kind of stone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct StoneKind {
    /// Share of the grains, by number; shares sum to 1.
    pub share: f64,
    /// Strengths, peak strain and energies over those above.
    pub strength_ratio: f64,
}

/// Strengths of equal probability that a scatter is divided into: grains of one strength are computed together.
const LEVELS: usize = 16;
/// Most kinds.
const MOST_KINDS: usize = 8;

impl Default for Stone {
    /// A sound granite: 150 and 10 MPa lie in the lower half of 100 to 250 and 7 to 25 MPa (University of Texas, GEOL 615). The
    /// energies are remembered: 0.1 N/mm is in the range of granites, and crushing takes as long a displacement as mortar's.
    fn default() -> Self {
        Self {
            compressive_mpa: 150.0,
            peak_strain: 0.004,
            tensile_mpa: 10.0,
            fracture_energy_n_per_mm: 0.1,
            crushing_energy_n_per_mm: 5.0,
            weibull_modulus: None,
            kinds: Vec::new(),
            seed: 1,
        }
    }
}

impl Stone {
    /// The strength without kinds and scatter.
    pub fn mean(&self) -> Strength {
        Strength {
            compressive_mpa: self.compressive_mpa,
            peak_strain: self.peak_strain,
            tensile_mpa: self.tensile_mpa,
            fracture_energy_n_per_mm: self.fracture_energy_n_per_mm,
            crushing_energy_n_per_mm: self.crushing_energy_n_per_mm,
        }
    }

    /// All strengths that grains may have, kind by kind.
    pub fn strengths(&self) -> Vec<Strength> {
        let levels = self.levels();
        let of_kind = |ratio: f64| levels.iter().map(move |level| ratio * level);
        let ratios = self.kinds().into_iter().flat_map(|kind| of_kind(kind.strength_ratio));
        ratios.map(|ratio| self.scaled(ratio)).collect()
    }

    /// Place among [`strengths`](Self::strengths) of the grain with this number.
    pub fn place(&self, grain: u32) -> usize {
        let (kinds, levels) = (self.kinds(), self.levels().len());
        let (drawn, mut sum) = (uniform(self.seed, 2 * u64::from(grain)), 0.0);
        let chosen = kinds.iter().position(|kind| {
            sum += kind.share;
            drawn < sum
        });
        let level = (uniform(self.seed, 2 * u64::from(grain) + 1) * levels as f64) as usize;
        chosen.unwrap_or(kinds.len() - 1) * levels + level
    }

    fn kinds(&self) -> Vec<StoneKind> {
        if self.kinds.is_empty() { vec![StoneKind { share: 1.0, strength_ratio: 1.0 }] } else { self.kinds.clone() }
    }

    /// Strengths over their mean, each as probable as the next: quantiles of Weibull's distribution.
    fn levels(&self) -> Vec<f64> {
        let Some(modulus) = self.weibull_modulus else { return vec![1.0] };
        let mean = libm::tgamma(1.0 + 1.0 / modulus);
        let quantile = |level: usize| -libm::log1p(-(level as f64 + 0.5) / LEVELS as f64);
        (0..LEVELS).map(|level| libm::pow(quantile(level), 1.0 / modulus) / mean).collect()
    }

    /// The curve of a stone that is `ratio` as strong: its elastic strain grows as its strength.
    fn scaled(&self, ratio: f64) -> Strength {
        let mean = self.mean();
        Strength { peak_strain: ratio * mean.peak_strain, ..mean.scaled(ratio) }
    }
}

/// A number from 0 to below 1, drawn by splitmix64 (Steele, Lea and Flood 2014).
fn uniform(seed: u64, number: u64) -> f64 {
    let mut z = seed.wrapping_add(number.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

impl Materials {
    /// Checks the draw of the aggregates' strengths; the law checks each strength.
    ///
    /// # Errors
    /// Names the first value outside its range.
    pub fn validate_stone(&self) -> Result<(), OutOfRange> {
        let Some(stone) = &self.aggregate_strength else { return Ok(()) };
        let require = |key: &str, value, met, accepted| {
            MATERIALS.require(format!("aggregate_strength.{key}"), value, met, accepted)
        };
        let modulus = stone.weibull_modulus.unwrap_or(1.0);
        require(
            "weibull_modulus",
            modulus,
            (1.0..=100.0).contains(&modulus),
            "it must be 1 to 100; rocks have 3 to 15",
        )?;
        let count = stone.kinds.len();
        require("kinds", count as f64, count <= MOST_KINDS, "it must have at most 8 kinds")?;
        for kind in &stone.kinds {
            let StoneKind { share, strength_ratio: ratio } = *kind;
            require("kinds.share", share, share > 0.0 && share <= 1.0, "it must lie above 0 and at most at 1")?;
            require("kinds.strength_ratio", ratio, (0.01..=100.0).contains(&ratio), "it must be 0.01 to 100")?;
        }
        let sum: f64 = stone.kinds.iter().map(|kind| kind.share).sum();
        require("kinds.share", sum, count == 0 || (sum - 1.0).abs() < 1e-6, "the shares must sum to 1")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(stone: &Stone, grains: u32) -> Vec<f64> {
        let strengths = stone.strengths();
        (0..grains).map(|grain| strengths[stone.place(grain)].tensile_mpa).collect()
    }

    #[test]
    fn stones_are_alike_where_nothing_is_drawn() {
        assert_eq!(drawn(&Stone::default(), 100), vec![10.0; 100]);
    }

    #[test]
    fn kinds_have_their_shares_and_a_scatter_has_its_mean_and_spread() {
        let kind = |share, strength_ratio| StoneKind { share, strength_ratio };
        let weak = Stone { kinds: vec![kind(0.2, 0.5), kind(0.8, 1.0)], ..Stone::default() };
        let count = drawn(&weak, 20_000).iter().filter(|mpa| **mpa == 5.0).count();
        assert!((count as f64 / 20_000.0 - 0.2).abs() < 0.01, "{count}");
        let scattered = Stone { weibull_modulus: Some(6.0), ..Stone::default() };
        let all = drawn(&scattered, 20_000);
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let spread = (all.iter().map(|mpa| (mpa - mean).powi(2)).sum::<f64>() / all.len() as f64).sqrt();
        // Weibull's coefficient of variation is 0.194 at 6; the last of 16 levels is cut at its median.
        assert!((mean / 10.0 - 1.0).abs() < 0.01 && (0.17..0.2).contains(&(spread / mean)), "{mean} {spread}");
        assert_ne!(all, drawn(&Stone { seed: 2, ..scattered }, 20_000));
    }

    #[test]
    fn a_draw_that_cannot_be_is_named() {
        let refused = |stone: Stone| {
            let materials = Materials { aggregate_strength: Some(stone), ..Materials::default() };
            materials.validate_stone().unwrap_err().to_string()
        };
        let kinds = vec![StoneKind { share: 0.5, strength_ratio: 1.0 }];
        let text = refused(Stone { kinds, ..Stone::default() });
        assert!(text.contains("aggregate_strength.kinds.share is 0.5; the shares must sum to 1"), "{text}");
        let text = refused(Stone { weibull_modulus: Some(0.0), ..Stone::default() });
        assert!(text.contains("aggregate_strength.weibull_modulus is 0; it must be 1 to 100"), "{text}");
    }
}
