//! A body's surface as the fit needs it: edges and corners near a point, and steps along a face.

use crate::cells::owned_volumes;
use crate::planes::{EightPlanes, LANES, bits, each_bit, touched};
use crate::tet::TetMesh;
use meso_collision::geometry::{BodyForm, Plane, Polyhedron, Round, nearest_on_triangle};
use meso_collision::math::{Aabb, Vec3};
use meso_collision::simd::{Wide, widest};

/// Sine of the angle below which planes count as parallel.
const PARALLEL: f64 = 1e-3;

/// Faces, edges and corners of a body.
pub(super) struct Surface {
    planes: Vec<Plane>,
    /// The planes again.
    eights: Vec<EightPlanes>,
    /// The triangle in each plane of a body with dents, beyond which the plane is no part of the surface.
    triangles: Vec<[Vec3; 3]>,
    edges: Edges,
    corners: Vec<Vec3>,
    /// The corners again by eights: x, y and z; the last one is filled up with a corner that it has already.
    eight_corners: Vec<[[f64; LANES]; 3]>,
    /// What its cells are to take, mm3.
    pub(super) volume: f64,
    /// The box of its caps.
    cuts: Aabb,
    /// Points this far from a plane count as on it, mm.
    slack: f64,
    /// A ball or an ellipsoid, without faces, edges and corners.
    round: Option<Round>,
}

/// The distance of a point to the nearest of some planes, and its height over the bound that it exceeds most, mm. Bounds lie
/// so far above the planes.
struct Against<'a>(&'a [EightPlanes], f64, &'a Vec3);

impl Wide for Against<'_> {
    type Output = [f64; 2];

    #[inline(always)]
    fn run(self) -> [f64; 2] {
        let Self(eights, slack, x) = self;
        let (mut nearest, mut highest) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
        for EightPlanes { normal: [nx, ny, nz], offset } in eights {
            for l in 0..LANES {
                let along = nx[l] * x.x + ny[l] * x.y + nz[l] * x.z;
                let (distance, above) = ((along - offset[l]).abs(), along - (offset[l] + slack));
                nearest[l] = if distance < nearest[l] { distance } else { nearest[l] };
                highest[l] = if above > highest[l] { above } else { highest[l] };
            }
        }
        [nearest.into_iter().fold(f64::INFINITY, f64::min), highest.into_iter().fold(f64::NEG_INFINITY, f64::max)]
    }
}

/// A point on a body's surface with the faces there, along which it may move.
pub(super) struct Foothold<'a> {
    surface: &'a Surface,
    x: Vec3,
    faces: Vec<(usize, &'a Plane)>,
}

impl Foothold<'_> {
    /// The point after the part of `step` that lies in all its faces, or `None` where that leaves the faces.
    pub(super) fn after(&self, step: &Vec3) -> Option<Vec3> {
        let Self { surface, x, faces } = self;
        if let Some(round) = &surface.round {
            let normal = round.normal(x);
            return surface.has(x).then(|| round.nearest(&(x + step - normal * normal.dot(step))));
        }
        let step = match faces[..] {
            [(_, plane)] => step - plane.normal * plane.normal.dot(step),
            [(_, first), (_, second)] => {
                let edge = first.normal.cross(&second.normal).normalize();
                edge * edge.dot(step)
            }
            _ => return None,
        };
        self.if_on_faces(x + step)
    }

    /// A `position` that is still on all the faces.
    fn if_on_faces(&self, position: Vec3) -> Option<Vec3> {
        let is_on = |(face, _): &(usize, &Plane)| self.surface.is_on(*face, &position);
        (self.faces.iter().all(is_on) && self.surface.holds(&position)).then_some(position)
    }
}

/// An edge of a body.
#[derive(Clone, Copy)]
struct Edge {
    start: Vec3,
    along: Vec3,
}

/// The edges of a body, by eights; the last one is filled up with an edge that it has already.
#[derive(Default)]
struct Edges {
    count: usize,
    eights: Vec<EightEdges>,
}

/// Coordinates of eight edges.
struct EightEdges {
    start: [[f64; LANES]; 3],
    along: [[f64; LANES]; 3],
    /// `along` over its squared length.
    measure: [[f64; LANES]; 3],
}

impl EightEdges {
    fn new(edges: &[Edge]) -> Self {
        let rows = |of: fn(&Edge) -> Vec3| {
            let lanes: [Vec3; LANES] = std::array::from_fn(|l| of(&edges[l.min(edges.len() - 1)]));
            [0, 1, 2].map(|axis| lanes.map(|lane| lane[axis]))
        };
        let measure = |edge: &Edge| edge.along / edge.along.norm_squared();
        Self { start: rows(|edge| edge.start), along: rows(|edge| edge.along), measure: rows(measure) }
    }
}

