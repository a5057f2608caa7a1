//! The cracks of a point as layers, for whatever passes through them.
//!
//! A law knows the opening w of a point's widest crack and its plastic strain. Cracks open along the principal axes n of this
//! strain, each by its share of the largest principal value. A band of width h has one layer across each axis, so that the crack
//! strain is the sum of (w / h) n n^T. Cells may have the mean of their points: the strain adds up to the same openings.

use crate::march::Point;
use meso_collision::geometry::principal_axes;
use meso_collision::math::Mat3;

/// Places of the components xx yy zz xy yz zx.
const PLACES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];

/// Strain of a point's cracks, xx yy zz xy yz zx; shears are those of the tensor. Without an open crack it is 0.
pub(super) fn crack_strain(point: &Point) -> [f32; 6] {
    let [xx, yy, zz, xy, yz, zx] = point.plastic.map(f64::from);
    let plastic = Mat3::new(xx, xy / 2.0, zx / 2.0, xy / 2.0, yy, yz / 2.0, zx / 2.0, yz / 2.0, zz);
    let (opening, width) = (f64::from(point.opening_mm), f64::from(point.width_mm));
    if !(opening > 0.0 && width > 0.0) || plastic == Mat3::zeros() {
        return [0.0; 6];
    }
    let axes = principal_axes(&plastic);
    let values = [0, 1, 2].map(|axis| axes.column(axis).dot(&(plastic * axes.column(axis))));
    // By ascending values; a point that is pressed flat has nothing open.
    let largest = values[2].max(f64::MIN_POSITIVE);
    let open = values.into_iter().enumerate().filter(|(_, value)| *value > 0.0);
    let strain: Mat3 = open.map(|(axis, value)| axes.column(axis) * axes.column(axis).transpose() * value).sum();
    PLACES.map(|place| (strain[place] * (opening / (width * largest))) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crack_is_a_layer_across_its_normal() {
        let along_y = [0.0, 0.02, 0.0, 0.0, 0.0, 0.0];
        let point = Point { opening_mm: 0.06, width_mm: 3.0, plastic: along_y, ..Point::default() };
        assert_eq!(crack_strain(&point), along_y);
        assert_eq!(crack_strain(&Point { opening_mm: 0.0, ..point }), [0.0; 6]);
        assert_eq!(crack_strain(&Point { opening_mm: f32::NAN, ..point }), [0.0; 6]);
        let pressed = [-0.01, -0.02, -0.01, 0.0, 0.0, 0.0];
        assert_eq!(crack_strain(&Point { plastic: pressed, ..point }), [0.0; 6]);
    }

    #[test]
    fn an_oblique_crack_and_two_crossing_ones_have_their_normals() {
        let of = |plastic| crack_strain(&Point { opening_mm: 0.1, width_mm: 2.0, plastic, ..Point::default() });
        // Normal (1, 1, 0): the engineering shear of n n^T is twice its component.
        let oblique = of([0.5, 0.5, 0.0, 1.0, 0.0, 0.0]);
        let expected = [0.025, 0.025, 0.0, 0.025, 0.0, 0.0];
        assert!(oblique.iter().zip(expected).all(|(a, b): (&f32, f32)| (a - b).abs() < 1e-7), "{oblique:?}");
        assert_eq!(of([1.0, 0.5, -1.0, 0.0, 0.0, 0.0]), [0.05, 0.025, 0.0, 0.0, 0.0, 0.0]);
    }
}
