//! Which body holds a point: by the bodies' face planes one by one, and for all points of a grid by scanlines.
//!
//! A row of grid points parallel to x meets a convex body in one interval, cut out by the body's planes: nx x <= d -
//! ny y - nz z. So a body costs its planes times its rows, and no point is ever tested against a body. A body with dents
//! meets a row in several intervals, and a shell of one point by point, by their depths.

use crate::cells::{NO_BODY, Phase};
use crate::planes::{self, EightPlanes};
use meso_collision::dents::Skin;
use meso_collision::geometry::{BodyForm, Plane, Round};
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::aggregate::Aggregate;
use meso_concrete::parallel;
use meso_concrete::stop;
use std::borrow::Cow;

/// A body, ready to be asked for points.
#[derive(Clone)]
pub struct Facets {
    /// Phase of its inside.
    pub(crate) phase: Phase,
    pub(crate) aabb: Aabb,
    by: By,
    /// Shell thickness in this mesh, mm; 0: no shell.
    pub(crate) shell: f64,
    /// Whether the points below the shell are all that is painted.
    is_core_alone: bool,
}

/// By what a body says which points it holds.
#[derive(Clone)]
enum By {
    /// Its face planes, one by one and in eights.
    Planes(Vec<Plane>, Vec<EightPlanes>),
    Round(Round),
    /// The surface and the skin of a body with dents.
    Skin(Skin),
}

impl Facets {
    /// `shell(aggregate)` is the thickness of its shell in the mesh, mm.
    pub fn all(aggregates: &[Aggregate], shell: impl Fn(&Aggregate) -> f64 + Sync) -> Vec<Self> {
        parallel::map_each(aggregates, |a| Self::of(a, shell(a)))
    }

    /// One aggregate with a shell of `shell` mm.
    pub fn of(a: &Aggregate, shell: f64) -> Self {
        let by = match a.body.form() {
            BodyForm::Hull => {
                let planes: Vec<Plane> = a.body.planes().collect();
                let eights = EightPlanes::all(&planes);
                By::Planes(planes, eights)
            }
            BodyForm::Round(round) => By::Round(round),
            BodyForm::Surface => By::Skin(a.body.skin(shell)),
        };
        Self { phase: Phase::of(a.kind), aabb: a.body.aabb(), by, shell, is_core_alone: false }
    }

    /// The layers of an aggregate below its ITZ, each with its phase: the first one with the ITZ as its shell, and the inside
    /// of every further one, to be painted over those before it.
    pub fn layers(a: &Aggregate) -> Vec<(Self, Phase)> {
        if !a.shells.is_empty() && a.body.has_inner_body() {
            return a.nested().iter().map(|layer| (Self::of(layer, layer.itz_thickness_mm), layer.phase())).collect();
        }
        let of = |(number, (depth, phase))| (Self { is_core_alone: number > 0, ..Self::of(a, depth) }, phase);
        a.layers().enumerate().map(of).collect()
    }

    /// How far `x` lies below the inner side of the shell, mm; negative in the shell and outside.
    pub fn depth_below_shell(&self, x: &Vec3) -> f64 {
        match &self.by {
            By::Skin(skin) => skin.depth_below(x, self.shell),
            By::Planes(..) | By::Round(_) => -self.height(x) - self.shell,
        }
    }

    /// Distance to the farthest face plane ahead, mm: negative inside, where its size is the depth below the surface.
    pub fn height(&self, x: &Vec3) -> f64 {
        match &self.by {
            By::Planes(_, eights) => planes::height_over(eights, x),
            By::Round(round) => round.height(x),
            By::Skin(skin) => -skin.surface().depth(x),
        }
    }

    /// The part of the segment from `inside` to `outside` that lies within the body, 0 to 1.
    pub(crate) fn exit(&self, inside: &Vec3, outside: &Vec3) -> f64 {
        let direction = outside - inside;
        match &self.by {
            By::Planes(_, eights) => planes::exit(eights, inside, &direction),
            By::Round(round) => round.chord(inside, &direction).map_or(0.0, |(_, exit)| exit.clamp(0.0, 1.0)),
            By::Skin(skin) => skin.surface().exit(inside, outside),
        }
    }
}

/// Grains by the cells of a coarse grid: which one holds a point.
pub(crate) struct Locator<'a> {
    bodies: &'a [Facets],
    min: Vec3,
    cell: f64,
    counts: [usize; 3],
    buckets: Vec<Vec<u32>>,
}

/// Points this far from a body's box lie outside the body whatever the rounding.
const BEYOND_MM: f64 = 1e-6;

/// Longest edge of a locator's cell, mm, in bodies' mean box sizes.
const CELL_PER_BODY: f64 = 0.5;

