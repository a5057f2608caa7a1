//! Conductances between neighbouring voxels, from the exact geometry.
//!
//! A link joins the centres of two voxels through the face between them. Let `D` be the mean value over the face, `L` the
//! mean resistance along the link, and `n` the component along the link of the normal of the interface that it meets.
//!
//! - A gradient along the interface drives the flux `D` times the link's own gradient. So `D` is exact for it, for any
//!   angle, in any gap: the faces' shares of a phase, and its interface, close in every voxel (divergence theorem).
//! - A gradient across the interface drives one flux through both phases. So `1 / L` is exact for it.
//!
//! In a body of value `q` with a uniform field, a sphere say, the flux across the surface is `q` times the gradient
//! along it. The conductance that fits both in the mean of all directions is
//!
//! ```text
//! K = (D (1 - n^2) + n^2 q^2 L) / ((1 - n^2) + n^2 q^2 L^2)
//! ```
//!
//! It is `D` for impermeable bodies, `1 / L` for perfect conductors, and both are exact. A plane interface along the grid
//! has `D` or `1 / L`, too. At voxels near oblique planes links are coupled: see [`corners`].

mod corners;
mod layers;
mod parts;

pub(crate) use corners::Corners;
pub(crate) use layers::Layer;

use crate::grid::{End, Grid};
use crate::sections::{Section, Squares, WITHIN};
use meso_collision::geometry::{Plane, Triangles};
use meso_collision::math::Vec3;
use meso_concrete::parallel;

/// Conductances below this share of the mortar's are rounding.
const NOTHING: f64 = 1e-9;

/// Conductances of all links, each over the spacing along it: flux per difference of potential.
///
/// `across[a]` has the link below every voxel along axis a; along z there is one more layer, above the last.
pub(crate) struct Links {
    pub(crate) counts: [usize; 3],
    /// Whether voxels at opposite ends of z are neighbours. Along x and y they always are, by a link of 0 at walls.
    pub(crate) wraps: bool,
    pub(crate) across: [Vec<f32>; 3],
    /// Width of the last voxel along each axis, over that of the others: blocks of odd counts have narrow last ones.
    pub(crate) last: [f32; 3],
    /// Axes along which a part carries a flux.
    pub(crate) carries: [bool; 3],
    /// Coupled links at oblique interfaces.
    pub(crate) corners: Option<Corners>,
}

impl Links {
    /// Links of a grid, whose voxels are alike.
    pub(crate) fn of(counts: [usize; 3], wraps: bool, across: [Vec<f32>; 3]) -> Self {
        Self { counts, wraps, across, last: [1.0; 3], carries: [true; 3], corners: None }
    }

    /// The links of `layers` in mortar of value `mortar`.
    pub(crate) fn new(grid: &Grid, layers: &[Layer], mortar: f64) -> Self {
        let most = layers.iter().fold(mortar, |most, layer| layer.within.max(most));
        let wraps = grid.ends[2] == End::Periodic;
        if !layers.iter().any(|layer| layer.body > 0.0) {
            let link = |sums: &Sums, over: f64| (sums.conductance([mortar, most]) * over) as f32;
            return Self::of(grid.counts, wraps, [0, 1, 2].map(|axis| along(grid, layers, axis, link)));
        }
        let link = |sums: &Sums, over: f64| sums.link([mortar, most], over);
        let (across, corners) = corners::couple(grid, layers, [0, 1, 2].map(|axis| along(grid, layers, axis, link)));
        Self { corners, ..Self::of(grid.counts, wraps, across) }
    }
}

/// The links along an axis, in the grid's order.
fn along<T: Copy + Default + Send + Sync>(
    grid: &Grid,
    layers: &[Layer],
    axis: usize,
    of_sums: impl Fn(&Sums, f64) -> T + Sync,
) -> Vec<T> {
    let planes = Planes::new(grid, layers, axis);
    let count = grid.counts[axis] + usize::from(axis == 2);
    let of = |number: usize| planes.links(number, &of_sums);
    let slices: Vec<Vec<T>> = parallel::map(count, of);
    if axis == 2 {
        return slices.concat();
    }
    let [nx, ny, nz] = grid.counts;
    let mut links = vec![T::default(); nx * ny * nz];
    parallel::chunks_mut(&mut links, nx * ny, |k, layer| {
        for (number, link) in layer.iter_mut().enumerate() {
            let (i, j) = (number % nx, number / nx);
            // A plane across x is numbered with y fastest, a plane across y with z fastest.
            *link = if axis == 0 { slices[i][k * ny + j] } else { slices[j][i * nz + k] };
        }
    });
    links
}

