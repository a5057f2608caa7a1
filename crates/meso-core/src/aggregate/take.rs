//! The *take*: enough grains of every class, each made from its own random stream (Sec. 2.1).

use super::random::{Purpose, Stream};
use super::{Grading, Itz, Shape, SizeClass, SizeDefinition};
use crate::geometry::{HullError, Polyhedron, convex_hull, sieve_size};
use crate::math::{Mat3, Vec3};
use rayon::prelude::*;

/// A grain that has a shape and an orientation, but no place yet.
#[derive(Clone, Debug)]
pub struct Grain {
    /// Index of its size class, from the finest.
    pub class: u16,
    /// Number within its class; with the class it names the grain's random streams.
    pub index: u32,
    /// Thickness of its ITZ, mm.
    pub itz_thickness_mm: f64,
    /// True when the drawn thickness was too much for the grain and was limited.
    pub itz_limited: bool,
    /// Outer surface about a point inside of it, mm, on the [`snap`] lattice.
    pub body: Polyhedron,
    /// Semi-axes of the ellipsoid the vertices lie on or near, mm.
    pub semi_axes: Vec3,
    /// Columns: the directions of the semi-axes.
    pub rotation: Mat3,
    /// mm3.
    pub volume: f64,
    /// Radius of the sphere about the centre that holds the body, mm.
    pub outer_radius: f64,
    /// Radius of the sphere about the centre that the body holds, mm.
    pub inner_radius: f64,
}

impl Grain {
    /// Radius of the ball of the same volume, mm.
    pub fn ball_radius(&self) -> f64 {
        libm::cbrt(self.volume * 0.75 / std::f64::consts::PI)
    }
}

/// An ITZ takes at most this share of the distance from a grain's centre to its nearest face, so that a core remains.
pub const ITZ_LIMIT: f64 = 0.5;

/// Coordinates of grains and of their centres are multiples of 2^-30 mm: their sums are then exact in f64 up to 8 km,
/// so that moving a grain to its place changes no shape, no volume and no face by rounding.
pub const LATTICE_MM: f64 = 1.0 / (1u64 << 30) as f64;

/// Rounds to the lattice of [`LATTICE_MM`].
#[inline(always)]
pub fn snap(v: &Vec3) -> Vec3 {
    v.map(|x| (x / LATTICE_MM).round_ties_even() * LATTICE_MM)
}

/// What the take needs of a spec.
#[derive(Clone, Copy)]
pub struct Recipe<'a> {
    /// Sizes.
    pub grading: &'a Grading,
    /// Shapes.
    pub shape: &'a Shape,
    /// ITZ.
    pub itz: &'a Itz,
    /// Seed of all streams.
    pub seed: u64,
    /// Asked now and then; `false` ends the take with the grains it has.
    pub go_on: &'a (dyn Fn() -> bool + Sync),
}

/// Makes grains of every class until each class holds `volume * share * (1 + surplus)` mm3, as nearly as whole grains
/// allow; in descending volume.
///
/// # Errors
/// A shape without volume.
pub fn take(recipe: &Recipe, volume: f64, surplus: f64) -> Result<Vec<Grain>, HullError> {
    let mut grains = Vec::new();
    for (class, limits) in recipe.grading.classes().iter().enumerate() {
        grains.append(&mut take_class(recipe, class as u16, limits, volume * limits.share * (1.0 + surplus))?);
    }
    grains.shrink_to_fit();
    grains.sort_by(|p, q| q.volume.total_cmp(&p.volume).then((p.class, p.index).cmp(&(q.class, q.index))));
    Ok(grains)
}

/// Grains made at once: enough to share among threads, few enough not to overshoot much.
const CHUNK: u32 = 256;

fn take_class(recipe: &Recipe, class: u16, limits: &SizeClass, target: f64) -> Result<Vec<Grain>, HullError> {
    let (mut grains, mut volume) = (Vec::new(), 0.0);
    for start in (0..).step_by(CHUNK as usize) {
        if !(recipe.go_on)() {
            return Ok(grains);
        }
        let chunk: Vec<Grain> =
            (start..start + CHUNK).into_par_iter().map(|i| make(recipe, class, limits, i)).collect::<Result<_, _>>()?;
        for grain in chunk {
            // The last grain goes in when that brings the class nearer to its target.
            if volume + grain.volume / 2.0 >= target {
                return Ok(grains);
            }
            volume += grain.volume;
            grains.push(grain);
        }
    }
    unreachable!("the range of chunks has no end")
}

fn make(recipe: &Recipe, class: u16, limits: &SizeClass, index: u32) -> Result<Grain, HullError> {
    let stream = &mut Stream::new(recipe.seed, Purpose::Take, class, u64::from(index));
    let size = recipe.grading.size_law.size(limits.d_min_mm, limits.d_max_mm, stream.unit());
    let mut outline = recipe.shape.outline(size, limits.d_min_mm, stream);
    if recipe.grading.size == SizeDefinition::Sieve {
        let scale = size / sieve_size(&convex_hull(&outline.vertices)?);
        outline.semi_axes *= scale;
        outline.vertices.iter_mut().for_each(|vertex| *vertex *= scale);
    }
    let rotation = stream.rotation().to_rotation_matrix();
    let vertices: Vec<Vec3> = outline.vertices.iter().map(|v| snap(&(rotation * v))).collect();
    let body = convex_hull(&vertices)?;
    let inner_radius = body.planes().map(|plane| plane.offset).fold(f64::INFINITY, f64::min);
    let drawn = stream.uniform(recipe.itz.thickness_mm[0], recipe.itz.thickness_mm[1]);
    Ok(Grain {
        class,
        index,
        itz_thickness_mm: drawn.min(ITZ_LIMIT * inner_radius),
        itz_limited: drawn > ITZ_LIMIT * inner_radius,
        semi_axes: outline.semi_axes,
        rotation: rotation.into_inner(),
        volume: body.volume(),
        outer_radius: body.vertices().iter().map(Vec3::norm).fold(0.0, f64::max),
        inner_radius,
        body,
    })
}
