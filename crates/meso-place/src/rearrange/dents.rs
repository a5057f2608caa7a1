//! Contacts of grains with dents whose hulls overlap: corners and edges of each in the heights over the other.
//!
//! The heights over a shape stand in a grid that all of its copies share. A corner below the wanted gap is pushed along
//! the slope there, a ridge across the other's nearest ridge; the deepest one together with those that are pushed the
//! same way. This search may miss a contact; `certify` finds that pair, and it keeps a margin from then on.

use super::contact::{FoundContact, Points, V, add_scaled, cross, direction_or_up, dot, length, scale};
use crate::Turn;
use crate::task::Task;
use meso_collision::dents::{Height, HeightGrid};
use meso_collision::geometry::{Plane, Polyhedron};
use meso_collision::math::Vec3;
use meso_concrete::aggregate::Grain;
use meso_concrete::parallel;
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Grid points along the longest side of a shape, and the most points of all shapes together (16 MB).
const POINTS: usize = 24;
const MOST_POINTS: usize = 4_000_000;
/// Points within this many wanted gaps are looked at, so that a pair need not be looked at again at once.
const AHEAD: f32 = 10.0;
/// Ridges are left alone where a corner is deeper than this many spacings of a grid.
const DEEP: f32 = 0.5;
/// Cosine between the deepest point's push and another one that goes the same way.
const ALIKE: f32 = 0.7;
/// Margin of a grain that was not proved apart, as a share of its ball's radius; it doubles with every proof that fails.
const FIRST_MARGIN: f32 = 0.002;
const MOST_MARGIN: f32 = 0.04;

/// The shapes of all grains with dents, and the margins of those that a proof found too near.
#[derive(Clone)]
pub(super) struct DentedShapes {
    shapes: Arc<BTreeMap<u32, Shape>>,
    /// By grain, mm.
    margins: Vec<f32>,
}

/// Hulls that take this share of the specimen wedge: in a 75 mm cube 0.70 took 942 sweeps.
const CROWDED: f64 = 0.7;

/// True where grains have dents, and the hulls of all would take so much of the specimen that they wedge.
pub(super) fn hulls_crowd(task: &Task) -> bool {
    if task.request.grains.iter().all(|grain| grain.copy_of().is_none()) {
        return false;
    }
    let mut ratios = BTreeMap::new();
    let volume = |grain: &Grain| {
        let own = || grain.body.widened().hull().map_or(1.0, |hull| hull.volume() / grain.volume());
        let ratio = grain.copy_of().map_or(1.0, |template| *ratios.entry(template).or_insert_with(own));
        ratio * grain.volume()
    };
    task.request.grains.iter().map(volume).sum::<f64>() > CROWDED * task.volume
}

/// A shape, in the frame of its first copy.
struct Shape {
    heights: HeightGrid,
    /// Edges that are no bottoms of dents, and those of each triangle.
    ridges: Vec<[u16; 2]>,
    by_triangle: Vec<Vec<[u16; 2]>>,
    /// Two corners in different directions, which say how a copy is turned.
    corners: [usize; 2],
    frame: Matrix3<f32>,
    /// From the centre to the first of these corners, mm.
    arm: f32,
}

/// A body as a copy of a shape.
#[derive(Clone, Copy)]
struct Copied {
    template: u32,
    /// Its size over the shape's.
    scale: f32,
    /// From the shape's frame to the grain's own.
    turn: Turn,
}

impl DentedShapes {
    /// The shapes of `grains`; `None` where none has dents.
    pub(super) fn of(grains: &[Grain]) -> Option<Self> {
        let mut firsts = BTreeMap::new();
        for (template, grain) in grains.iter().filter_map(|grain| Some((grain.copy_of()?, grain))) {
            firsts.entry(template).or_insert(grain);
        }
        let points = POINTS.min(libm::cbrt(MOST_POINTS as f64 / firsts.len().max(1) as f64) as usize);
        let firsts: Vec<(u32, &Grain)> = firsts.into_iter().collect();
        let shapes = parallel::map_each(&firsts, |(template, grain)| (*template, Shape::new(grain, points)));
        let margins = vec![0.0; grains.len()];
        (!shapes.is_empty()).then(|| Self { shapes: Arc::new(shapes.into_iter().collect()), margins })
    }

