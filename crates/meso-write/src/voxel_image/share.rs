//! The share of every voxel that bodies take, exact to rounding; sampled where a core has no surface.
//!
//! In a column of voxels along x, a body lies between its faces towards -x and its faces towards +x. So every face is
//! divided by the planes between voxels, and each piece counts twice: the volume between it and its voxel's lower side,
//! and its projection, which all voxels below it in the column have whole (the divergence theorem). The work grows with
//! the surface, not with the planes that cross a voxel.
//!
//! The core of a body with dents or an ellipsoid is the set of its points deeper than the ITZ. Its share is sampled in the
//! voxels that its surface may cross.

use super::options::ShareOf;
use meso_collision::geometry::Polyhedron;
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::aggregate::{Aggregate, Kind};
use meso_concrete::parallel;
use meso_concrete::stop;
use meso_mesh::location::{Facets, PointGrid};
use meso_view::section::divide;
use std::ops::Range;

/// Bodies whose shares are added up, or subtracted.
pub(super) struct Shares {
    grid: PointGrid,
    bodies: Vec<Body>,
    by_layer: Vec<Vec<u32>>,
}

struct Body {
    form: Form,
    aabb: Aabb,
    /// 1, or -1 of the core that a shell lacks.
    sign: f32,
}

enum Form {
    /// A closed surface.
    Surface(Polyhedron),
    /// The points deeper than the shell.
    Deeper(Box<Facets>),
}

/// Halvings of a voxel that the surface of a sampled core may cross.
const HALVINGS: usize = 2;

/// Shares this close to 0 or 1 are; rounding leaves less.
const WHOLE: f64 = 1e-9;

impl Shares {
    pub(super) fn new(grid: PointGrid, of: ShareOf, aggregates: &[Aggregate]) -> Self {
        Self::of(grid, parallel::flat_map(aggregates.len(), |number| parts(&aggregates[number], of)))
    }

    fn of(grid: PointGrid, bodies: Vec<Body>) -> Self {
        let mut by_layer = vec![Vec::new(); grid.counts[2]];
        for (index, body) in bodies.iter().enumerate() {
            touched(&grid, 2, &body.aabb).for_each(|k| by_layer[k].push(index as u32));
        }
        Self { grid, bodies, by_layer }
    }

    /// Adds the shares of all bodies in the voxels of layer `k`.
    pub(super) fn add(&self, k: usize, layer: &mut [f32]) {
        let mut columns = ColumnLayer::default();
        for &index in &self.by_layer[k] {
            stop::point();
            let body = &self.bodies[index as usize];
            match &body.form {
                Form::Surface(surface) => {
                    columns.fill(&self.grid, k, surface, &body.aabb);
                    columns.add_to(&self.grid, body.sign, layer);
                }
                Form::Deeper(facets) => add_sampled(&self.grid, k, facets, body, layer),
            }
        }
    }
}

/// Adds the shares of the points deeper than the shell in the voxels of layer `k`.
fn add_sampled(grid: &PointGrid, k: usize, facets: &Facets, body: &Body, layer: &mut [f32]) {
    let half = grid.spacing.x / 2.0;
    for j in touched(grid, 1, &body.aabb) {
        for i in touched(grid, 0, &body.aabb) {
            let middle = Vec3::new(grid.coordinate(0, i), grid.coordinate(1, j), grid.coordinate(2, k));
            let voxel = Aabb { min: middle, max: middle }.grown(half);
            let volume = voxel.volume_above(HALVINGS, |point| facets.depth_below_shell(point));
            layer[j * grid.counts[0] + i] += body.sign * snapped(volume / (8.0 * half.powi(3))) as f32;
        }
    }
}

/// The parts of an aggregate that count.
fn parts(aggregate: &Aggregate, of: ShareOf) -> Vec<Body> {
    stop::point();
    let part = |surface: Polyhedron, sign: f32| Body { aabb: surface.aabb(), form: Form::Surface(surface), sign };
    // A ball or an ellipsoid counts by facets that hold its volume.
    let faceted = |body: &Polyhedron| body.faceted().into_owned();
    let whole = || part(faceted(&aggregate.body), 1.0);
    let core = |sign: f32| aggregate.core().ok().flatten().map(|core| part(faceted(&core), sign));
    let (thickness, aabb) = (aggregate.itz_thickness_mm, aggregate.body.aabb());
    let deeper = |than: f64, sign: f32| Body { aabb, form: Form::Deeper(Box::new(Facets::of(aggregate, than))), sign };
    let is_sampled = thickness > 0.0 && !aggregate.body.has_inner_body();
    match (of, aggregate.kind) {
        (ShareOf::Aggregate, Kind::Aggregate) | (ShareOf::Void, Kind::Void) | (ShareOf::Fibre, Kind::Fibre) => {
            vec![whole()]
        }
        (ShareOf::Core, Kind::Aggregate) if is_sampled => vec![deeper(thickness, 1.0)],
        // Both sides of the shell have one error, so no share is negative.
        (ShareOf::Itz, Kind::Aggregate) if is_sampled => vec![deeper(0.0, 1.0), deeper(thickness, -1.0)],
        (ShareOf::Core, Kind::Aggregate) => core(1.0).into_iter().collect(),
        (ShareOf::Itz, Kind::Aggregate) => std::iter::once(whole()).chain(core(-1.0)).collect(),
        _ => Vec::new(),
    }
}

