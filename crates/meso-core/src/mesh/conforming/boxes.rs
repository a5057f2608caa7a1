//! The surfaces in a box that repeats itself or is meshed in slabs: cut grains, their caps on the box's faces and between the
//! slabs, and what mortar has of these.

use super::faces::{self, Face};
use super::facets::LONGEST;
use super::pieces::{Piece, pieces};
use super::sheets::{self, Upper};
use super::shells::Shells;
use super::slabs::Slabs;
use crate::aggregate::Aggregate;
use crate::math::{Aabb, Vec3};
use crate::mesh::MeshError;
use crate::packing::Period;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Nodes this near to a face are on it, mm.
const ON_FACE_MM: f64 = 1e-7;

/// The surfaces of `aggregates` and all their images in the box `domain`, with edges of about `size` mm, slab by slab.
///
/// # Errors
/// Where a face of the box grazes an aggregate.
pub(super) fn shells(
    aggregates: &[Aggregate],
    period: &Period,
    domain: &Aabb,
    slabs: &Slabs,
    size: f64,
) -> Result<Vec<Shells>, MeshError> {
    let limit = LONGEST * size;
    let pieces = pieces(aggregates, period, domain, slabs)?;
    let lower = |(pieces, aabb): (&Vec<Piece>, &Aabb)| {
        let faces = (0..3).into_par_iter().map(|axis| faces::lower(axis, aabb, pieces, limit));
        faces.collect::<Result<Vec<Face>, MeshError>>()
    };
    let boxes = slabs.boxes(domain);
    let faces: Vec<Vec<Face>> = pieces.par_iter().zip(&boxes).map(lower).collect::<Result<_, MeshError>>()?;
    let of_slab = |slab: usize| {
        sheets::shells(&pieces[slab], aggregates, limit, |sheets, nodes| {
            for (axis, lower) in faces[slab].iter().enumerate() {
                // Above the last slab the first one comes again.
                let above = if axis == slabs.axis { (slab + 1) % boxes.len() } else { slab };
                let step = i32::from(axis != slabs.axis || above == 0);
                let (face, place) = (&faces[above][axis], boxes[slab].max[axis]);
                sheets.add_lower(lower, nodes);
                sheets.add_upper(&Upper { face, pieces: &pieces[above], axis, place, step }, &pieces[slab], nodes);
            }
        })
    };
    (0..boxes.len()).into_par_iter().map(of_slab).collect()
}

/// Refuses nodes on a face of `domain` across which the box repeats itself that have none opposite to them.
///
/// # Errors
/// Names the first.
pub(super) fn all_matched(points: &[Vec3], period: &Period, domain: &Aabb) -> Result<(), MeshError> {
    for axis in (0..3).filter(|&axis| period.along(axis).is_some()) {
        let [low, high] = [domain.min, domain.max].map(|face| {
            let on = points.iter().filter(|point| (point[axis] - face[axis]).abs() <= ON_FACE_MM);
            // -0 and 0 are one place.
            let within = |point: &Vec3| [1, 2].map(|next| (point[(axis + next) % 3] + 0.0).to_bits());
            on.map(|point| (within(point), [point.x, point.y, point.z])).collect::<BTreeMap<_, _>>()
        });
        let lone = |here: &BTreeMap<_, [f64; 3]>, there: &BTreeMap<[u64; 2], _>| {
            here.iter().find(|(within, _)| !there.contains_key(*within)).map(|(_, at)| *at)
        };
        if let Some(at) = lone(&low, &high).or_else(|| lone(&high, &low)) {
            return Err(MeshError::Unmatched { at });
        }
    }
    Ok(())
}
