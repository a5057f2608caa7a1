//! Closed surfaces of triangles, convex or not: points inside, depths, rows, and the proof that two bodies are apart.
//!
//! Two bodies are apart exactly when no two of their triangles meet and neither holds a point of the other, as long as
//! each surface is connected. All answers but depths are exact: signs of determinants (crate `robust`) and the certified
//! collision test decide. Bodies are closed sets, so triangles that touch meet.

use crate::geometry::{Triangles, orient3d};
use crate::gjk;
use crate::math::{Aabb, Vec3};
use robust::{Coord, orient2d};

impl Triangles {
    /// True when the surface winds once around the point, or the point lies on it.
    pub fn contains(&self, point: &Vec3) -> bool {
        let mut sum = 0;
        for (t, turns, side) in self.windings(point) {
            if side == 0.0 && gjk::intersects(std::slice::from_ref(point), self.of(t)).unwrap_or(true) {
                return true;
            }
            sum += turns;
        }
        sum > 0
    }

    /// The triangles whose boxes reach above `point`, or hold it; how often each winds around the point, 1, 0 or -1;
    /// and on which side of its plane that is. Every one above or below counts by its orientation, edges to one of
    /// their two sides.
    pub fn windings(&self, point: &Vec3) -> impl Iterator<Item = (u32, i32, f64)> {
        let upwards = Aabb { min: *point, max: Vec3::new(point.x, point.y, f64::INFINITY) };
        let point = *point;
        self.meeting(upwards).map(move |t| {
            let [a, b, c] = self.of(t);
            let (turns, side) = (turns_around(&[*a, *b, *c], &point, 2), orient3d(a, b, c, &point));
            // An upward triangle with the point below it has the point on its inner side.
            let winds = (turns > 0 && side < 0.0) || (turns < 0 && side > 0.0);
            (t, if winds { turns } else { 0 }, side)
        })
    }

    /// From `point` to the surface, mm: positive inside, negative outside.
    pub fn depth(&self, point: &Vec3) -> f64 {
        let distance = self.nearest(point).map_or(f64::INFINITY, |(_, distance)| distance);
        if self.contains(point) { distance } else { -distance }
    }

    /// The parts of the line through (y, z) along x that lie in the body, ascending: pairs of coordinates, mm.
    pub fn row(&self, y: f64, z: f64) -> Vec<[f64; 2]> {
        let crossings = self.crossings(0, &Vec3::new(0.0, y, z), [f64::NEG_INFINITY, f64::INFINITY]);
        let crossings: Vec<f64> = crossings.into_iter().map(|(at, _)| at).collect();
        crossings.as_chunks().0.to_vec()
    }

    /// Where the line through a point along an axis crosses the surface within a range of that axis, ascending: the
    /// coordinate, mm, and the component of the outward normal along the axis.
    pub fn crossings(&self, axis: usize, through: &Vec3, [low, high]: [f64; 2]) -> Vec<(f64, f64)> {
        let (mut from, mut to) = (*through, *through);
        (from[axis], to[axis]) = (low, high);
        let mut crossings: Vec<(f64, f64)> = Vec::new();
        for t in self.meeting(Aabb { min: from, max: to }) {
            if turns_around(self.of(t), through, axis) != 0 {
                let crossing = crossing(self.of(t), axis, through);
                crossings.extend((low..=high).contains(&crossing.0).then_some(crossing));
            }
        }
        crossings.sort_unstable_by(|p, q| p.0.total_cmp(&q.0));
        crossings
    }

    /// The part of the segment from `inside` to `outside` before it first leaves the body, 0 to 1.
    pub fn exit(&self, inside: &Vec3, outside: &Vec3) -> f64 {
        let way = outside - inside;
        let crossing = |t: u32| {
            let [a, b, c] = self.of(t);
            let normal = (b - a).cross(&(c - a));
            let share = normal.dot(&(a - inside)) / normal.dot(&way);
            let foot = inside + way * share;
            let is_within = [(a, b), (b, c), (c, a)].iter().all(|(from, to)| {
                normal.dot(&(*to - *from).cross(&(foot - *from))) >= -ROUNDING_OF_AN_EXIT * normal.norm_squared()
            });
            let leaves = normal.dot(&way) > 0.0 && share >= -ROUNDING_OF_AN_EXIT;
            (leaves && is_within).then_some(share)
        };
        let near = self.meeting(Aabb::around([inside, outside]));
        near.filter_map(crossing).fold(1.0, f64::min).max(0.0)
    }

