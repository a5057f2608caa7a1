//! The area of a plane section of a body in every square of a grid, exact to rounding.

use crate::grid::Grid;
use meso_collision::geometry::{BodyForm, Polyhedron};
use meso_view::section::divide;
use std::ops::Range;

/// Distance of a section from the plane between voxels, over their spacing: a body that ends in the plane covers it from inside.
pub(crate) const WITHIN: f64 = 1e-9;

/// A point of a section: coordinates along the two axes of its plane, mm.
type Point = [f64; 2];

/// Memory that sections reuse.
#[derive(Default)]
pub(crate) struct Section {
    corners: Vec<Point>,
    strip: Vec<Point>,
    rest: Vec<Point>,
    piece: Vec<Point>,
    beyond: Vec<Point>,
}

/// A grid of rectangles in a plane.
pub(crate) struct Squares {
    pub(crate) origin: Point,
    pub(crate) spacing: Point,
    pub(crate) counts: [usize; 2],
}

impl Squares {
    /// Faces of a grid's voxels across `axis`.
    pub(crate) fn across(grid: &Grid, axis: usize) -> Self {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        Self {
            origin: [grid.origin[b], grid.origin[c]],
            spacing: [grid.spacing[b], grid.spacing[c]],
            counts: [grid.counts[b], grid.counts[c]],
        }
    }

    fn side(&self, axis: usize, number: usize) -> f64 {
        self.origin[axis] + number as f64 * self.spacing[axis]
    }

    /// The squares along an axis that the interval reaches into.
    pub(crate) fn touched(&self, axis: usize, low: f64, high: f64) -> Range<usize> {
        let at = |x: f64| ((x - self.origin[axis]) / self.spacing[axis]).max(0.0);
        let end = (at(high).ceil() as usize).min(self.counts[axis]);
        (at(low) as usize).min(end)..end
    }
}

impl Section {
    /// Calls `visit` with every square that the section of `body` by the plane at `at` on `axis` meets, and the share of
    /// the square that it covers. Squares are numbered with the axis after `axis` fastest.
    pub(crate) fn shares(
        &mut self,
        body: &Polyhedron,
        axis: usize,
        at: f64,
        squares: &Squares,
        mut visit: impl FnMut(usize, f64),
    ) {
        if body.form() == BodyForm::Surface {
            return shares_with_dents(body, axis, at, squares, visit);
        }
        self.cut(body, axis, at);
        if self.corners.len() < 3 {
            return;
        }
        let (low, high) = extent(&self.corners, 1);
        let whole = squares.spacing[0] * squares.spacing[1];
        for row in squares.touched(1, low, high) {
            let (bottom, top) = (squares.side(1, row), squares.side(1, row + 1));
            divide::<_, 2>(&self.corners, 1, bottom, &mut self.rest, &mut self.beyond);
            divide::<_, 2>(&self.beyond, 1, top, &mut self.strip, &mut self.rest);
            if self.strip.len() < 3 {
                continue;
            }
            let (left, right) = extent(&self.strip, 0);
            let (inner_left, inner_right) = inner(&self.strip, bottom, top);
            for column in squares.touched(0, left, right) {
                let (from, to) = (squares.side(0, column), squares.side(0, column + 1));
                let share = if from >= inner_left && to <= inner_right {
                    1.0
                } else {
                    divide::<_, 2>(&self.strip, 0, from, &mut self.rest, &mut self.beyond);
                    divide::<_, 2>(&self.beyond, 0, to, &mut self.piece, &mut self.rest);
                    (area(&self.piece) / whole).clamp(0.0, 1.0)
                };
                visit(row * squares.counts[0] + column, share);
            }
        }
    }

    /// The corners of the section just above the plane, counter-clockwise: of two bodies that touch there, one is cut.
    fn cut(&mut self, body: &Polyhedron, axis: usize, at: f64) {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let points = &mut self.rest;
        points.clear();
        let vertices = body.vertices();
        for face in body.faces() {
            for (from, to) in face.iter().zip(face.iter().cycle().skip(1)) {
                let (p, q) = (&vertices[from as usize], &vertices[to as usize]);
                // Each edge belongs to two faces, and runs upwards in one of them.
                if p[axis] <= at && q[axis] > at {
                    let t = (at - p[axis]) / (q[axis] - p[axis]);
                    points.push([p[b] + t * (q[b] - p[b]), p[c] + t * (q[c] - p[c])]);
                }
            }
        }
        hull(points, &mut self.corners);
    }
}

/// [`Section::shares`] of a body with dents, whose section may have any number of loops.
///
/// By Green's theorem the area in a square is the sum over the section's edges of the integral of x dy, with x clamped
/// to the square's width and counted from its left side, over the square's height.
fn shares_with_dents(body: &Polyhedron, axis: usize, at: f64, squares: &Squares, mut visit: impl FnMut(usize, f64)) {
    let edges = edges_of_section(body, axis, at);
    let (low, high) = extent(edges.as_flattened(), 1);
    let (left, right) = extent(edges.as_flattened(), 0);
    let (rows, columns) = (squares.touched(1, low, high), squares.touched(0, left, right));
    let mut areas = vec![0.0; rows.len() * columns.len()];
    for [from, to] in &edges {
        let way = [to[0] - from[0], to[1] - from[1]];
        for row in squares.touched(1, from[1].min(to[1]), from[1].max(to[1])) {
            let (bottom, top) = (squares.side(1, row), squares.side(1, row + 1));
            // The part of the edge within the row; a level edge adds nothing.
            let share = |y: f64| if way[1] == 0.0 { 0.0 } else { (y.clamp(bottom, top) - from[1]) / way[1] };
            let [first, last] = [share(from[1]), share(to[1])].map(|share| from[0] + share * way[0]);
            let rise = to[1].clamp(bottom, top) - from[1].clamp(bottom, top);
            for column in columns.clone() {
                let width = mean_clamped(first, last, squares.side(0, column), squares.side(0, column + 1));
                areas[(row - rows.start) * columns.len() + column - columns.start] += width * rise;
            }
        }
    }
    let whole = squares.spacing[0] * squares.spacing[1];
    for (number, area) in areas.iter().enumerate().filter(|(_, area)| **area > 0.0) {
        let (row, column) = (rows.start + number / columns.len(), columns.start + number % columns.len());
        visit(row * squares.counts[0] + column, (area / whole).min(1.0));
    }
}

