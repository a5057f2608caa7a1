//! Slender grains of a library that cannot be that dense at random, named before any work starts.
//!
//! Bodies that lie at random meet as many others as there are centres in their excluded volume, and no stable packing has
//! more than some ten contacts a body. Philipse's limit of rods (see `limits::inclusions`) is this very rule:
//! with the excluded volume of rods, 2 L / D of their own, 5.4 D / L is 10.8 meetings. For other convex bodies the excluded
//! volume is that of A. Isihara (J. Chem. Phys. 18 (1950) 1446): V1 + V2 + (A1 M2 + A2 M1) / (4 pi), A the surface and
//! M = 2 pi times the mean width. Compact grains never come near: packed at 0.70 they have 7.

use super::{Checked, RANDOM_RODS};
use crate::messages::number;
use crate::{Spec, SpecError};
use meso_concrete::aggregate::{Grading, ShapeKind, Template};

/// Most bodies that have their centre in another's excluded volume.
const MOST_MEETINGS: f64 = 2.0 * RANDOM_RODS;
/// Sizes looked at in every class.
const SIZES: usize = 16;

impl Spec {
    /// Names a fraction that the library's grains do not reach at random. Not part of [`Spec::validate`]: a saved model
    /// may have fallen short.
    pub fn is_reachable_at_random(&self) -> Checked {
        if self.shape.kind != ShapeKind::Library {
            return Ok(());
        }
        let most = MOST_MEETINGS / excluded_over_own(&self.shape.grains, &self.grading);
        if self.fraction <= most {
            return Ok(());
        }
        let message = format!(
            "is {} but grains as slender as this library's fill at most {most:.3} at random; take a lower fraction or \
             stouter grains",
            number(self.fraction)
        );
        Err(SpecError::value("fraction", message))
    }
}

/// Mean excluded volume of two grains over their mean volume.
fn excluded_over_own(grains: &[Template], grading: &Grading) -> f64 {
    let [mut volume, mut surface, mut width] = [0.0; 3];
    for grain in grains {
        let (own_volume, own_surface, own_width) = grain.measures();
        (volume, surface, width) = (volume + own_volume, surface + own_surface, width + own_width);
    }
    let [d1, d2, d3] = mean_powers(grading);
    2.0 + surface * d2 * (width * d1) / (grains.len() as f64 * volume * d3)
}

/// The mean size, its mean square and its mean cube, by number.
fn mean_powers(grading: &Grading) -> [f64; 3] {
    let mut sums = [0.0; 4];
    for class in grading.classes() {
        let (low, high) = (class.d_min_mm, class.d_max_mm);
        let size = |i: usize| grading.size_law.size(low, high, (i as f64 + 0.5) / SIZES as f64);
        let powers = [0, 1, 2, 3].map(|power| (0..SIZES).map(|i| size(i).powi(power)).sum::<f64>());
        // As many as make up the class's volume.
        (0..4).for_each(|power| sums[power] += class.share * powers[power] / powers[3]);
    }
    [1, 2, 3].map(|power| sums[power] / sums[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_collision::math::Vec3;

    fn block(size: [f64; 3]) -> Template {
        let corner = |i: usize| Vec3::from_fn(|axis, _| if i >> axis & 1 == 1 { size[axis] } else { 0.0 });
        Template::new((0..8).map(corner).collect()).unwrap()
    }

    /// All grains of one size.
    fn most(size: [f64; 3]) -> f64 {
        let (d_min_mm, d_max_mm) = (10.0, 10.001);
        let grading = Grading { d_min_mm, d_max_mm, classes_mm: vec![d_min_mm, d_max_mm], ..Grading::default() };
        MOST_MEETINGS / excluded_over_own(&[block(size)], &grading)
    }

    #[test]
    fn blocks_have_the_excluded_volume_of_isihara() {
        // A box: the surface, and M = pi (a + b + c).
        for [a, b, c] in [[1.0, 1.0, 1.0], [1.0, 0.5, 0.2], [1.0, 1.0, 0.01], [1.0, 0.02, 0.02]] {
            let (volume, surface) = (a * b * c, 2.0 * (a * b + b * c + c * a));
            let exact = MOST_MEETINGS / (2.0 + surface * (a + b + c) / (2.0 * volume));
            assert!((most([a, b, c]) / exact - 1.0).abs() < 0.01, "{a} {b} {c}: {} {exact}", most([a, b, c]));
        }
    }

    #[test]
    fn needles_have_the_limit_of_rods_and_cubes_none() {
        let thickness = 0.01;
        // A rod of the same volume over length: its diameter is 2 / sqrt(pi) of the square's side.
        let rods = RANDOM_RODS * thickness * 2.0 / std::f64::consts::PI.sqrt();
        assert!((most([1.0, thickness, thickness]) / rods - 1.0).abs() < 0.15, "{}", most([1.0, thickness, thickness]));
        assert!(most([1.0; 3]) > 0.9);
        assert!(most([1.0, 1.0, 1e-4]) < 1e-3);
    }
}
