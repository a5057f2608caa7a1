//! Images of surface nodes on the offsets of the very faces that meet at the node.
//!
//! A ray may leave the offset through the plane beside: then a triangle at an edge ends up across the offset's edge and
//! cuts it off (0.036 mm rms over the layer's inner side in a 30 mm cube at 2 mm). So a node's seat is the point nearest
//! to its image that lies on the offsets of all its own faces: on the plane of one, the line of two, the point of three.
//! More have no common point in general, since there the offset has small edges of its own; the squares of what is left
//! are least then (0.006 mm rms in all).

use super::flat::Flat;
use super::shrink::{Shrink, Shrinks};
use super::ties::Ties;
use crate::math::{Mat3, Vec3};
use crate::mesh::Mesh;
use crate::mesh::separate::Copies;
use rayon::prelude::*;

/// Points this far from a plane count as on it, in depths of the centre.
const ON: f64 = 1e-9;
/// Damps a step where the faces hardly decide on it: planes 2 degrees apart and less.
const DAMPING: f64 = 1e-3;
/// Steps until the damping no longer counts: each leaves half of a gap between planes 2 degrees apart, less of others.
const STEPS: usize = 30;

/// Moves the images of the copies of interface nodes onto their seats; returns the copies that lie on no face of their body,
/// and keep their images.
pub(super) fn seat(mesh: &Mesh, copies: &Copies, shrinks: &Shrinks, ties: &Ties, images: &mut [Vec3]) -> Vec<u32> {
    let all: Vec<_> = copies.iter().filter(|(.., copy)| ties.leads(*copy) && !ties.is_pinned(*copy)).collect();
    let seated = |&(body, node, copy): &(u32, u32, u32)| {
        let flat = ties.flat(copy);
        let shrink = shrinks.get(body, flat)?;
        Some((copy, on_own_faces(shrink, flat, &mesh.points[node as usize], &images[copy as usize])))
    };
    let seated: Vec<(u32, Option<Vec3>)> = all.par_iter().filter_map(seated).collect();
    let mut loose = Vec::new();
    for (copy, seat) in seated {
        match seat {
            Some(seat) => images[copy as usize] = seat,
            None => loose.push(copy),
        }
    }
    ties.spread(images);
    loose
}

/// The seat on `flat` of the node at `x`, whose image along its ray is `image`; none where no face holds the node.
fn on_own_faces(shrink: &Shrink, flat: Flat, x: &Vec3, image: &Vec3) -> Option<Vec3> {
    let from_centre = x - shrink.centre;
    let holds = |plane: &&(Vec3, f64)| (plane.0.dot(&from_centre) - plane.1).abs() <= ON * plane.1;
    let own: Vec<&(Vec3, f64)> = shrink.planes.iter().filter(holds).collect();
    let slopes: Vec<Vec3> = own.iter().map(|plane| flat.along(&plane.0)).collect();
    let damped = slopes.iter().map(|slope| slope * slope.transpose()).sum::<Mat3>() + Mat3::identity() * DAMPING;
    let inverse = damped.try_inverse().filter(|_| !own.is_empty())?;
    let mut place = image - shrink.centre;
    for _ in 0..STEPS {
        let lack = |plane: &(Vec3, f64)| plane.1 - shrink.thickness - plane.0.dot(&place);
        place += inverse * slopes.iter().zip(&own).map(|(slope, plane)| slope * lack(plane)).sum::<Vec3>();
    }
    Some(shrink.centre + place)
}
