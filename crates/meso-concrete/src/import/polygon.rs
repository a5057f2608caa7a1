//! Polygons as triangles, convex or not.
//!
//! A polygon is seen along the axis that its normal is nearest to (Newell's, the mean over all corners). If all triangles
//! from its first corner then turn the same way, they are taken. Otherwise ears are cut off (G. H. Meisters, Polygons Have
//! Ears, 1975): triangles of three corners in a row that hold no other corner.

use crate::stop;
use meso_collision::math::Vec3;
use robust::{Coord, orient2d};
use std::cell::Cell;

/// Divides polygons into triangles, and counts those that had a fault.
#[derive(Clone, Copy, Debug, Default)]
pub struct Polygons {
    /// How many are not plane, and the farthest that a corner of them is off the mean plane, as a share of the polygon's size.
    bent: (usize, f64),
    /// How many have edges that cross.
    crossing: usize,
}

/// A polygon is plane if its corners are off their mean plane by less than this share of its size.
const PLANE: f64 = 0.01;

impl Polygons {
    /// The triangles of a polygon, as numbers of its corners; none of fewer than three corners.
    pub fn triangles(&mut self, corners: &[Vec3]) -> Vec<[usize; 3]> {
        let fan: Vec<[usize; 3]> = (2..corners.len()).map(|k| [0, k - 1, k]).collect();
        if corners.len() < 4 {
            return fan;
        }
        let normal = newell(corners);
        let bent = bent(corners, &normal);
        if bent > PLANE {
            self.bent = (self.bent.0 + 1, self.bent.1.max(bent));
        }
        let seen: Vec<Coord<f64>> = corners.iter().map(|corner| view(corner, &normal)).collect();
        let turn = |&[a, b, c]: &[usize; 3]| orient2d(seen[a], seen[b], seen[c]);
        if fan.iter().all(|triangle| turn(triangle) > 0.0) {
            return fan;
        }
        // Corners in a row would give flat triangles, which ears have not.
        ears(&seen).unwrap_or_else(|| {
            self.crossing += usize::from(fan.iter().any(|triangle| turn(triangle) < 0.0));
            fan
        })
    }

    /// Remarks about the polygons so far.
    pub fn notes(&self) -> impl Iterator<Item = String> + use<> {
        let Self { bent: (bent, most), crossing } = *self;
        let percent = 100.0 * most;
        let bent = (bent > 0).then(|| {
            format!("{bent} polygon(s) are not plane, by up to {percent:.1} % of their size; they were divided into triangles")
        });
        let crossing = (crossing > 0)
            .then(|| format!("{crossing} polygon(s) have edges that cross; they were divided from their first corner"));
        bent.into_iter().chain(crossing)
    }
}

/// Twice the area of the polygon along each axis.
fn newell(corners: &[Vec3]) -> Vec3 {
    let first = corners[0];
    corners.windows(2).map(|pair| (pair[0] - first).cross(&(pair[1] - first))).sum()
}

/// A point along the axis that the normal is nearest to; the polygon turns to the left.
fn view(point: &Vec3, normal: &Vec3) -> Coord<f64> {
    let axis = normal.iamax();
    let (x, y) = (point[(axis + 1) % 3], point[(axis + 2) % 3]);
    if normal[axis] < 0.0 { Coord { x: y, y: x } } else { Coord { x, y } }
}

/// The farthest that a corner is off the plane through their mean, as a share of the polygon's size.
fn bent(corners: &[Vec3], normal: &Vec3) -> f64 {
    let mean = corners.iter().sum::<Vec3>() / corners.len() as f64;
    let most = |of: &dyn Fn(Vec3) -> f64| corners.iter().map(|corner| of(corner - mean)).fold(0.0, f64::max);
    let size = 2.0 * most(&|away| away.norm());
    let Some(normal) = normal.try_normalize(0.0).filter(|_| size > 0.0) else { return 0.0 };
    most(&|away| normal.dot(&away).abs()) / size
}

/// The ears of a polygon; `None` where its edges cross.
fn ears(seen: &[Coord<f64>]) -> Option<Vec<[usize; 3]>> {
    let (mut left, mut triangles) = (Left::new(seen), Vec::with_capacity(seen.len() - 2));
    // The next ear is looked for behind the last one, so that a long row of corners gives no fan of needles.
    let mut from = 0;
    for count in (4..=seen.len()).rev() {
        stop::point();
        let all = std::iter::successors(Some(from), |&corner| Some(left.next[corner])).take(count);
        let ear = { all }.find(|&corner| left.is_ear(corner))?;
        triangles.push(left.around(ear));
        from = left.cut(ear);
    }
    let last: Vec<usize> = (0..seen.len()).filter(|&corner| left.is_there[corner]).collect();
    let [a, b, c] = last[..] else { return None };
    triangles.push([a, b, c]);
    (orient2d(seen[a], seen[b], seen[c]) >= 0.0).then_some(triangles)
}

