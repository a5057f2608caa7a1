//! A closed surface for every grain of a label volume: smooth, of the volume of its voxels, and apart from all others.
//!
//! 1. A grain is where its blurred share exceeds a level, and the blurred share of all other grains by a margin. So grains
//!    that touch in the labels get a stated gap. The level, given as a depth, is chosen so that the surface has the volume of the
//!    voxels.
//! 2. Marching tetrahedra make the surface, and edges of small quadric error collapse.
//! 3. No surface may cross itself, and every pair is proved apart. Grains that fail are made again with more triangles, at
//!    last with all of them.

use super::field::{Field, Gap, Lattice};
use super::labelled::{LabelledGrain, LabelledGrains};
use crate::parallel;
use crate::watch::{Stage, Watch};
use meso_collision::dents::SelfCrossing;
use meso_collision::geometry::{TriangleMesh, Triangles};
use meso_collision::math::{Aabb, Vec3};
use std::sync::atomic::{AtomicUsize, Ordering};

/// How surfaces are made; all lengths in voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothOptions {
    /// Distance of the nodes of marching tetrahedra; at most 1 for grains of fewer than 12 voxels along an axis.
    pub step: f64,
    /// Standard deviation of the blur.
    pub smoothing: f64,
    /// Root mean square error up to which edges collapse.
    pub tolerance: f64,
}

impl Default for SmoothOptions {
    fn default() -> Self {
        Self { step: 2.0, smoothing: 1.0, tolerance: 0.2 }
    }
}

/// An upright cylinder that all grains stay in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoreCylinder {
    /// Its axis along x and y, mm.
    pub centre_mm: [f64; 2],
    /// Its radius, mm.
    pub radius_mm: f64,
}

/// Why grains have no surfaces.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SurfacesError {
    /// A pair that shares a point with all its triangles.
    #[error("grains {a} and {b}, from 1, cannot be separated: one encloses the other; fill the hollow")]
    Enclosed {
        /// Number of a grain.
        a: usize,
        /// Number of another.
        b: usize,
    },
    /// The user stopped the work.
    #[error("stopped")]
    Stopped,
}

/// Gap between grains that touch in the labels, in voxels, before edges collapse.
const GAP: f64 = 0.5;
/// A grain of fewer voxels along an axis has nodes one voxel apart: chords two voxels long cut off much of it, which its
/// neighbours leave no room to make up for.
const SMALL: usize = 12;
/// Share of the work that the first try of all grains takes.
const FIRST_ROUND: f64 = 0.8;
/// Tries of a grain, by their shares of the tolerance.
const TRIES: [f64; 3] = [1.0, 0.25, 0.0];
/// Largest distance of a reduced surface from the given one, over the root mean square that it was reduced by: a mean over
/// large sides hides what is lost at their edges.
const FAR: f64 = 10.0;
/// Levels that a surface may have, in widths of the blur: shares of 1/4 and 3/4.
const LEVELS: [f64; 2] = [-0.67, 0.67];
/// Faces of a grain's voxels whose distance to its surface is measured, about.
const MEASURED: usize = 500;
/// Vertices this near to a wall, over its distance to the opposite one, lie in it.
const ROUNDING: f64 = 1e-12;
/// Relative error of a grain's volume at which the search for its level ends, and the most steps of that.
const CLOSE: f64 = 0.002;
const STEPS: usize = 6;

/// Grains of a volume, and how to make surfaces of them.
pub struct GrainSurfaces<'a> {
    parts: &'a LabelledGrains,
    spacing_mm: Vec3,
    options: SmoothOptions,
    round: Option<CoreCylinder>,
    /// Least gap between grains, mm; 0 for half a voxel.
    gap_mm: f64,
    lattice: Lattice,
    /// For grains of fewer than [`SMALL`] voxels.
    fine: Lattice,
}

