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
use meso_concrete::aggregate::{ShapeKind, Template};
use std::f64::consts::TAU;

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
        let most = MOST_MEETINGS / self.excluded_over_own();
        if self.fraction <= most {
            return Ok(());
        }
        let message = format!(
            "is {} but grains as slender as this library's{} fill at most {most:.3} at random; take a lower fraction or \
             stouter grains",
            number(self.fraction),
            if self.shape.has_coatings() { ", with their coatings," } else { "" }
        );
        Err(SpecError::value("fraction", message))
    }

    /// Mean excluded volume of two grains over their stones' mean volume.
    ///
    /// A coating of the thickness t around a body of the volume V, the surface A and the mean width w has at least the
    /// points within t of it: Steiner's V + A t + 2 pi w t^2 + 4/3 pi t^3, A + 4 pi w t + 4 pi t^2 and w + 2 t.
    fn excluded_over_own(&self) -> f64 {
        let grains = &self.shape.grains;
        let [mut volume, mut surface, mut width] = [0.0; 3];
        for (own_volume, own_surface, own_width) in grains.iter().map(Template::measures) {
            (volume, surface, width) = (volume + own_volume, surface + own_surface, width + own_width);
        }
        let mean = [volume, surface, width].map(|sum| sum / grains.len() as f64);
        let mut sums = [0.0; 5];
        for class in self.grading.classes() {
            let (low, high) = (class.d_min_mm, class.d_max_mm);
            let sizes: Vec<f64> =
                (0..SIZES).map(|i| self.grading.size_law.size(low, high, (i as f64 + 0.5) / SIZES as f64)).collect();
            // As many as make up the class's volume.
            let cubes: f64 = sizes.iter().map(|size| size.powi(3)).sum();
            for size in sizes {
                let [v, a, w] = [mean[0] * size.powi(3), mean[1] * size.powi(2), mean[2] * size];
                for (share, [least, most]) in self.coatings(&class, size) {
                    let (number, t) = (class.share * share / cubes, (least + most) / 2.0);
                    let volume = v + t * (a + t * TAU * (w + t * 2.0 / 3.0));
                    let own = [1.0, v, volume, a + 2.0 * TAU * t * (w + t), w + 2.0 * t];
                    sums.iter_mut().zip(own).for_each(|(sum, own)| *sum += number * own);
                }
            }
        }
        let [number, stones, volume, surface, width] = sums;
        2.0 * volume / stones + surface * width / (number * stones)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_collision::math::Vec3;
    use meso_concrete::aggregate::{Grading, Itz, Shape, ShellLaw};

    fn block(size: [f64; 3]) -> Template {
        let corner = |i: usize| Vec3::from_fn(|axis, _| if i >> axis & 1 == 1 { size[axis] } else { 0.0 });
        Template::new((0..8).map(corner).collect()).unwrap()
    }

    fn most(size: [f64; 3]) -> f64 {
        most_with(size, Vec::new())
    }

    /// All grains of one size.
    fn most_with(size: [f64; 3], shells: Vec<ShellLaw>) -> f64 {
        let (d_min_mm, d_max_mm) = (10.0, 10.001);
        let grading = Grading { d_min_mm, d_max_mm, classes_mm: vec![d_min_mm, d_max_mm], ..Grading::default() };
        let shape = Shape { kind: ShapeKind::Library, grains: vec![block(size)], shells, ..Shape::default() };
        let itz = Itz { thickness_mm: [0.0; 2] };
        MOST_MEETINGS / Spec { grading, shape, itz, ..Spec::default() }.excluded_over_own()
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

    /// Isotropic spherocylinders of the length L and the diameter D exclude 4/3 pi D^3 + 2 pi L D^2 + pi / 2 L^2 D (Onsager 1949).
    #[test]
    fn coated_needles_exclude_what_spherocylinders_do() {
        const THIN: f64 = 1e-5;
        for [thickness, length] in [[0.5, 10.0], [5.0, 10.0]] {
            let shell = ShellLaw {
                name: "coat".to_owned(),
                thickness_mm: Some([thickness; 2]),
                size_share: None,
                thickness_over_size_mm: None,
                volume_share: None,
                of: None,
                outward: true,
            };
            let d = 2.0 * thickness;
            let excluded = TAU * d * (2.0 / 3.0 * d * d + length * d + length * length / 4.0);
            let exact = MOST_MEETINGS * length * (length * THIN).powi(2) / excluded;
            let found = most_with([1.0, THIN, THIN], vec![shell]);
            assert!((found / exact - 1.0).abs() < 0.01, "{thickness}: {found} {exact}");
        }
    }
}