    /// True when the bodies are proved more than `gap` mm apart. Both surfaces must be closed and connected.
    ///
    /// Bodies whose coordinates are too large or too small to be asked about are not proved apart.
    pub fn is_apart(&self, other: &Self, gap: f64) -> bool {
        let reach = gap * (1.0 + 1e-9) + self.rounding(other, gap);
        let clear = |p: u32, q: u32| triangles_clear(self.of(p), other.of(q), gap);
        let holds = |a: &Self, b: &Self| b.corners().first().is_none_or(|triangle| a.contains(&triangle[0]));
        self.all_pairs(other, reach, clear) && !holds(self, other) && !holds(other, self)
    }

    /// The least distance of two triangles of the bodies that are nearer than `most` mm; 0 where one holds the other.
    pub fn distance_below(&self, other: &Self, most: f64) -> f64 {
        if !self.is_apart(other, 0.0) {
            return 0.0;
        }
        let mut least = most;
        self.all_pairs(other, most * (1.0 + 1e-9) + self.rounding(other, most), |p, q| {
            least = least.min(gjk::distance(self.of(p), other.of(q)).unwrap_or(0.0));
            true
        });
        least
    }

    /// Bound on the rounding of a box that is grown by a gap, mm; 0 for no gap, which is not rounded.
    fn rounding(&self, other: &Self, gap: f64) -> f64 {
        let farthest = |aabb: Aabb| aabb.min.abs().sup(&aabb.max.abs()).max();
        if gap == 0.0 { 0.0 } else { 4.0 * f64::EPSILON * farthest(self.aabb()).max(farthest(other.aabb())) }
    }
}

/// Crossings this close to the edge of a triangle, as a share of its size, count.
const ROUNDING_OF_AN_EXIT: f64 = 1e-9;
/// Divisions of the box in a search for the deepest point.
const MOST_HALVINGS: i32 = 7;
/// A cube is divided where it may hold a point deeper than the best by this factor.
const ENOUGH: f64 = 1.05;

impl Aabb {
    /// A point in this box that is about as deep as any, and its depth, mm; 0 where no point that was asked is inside.
    ///
    /// Cubes that may hold a point deeper by 5 % are divided, down to 1/64 of the longest side. A point that is deeper than the
    /// answer by [`missed_by_deepest`](Self::missed_by_deepest) may stay unseen.
    pub(super) fn deepest(&self, depth: impl Fn(&Vec3) -> f64) -> (Vec3, f64) {
        let mut half = self.size().max() / 2.0;
        let mut cubes = vec![(self.min + self.max) / 2.0];
        let mut best = (cubes[0], 0.0);
        for _ in 0..MOST_HALVINGS {
            let depths: Vec<f64> = cubes.iter().map(&depth).collect();
            for (middle, depth) in cubes.iter().zip(&depths) {
                best = if *depth > best.1 { (*middle, *depth) } else { best };
            }
            let reach = half * 3.0_f64.sqrt();
            let may_be_deeper = |depth: f64| depth + reach > best.1 * ENOUGH;
            let kept = cubes.iter().zip(&depths).filter(|(_, depth)| may_be_deeper(**depth));
            half /= 2.0;
            cubes = kept.flat_map(|(middle, _)| eighths(*middle, half)).collect();
            if cubes.is_empty() {
                break;
            }
        }
        best
    }

    /// Half a diagonal of the smallest cubes that a search for the deepest point asks, mm.
    pub(super) fn missed_by_deepest(&self) -> f64 {
        self.size().max() / 2.0_f64.powi(MOST_HALVINGS) * 3.0_f64.sqrt()
    }

    /// Volume of the points where `height` is positive, mm3, in the cube about this box. The height has a slope of 1.
    ///
    /// Cubes are halved `halvings` times where the surface may divide them, and the last ones count in part, as if the surface
    /// were a plane across an axis.
    pub fn volume_above(&self, halvings: usize, height: impl Fn(&Vec3) -> f64) -> f64 {
        let [volume] = self.volumes_above(halvings, |point, _, _: Option<&()>| ([(height(point), Vec3::x())], ()));
        volume
    }

