//! Heights over a closed surface on a grid, for quick answers in single precision that prove nothing.
//!
//! Near the surface each cell lists the triangles that may be the nearest ones to its points, so that small heights are
//! exact to rounding; others are interpolated.

use crate::geometry::{Triangles, nearest_on_triangle};
use crate::math::{Aabb, Vec3};

/// Heights over a closed surface, by a grid around it.
#[derive(Clone, Debug)]
pub struct HeightGrid {
    /// The lowest point of the grid, mm.
    low: [f32; 3],
    spacing: f32,
    counts: [usize; 3],
    /// Heights, mm, negative inside; x runs fastest.
    heights: Vec<f32>,
    facets: Vec<([Vec3; 3], Vec3)>,
    /// By cell, where its triangles begin; cells far from the surface have none.
    starts: Vec<u32>,
    triangles: Vec<u16>,
}

/// A point over a surface.
#[derive(Clone, Copy, Debug)]
pub struct Height<'a> {
    /// mm, negative inside.
    pub height: f32,
    /// Direction in which the height grows, of any length.
    pub slope: [f32; 3],
    /// The triangles that may be the nearest ones, near the surface.
    pub triangles: &'a [u16],
}

/// Cells list their triangles where the height of their middle is at most this many spacings.
const NEAR: f32 = 1.4;
/// Interpolated heights below this many spacings are replaced by exact ones.
const SMALL: f32 = 0.4;
/// A point this near to a triangle, in spacings, has its normal as the slope.
const ON: f64 = 1e-3;
/// Spacings between the surface's box and the end of the grid, on both sides.
const MARGIN: f64 = 1.0;

impl HeightGrid {
    /// Heights over `surface` with `points` grid points, 4 or more, along the longest side of its box.
    pub fn new(surface: &Triangles, points: usize) -> Self {
        let (aabb, points) = (surface.aabb(), points.max(4));
        let spacing = aabb.size().max() / (points as f64 - 1.0 - 2.0 * MARGIN);
        let low = aabb.min.add_scalar(-MARGIN * spacing);
        let counts = [0, 1, 2].map(|axis| (aabb.size()[axis] / spacing + 2.0 * MARGIN).ceil() as usize + 1);
        let number = |k: usize| [k % counts[0], k / counts[0] % counts[1], k / (counts[0] * counts[1])];
        let height = |k: usize| -surface.depth(&(low + Vec3::from(number(k).map(|i| i as f64)) * spacing)) as f32;
        let heights: Vec<f32> = (0..counts.iter().product()).map(height).collect();
        let (mut starts, mut triangles) = (vec![0], Vec::new());
        for (cell, height) in heights.iter().enumerate() {
            let middle = low + Vec3::from(number(cell).map(|i| i as f64 + 0.5)) * spacing;
            if height.abs() <= (NEAR + 1.0) * spacing as f32 {
                triangles.extend(candidates(surface, &middle, spacing));
            }
            starts.push(triangles.len() as u32);
        }
        let normal = |[a, b, c]: &[Vec3; 3]| (b - a).cross(&(c - a)).normalize();
        let facets = surface.corners().iter().map(|corners| (*corners, normal(corners))).collect();
        let low = low.map(|x| x as f32).into();
        Self { low, spacing: spacing as f32, counts, heights, facets, starts, triangles }
    }

    /// The distance of two grid points, mm.
    pub fn spacing(&self) -> f32 {
        self.spacing
    }

