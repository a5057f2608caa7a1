//! The hull of a few points in general position, by gift wrapping (Chand and Kapur 1970): from every edge of a triangle of
//! the hull to the one beyond, which is where a plane that turns about the edge first meets a point.
//!
//! The turning is done in single precision, eight points at a time, and only proposes: every triangle is kept only when
//! all other points are below it by more than rounding can hide. Triangles that are facets and share all their edges are
//! all facets there are.

use super::cloud::{Cloud, LANES, MOST_GROUPS, MOST_POINTS};
use crate::lanes::least_lane;
use crate::math::Vec3;
use crate::simd::{Wide, widest};

/// Stands for: no corner.
const NONE: u8 = u8::MAX;

/// Triangles of a hull under construction, and its scratch memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Wrap {
    turning: Turning,
    /// By directed edge, the third corner of its triangle.
    third: Vec<u8>,
    /// By corner, in bits: where the edges end that begin there and whose triangle has no smaller corner.
    first: Vec<u128>,
    /// Facets whose edges are not all followed.
    queue: Vec<[u8; 3]>,
    corners: Vec<u8>,
}

impl Wrap {
    /// The corners of all facets in canonical order; `None` where there are many points, facets that are no
    /// triangles, or facets that rounding leaves undecided.
    pub(super) fn triangles(&mut self, points: &[Vec3]) -> Option<&[u8]> {
        let n = points.len();
        if !(4..=MOST_POINTS).contains(&n) {
            return None;
        }
        self.third.clear();
        self.third.resize(n * n, NONE);
        self.first.clear();
        self.first.resize(n, 0);
        self.queue.clear();
        widest(Wrapping { wrap: self, points }).then(|| self.collect(n))
    }

    /// Takes note of a facet; false where one of its edges has another.
    #[inline(always)]
    fn add(&mut self, [a, b, c]: [usize; 3]) -> bool {
        self.queue.push([a as u8, b as u8, c as u8]);
        // All three, without short-circuit.
        self.enter(a, b, c) & self.enter(b, c, a) & self.enter(c, a, b)
    }

    /// Takes note of one of a facet's edges; false where another has it.
    #[inline(always)]
    fn enter(&mut self, from: usize, to: usize, third: usize) -> bool {
        if from < to.min(third) {
            self.first[from] |= 1 << to;
        }
        let at = from * self.first.len() + to;
        std::mem::replace(&mut self.third[at], third as u8) == NONE
    }

    /// Every facet from its smallest corner on, in ascending order of the first two.
    fn collect(&mut self, n: usize) -> &[u8] {
        self.corners.clear();
        for (a, &ends) in self.first.iter().enumerate() {
            let mut ends = ends;
            while ends != 0 {
                let b = ends.trailing_zeros() as usize;
                self.corners.extend([a as u8, b as u8, self.third[a * n + b]]);
                ends &= ends - 1;
            }
        }
        &self.corners
    }
}

/// The wrapping, on wide registers; whether it came to an end.
struct Wrapping<'a> {
    wrap: &'a mut Wrap,
    points: &'a [Vec3],
}

impl Wide for Wrapping<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let Self { wrap, points } = self;
        wrap.turning.fill(points);
        let first = wrap.turning.first_facet();
        if !wrap.turning.are_points(first) || !wrap.add(first) {
            return false;
        }
        // More facets than these no hull has.
        for _ in 0..2 * points.len() {
            let Some([a, b, c]) = wrap.queue.pop() else { return true };
            if !wrap.follow([usize::from(a), usize::from(b), usize::from(c)]) {
                return false;
            }
        }
        false
    }
}

impl Wrap {
    /// Finds the facets beyond the edges of this one; false where it is none, or where one is not found.
    #[inline(always)]
    fn follow(&mut self, [a, b, c]: [usize; 3]) -> bool {
        let plane = self.turning.cloud.plane([a, b, c]);
        // The three that rounding may see in the plane are the corners.
        if self.turning.start(&plane) != 3 {
            return false;
        }
        self.turning.leave_out(&[a, b, c]);
        self.cross(&plane.0, a, b) && self.cross(&plane.0, b, c) && self.cross(&plane.0, c, a)
    }

    /// Finds the facet beyond one edge of that with this normal, if it is not known; false where that failed.
    #[inline(always)]
    fn cross(&mut self, normal: &Vec3, from: usize, to: usize) -> bool {
        if self.third[to * self.first.len() + from] != NONE {
            return true;
        }
        let facet = [to, from, self.turning.meets(from, self.turning.cloud.point(to), normal)];
        self.turning.are_points(facet) && self.add(facet)
    }
}

