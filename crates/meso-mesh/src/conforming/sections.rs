//! The surfaces of specimens in slabs: bodies and the specimen's own surface, cut by the planes between the slabs and by the
//! faces of a periodic box; the caps there; and the mortar's part of these planes and faces.
//!
//! The lower face of each axis is triangulated with the rims of the cut bodies in it ([`FittedPlane`]); moved by the
//! period it is the upper one.

use super::clipped::{self, Cuts, Piece, pieces};
use super::plc::{Face, Shells, Upper, shells, surface};
use crate::error::MeshError;
use crate::triangulation::{FittedPlane, Frame, LONGEST, Nodes, halved, region};
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::parallel;
use meso_concrete::specimen::{Period, Surface};
use std::collections::BTreeMap;

/// Nodes this near to a face are on it, mm.
const ON_FACE_MM: f64 = 1e-7;

/// The surfaces of the placed bodies and all their images in the box, slab by slab.
///
/// # Errors
/// Where a face of the box grazes an aggregate.
pub(super) fn of_box(cuts: Cuts) -> Result<Vec<Shells>, MeshError> {
    let Cuts { placed, domain, slabs, size, .. } = cuts;
    let limit = LONGEST * size;
    let pieces = pieces(cuts)?;
    let boxes = slabs.boxes(domain);
    let lower = |slab: usize| parallel::try_map(3, |axis| lower_face(axis, &boxes[slab], &pieces[slab], limit));
    let faces: Vec<Vec<Face>> = parallel::try_map(boxes.len(), lower)?;
    let of_slab = |slab: usize| {
        shells(&pieces[slab], placed, limit, |sheets, nodes| {
            for (axis, lower) in faces[slab].iter().enumerate() {
                // Above the last slab the first one comes again.
                let above = if axis == slabs.axis { (slab + 1) % boxes.len() } else { slab };
                let step = i32::from(axis != slabs.axis || above == 0);
                let (face, position) = (&faces[above][axis], boxes[slab].max[axis]);
                sheets.add_lower(lower, nodes);
                sheets.add_upper(&Upper { face, pieces: &pieces[above], axis, position, step }, &pieces[slab], nodes);
            }
        })
    };
    parallel::try_map(boxes.len(), of_slab)
}

