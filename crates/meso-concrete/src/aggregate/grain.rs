//! A grain: the shape and orientation of an aggregate, void or fibre, on the lattice that keeps translations exact.

use super::random::Stream;
use crate::parallel;
use meso_collision::geometry::{BodyForm, CompactPolyhedron, HullError, OffsetError, Polyhedron, Round, convex_hull};
use meso_collision::math::{Mat3, Rotation, Vec3};
use meso_collision::simd::{Wide, widest};
use serde::{Deserialize, Serialize};

/// Kind of a placed body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// An aggregate, with its ITZ.
    #[default]
    Aggregate,
    /// A spherical void.
    Void,
    /// A straight fibre.
    Fibre,
}

impl Kind {
    /// All kinds but the aggregates, in the order of their classes.
    pub const FURTHER: [Self; 2] = [Self::Void, Self::Fibre];

    /// Name of the kind.
    pub fn name(self) -> &'static str {
        match self {
            Self::Aggregate => "aggregate",
            Self::Void => "void",
            Self::Fibre => "fibre",
        }
    }

    /// Many of it, which is the name of its table in a spec.
    pub fn plural(self) -> &'static str {
        match self {
            Self::Aggregate => "aggregates",
            Self::Void => "voids",
            Self::Fibre => "fibres",
        }
    }
}

/// A shell of a grain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shell {
    /// Position of its phase among the specimen's own.
    pub own: u8,
    /// Thickness, mm.
    pub thickness_mm: f64,
    /// Whether it lies around the stone that the grading asks for.
    pub outward: bool,
}

/// A grain has a shape and an orientation, but no position yet.
#[derive(Clone, Debug)]
pub struct Grain {
    /// Kind of the grain.
    pub kind: Kind,
    /// Position of its phase among the specimen's own; `None` for the phase of its kind.
    pub own: Option<u8>,
    /// Index of its size class, from the finest; those of voids and of fibres follow the grading's.
    pub class: u16,
    /// Number within its class; with the class it names the grain's random streams.
    pub index: u32,
    /// See [`copy_of`](Self::copy_of); 0 for grains without dents.
    pub(super) template: u32,
    /// Thickness of its ITZ, mm.
    pub itz_thickness_mm: f64,
    /// Its further shells below the ITZ, from outside.
    pub shells: Vec<Shell>,
    /// Volume of the stone within outward shells, mm3; `None` without these.
    pub(super) stone_mm3: Option<f64>,
    /// True when the drawn thickness was too large for the grain and was limited.
    pub itz_limited: bool,
    /// True when the grain has dents, and parts thinner than two of its ITZ: nothing of these is inside the ITZ.
    pub itz_thin: bool,
    /// Outer surface about a point inside of it, mm, on the [`snap`] lattice.
    pub body: CompactPolyhedron,
    /// Radius of the sphere about the centre that holds the body, mm, rounded up.
    pub outer_radius: f32,
    /// Radius of the sphere about the centre that the body holds, mm, rounded down.
    pub inner_radius: f32,
}

/// Sorts the grains as they are taken.
pub(super) fn in_order(grains: &mut [Grain]) {
    let last = |grain: &Grain| grain.kind != Kind::Fibre;
    // No two have the same number in the same class.
    grains.sort_unstable_by(|p, q| {
        let by_volume = q.volume().total_cmp(&p.volume());
        last(p).cmp(&last(q)).then(by_volume).then((p.class, p.index).cmp(&(q.class, q.index)))
    });
}

/// Depth of the stone within outward `shells` and the ITZ around them, mm; 0 where there are none.
pub(super) fn coating_mm(itz_thickness_mm: f64, shells: &[Shell]) -> f64 {
    if !shells.iter().any(|shell| shell.outward) {
        return 0.0;
    }
    shells.iter().filter(|shell| shell.outward).fold(itz_thickness_mm, |sum, shell| sum + shell.thickness_mm)
}

impl Grain {
    /// Number in the library of the surface with dents that the grain is a copy of; `None` for grains without dents.
    pub fn copy_of(&self) -> Option<u32> {
        (self.body.form() == BodyForm::Surface).then_some(self.template)
    }

    /// Volume of the grain, mm3.
    pub fn volume(&self) -> f64 {
        self.body.volume()
    }

