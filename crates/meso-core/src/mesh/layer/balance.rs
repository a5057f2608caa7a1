//! The layer's volume is made right where its thickness is free.
//!
//! Sharp cells are made blunter mostly by nodes that go farther in, so that a lattice's layer comes out too thick: in cubes of
//! 60 mm at 2 mm by 0.8 and 0.9 %, where the seats before that were 0.3 and 0.4 % short. The nodes that lie on no face of
//! their aggregate, at closed gaps (a third of the mesh's interface), have no exact place to go to: they go back by the share
//! of their way that brings the layers' volume to the exact one, as far as that leaves no cell too sharp.

use super::blunt::{NO_RAIL, Task, star, stars, tetrahedra};
use super::bodies::Bodies;
use super::sound::volume;
use crate::geometry::inward_offset;
use crate::math::Vec3;
use crate::mesh::lattice::Star;
use crate::mesh::{Mesh, Phase};
use rayon::prelude::*;

/// Rounds; each one makes up for the nodes that could not go in the one before.
const ROUNDS: usize = 3;
/// The share tried to see what it changes.
const TRIED: f64 = 0.1;
/// The largest share that a node goes in a round.
const MOST: f64 = 0.1;
/// Cells added up together.
const RUN: usize = 1 << 12;

/// Moves the inner ends of rails that are `loose`, with their images, until the layers of `mesh` have `exact` mm3.
pub(super) fn balance(mesh: &mut Mesh, task: &Task, loose: &[bool], exact: f64) {
    let is_free = |node: u32| loose.get(node as usize) == Some(&true) && task.outer[node as usize] != NO_RAIL;
    let all_free = |node: &u32| task.faces.images(*node).into_iter().all(is_free);
    let nodes: Vec<u32> = (0..mesh.points.len() as u32).filter(all_free).collect();
    let stars = stars(mesh, &nodes);
    let ends = |mesh: &Mesh, node: u32| [node, task.outer[node as usize]].map(|end| mesh.points[end as usize]);
    for _ in 0..ROUNDS {
        let before = total(mesh, &mesh.points);
        let mut tried = mesh.points.clone();
        for &node in &nodes {
            let [inner, outer] = ends(mesh, node);
            tried[node as usize] = inner + (outer - inner) * TRIED;
        }
        let lost = (before - total(mesh, &tried)) / TRIED;
        let share = if lost > 0.0 { ((before - exact) / lost).clamp(-MOST, MOST) } else { 0.0 };
        // All images at once, when their first comes up.
        for &node in nodes.iter().filter(|&&node| task.faces.images(node)[0] == node && !stars.cells(node).is_empty()) {
            let [inner, outer] = ends(mesh, node);
            let place = inner + task.faces.flat(node).along(&(outer - inner)) * share;
            let images = task.faces.images(node);
            let mut all: Vec<(u32, Star)> =
                images.iter().map(|&image| (image, star(mesh, image, stars.cells(image)))).collect();
            let limit = all.iter_mut().map(|(_, star)| star.sharpest_first()).fold(task.limit, f64::max);
            if all.iter().all(|(image, star)| star.worst(&task.faces.put(*image, &place), limit) <= limit) {
                images.iter().for_each(|&image| mesh.points[image as usize] = task.faces.put(image, &place));
            }
        }
    }
}

/// The volume of all layers in truth, mm3, those of a body and its images once.
pub(super) fn exact(bodies: &Bodies, thickness: impl Fn(u32) -> f64 + Sync) -> Option<f64> {
    let shell = |body: u32| {
        let whole = &bodies.get(body).body;
        let core = inward_offset(whole, thickness(body)).ok()?.map_or(0.0, |core| core.volume());
        Some(whole.volume() - core)
    };
    let ones: Vec<u32> = bodies.first_of_each().filter(|body| thickness(*body) > 0.0).collect();
    let shells = ones.into_par_iter().map(shell).collect::<Option<Vec<f64>>>()?;
    Some(shells.into_iter().sum())
}

/// The volume of the layers with the nodes at `points`, mm3; the same on any number of threads.
fn total(mesh: &Mesh, points: &[Vec3]) -> f64 {
    let of_run = |(cells, phases): (&[[u32; 4]], &[Phase])| -> f64 {
        let itz = cells.iter().zip(phases).filter(|(_, phase)| **phase == Phase::Itz);
        itz.map(|(cell, _)| volume(cell.map(|node| points[node as usize]))).sum()
    };
    let runs: Vec<f64> = tetrahedra(mesh).par_chunks(RUN).zip(mesh.phase.par_chunks(RUN)).map(of_run).collect();
    runs.into_iter().sum()
}