/// A plane with all points below, which turns about a line in it.
#[derive(Clone, Debug, Default)]
struct Turning {
    cloud: Cloud,
    /// Number of points.
    count: usize,
    /// The points in single precision, coordinate by coordinate.
    x: [Narrow; MOST_GROUPS],
    y: [Narrow; MOST_GROUPS],
    z: [Narrow; MOST_GROUPS],
    /// One over every point's height above the plane, which is below 0; NaN for points in it.
    per_height: [Narrow; MOST_GROUPS],
}

/// One number of each point in a group.
type Narrow = [f32; LANES];

impl Turning {
    #[inline(always)]
    fn fill(&mut self, points: &[Vec3]) {
        let Self { cloud, x, y, z, .. } = self;
        cloud.fill(points);
        self.count = points.len();
        for group in 0..cloud.groups {
            for lane in 0..LANES {
                x[group][lane] = cloud.x[group][lane] as f32;
                y[group][lane] = cloud.y[group][lane] as f32;
                z[group][lane] = cloud.z[group][lane] as f32;
            }
        }
    }

    /// Three points that are likely to be corners of a facet, counter-clockwise from outside.
    #[inline(always)]
    fn first_facet(&mut self) -> [usize; 3] {
        let mut a = 0;
        for i in 0..self.count {
            a = if self.cloud.point(i).x < self.cloud.point(a).x { i } else { a };
        }
        // From the plane across x, about a line along y, then about the edge found.
        let (at, y) = (self.cloud.point(a), Vec3::y());
        self.start(&(-Vec3::x(), -at.x));
        self.leave_out(&[a]);
        let b = self.meets(a, at + y, &-Vec3::x());
        let edge = self.cloud.point(b) - at;
        let across = edge.cross(&y);
        // The padding, or the middle, is inside.
        let normal = if across.dot(&at) < 0.0 { -across } else { across };
        self.start(&(normal, normal.dot(&at)));
        self.leave_out(&[a, b]);
        [b, a, self.meets(a, self.cloud.point(b), &normal)]
    }

    /// Three different points, none of them padding.
    #[inline(always)]
    fn are_points(&self, [a, b, c]: [usize; 3]) -> bool {
        a.max(b).max(c) < self.count && a != b && b != c && c != a
    }

    /// Starts from a plane; the number of points that are not certainly below.
    #[inline(always)]
    fn start(&mut self, plane: &(Vec3, f64)) -> u32 {
        let mut not_below = [0; LANES];
        for group in 0..self.cloud.groups {
            let heights = self.cloud.heights(group, plane, &mut not_below);
            for (per_height, height) in self.per_height[group].iter_mut().zip(&heights) {
                *per_height = 1.0 / *height as f32;
            }
        }
        not_below.iter().sum()
    }

    #[inline(always)]
    fn leave_out(&mut self, points: &[usize]) {
        for &point in points {
            self.per_height[point / LANES][point % LANES] = f32::NAN;
        }
    }

    /// The point that the plane with this outward normal first meets when it turns about the line from a point to another
    /// place: the one of the least slope.
    #[inline(always)]
    fn meets(&self, from: usize, to: Vec3, normal: &Vec3) -> usize {
        let at = self.cloud.point(from);
        let outward = (to - at).cross(normal);
        let (ox, oy, oz) = (outward.x as f32, outward.y as f32, outward.z as f32);
        let offset = outward.dot(&at) as f32;
        let (mut best, mut number) = ([f32::MAX; LANES], [0_u32; LANES]);
        for group in 0..self.cloud.groups {
            let (x, y, z) = (&self.x[group], &self.y[group], &self.z[group]);
            let per_height = &self.per_height[group];
            let mut slopes = [0.0; LANES];
            for lane in 0..LANES {
                slopes[lane] = (ox * x[lane] + oy * y[lane] + oz * z[lane] - offset) * per_height[lane];
            }
            for lane in 0..LANES {
                number[lane] = if slopes[lane] < best[lane] { group as u32 } else { number[lane] };
            }
            for lane in 0..LANES {
                best[lane] = if slopes[lane] < best[lane] { slopes[lane] } else { best[lane] };
            }
        }
        let (_, lane) = least_lane(&best);
        number[lane] as usize * LANES + lane
    }
}