    /// The height of `point` over the surface; `None` beyond the grid, which is a spacing or more away from it.
    pub fn at(&self, point: [f32; 3]) -> Option<Height<'_>> {
        let place = [0, 1, 2].map(|axis| (point[axis] - self.low[axis]) / self.spacing);
        let is_within = |axis: usize| place[axis] >= 0.0 && place[axis] < (self.counts[axis] - 1) as f32;
        if !(is_within(0) && is_within(1) && is_within(2)) {
            return None;
        }
        let [i, j, k] = place.map(|x| x as usize);
        let [u, v, w] = [place[0] - i as f32, place[1] - j as f32, place[2] - k as f32];
        let (row, layer) = (self.counts[0], self.counts[0] * self.counts[1]);
        let at = (k * self.counts[1] + j) * row + i;
        // Along x first, then y, then z: the pairs that remain give the slopes.
        let along_x = |from: usize| {
            let (low, high) = (self.heights[from], self.heights[from + 1]);
            (low + (high - low) * u, high - low)
        };
        let [p, q, r, s] = [at, at + row, at + layer, at + layer + row].map(along_x);
        let mixed = |low: f32, high: f32, share: f32| low + (high - low) * share;
        let (below, above) = (mixed(p.0, q.0, v), mixed(r.0, s.0, v));
        let slopes = [mixed(mixed(p.1, q.1, v), mixed(r.1, s.1, v), w), mixed(q.0 - p.0, s.0 - r.0, w), above - below];
        let (height, triangles) =
            (mixed(below, above, w), &self.triangles[self.starts[at] as usize..self.starts[at + 1] as usize]);
        if height.abs() < SMALL * self.spacing && !triangles.is_empty() {
            return Some(self.over(triangles, &Vec3::from(point.map(f64::from))));
        }
        Some(Height { height, slope: slopes, triangles })
    }

    /// The height over the nearest of some triangles. Among several as near, the one that faces the point most
    /// has the sign.
    fn over<'a>(&self, triangles: &'a [u16], point: &Vec3) -> Height<'a> {
        let mut best = (f64::INFINITY, 0.0, Vec3::zeros());
        for &triangle in triangles {
            let (corners, normal) = &self.facets[usize::from(triangle)];
            let arm = point - nearest_on_triangle(corners, point);
            let (distance, same) = (arm.norm(), 1e-6 * f64::from(self.spacing));
            if distance > best.0 + same {
                continue;
            }
            let above = normal.dot(&(point - corners[0]));
            if distance < best.0 - same || above.abs() > f64::abs(best.1) {
                let slope = if distance < ON * f64::from(self.spacing) { *normal } else { arm * above.signum() };
                best = (distance, above, slope);
            }
        }
        let (distance, above, slope) = best;
        let height = if above < 0.0 { -distance } else { distance };
        Height { height: height as f32, slope: slope.map(|x| x as f32).into(), triangles }
    }
}

/// The triangles that may be the nearest ones to points of the cell around `middle`; none where it is far from all.
fn candidates(surface: &Triangles, middle: &Vec3, spacing: f64) -> Vec<u16> {
    let Some((_, least)) = surface.nearest(middle) else { return Vec::new() };
    if least > f64::from(NEAR) * spacing {
        return Vec::new();
    }
    let reach = least + 3.0_f64.sqrt() * spacing;
    let near = surface.near(&Aabb { min: *middle, max: *middle }.grown(reach));
    let may_be = |triangle: &u32| surface.nearest_of(*triangle, middle).1 <= reach;
    near.into_iter().filter(may_be).map(|triangle| triangle as u16).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Polyhedron, Round};
    use crate::random::Stream;

    #[test]
    fn heights_and_slopes_over_facets_of_a_ball_are_exact_near_them() {
        let ball = Polyhedron::of_round(&Round::ball(5.0)).faceted().into_owned();
        let surface = ball.surface();
        let grid = HeightGrid::new(&surface, 24);
        let mut stream = Stream::new(3);
        let (mut inside, mut beyond, mut near) = (0, 0, 0);
        for _ in 0..2000 {
            let point = Vec3::from_fn(|_, _| stream.uniform(-6.5, 6.5));
            let Some(Height { height, slope, .. }) = grid.at(point.map(|x| x as f32).into()) else {
                assert!(point.amax() > 5.0 + f64::from(grid.spacing()) * 0.9);
                beyond += 1;
                continue;
            };
            let slope = Vec3::from(slope.map(f64::from)).normalize();
            let exact = -surface.depth(&point);
            let is_small = height.abs() < 0.3 * grid.spacing();
            let most = if is_small { 1e-5 } else { 0.1 };
            assert!((f64::from(height) - exact).abs() < most, "{point:?} {height} {exact}");
            near += usize::from(is_small);
            if point.norm() > 2.0 {
                assert!((slope - point.normalize()).norm() < 0.3, "{point:?} {slope:?}");
            }
            inside += usize::from(height < 0.0);
        }
        assert!(inside > 300 && beyond > 300 && near > 60, "{inside} {beyond} {near}");
    }
}