    /// Gives wider margins to those of `unproved` grains that may have them; false where there are none.
    pub(super) fn widen(&mut self, grains: &[Grain], unproved: &[u32]) -> bool {
        let mut widened = false;
        for &grain in unproved.iter().filter(|&&grain| grains[grain as usize].copy_of().is_some()) {
            let (radius, margin) = (grains[grain as usize].ball_radius() as f32, &mut self.margins[grain as usize]);
            let next = (2.0 * *margin).max(FIRST_MARGIN * radius);
            if next <= MOST_MARGIN * radius {
                (*margin, widened) = (next, true);
            }
        }
        widened
    }

    /// The margin of a grain, mm.
    pub(super) fn margin(&self, grain: u32) -> f32 {
        self.margins[grain as usize]
    }

    /// The surfaces of bodies, which are these grains in this order.
    pub(super) fn surfaces<'g>(&self, grains: impl Iterator<Item = &'g Grain>) -> Surfaces {
        let copied = |grain: &Grain| grain.copy_of().map(|template| self.shapes[&template].copied(template, grain));
        Surfaces { shapes: self.shapes.clone(), bodies: grains.map(copied).collect() }
    }
}

impl Shape {
    fn new(grain: &Grain, points: usize) -> Self {
        let body = grain.body.widened();
        let by_triangle = ridges(&body);
        let mut ridges = by_triangle.concat();
        ridges.sort_unstable();
        ridges.dedup();
        let vertices: Vec<V> = body.vertices().iter().map(narrow).collect();
        let farthest = |score: &dyn Fn(&V) -> f32| {
            (0..vertices.len()).max_by(|&i, &j| score(&vertices[i]).total_cmp(&score(&vertices[j]))).unwrap_or(0)
        };
        let first = farthest(&|v| length(*v));
        let corners = [first, farthest(&|v| length(cross(vertices[first], *v)))];
        Self {
            heights: HeightGrid::new(&body.surface(), points),
            ridges,
            by_triangle,
            corners,
            frame: frame(corners.map(|corner| vertices[corner])),
            arm: length(vertices[first]),
        }
    }

    fn copied(&self, template: u32, grain: &Grain) -> Copied {
        let [x, y, z] = grain.body.coordinates();
        let corners = self.corners.map(|corner| [x[corner], y[corner], z[corner]]);
        let turn = Rotation3::from_matrix_unchecked(frame(corners) * self.frame.transpose());
        Copied { template, scale: length(corners[0]) / self.arm, turn: Turn::from_rotation_matrix(&turn) }
    }
}

/// The edges of each triangle that the surface bends away from, the lower corner first.
fn ridges(body: &Polyhedron) -> Vec<Vec<[u16; 2]>> {
    let mut opposite = BTreeMap::new();
    for t in body.triangles() {
        (0..3).for_each(|k| {
            opposite.insert([t[k], t[(k + 1) % 3]], t[(k + 2) % 3]);
        });
    }
    let vertex = |corner: u32| body.vertices()[corner as usize];
    let of = |(t, plane): ([u32; 3], Plane)| {
        let bends = |&k: &usize| {
            let beyond = opposite.get(&[t[(k + 1) % 3], t[k]]);
            beyond.is_some_and(|corner| plane.height(&vertex(*corner)) < 0.0)
        };
        let edge = |k: usize| [t[k].min(t[(k + 1) % 3]) as u16, t[k].max(t[(k + 1) % 3]) as u16];
        (0..3).filter(bends).map(edge).collect()
    };
    body.triangles().zip(body.planes()).map(of).collect()
}

fn narrow(v: &Vec3) -> V {
    v.map(|x| x as f32).into()
}

/// A right-handed frame that follows two directions.
fn frame([first, second]: [V; 2]) -> Matrix3<f32> {
    let along = direction_or_up(first);
    let across = direction_or_up(cross(first, second));
    Matrix3::from_columns(&[along, cross(across, along), across].map(Vector3::from))
}

/// The surfaces of the moving bodies.
pub(super) struct Surfaces {
    shapes: Arc<BTreeMap<u32, Shape>>,
    bodies: Vec<Option<Copied>>,
}