    /// Volume that counts for the grading, mm3: the stone's within outward shells.
    pub fn graded_volume(&self) -> f64 {
        self.stone_mm3.unwrap_or_else(|| self.volume())
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

/// Coordinates of grains and of their centres are multiples of 2^-30 mm: their sums are then exact in f64 up to 8 km,
/// so that translating a grain changes no shape, no volume and no face by rounding.
pub(crate) const LATTICE_MM: f64 = 1.0 / (1u64 << 30) as f64;

/// Rounds to the lattice of 2^-30 mm.
#[inline(always)]
pub fn snap(v: &Vec3) -> Vec3 {
    rounded_to(LATTICE_MM, v)
}

/// Rounds to multiples of `lattice`, a power of two.
#[inline(always)]
pub fn rounded_to(lattice: f64, v: &Vec3) -> Vec3 {
    v.map(|x| (x / lattice).round_ties_even() * lattice)
}

/// The vertices turned and rounded to the lattice.
pub fn turned(vertices: impl ExactSizeIterator<Item = Vec3>, rotation: &Mat3) -> Vec<Vec3> {
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
        Self::hull(kind, (class, index), &vertices)
    }

    fn hull(kind: Kind, ids: (u16, u32), vertices: &[Vec3]) -> Result<Self, HullError> {
        let body = convex_hull(vertices)?;
        let inner_radius = body.planes().map(|plane| plane.offset).fold(f64::INFINITY, f64::min);
        Ok(Self::around_origin(kind, ids, body, inner_radius))
    }

    /// Grows the grains by their outward shells and the ITZ around them.
    ///
    /// # Errors
    /// Grains that have no outward offset.
    pub fn coat(grains: &mut Vec<Self>) -> Result<(), OffsetError> {
        *grains = parallel::try_map(grains.len(), |number| grains[number].coated())?;
        in_order(grains);
        Ok(())
    }

    /// The grain that has this one as its stone, within its outward shells and the ITZ around them.
    ///
    /// Rounded to single precision, its planes are off by the millionth part of a millimetre that the stone's corners are off, too.
    fn coated(&self) -> Result<Self, OffsetError> {
        let (stone, thickness_mm) = (self.body.widened(), coating_mm(self.itz_thickness_mm, &self.shells));
        if thickness_mm == 0.0 {
            return Ok(self.clone());
        }
        let (ids, outer) = ((self.class, self.index), stone.outward_offset(thickness_mm)?);
        let rounded = |vertex: &Vec3| narrowed(&snap(vertex));
        let Self { body, outer_radius, inner_radius, .. } = match outer.form() {
            BodyForm::Round(round) => Self::of_ends(ids, &round.ends().map(|end| rounded(&end))),
            _ => Self::hull(self.kind, ids, &outer.vertices().iter().map(rounded).collect::<Vec<_>>())?,
        };
        Ok(Self { body, outer_radius, inner_radius, stone_mm3: Some(self.volume()), ..self.clone() })
    }

    /// The grain with dents that is `length` times as large as `unit`, in a random orientation, without ITZ.
    pub(super) fn dented(ids: (u16, u32), unit: &Polyhedron, length: f64, stream: &mut Stream) -> Self {
        let turn = stream.rotation().to_rotation_matrix().into_inner();
        let body = unit.mapped(|vertex| narrowed(&snap(&(turn * (vertex * length)))));
        // Single precision may close a part that is thinner than a millionth of the grain.
        let inner_radius = body.surface().depth(&Vec3::zeros()).max(0.0);
        Self::around_origin(Kind::Aggregate, ids, body, inner_radius)
    }

    /// The ball or ellipsoid with these semi-axes, mm, an ellipsoid in a random orientation, without ITZ.
    pub(super) fn round(ids: (u16, u32), semi_axes: &Vec3, stream: &mut Stream) -> Self {
        let round = Round::of_semi_axes(semi_axes);
        let turn = match round.radius() {
            Some(_) => Mat3::identity(),
            None => stream.rotation().to_rotation_matrix().into_inner(),
        };
        // Opposite ends are rounded alike, so that the centre stays.
        Self::of_ends(ids, &round.ends().map(|end| narrowed(&snap(&(turn * end)))))
    }

    fn of_ends(ids: (u16, u32), ends: &[Vec3]) -> Self {
        let inner_radius = Round::of_ends(ends).semi_axes()[2];
        Self::around_origin(Kind::Aggregate, ids, Polyhedron::of_ends(ends), inner_radius)
    }

    fn around_origin(kind: Kind, (class, index): (u16, u32), body: Polyhedron, inner_radius: f64) -> Self {
        let outer_radius = body.vertices().iter().map(Vec3::norm).fold(0.0, f64::max);
        Self {
            kind,
            own: None,
            class,
            index,
            template: 0,
            itz_thickness_mm: 0.0,
            shells: Vec::new(),
            stone_mm3: None,
            itz_limited: false,
            itz_thin: false,
            outer_radius: outer_radius as f32 * (1.0 + f32::EPSILON),
            inner_radius: inner_radius as f32 * (1.0 - f32::EPSILON),
            body: body.into(),
        }
    }
}
