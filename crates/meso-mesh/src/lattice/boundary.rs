//! The specimen's own surface where the specimen is no box, and the constraints of nodes on it and on the lattice's flat sides.
//!
//! The lattice reaches a cell beyond the specimen's box. It ends at a side that is flat and meets the rest steeply (the ends
//! of a cylinder), and the surface is cut within that side. The container tells which points it holds and how deep; its
//! polygons tell where it has edges.

use crate::tet::Star;
use meso_collision::math::Vec3;
use meso_concrete::specimen::{Container, Surface};

/// Surfaces that meet at more than this angle have an edge between them: its cosine, 30 degrees.
const SHARP: f64 = 0.866;
/// A side of the box is flat where nothing else touches it at less than 45 degrees: the cosine of that.
const STEEP: f64 = 0.708;
/// Steps of the search for a crossing.
const STEPS: usize = 100;

/// The surface of a container.
pub(super) struct BoundarySurface<'a> {
    container: &'a dyn Container,
    edges: Vec<SurfaceEdge>,
    /// The sides of the container's box, low and high by axis, beyond which there is surface to be met.
    pub(super) open: [[bool; 2]; 3],
    /// Points this far from the surface count as on it, mm.
    slack: f64,
}

/// An edge of the surface.
struct SurfaceEdge {
    start: Vec3,
    along: Vec3,
    /// 1 where the container has less than half of the space around, -1 where it has more.
    stands_out: f64,
}

impl<'a> BoundarySurface<'a> {
    /// The surface of `container`, or `None` for a box.
    pub(super) fn new(container: &'a dyn Container) -> Option<Self> {
        if container.is_box() {
            return None;
        }
        let (surface, aabb) = (container.surface(), container.aabb());
        let slack = 1e-9 * aabb.size().max();
        let normals: Vec<Vec3> = surface.faces.iter().map(|face| normal(&surface, face)).collect();
        let on = |node: u32, axis: usize, high: usize| {
            let plane = [aabb.min, aabb.max][high][axis];
            (surface.points[node as usize][axis] - plane).abs() <= slack
        };
        let open =
            [0, 1, 2].map(|axis| [0, 1].map(|high| !ends(&surface, &normals, axis, |node| on(node, axis, high))));
        let in_end = |pair: [u32; 2]| {
            let within = |axis: usize, high: usize| !open[axis][high] && pair.iter().all(|&node| on(node, axis, high));
            (0..6).any(|side| within(side / 2, side % 2))
        };
        let edges = edges(&surface, &normals, in_end);
        Some(Self { container, edges, open, slack })
    }

    /// Whether the closed container has `x`.
    pub(super) fn contains(&self, x: &Vec3) -> bool {
        self.container.contains(x)
    }

    /// The part of the segment from `outside` to `inside` that lies outside, 0 to 1.
    pub(super) fn exit(&self, outside: &Vec3, inside: &Vec3) -> f64 {
        let at = |t: f64| outside + (inside - outside) * t;
        let depth = |t: f64| self.container.depth(&at(t));
        let (mut low, mut high) = ((0.0, depth(0.0)), (1.0, depth(1.0)));
        if low.1 >= 0.0 {
            return 0.0;
        }
        if high.1 < 0.0 {
            return 1.0;
        }
        // Regula falsi (Illinois); halves where the depth is no measure, as in a side of the box.
        let mut last = 0;
        for step in 0..STEPS {
            if high.0 - low.0 < 1e-15 {
                break;
            }
            let t = if high.1 <= 0.0 || step % 4 == 3 {
                (low.0 + high.0) / 2.0
            } else {
                (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1)
            };
            let t = t.clamp(low.0, high.0);
            let d = depth(t);
            if d >= 0.0 {
                high = (t, d);
                if last == 1 {
                    low.1 /= 2.0;
                }
                last = 1;
            } else {
                low = (t, d);
                if last == -1 {
                    high.1 /= 2.0;
                }
                last = -1;
            }
            if d.abs() < 1e-6 * self.slack && high.1 > 0.0 {
                return t;
            }
        }
        high.0
    }