impl<'a> GrainSurfaces<'a> {
    /// Surfaces of `parts`, whose voxels have these edges.
    pub fn new(parts: &'a LabelledGrains, spacing_mm: [f64; 3], options: SmoothOptions) -> Self {
        let lattice = |step: f64| Lattice::new(parts.counts, step, options.smoothing);
        let (lattice, fine) = (lattice(options.step), lattice(options.step.min(1.0)));
        Self { parts, spacing_mm: spacing_mm.into(), options, round: None, gap_mm: 0.0, lattice, fine }
    }

    /// Ends all grains at a cylinder.
    #[must_use]
    pub fn within(mut self, round: Option<CoreCylinder>) -> Self {
        self.round = round;
        self
    }

    /// Leaves this gap between grains, mm, or half a voxel where that is more.
    #[must_use]
    pub fn apart(mut self, gap_mm: f64) -> Self {
        self.gap_mm = if gap_mm > GAP * self.spacing_mm.min() { gap_mm } else { 0.0 };
        self
    }

    /// The surface of every grain, mm; `None` where a grain is too thin to be seen after the blur.
    ///
    /// # Errors
    /// See [`SurfacesError`].
    pub fn all(&self, watch: &dyn Watch) -> Result<Vec<Option<TriangleMesh>>, SurfacesError> {
        let count = self.parts.grains.len();
        let mut tries = vec![0; count];
        let mut found: Vec<Option<Solid>> = (0..count).map(|_| None).collect();
        let mut due: Vec<usize> = (0..count).collect();
        while !due.is_empty() {
            let done = AtomicUsize::new(0);
            let made = parallel::map(due.len(), |k| {
                let solid = if watch.stops() { None } else { self.solid(due[k], tries[due[k]]) };
                let done = done.fetch_add(1, Ordering::Relaxed) as f64;
                watch.stage(Stage::Take, FIRST_ROUND * if due.len() == count { done / count as f64 } else { 1.0 });
                solid
            });
            if watch.stops() {
                return Err(SurfacesError::Stopped);
            }
            for (&grain, made) in due.iter().zip(made) {
                if let Some((solid, used)) = made {
                    tries[grain] = used;
                    found[grain] = Some(solid);
                }
            }
            due = self.meeting(&found, &mut tries)?;
        }
        Ok(found.into_iter().map(|solid| solid.map(|solid| solid.mesh)).collect())
    }

    /// The grains to be made again, since they share a point with another.
    fn meeting(&self, found: &[Option<Solid>], tries: &mut [usize]) -> Result<Vec<usize>, SurfacesError> {
        let mut due = Vec::new();
        for (a, b) in meeting_pairs(found, self.gap_mm) {
            let last = TRIES.len() - 1;
            let is_last = tries[a] == last && tries[b] == last;
            if is_last && self.gap_mm > 0.0 && are_apart(&found[a], &found[b]) {
                continue;
            }
            if is_last {
                return Err(SurfacesError::Enclosed { a: a + 1, b: b + 1 });
            }
            due.extend([a, b].into_iter().filter(|&grain| tries[grain] < last));
        }
        due.sort_unstable();
        due.dedup();
        due.iter().for_each(|&grain| tries[grain] += 1);
        Ok(due)
    }

