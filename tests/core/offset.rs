//! The inward offset against exact erosions.

use meso_core::geometry::{convex_hull, inscribed_ball, inward_offset};
use meso_core::math::Vec3;

fn cube(side: f64) -> Vec<Vec3> {
    (0..8).map(|i| Vec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * side).collect()
}

#[test]
fn a_shrunk_cube_is_a_cube() {
    let body = convex_hull(&cube(2.0)).unwrap();
    for thickness in [0.0, 0.1, 0.25, 0.9, 0.999] {
        let core = inward_offset(&body, thickness).unwrap().unwrap();
        let side = 2.0 - 2.0 * thickness;
        assert!((core.volume() / side.powi(3) - 1.0).abs() < 1e-13, "{} at {thickness}", core.volume());
        assert_eq!((core.vertices().len(), core.faces().len()), (8, 6));
    }
}

#[test]
fn a_cube_vanishes_at_half_its_side_and_not_before() {
    let body = convex_hull(&cube(2.0)).unwrap();
    assert_eq!(inscribed_ball(&body).radius, 1.0);
    assert_eq!(inward_offset(&body, 1.0).unwrap(), None);
    assert_eq!(inward_offset(&body, 1.0 + f64::EPSILON).unwrap(), None);
    let almost = 1.0 - f64::EPSILON * 1e5;
    let core = inward_offset(&body, almost).unwrap().unwrap();
    assert!((core.volume() / (2.0 - 2.0 * almost).powi(3) - 1.0).abs() < 1e-12);
    assert!(!matches!(inward_offset(&body, 1.0 - f64::EPSILON / 2.0), Ok(None)));
}