/// The planes of faces across an axis.
struct Planes<'a> {
    grid: &'a Grid,
    layers: &'a [Layer],
    axis: usize,
    squares: Squares,
    /// Layers that reach into the links of each plane.
    by_plane: Vec<Vec<u32>>,
    /// Whether a body conducts: else resistances along links are not asked for.
    conduct: bool,
}

/// Sums over the layers at a link.
#[derive(Clone, Copy, Default)]
struct Sums {
    value: f64,
    blocked: f64,
    resistance: f64,
    weight: f64,
    normal: f64,
    flux: f64,
}

impl<'a> Planes<'a> {
    fn new(grid: &'a Grid, layers: &'a [Layer], axis: usize) -> Self {
        let squares = Squares::across(grid, axis);
        let h = grid.spacing[axis];
        let mut by_plane = vec![Vec::new(); grid.counts[axis] + 1];
        for (number, layer) in layers.iter().enumerate() {
            let at = |x: f64| (x - grid.origin[axis]) / h;
            let first = (at(layer.aabb.min[axis]) - 0.5).floor().max(0.0) as usize;
            let last = (at(layer.aabb.max[axis]) + 0.5).ceil().min(grid.counts[axis] as f64);
            (first..=last.max(-1.0) as usize).for_each(|plane| by_plane[plane].push(number as u32));
        }
        let conduct = layers.iter().any(|layer| layer.body > 0.0);
        Self { grid, layers, axis, squares, by_plane, conduct }
    }

    /// The links through a plane, each of its sums and of its area over its length.
    fn links<T: Copy + Default>(&self, number: usize, of: impl Fn(&Sums, f64) -> T) -> Vec<T> {
        let Some(link) = self.grid.link(self.axis, number) else {
            return vec![T::default(); self.squares.counts[0] * self.squares.counts[1]];
        };
        // The last plane of a period is its first one, to the last bit.
        let number =
            if self.grid.ends[self.axis] == End::Periodic { number % self.grid.counts[self.axis] } else { number };
        let h = self.grid.spacing[self.axis];
        let at = self.grid.origin[self.axis] + number as f64 * h;
        // A section lies just above its plane; above the last one the specimen ends.
        let section_at = if number == self.grid.counts[self.axis] { at - WITHIN * h } else { at };
        let mut sums = vec![Sums::default(); self.squares.counts[0] * self.squares.counts[1]];
        let mut section = Section::default();
        let (mut shares, mut covered) = (vec![0.0; sums.len()], Vec::new());
        for &layer in &self.by_plane[number] {
            let layer = &self.layers[layer as usize];
            section.shares(&layer.surface, self.axis, section_at, &self.squares, |square, share| {
                sums[square].value += layer.change * share;
                sums[square].blocked += layer.blocks * share;
                shares[square] = share;
                covered.push(square);
            });
            if self.conduct && layer.blocks == 0.0 {
                self.add_lines(layer, at, [at + link.from, at + link.to], &shares, &mut sums);
            }
            covered.drain(..).for_each(|square| shares[square] = 0.0);
        }
        let over = self.grid.area(self.axis) / (link.to - link.from);
        sums.iter().map(|sums| of(sums, over)).collect()
    }

    /// Adds the resistances that a layer changes along its links, and the normals where it ends.
    fn add_lines(&self, layer: &Layer, at: f64, ends: [f64; 2], shares: &[f64], sums: &mut [Sums]) {
        let Squares { origin, spacing, counts } = &self.squares;
        let (b, c) = ((self.axis + 1) % 3, (self.axis + 2) % 3);
        let rows = self.squares.touched(1, layer.aabb.min[c], layer.aabb.max[c]);
        let columns = self.squares.touched(0, layer.aabb.min[b], layer.aabb.max[b]);
        for (row, column) in rows.flat_map(|row| columns.clone().map(move |column| (row, column))) {
            let square = row * counts[0] + column;
            let mut centre = Vec3::zeros();
            centre[self.axis] = at;
            centre[b] = origin[0] + (column as f64 + 0.5) * spacing[0];
            centre[c] = origin[1] + (row as f64 + 0.5) * spacing[1];
            let share = shares[square];
            let met = match &layer.dents {
                None => Met::new(&layer.planes, self.axis, &centre, ends),
                Some(surface) => Met::with_dents(surface, self.axis, &centre, ends, share),
            };
            let along = met.share;
            let weight = share * (1.0 - share) + along * (1.0 - along);
            let sum = &mut sums[square];
            sum.resistance += layer.resistance * along;
            sum.weight += weight;
            sum.normal += weight * met.normal2;
            sum.flux += weight * met.normal2 * layer.body * layer.body;
        }
    }
}

impl Sums {
    /// The conductance with the value and the resistance for corners; those of a face that is blocked couple with none.
    fn link(&self, [mortar, most]: [f64; 2], over: f64) -> corners::Link {
        let (value, resistance) = self.both(mortar, most);
        let is_open = self.blocked == 0.0 && value > NOTHING * mortar;
        let resistance = if is_open { resistance } else { 0.0 };
        [self.conductance([mortar, most]) * over, value, resistance].map(|x| x as f32)
    }

