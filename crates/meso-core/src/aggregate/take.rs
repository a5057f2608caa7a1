//! The *take*: enough grains of every class, each made from its own random stream (Sec. 2.1).

use super::random::{Purpose, Stream};
use super::{Grading, Inclusions, Itz, Kind, Shape, SizeClass, SizeDefinition, inclusions};
use crate::geometry::{CompactPolyhedron, HullError, convex_hull, sieve_size};
use crate::math::{Mat3, Rotation, Vec3};
use crate::simd::{Wide, widest};
use crate::stop;
use rayon::prelude::*;

/// A grain has a shape and an orientation, but no position yet.
#[derive(Clone, Debug)]
pub struct Grain {
    /// What it is.
    pub kind: Kind,
    /// Index of its size class, from the finest; those of voids and of fibres follow the grading's.
    pub class: u16,
    /// Number within its class; with the class it names the grain's random streams.
    pub index: u32,
    /// Thickness of its ITZ, mm.
    pub itz_thickness_mm: f64,
    /// True when the drawn thickness was too large for the grain and was limited.
    pub itz_limited: bool,
    /// Outer surface about a point inside of it, mm, on the [`snap`] lattice.
    pub body: CompactPolyhedron,
    /// Radius of the sphere about the centre that holds the body, mm, rounded up.
    pub outer_radius: f32,
    /// Radius of the sphere about the centre that the body holds, mm, rounded down.
    pub inner_radius: f32,
}

impl Grain {
    /// mm3.
    pub fn volume(&self) -> f64 {
        self.body.volume()
    }

    /// From the centre to the middle of that end of a fibre where the farthest vertex is, mm.
    pub fn half_length(&self) -> Vec3 {
        let farther = |a: Vec3, b: Vec3| if b.norm_squared() > a.norm_squared() { b } else { a };
        let farthest = self.body.vertices().fold(Vec3::zeros(), farther);
        let end = || self.body.vertices().filter(|vertex| vertex.dot(&farthest) > 0.0);
        end().sum::<Vec3>() / end().count() as f64
    }

    /// Radius of the ball of the same volume, mm.
    pub fn ball_radius(&self) -> f64 {
        libm::cbrt(self.volume() * 0.75 / std::f64::consts::PI)
    }
}

/// An ITZ takes at most this share of the distance from a grain's centre to its nearest face, so that a core remains.
pub const ITZ_LIMIT: f64 = 0.5;

/// Coordinates of grains and of their centres are multiples of 2^-30 mm: their sums are then exact in f64 up to 8 km,
/// so that translating a grain changes no shape, no volume and no face by rounding.
pub const LATTICE_MM: f64 = 1.0 / (1u64 << 30) as f64;

/// Rounds to the lattice of [`LATTICE_MM`].
#[inline(always)]
pub fn snap(v: &Vec3) -> Vec3 {
    rounded_to(LATTICE_MM, v)
}

/// Rounds to multiples of `lattice`, a power of two.
#[inline(always)]
pub(crate) fn rounded_to(lattice: f64, v: &Vec3) -> Vec3 {
    v.map(|x| (x / lattice).round_ties_even() * lattice)
}

/// The vertices turned and rounded to the lattice.
pub(crate) fn turned(vertices: impl ExactSizeIterator<Item = Vec3>, rotation: &Mat3) -> Vec<Vec3> {
    widest(Turned { vertices, rotation })
}

/// [`turned`] in vector registers that round in hardware.
struct Turned<'a, I> {
    vertices: I,
    rotation: &'a Mat3,
}

impl<I: ExactSizeIterator<Item = Vec3>> Wide for Turned<'_, I> {
    type Output = Vec<Vec3>;

    #[inline(always)]
    fn run(self) -> Vec<Vec3> {
        let mut turned = Vec::with_capacity(self.vertices.len());
        for vertex in self.vertices {
            turned.push(snap(&(self.rotation * vertex)));
        }
        turned
    }
}

/// Rounds to the single precision of a [`CompactPolyhedron`]. A point of the lattice stays on it: single precision is
/// finer only where all of the lattice's digits fit into it.
fn narrowed(v: &Vec3) -> Vec3 {
    v.map(|x| f64::from(x as f32))
}

/// The parts of a spec that the take needs.
#[derive(Clone, Copy)]
pub struct Recipe<'a> {
    /// Sizes.
    pub grading: &'a Grading,
    /// Shapes.
    pub shape: &'a Shape,
    /// ITZ.
    pub itz: &'a Itz,
    /// Further phases.
    pub inclusions: &'a Inclusions,
    /// Seed of all streams.
    pub seed: u64,
    /// Called now and then; `false` ends the take with the grains it has.
    pub go_on: &'a (dyn Fn() -> bool + Sync),
}