impl Surfaces {
    /// True for two bodies that both have dents.
    #[inline]
    pub(super) fn both(&self, a: u32, b: u32) -> bool {
        self.bodies[a as usize].is_some() && self.bodies[b as usize].is_some()
    }

    /// Makes the contact of two hulls that of the surfaces, both with dents, of bodies turned and with corners so; `x` is
    /// from centre to centre.
    #[inline(never)]
    pub(super) fn refine(&self, pair: [u32; 2], at: [(Turn, Points); 2], x: V, want: f32, hulls: &mut FoundContact) {
        let [(turn, p), (turn_of_other, q)] = at;
        let (Some(own), Some(other)) = (self.body(pair[0], turn), self.body(pair[1], turn_of_other)) else { return };
        let ahead = AHEAD * want;
        let mut points = Vec::new();
        let hull = (hulls.normal, hulls.gap);
        let heights = other.corners(&p, (scale(x, -1.0), hull), ahead, |at, height, slope| {
            points.push(Sample { at, height, normal: scale(slope, -1.0) });
        });
        own.corners(&q, (x, (scale(hull.0, -1.0), hull.1)), ahead, |at, height, slope| {
            points.push(Sample { at: add_scaled(at, x, 1.0), height, normal: slope });
        });
        // Ridges decide between bodies that hardly overlap.
        if points.iter().any(|point| point.height < -DEEP * own.span().min(other.span())) {
            return Self::settle(&points, x, want, hulls);
        }
        other.ridges((&own, &p, &heights), (&q, scale(x, -1.0)), ahead, |at, height, slope| {
            points.push(Sample { at, height, normal: scale(slope, -1.0) });
        });
        hulls.gap = ahead;
        Self::settle(&points, x, want, hulls);
    }

    /// The contact of points in both bodies: the deepest one, with those that are pushed the same way.
    fn settle(points: &[Sample], x: V, want: f32, hulls: &mut FoundContact) {
        let Some(deepest) = points.iter().min_by(|p, q| p.height.total_cmp(&q.height)) else { return };
        hulls.gap = deepest.height;
        let (mut sum, mut normal, mut at) = (0.0, [0.0; 3], [0.0; 3]);
        let alike = |point: &&Sample| point.height < want && dot(point.normal, deepest.normal) > ALIKE;
        for point in points.iter().filter(alike) {
            let weight = want - point.height;
            sum += weight;
            normal = add_scaled(normal, point.normal, weight);
            at = add_scaled(at, point.at, weight);
        }
        if sum > 0.0 {
            hulls.normal = direction_or_up(normal);
            hulls.on_a = scale(at, 1.0 / sum);
            hulls.on_b = add_scaled(hulls.on_a, x, -1.0);
        }
    }

    fn body(&self, body: u32, turned: Turn) -> Option<Surface<'_>> {
        let Copied { template, scale, turn } = self.bodies[body as usize]?;
        let turn = (turned * turn).to_rotation_matrix().into_inner();
        Some(Surface { shape: &self.shapes[&template], scale, turn })
    }
}

/// A point of a body near the other one.
struct Sample {
    /// From the centre of the first body, mm.
    at: V,
    height: f32,
    /// From the first body to the second.
    normal: V,
}

/// The surface of a body at its pose.
struct Surface<'a> {
    shape: &'a Shape,
    scale: f32,
    /// From the shape's frame to the specimen's.
    turn: Matrix3<f32>,
}