impl<'a> Locator<'a> {
    pub(crate) fn new(bodies: &'a [Facets], domain: &Aabb) -> Self {
        let mean = bodies.iter().map(|g| g.aabb.size().max()).sum::<f64>() / bodies.len().max(1) as f64;
        let cell = (mean * CELL_PER_BODY).max(domain.size().max() / 256.0);
        let counts = [0, 1, 2].map(|i| (domain.size()[i] / cell).ceil().max(1.0) as usize);
        let mut locator =
            Self { bodies, min: domain.min, cell, counts, buckets: vec![Vec::new(); counts.iter().product()] };
        for (index, body) in bodies.iter().enumerate() {
            let (low, high) = (locator.cell_of(&body.aabb.min), locator.cell_of(&body.aabb.max));
            for k in low[2]..=high[2] {
                for j in low[1]..=high[1] {
                    for i in low[0]..=high[0] {
                        let bucket = locator.bucket([i, j, k]);
                        locator.buckets[bucket].push(index as u32);
                    }
                }
            }
        }
        locator
    }

    /// The body that holds `x`, as an index, with the point's (negative) height; of several the first.
    pub(crate) fn find(&self, x: &Vec3) -> Option<(usize, f64)> {
        let bucket = &self.buckets[self.bucket(self.cell_of(x))];
        let near = bucket.iter().filter(|&&g| self.bodies[g as usize].aabb.distance(x) < BEYOND_MM);
        let heights = near.map(|&g| (g as usize, self.bodies[g as usize].height(x)));
        heights.into_iter().find(|(_, height)| *height <= 0.0)
    }

    fn cell_of(&self, x: &Vec3) -> [usize; 3] {
        [0, 1, 2].map(|i| (((x[i] - self.min[i]) / self.cell).max(0.0) as usize).min(self.counts[i] - 1))
    }

    fn bucket(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.counts[1] + j) * self.counts[0] + i
    }
}

/// Points `origin + (i, j, k) * spacing`, i fastest.
#[derive(Clone, Copy, Debug)]
pub struct PointGrid {
    /// The first point, mm.
    pub origin: Vec3,
    /// Distance of neighbours along each axis, mm.
    pub spacing: Vec3,
    /// Number of points along each axis.
    pub counts: [usize; 3],
}

impl PointGrid {
    /// Coordinate of the point with this index along an axis, mm.
    pub fn coordinate(&self, axis: usize, index: usize) -> f64 {
        self.origin[axis] + index as f64 * self.spacing[axis]
    }

    /// The indices whose coordinates lie within the closed interval `low..=high`.
    pub fn range(&self, axis: usize, low: f64, high: f64) -> std::ops::Range<usize> {
        let index = |x: f64| (x - self.origin[axis]) / self.spacing[axis];
        let start = index(low).ceil().max(0.0);
        let end = (index(high).floor() + 1.0).min(self.counts[axis] as f64);
        if start < end { start as usize..end as usize } else { 0..0 }
    }

    /// The point with this number in layer `k`.
    pub fn point(&self, number: usize, k: usize) -> Vec3 {
        let (i, j) = (number % self.counts[0], number / self.counts[0]);
        Vec3::new(self.coordinate(0, i), self.coordinate(1, j), self.coordinate(2, k))
    }

    /// Points in one z layer.
    pub fn layer_len(&self) -> usize {
        self.counts[0] * self.counts[1]
    }
}

/// Where a point lies: in the mortar, or in the core or the shell of an aggregate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Label(u32);

impl Label {
    /// A point in no body.
    pub const MORTAR: Self = Self(NO_BODY);

    pub(crate) fn core(body: u32) -> Self {
        Self(body << 1)
    }

    pub(crate) fn shell(body: u32) -> Self {
        Self(body << 1 | 1)
    }

    /// Index of the body, or `None` in the mortar.
    pub fn body(self) -> Option<u32> {
        (self != Self::MORTAR).then_some(self.0 >> 1)
    }

    pub(crate) fn in_shell(self) -> bool {
        self != Self::MORTAR && self.0 & 1 == 1
    }
}

/// All bodies, and by layer of a grid those that meet it.
pub struct Scan<'a> {
    grid: PointGrid,
    bodies: Cow<'a, [Facets]>,
    by_layer: Vec<Vec<u32>>,
}

impl<'a> Scan<'a> {
    /// Prepares the labels of `grid`.
    pub fn new(grid: PointGrid, bodies: impl Into<Cow<'a, [Facets]>>) -> Self {
        let bodies = bodies.into();
        let mut by_layer = vec![Vec::new(); grid.counts[2]];
        for (index, body) in bodies.iter().enumerate() {
            for k in grid.range(2, body.aabb.min.z, body.aabb.max.z) {
                by_layer[k].push(index as u32);
            }
        }
        Self { grid, bodies, by_layer }
    }

