//! Caps of a body with dents, its skin, and the depths below this.
//!
//! The sides of a box may cut a body, as those of a scan cut grains. Its triangles in such a side are a cap, all others are its
//! skin. A shell lies below the skin alone: where the cap is, the body went on before the cut. So the skin is continued beyond
//! the rims of caps along its tangent planes, and the shell has one thickness up to the cap.

use crate::geometry::{Polyhedron, Triangles};
use crate::math::{Aabb, Vec3};
use crate::stop;
use std::collections::BTreeMap;

/// The skin goes on beyond a rim by so many thicknesses of the shell. It decides on depths where it meets the cap at 14 degrees
/// and more.
const BEYOND: f64 = 4.0;

impl Polyhedron {
    /// Makes caps of the triangles of a body with dents that lie exactly in a side of `sides`.
    pub fn mark_caps(&mut self, sides: &Aabb) {
        if self.is_convex() {
            return;
        }
        let (aabb, mut caps) = (self.aabb(), 0);
        for bit in 0..6 {
            let is_reached = aabb.end(bit) == sides.end(bit);
            let is_cap = |t: [u32; 3]| t.iter().all(|&v| self.vertices()[v as usize][bit / 2] == aabb.end(bit));
            caps |= u8::from(is_reached && self.triangles().any(is_cap)) << bit;
        }
        self.set_caps(caps);
    }

    /// The skin of a body with dents, for depths of a shell of `thickness` mm.
    pub fn skin(&self, thickness: f64) -> Skin {
        let cuts = self.cuts();
        let open = cuts.map(|cuts| {
            let mut triangles: Vec<[Vec3; 3]> = self.corners().filter(|corners| !cuts.cap(corners)).collect();
            let own = triangles.len() as u32;
            triangles.extend(cuts.beyond_rims(&triangles, BEYOND * thickness));
            Open { skin: Triangles::new(triangles), own, cuts }
        });
        Skin { surface: self.surface(), open }
    }

    /// The corners of its triangles.
    pub(super) fn corners(&self) -> impl Iterator<Item = [Vec3; 3]> {
        self.triangles().map(|t| t.map(|v| self.vertices()[v as usize]))
    }

    /// The box that its caps bound, everywhere else unbounded.
    pub fn cut_space(&self) -> Aabb {
        self.aabb().bounded_at(self.caps())
    }

    /// The planes of its caps; `None` where it has none.
    pub(super) fn cuts(&self) -> Option<SkinCuts> {
        (self.caps() != 0).then(|| SkinCuts(self.cut_space()))
    }
}

/// The planes of caps, as a box that is unbounded where there are none.
#[derive(Clone, Copy, Debug)]
pub(super) struct SkinCuts(Aabb);

impl SkinCuts {
    /// Whether `x` lies in the plane of this cap.
    fn have(&self, bit: usize, x: &Vec3) -> bool {
        x[bit / 2] == self.0.end(bit)
    }

    /// Whether a triangle is of a cap.
    pub(super) fn cap(&self, corners: &[Vec3; 3]) -> bool {
        (0..6).any(|bit| corners.iter().all(|v| self.have(bit, v)))
    }

    /// The part of `step` that leaves `x` in the planes of the caps that it lies in.
    pub(super) fn along(&self, x: &Vec3, step: &Vec3) -> Vec3 {
        let is_held = |axis: usize| self.have(2 * axis, x) || self.have(2 * axis + 1, x);
        Vec3::from_fn(|axis, _| if is_held(axis) { 0.0 } else { step[axis] })
    }

    /// The point between the planes that is nearest to `x`.
    fn nearest(&self, x: &Vec3) -> Vec3 {
        x.sup(&self.0.min).inf(&self.0.max)
    }

    /// From `x` to the nearest plane, mm, negative beyond it; and the unit vector from there inwards.
    fn depth(&self, x: &Vec3) -> (f64, Vec3) {
        let of = |bit: usize| {
            let inwards = if bit.is_multiple_of(2) { 1.0 } else { -1.0 };
            ((x[bit / 2] - self.0.end(bit)) * inwards, Vec3::ith(bit / 2, inwards))
        };
        (0..6).map(of).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
    }