impl Edges {
    fn new(edges: &[Edge]) -> Self {
        Self { count: edges.len(), eights: edges.chunks(LANES).map(EightEdges::new).collect() }
    }

    fn iter(&self) -> impl Iterator<Item = Edge> {
        (0..self.count).map(|number| self.edge(number))
    }

    fn edge(&self, number: usize) -> Edge {
        let EightEdges { start, along, .. } = &self.eights[number / LANES];
        let [start, along] = [start, along].map(|rows| Vec3::from_fn(|axis, _| rows[axis][number % LANES]));
        Edge { start, along }
    }

    /// Calls `visit` with the nearest points of the edges to `x`, where they lie between the ends and nearer than the root of `square`.
    fn near(&self, x: &Vec3, square: f64, mut visit: impl FnMut(Vec3)) {
        for (part, eights) in self.eights.chunks(MOST).enumerate() {
            let near = widest(Near { eights, x, square });
            for (eight, shares) in (part * MOST..).zip(&near[..eights.len()]) {
                for (number, t) in (eight * LANES..self.count).zip(shares).filter(|(_, t)| **t > 0.0) {
                    let Edge { start, along } = self.edge(number);
                    visit(start + along * *t);
                }
            }
        }
    }
}

/// Eights that are held against a point together.
const MOST: usize = 16;

/// The shares of some edges at which they come nearest to a point; 0 for those that do so at an end, or not near enough.
struct Near<'a> {
    eights: &'a [EightEdges],
    x: &'a Vec3,
    square: f64,
}

impl Wide for Near<'_> {
    type Output = [[f64; LANES]; MOST];

    #[inline(always)]
    fn run(self) -> Self::Output {
        let (x, mut all) = (self.x, [[0.0; LANES]; MOST]);
        for (shares, eight) in all.iter_mut().zip(self.eights) {
            let EightEdges { start: [sx, sy, sz], along: [ax, ay, az], measure: [mx, my, mz] } = eight;
            for l in 0..LANES {
                let t = (x.x - sx[l]) * mx[l] + (x.y - sy[l]) * my[l] + (x.z - sz[l]) * mz[l];
                let [a, b, c] = [sx[l] + ax[l] * t - x.x, sy[l] + ay[l] * t - x.y, sz[l] + az[l] * t - x.z];
                let is_near = (t > 0.0) & (t < 1.0) & (a * a + b * b + c * c < self.square);
                shares[l] = if is_near { t } else { 0.0 };
            }
        }
        all
    }
}

/// Coordinates of eight points, or of fewer and the last one again.
fn eight_points(points: &[Vec3]) -> [[f64; LANES]; 3] {
    [0, 1, 2].map(|axis| std::array::from_fn(|l| points[l.min(points.len() - 1)][axis]))
}

/// Points of some eights that lie nearer to `x` than the root of `square`.
struct Close<'a> {
    eights: &'a [[[f64; LANES]; 3]],
    x: &'a Vec3,
    square: f64,
}

impl Wide for Close<'_> {
    type Output = u64;

    #[inline(always)]
    fn run(self) -> u64 {
        let (x, mut all) = (self.x, 0);
        for (number, [px, py, pz]) in self.eights.iter().enumerate() {
            let away = |l: usize| [px[l] - x.x, py[l] - x.y, pz[l] - x.z];
            let square = |[a, b, c]: [f64; 3]| a * a + b * b + c * c;
            all |= bits(|l| square(away(l)) < self.square) << (LANES * number);
        }
        all
    }
}

impl Surface {
    /// The surface of `body`, whose cells are to take `volume` mm3; `cuts` is the box of its caps before it was continued.
    pub(super) fn new(body: &Polyhedron, volume: f64, cuts: Aabb) -> Self {
        let slack = SLACK * body.aabb().size().max();
        if let BodyForm::Round(round) = body.form() {
            let (planes, triangles, edges, corners) = (Vec::new(), Vec::new(), Edges::default(), Vec::new());
            let (eights, eight_corners, round) = (Vec::new(), Vec::new(), Some(round));
            return Self { planes, eights, triangles, edges, corners, eight_corners, volume, cuts, slack, round };
        }
        let at = |i: u32| body.vertices()[i as usize];
        let mut edges = Vec::new();
        for face in body.faces() {
            let face: Vec<u32> = face.iter().collect();
            for i in 0..face.len() {
                let (a, b) = (face[i], face[(i + 1) % face.len()]);
                if a < b {
                    edges.push(Edge { start: at(a), along: at(b) - at(a) });
                }
            }
        }
        let planes: Vec<Plane> = body.planes().collect();
        let has_dents = body.form() == BodyForm::Surface;
        let triangles = if has_dents { body.triangles().map(|t| t.map(at)).collect() } else { Vec::new() };
        Self {
            eights: EightPlanes::all(&planes),
            planes,
            triangles,
            edges: Edges::new(&edges),
            eight_corners: body.vertices().chunks(LANES).map(eight_points).collect(),
            corners: body.vertices().to_vec(),
            volume,
            cuts,
            slack,
            round: None,
        }
    }