    /// The surface of a grain from its next try on that does not cross itself, and that try.
    fn solid(&self, grain: usize, first: usize) -> Option<(Solid, usize)> {
        let LabelledGrain { from, to, .. } = &self.parts.grains[grain];
        let is_small = (0..3).any(|axis| to[axis] - from[axis] < SMALL);
        let lattice = if is_small { &self.fine } else { &self.lattice };
        let mut field = lattice.field(self.parts, grain as u32 + 1);
        if let Some(round) = &self.round {
            let [hx, hy] = [self.spacing_mm.x, self.spacing_mm.y];
            // Distances are convex, so what is interpolated between nodes lies within.
            let depth = |[x, y]: [f64; 2]| -round.beyond(x * hx, y * hy) / (hx.min(hy) * self.options.smoothing);
            field.cut(self.margin() as f32, depth);
        }
        if self.gap_mm > 0.0 {
            // Marched surfaces are within a quarter of a voxel of the field's.
            let (h, spacing_mm) = (self.spacing_mm.min(), self.spacing_mm.into());
            let gap = Gap { gap_mm: self.gap_mm + GAP / 2.0 * h, spacing_mm, width_mm: h * self.options.smoothing };
            field.keep_off(self.parts, grain as u32 + 1, &gap, self.margin() as f32);
        }
        let given = self.of_volume(&field, self.parts.grains[grain].voxels)?;
        let solids = (first..TRIES.len()).map(|number| (self.tried(grain, &given, TRIES[number]), number));
        let mut solids = solids.map(|(mesh, number)| (Solid::new(mesh), number));
        let is_right = |solid: &Solid, number: usize| {
            solid.is_near(&given, FAR * self.limit_mm(TRIES[number])) && !solid.crosses_itself()
        };
        solids.find(|(solid, number)| *number + 1 == TRIES.len() || is_right(solid, *number))
    }

    /// The surface of a field whose volume is that of so many voxels as nearly as its neighbours allow, mm, without its hollows.
    fn of_volume(&self, field: &Field, voxels: usize) -> Option<TriangleMesh> {
        let target = voxels as f64 * self.spacing_mm.product();
        let margin = self.margin();
        let [mut low, mut high] = LEVELS;
        let (mut level, mut last) = (0.0, None);
        let mut best: Option<(f64, TriangleMesh)> = None;
        for _ in 0..STEPS {
            let mesh = self.marched(field, level, margin);
            let excess = mesh.volume() - target;
            if excess > 0.0 {
                low = level;
            } else {
                high = level;
            }
            let slope = match last {
                Some((before, old)) if before != excess => (excess - before) / (level - old),
                // The slope of a plane surface.
                _ => -self.options.smoothing * self.spacing_mm.min() * area(&mesh),
            };
            last = Some((excess, level));
            if best.as_ref().is_none_or(|best| excess.abs() < best.0) {
                best = Some((excess.abs(), mesh));
            }
            if excess.abs() < CLOSE * target {
                break;
            }
            let next = level - excess / slope;
            level = if next > low && next < high { next } else { (low + high) / 2.0 };
        }
        let parts = best?.1.components().into_iter();
        let outer = parts.max_by(|a, b| a.volume().total_cmp(&b.volume()))?;
        (outer.volume() > 0.0).then_some(outer)
    }

    /// Root mean square error of a reduced surface, for a share of the tolerance.
    fn limit_mm(&self, share: f64) -> f64 {
        share * self.options.tolerance * self.spacing_mm.min()
    }

    /// Half of the gap of grains that touch, in widths of the blur.
    fn margin(&self) -> f64 {
        GAP / 2.0 / self.options.smoothing
    }

    fn marched(&self, field: &Field, level: f64, margin: f64) -> TriangleMesh {
        let mut mesh = field.nodes(level as f32, margin as f32).surface();
        let scale = Vec3::from(field.spacing).component_mul(&self.spacing_mm);
        let from = Vec3::from_fn(|axis, _| field.from[axis] as f64 - 0.5);
        mesh.vertices.iter_mut().for_each(|v| *v = self.in_walls((*v + from).component_mul(&scale), |_| 0.0));
        mesh
    }

    /// The largest distance of a face between a grain's voxels and others to its surface, mm; some of the faces are measured.
    pub fn farthest(&self, meshes: &[Option<TriangleMesh>]) -> f64 {
        let of = |grain: usize| meshes[grain].as_ref().map_or(0.0, |mesh| self.farthest_of(grain, mesh));
        parallel::map(meshes.len(), of).into_iter().fold(0.0, f64::max)
    }