    /// Continues the triangles of a skin beyond their edges in caps by `reach` mm.
    fn beyond_rims(&self, skin: &[[Vec3; 3]], reach: f64) -> Vec<[Vec3; 3]> {
        let key = |v: &Vec3| -> [u64; 3] { v.map(f64::to_bits).into() };
        let mut normals: BTreeMap<[u64; 3], Vec3> = BTreeMap::new();
        let touching = skin.iter().filter(|t| (0..6).any(|bit| t.iter().any(|v| self.have(bit, v))));
        for corners @ [a, b, c] in touching {
            let normal = (b - a).cross(&(c - a));
            corners.iter().for_each(|v| *normals.entry(key(v)).or_default() += normal);
        }
        let end = |v: &Vec3, bit: usize| v + self.tangent(v, &normals[&key(v)], bit) * reach;
        let mut beyond = Vec::new();
        for bit in 0..6 {
            let edges = skin.iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
            for [a, b] in edges.filter(|[a, b]| self.have(bit, a) && self.have(bit, b)) {
                let [over_a, over_b] = [end(a, bit), end(b, bit)];
                beyond.extend([[*b, *a, over_a], [*b, over_a, over_b]]);
                // In an edge of the box the two continuations leave a sector between them.
                for other in (bit + 1..6).filter(|other| other / 2 > bit / 2) {
                    let corners = [a, b].into_iter().filter(|v| self.have(other, v));
                    beyond.extend(corners.map(|v| [*v, end(v, bit), end(v, other)]));
                }
            }
        }
        beyond
    }

    /// The unit vector out of a cap along the skin with this `normal` at `v`, in the planes of the other caps there.
    fn tangent(&self, v: &Vec3, normal: &Vec3, bit: usize) -> Vec3 {
        let outwards = Vec3::ith(bit / 2, if bit.is_multiple_of(2) { -1.0 } else { 1.0 });
        let other = (0..6).find(|other| other / 2 != bit / 2 && self.have(*other, v));
        let along = match other {
            Some(other) => normal.cross(&Vec3::ith(other / 2, 1.0)),
            None => outwards * normal.norm_squared() - normal * normal.dot(&outwards),
        };
        let along = along * if along.dot(&outwards) < 0.0 { -1.0 } else { 1.0 };
        along.try_normalize(0.0).unwrap_or(outwards)
    }
}

/// Triangles from which a thin body's depth is searched.
const MOST_STARTS: usize = 256;
/// Balls that one of them tries, each smaller than the last one.
const MOST_SHRINKS: usize = 40;
/// Share of its radius by which a ball may cross the skin.
const TOUCHES: f64 = 1e-6;

/// The surface of a body with dents, and its skin.
#[derive(Clone, Debug)]
pub struct Skin {
    surface: Triangles,
    open: Option<Open>,
}

/// The skin of a body with caps.
#[derive(Clone, Debug)]
struct Open {
    /// Its own triangles, then those beyond the rims.
    skin: Triangles,
    own: u32,
    cuts: SkinCuts,
}

impl Skin {
    /// The closed surface, caps included.
    pub fn surface(&self) -> &Triangles {
        &self.surface
    }

    fn triangles(&self) -> &Triangles {
        self.open.as_ref().map_or(&self.surface, |open| &open.skin)
    }

    /// The point of the skin, continued, that is nearest to `x`, and its distance, mm; `None` where there is no skin.
    pub fn nearest(&self, x: &Vec3) -> Option<(Vec3, f64)> {
        self.triangles().nearest(x)
    }

    /// From `x` to the skin, mm: positive inside, negative outside. A point beyond a cap is as deep as the nearest point of
    /// the cap's plane.
    pub fn depth(&self, x: &Vec3) -> f64 {
        stop::point();
        let x = self.within(x);
        let distance = self.nearest(&x).map_or(f64::INFINITY, |(_, distance)| distance);
        if self.surface.contains(&x) { distance } else { -distance }
    }

    /// How far `x` is within the points of the body that are deeper than `depth` mm: negative outside, with a slope of 1.
    pub fn depth_below(&self, x: &Vec3, depth: f64) -> f64 {
        self.up_to_caps(x, (self.depth(x) - depth, Vec3::zeros())).0
    }

    /// A point that is about as deep as any, and its depth, mm. It lies in the body, whatever the shape.
    pub fn deepest(&self) -> (Vec3, f64) {
        let aabb = self.surface.aabb();
        let mut best = aabb.deepest(|x| self.depth(x));
        // Parts as thin as the smallest cubes may lie between the points that were asked.
        if best.1 < aabb.missed_by_deepest() {
            let mut look = |x: Vec3| {
                let depth = self.depth(&x);
                best = if depth > best.1 { (x, depth) } else { best };
            };
            self.starts().filter_map(|(at, inwards)| self.touching(&at, &inwards)).for_each(&mut look);
        }
        (self.within(&best.0), best.1)
    }

    /// Points of the body's own skin, spread over it, and the unit vectors from there inwards.
    fn starts(&self) -> impl Iterator<Item = (Vec3, Vec3)> {
        let own = self.open.as_ref().map_or(self.surface.corners().len(), |open| open.own as usize);
        let spread = (0..own).step_by(own.div_ceil(MOST_STARTS).max(1));
        spread.flat_map(|number| {
            let corners = self.triangles().of(number as u32);
            let [a, b, c] = corners;
            let inwards = (c - a).cross(&(b - a)).try_normalize(0.0);
            let middle = (a + b + c) / 3.0;
            inwards.into_iter().flat_map(move |inwards| {
                let near = corners.map(|corner| (middle + corner) / 2.0);
                [middle].into_iter().chain(near).map(move |at| (at, inwards))
            })
        })
    }