    /// Whether sides of the box cut the body.
    pub(super) fn has_caps(&self) -> bool {
        self.cuts != Aabb::everywhere()
    }

    /// Whether a point of the specimen lies in the plane of one of its caps.
    pub(super) fn is_cut_at(&self, x: &Vec3) -> bool {
        (0..3).any(|axis| x[axis] <= self.cuts.min[axis] || x[axis] >= self.cuts.max[axis])
    }

    /// Calls `visit` with the corners and the nearest points of the edges within `reach` of `x`.
    pub(super) fn features_near(&self, x: &Vec3, reach: f64, mut visit: impl FnMut(Vec3)) {
        let (eights, square) = (&self.eight_corners, reach * reach);
        each_bit(eights, self.corners.len(), |eights| widest(Close { eights, x, square }), |i| visit(self.corners[i]));
        self.edges.near(x, square, visit);
    }

    /// The faces at `x`.
    pub(super) fn foothold(&self, x: &Vec3) -> Foothold<'_> {
        let mut faces = Vec::new();
        touched(&self.eights, self.planes.len(), x, self.slack, |face| {
            if self.triangle_has(face, x) {
                faces.push((face, &self.planes[face]));
            }
        });
        Foothold { surface: self, x: *x, faces }
    }

    /// Projects a point within the planes through `x` across `axes`, too.
    pub(super) fn along_face_within(&self, x: &Vec3, step: &Vec3, axes: [bool; 3]) -> Option<Vec3> {
        if let Some(round) = &self.round {
            return if self.has(x) { nearest_in_planes(round, &(x + step), axes, self.slack) } else { None };
        }
        let at = self.foothold(x);
        let mut normals: Vec<Vec3> = (0..3).filter(|i| axes[*i]).map(|i| Vec3::ith(i, 1.0)).collect();
        normals.extend(at.faces.iter().map(|(_, plane)| plane.normal));
        let &[first, second] = normals.as_slice() else { return None };
        let edge = first.cross(&second).try_normalize(PARALLEL)?;
        at.if_on_faces(x + edge * edge.dot(step))
    }

    /// Calls `visit` with the positions nearest to `x` on the faces, and with the edges, within the planes through `x` across
    /// `axes`, as far as these are within `reach`.
    pub(super) fn nearest_within(&self, x: &Vec3, axes: [bool; 3], reach: f64, mut visit: impl FnMut(Vec3)) {
        if let Some(round) = &self.round {
            let position = nearest_in_planes(round, x, axes, self.slack);
            return position.filter(|position| (position - x).norm() < reach).into_iter().for_each(visit);
        }
        for (face, plane) in self.planes.iter().enumerate() {
            let direction = Vec3::from_fn(|i, _| if axes[i] { 0.0 } else { plane.normal[i] });
            let step = direction * ((plane.offset - plane.normal.dot(x)) / direction.norm_squared());
            if direction.norm() > PARALLEL && step.norm() < reach && self.face_has(face, &(x + step)) {
                visit(x + step);
            }
        }
        let Some(axis) = (0..3).find(|i| axes[*i]).filter(|_| axes.iter().filter(|held| **held).count() == 1) else {
            return;
        };
        for edge in self.edges.iter() {
            let t = (x[axis] - edge.start[axis]) / edge.along[axis];
            let position = edge.start + edge.along * t;
            if (0.0..=1.0).contains(&t) && (position - x).norm() < reach {
                visit(Vec3::from_fn(|i, _| if axes[i] { x[i] } else { position[i] }));
            }
        }
    }

    /// Calls `visit` with the feet of the perpendiculars from `x` to the faces, as far as these are within `reach`.
    pub(super) fn feet_near(&self, x: &Vec3, reach: f64, mut visit: impl FnMut(Vec3)) {
        if let Some(round) = &self.round {
            let foot = round.nearest(x);
            if (foot - x).norm() < reach {
                visit(foot);
            }
            return;
        }
        for (face, plane) in self.planes.iter().enumerate() {
            let height = plane.height(x);
            let foot = x - plane.normal * height;
            if height.abs() < reach && self.face_has(face, &foot) {
                visit(foot);
            }
        }
    }

    /// Whether `x` lies on the surface.
    pub(super) fn has(&self, x: &Vec3) -> bool {
        if let Some(round) = &self.round {
            return round.height(x).abs() <= self.slack;
        }
        if !self.triangles.is_empty() {
            return (0..self.planes.len()).any(|face| self.is_on(face, x));
        }
        let [nearest, highest] = widest(Against(&self.eights, self.slack, x));
        nearest <= self.slack && highest <= 0.0
    }

    /// Whether `x` lies in the closed convex body. The faces of a body with dents bound themselves.
    fn holds(&self, x: &Vec3) -> bool {
        !self.triangles.is_empty() || widest(Against(&self.eights, self.slack, x))[1] <= 0.0
    }

    /// Whether `x` lies on a face, or on its plane where that bounds a convex body.
    fn is_on(&self, face: usize, x: &Vec3) -> bool {
        self.planes[face].height(x).abs() <= self.slack && self.triangle_has(face, x)
    }

    /// Whether a point of the plane of a face lies on the body's surface.
    fn face_has(&self, face: usize, x: &Vec3) -> bool {
        self.holds(x) && self.triangle_has(face, x)
    }

    /// Whether `x` lies in the triangle of a body with dents.
    fn triangle_has(&self, face: usize, x: &Vec3) -> bool {
        self.triangles.get(face).is_none_or(|triangle| (nearest_on_triangle(triangle, x) - x).norm() <= self.slack)
    }
}