/// The corners of a polygon that are left, in a ring, and in a grid of squares of about as many as there are corners.
struct Left<'a> {
    seen: &'a [Coord<f64>],
    next: Vec<usize>,
    before: Vec<usize>,
    is_there: Vec<bool>,
    /// A corner in the triangle of this one, which is no ear as long as that one and its neighbours are there.
    within: Vec<Cell<Option<usize>>>,
    squares: CornerSquares,
}

impl<'a> Left<'a> {
    fn new(seen: &'a [Coord<f64>]) -> Self {
        let count = seen.len();
        Self {
            next: (0..count).map(|corner| (corner + 1) % count).collect(),
            before: (0..count).map(|corner| (corner + count - 1) % count).collect(),
            is_there: vec![true; count],
            within: vec![Cell::new(None); count],
            squares: CornerSquares::new(seen),
            seen,
        }
    }

    /// A corner with those before and behind it.
    fn around(&self, corner: usize) -> [usize; 3] {
        [self.before[corner], corner, self.next[corner]]
    }

    /// Takes a corner away; the one behind it.
    fn cut(&mut self, corner: usize) -> usize {
        let [before, _, next] = self.around(corner);
        (self.next[before], self.before[next], self.is_there[corner]) = (next, before, false);
        [before, next].into_iter().for_each(|neighbour| self.within[neighbour].set(None));
        next
    }

    /// True where the polygon turns to the left at a corner, and the triangle there holds no other corner.
    fn is_ear(&self, corner: usize) -> bool {
        if self.within[corner].get().is_some_and(|other| self.is_there[other]) {
            return false;
        }
        let [a, b, c] = self.around(corner).map(|corner| self.seen[corner]);
        if orient2d(a, b, c) <= 0.0 {
            return false;
        }
        let sides = [(a, b), (b, c), (c, a)];
        let holds = |other: usize| {
            let p = self.seen[other];
            let is_corner = [a, b, c].contains(&p);
            self.is_there[other] && !is_corner && sides.into_iter().all(|(from, to)| orient2d(from, to, p) >= 0.0)
        };
        self.within[corner].set(self.squares.about([a, b, c]).find(|&other| holds(other)));
        self.within[corner].get().is_none()
    }
}

/// Corners by the square that they lie in.
struct CornerSquares {
    min: Coord<f64>,
    /// CornerSquares per unit along x and y.
    per_unit: [f64; 2],
    /// CornerSquares along an edge.
    side: usize,
    /// The corners of square s are `corners[starts[s]..starts[s + 1]]`.
    starts: Vec<usize>,
    corners: Vec<usize>,
}

impl CornerSquares {
    fn new(seen: &[Coord<f64>]) -> Self {
        let side = seen.len().isqrt().max(1);
        let range = |of: fn(&Coord<f64>) -> f64| {
            seen.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
        };
        let [x, y] = [range(|p| p.x), range(|p| p.y)];
        let per_unit = [x, y].map(|(low, high)| side as f64 / (high - low));
        let mut squares = Self {
            min: Coord { x: x.0, y: y.0 },
            per_unit,
            side,
            starts: vec![0; side * side + 1],
            corners: Vec::new(),
        };
        let square = |p: &Coord<f64>| squares.column(p.x) + side * squares.row(p.y);
        let at: Vec<usize> = seen.iter().map(square).collect();
        at.iter().for_each(|square| squares.starts[square + 1] += 1);
        (0..side * side).for_each(|square| squares.starts[square + 1] += squares.starts[square]);
        let mut free = squares.starts.clone();
        squares.corners = vec![0; seen.len()];
        for (corner, square) in at.into_iter().enumerate() {
            squares.corners[free[square]] = corner;
            free[square] += 1;
        }
        squares
    }

    /// The square that holds a coordinate; a polygon without extent, or with coordinates that are no numbers, has one.
    fn place(&self, at: f64, low: f64, axis: usize) -> usize {
        (((at - low) * self.per_unit[axis]) as usize).min(self.side - 1)
    }

    fn column(&self, x: f64) -> usize {
        self.place(x, self.min.x, 0)
    }

    fn row(&self, y: f64) -> usize {
        self.place(y, self.min.y, 1)
    }