/// The voxels along an axis that a body's box reaches into.
fn touched(grid: &PointGrid, axis: usize, aabb: &Aabb) -> Range<usize> {
    let half = grid.spacing[axis] / 2.0;
    grid.range(axis, aabb.min[axis] - half, aabb.max[axis] + half)
}

/// The lower side of a voxel.
fn side(grid: &PointGrid, axis: usize, voxel: usize) -> f64 {
    grid.coordinate(axis, voxel) - grid.spacing[axis] / 2.0
}

/// One layer of the columns that a body reaches into.
#[derive(Default)]
struct ColumnLayer {
    across: Range<usize>,
    along: Range<usize>,
    /// Pieces by column and voxel, and one more for the space beyond the last voxel.
    pieces: Vec<Pieces>,
    knives: [Knife; 2],
}

/// Sums over the pieces of faces in a voxel.
#[derive(Clone, Copy, Default)]
struct Pieces {
    /// Their projections along x, mm2; negative where they look to -x.
    area: f64,
    /// The volume between them and the voxel's lower side, mm3, signed as the area.
    volume: f64,
}

impl ColumnLayer {
    fn fill(&mut self, grid: &PointGrid, k: usize, surface: &Polyhedron, aabb: &Aabb) {
        (self.across, self.along) = (touched(grid, 1, aabb), touched(grid, 0, aabb));
        self.pieces.clear();
        self.pieces.resize(self.across.len() * (self.along.len() + 1), Pieces::default());
        let (bottom, top) = (side(grid, 2, k), side(grid, 2, k + 1));
        let Self { across, along, pieces, knives: [by_y, by_x] } = self;
        let [mut above, mut layer, mut rest] = [const { Vec::new() }; 3];
        for face in surface.faces() {
            let polygon: Vec<Vec3> = face.iter().map(|corner| surface.vertices()[corner as usize]).collect();
            divide::<_, 3>(&polygon, 2, bottom, &mut rest, &mut above);
            divide::<_, 3>(&above, 2, top, &mut layer, &mut rest);
            by_y.slice(grid, 1, across.clone(), &layer, |j, strip| {
                if j == across.end {
                    return;
                }
                let column = &mut pieces[(j - across.start) * (along.len() + 1)..][..=along.len()];
                by_x.slice(grid, 0, along.clone(), strip, |i, piece| {
                    column[i - along.start].add(piece, side(grid, 0, i));
                });
            });
        }
    }

    fn add_to(&self, grid: &PointGrid, sign: f32, layer: &mut [f32]) {
        let h = grid.spacing.x;
        let voxel = h * grid.spacing.y * grid.spacing.z;
        for (j, column) in self.across.clone().zip(self.pieces.chunks_exact(self.along.len() + 1)) {
            let row = &mut layer[j * grid.counts[0]..][self.along.clone()];
            let mut beyond = column[row.len()].area;
            for (value, pieces) in row.iter_mut().zip(column).rev() {
                let share = (pieces.volume + h * beyond) / voxel;
                beyond += pieces.area;
                *value += sign * snapped(share) as f32;
            }
        }
    }
}

fn snapped(share: f64) -> f64 {
    match share {
        share if share < WHOLE => 0.0,
        share if share > 1.0 - WHOLE => 1.0,
        share => share,
    }
}

impl Pieces {
    /// Adds a convex polygon above `bottom`.
    fn add(&mut self, piece: &[Vec3], bottom: f64) {
        let first = piece[0];
        for pair in piece[1..].windows(2) {
            let (a, b) = (pair[0] - first, pair[1] - first);
            let area = (a.y * b.z - a.z * b.y) / 2.0;
            self.area += area;
            self.volume += area * (first.x - bottom + (a.x + b.x) / 3.0);
        }
    }
}

/// Divides polygons, and keeps the memory for it.
#[derive(Default)]
struct Knife {
    rest: Vec<Vec3>,
    below: Vec<Vec3>,
    above: Vec<Vec3>,
}

