//! The surfaces in a specimen that is no box, in slabs: grains and the specimen's own surface cut by the planes between these,
//! the caps there, and what mortar has of the planes.

use super::faces::{Face, Nodes};
use super::facets::LONGEST;
use super::pieces::{self, Piece, pieces};
use super::plane::{Frame, region};
use super::sheets::{self, Upper, surface};
use super::shells::Shells;
use super::slabs::Slabs;
use crate::aggregate::Aggregate;
use crate::math::{Aabb, Vec3};
use crate::mesh::MeshError;
use crate::packing::{Period, Surface};
use rayon::prelude::*;

/// The surfaces of `aggregates` within the specimen's own, `walls`, with edges of about `size` mm, slab by slab; there is no
/// `period`.
///
/// # Errors
/// Where a plane between slabs grazes an aggregate.
pub(super) fn shells(
    aggregates: &[Aggregate],
    walls: Surface,
    period: &Period,
    domain: &Aabb,
    slabs: &Slabs,
    size: f64,
) -> Result<Vec<Shells>, MeshError> {
    let limit = LONGEST * size;
    let pieces = pieces(aggregates, period, domain, slabs)?;
    let walls = pieces::walls(walls, slabs, period);
    let of_plane = |(above, place): (usize, &f64)| section(slabs.axis, *place, &walls[above], &pieces[above], limit);
    let planes = (1..walls.len()).into_par_iter().zip(&slabs.places).map(of_plane);
    let planes: Vec<Face> = planes.collect::<Result<_, MeshError>>()?;
    let of_slab = |slab: usize| {
        let walls = surface(&walls[slab], limit)?;
        sheets::shells(&pieces[slab], aggregates, limit, |sheets, nodes| {
            sheets.add_walls(&walls, nodes);
            if slab > 0 {
                sheets.add_lower(&planes[slab - 1], nodes);
            }
            if let Some(face) = planes.get(slab) {
                let (axis, place) = (slabs.axis, slabs.places[slab]);
                let upper = Upper { face, pieces: &pieces[slab + 1], axis, place, step: 0 };
                sheets.add_upper(&upper, &pieces[slab], nodes);
            }
        })
    };
    (0..walls.len()).into_par_iter().map(of_slab).collect()
}

/// The plane at `place` across `axis` below what is in a slab: within the walls' outline, and in the caps of its `pieces`.
fn section(axis: usize, place: f64, walls: &Piece, pieces: &[Piece], limit: f64) -> Result<Face, MeshError> {
    let frame = Frame::across(axis, place);
    let upward = |loops: Vec<Vec3>| loops.into_iter().rev().collect::<Vec<Vec3>>();
    let outlines = walls.loops(axis, false).map(upward);
    // Around the mortar caps go the other way.
    let caps = || pieces.iter().flat_map(|piece| piece.loops(axis, false));
    let mut regions = vec![(None, region(frame, &outlines.chain(caps()).collect::<Vec<_>>(), limit)?)];
    for (index, piece) in pieces.iter().enumerate() {
        for cap in piece.loops(axis, false) {
            regions.push((Some(index), region(frame, &[upward(cap)], limit)?));
        }
    }
    let (mut nodes, mut triangles) = (Nodes::default(), Vec::new());
    for (piece, region) in regions {
        let number: Vec<u32> = region.points.iter().map(|point| nodes.at(*point)).collect();
        let own = region.triangles.iter().map(|triangle| (triangle.map(|node| number[node as usize]), piece));
        triangles.extend(own);
    }
    Ok(Face { points: nodes.points, triangles })
}