    /// Whether `x` lies on the surface, which looks towards `outwards`.
    pub(super) fn has(&self, x: &Vec3, outwards: &Vec3) -> bool {
        let step = outwards * self.slack;
        self.contains(&(x - step)) && !self.contains(&(x + step))
    }

    /// The point of the surface from `x` on, forwards or backwards along `outwards`, at most `reach` away.
    pub(super) fn along(&self, x: &Vec3, outwards: &Vec3, reach: f64) -> Option<Vec3> {
        let (inside, outside) = (x - outwards * reach, x + outwards * reach);
        if !self.contains(&inside) || self.contains(&outside) {
            return None;
        }
        Some(outside + (inside - outside) * self.exit(&outside, &inside))
    }

    /// Calls `visit` with the nearest points of the edges within `reach` of `x`, and whether volume is gained (1) or lost
    /// (-1) where the surface takes them in.
    pub(super) fn edges_near(&self, x: &Vec3, reach: f64, mut visit: impl FnMut(Vec3, f64)) {
        for edge in &self.edges {
            let t = (x - edge.start).dot(&edge.along) / edge.along.norm_squared();
            let nearest = edge.start + edge.along * t.clamp(0.0, 1.0);
            if (nearest - x).norm_squared() < reach * reach {
                visit(nearest, edge.stands_out);
            }
        }
    }
}

/// Whether the lattice may end at the side of the box across `axis` whose points are `on` it: there the surface is flat,
/// and meets the rest steeply.
fn ends(surface: &Surface, normals: &[Vec3], axis: usize, on: impl Fn(u32) -> bool) -> bool {
    let faces = surface.faces.iter().zip(normals);
    let touching = faces.filter(|(face, _)| face.iter().any(|&node| on(node)));
    let (flat, others): (Vec<_>, Vec<_>) = touching.partition(|(face, _)| face.iter().all(|&node| on(node)));
    !flat.is_empty() && others.iter().all(|(_, normal)| normal[axis].abs() <= STEEP)
}

/// Unit normal of a polygon (Newell's), outward.
fn normal(surface: &Surface, face: &[u32]) -> Vec3 {
    let p = |i: usize| surface.points[face[i % face.len()] as usize] - surface.points[face[0] as usize];
    let sum: Vec3 = (1..face.len()).map(|i| p(i).cross(&p(i + 1))).sum();
    sum.try_normalize(0.0).unwrap_or_default()
}

/// The sharp edges that `skip` does not want.
fn edges(surface: &Surface, normals: &[Vec3], skip: impl Fn([u32; 2]) -> bool) -> Vec<SurfaceEdge> {
    let mut sides: Vec<([u32; 2], usize, bool)> = Vec::new();
    for (number, face) in surface.faces.iter().enumerate() {
        for (i, &a) in face.iter().enumerate() {
            let b = face[(i + 1) % face.len()];
            sides.push(([a.min(b), a.max(b)], number, a < b));
        }
    }
    sides.sort_unstable();
    let pairs = sides.chunk_by(|a, b| a.0 == b.0).filter(|pair| pair.len() == 2 && !skip(pair[0].0));
    let edge = |pair: &[([u32; 2], usize, bool)]| {
        // The face that runs along the edge from its start, then the other.
        let [first, second] =
            if pair[0].2 { [pair[0].1, pair[1].1] } else { [pair[1].1, pair[0].1] }.map(|f| normals[f]);
        let [start, end] = pair[0].0.map(|n| surface.points[n as usize]);
        let stands_out = first.cross(&second).dot(&(end - start)).signum();
        (first.dot(&second) < SHARP).then_some(SurfaceEdge { start, along: end - start, stands_out })
    };
    pairs.filter_map(edge).collect()
}

/// Constraints of the nodes on the specimen's surface.
pub(super) struct Boundary<'a> {
    /// The surface where it is not the lattice's box, and which nodes lie on it.
    pub(super) surface: Option<(&'a BoundarySurface<'a>, Vec<bool>)>,
    /// The axes along which the specimen repeats itself: nodes on the sides across these stay where they are.
    pub(super) repeats: [bool; 3],
}

