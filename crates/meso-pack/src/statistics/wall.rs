//! The wall effect: less aggregate near a mould, since no grain's middle comes closer to it than its radius.

use super::{Sample, in_order};
use meso_collision::geometry::{BodyForm, Polyhedron};
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::aggregate::random::{Draw, Stream};
use meso_concrete::parallel;
use serde::{Deserialize, Serialize};

/// Points to a batch: each batch has its own random stream.
const BATCH: u32 = 4096;

/// Aggregate fraction by layers parallel to the surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WallEffect {
    /// Middle of the layer below the specimen's surface, mm.
    pub depth_mm: Vec<f64>,
    /// Share of the layer's sampled points that lie in an aggregate.
    pub fraction: Vec<f64>,
    /// Sampled points in the layer: the fraction's standard error is sqrt(f (1 - f) / points).
    pub points: Vec<u64>,
}

/// Batches whose points are held at a time: bodies with dents are asked for the points of all of them.
const HELD: u32 = 64;
/// A body with dents makes a tree of its triangles for so many points: for fewer, passes over all triangles are faster.
const MANY: usize = 32;

/// A point in the specimen.
struct Point {
    at: Vec3,
    layer: usize,
    is_covered: bool,
}

pub(super) fn wall_effect(sample: &Sample) -> WallEffect {
    let width = layer_width(sample);
    let mut total: Vec<[u64; 2]> = Vec::new();
    let batches = sample.options.points.div_ceil(BATCH);
    for first in (0..batches).step_by(HELD as usize) {
        let mut points: Vec<Point> = Vec::new();
        let last = batches.min(first.saturating_add(HELD));
        in_order(last - first, |k| drawn(sample, first + k), |mut batch| points.append(&mut batch));
        cover_by_dents(sample, &mut points);
        for point in &points {
            total.resize(total.len().max(point.layer + 1), [0; 2]);
            let [all, covered] = &mut total[point.layer];
            *all += 1;
            *covered += u64::from(point.is_covered);
        }
    }
    let mut effect = WallEffect::default();
    for (layer, [all, covered]) in total.into_iter().enumerate().filter(|(_, [all, _])| *all > 0) {
        effect.depth_mm.push((layer as f64 + 0.5) * width);
        effect.fraction.push(covered as f64 / all as f64);
        effect.points.push(all);
    }
    effect
}

/// The points of a batch that lie in the specimen, covered by bodies without dents or not yet.
fn drawn(sample: &Sample, batch: u32) -> Vec<Point> {
    let mut stream = Stream::new(sample.options.seed, Draw::Sample, 0, u64::from(batch));
    let (container, width) = (sample.container.aabb(), layer_width(sample));
    let points = BATCH.min(sample.options.points - batch * BATCH);
    let drawn = (0..points).map(|_| stream.point(&container.min, &container.max)).filter_map(|at| {
        let depth = sample.container.depth(&at);
        let covers = |body: &Polyhedron| !is_slow(body) && body.contains(&at);
        let is_covered = || near(sample, &at).into_iter().any(|a| covers(&sample.aggregates[a as usize].body));
        let is_in = depth >= 0.0 && depth.is_finite();
        is_in.then(|| Point { at, layer: (depth / width) as usize, is_covered: is_covered() })
    });
    drawn.collect()
}

/// Covers the points that lie in bodies with dents, body by body.
fn cover_by_dents(sample: &Sample, points: &mut [Point]) {
    if !sample.aggregates.iter().any(|aggregate| is_slow(&aggregate.body)) {
        return;
    }
    let mut asked: Vec<(u32, u32)> = parallel::flat_map(points.len(), |k| {
        let near = if points[k].is_covered { Vec::new() } else { near(sample, &points[k].at) };
        let with_dents = near.into_iter().filter(|&a| is_slow(&sample.aggregates[a as usize].body));
        with_dents.map(move |a| (a, k as u32)).collect::<Vec<_>>()
    });
    asked.sort_unstable();
    asked.dedup();
    let of_bodies: Vec<&[(u32, u32)]> = asked.chunk_by(|p, q| p.0 == q.0).collect();
    let covered: Vec<u32> = parallel::flat_map(of_bodies.len(), |k| {
        let body = &sample.aggregates[of_bodies[k][0].0 as usize].body;
        let surface = (of_bodies[k].len() >= MANY).then(|| body.surface());
        let holds = |at: &Vec3| surface.as_ref().map_or_else(|| body.contains(at), |surface| surface.contains(at));
        let held = of_bodies[k].iter().map(|&(_, point)| point).filter(|&point| holds(&points[point as usize].at));
        held.collect::<Vec<_>>()
    });
    covered.into_iter().for_each(|point| points[point as usize].is_covered = true);
}

