//! The way into a body that crosses all the faces at a point as steeply as can be.

use crate::math::Vec3;

/// Steps of the search.
const STEPS: usize = 60;
/// Least cosine to all faces for a way to be one.
const STEEP: f64 = 0.05;

/// The unit vector whose least cosine to the inward `normals` (given outward) is greatest, and that cosine: exact for one
/// and two faces, within a few percent for more; `None` where there is no way in, or hardly one.
pub(super) fn steepest(normals: &[Vec3]) -> Option<(Vec3, f64)> {
    let least = |way: &Vec3| {
        let cosines = normals.iter().map(|normal| (-normal.dot(way), *normal));
        cosines.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
    };
    let mut way = -normals.iter().sum::<Vec3>().try_normalize(1e-9)?;
    let mut best = (way, least(&way).0);
    let steps = if normals.len() > 2 { STEPS } else { 0 };
    for step in 0..steps {
        way = (way - least(&way).1 * (1.0 / (2 + step) as f64)).try_normalize(1e-9)?;
        let cosine = least(&way).0;
        if cosine > best.1 {
            best = (way, cosine);
        }
    }
    (best.1 > STEEP).then_some(best)
}