/// The position on a ball or an ellipsoid near `x` in the planes through `x` across `axes`; `None` where they miss it.
///
/// Steps along the gradient within the planes, each to the surface.
fn nearest_in_planes(round: &Round, x: &Vec3, axes: [bool; 3], slack: f64) -> Option<Vec3> {
    let mut position = *x;
    for _ in 0..STEPS {
        let normal = round.normal(&position);
        let way = Vec3::from_fn(|axis, _| if axes[axis] { 0.0 } else { normal[axis] });
        let way = way.try_normalize(PARALLEL)?;
        let (from, to) = round.chord(&position, &way)?;
        let step = if from.abs() < to.abs() { from } else { to };
        position += way * step;
        if step.abs() <= slack {
            return Some(position);
        }
    }
    None
}

/// Most steps to a position in a plane.
const STEPS: usize = 20;

/// Share of a body's size that counts as none.
const SLACK: f64 = 1e-9;

/// A body that lacks this share of its volume, or more, counts in full.
const FULL: f64 = 0.02;

/// How much every body's tetrahedra lack of its volume: 1 for [`FULL`] of it or more, -1 for as much too much.
pub(super) fn volume_deficits(mesh: &TetMesh, surfaces: &[Surface]) -> Vec<f64> {
    let mut volumes = vec![0.0; surfaces.len()];
    owned_volumes(mesh.by_body(), |cell, volume| volumes[mesh.owner[cell] as usize] += volume);
    let deficit = |(surface, volume): (&Surface, f64)| (1.0 - volume / surface.volume) / FULL;
    surfaces.iter().zip(volumes).map(|pair| deficit(pair).clamp(-1.0, 1.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_collision::geometry::convex_hull;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{RngCore, SeedableRng};

    #[test]
    fn a_body_measured_by_eights_has_the_points_and_the_edges_that_its_planes_and_edges_have_one_by_one() {
        let mut random = ChaCha8Rng::seed_from_u64(48);
        let mut point = || Vec3::from_fn(|_, _| f64::from(random.next_u32()) / f64::from(u32::MAX));
        let body = convex_hull(&(0..25).map(|_| point() * 10.0).collect::<Vec<_>>()).unwrap();
        let surface = Surface::new(&body, body.volume(), body.cut_space());
        let (mut on, mut near) = (0, 0);
        for _ in 0..2000 {
            // A foot on one of the planes: on the body or beside it.
            let (x, plane) =
                (point() * 10.0, surface.planes[(point().x * 0.999 * surface.planes.len() as f64) as usize]);
            let x = x - plane.normal * plane.height(&x);
            let holds = surface.planes.iter().all(|p| p.normal.dot(&x) <= p.offset + surface.slack);
            assert_eq!(surface.has(&x), holds);
            on += usize::from(holds);
            let (mut found, mut expected) = (Vec::new(), Vec::new());
            surface.edges.near(&x, 4.0, |position| found.push(position));
            for Edge { start, along } in surface.edges.iter() {
                let t = (x - start).dot(&(along / along.norm_squared()));
                let position = start + along * t;
                if t > 0.0 && t < 1.0 && (position - x).norm_squared() < 4.0 {
                    expected.push(position);
                }
            }
            assert_eq!(found, expected);
            near += found.len();
        }
        assert!((200..1800).contains(&on) && near > 1000, "{on} {near}");
    }
}
