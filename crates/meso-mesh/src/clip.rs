//! Which cells of a grid lie in a specimen that does not fill its bounding box.
//!
//! Cells with their centroids inside stay, as long as these have the specimen's volume. They do not always: of the squares of 2 mm
//! about a circle of 100 mm 0.6 % too many have their centres in it, which the mortar, half of the specimen, has to hold. Then
//! every voxel is sampled, and the ones with the largest shares inside are kept, as many as come closest to the volume.

use crate::cells::{CellKind, Mesh, NO_BODY};
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::parallel;
use meso_concrete::specimen::Container;
use meso_concrete::stop;

/// Centroids decide where they keep this share of the specimen's volume.
const CLOSE: f64 = 0.002;
/// Samples of a voxel along an axis: shares in steps of 1/216.
const SAMPLES: usize = 6;
/// Sub-samples of a whole voxel.
const ALL: u16 = (SAMPLES * SAMPLES * SAMPLES) as u16;

/// For every cell of `mesh` whether it is kept: all of aggregates, and those of mortar in `container`.
pub(super) fn kept(mesh: &Mesh, container: &dyn Container) -> Vec<bool> {
    let is_mortar = |cell: usize| mesh.owner[cell] == NO_BODY;
    let by_centroid = |cell: usize| !is_mortar(cell) || container.contains(&centroid(&corners(mesh, cell)));
    let inside = parallel::map_short(mesh.cell_count(), by_centroid);
    // Voxels have one volume.
    let voxel = if mesh.cell_count() == 0 { 0.0 } else { mesh.volume(0) };
    let wanted = container.volume() / voxel;
    let count = inside.iter().filter(|inside| **inside).count();
    if mesh.kind != CellKind::Hexahedron || (count as f64 - wanted).abs() <= CLOSE * wanted {
        return inside;
    }
    let share = |cell: usize| if is_mortar(cell) { samples(mesh, cell, container) } else { ALL };
    let shares = parallel::map_short(mesh.cell_count(), share);
    let least = least_share(&shares, wanted);
    shares.into_iter().map(|share| share >= least).collect()
}

/// The share with which, and above which, about `wanted` voxels are kept. Voxels of the same share stay together, so that what is
/// left is as symmetric as the specimen.
fn least_share(shares: &[u16], wanted: f64) -> u16 {
    let mut counts = [0usize; ALL as usize + 1];
    shares.iter().for_each(|&share| counts[usize::from(share)] += 1);
    let (mut best, mut kept) = ((f64::INFINITY, ALL), 0);
    for share in (1..=ALL).rev() {
        kept += counts[usize::from(share)];
        let off = (kept as f64 - wanted).abs();
        if off < best.0 {
            best = (off, share);
        }
    }
    best.1
}

/// How many samples of a voxel are inside.
fn samples(mesh: &Mesh, cell: usize, container: &dyn Container) -> u16 {
    stop::point();
    let corners = corners(mesh, cell);
    let voxel = Aabb::around(&corners);
    if container.is_clear(&centroid(&corners), voxel.size().norm() / 2.0) {
        return ALL;
    }
    let at = |number: usize, axis: usize| {
        let k = number / [1, SAMPLES, SAMPLES * SAMPLES][axis] % SAMPLES;
        voxel.min[axis] + voxel.size()[axis] * (k as f64 + 0.5) / SAMPLES as f64
    };
    let point = |number: usize| Vec3::from_fn(|axis, _| at(number, axis));
    (0..usize::from(ALL)).filter(|&number| container.contains(&point(number))).count() as u16
}

fn corners(mesh: &Mesh, cell: usize) -> Vec<Vec3> {
    mesh.by_owner().cell(cell).iter().map(|&node| mesh.points[node as usize]).collect()
}

fn centroid(corners: &[Vec3]) -> Vec3 {
    corners.iter().sum::<Vec3>() / corners.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn voxels_of_one_share_are_kept_together_and_come_closest_to_the_volume() {
        let shares = [ALL, ALL, 200, 200, 100, 100, 100, 0, 0];
        assert_eq!(least_share(&shares, 2.0), ALL);
        assert_eq!(least_share(&shares, 4.4), 200);
        assert_eq!(least_share(&shares, 5.6), 100);
        assert_eq!(least_share(&shares, 9.0), 100, "nothing that has no part inside is kept");
    }
}