    /// The corners in the squares about a triangle.
    fn about(&self, [a, b, c]: [Coord<f64>; 3]) -> impl Iterator<Item = usize> {
        let columns = [a, b, c].map(|p| self.column(p.x));
        let rows = [a, b, c].map(|p| self.row(p.y));
        let range = |[a, b, c]: [usize; 3]| a.min(b).min(c)..=a.max(b).max(c);
        let columns = range(columns);
        range(rows).flat_map(move |row| {
            let [from, to] = [*columns.start(), columns.end() + 1].map(|column| self.starts[column + self.side * row]);
            self.corners[from..to].iter().copied()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[Vec3], triangles: &[[usize; 3]]) -> (f64, Vec3) {
        let of = |t: &[usize; 3]| (corners[t[1]] - corners[t[0]]).cross(&(corners[t[2]] - corners[t[0]])) / 2.0;
        (triangles.iter().map(|t| of(t).norm()).sum(), triangles.iter().map(of).sum())
    }

    /// A star of `tips` tips in a plane across (1, 2, 3), and its area.
    fn star(tips: usize, inner: f64) -> (Vec<Vec3>, f64) {
        let [u, v] = [Vec3::new(2.0, -1.0, 0.0).normalize(), Vec3::new(3.0, 6.0, -5.0).normalize()];
        let angle = std::f64::consts::PI / tips as f64;
        let corner = |k: usize| {
            let radius = if k.is_multiple_of(2) { 1.0 } else { inner };
            (u * (angle * k as f64).cos() + v * (angle * k as f64).sin()) * radius
        };
        ((0..2 * tips).map(corner).collect(), tips as f64 * inner * angle.sin())
    }

    #[test]
    fn triangles_cover_a_concave_polygon_once_wherever_it_begins() {
        for (tips, inner) in [(3, 0.2), (5, 0.4), (17, 0.9), (40, 0.1)] {
            let (mut corners, expected) = star(tips, inner);
            for _ in 0..2 * tips {
                corners.rotate_left(1);
                for is_back in [false, true] {
                    let corners: Vec<Vec3> =
                        if is_back { corners.iter().rev().copied().collect() } else { corners.clone() };
                    let mut polygons = Polygons::default();
                    let triangles = polygons.triangles(&corners);
                    let (area, sum) = area(&corners, &triangles);
                    assert_eq!(triangles.len(), corners.len() - 2);
                    assert!((area / expected - 1.0).abs() < 1e-9 && (sum.norm() / expected - 1.0).abs() < 1e-9);
                    assert_eq!(polygons.notes().count(), 0);
                }
            }
        }
    }

    #[test]
    fn convex_polygons_are_fans_and_corners_in_a_row_give_no_flat_triangles() {
        let (hexagon, _) = star(3, 1.0);
        assert_eq!(Polygons::default().triangles(&hexagon), [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]);
        // A square and an L, both with corners within edges.
        let square = vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [0.0, 1.0]];
        let angle = vec![[1.0, 1.0], [1.0, 2.0], [0.0, 2.0], [0.0, 1.0], [0.0, 0.0], [2.0, 0.0], [2.0, 1.0]];
        for (mut corners, expected) in [(square, 4.0), (angle, 3.0)] {
            for _ in 0..corners.len() {
                corners.rotate_left(1);
                let corners: Vec<Vec3> = corners.iter().map(|&[x, y]| Vec3::new(0.0, x, y)).collect();
                let triangles = Polygons::default().triangles(&corners);
                assert!((area(&corners, &triangles).0 - expected).abs() < 1e-12, "{triangles:?}");
                assert!(
                    triangles.len() == corners.len() - 2 && triangles.iter().all(|t| area(&corners, &[*t]).0 > 0.1)
                );
            }
        }
        let line = [0.0, 1.0, 2.0, 3.0].map(|x| Vec3::new(x, 0.0, 0.0));
        assert_eq!(Polygons::default().triangles(&line), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn bow_ties_and_bent_squares_are_divided_with_a_remark() {
        let mut polygons = Polygons::default();
        let bow = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 3.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
        assert_eq!(polygons.triangles(&bow), [[0, 1, 2], [0, 2, 3]]);
        let bent = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.2], [1.0, 1.0, 0.0], [0.0, 1.0, 0.2]].map(Vec3::from);
        assert_eq!(polygons.triangles(&bent), [[0, 1, 2], [0, 2, 3]]);
        let notes: Vec<String> = polygons.notes().collect();
        assert_eq!(
            notes,
            [
                "1 polygon(s) are not plane, by up to 7.0 % of their size; they were divided into triangles",
                "1 polygon(s) have edges that cross; they were divided from their first corner"
            ]
        );
    }

    /// The case `polygons.py`: 2,000 corners took 7 s, 16,000 more than 70 s; half of them point inwards here.
    #[test]
    fn a_polygon_of_many_corners_is_divided_in_time() {
        let (mut corners, expected) = star(20_000, 0.98);
        corners.iter_mut().enumerate().for_each(|(k, corner)| *corner *= 1.0 + 0.01 * (0.3 * k as f64).sin());
        let triangles = Polygons::default().triangles(&corners);
        let (area, sum) = area(&corners, &triangles);
        assert_eq!(triangles.len(), corners.len() - 2);
        assert!((area / sum.norm() - 1.0).abs() < 1e-9 && (area / expected - 1.0).abs() < 0.01, "{area} {expected}");
    }

    #[test]
    fn a_ring_cut_open_along_a_bridge_has_its_area() {
        let ring = [
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 3.0],
            [0.0, 3.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [2.0, 2.0],
            [2.0, 1.0],
            [1.0, 1.0],
        ];
        let corners = ring.map(|[x, y]| Vec3::new(x, y, 1.0));
        let triangles = Polygons::default().triangles(&corners);
        assert!((area(&corners, &triangles).0 - 8.0).abs() < 1e-12 && triangles.len() == 8, "{triangles:?}");
    }
}
