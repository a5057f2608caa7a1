//! The faces of a periodic box as triangles, one and the same on both sides.
//!
//! The lower face of each axis is triangulated with the rims of the cut grains in it ([`plane`](super::plane)), and moved by
//! the period it is the upper one.

use super::facets::halved;
use super::pieces::Piece;
use super::plane::{Frame, Plane};
use crate::math::{Aabb, Vec3};
use crate::mesh::MeshError;
use std::collections::BTreeMap;

/// A lower face: its triangles counter-clockwise seen from above, each with the piece whose cap it is part of.
pub(super) struct Face {
    pub(super) points: Vec<Vec3>,
    pub(super) triangles: Vec<([u32; 3], Option<usize>)>,
}

/// The lower face of `domain` across `axis`, cut by `pieces`; no edge in it is longer than `limit` mm by much.
///
/// # Errors
/// Says which rims cross: of disjoint grains none do.
pub(super) fn lower(axis: usize, domain: &Aabb, pieces: &[Piece], limit: f64) -> Result<Face, MeshError> {
    let caps: Vec<(usize, Vec<Vec3>)> = caps(axis, pieces).collect();
    let rims = Sides { axis, domain }.rims(&caps, limit);
    let mut plane = Plane::new(Frame::across(axis, domain.min[axis]), &rims, limit)?;
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
struct Sides<'a> {
    axis: usize,
    domain: &'a Aabb,
}

impl Sides<'_> {
    fn in_plane(&self) -> [usize; 2] {
        [(self.axis + 1) % 3, (self.axis + 2) % 3]
    }

    /// The rims of `caps` and the face's four sides, as nodes in a row.
    fn rims(&self, caps: &[(usize, Vec<Vec3>)], limit: f64) -> Vec<Vec<Vec3>> {
        let of_caps = caps.iter().flat_map(|(_, corners)| edges(corners));
        // What grains have of the sides is among their parts.
        let of_caps = of_caps.filter(|(from, to)| !self.is_on_a_side(from, to));
        self.sides(caps).into_iter().chain(of_caps).map(|(from, to)| halved(from, to, limit)).collect()
    }

    fn is_on_a_side(&self, from: &Vec3, to: &Vec3) -> bool {
        let both = |axis: usize, place: f64| from[axis] == place && to[axis] == place;
        self.in_plane().into_iter().any(|axis| both(axis, self.domain.min[axis]) || both(axis, self.domain.max[axis]))
    }

    /// The parts of the face's four sides between the grains' edges there.
    fn sides(&self, caps: &[(usize, Vec<Vec3>)]) -> Vec<(Vec3, Vec3)> {
        let [u, v] = self.in_plane();
        let mut parts = Vec::new();
        for (along, across) in [(u, v), (v, u)] {
            for place in [self.domain.min[across], self.domain.max[across]] {
                let mut start = self.domain.min;
                start[across] = place;
                let mut end = start;
                end[along] = self.domain.max[along];
                let corners = caps.iter().flat_map(|cap| &cap.1).filter(|corner| corner[across] == place);
                let mut stops: Vec<Vec3> = corners.copied().chain([start, end]).collect();
                stops.sort_by(|a, b| a[along].total_cmp(&b[along]));
                stops.dedup();
                parts.extend(stops.windows(2).map(|pair| (pair[0], pair[1])));
            }
        }
        parts
    }
}

/// Nodes by their places, bit for bit.
#[derive(Default)]
pub(super) struct Nodes {
    pub(super) points: Vec<Vec3>,
    numbers: BTreeMap<[u64; 3], u32>,
}

impl Nodes {
    /// The number of the node at `place`, a new one where there is none.
    pub(super) fn at(&mut self, place: Vec3) -> u32 {
        // -0 and 0 are one place.
        let key: [u64; 3] = place.map(|x| (x + 0.0).to_bits()).into();
        *self.numbers.entry(key).or_insert_with(|| {
            self.points.push(place);
            self.points.len() as u32 - 1
        })
    }
}
