//! Shape and orientation of the aggregates.
//!
//! The lengths a >= b >= c of an aggregate are its extents along the principal axes of its inertia tensor (the edges of
//! its box along these axes). Equal moments leave axes free, and rounding would choose them: cubes had lengths of 1 to 1.7
//! edges. The narrowest of the free directions is taken first then, and a free longest axis counts for all its directions.

use super::Distribution;
use meso_collision::geometry::{BodyForm, Polyhedron, principal_axes};
use meso_collision::math::{Mat3, Vec3};
use meso_concrete::aggregate::Aggregate;
use meso_concrete::parallel;
use serde::{Deserialize, Serialize};

/// Shape of all aggregates, each counted once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Shapes {
    /// Longest extent a, mm.
    pub length_mm: Option<Distribution>,
    /// Elongation b / a.
    pub elongation: Option<Distribution>,
    /// Flatness c / b.
    pub flatness: Option<Distribution>,
    /// Wadell's sphericity: surface of the ball of the same volume over the surface (Wadell 1932).
    pub wadell_sphericity: Option<Distribution>,
    /// Krumbein's intercept sphericity, the cube root of b c / a^2 (Krumbein 1941).
    pub krumbein_sphericity: Option<Distribution>,
    /// Convexity: volume over that of the convex hull.
    pub convexity: Option<Distribution>,
    /// Width of the smallest square hole passed, mm.
    pub sieve_size_mm: Option<Distribution>,
    /// Numbers by Zingg's classes.
    pub zingg: Zingg,
}

/// Zingg's four classes, divided at b / a = 2/3 and c / b = 2/3 (Zingg 1935).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Zingg {
    /// Both ratios above 2/3.
    pub equant: usize,
    /// Flat, not elongated: c / b at most 2/3.
    pub disc: usize,
    /// Elongated, not flat: b / a at most 2/3.
    pub rod: usize,
    /// Both at most 2/3.
    pub blade: usize,
}

/// Directions of the longest axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Orientation {
    /// Mean of a a^T over the unit vectors a along the longest axes: a third of the identity where there is no order.
    pub tensor: [[f64; 3]; 3],
    /// Eigenvalues of the orientation tensor, ascending; they sum to 1.
    pub eigenvalues: [f64; 3],
}

struct Measured {
    extents: [f64; 3],
    wadell: f64,
    convexity: f64,
    sieve: f64,
}

impl Shapes {
    /// The shapes of one of every `step` aggregates.
    pub(super) fn of(aggregates: &[Aggregate], step: usize) -> Self {
        let all = parallel::map(aggregates.len().div_ceil(step), |k| measure(&aggregates[k * step]));
        let distribution = |figure: &dyn Fn(&Measured) -> f64| Distribution::of(all.iter().map(figure));
        Self {
            length_mm: distribution(&|m| m.extents[0]),
            elongation: distribution(&|m| m.extents[1] / m.extents[0]),
            flatness: distribution(&|m| m.extents[2] / m.extents[1]),
            wadell_sphericity: distribution(&|m| m.wadell),
            krumbein_sphericity: distribution(&|m| {
                libm::cbrt(m.extents[1] * m.extents[2]) / libm::cbrt(m.extents[0] * m.extents[0])
            }),
            convexity: distribution(&|m| m.convexity),
            sieve_size_mm: distribution(&|m| m.sieve),
            zingg: zingg(&all),
        }
    }
}

fn measure(aggregate: &Aggregate) -> Measured {
    let body = &aggregate.body;
    let convexity = body.volume() / body.hull().expect("an aggregate has a volume").volume();
    Measured { extents: extents(body), wadell: body.sphericity(), convexity, sieve: body.sieve_size() }
}

/// Moments of inertia that differ by this share of the largest are equal: vertices are rounded to single precision.
const EQUAL_MOMENTS: f64 = 5e-7;

/// Principal axes of a body, the longest first.
struct Principal {
    axes: Mat3,
    /// Whether the first two moments are equal, and the last two.
    equal: [bool; 2],
}

impl Principal {
    fn of(body: &Polyhedron) -> Self {
        let inertia = body.mass_properties().inertia;
        let axes = principal_axes(&inertia);
        let moment = |k: usize| axes.column(k).dot(&(inertia * axes.column(k)));
        let equal = |k: usize| moment(k + 1) - moment(k) <= EQUAL_MOMENTS * moment(2);
        Self { axes, equal: [equal(0), equal(1)] }
    }

    fn axis(&self, k: usize) -> Vec3 {
        self.axes.column(k).into_owned()
    }

    /// Mean of a a^T over the directions a that the longest axis may have.
    fn longest(&self) -> Mat3 {
        let [a, b] = [self.axis(0), self.axis(1)];
        match self.equal {
            [true, true] => Mat3::identity() / 3.0,
            [true, false] => (a * a.transpose() + b * b.transpose()) / 2.0,
            _ => a * a.transpose(),
        }
    }
}