    /// Volumes of the points where each of several heights is positive, mm3, in the cube about this box. Heights have a slope of
    /// 1; `heights` gives them with the unit vectors along which they grow, and a note for the eight cubes within, which get it from
    /// the cube around them. It also gets the farthest that their middles and corners are from that of the cube, below 0 where
    /// the cube is a last one.
    ///
    /// Cubes are halved `halvings` times where a surface may divide them. The share of the last ones follows from the
    /// height at their middle, as if the surface were a plane.
    pub(super) fn volumes_above<const N: usize, T>(
        &self,
        halvings: usize,
        heights: impl Fn(&Vec3, f64, Option<&T>) -> ([(f64, Vec3); N], T),
    ) -> [f64; N] {
        let (mut half, mut volumes) = (self.size().max() / 2.0, [0.0; N]);
        let mut divided: Vec<(Vec3, [bool; N], T)> = Vec::new();
        for halving in 0..=halvings {
            let (reach, whole, is_last) = (half * 3.0_f64.sqrt(), 8.0 * half.powi(3), halving == halvings);
            let mut asked = |middle: Vec3, undecided: &[bool; N], around: Option<&T>| {
                let (heights, note) = heights(&middle, if is_last { -1.0 } else { reach }, around);
                let mut divides = [false; N];
                for i in (0..N).filter(|&i| undecided[i]) {
                    let (height, upwards) = heights[i];
                    if height >= reach {
                        volumes[i] += whole;
                    } else if height > -reach && is_last {
                        volumes[i] += whole * share_above(&upwards, height / half);
                    } else {
                        divides[i] = height > -reach;
                    }
                }
                divides.contains(&true).then_some((middle, divides, note))
            };
            divided = if halving == 0 {
                asked((self.min + self.max) / 2.0, &[true; N], None).into_iter().collect()
            } else {
                let within =
                    divided.iter().flat_map(|around| eighths(around.0, half).map(move |middle| (middle, around)));
                within.filter_map(|(middle, around)| asked(middle, &around.1, Some(&around.2))).collect()
            };
            half /= 2.0;
        }
        volumes
    }
}

/// Share of the cube from -1 to 1 above a plane `height` below its middle, with the unit normal `upwards`.
fn share_above(upwards: &Vec3, height: f64) -> f64 {
    let mut edges = (upwards * 2.0).abs();
    edges.as_mut_slice().sort_unstable_by(f64::total_cmp);
    // The heights of the three edges of the cube, and of the corner farthest beyond the plane on the smaller side.
    let [a, b, c]: [f64; 3] = edges.into();
    let corner = ((a + b + c) / 2.0 - height.abs()).max(0.0);
    let cube = |height: f64| height.max(0.0).powi(3);
    // The corner's pyramid, less what of it is beyond the cube's other sides; without an edge that is level, or nearly.
    let smaller = if corner < a {
        cube(corner) / (6.0 * a * b * c)
    } else if corner < b {
        (3.0 * corner * (corner - a) + a * a) / (6.0 * b * c)
    } else if corner >= a + b {
        (2.0 * corner - a - b) / (2.0 * c)
    } else {
        (cube(corner) - cube(corner - a) - cube(corner - b) - cube(corner - c)) / (6.0 * a * b * c)
    };
    if height > 0.0 { 1.0 - smaller } else { smaller }
}

/// Middles of the eight cubes of half edge `half` around a point.
fn eighths(middle: Vec3, half: f64) -> impl Iterator<Item = Vec3> {
    (0..8).map(move |k| middle + Vec3::from_fn(|axis, _| if k >> axis & 1 == 1 { half } else { -half }))
}

/// True when two triangles are more than `gap` apart.
fn triangles_clear(p: &[Vec3; 3], q: &[Vec3; 3], gap: f64) -> bool {
    if gap > 0.0 {
        return gjk::distance_exceeds(p, q, gap).unwrap_or(false);
    }
    // Most pairs of triangles whose boxes meet lie on one side of each other's planes.
    is_beside(q, p) || is_beside(p, q) || !gjk::intersects(p, q).unwrap_or(true)
}

