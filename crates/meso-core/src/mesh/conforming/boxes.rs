//! The surfaces in a box that repeats itself or is meshed in slabs: cut grains, their caps on the box's faces and between the
//! slabs, and what mortar has of these.
//!
//! Mortar may be in several parts: a flat grain can cut a corner off the box.

use super::faces::{self, Face, Nodes};
use super::facets::{LONGEST, Triangles, facets};
use super::parts;
use super::pieces::{Piece, pieces};
use super::shells::{Filled, Shells};
use super::slabs::Slabs;
use crate::aggregate::{Aggregate, Kind};
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
        faces.collect::<Result<Vec<Face>, String>>()
    };
    let boxes = slabs.boxes(domain);
    let faces: Vec<Vec<Face>> =
        pieces.par_iter().zip(&boxes).map(lower).collect::<Result<_, String>>().map_err(MeshError::Gmsh)?;
    let of_slab = |slab: usize| {
        // A piece's own facets, its rims cut as the box's faces have them.
        let facets = |piece: &Piece| facets(&piece.points, piece.facets.iter().cloned(), limit);
        let facets: Vec<Triangles> = pieces[slab].par_iter().map(facets).collect::<Result<_, String>>()?;
        let mut nodes = Nodes::default();
        let mut sheets = Sheets::new(&pieces[slab], &facets, &mut nodes);
        for (axis, lower) in faces[slab].iter().enumerate() {
            // Above the last slab the first one comes again.
            let above = if axis == slabs.axis { (slab + 1) % boxes.len() } else { slab };
            let step = i32::from(axis != slabs.axis || above == 0);
            sheets.add_lower(lower, &mut nodes);
            let upper =
                Upper { face: &faces[above][axis], pieces: &pieces[above], axis, place: boxes[slab].max[axis], step };
            sheets.add_upper(&upper, &pieces[slab], &mut nodes);
        }
        let mut shells = Shells { points: nodes.points, ..Shells::default() };
        sheets.shells(&pieces[slab], aggregates, &mut shells).map(|()| shells)
    };
    (0..boxes.len()).into_par_iter().map(of_slab).collect::<Result<_, String>>().map_err(MeshError::Gmsh)
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
    pub(super) fn new(pieces: &[Piece], facets: &[Triangles], nodes: &mut Nodes) -> Self {
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
    pub(super) fn shells(
        mut self,
        pieces: &[Piece],
        aggregates: &[Aggregate],
        shells: &mut Shells,
    ) -> Result<(), String> {
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