/// Extents along the principal axes, descending.
fn extents(body: &Polyhedron) -> [f64; 3] {
    if let BodyForm::Round(round) = body.form() {
        return round.semi_axes().map(|axis| 2.0 * axis);
    }
    let principal = Principal::of(body);
    let axes = match principal.equal {
        [false, false] => [0, 1, 2].map(|k| principal.axis(k)),
        [true, true] => {
            let sides = sides(body);
            let normals = sides.iter().enumerate().flat_map(|(i, p)| sides[..i].iter().map(move |q| p.cross(q)));
            narrowest_around(body, &narrowest(body, normals))
        }
        [true, false] => narrowest_around(body, &principal.axis(2)),
        [false, true] => narrowest_around(body, &principal.axis(0)),
    };
    let mut extents = axes.map(|axis| extent(body, &axis));
    extents.sort_by(|x, y| y.total_cmp(x));
    extents
}

fn extent(body: &Polyhedron, axis: &Vec3) -> f64 {
    let along = body.vertices().iter().map(|v| axis.dot(v));
    along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
}

/// An axis, the narrowest direction orthogonal to it, and the third axis.
fn narrowest_around(body: &Polyhedron, axis: &Vec3) -> [Vec3; 3] {
    let second = narrowest(body, sides(body).iter().map(|side| axis.cross(side)));
    [*axis, second, axis.cross(&second)]
}

/// The unit direction among `normals` along which the body is narrowest. Parallel sides leave normals without length.
fn narrowest(body: &Polyhedron, normals: impl Iterator<Item = Vec3>) -> Vec3 {
    let directions = normals.filter_map(|normal| normal.try_normalize(1e-6));
    let widths = directions.map(|direction| (extent(body, &direction), direction));
    widths.min_by(|p, q| p.0.total_cmp(&q.0)).map_or_else(Vec3::x, |(_, direction)| direction)
}

/// Unit vectors along the sides of all triangles.
fn sides(body: &Polyhedron) -> Vec<Vec3> {
    let side = |from: u32, to: u32| body.vertices()[to as usize] - body.vertices()[from as usize];
    let triangles = body.triangles().flat_map(|[a, b, c]| [(a, b), (b, c), (c, a)]);
    triangles.filter(|(from, to)| from < to).map(|(from, to)| side(from, to).normalize()).collect()
}

fn zingg(all: &[Measured]) -> Zingg {
    let mut zingg = Zingg::default();
    for Measured { extents: [a, b, c], .. } in all {
        let class = match (3.0 * b > 2.0 * a, 3.0 * c > 2.0 * b) {
            (true, true) => &mut zingg.equant,
            (true, false) => &mut zingg.disc,
            (false, true) => &mut zingg.rod,
            (false, false) => &mut zingg.blade,
        };
        *class += 1;
    }
    zingg
}

impl Orientation {
    pub(super) fn of(aggregates: &[Aggregate]) -> Self {
        let axes = parallel::map_each(aggregates, |aggregate| Principal::of(&aggregate.body).longest());
        let mean = axes.iter().sum::<Mat3>() / axes.len().max(1) as f64;
        let basis = principal_axes(&mean);
        let eigenvalue = |k: usize| basis.column(k).dot(&(mean * basis.column(k)));
        Self { tensor: mean.into(), eigenvalues: [0, 1, 2].map(eigenvalue) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_collision::geometry::convex_hull;
    use meso_collision::math::Rotation;

    /// Corners of a block, turned and rounded to single precision.
    fn turned(half: [f64; 3], seed: u32) -> Polyhedron {
        let turn = Rotation::new(Vec3::new(1.0, 0.3, -0.7) * f64::from(seed));
        let corner = |i: usize| Vec3::from_fn(|k, _| if i >> k & 1 == 1 { half[k] } else { -half[k] });
        let corners: Vec<Vec3> = (0..8).map(|i| (turn * corner(i)).map(|x| f64::from(x as f32))).collect();
        convex_hull(&corners).unwrap()
    }

    #[test]
    fn extents_of_regular_blocks_do_not_depend_on_orientation() {
        for seed in 0..30 {
            for half in [[5.0, 5.0, 5.0], [5.0, 5.0, 1.25], [5.0, 2.5, 2.5], [5.0, 4.0, 3.0]] {
                for (found, half) in extents(&turned(half, seed)).into_iter().zip(half) {
                    assert!((found - 2.0 * half).abs() < 1e-5, "seed {seed}: {found}, not {}", 2.0 * half);
                }
            }
        }
    }

    #[test]
    fn longest_axes_that_are_free_have_no_direction() {
        for seed in 0..30 {
            assert!((Principal::of(&turned([5.0; 3], seed)).longest() - Mat3::identity() / 3.0).amax() < 1e-12);
            let turn = Rotation::new(Vec3::new(1.0, 0.3, -0.7) * f64::from(seed));
            let across = turn * Vec3::z();
            let plate = (Mat3::identity() - across * across.transpose()) / 2.0;
            assert!((Principal::of(&turned([5.0, 5.0, 1.25], seed)).longest() - plate).amax() < 1e-6);
        }
    }
}