    /// The middle of a ball that touches the skin at `at`, from inside, and reaches it nowhere else: a ball that is too
    /// large shrinks until it touches the nearest point too (Ma, Bae, Choi 2012).
    fn touching(&self, at: &Vec3, inwards: &Vec3) -> Option<Vec3> {
        let mut radius = self.surface.aabb().size().norm() / 2.0;
        for _ in 0..MOST_SHRINKS {
            let (nearest, distance) = self.nearest(&(at + inwards * radius))?;
            let way = nearest - at;
            let smaller = way.norm_squared() / (2.0 * way.dot(inwards));
            if distance >= radius * (1.0 - TOUCHES) || !(smaller > 0.0 && smaller < radius) {
                break;
            }
            radius = smaller;
        }
        Some(at + inwards * radius)
    }

    /// The point of the cut space that is nearest to `x`.
    fn within(&self, x: &Vec3) -> Vec3 {
        self.open.as_ref().map_or(*x, |open| open.cuts.nearest(x))
    }

    /// A depth of `x` and the unit vector inwards or, where that is less, those of the nearest cap's plane.
    fn up_to_caps(&self, x: &Vec3, below: (f64, Vec3)) -> (f64, Vec3) {
        let below_caps = self.open.as_ref().map(|open| open.cuts.depth(x));
        below_caps.filter(|cap| cap.0 < below.0).unwrap_or(below)
    }

    /// How far `x` is below each of the `levels`, as [`depth_below`](Self::depth_below) says, and the unit vector along which it gets
    /// deeper; and a note for points within `reach` mm of it. `around` is the note for a point whose reach this one is in.
    pub(super) fn depths_below<const N: usize>(
        &self,
        x: &Vec3,
        levels: [f64; N],
        reach: f64,
        around: Option<&Depth>,
    ) -> ([(f64, Vec3); N], Depth) {
        let found = self.depth_within(&self.within(x), reach, around);
        let from_skin = found.point - self.triangles().nearest_of(found.nearest, &found.point).0;
        let inwards = (from_skin / found.depth).try_normalize(0.0).unwrap_or_else(Vec3::x);
        (levels.map(|level| self.up_to_caps(x, (found.depth - level, inwards))), found)
    }

    /// The depth of `point`, and the triangles that are the nearest ones of points within `reach` mm of it; none of them
    /// where `reach` is negative.
    fn depth_within(&self, point: &Vec3, reach: f64, around: Option<&Depth>) -> Depth {
        let (mut near, mut best, skin) = (Vec::new(), (f64::INFINITY, 0), self.triangles());
        let step = around.map_or(0.0, |around| (around.point - point).norm());
        let mut look = |triangle: u32| {
            let distance = skin.nearest_of(triangle, point).1;
            best = if (distance, triangle) < best { (distance, triangle) } else { best };
            if distance <= best.0 + 2.0 * reach {
                near.push((distance, triangle));
            }
            best.0 + 2.0 * reach.max(0.0)
        };
        match around {
            Some(around) => {
                let mut farthest = f64::INFINITY;
                let mut may_be_near = around.triangles.iter();
                while let Some((_, triangle)) = may_be_near.next().filter(|near| near.0 - step <= farthest) {
                    farthest = look(*triangle);
                }
            }
            None => (0..skin.corners().len() as u32).for_each(|triangle| _ = look(triangle)),
        }
        let (distance, nearest) = best;
        let is_inside = match around.filter(|around| step < around.depth.abs()) {
            Some(around) => around.depth > 0.0,
            None => self.is_below(nearest, point, distance).unwrap_or_else(|| self.surface.contains(point)),
        };
        near.retain(|near| near.0 <= distance + 2.0 * reach);
        near.sort_unstable_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
        Depth { point: *point, nearest, triangles: near, depth: if is_inside { distance } else { -distance } }
    }

    /// Whether a point lies on the inner side of its nearest triangle; `None` unless it lies straight above or below one of
    /// the body's own.
    fn is_below(&self, nearest: u32, point: &Vec3, distance: f64) -> Option<bool> {
        let [a, b, c] = self.triangles().of(nearest);
        let normal = (b - a).cross(&(c - a));
        let height = normal.dot(&(point - a)) / normal.norm();
        let is_own = self.open.as_ref().is_none_or(|open| nearest < open.own);
        (is_own && height.abs() > distance * STRAIGHT && distance > 0.0).then_some(height < 0.0)
    }
}

/// A point, its depth, mm, its nearest triangle, and those of points around it with their distances, ascending.
pub(super) struct Depth {
    point: Vec3,
    nearest: u32,
    triangles: Vec<(f64, u32)>,
    depth: f64,
}

/// Least cosine between a normal and the way to the nearest point of a triangle that decides on the side.
const STRAIGHT: f64 = 1.0 - 1e-9;