/// Generates grains of every class until each class holds `fraction * volume * share * (1 + surplus)` mm3, as nearly
/// as whole grains allow, and the further phases likewise; the specimen's `volume` is in mm3. Fibres come first,
/// because nothing else is as long, then everything else in descending volume.
///
/// # Errors
/// A shape without volume.
pub fn take(recipe: &Recipe, fraction: f64, volume: f64, surplus: f64) -> Result<Vec<Grain>, HullError> {
    let (classes, beyond) = (recipe.grading.classes(), 1.0 + surplus);
    let mut grains = Vec::new();
    // Coarse classes first: if it ends early, they are what a packing begins with.
    for (class, limits) in (0..classes.len() as u16).zip(&classes).rev() {
        let target = fraction * volume * limits.share * beyond;
        fill(&mut grains, target, recipe.go_on, |index| make(recipe, class, limits, index))?;
    }
    inclusions::take(&mut grains, recipe, classes.len() as u16, volume * beyond)?;
    grains.shrink_to_fit();
    let last = |grain: &Grain| grain.kind != Kind::Fibre;
    // No two have the same number in the same class.
    grains.sort_unstable_by(|p, q| {
        let by_volume = q.volume().total_cmp(&p.volume());
        last(p).cmp(&last(q)).then(by_volume).then((p.class, p.index).cmp(&(q.class, q.index)))
    });
    Ok(grains)
}

/// Most grains generated at once: enough to share among threads.
const CHUNK: u32 = 256;
/// Grains generated beyond the number predicted from the mean volume so far.
const SPARE: u32 = 8;

/// Generates grains by number until they hold `target` mm3, and adds them to the `grains`.
pub(super) fn fill(
    grains: &mut Vec<Grain>,
    target: f64,
    go_on: &(dyn Fn() -> bool + Sync),
    make: impl Fn(u32) -> Result<Grain, HullError> + Sync,
) -> Result<(), HullError> {
    let (mut volume, mut made) = (0.0, 0);
    loop {
        if !go_on() {
            return Ok(());
        }
        // With no grain yet this is NaN, and NaN.min(CHUNK) is CHUNK.
        let expected = (target - volume) / volume * f64::from(made);
        let count = CHUNK.min((expected.min(f64::from(CHUNK)) as u32).saturating_add(SPARE));
        let chunk: Vec<Grain> = (made..made + count).into_par_iter().panic_fuse().map(&make).collect::<Result<_, _>>()?;
        for grain in chunk {
            // The last grain is included when that brings the class nearer to its target.
            if volume + grain.volume() / 2.0 >= target {
                return Ok(());
            }
            volume += grain.volume();
            grains.push(grain);
        }
        made += count;
    }
}

fn make(recipe: &Recipe, class: u16, limits: &SizeClass, index: u32) -> Result<Grain, HullError> {
    stop::point();
    let stream = &mut Stream::new(recipe.seed, Purpose::Take, class, u64::from(index));
    let size = recipe.grading.size_law.size(limits.d_min_mm, limits.d_max_mm, stream.unit());
    let mut vertices = recipe.shape.outline(size, limits.d_min_mm, stream);
    if recipe.grading.size == SizeDefinition::Sieve {
        let scale = size / sieve_size(&convex_hull(&vertices)?);
        vertices.iter_mut().for_each(|vertex| *vertex *= scale);
    }
    let bare = Grain::turned(Kind::Aggregate, (class, index), &vertices, stream)?;
    let drawn = stream.uniform(recipe.itz.thickness_mm[0], recipe.itz.thickness_mm[1]);
    let most = ITZ_LIMIT * f64::from(bare.inner_radius);
    Ok(Grain { itz_thickness_mm: drawn.min(most), itz_limited: drawn > most, ..bare })
}

impl Grain {
    /// The grain of these vertices in a random orientation, without ITZ.
    pub(super) fn turned(
        kind: Kind,
        ids: (u16, u32),
        vertices: &[Vec3],
        stream: &mut Stream,
    ) -> Result<Self, HullError> {
        Self::oriented(kind, ids, vertices, &stream.rotation())
    }

    /// The grain of these vertices that is turned by `rotation`, without ITZ.
    pub(super) fn oriented(
        kind: Kind,
        (class, index): (u16, u32),
        vertices: &[Vec3],
        rotation: &Rotation,
    ) -> Result<Self, HullError> {
        let mut vertices = turned(vertices.iter().copied(), &rotation.to_rotation_matrix().into_inner());
        vertices.iter_mut().for_each(|vertex| *vertex = narrowed(vertex));
        let body = convex_hull(&vertices)?;
        let outer_radius = body.vertices().iter().map(Vec3::norm).fold(0.0, f64::max);
        let inner_radius = body.planes().map(|plane| plane.offset).fold(f64::INFINITY, f64::min);
        Ok(Self {
            kind,
            class,
            index,
            itz_thickness_mm: 0.0,
            itz_limited: false,
            outer_radius: outer_radius as f32 * (1.0 + f32::EPSILON),
            inner_radius: inner_radius as f32 * (1.0 - f32::EPSILON),
            body: body.into(),
        })
    }
}