    /// Mean value over the face and mean resistance along the link. Round bodies that touch are polyhedra around them which
    /// overlap a little: what counts twice there is at least a resistance of the phase of the `most` value.
    fn both(&self, mortar: f64, most: f64) -> (f64, f64) {
        ((mortar + self.value).min(most), (1.0 / mortar + self.resistance).max(1.0 / most))
    }

    fn conductance(&self, [mortar, most]: [f64; 2]) -> f64 {
        let ((value, resistance), open) = (self.both(mortar, most), 1.0 - self.blocked);
        if value < NOTHING * mortar || open < NOTHING {
            return 0.0;
        }
        if self.weight <= 0.0 {
            return value;
        }
        let value = value / open;
        let (normal, flux) = (self.normal / self.weight, self.flux / self.weight);
        open * (value * (1.0 - normal) + flux * resistance) / ((1.0 - normal) + flux * resistance * resistance)
    }
}

/// A link on its way through a body.
struct Met {
    /// Share of the link inside.
    share: f64,
    /// Square of the component along the link of the normal where it enters or leaves, or else of the nearest face.
    normal2: f64,
}

impl Met {
    /// Through a body with dents, which covers this `share` of the face at the `centre` of the link.
    fn with_dents(surface: &Triangles, axis: usize, centre: &Vec3, [low, high]: [f64; 2], share: f64) -> Self {
        let crossings = surface.crossings(axis, centre, [low, high]);
        let square = |along: f64| (along * along).min(1.0);
        let Some(first) = crossings.first() else {
            let is_inside = share >= 1.0 || share > 0.0 && surface.contains(centre);
            let arm = surface.nearest(centre).map_or(Vec3::zeros(), |(nearest, _)| centre - nearest);
            let normal = arm.try_normalize(0.0).unwrap_or_default();
            return Self { share: f64::from(u8::from(is_inside)), normal2: square(normal[axis]) };
        };
        // A surface that is left first was around the link's beginning.
        let (mut inside, mut from) = (0.0, (first.1 > 0.0).then_some(low));
        for (at, along) in &crossings {
            match from.take() {
                Some(entered) if *along > 0.0 => inside += at - entered,
                _ => from = Some(*at),
            }
        }
        inside += from.map_or(0.0, |entered| high - entered);
        let normal2 = crossings.iter().map(|(_, along)| square(*along)).sum::<f64>() / crossings.len() as f64;
        Self { share: inside / (high - low), normal2 }
    }

    fn new(planes: &[Plane], axis: usize, centre: &Vec3, [low, high]: [f64; 2]) -> Self {
        let (mut from, mut to) = (low, high);
        let mut ends: [Option<f64>; 2] = [None, None];
        let mut nearest = (f64::NEG_INFINITY, 0.0);
        for plane in planes {
            let (height, along) = (plane.height(centre), plane.normal[axis]);
            if height > nearest.0 {
                nearest = (height, along);
            }
            let at = centre[axis] - height / along;
            if along > 0.0 && at < to {
                (to, ends[1]) = (at, Some(along));
            } else if along < 0.0 && at > from {
                (from, ends[0]) = (at, Some(along));
            } else if along == 0.0 && height > 0.0 {
                to = f64::NEG_INFINITY;
            }
        }
        let share = ((to - from) / (high - low)).max(0.0);
        let crossed: Vec<f64> = ends.into_iter().flatten().filter(|_| share > 0.0).collect();
        let square = |along: f64| (along * along).min(1.0);
        let normal2 = match crossed.len() {
            0 => square(nearest.1),
            count => crossed.iter().map(|along| square(*along)).sum::<f64>() / count as f64,
        };
        Self { share, normal2 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The case: two spheres that touch had a link of -77, and the equations no solution.
    #[test]
    fn a_place_that_two_bodies_cover_conducts_as_the_better_phase() {
        let most = 1372.0;
        let twice = |share: f64| Sums {
            value: 2.0 * share * (most - 1.0),
            resistance: 2.0 * share * (1.0 / most - 1.0),
            weight: 0.5,
            normal: 0.1,
            flux: 0.5 * 0.1 * most * most,
            ..Sums::default()
        };
        for share in [0.5, 0.51, 0.75, 1.0] {
            let [conductance, value, resistance] = twice(share).link([1.0, most], 1.0).map(f64::from);
            assert!(conductance > 0.0 && conductance <= most * (1.0 + 1e-6), "{share}: {conductance}");
            assert!(value <= most && resistance >= 1.0 / most * (1.0 - 1e-6), "{share}: {value}, {resistance}");
        }
    }
}