impl Surface<'_> {
    /// A point about the centre over the surface, mm, with a slope of length 1.
    #[inline(always)]
    fn height(&self, point: V) -> Option<Height<'_>> {
        let of_shape = self.turn.tr_mul(&Vector3::from(point)) / self.scale;
        let Height { height, slope, triangles } = self.shape.heights.at(of_shape.into())?;
        let slope = direction_or_up((self.turn * Vector3::from(slope)).into());
        Some(Height { height: height * self.scale, slope, triangles })
    }

    /// The distance of two points of the grid, mm.
    fn span(&self) -> f32 {
        self.scale * self.shape.heights.spacing()
    }

    /// Calls `each` with those corners of a body that are less than `ahead` mm above this surface, and returns lower
    /// bounds of the heights of all, infinite for those beyond a plane that has nothing of this surface before it. The body's centre is at `x`; its hull ends a hull's `gap` before that of this
    /// surface's body, in the direction `towards` it.
    fn corners(
        &self,
        points: &Points,
        (x, (towards, gap)): (V, (V, f32)),
        ahead: f32,
        mut each: impl FnMut(V, f32, V),
    ) -> Vec<f32> {
        let mut heights: Vec<f32> = (0..points.x.len()).map(|i| dot(points.at(i), towards)).collect();
        let plane = heights.iter().copied().fold(f32::NEG_INFINITY, f32::max) + gap;
        for (i, height) in heights.iter_mut().enumerate() {
            // A corner before the plane is at least as far from the surface.
            *height = plane - *height;
            if *height > ahead {
                *height = f32::INFINITY;
                continue;
            }
            let Some(found) = self.height(add_scaled(points.at(i), x, 1.0)) else {
                *height = height.max(ahead);
                continue;
            };
            *height = found.height;
            if found.height < ahead {
                each(points.at(i), found.height, found.slope);
            }
        }
        heights
    }

    /// Calls `each` with those ridges of a body that cross a ridge of this surface less than `ahead` mm above it. The
    /// body's corners have these `heights`, and its centre is at `x`; the corners of this surface are `own`.
    fn ridges(
        &self,
        (of, points, heights): (&Surface, &Points, &[f32]),
        (own, x): (&Points, V),
        ahead: f32,
        mut each: impl FnMut(V, f32, V),
    ) {
        let span = self.span();
        for [i, j] in of.shape.ridges.iter().map(|edge| edge.map(usize::from)) {
            let from = points.at(i);
            let along = add_scaled(points.at(j), from, -1.0);
            // Heights fall by no more than the way; a ridge with both ends before the plane is there as a whole.
            let (sum, way) = (heights[i] + heights[j], length(along));
            let lowest = heights[i].min(heights[j]);
            if lowest - way > ahead || sum.is_finite() && (sum - way) / 2.0 > ahead {
                continue;
            }
            let share = if sum.is_finite() { 0.5 + (heights[i] - heights[j]) / (2.0 * way) } else { 0.5 };
            let share = share.clamp(0.1, 0.9);
            let Some(over) = self.height(add_scaled(add_scaled(from, along, share), x, 1.0)) else { continue };
            if over.height < ahead {
                each(add_scaled(from, along, share), over.height, over.slope);
            }
            for edge in over.triangles.iter().flat_map(|triangle| &self.shape.by_triangle[usize::from(*triangle)]) {
                let [p, q] = edge.map(|corner| own.at(usize::from(corner)));
                let crossing = crossing((add_scaled(from, x, 1.0), along), (p, add_scaled(q, p, -1.0)));
                let Some((share, across, apart)) = crossing else { continue };
                let sign = if dot(across, over.slope) < 0.0 { -1.0 } else { 1.0 };
                let height = sign * apart;
                let is_near = height < ahead && height > over.height - span;
                if is_near && sign * dot(across, over.slope) > FACING {
                    each(add_scaled(from, along, share), height, scale(across, sign));
                }
            }
        }
    }
}

/// Least cosine between the direction across two ridges and the slope nearby.
const FACING: f32 = 0.5;
/// Lines that are nearly parallel, by the square of the sine of their angle, do not cross.
const PARALLEL: f32 = 1e-4;

/// Where two edges, each a corner and the way to its other one, cross: the share of the first edge, the unit vector
/// across both, and how far along it the first is from the second.
fn crossing((p, d): (V, V), (q, e): (V, V)) -> Option<(f32, V, f32)> {
    let r = add_scaled(p, q, -1.0);
    let (dd, ee, de, dr, er) = (dot(d, d), dot(e, e), dot(d, e), dot(d, r), dot(e, r));
    let determinant = dd * ee - de * de;
    if determinant < PARALLEL * dd * ee {
        return None;
    }
    let (on_first, on_second) = ((de * er - dr * ee) / determinant, (dd * er - de * dr) / determinant);
    let is_on = |share: f32| (0.0..=1.0).contains(&share);
    let across = direction_or_up(cross(d, e));
    (is_on(on_first) && is_on(on_second)).then(|| (on_first, across, dot(across, r)))
}