/// Whether a body holds a point takes long to find out: it is asked for many points at once.
fn is_slow(body: &Polyhedron) -> bool {
    body.form() == BodyForm::Surface
}

/// As asked, but never so thin that the layers do not fit into memory.
fn layer_width(sample: &Sample) -> f64 {
    (1e-3 * sample.container.aabb().size().max()).max(sample.options.layer_mm)
}

/// The aggregates whose boxes hold a point.
fn near(sample: &Sample, at: &Vec3) -> Vec<u32> {
    let mut near = Vec::new();
    sample.index.near(&Aabb { min: *at, max: *at }, &mut near);
    near
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{StatisticsOptions, WithImages};
    use meso_concrete::watch::Silent;
    use meso_spec::Spec;

    /// A packing of bodies whose section is an L.
    fn spec() -> Spec {
        let section = [[0, 0], [4, 0], [4, 1], [1, 1], [1, 4], [0, 4]];
        let vertices: Vec<[i32; 3]> = [0, 3].iter().flat_map(|z| section.map(|[x, y]| [x, y, *z])).collect();
        let caps = (1..5).flat_map(|k| [[0, k + 1, k], [6, k + 6, k + 7]]);
        let sides = (0..6).map(|k| (k, (k + 1) % 6)).flat_map(|(k, next)| [[k, next, next + 6], [k, next + 6, k + 6]]);
        let faces: Vec<[usize; 3]> = caps.chain(sides).collect();
        let grain = format!("grains = [{{ vertices = {vertices:?}, faces = {faces:?} }}]");
        let sizes = "specimen = { kind = 'cube', side_mm = 30 }\ngrading = { d_min_mm = 6, d_max_mm = 14 }";
        Spec::from_toml(&format!("fraction = 0.1\n{sizes}\n[shape]\nkind = 'library'\n{grain}\n")).unwrap()
    }

    /// 20 s of 24 for the page of 87 stones of 4,224 triangles went by here, while every point passed all triangles.
    #[test]
    fn points_are_covered_by_bodies_with_dents_as_if_each_was_asked_alone() {
        let model = crate::pack(&spec(), &Silent).unwrap();
        let (container, images) = (model.spec.specimen.container(), WithImages::near(&model, 1.0));
        let mut seen = [0; 2];
        for points in [400, 20_000] {
            let options = &StatisticsOptions { points, layer_mm: 5.0, ..StatisticsOptions::default() };
            let sample =
                Sample { container: &*container, aggregates: &images.aggregates, index: &images.index, options };
            let effect = wall_effect(&sample);
            let batches = (0..points.div_ceil(BATCH)).flat_map(|batch| drawn(&sample, batch));
            let mut counts = vec![[0_u64; 2]; effect.points.len()];
            for point in batches {
                let holds = model.aggregates.iter().any(|aggregate| aggregate.body.contains(&point.at));
                counts[point.layer][usize::from(holds)] += 1;
            }
            let told: Vec<[u64; 2]> = effect
                .points
                .iter()
                .zip(&effect.fraction)
                .map(|(all, share)| {
                    let held = (*all as f64 * share).round() as u64;
                    [all - held, held]
                })
                .collect();
            assert_eq!(told, counts);
            counts.iter().for_each(|[out, held]| seen = [seen[0] + out, seen[1] + held]);
        }
        assert!(model.aggregates.iter().all(|aggregate| is_slow(&aggregate.body)));
        assert!(seen[1] > 1000 && seen[0] > 1000, "{seen:?}");
    }
}