    fn farthest_of(&self, grain: usize, mesh: &TriangleMesh) -> f64 {
        let facets = mesh.facets();
        let faces = self.faces(grain);
        let every = faces.len().div_ceil(MEASURED).max(1);
        let farther = |most: f64, face: &Vec3| {
            if facets.is_within(face, most) { most } else { facets.nearest(face).map_or(most, |near| near.1.max(most)) }
        };
        faces.iter().step_by(every).fold(0.0, farther)
    }

    /// Middles of the faces between voxels of a grain and others, mm.
    fn faces(&self, grain: usize) -> Vec<Vec3> {
        let (part, number) = (&self.parts.grains[grain], grain as u32 + 1);
        let mut faces = Vec::new();
        let [xs, ys, zs] = [0, 1, 2].map(|axis| part.from[axis]..part.to[axis]);
        for (y, z) in zs.flat_map(|z| ys.clone().map(move |y| (y, z))) {
            let row = (z * self.parts.counts[1] + y) * self.parts.counts[0];
            for x in xs.clone().filter(|x| self.parts.of[row + x] == number) {
                let middle = Vec3::new(x as f64, y as f64, z as f64).add_scalar(0.5);
                for (axis, step) in self.parts.steps().into_iter().enumerate() {
                    let at = [x, y, z][axis];
                    let mut add = |other: usize, side: f64| {
                        if self.parts.of[other] != number {
                            let face = middle + Vec3::ith(axis, side);
                            faces.push(face.component_mul(&self.spacing_mm));
                        }
                    };
                    if at > 0 {
                        add(row + x - step, -0.5);
                    }
                    if at + 1 < self.parts.counts[axis] {
                        add(row + x + step, 0.5);
                    }
                }
            }
        }
        faces
    }

    fn walls(&self) -> Aabb {
        let max = Vec3::from_fn(|axis, _| self.parts.counts[axis] as f64 * self.spacing_mm[axis]);
        Aabb { min: Vec3::zeros(), max }
    }

    /// A vertex, in the walls that it is beyond or as `near` as this for each, mm.
    fn in_walls(&self, mut vertex: Vec3, near: impl Fn(usize) -> f64) -> Vec3 {
        let walls = self.walls();
        for side in 0..6 {
            let (x, wall) = (&mut vertex[side / 2], walls.end(side));
            let within = if side % 2 == 0 { *x - wall } else { wall - *x };
            if within <= near(side).max(ROUNDING * walls.max[side / 2]) {
                *x = wall;
            }
        }
        if let Some(round) = &self.round {
            round.draw_in(&mut vertex);
        }
        vertex
    }

    /// A surface with fewer triangles; vertices near a wall that the grain touches lie in it.
    fn tried(&self, grain: usize, given: &TriangleMesh, share: f64) -> TriangleMesh {
        let limit = self.limit_mm(share);
        let mut mesh = given.clone();
        if limit > 0.0 {
            mesh = given.simplified(limit, &self.walls());
            // Merged triangles changed the volume a little. Caps stay in their walls.
            let walls = self.walls();
            let in_wall =
                |t: &[u32; 3], side: usize| t.iter().all(|&v| mesh.vertices[v as usize][side / 2] == walls.end(side));
            let free = mesh.triangles.iter().filter(|t| !(0..6).any(|side| in_wall(t, side))).copied().collect();
            let free = TriangleMesh { vertices: mesh.vertices.clone(), triangles: free };
            let offset = (given.volume() - mesh.volume()) / area(&free);
            let normals = normals(&free);
            mesh.vertices.iter_mut().zip(normals).for_each(|(vertex, normal)| *vertex += normal * offset);
        }
        let (part, counts) = (&self.parts.grains[grain], &self.parts.counts);
        let reaches = |axis: usize| [part.from[axis] == 0, part.to[axis] == counts[axis]];
        let near = |side: usize| if reaches(side / 2)[side % 2] { 1.5 * limit } else { 0.0 };
        mesh.vertices.iter_mut().for_each(|v| *v = self.in_walls(*v, near));
        mesh
    }
}

