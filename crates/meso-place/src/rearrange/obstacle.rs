//! Fixed bodies around non-convex specimens, and how they push grains.

use super::contact::{FoundContact, LANES, Points, direction_or_up, gap_along};
use meso_collision::math::Vec3;
use meso_concrete::specimen::Obstacle;

/// Vertices about a point, padded.
struct PaddedVertices {
    coordinates: [Vec<f32>; 3],
}

impl PaddedVertices {
    fn new(vertices: &[Vec3], origin: &Vec3) -> Self {
        let padded = vertices.len().next_multiple_of(LANES);
        let along = |axis: usize| {
            let all = vertices.iter().map(move |v| (v[axis] - origin[axis]) as f32);
            all.chain(std::iter::repeat((vertices[0][axis] - origin[axis]) as f32)).take(padded).collect()
        };
        Self { coordinates: [along(0), along(1), along(2)] }
    }

    fn points(&self) -> Points<'_> {
        let [x, y, z] = &self.coordinates;
        Points { x, y, z }
    }
}

/// The displacement, mm, that brings a body (its vertices about `centre`) to a distance of `gap` mm from `obstacle`;
/// zero where it has that. Where the obstacle forbids the shortest direction, it pushes back over its own plane.
pub(super) fn push(body: &Points, centre: &Vec3, obstacle: &Obstacle, gap: f64) -> Vec3 {
    let (direction, lacking) = shortest(body, centre, obstacle.points, gap);
    if lacking <= 0.0 {
        return Vec3::zeros();
    }
    let Some(outward) = obstacle.outward.first().filter(|_| !leads_against(&direction, obstacle.outward)) else {
        return direction * lacking;
    };
    let from_plane = |i: usize| {
        let vertex = Vec3::new(f64::from(body.x[i]), f64::from(body.y[i]), f64::from(body.z[i]));
        outward.dot(&(vertex + centre - obstacle.points[0]))
    };
    let beyond = (0..body.x.len()).map(from_plane).fold(f64::NEG_INFINITY, f64::max);
    outward * -(beyond + gap).max(0.0)
}

/// A direction is forbidden when it differs by less than this from a combination of the outward normals.
const AWAY: f64 = 0.1;
/// Rounds of the search for that sum.
const ROUNDS: usize = 30;

/// True when the unit vector `direction` is nearly a combination of the reversed normals.
fn leads_against(direction: &Vec3, normals: &[Vec3]) -> bool {
    let mut parts = vec![0.0f64; normals.len()];
    let mut rest = *direction;
    for _ in 0..ROUNDS {
        for (part, normal) in parts.iter_mut().zip(normals) {
            let better = (*part - normal.dot(&rest)).max(0.0);
            rest += normal * (better - *part);
            *part = better;
        }
        if rest.norm() < AWAY {
            return true;
        }
    }
    false
}

/// The shortest direction off an obstacle, of unit length, and how far it is to `gap` mm of distance, mm.
fn shortest(body: &Points, centre: &Vec3, obstacle: &[Vec3], gap: f64) -> (Vec3, f64) {
    // Contacts are found by moving the bodies apart about their origins. The obstacle's origin is its point nearest
    // to the body, so its extent does not matter.
    let origin = nearest(obstacle, centre);
    let about = PaddedVertices::new(obstacle, &origin);
    let contact = contact(&about.points(), body, &(centre - origin));
    (Vec3::from_fn(|i, _| f64::from(contact.normal[i])), gap - f64::from(contact.gap))
}

/// Distance from a point to an obstacle, mm; 0 where the obstacle holds it.
pub(super) fn distance(obstacle: &[Vec3], point: &Vec3) -> f64 {
    let middle = obstacle.iter().sum::<Vec3>() / obstacle.len() as f64;
    let zeros = [0.0; LANES];
    let alone = Points { x: &zeros, y: &zeros, z: &zeros };
    f64::from(contact(&PaddedVertices::new(obstacle, &middle).points(), &alone, &(point - middle)).gap.max(0.0))
}

/// A point of the obstacle near to the nearest to `point`; its middle where it holds the point.
fn nearest(obstacle: &[Vec3], point: &Vec3) -> Vec3 {
    let middle = obstacle.iter().sum::<Vec3>() / obstacle.len() as f64;
    let about = PaddedVertices::new(obstacle, &middle);
    let zeros = [0.0; LANES];
    let alone = Points { x: &zeros, y: &zeros, z: &zeros };
    let contact = contact(&about.points(), &alone, &(point - middle));
    if contact.gap <= 0.0 {
        return middle;
    }
    middle + Vec3::from_fn(|i, _| f64::from(contact.on_a[i]))
}

fn contact(a: &Points, b: &Points, x: &Vec3) -> FoundContact {
    let x = [x.x as f32, x.y as f32, x.z as f32];
    let mut contact = FoundContact::towards(direction_or_up(x));
    contact.gap = gap_along(a, b, x, contact.normal);
    contact.refresh(a, b, x, x);
    contact
}
