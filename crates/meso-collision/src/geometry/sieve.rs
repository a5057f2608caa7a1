//! The sieve size: the width of the smallest square hole that a grain passes.
//!
//! A grain falls through lengthwise. So the grain is projected along the principal axis of its smallest moment of
//! inertia, and its size is the side of the smallest square, turned at will, around that projection. (The true minimum
//! over all directions is at most this, 3 % less in the mean of 40 of the paper's polyhedra and 13 % less of one of
//! them, by 600 random directions each; finding it is costlier than making the grain, and sieving itself scatters by
//! more.)

use super::Polyhedron;
use crate::math::Mat3;
use nalgebra::Vector2;

type Vec2 = Vector2<f64>;

impl Polyhedron {
    /// Side of the smallest square hole that the body passes lengthwise, mm.
    pub fn sieve_size(&self) -> f64 {
        let axes = principal_axes(&self.mass_properties().inertia);
        let (u, v) = (axes.column(1).into_owned(), axes.column(2).into_owned());
        let mut shadow: Vec<Vec2> = self.vertices().iter().map(|p| Vec2::new(u.dot(p), v.dot(p))).collect();
        smallest_square(&outline(&mut shadow))
    }
}

/// Unit eigenvectors of a symmetric tensor as columns, by ascending eigenvalue (for an inertia tensor: the longest axis
/// of the body first).
///
/// Jacobi's method: it needs no trigonometric function, so it gives the same bits everywhere.
pub fn principal_axes(tensor: &Mat3) -> Mat3 {
    let (mut diagonal, mut axes) = (*tensor, Mat3::identity());
    // Six sweeps square the off-diagonal part far below rounding; more change nothing.
    for _ in 0..6 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let turn = jacobi_rotation(&diagonal, p, q);
            diagonal = turn.transpose() * diagonal * turn;
            axes *= turn;
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| diagonal[(i, i)].total_cmp(&diagonal[(j, j)]));
    Mat3::from_columns(&order.map(|k| axes.column(k).into_owned()))
}

/// The rotation in the plane (p, q) that makes the element (p, q) zero.
fn jacobi_rotation(a: &Mat3, p: usize, q: usize) -> Mat3 {
    let mut turn = Mat3::identity();
    if a[(p, q)] != 0.0 {
        let theta = (a[(q, q)] - a[(p, p)]) / (2.0 * a[(p, q)]);
        let tangent = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
        let cos = 1.0 / (tangent * tangent + 1.0).sqrt();
        let sin = tangent * cos;
        (turn[(p, p)], turn[(q, q)], turn[(p, q)], turn[(q, p)]) = (cos, cos, sin, -sin);
    }
    turn
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

#[cfg(test)]
mod tests {
    use super::*;

    fn square_by_scanning(outline: &[Vec2]) -> f64 {
        let turn = |k: u32| f64::from(k) * std::f64::consts::FRAC_PI_2 / 20_000.0;
        (0..20_000).map(|k| side_at(outline, &Vec2::new(turn(k).cos(), turn(k).sin()))).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn the_smallest_square_is_the_one_that_scanning_finds() {
        for corners in 3..40_u32 {
            let at = |k: u32| f64::from(k * k * 37 % 101) + f64::from(k) * 0.1;
            let mut points: Vec<Vec2> = (0..corners).map(|k| Vec2::new(at(k), at(k + corners) * 0.6)).collect();
            let outline = outline(&mut points);
            let (found, scanned) = (smallest_square(&outline), square_by_scanning(&outline));
            assert!(found <= scanned + 1e-9 && found > scanned - 0.02, "{corners} corners: {found}, {scanned}");
        }
    }
}
