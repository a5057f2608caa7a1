//! Further phases: spherical voids and straight fibres, polyhedra that are placed together with the aggregates.
//!
//! A void is the hull of the 12 corners of an icosahedron and the 20 of its dual on one sphere (a pentakis
//! dodecahedron): 60 triangles, and 32 corners, which collision takes at once. A fibre is a prism of eight sides. Both
//! have exactly the volume of the sphere or the cylinder they stand for. They have no ITZ.

use super::grain::{Grain, Kind};
use super::random::Stream;
use super::{Grading, SizeClass, SizeLaw};
use meso_collision::geometry::{HullError, convex_hull};
use meso_collision::math::{Mat3, Rotation, Vec3};
use nalgebra::Rotation3;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2, TAU};

/// Spherical voids, `[voids]` in a spec.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Voids {
    /// Their volume over the specimen's, 0 to 1.
    pub fraction: f64,
    /// Smallest and largest diameter, mm; every diameter between them is drawn equally often.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diameter_mm: Option<[f64; 2]>,
    /// Diameters by a grading of their own, as `[grading]` has the sizes of the aggregates; instead of `diameter_mm`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grading: Option<Grading>,
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
pub struct Inclusions<'a> {
    /// `[voids]`.
    pub voids: Option<&'a Voids>,
    /// `[fibres]`.
    pub fibres: Option<Fibres>,
}

impl Voids {
    /// Classes of their diameters, from the finest.
    pub fn classes(&self) -> Vec<SizeClass> {
        let one = |[d_min_mm, d_max_mm]: [f64; 2]| vec![SizeClass { d_min_mm, d_max_mm, share: 1.0 }];
        self.grading.as_ref().map_or_else(|| self.diameter_mm.map(one).unwrap_or_default(), Grading::classes)
    }

    /// Smallest and largest diameter, mm.
    pub fn limits_mm(&self) -> [f64; 2] {
        let classes = self.classes();
        [classes.first().map_or(0.0, |class| class.d_min_mm), classes.last().map_or(0.0, |class| class.d_max_mm)]
    }

    /// Diameter of the sphere of a void's volume, mm.
    pub fn diameter_of(volume_mm3: f64) -> f64 {
        libm::cbrt(volume_mm3 * 6.0 / PI)
    }

    /// Distribution of the diameters within a class.
    pub fn size_law(&self) -> SizeLaw {
        self.grading.as_ref().map_or(SizeLaw::Uniform, |grading| grading.size_law)
    }

    /// Volume asked for over the specimen's: a raw curve leaves a part of the fraction.
    pub fn asked(&self) -> f64 {
        self.grading.as_ref().map_or(1.0, |own| own.passing(own.d_max_mm) - own.passing(own.d_min_mm)) * self.fraction
    }

    /// Voids in a unit of the specimen's volume, in the mean, 1/mm3.
    pub fn per_mm3(&self) -> f64 {
        let law = self.size_law();
        let number = |class: &SizeClass| class.share / (PI / 6.0 * law.mean_cube(class.d_min_mm, class.d_max_mm));
        self.fraction * self.classes().iter().map(number).sum::<f64>()
    }

    /// The largest polyhedron's longest diagonal, mm.
    pub fn longest(&self) -> f64 {
        self.limits_mm()[1] * ball()[0].norm()
    }

    /// A void of these `(class, index)`: the corners of the [`ball`], as large as drawn in a class of diameters, in a random
    /// orientation.
    pub(super) fn grain(
        &self,
        ball: &[Vec3],
        diameters: &SizeClass,
        ids: (u16, u32),
        stream: &mut Stream,
    ) -> Result<Grain, HullError> {
        let radius = self.size_law().size(diameters.d_min_mm, diameters.d_max_mm, stream.unit()) / 2.0;
        let vertices: Vec<Vec3> = ball.iter().map(|vertex| vertex * radius).collect();
        Grain::turned(Kind::Void, ids, &vertices, stream)
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

    /// A fibre of these `(class, index)`: the [`prism`](Self::prism) in a direction of the cone, or in any.
    pub(super) fn grain(&self, prism: &[Vec3], ids: (u16, u32), stream: &mut Stream) -> Result<Grain, HullError> {
        match self.orientation {
            Some(cone) => Grain::oriented(Kind::Fibre, ids, prism, &cone.rotation(stream)),
            None => Grain::turned(Kind::Fibre, ids, prism, stream),
        }
    }

    /// The prism along x.
    pub(super) fn prism(&self) -> Vec<Vec3> {
        let (half, radius) = (self.length_mm / 2.0, OCTAGON.sqrt() * self.diameter_mm);
        const S: f64 = FRAC_1_SQRT_2;
        let around = [[1.0, 0.0], [S, S], [0.0, 1.0], [-S, S], [-1.0, 0.0], [-S, -S], [0.0, -1.0], [S, -S]];
        let corner = |x: f64| around.map(|[y, z]| Vec3::new(x, y * radius, z * radius));
        [corner(-half), corner(half)].concat()
    }
}

impl Inclusions<'_> {
    /// Volumes of voids and fibres over the specimen's, in the order of [`Kind::FURTHER`]; 0 where there are none.
    pub fn fractions(&self) -> [f64; 2] {
        [self.voids.map_or(0.0, Voids::asked), self.fibres.map_or(0.0, |fibres| fibres.fraction)]
    }
}

/// Square of an octagon's circumradius over that of a circle's diameter, of the same area: pi / (8 sqrt 2).
const OCTAGON: f64 = PI / (8.0 * SQRT_2);

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
pub(super) fn ball() -> Vec<Vec3> {
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
