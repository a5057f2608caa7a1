//! Shape and orientation of the aggregates.
//!
//! The lengths a >= b >= c of an aggregate are its extents along the principal axes of its inertia tensor (the edges of
//! its box along these axes).

use super::Distribution;
use meso_collision::geometry::principal_axes;
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
    sieve: f64,
}

impl Shapes {
    pub(super) fn of(aggregates: &[Aggregate]) -> Self {
        let all = parallel::map_each(aggregates, measure);
        let distribution = |figure: &dyn Fn(&Measured) -> f64| Distribution::of(all.iter().map(figure));
        Self {
            length_mm: distribution(&|m| m.extents[0]),
            elongation: distribution(&|m| m.extents[1] / m.extents[0]),
            flatness: distribution(&|m| m.extents[2] / m.extents[1]),
            wadell_sphericity: distribution(&|m| m.wadell),
            krumbein_sphericity: distribution(&|m| {
                libm::cbrt(m.extents[1] * m.extents[2]) / libm::cbrt(m.extents[0] * m.extents[0])
            }),
            sieve_size_mm: distribution(&|m| m.sieve),
            zingg: zingg(&all),
        }
    }
}

fn measure(aggregate: &Aggregate) -> Measured {
    let body = &aggregate.body;
    let axes = principal_axes(&body.mass_properties().inertia);
    let mut extents = [0, 1, 2].map(|k| {
        let along = body.vertices().iter().map(|v| axes.column(k).dot(v));
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
    });
    extents.sort_by(|x, y| y.total_cmp(x));
    let six_volumes = libm::cbrt(6.0 * body.volume());
    let wadell = libm::cbrt(std::f64::consts::PI) * six_volumes * six_volumes / body.area();
    Measured { extents, wadell, sieve: body.sieve_size() }
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
        let longest =
            |a: &Aggregate| -> Vec3 { principal_axes(&a.body.mass_properties().inertia).column(0).into_owned() };
        let axes = parallel::map_each(aggregates, longest);
        let mean = axes.iter().map(|a| a * a.transpose()).sum::<Mat3>() / axes.len().max(1) as f64;
        let basis = principal_axes(&mean);
        let eigenvalue = |k: usize| basis.column(k).dot(&(mean * basis.column(k)));
        Self { tensor: mean.into(), eigenvalues: [0, 1, 2].map(eigenvalue) }
    }
}