impl Boundary<'_> {
    /// Constraint of node number `node`, which lies on the box's sides across `axes`.
    pub(super) fn hold(&self, node: usize, axes: [bool; 3]) -> Option<Hold> {
        let outer = self.surface.as_ref().is_some_and(|(_, outer)| outer[node]);
        (outer || axes.contains(&true)).then_some(Hold { axes, outer })
    }

    /// Whether a node held like this stays where it is.
    pub(super) fn fixes(&self, hold: Hold) -> bool {
        (0..3).any(|axis| hold.axes[axis] && self.repeats[axis])
    }

    /// Whether the specimen ends at a side across one of `axes`.
    pub(super) fn ends(&self, axes: [bool; 3]) -> bool {
        (0..3).any(|axis| axes[axis] && !self.repeats[axis])
    }
}

/// Which coordinates a node keeps, since it lies on a flat side across that axis, and whether it lies on the boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Hold {
    pub(super) axes: [bool; 3],
    pub(super) outer: bool,
}

/// How far from a moved node the boundary is looked for, in elements.
const SEARCH: f64 = 0.3;
/// A node off the boundary looks for it this far, in elements.
const RETURN: f64 = 0.6;
/// How far away edges of the boundary are looked for, in elements.
const EDGE: f64 = 0.7;
/// Least gain of six times the volume where a node takes an edge in, in elements' cubes.
const LEAST: f64 = 1e-6;
/// A node that moves on the boundary stays on its side of an edge: sine of the most that it may rise.
const RISE: f64 = 0.05;

/// Constraint that keeps a moving node on the specimen's surface.
#[derive(Clone, Copy)]
pub(super) struct BoundaryTrack {
    axes: [bool; 3],
    /// Out of the specimen, without the directions that flat sides forbid; `None` for a node that has not to keep to the boundary.
    outwards: Option<Vec3>,
}

impl BoundaryTrack {
    pub(super) fn of(star: &Star, hold: Hold) -> Self {
        let free = Self { axes: hold.axes, outwards: None };
        // The specimen gains by a move as much as all of the star's tetrahedra together.
        let outwards = free.allowed(&star.gain(|_| 1.0)).try_normalize(0.0).filter(|_| hold.outer);
        Self { outwards, ..free }
    }

    /// Let off the boundary, but not off the flat sides.
    pub(super) fn released(self) -> Self {
        Self { outwards: None, ..self }
    }

    /// `x` after the part of `step` that the surface allows, with elements of `size` mm.
    pub(super) fn after(&self, boundary: &Boundary, x: &Vec3, step: &Vec3, size: f64) -> Option<Vec3> {
        let position = x + self.allowed(step);
        match (&self.outwards, &boundary.surface) {
            (Some(outwards), Some((surface, _))) => surface.along(&position, outwards, SEARCH * size),
            _ => Some(position),
        }
    }

    /// Whether a move leaves the boundary's faces for an edge, or an edge for a face.
    pub(super) fn rises(&self, step: &Vec3) -> bool {
        self.outwards.is_some_and(|outwards| outwards.dot(step).abs() > RISE * step.norm())
    }

    /// Positions that bring the specimen's volume nearer, with the volume they gain: onto the boundary for a node off it, else
    /// onto its edges.
    pub(super) fn positions(&self, boundary: &Boundary, star: &Star, size: f64) -> Vec<(f64, Vec3)> {
        let x = &star.centre;
        let (Some(outwards), Some((surface, _))) = (&self.outwards, &boundary.surface) else { return Vec::new() };
        if !surface.has(x, outwards) {
            return surface.along(x, outwards, RETURN * size).map(|position| (0.0, position)).into_iter().collect();
        }
        let gain = star.gain(|_| 1.0);
        let mut positions = Vec::new();
        surface.edges_near(x, EDGE * size, |position, stands_out| {
            let step = position - x;
            let gained = stands_out * gain.dot(&step);
            let leaves = (0..3).any(|axis| self.axes[axis] && step[axis].abs() > 1e-9 * size);
            if gained > LEAST * size * size * size && !leaves {
                positions.push((gained, x + self.allowed(&step)));
            }
        });
        positions
    }

    fn allowed(&self, step: &Vec3) -> Vec3 {
        Vec3::from_fn(|axis, _| if self.axes[axis] { 0.0 } else { step[axis] })
    }
}
