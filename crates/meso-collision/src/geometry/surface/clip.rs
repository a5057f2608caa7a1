//! The part of a convex polyhedron on one side of a plane across an axis.

use crate::geometry::{HullError, Polyhedron, convex_hull};
use crate::math::{Aabb, Vec3};

/// The part of `body` inside the closed box `domain`, or `None` where that has no volume.
///
/// Both parts of a body that a plane divides have the same corners on it, bit for bit.
pub fn clipped(body: &Polyhedron, domain: &Aabb) -> Option<Polyhedron> {
    let aabb = body.aabb();
    let mut part = body.clone();
    for axis in 0..3 {
        // An infinite side, or one that the body does not reach, cuts nothing.
        if aabb.min[axis] < domain.min[axis] {
            part = half(&part, axis, domain.min[axis], -1.0)?;
        }
        if aabb.max[axis] > domain.max[axis] {
            part = half(&part, axis, domain.max[axis], 1.0)?;
        }
    }
    Some(part)
}

/// The part where `side * x[axis] <= side * at`.
fn half(body: &Polyhedron, axis: usize, at: f64, side: f64) -> Option<Polyhedron> {
    let inside = |v: &Vec3| side * v[axis] <= side * at;
    let mut points: Vec<Vec3> = body.vertices().iter().filter(|v| inside(v)).copied().collect();
    for face in body.faces() {
        for k in 0..face.len() {
            let [from, to] = [k, (k + 1) % face.len()].map(|k| body.vertices()[face.vertex(k) as usize]);
            // Every edge is passed in both directions; upwards it counts, whichever part is asked for.
            if from[axis] < at && to[axis] > at {
                let mut point = from + (to - from) * ((at - from[axis]) / (to[axis] - from[axis]));
                point[axis] = at;
                points.push(point);
            }
        }
    }
    match convex_hull(&points) {
        Ok(part) => Some(part),
        Err(HullError::Empty | HullError::LowerDimensional { .. }) => None,
        Err(HullError::NotFinite { .. } | HullError::OutOfRange { .. }) => {
            unreachable!("points between the vertices of a body are within its range")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn octahedron() -> Polyhedron {
        let ends: Vec<Vec3> = (0..3).flat_map(|i| [Vec3::ith(i, 2.0), Vec3::ith(i, -2.0)]).collect();
        convex_hull(&ends).unwrap()
    }

    #[test]
    fn the_parts_of_a_body_add_up_and_share_their_cut() {
        let body = octahedron().translated(&Vec3::new(0.1, 0.2, 0.3));
        let whole = Aabb { min: Vec3::repeat(-9.0), max: Vec3::repeat(9.0) };
        let low = clipped(&body, &Aabb { max: Vec3::new(0.7, 9.0, 9.0), ..whole }).unwrap();
        let high = clipped(&body, &Aabb { min: Vec3::new(0.7, -9.0, -9.0), ..whole }).unwrap();
        assert!((low.volume() + high.volume() - body.volume()).abs() < 1e-13);
        let cut = |part: &Polyhedron| {
            let mut corners: Vec<[u64; 2]> =
                part.vertices().iter().filter(|v| v.x == 0.7).map(|v| [v.y.to_bits(), v.z.to_bits()]).collect();
            corners.sort_unstable();
            corners
        };
        assert_eq!(cut(&low).len(), 4);
        assert_eq!(cut(&low), cut(&high));
    }

    #[test]
    fn a_body_outside_or_only_touching_has_no_part() {
        let domain = Aabb { min: Vec3::new(2.0, -9.0, -9.0), max: Vec3::repeat(9.0) };
        assert_eq!(clipped(&octahedron(), &domain), None);
        assert_eq!(clipped(&octahedron(), &Aabb { min: Vec3::new(3.0, -9.0, -9.0), ..domain }), None);
    }
}