impl CoreCylinder {
    /// How far a place lies beyond the cylinder, mm; negative within.
    fn beyond(&self, x: f64, y: f64) -> f64 {
        libm::hypot(x - self.centre_mm[0], y - self.centre_mm[1]) - self.radius_mm
    }

    /// Draws a vertex beyond the cylinder towards its axis.
    fn draw_in(&self, vertex: &mut Vec3) {
        let [x, y] = self.centre_mm;
        let within = self.radius_mm * (1.0 - ROUNDING) / libm::hypot(vertex.x - x, vertex.y - y);
        if within < 1.0 {
            (vertex.x, vertex.y) = (x + within * (vertex.x - x), y + within * (vertex.y - y));
        }
    }
}

/// A surface, and its triangles by where they lie.
struct Solid {
    mesh: TriangleMesh,
    facets: Triangles,
}

impl Solid {
    fn new(mesh: TriangleMesh) -> Self {
        Self { facets: mesh.facets(), mesh }
    }

    /// Whether some of the vertices of another surface are all within this distance, mm.
    fn is_near(&self, given: &TriangleMesh, most_mm: f64) -> bool {
        let every = given.vertices.len().div_ceil(MEASURED).max(1);
        given.vertices.iter().step_by(every).all(|v| self.facets.is_within(v, most_mm))
    }

    fn crosses_itself(&self) -> bool {
        self.mesh.check_closed().is_err() || (SelfCrossing { mesh: &self.mesh, facets: &self.facets }).find().is_some()
    }
}

/// Are two surfaces proved apart?
fn are_apart(a: &Option<Solid>, b: &Option<Solid>) -> bool {
    matches!((a, b), (Some(a), Some(b)) if a.facets.is_apart(&b.facets, 0.0))
}

/// The pairs of surfaces that are not proved this far apart.
fn meeting_pairs(found: &[Option<Solid>], gap_mm: f64) -> Vec<(usize, usize)> {
    let mut boxes: Vec<(Aabb, usize, &Solid)> = Vec::new();
    for (number, solid) in found.iter().enumerate() {
        boxes.extend(solid.as_ref().map(|solid| (solid.facets.aabb(), number, solid)));
    }
    boxes.sort_by(|a, b| a.0.min.x.total_cmp(&b.0.min.x).then(a.1.cmp(&b.1)));
    parallel::flat_map(boxes.len(), |k| {
        let (own, number, solid) = &boxes[k];
        let later = boxes[k + 1..].iter().take_while(|other| other.0.min.x <= own.max.x + gap_mm);
        let meets = |other: &&(Aabb, usize, &Solid)| {
            own.intersects(&other.0.grown(gap_mm)) && !solid.facets.is_apart(&other.2.facets, gap_mm)
        };
        later.filter(meets).map(|other| (*number, other.1)).collect::<Vec<_>>()
    })
}

fn area(mesh: &TriangleMesh) -> f64 {
    mesh.triangles.iter().map(|t| cross(mesh, t).norm() / 2.0).sum()
}

fn cross(mesh: &TriangleMesh, [a, b, c]: &[u32; 3]) -> Vec3 {
    let [a, b, c] = [a, b, c].map(|i| mesh.vertices[*i as usize]);
    (b - a).cross(&(c - a))
}

/// Unit normals at the vertices, by the areas of their triangles.
fn normals(mesh: &TriangleMesh) -> Vec<Vec3> {
    let mut normals = vec![Vec3::zeros(); mesh.vertices.len()];
    for triangle in &mesh.triangles {
        let cross = cross(mesh, triangle);
        triangle.iter().for_each(|i| normals[*i as usize] += cross);
    }
    normals.iter().map(|normal| normal.try_normalize(0.0).unwrap_or_default()).collect()
}
