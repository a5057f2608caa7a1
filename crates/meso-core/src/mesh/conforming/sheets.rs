//! The surfaces of one slab put together on common nodes: facets of pieces, their caps, and what mortar has of the sides.
//!
//! Mortar may be in several parts: a flat grain can cut a corner off a box.

use super::faces::{Face, Nodes};
use super::facets::{Triangles, facets};
use super::parts;
use super::pieces::Piece;
use super::shells::{Filled, Shells};
use crate::aggregate::{Aggregate, Kind};
use crate::math::Vec3;
use crate::mesh::MeshError;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// What `pieces` and the sides that `add` puts around them enclose; edges are at most `limit` mm long.
///
/// # Errors
/// Says what cannot be cut into triangles, or does not close.
pub(super) fn shells(
    pieces: &[Piece],
    aggregates: &[Aggregate],
    limit: f64,
    add: impl FnOnce(&mut Sheets, &mut Nodes),
) -> Result<Shells, MeshError> {
    let surfaces = pieces.par_iter().map(|piece| surface(piece, limit));
    let surfaces: Vec<Triangles> = surfaces.collect::<Result<_, MeshError>>()?;
    let mut nodes = Nodes::default();
    let mut sheets = Sheets::new(pieces, &surfaces, &mut nodes);
    add(&mut sheets, &mut nodes);
    let mut shells = Shells { points: nodes.points, ..Shells::default() };
    sheets.shells(pieces, aggregates, &mut shells).map(|()| shells)
}

/// A piece's own facets in triangles, its rims cut as the faces on the other side have them.
pub(super) fn surface(piece: &Piece, limit: f64) -> Result<Triangles, MeshError> {
    facets(&piece.points, piece.facets.iter().cloned(), limit)
}

/// The upper face of a slab: the lower one of what is above it, moved.
pub(super) struct Upper<'a> {
    pub(super) face: &'a Face,
    /// What is above it.
    pub(super) pieces: &'a [Piece],
    pub(super) axis: usize,
    pub(super) place: f64,
    /// Periods between the two.
    pub(super) step: i32,
}

impl Upper<'_> {
    fn moved(&self, point: &Vec3) -> Vec3 {
        Vec3::from_fn(|i, _| if i == self.axis { self.place } else { point[i] })
    }

    /// Grain and image of what is below the piece `above`.
    fn below(&self, above: usize) -> (usize, [i32; 3]) {
        let mut steps = self.pieces[above].steps;
        steps[self.axis] += self.step;
        (self.pieces[above].grain, steps)
    }
}

/// The triangles on common nodes.
pub(super) struct Sheets {
    /// Of every piece.
    facets: Vec<Vec<[u32; 3]>>,
    caps: Vec<Vec<[u32; 3]>>,
    /// Of the box's faces, between the caps.
    rest: Vec<[u32; 3]>,
}

impl Sheets {
    fn new(pieces: &[Piece], facets: &[Triangles], nodes: &mut Nodes) -> Self {
        let own = |surface: &Triangles| {
            let number: Vec<u32> = surface.points.iter().map(|point| nodes.at(*point)).collect();
            surface.triangles.iter().map(|triangle| triangle.map(|node| number[node as usize])).collect()
        };
        Self { facets: facets.iter().map(own).collect(), caps: vec![Vec::new(); pieces.len()], rest: Vec::new() }
    }

    /// Adds the part of the specimen's own surface that bounds mortar.
    pub(super) fn add_walls(&mut self, walls: &Triangles, nodes: &mut Nodes) {
        let number: Vec<u32> = walls.points.iter().map(|point| nodes.at(*point)).collect();
        self.rest.extend(walls.triangles.iter().map(|triangle| triangle.map(|node| number[node as usize])));
    }

    /// Adds a slab's own lower face.
    pub(super) fn add_lower(&mut self, face: &Face, nodes: &mut Nodes) {
        let number: Vec<u32> = face.points.iter().map(|point| nodes.at(*point)).collect();
        for (triangle, piece) in &face.triangles {
            let [a, b, c] = triangle.map(|node| number[node as usize]);
            self.sheet(*piece).push([a, c, b]);
        }
    }

    /// Adds the upper face of the slab that has `pieces`.
    pub(super) fn add_upper(&mut self, upper: &Upper, pieces: &[Piece], nodes: &mut Nodes) {
        let by_place: BTreeMap<(usize, [i32; 3]), usize> =
            pieces.iter().enumerate().map(|(index, piece)| ((piece.grain, piece.steps), index)).collect();
        let number: Vec<u32> = upper.face.points.iter().map(|point| nodes.at(upper.moved(point))).collect();
        for (triangle, piece) in &upper.face.triangles {
            let piece = piece.map(|above| by_place[&upper.below(above)]);
            self.sheet(piece).push(triangle.map(|node| number[node as usize]));
        }
    }

    /// The triangles of a piece's caps, or those between them.
    fn sheet(&mut self, piece: Option<usize>) -> &mut Vec<[u32; 3]> {
        match piece {
            Some(piece) => &mut self.caps[piece],
            None => &mut self.rest,
        }
    }

    /// The shells of the pieces and of the mortar, with the volumes in them.
    fn shells(mut self, pieces: &[Piece], aggregates: &[Aggregate], shells: &mut Shells) -> Result<(), MeshError> {
        let is_cut = |piece: &usize| !pieces[*piece].caps.is_empty();
        let outside = (0..pieces.len()).filter(is_cut).map(|piece| {
            // Counter-clockwise from outside the mortar.
            let turned = std::mem::take(&mut self.facets[piece]).into_iter().map(|[a, b, c]| [a, c, b]);
            (Some(piece), turned.collect())
        });
        let parts = parts::parts(outside.chain([(None, std::mem::take(&mut self.rest))]), &shells.points)?;
        let mut own = vec![Vec::new(); pieces.len()];
        let outer: Vec<Vec<u32>> = parts
            .iter()
            .map(|part| {
                let add = |(piece, triangles): (&Option<usize>, &Vec<[u32; 3]>)| {
                    let surface = shells.surface(triangles.clone());
                    piece.iter().for_each(|piece| own[*piece].push(surface));
                    surface
                };
                part.sheets.iter().map(add).collect()
            })
            .collect();
        let mut holes = vec![Vec::new(); parts.len()];
        for (index, piece) in pieces.iter().enumerate() {
            let (solid, whole) = (aggregates[piece.grain].kind != Kind::Void, !is_cut(&index));
            // What is cut off a void has no elements on either side.
            if solid || whole {
                let sheet = if whole { &mut self.facets } else { &mut self.caps };
                own[index].push(shells.surface(std::mem::take(&mut sheet[index])));
                let shell = shells.shell(std::mem::take(&mut own[index]));
                if whole {
                    holes[parts::around(&parts, &piece.centre(), &shells.points)].push(shell);
                }
                if solid {
                    let (centre, grain) = (Some(piece.centre()), Some(piece.grain as u32));
                    shells.volumes.push(Filled { loops: vec![shell], centre, grain });
                }
            }
        }
        for (surfaces, holes) in outer.into_iter().zip(holes) {
            let loops = [vec![shells.shell(surfaces)], holes].concat();
            shells.volumes.push(Filled { loops, centre: None, grain: None });
        }
        Ok(())
    }
}