/// The edges of a section just above the plane, with the section on their left.
fn edges_of_section(body: &Polyhedron, axis: usize, at: f64) -> Vec<[Point; 2]> {
    let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
    let vertices = body.vertices();
    let mut edges = Vec::new();
    for triangle in body.triangles() {
        let (mut upwards, mut downwards) = (None, None);
        for k in 0..3 {
            let [p, q] = [triangle[k], triangle[(k + 1) % 3]].map(|corner| &vertices[corner as usize]);
            if (p[axis] <= at) != (q[axis] <= at) {
                let (low, high) = if p[axis] <= at { (p, q) } else { (q, p) };
                let t = (at - low[axis]) / (high[axis] - low[axis]);
                let point = Some([low[b] + t * (high[b] - low[b]), low[c] + t * (high[c] - low[c])]);
                *(if p[axis] <= at { &mut upwards } else { &mut downwards }) = point;
            }
        }
        edges.extend(downwards.zip(upwards).map(|(from, to)| [from, to]));
    }
    edges
}

/// Mean over x from `first` to `last` of x clamped to `left` and `right`, counted from `left`.
fn mean_clamped(first: f64, last: f64, left: f64, right: f64) -> f64 {
    let width = right - left;
    let sum = |x: f64| {
        let within = (x - left).clamp(0.0, width);
        within * within / 2.0 + width * (x - right).max(0.0)
    };
    let way = last - first;
    if way.abs() < 1e-6 * width {
        return ((first + last) / 2.0 - left).clamp(0.0, width);
    }
    (sum(last) - sum(first)) / way
}

/// Least and largest coordinate.
fn extent(points: &[Point], axis: usize) -> (f64, f64) {
    points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p[axis]), high.max(p[axis])))
}

/// The interval that a strip covers over its whole height; empty where it does not reach both sides.
fn inner(strip: &[Point], bottom: f64, top: f64) -> (f64, f64) {
    let at = |y: f64| {
        let met = strip.iter().filter(|p| p[1] == y);
        met.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p[0]), high.max(p[0])))
    };
    let (below, above) = (at(bottom), at(top));
    (below.0.max(above.0), below.1.min(above.1))
}

fn area(polygon: &[Point]) -> f64 {
    let Some((first, rest)) = polygon.split_first() else { return 0.0 };
    let spans = rest.windows(2).map(|pair| {
        let (a, b) = (pair[0], pair[1]);
        (a[0] - first[0]) * (b[1] - first[1]) - (a[1] - first[1]) * (b[0] - first[0])
    });
    spans.sum::<f64>() / 2.0
}

/// The convex hull of points, counter-clockwise (Andrew's monotone chain).
fn hull(points: &mut [Point], corners: &mut Vec<Point>) {
    points.sort_unstable_by(|p, q| p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])));
    corners.clear();
    chain(points.iter(), corners, 0);
    let first = corners.len().saturating_sub(1);
    chain(points.iter().rev(), corners, first);
    corners.pop();
}

/// Appends a chain that turns left, and keeps the corners before `start`.
fn chain<'a>(points: impl Iterator<Item = &'a Point>, corners: &mut Vec<Point>, start: usize) {
    corners.truncate(start);
    for &p in points {
        while corners.len() >= start + 2 {
            let (o, a) = (corners[corners.len() - 2], corners[corners.len() - 1]);
            if (a[0] - o[0]) * (p[1] - o[1]) - (a[1] - o[1]) * (p[0] - o[0]) > 0.0 {
                break;
            }
            corners.pop();
        }
        corners.push(p);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_collision::geometry::convex_hull;
    use meso_collision::math::Vec3;

    /// Shares of the section of a box turned about x by 45 degrees, at x = 0.
    fn shares(counts: [usize; 2], spacing: f64) -> Vec<f64> {
        let corners = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
        let at = |x: f64| corners.map(|[y, z]| Vec3::new(x, y + 1.5, z + 1.5));
        let body = convex_hull(&[at(-1.0), at(1.0)].concat()).unwrap();
        let squares = Squares { origin: [0.0; 2], spacing: [spacing; 2], counts };
        let mut shares = vec![0.0; counts[0] * counts[1]];
        Section::default().shares(&body, 0, 0.0, &squares, |square, share| shares[square] += share);
        shares
    }

    #[test]
    fn shares_of_a_turned_square_are_exact() {
        let shares = shares([3, 3], 1.0);
        let expected = [0.0, 0.25, 0.0, 0.25, 1.0, 0.25, 0.0, 0.25, 0.0];
        assert!(shares.iter().zip(expected).all(|(share, exact)| (share - exact).abs() < 1e-14), "{shares:?}");
    }

    #[test]
    fn shares_add_up_to_the_section() {
        let fine = shares([40, 30], 0.1);
        assert!((fine.iter().sum::<f64>() * 0.01 - 2.0).abs() < 1e-12);
        assert!(fine.iter().filter(|share| **share == 1.0).count() > 100);
    }
}