/// True when the points all lie off the plane of a triangle, on one side of it.
pub(super) fn is_beside(points: &[Vec3], [a, b, c]: &[Vec3; 3]) -> bool {
    let mut sides = points.iter().map(|point| orient3d(a, b, c, point));
    let first = sides.next().unwrap_or(0.0);
    first != 0.0 && sides.all(|side| side * first > 0.0)
}

/// Where the line through a point along an axis meets the plane of a triangle, within the triangle's extent, mm, and the
/// component of the unit normal along the axis.
fn crossing([a, b, c]: &[Vec3; 3], axis: usize, through: &Vec3) -> (f64, f64) {
    let normal = (b - a).cross(&(c - a));
    let [v, w] = [(axis + 1) % 3, (axis + 2) % 3];
    let at = a[axis] - (normal[v] * (through[v] - a[v]) + normal[w] * (through[w] - a[w])) / normal[axis];
    // A triangle that is seen edge-on has no slope to speak of.
    let at = if at.is_finite() { at } else { a[axis] };
    let (low, high) = (a[axis].min(b[axis]).min(c[axis]), a[axis].max(b[axis]).max(c[axis]));
    (at.clamp(low, high), normal[axis] / normal.norm())
}

/// A point as it is seen along an axis, from its upper end.
pub(super) fn seen(point: &Vec3, axis: usize) -> Coord<f64> {
    Coord { x: point[(axis + 1) % 3], y: point[(axis + 2) % 3] }
}

/// How often a triangle seen along an axis turns around a point, 1, 0 or -1: its edges that cross the line to the right
/// of the point, those upwards less those downwards. A point on an edge of two triangles counts to one of them.
fn turns_around(triangle: &[Vec3; 3], point: &Vec3, axis: usize) -> i32 {
    let at = seen(point, axis);
    let crossing = |k: usize| {
        let (from, to) = (seen(&triangle[k], axis), seen(&triangle[(k + 1) % 3], axis));
        if from.y <= at.y && to.y > at.y {
            i32::from(orient2d(from, to, at) > 0.0)
        } else if from.y > at.y && to.y <= at.y {
            -i32::from(orient2d(from, to, at) < 0.0)
        } else {
            0
        }
    };
    (0..3).map(crossing).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The middles of 64 cells along each edge of the cube from -1 to 1, counted.
    fn counted_above(upwards: &Vec3, height: f64) -> f64 {
        let coordinate = |i: u32| (f64::from(i) + 0.5) / 32.0 - 1.0;
        let cells = (0..64).flat_map(|i| (0..64).flat_map(move |j| (0..64).map(move |k| [i, j, k])));
        let above = cells.filter(|cell| upwards.dot(&Vec3::from(cell.map(coordinate))) + height > 0.0);
        above.count() as f64 / 64_f64.powi(3)
    }

    #[test]
    fn the_share_of_a_cube_above_a_plane_is_counted_for_planes_of_all_kinds() {
        let normals = [[0.3, 0.5, 0.8], [-0.9, 0.4, 0.1], [0.02, 0.6, -0.7], [1e-12, 0.6, 0.8], [0.0, 1e-15, -1.0]];
        for normal in normals.map(|normal| Vec3::from(normal).normalize()) {
            for height in [-1.6, -1.1, -0.81, -0.4, -0.13, 0.0, 0.02, 0.6, 0.97, 1.3] {
                let (share, counted) = (share_above(&normal, height), counted_above(&normal, height));
                assert!((share - counted).abs() < 0.01, "{normal:?} at {height}: {share} beside {counted}");
                assert!((share + share_above(&normal, -height) - 1.0).abs() < 1e-12);
            }
        }
        // A corner's pyramid whose three edges are the cube's.
        let diagonal = Vec3::repeat(1.0).normalize();
        assert!((share_above(&diagonal, -diagonal.x) - 1.0 / 6.0).abs() < 1e-12);
        assert_eq!(share_above(&Vec3::x(), 0.25), 0.625);
        assert_eq!(share_above(&Vec3::x(), -1.0), 0.0);
    }
}
