//! The distance of a point from the surface of a body.

use super::nearest::nearest_on_triangle;
use super::triangles::Triangles;
use crate::geometry::round::{FACETS, Round};
use crate::geometry::{BodyForm, Plane, Polyhedron};
use crate::math::Vec3;

/// The surface of a body, laid out for distances from points.
pub struct BodySurface {
    /// The triangles of its faces.
    triangles: Vec<[Vec3; 3]>,
    /// The plane of each triangle.
    planes: Vec<Plane>,
    /// Around each triangle: the ball's middle and radius, mm.
    balls: Vec<(Vec3, f64)>,
    /// The surface of a body with dents, whose hull has the triangles, planes and balls.
    dents: Option<Triangles>,
    /// A ball or an ellipsoid, with the triangles, planes and balls of facets around it.
    round: Option<Round>,
}

impl BodySurface {
    /// The surface of `body`.
    pub fn new(body: &Polyhedron) -> Self {
        match (body.form(), body.hull()) {
            (BodyForm::Round(round), _) => {
                let around = body.facets_grown(&round, FACETS.outwards);
                Self { round: Some(round), ..Self::of_convex(&around) }
            }
            (BodyForm::Surface, Ok(hull)) => Self { dents: Some(body.surface()), ..Self::of_convex(&hull) },
            (BodyForm::Hull | BodyForm::Surface, _) => Self::of_convex(body),
        }
    }

    fn of_convex(body: &Polyhedron) -> Self {
        let corners = |t: [u32; 3]| t.map(|i| body.vertices()[i as usize]);
        let pieces =
            body.faces().zip(body.planes()).flat_map(|(face, plane)| face.triangles().map(move |t| (t, plane)));
        let (triangles, planes): (Vec<_>, Vec<_>) = pieces.map(|(t, plane)| (corners(t), plane)).unzip();
        let balls = triangles.iter().map(ball_around).collect();
        Self { triangles, planes, balls, dents: None, round: None }
    }

    /// From `x` to the surface, mm: inside, the nearest plane; outside, the nearest of the triangles that face `x`.
    pub fn distance(&self, x: &Vec3) -> f64 {
        self.distance_below(x, f64::INFINITY).unwrap_or(f64::INFINITY)
    }

    /// The face plane that is farthest below `x`, or nearest above an inner one: an outer `x` is no nearer to the body
    /// than to it. The planes are those of the hull.
    pub fn plane_under(&self, x: &Vec3) -> &Plane {
        &self.planes[self.highest(x).0]
    }

    /// Returns [`BodySurface::distance`], or `None` where a face plane shows that an outer `x` is no nearer than
    /// `limit`.
    pub fn distance_below(&self, x: &Vec3, limit: f64) -> Option<f64> {
        if let Some(round) = &self.round {
            return Some(round.height(x).abs());
        }
        let (highest, most) = self.highest(x);
        if let Some(surface) = &self.dents {
            // Within the hull a plane tells nothing.
            let is_far = most > 0.0 && most * (1.0 - ROUNDING_OF_A_HEIGHT) >= limit;
            return if is_far { None } else { surface.nearest(x).map(|(_, distance)| distance) };
        }
        if most <= 0.0 {
            return Some(-most);
        }
        if most * (1.0 - ROUNDING_OF_A_HEIGHT) >= limit {
            return None;
        }
        let to = |triangle: usize| (nearest_on_triangle(&self.triangles[triangle], x) - x).norm();
        let mut least = to(highest);
        // Above the inside of the highest triangle, as most points are, nothing is nearer than it.
        if least <= most * (1.0 + ROUNDING_OF_A_HEIGHT) {
            return Some(least);
        }
        // A ball beyond the nearest point so far costs a third of its triangle, and most are.
        let reaches =
            |(middle, radius): &(Vec3, f64), least: f64| (middle - x).norm_squared() < (least + radius).powi(2);
        for (triangle, plane) in self.planes.iter().enumerate() {
            if (0.0..least).contains(&plane.height(x)) && reaches(&self.balls[triangle], least) {
                least = least.min(to(triangle));
            }
        }
        Some(least)
    }

    /// The triangle above whose plane `x` is highest, and that height, mm.
    fn highest(&self, x: &Vec3) -> (usize, f64) {
        let (mut highest, mut most) = (0, f64::NEG_INFINITY);
        for (triangle, plane) in self.planes.iter().enumerate() {
            let above = plane.height(x);
            if above > most {
                (highest, most) = (triangle, above);
            }
        }
        (highest, most)
    }
}

/// A share of a distance that its rounding does not reach.
const ROUNDING_OF_A_HEIGHT: f64 = 1e-12;

/// The middle of a triangle's corners, and a radius that holds them however it is rounded.
fn ball_around(corners: &[Vec3; 3]) -> (Vec3, f64) {
    let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    let radius = corners.iter().map(|corner| (corner - middle).norm()).fold(0.0, f64::max);
    (middle, radius * (1.0 + 1e-9))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::convex_hull;
    use crate::gjk;

    /// A body with faces of three, four and six corners, some at blunt angles.
    fn body() -> Vec<Vec3> {
        let (cos, sin) = (0.5, 0.75_f64.sqrt());
        let ring = [(1.0, 0.0), (cos, sin), (-cos, sin), (-1.0, 0.0), (-cos, -sin), (cos, -sin)];
        let layers = [(3.0, -2.0), (4.0, 0.0), (3.0, 1.0)];
        let mut points: Vec<Vec3> =
            layers.iter().flat_map(|(r, z)| ring.map(|(x, y)| Vec3::new(r * x + 7.0, r * y + 7.0, z + 7.0))).collect();
        points.push(Vec3::new(7.5, 6.8, 8.6));
        points
    }

    #[test]
    fn distances_are_those_of_gjk_outside_and_of_the_planes_inside() {
        let hull = convex_hull(&body()).unwrap();
        let body = BodySurface::new(&hull);
        let (mut above, mut beside) = (0, 0);
        for at in 0..17_usize.pow(3) {
            let x = Vec3::new((at % 17) as f64, (at / 17 % 17) as f64, (at / 289) as f64) * 0.83;
            let height = Plane::height_over(hull.planes(), &x);
            let exact = gjk::distance(&[x], hull.vertices()).unwrap();
            let expected = if height <= 0.0 { -height } else { exact };
            assert!((body.distance(&x) - expected).abs() < 1e-12, "{x:?}");
            above += usize::from(height > 0.0 && exact < height + 1e-12);
            beside += usize::from(height > 0.0 && exact > height + 1e-12);
        }
        assert!(above > 500 && beside > 2000, "{above} {beside}");
    }
}