impl Knife {
    /// Hands the parts of a polygon in each of `voxels` along `axis` to `visit`. The part beyond the last voxel comes
    /// with the next number; the part before the first is left out.
    fn slice(
        &mut self,
        grid: &PointGrid,
        axis: usize,
        voxels: Range<usize>,
        polygon: &[Vec3],
        mut visit: impl FnMut(usize, &[Vec3]),
    ) {
        let Self { rest, below, above } = self;
        let ends = polygon.iter().map(|v| v[axis]);
        let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        let met = grid.range(axis, low - grid.spacing[axis] / 2.0, grid.coordinate(axis, grid.counts[axis]));
        // Rounding may call the first one later than it is, not earlier than the body's first.
        let first =
            if met.is_empty() { voxels.end } else { met.start.saturating_sub(1).clamp(voxels.start, voxels.end) };
        divide::<_, 3>(polygon, axis, side(grid, axis, first), below, rest);
        for voxel in first..voxels.end {
            let end = side(grid, axis, voxel + 1);
            if high <= end {
                visit_solid(rest, |part| visit(voxel, part));
                return;
            }
            divide::<_, 3>(rest, axis, end, below, above);
            visit_solid(below, |part| visit(voxel, part));
            std::mem::swap(rest, above);
        }
        visit_solid(rest, |part| visit(voxels.end, part));
    }
}

/// Calls `visit` with a polygon that has an area.
fn visit_solid(polygon: &[Vec3], visit: impl FnOnce(&[Vec3])) {
    if polygon.len() > 2 {
        visit(polygon);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_collision::geometry::{clipped as part_in_box, convex_hull};

    /// A body of 24 corners.
    fn body() -> Polyhedron {
        let point = |i: i32| {
            let (a, b) = (f64::from(i) * 2.4, f64::from(i) / 12.0 - 0.95);
            let r = (1.0 - b * b).max(0.0).sqrt();
            Vec3::new(4.1 + 3.0 * r * libm::cos(a), 4.3 + 2.5 * r * libm::sin(a), 3.9 + 2.0 * b)
        };
        convex_hull(&(0..24).map(point).collect::<Vec<_>>()).unwrap()
    }

    /// Shares of `body` in voxels of `h` mm from `first` voxels off the origin on, layer by layer.
    fn shares(body: &Polyhedron, h: f64, first: f64, counts: [usize; 3]) -> Vec<f64> {
        let grid = PointGrid { origin: Vec3::repeat((first + 0.5) * h), spacing: Vec3::repeat(h), counts };
        let body = Body { form: Form::Surface(body.clone()), aabb: body.aabb(), sign: 1.0 };
        let shares = Shares::of(grid, vec![body]);
        let layer = |k: usize| {
            let mut layer = vec![0.0; counts[0] * counts[1]];
            shares.add(k, &mut layer);
            layer
        };
        (0..counts[2]).flat_map(layer).map(f64::from).collect()
    }

    #[test]
    fn a_body_inside_one_voxel_takes_its_own_share() {
        let share = shares(&body(), 9.0, 0.0, [1; 3])[0];
        assert!((share * 729.0 / body().volume() - 1.0).abs() < 1e-7, "{share}");
    }

    #[test]
    fn shares_are_those_of_the_exact_clip() {
        let body = body();
        // The whole body; a grid that holds a part of it, so that it reaches beyond on all sides.
        for (h, first, counts) in
            [(0.7, 0.0, [14, 13, 12]), (2.0, 0.0, [5; 3]), (0.5, 6.0, [4, 5, 6]), (0.25, 9.0, [9, 1, 2])]
        {
            let (mut sum, mut crossed) = (0.0, 0);
            for (number, share) in shares(&body, h, first, counts).into_iter().enumerate() {
                let (i, j, k) = (number % counts[0], number / counts[0] % counts[1], number / (counts[0] * counts[1]));
                let low = (Vec3::new(i as f64, j as f64, k as f64).add_scalar(first)) * h;
                let voxel = Aabb { min: low, max: low.add_scalar(h) };
                let exact = if body.aabb().intersects(&voxel) { part_in_box(&body, &voxel) } else { None };
                let exact = exact.map_or(0.0, |part| part.volume() / h.powi(3));
                assert!((share - exact).abs() < 1e-6, "{share} for {exact} at {low}");
                assert!(exact > 0.0 || share == 0.0, "{share} outside at {low}");
                sum += share;
                crossed += usize::from(share > 0.0 && share < 1.0);
            }
            assert!(first > 0.0 || (sum * h.powi(3) / body.volume() - 1.0).abs() < 1e-7);
            assert!(crossed > 0 && (first > 0.0 || crossed > 20), "{crossed} of {counts:?}");
        }
    }
}
