//! The smallest square around a projection of a body, by rotating calipers; and over all directions, by brute force.

use crate::dice::Dice;
use meso_collision::math::Vec3;
use nalgebra::Vector2;

type Vec2 = Vector2<f64>;

/// Side of the smallest square around the projection of the points along `direction`.
pub(crate) fn smallest_square_along(points: &[Vec3], direction: &Vec3) -> f64 {
    let u = direction.cross(&Vec3::ith(direction.iamin(), 1.0)).normalize();
    let v = direction.cross(&u).normalize();
    let mut shadow: Vec<Vec2> = points.iter().map(|p| Vec2::new(u.dot(p), v.dot(p))).collect();
    smallest_square(&outline(&mut shadow))
}

/// The smallest square that is found from `starts` random directions, of which the best are polished: a fiftieth, at least
/// eight.
pub(crate) fn by_brute_force(points: &[Vec3], dice: &mut Dice, starts: usize) -> f64 {
    let mut tried: Vec<(f64, Vec3)> = (0..starts)
        .map(|_| dice.direction())
        .map(|direction| (smallest_square_along(points, &direction), direction))
        .collect();
    tried.sort_by(|p, q| p.0.total_cmp(&q.0));
    tried.iter().take((starts / 50).max(8)).map(|start| polished(points, dice, *start)).fold(f64::INFINITY, f64::min)
}

/// A local minimum near a direction: random steps, halved whenever forty in a row fail.
fn polished(points: &[Vec3], dice: &mut Dice, (mut least, mut best): (f64, Vec3)) -> f64 {
    let (mut step, mut failures) = (0.1, 0);
    while step > 1e-10 {
        let direction = (best + dice.direction() * step).normalize();
        let side = smallest_square_along(points, &direction);
        failures = if side < least { 0 } else { failures + 1 };
        if side < least {
            (least, best, step) = (side, direction, 1.5 * step);
        }
        if failures == 40 {
            (step, failures) = (0.5 * step, 0);
        }
    }
    least
}

/// The convex hull of points in the plane, counter-clockwise (Andrew 1979).
fn outline(points: &mut [Vec2]) -> Vec<Vec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut hull: Vec<Vec2> = Vec::with_capacity(points.len() + 1);
    for chain in 0..2 {
        let start = hull.len();
        for k in 0..points.len() {
            let p = points[if chain == 0 { k } else { points.len() - 1 - k }];
            while hull.len() > start + 1 && !turns_left(&hull[hull.len() - 2], &hull[hull.len() - 1], &p) {
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
    }
    hull
}

fn turns_left(a: &Vec2, b: &Vec2, c: &Vec2) -> bool {
    (b - a).perp(&(c - b)) > 0.0
}

/// The side of the smallest square around a convex polygon.
///
/// Over the turns at which the same four corners touch, both widths are sines of the turn, concave: so the larger of
/// the two is smallest at an end of such a range (an edge lies on a side of the square) or where the widths are equal.
fn smallest_square(outline: &[Vec2]) -> f64 {
    let directions = quarter_turn_directions(outline);
    let mut best = f64::INFINITY;
    for (k, from) in directions.iter().enumerate() {
        let to = directions.get(k + 1).copied().unwrap_or_else(|| Vec2::new(-directions[0].y, directions[0].x));
        best = best.min(side_at(outline, from)).min(side_of_equal_widths(outline, from, &to));
    }
    best
}

/// The edges' directions turned by quarter turns into 0 to 90 degrees, ascending.
fn quarter_turn_directions(outline: &[Vec2]) -> Vec<Vec2> {
    let edge = |k: usize| (outline[(k + 1) % outline.len()] - outline[k]).try_normalize(0.0);
    let fold = |d: Vec2| {
        let d = if d.y < 0.0 || (d.y == 0.0 && d.x < 0.0) { -d } else { d };
        if d.x > 0.0 { d } else { Vec2::new(d.y, -d.x) }
    };
    let mut directions: Vec<Vec2> = (0..outline.len()).filter_map(edge).map(fold).collect();
    directions.sort_by(|a, b| a.y.total_cmp(&b.y));
    directions
}

/// The side of the smallest square around the outline whose sides are along `direction` and across it.
fn side_at(outline: &[Vec2], direction: &Vec2) -> f64 {
    let [along, across] = diameters(outline, direction);
    along.dot(direction).max(across.dot(&quarter_turn(direction)))
}

/// The side at the turn between two directions where both widths are the same, or infinity where there is none.
fn side_of_equal_widths(outline: &[Vec2], from: &Vec2, to: &Vec2) -> f64 {
    let Some(middle) = (from + to).try_normalize(0.0) else { return f64::INFINITY };
    // Corners that touch do not change in between: along . d = across . (d turned by 90 degrees) is linear in d.
    let [along, across] = diameters(outline, &middle);
    let balance = along - Vec2::new(across.y, -across.x);
    let Some(direction) = quarter_turn(&balance).try_normalize(0.0) else { return f64::INFINITY };
    let direction = if direction.dot(&middle) < 0.0 { -direction } else { direction };
    let between = from.perp(&direction) >= 0.0 && direction.perp(to) >= 0.0;
    if between { side_at(outline, &direction) } else { f64::INFINITY }
}

/// From the last to the first corner along `direction`, and across it.
fn diameters(outline: &[Vec2], direction: &Vec2) -> [Vec2; 2] {
    [*direction, quarter_turn(direction)].map(|d| {
        let key = |p: &&Vec2| d.dot(p);
        let highest = outline.iter().max_by(|p, q| key(p).total_cmp(&key(q)));
        let lowest = outline.iter().min_by(|p, q| key(p).total_cmp(&key(q)));
        highest.zip(lowest).map_or_else(Vec2::zeros, |(high, low)| high - low)
    })
}

fn quarter_turn(v: &Vec2) -> Vec2 {
    Vec2::new(-v.y, v.x)
}