/// Refuses nodes on a face of `domain` across which the box repeats itself that have none opposite to them.
///
/// # Errors
/// Names the first.
pub(super) fn all_matched(points: &[Vec3], period: &Period, domain: &Aabb) -> Result<(), MeshError> {
    for axis in (0..3).filter(|&axis| period.along(axis).is_some()) {
        let [low, high] = [domain.min, domain.max].map(|face| {
            let on = points.iter().filter(|point| (point[axis] - face[axis]).abs() <= ON_FACE_MM);
            // -0 and 0 are one position.
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

/// The surfaces of the placed bodies within the specimen's own, `walls`, slab by slab; there is no period.
///
/// # Errors
/// Where a plane between slabs grazes an aggregate.
pub(super) fn of_walls(cuts: Cuts, walls: Surface) -> Result<Vec<Shells>, MeshError> {
    let Cuts { placed, slabs, size, .. } = cuts;
    let limit = LONGEST * size;
    let pieces = pieces(cuts)?;
    let walls = clipped::walls(walls, slabs, cuts.period);
    let of_plane = |plane: usize| {
        let above = plane + 1;
        section(slabs.axis, slabs.positions[plane], &walls[above], &pieces[above], limit)
    };
    let planes: Vec<Face> = parallel::try_map(walls.len() - 1, of_plane)?;
    let of_slab = |slab: usize| {
        let walls = surface(&walls[slab], limit)?;
        shells(&pieces[slab], placed, limit, |sheets, nodes| {
            sheets.add_walls(&walls, nodes);
            if slab > 0 {
                sheets.add_lower(&planes[slab - 1], nodes);
            }
            if let Some(face) = planes.get(slab) {
                let (axis, position) = (slabs.axis, slabs.positions[slab]);
                let upper = Upper { face, pieces: &pieces[slab + 1], axis, position, step: 0 };
                sheets.add_upper(&upper, &pieces[slab], nodes);
            }
        })
    };
    parallel::try_map(walls.len(), of_slab)
}

/// The plane at `position` across `axis` below the pieces of a slab: within the walls' outline, and in the caps of its `pieces`.
fn section(axis: usize, position: f64, walls: &Piece, pieces: &[Piece], limit: f64) -> Result<Face, MeshError> {
    let frame = Frame::across(axis, position);
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
        triangles.extend(nodes.triangles(&region).into_iter().map(|triangle| (triangle, piece)));
    }
    Ok(Face { points: nodes.points, triangles })
}

/// The lower face of `domain` across `axis`, cut by `pieces`; no edge in it is longer than `limit` mm by much.
///
/// # Errors
/// Says which rims cross: of disjoint bodies none do.
fn lower_face(axis: usize, domain: &Aabb, pieces: &[Piece], limit: f64) -> Result<Face, MeshError> {
    let caps: Vec<(usize, Vec<Vec3>)> = caps(axis, pieces).collect();
    let rims = FaceSides { axis, domain }.rims(&caps, limit);
    let mut plane = FittedPlane::new(Frame::across(axis, domain.min[axis]), &rims, limit)?;
    let mut piece = vec![None; plane.count()];
    for (index, corners) in caps {
        // Counter-clockwise from outside is clockwise from above.
        let nodes = halved(corners[1], corners[0], limit);
        plane.within(nodes[0], nodes[1])?.into_iter().for_each(|triangle| piece[triangle] = Some(index));
    }
    let triangles = plane.triangles().map(|(number, nodes)| (nodes, piece[number])).collect();
    Ok(Face { points: plane.points, triangles })
}

/// The caps on the lower face of `axis` with their pieces.
fn caps(axis: usize, pieces: &[Piece]) -> impl Iterator<Item = (usize, Vec<Vec3>)> {
    (0..).zip(pieces).flat_map(move |(index, piece)| piece.loops(axis, false).map(move |cap| (index, cap)))
}

fn edges(corners: &[Vec3]) -> impl Iterator<Item = (Vec3, Vec3)> {
    (0..corners.len()).map(|k| (corners[k], corners[(k + 1) % corners.len()]))
}

/// The sides of the lower face across an axis.
#[derive(Clone, Copy)]
struct FaceSides<'a> {
    axis: usize,
    domain: &'a Aabb,
}

impl FaceSides<'_> {
    fn in_plane(&self) -> [usize; 2] {
        [(self.axis + 1) % 3, (self.axis + 2) % 3]
    }

    /// The rims of `caps` and the face's four sides, as nodes in a row.
    fn rims(&self, caps: &[(usize, Vec<Vec3>)], limit: f64) -> Vec<Vec<Vec3>> {
        let of_caps = caps.iter().flat_map(|(_, corners)| edges(corners));
        // The edges of bodies on the sides are among the parts of these.
        let of_caps = of_caps.filter(|(from, to)| !self.is_on_a_side(from, to));
        self.sides(caps).into_iter().chain(of_caps).map(|(from, to)| halved(from, to, limit)).collect()
    }

    fn is_on_a_side(&self, from: &Vec3, to: &Vec3) -> bool {
        let both = |axis: usize, position: f64| from[axis] == position && to[axis] == position;
        self.in_plane().into_iter().any(|axis| both(axis, self.domain.min[axis]) || both(axis, self.domain.max[axis]))
    }

    /// The parts of the face's four sides between the bodies' edges there.
    fn sides(&self, caps: &[(usize, Vec<Vec3>)]) -> Vec<(Vec3, Vec3)> {
        let [u, v] = self.in_plane();
        let mut parts = Vec::new();
        for (along, across) in [(u, v), (v, u)] {
            for position in [self.domain.min[across], self.domain.max[across]] {
                let mut start = self.domain.min;
                start[across] = position;
                let mut end = start;
                end[along] = self.domain.max[along];
                let corners = caps.iter().flat_map(|cap| &cap.1).filter(|corner| corner[across] == position);
                let mut stops: Vec<Vec3> = corners.copied().chain([start, end]).collect();
                stops.sort_by(|a, b| a[along].total_cmp(&b[along]));
                stops.dedup();
                parts.extend(stops.windows(2).map(|pair| (pair[0], pair[1])));
            }
        }
        parts
    }
}