    /// The points.
    pub fn grid(&self) -> &PointGrid {
        &self.grid
    }

    /// The bodies, as they were given.
    pub fn bodies(&self) -> &[Facets] {
        &self.bodies
    }

    /// Labels of layer `k`, into `labels` of length [`PointGrid::layer_len`].
    pub fn label_layer(&self, k: usize, labels: &mut [Label]) {
        labels.fill(Label::MORTAR);
        self.paint_layer(k, labels, |body| [Label::shell(body), Label::core(body)]);
    }

    /// Gives the points of layer `k` in the shell and the core of every body their values; others keep theirs.
    pub fn paint_layer<T: Copy>(&self, k: usize, layer: &mut [T], values: impl Fn(u32) -> [T; 2]) {
        let z = self.grid.coordinate(2, k);
        for &index in &self.by_layer[k] {
            stop::point();
            let body = &self.bodies[index as usize];
            let [shell, core_value] = values(index);
            for j in self.grid.range(1, body.aabb.min.y, body.aabb.max.y) {
                let row = &mut layer[j * self.grid.counts[0]..][..self.grid.counts[0]];
                let y = self.grid.coordinate(1, j);
                let spans = match &body.by {
                    By::Planes(planes, _) => {
                        let [outer, core] = body.intervals(planes, y, z);
                        if body.shell > 0.0 {
                            row[self.grid.range(0, outer.low, outer.high)].fill(shell);
                        }
                        row[self.grid.range(0, core.low, core.high)].fill(core_value);
                        continue;
                    }
                    By::Round(round) => {
                        round.chord(&Vec3::new(0.0, y, z), &Vec3::x()).into_iter().map(Into::into).collect()
                    }
                    By::Skin(skin) => skin.surface().row(y, z),
                };
                self.paint_row(row, [j, k], (body, &spans), [shell, core_value]);
            }
        }
    }
}

impl Scan<'_> {
    /// Gives the points of a row in the shell and the core of a body their values, whose `spans` of the row are known.
    fn paint_row<T: Copy>(&self, row: &mut [T], [j, k]: [usize; 2], of: (&Facets, &[[f64; 2]]), [shell, core]: [T; 2]) {
        let ((body, spans), [y, z]) = (of, [self.grid.coordinate(1, j), self.grid.coordinate(2, k)]);
        for [from, to] in spans {
            for i in self.grid.range(0, *from, *to) {
                let is_deep = || body.is_deep(&Vec3::new(self.grid.coordinate(0, i), y, z));
                if body.shell == 0.0 || is_deep() {
                    row[i] = core;
                } else if !body.is_core_alone {
                    row[i] = shell;
                }
            }
        }
    }
}

/// The part of a row inside a body; empty when `low > high`.
#[derive(Clone, Copy)]
struct Interval {
    low: f64,
    high: f64,
}

impl Interval {
    /// Keeps the part with `nx * x <= reach`.
    fn clip(&mut self, nx: f64, reach: f64) {
        if nx > 0.0 {
            self.high = self.high.min(reach / nx);
        } else if nx < 0.0 {
            self.low = self.low.max(reach / nx);
        } else if reach < 0.0 {
            self.high = f64::NEG_INFINITY;
        }
    }
}

impl Facets {
    /// Whether a point of the body, at this height, is in its shell.
    pub(crate) fn has_in_shell(&self, x: &Vec3, height: f64) -> bool {
        // Below caps points are deeper than below the whole surface.
        height > -self.shell && (!matches!(self.by, By::Skin(_)) || !self.is_deep(x))
    }

    /// True for points of the body that lie deeper than the shell.
    fn is_deep(&self, point: &Vec3) -> bool {
        match &self.by {
            By::Skin(skin) => skin.nearest(point).is_none_or(|near| near.1 > self.shell),
            By::Planes(..) | By::Round(_) => -self.height(point) > self.shell,
        }
    }

    /// The row through (y, z), in the outer body within these planes and in the core.
    fn intervals(&self, planes: &[Plane], y: f64, z: f64) -> [Interval; 2] {
        let mut outer = Interval { low: self.aabb.min.x, high: self.aabb.max.x };
        let mut core = outer;
        for Plane { normal, offset } in planes {
            let reach = offset - normal.y * y - normal.z * z;
            outer.clip(normal.x, reach);
            core.clip(normal.x, reach - self.shell);
        }
        [outer, core]
    }
}
