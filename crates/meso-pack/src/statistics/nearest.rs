//! Thickness of the mortar between an aggregate and the nearest other one.

use super::index::Index;
use super::{Distribution, WithImages};
use crate::model::Model;
use meso_collision::geometry::Polyhedron;
use meso_collision::gjk::GjkError;
use meso_collision::math::{Aabb, Vec3};
use meso_collision::posed::{Posed, WithTree};
use meso_concrete::aggregate::Aggregate;
use meso_concrete::parallel;
use meso_concrete::stop;

/// Distances from one of every `step` aggregates to the nearest other one, mm; `None` where there is no other. In a periodic
/// specimen images count as others, an aggregate's own among them.
pub(super) fn nearest_distances(
    model: &Model,
    images: &WithImages,
    step: usize,
) -> Result<Option<Distribution>, GjkError> {
    let (asked, specimen) = (Asked { count: model.aggregates.len().div_ceil(step), step }, &model.spec.specimen);
    let mut found = distances(&images.aggregates, asked, &images.index)?;
    let mut margin = images.margin;
    // An image further off than those at hand may be nearer than the nearest of them.
    while !specimen.period().is_none() && found.iter().any(|distance| *distance > margin - outmost(model)) {
        margin *= 2.0;
        let wider = WithImages::near(model, margin);
        found = distances(&wider.aggregates, asked, &wider.index)?;
    }
    Ok(Distribution::of(found.into_iter().filter(|distance| distance.is_finite())))
}

/// How far aggregates reach out of the specimen's box, mm.
fn outmost(model: &Model) -> f64 {
    let container = model.spec.specimen.aabb();
    let beyond = |body: Aabb| (container.min - body.min).sup(&(body.max - container.max)).max();
    model.aggregates.iter().map(|aggregate| beyond(aggregate.body.aabb())).fold(0.0, f64::max)
}

/// The aggregates that look for their neighbours: so many, one of every `step`.
#[derive(Clone, Copy)]
struct Asked {
    count: usize,
    step: usize,
}

/// From each of those asked; infinite where there is no other.
fn distances(aggregates: &[Aggregate], asked: Asked, index: &Index) -> Result<Vec<f64>, GjkError> {
    if aggregates.len() < 2 {
        return Ok(vec![f64::INFINITY; asked.count]);
    }
    parallel::try_map(asked.count, |k| nearest(aggregates, index, (k * asked.step) as u32))
}

/// Looks into a growing box around the aggregate until the nearest found is nearer than the box reaches.
fn nearest(aggregates: &[Aggregate], index: &Index, a: u32) -> Result<f64, GjkError> {
    stop::point();
    let own = index.aabb(a);
    let own_body = WithTree::new(&aggregates[a as usize].body);
    let mut reach = 0.25 * index.cell();
    loop {
        let margin = Vec3::repeat(reach);
        let mut near = Vec::new();
        index.near(&Aabb { min: own.min - margin, max: own.max + margin }, &mut near);
        near.sort_unstable();
        near.dedup();
        let mut candidates: Vec<(f64, u32)> =
            near.into_iter().filter(|&b| b != a).map(|b| (gap(own, index.aabb(b)), b)).collect();
        candidates.sort_by(|x, y| x.0.total_cmp(&y.0));
        let mut best = f64::INFINITY;
        for (at_least, b) in candidates {
            if at_least < best {
                best = best.min(distance_below(&own_body, &aggregates[b as usize].body, best)?);
            }
        }
        if best <= reach {
            return Ok(best);
        }
        // An aggregate found further off than the box reaches bounds the search; none found doubles it.
        reach = if best.is_finite() { best } else { 2.0 * reach };
    }
}

/// Distance to another body, mm, or infinity where it is farther than `best`: rejecting a farther body costs a fraction
/// of its distance, which is correctly rounded.
fn distance_below(own: &WithTree<&Polyhedron>, other: &Polyhedron, best: f64) -> Result<f64, GjkError> {
    let other = WithTree::new(other);
    let is_far = best.is_finite() && own.is_farther(&other, best)?;
    if is_far { Ok(f64::INFINITY) } else { own.distance(&other) }
}

/// Distance between two boxes.
fn gap(a: &Aabb, b: &Aabb) -> f64 {
    let apart = (a.min - b.max).sup(&(b.min - a.max));
    apart.sup(&Vec3::zeros()).norm()
}
