//! Further phases: spherical voids and straight fibres, polyhedra that are placed together with the aggregates.
//!
//! A void is the hull of the 12 corners of an icosahedron and the 20 of its dual on one sphere (a pentakis
//! dodecahedron): 60 triangles, and 32 corners, which collision takes at once. A fibre is a prism of eight sides. Both
//! have exactly the volume of the sphere or the cylinder they stand for. They have no ITZ.

use super::SizeLaw;
use super::random::{Purpose, Stream};
use super::take::{Grain, Recipe, fill};
use crate::geometry::{HullError, convex_hull};
use crate::math::{Mat3, Rotation, Vec3};
use nalgebra::Rotation3;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2, TAU};

/// What a placed body is.
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

/// Spherical voids, `[voids]` in a spec.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Voids {
    /// Their volume over the specimen's, 0 to 1.
    pub fraction: f64,
    /// Smallest and largest diameter, mm; every diameter between them is drawn equally often.
    pub diameter_mm: [f64; 2],
}

/// Straight fibres, `[fibres]` in a spec.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Fibres {
    /// Their volume over the specimen's, 0 to 1.
    pub fraction: f64,
    /// Diameter of the cylinder of the same volume and length, mm.
    pub diameter_mm: f64,
    /// Length, mm.
    pub length_mm: f64,
    /// Directions before placement; all are equally likely where it is absent. Rearrangement rotates the fibres
    /// further: the statistics report by how much.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<Cone>,
}

/// The directions within an angle of one direction, all equally likely.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Cone {
    /// Its axis, of any length; a fibre has no front and no back.
    pub direction: [f64; 3],
    /// Half of its opening, degrees; 0 for parallel fibres, 90 for all directions.
    pub within_degrees: f64,
}

/// The further phases of a spec.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inclusions {
    /// `[voids]`.
    pub voids: Option<Voids>,
    /// `[fibres]`.
    pub fibres: Option<Fibres>,
}

impl Kind {
    /// All kinds but the aggregates, in the order of their classes.
    pub const FURTHER: [Self; 2] = [Self::Void, Self::Fibre];

    /// Its name.
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

impl Voids {
    /// Volume of a void in the mean, mm3.
    pub fn mean_volume(&self) -> f64 {
        let [low, high] = self.diameter_mm;
        if low == high { PI / 6.0 * low * low * low } else { PI / 6.0 * SizeLaw::Uniform.mean_cube(low, high) }
    }

    /// The largest polyhedron's longest diagonal, mm.
    pub fn longest(&self) -> f64 {
        self.diameter_mm[1] * ball()[0].norm()
    }
}

impl Fibres {
    /// Volume of a fibre, mm3.
    pub fn volume(&self) -> f64 {
        PI / 4.0 * self.diameter_mm * self.diameter_mm * self.length_mm
    }

