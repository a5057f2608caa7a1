//! The volume of an eroded body to hundreds of digits: Lawrence's formula over all triples of planes.
//!
//! For a simple polytope and a vector c, the volume is the sum over its vertices v of (c . v)^3 / (6 |det| g1 g2 g3),
//! where det is that of the three outward normals at v and g solves g1 n1 + g2 n2 + g3 n3 = c (Lawrence 1991).
//! Planes are pushed outwards by 2^-400 and less, each by a different amount, so that every vertex is simple.

use crate::exact::{cross as integer_cross, dot as integer_dot, in_units, minus};
use meso_collision::geometry::Polyhedron;
use num_bigint::BigInt;
use num_traits::{Signed, ToPrimitive, Zero};

/// Binary digits after the point.
const DIGITS: u64 = 1200;

type Fixed3 = [BigInt; 3];

/// The planes of a body with unit normals, in units of 2^`exponent` mm.
pub(crate) struct Planes {
    normals: Vec<Fixed3>,
    offsets: Vec<BigInt>,
    exponent: i32,
}

impl Planes {
    /// The exact planes of a body whose faces are plane to the last bit.
    pub(crate) fn of(body: &Polyhedron) -> Self {
        let size = body.vertices().iter().map(|v| (v - body.vertices()[0]).amax()).fold(0.0, f64::max);
        let exponent = libm::ilogb(size) + 1;
        let exact: Vec<Fixed3> = body.vertices().iter().map(|v| [v.x, v.y, v.z].map(|x| in_units(x, 300))).collect();
        let mut planes = Self { normals: Vec::new(), offsets: Vec::new(), exponent };
        for face in body.faces() {
            let corner = |k| &exact[face.vertex(k) as usize];
            let normal = integer_cross(&minus(corner(1), corner(0)), &minus(corner(2), corner(0)));
            let squared: BigInt = integer_dot(&normal, &normal) << (2 * DIGITS);
            let norm = squared.sqrt();
            let unit = normal.map(|n| divide(&(n << DIGITS), &norm));
            // Relative to the first vertex, from units of 2^-300 mm into units of 2^exponent mm.
            let height = integer_dot(&unit, &minus(corner(0), &exact[0])) >> (300 + exponent);
            planes.normals.push(unit);
            planes.offsets.push(height);
        }
        planes
    }

    /// The volume of the erosion by `thickness`, mm3; 0 where it has none.
    pub(crate) fn eroded_volume(&self, thickness: f64) -> f64 {
        let volume = self.volume(&in_units(thickness, DIGITS as i32 - self.exponent));
        // A flat rest has the volume of its pushed planes: about 2^-400.
        if volume.bits() < DIGITS - 370 { 0.0 } else { self.in_mm3(volume) }
    }

    fn in_mm3(&self, volume: BigInt) -> f64 {
        let spare = volume.bits() as i64 - 64;
        let head = if spare > 0 { &volume >> spare } else { &volume << -spare };
        libm::scalbn(head.to_f64().unwrap(), (spare - DIGITS as i64) as i32 + 3 * self.exponent)
    }

    fn volume(&self, thickness: &BigInt) -> BigInt {
        let offsets: Vec<BigInt> = (0_u32..)
            .zip(&self.offsets)
            .map(|(i, d)| d - thickness + (BigInt::from(1_000 + i * i * 7 % 997) << (DIGITS - 410)))
            .collect();
        let mut volume = BigInt::zero();
        for i in 0..offsets.len() {
            for j in 0..i {
                for k in 0..j {
                    volume += self.term([i, j, k], &offsets);
                }
            }
        }
        volume
    }

    /// The vertex's term of the sum, 0 where the three planes do not meet in a vertex of the body.
    fn term(&self, planes: [usize; 3], offsets: &[BigInt]) -> BigInt {
        let [a, b, c] = planes.map(|i| &self.normals[i]);
        let [bc, ca, ab] = [cross(b, c), cross(c, a), cross(a, b)];
        let determinant = dot(a, &bc);
        if determinant.bits() < DIGITS - 330 {
            return BigInt::zero();
        }
        let solve = |right: [&BigInt; 3]| -> Fixed3 {
            [0, 1, 2].map(|x| {
                divide(&(times(right[0], &bc[x]) + times(right[1], &ca[x]) + times(right[2], &ab[x])), &determinant)
            })
        };
        let vertex = solve(planes.map(|i| &offsets[i]));
        let outside = |i: usize| !planes.contains(&i) && dot(&self.normals[i], &vertex) > offsets[i];
        if (0..offsets.len()).any(outside) {
            return BigInt::zero();
        }
        // No edge of a lattice body is across it.
        let direction = [1_u32, 2, 7].map(|x| (BigInt::from(x) << (2 * DIGITS)).sqrt());
        let height = dot(&direction, &vertex);
        let denominator = [&bc, &ca, &ab]
            .map(|x| divide(&dot(&direction, x), &determinant))
            .iter()
            .fold(determinant.abs() * 6, |product, g| times(&product, g));
        divide(&times(&times(&height, &height), &height), &denominator)
    }
}

fn times(a: &BigInt, b: &BigInt) -> BigInt {
    (a * b) >> DIGITS
}

fn divide(a: &BigInt, b: &BigInt) -> BigInt {
    (a << DIGITS) / b
}

fn dot(a: &Fixed3, b: &Fixed3) -> BigInt {
    (&a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]) >> DIGITS
}

fn cross(a: &Fixed3, b: &Fixed3) -> Fixed3 {
    [(1, 2), (2, 0), (0, 1)].map(|(j, k)| (&a[j] * &b[k] - &a[k] * &b[j]) >> DIGITS)
}
