//! Rotation of a body's vertices, and the box of the result.

use super::contact::{LANES, V, highest};
use crate::Turn;
use meso_collision::geometry::{BodyForm, CompactPolyhedron};
use meso_collision::math::Vec3;
use meso_collision::simd::{Wide, widest};
use meso_concrete::aggregate::Grain;

/// Vertices that the dynamics see of a round shape: a ball's centre, which has a rim, or the facets around an ellipsoid.
fn round_vertices(shape: &CompactPolyhedron) -> Option<Vec<Vec3>> {
    let BodyForm::Round(round) = shape.form() else { return None };
    Some(if round.radius().is_some() { vec![*round.centre()] } else { round.circumscribed() })
}

/// Number of vertices that the dynamics see of a shape.
pub(super) fn vertex_count(shape: &CompactPolyhedron) -> usize {
    round_vertices(shape).map_or_else(|| shape.vertex_count(), |vertices| vertices.len())
}

/// Radius of the sphere about the centre that holds them, and the rim of a ball, mm.
pub(super) fn outer_radius(grain: &Grain) -> f32 {
    let around = round_vertices(&grain.body).unwrap_or_default();
    around.iter().map(|vertex| vertex.norm() as f32).fold(grain.outer_radius, f32::max)
}

/// Turns the vertices of `shape` by `rotation` into `turned`, with copies of the first to the end; returns the box of
/// the result.
pub(super) fn turn(shape: &CompactPolyhedron, turned: &mut [f32], rotation: &Turn) -> (V, V) {
    let len = turned.len() / 3;
    if let Some(around) = round_vertices(shape) {
        for (axis, turned) in turned.chunks_exact_mut(len).enumerate() {
            turned.iter_mut().zip(&around).for_each(|(to, vertex)| *to = vertex[axis] as f32);
            turned[around.len()..].fill(around[0][axis] as f32);
        }
        return turn_on(turned, rotation);
    }
    for (turned, along) in turned.chunks_exact_mut(len).zip(shape.coordinates()) {
        turned[..along.len()].copy_from_slice(along);
        turned[along.len()..].fill(along[0]);
    }
    turn_on(turned, rotation)
}

/// Turns all of `turned` on by `rotation`; returns the box of the result.
pub(super) fn turn_on(turned: &mut [f32], rotation: &Turn) -> (V, V) {
    widest(TurnOn { turned, rotation })
}

/// [`turn_on`] on wide registers.
struct TurnOn<'a> {
    turned: &'a mut [f32],
    rotation: &'a Turn,
}

impl Wide for TurnOn<'_> {
    type Output = (V, V);

    #[inline(always)]
    fn run(self) -> (V, V) {
        let Self { turned, rotation } = self;
        let m = rotation.to_rotation_matrix().into_inner();
        let row = |i: usize| [m[(i, 0)], m[(i, 1)], m[(i, 2)]];
        let rows = [row(0), row(1), row(2)];
        let mut extents = [Extent::NONE; 3];
        let (x, yz) = turned.split_at_mut(turned.len() / 3);
        let (y, z) = yz.split_at_mut(x.len());
        let blocks = x.as_chunks_mut::<LANES>().0.iter_mut().zip(y.as_chunks_mut::<LANES>().0).zip(z.as_chunks_mut().0);
        for ((x, y), z) in blocks {
            let from = (*x, *y, *z);
            *x = along(rows[0], &from);
            *y = along(rows[1], &from);
            *z = along(rows[2], &from);
            extents[0].include(x);
            extents[1].include(y);
            extents[2].include(z);
        }
        let [x, y, z] = extents;
        ([x.low(), y.low(), z.low()], [x.high(), y.high(), z.high()])
    }
}

/// Several values side by side.
type Lanes = [f32; LANES];

/// Support values in direction `d`.
#[inline(always)]
fn along(d: V, (x, y, z): &(Lanes, Lanes, Lanes)) -> Lanes {
    let mut along = [0.0; LANES];
    for lane in 0..LANES {
        along[lane] = d[0] * x[lane] + d[1] * y[lane] + d[2] * z[lane];
    }
    along
}

/// Lowest and highest values, lane by lane.
#[derive(Clone, Copy)]
struct Extent {
    low: Lanes,
    high: Lanes,
}

impl Extent {
    const NONE: Self = Self { low: [f32::INFINITY; LANES], high: [f32::NEG_INFINITY; LANES] };

    #[inline(always)]
    fn include(&mut self, values: &Lanes) {
        for ((low, high), &value) in self.low.iter_mut().zip(&mut self.high).zip(values) {
            *low = if value < *low { value } else { *low };
            *high = if value > *high { value } else { *high };
        }
    }

    #[inline(always)]
    fn low(&self) -> f32 {
        -highest(self.low.map(|value| -value))
    }

    #[inline(always)]
    fn high(&self) -> f32 {
        highest(self.high)
    }
}