    /// The prism's longest diagonal, mm.
    pub fn longest(&self) -> f64 {
        let across = 2.0 * OCTAGON.sqrt() * self.diameter_mm;
        (self.length_mm * self.length_mm + across * across).sqrt()
    }
}

impl Inclusions {
    /// Their volume over the specimen's, in the order of [`Kind::FURTHER`]; 0 where there are none.
    pub fn fractions(&self) -> [f64; 2] {
        [self.voids.map_or(0.0, |voids| voids.fraction), self.fibres.map_or(0.0, |fibres| fibres.fraction)]
    }
}

/// Square of an octagon's circumradius over that of a circle's diameter, of the same area: pi / (8 sqrt 2).
const OCTAGON: f64 = PI / (8.0 * SQRT_2);

/// Adds voids and fibres for a specimen of `volume` mm3 to the `grains`; their classes begin at `first_class`.
///
/// # Errors
/// A body so small that the lattice of coordinates flattens it.
pub(super) fn take(grains: &mut Vec<Grain>, recipe: &Recipe, first_class: u16, volume: f64) -> Result<(), HullError> {
    let Inclusions { voids, fibres } = recipe.inclusions;
    if let Some(voids) = voids {
        let (ball, [low, high], class) = (ball(), voids.diameter_mm, first_class);
        let make = |index| {
            let stream = &mut Stream::new(recipe.seed, Purpose::Take, class, u64::from(index));
            let radius = stream.uniform(low, high) / 2.0;
            let vertices: Vec<Vec3> = ball.iter().map(|vertex| vertex * radius).collect();
            Grain::turned(Kind::Void, (class, index), &vertices, stream)
        };
        fill(grains, voids.fraction * volume, recipe.go_on, make)?;
    }
    if let Some(fibres) = fibres {
        let (prism, class) = (prism(fibres), first_class + 1);
        let make = |index| {
            let stream = &mut Stream::new(recipe.seed, Purpose::Take, class, u64::from(index));
            match fibres.orientation {
                Some(cone) => Grain::oriented(Kind::Fibre, (class, index), &prism, &cone.rotation(stream)),
                None => Grain::turned(Kind::Fibre, (class, index), &prism, stream),
            }
        };
        fill(grains, fibres.fraction * volume, recipe.go_on, make)?;
    }
    Ok(())
}

impl Cone {
    /// Turns the x axis to a direction of the cone, and about that by any angle.
    fn rotation(&self, stream: &mut Stream) -> Rotation {
        let [axis, across, third] = frame(&Vec3::from(self.direction).normalize());
        // A cone's directions lie on a cap, whose area is even along its axis.
        let cos = stream.uniform(libm::cos(self.within_degrees.to_radians()), 1.0);
        let (sin, around) = (libm::sqrt(1.0 - cos * cos), TAU * stream.unit());
        let x = axis * cos + (across * libm::cos(around) + third * libm::sin(around)) * sin;
        let [x, y, z] = frame(&x);
        let roll = TAU * stream.unit();
        let y = y * libm::cos(roll) + z * libm::sin(roll);
        Rotation::from_rotation_matrix(&Rotation3::from_matrix_unchecked(Mat3::from_columns(&[x, y, x.cross(&y)])))
    }
}

/// A unit vector with two more, each square to the others and right-handed.
fn frame(x: &Vec3) -> [Vec3; 3] {
    let mut aside = Vec3::zeros();
    aside[x.iamin()] = 1.0;
    let y = (aside - x * x.dot(&aside)).normalize();
    [*x, y, x.cross(&y)]
}

/// Corners on a sphere, whose hull has the volume of a ball of radius 1.
fn ball() -> Vec<Vec3> {
    let golden = (1.0 + 5.0f64.sqrt()) / 2.0;
    let mut corners = Vec::with_capacity(32);
    for [p, q] in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
        // The icosahedron's corners, then the dual's.
        for [x, y, z] in [[0.0, p, q * golden], [p / golden, 0.0, q * golden]] {
            corners.extend([[x, y, z], [y, z, x], [z, x, y]]);
        }
        corners.extend([[p, q, 1.0], [p, q, -1.0]]);
    }
    let corners: Vec<Vec3> = corners.into_iter().map(|corner| Vec3::from(corner).normalize()).collect();
    let hull = convex_hull(&corners).expect("the corners lie all around the origin");
    let radius = libm::cbrt(4.0 / 3.0 * PI / hull.volume());
    corners.iter().map(|corner| corner * radius).collect()
}

/// The prism along x.
fn prism(fibres: &Fibres) -> Vec<Vec3> {
    let (half, radius) = (fibres.length_mm / 2.0, OCTAGON.sqrt() * fibres.diameter_mm);
    const S: f64 = FRAC_1_SQRT_2;
    let around = [[1.0, 0.0], [S, S], [0.0, 1.0], [-S, S], [-1.0, 0.0], [-S, -S], [0.0, -1.0], [S, -S]];
    let corner = |x: f64| around.map(|[y, z]| Vec3::new(x, y * radius, z * radius));
    [corner(-half), corner(half)].concat()
}
