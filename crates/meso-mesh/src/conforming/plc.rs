//! The input of gmsh: the piecewise linear complex of one slab.
//!
//! The facets of clipped bodies, their caps and the mortar's part of the sides meet at common nodes. They form surfaces that
//! share the nodes of their rims, closed shells of these surfaces, and the volumes between the shells. The mortar may have
//! several parts: a flat body can cut a corner off a box.

use super::clipped::Piece;
use crate::cells::NO_BODY;
use crate::disjoint::{find, join};
use crate::error::MeshError;
use crate::triangulation::{Nodes, Triangles, Untriangulated, facets};
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::aggregate::{Aggregate, Kind};
use meso_concrete::parallel;
use std::collections::BTreeMap;

/// The shells of `pieces` and of the sides that `add` puts around them; edges are at most `limit` mm long.
///
/// # Errors
/// Names a face that cannot be cut into triangles, or a surface that does not close.
pub(super) fn shells(
    pieces: &[Piece],
    aggregates: &[Aggregate],
    limit: f64,
    add: impl FnOnce(&mut Sheets, &mut Nodes),
) -> Result<Shells, MeshError> {
    let surfaces: Vec<Triangles> = parallel::try_map(pieces.len(), |piece| surface(&pieces[piece], limit))?;
    let mut nodes = Nodes::default();
    let mut sheets = Sheets::new(pieces, &surfaces, &mut nodes);
    add(&mut sheets, &mut nodes);
    let mut shells = Shells { points: nodes.points, ..Shells::default() };
    sheets.shells(pieces, aggregates, &mut shells).map(|()| shells)
}

/// A face of a box, or a plane between slabs: its triangles counter-clockwise seen from above, each with the piece whose cap it is part of.
pub(super) struct Face {
    pub(super) points: Vec<Vec3>,
    pub(super) triangles: Vec<([u32; 3], Option<usize>)>,
}

/// A piece's own facets in triangles, its rims cut as the faces on the other side have them.
pub(super) fn surface(piece: &Piece, limit: f64) -> Result<Triangles, Untriangulated> {
    facets(&piece.points, piece.facets.iter().cloned(), limit)
}

/// The upper face of a slab: the lower one of the piece above it, moved.
pub(super) struct Upper<'a> {
    pub(super) face: &'a Face,
    /// The pieces above it.
    pub(super) pieces: &'a [Piece],
    pub(super) axis: usize,
    pub(super) position: f64,
    /// Periods between the two.
    pub(super) step: i32,
}

impl Upper<'_> {
    fn moved(&self, point: &Vec3) -> Vec3 {
        Vec3::from_fn(|i, _| if i == self.axis { self.position } else { point[i] })
    }

    /// Body and image of the piece below the piece `above`.
    fn below(&self, above: usize) -> (usize, [i32; 3]) {
        let mut steps = self.pieces[above].steps;
        steps[self.axis] += self.step;
        (self.pieces[above].placed, steps)
    }
}

/// The triangles on common nodes.
pub(super) struct Sheets {
    /// The caps of every piece.
    facets: Vec<Vec<[u32; 3]>>,
    caps: Vec<Vec<[u32; 3]>>,
    /// The mortar of the box's faces, between the caps.
    rest: Vec<[u32; 3]>,
}

impl Sheets {
    fn new(pieces: &[Piece], facets: &[Triangles], nodes: &mut Nodes) -> Self {
        let facets = facets.iter().map(|surface| nodes.triangles(surface)).collect();
        Self { facets, caps: vec![Vec::new(); pieces.len()], rest: Vec::new() }
    }

    /// Adds the part of the specimen's own surface that bounds mortar.
    pub(super) fn add_walls(&mut self, walls: &Triangles, nodes: &mut Nodes) {
        self.rest.extend(nodes.triangles(walls));
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
        let by_image: BTreeMap<(usize, [i32; 3]), usize> =
            pieces.iter().enumerate().map(|(index, piece)| ((piece.placed, piece.steps), index)).collect();
        let number: Vec<u32> = upper.face.points.iter().map(|point| nodes.at(upper.moved(point))).collect();
        for (triangle, piece) in &upper.face.triangles {
            let piece = piece.map(|above| by_image[&upper.below(above)]);
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
        let parts = parts(outside.chain([(None, std::mem::take(&mut self.rest))]), &shells.points)?;
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
            let (solid, whole) = (aggregates[piece.placed].kind != Kind::Void, !is_cut(&index));
            // The cap of a void has no elements on either side.
            if solid || whole {
                let sheet = if whole { &mut self.facets } else { &mut self.caps };
                own[index].push(shells.surface(std::mem::take(&mut sheet[index])));
                let shell = shells.shell(std::mem::take(&mut own[index]));
                if whole {
                    holes[around(&parts, &piece.centre(), &shells.points)].push(shell);
                }
                if solid {
                    let centre = Some(piece.centre());
                    shells.volumes.push(Filled { loops: vec![shell], centre, owner: piece.body });
                }
            }
        }
        for (surfaces, holes) in outer.into_iter().zip(holes) {
            let loops = [vec![shells.shell(surfaces)], holes].concat();
            shells.volumes.push(Filled { loops, centre: None, owner: NO_BODY });
        }
        Ok(())
    }
}

/// Surfaces and the volumes between them; all indices count from 0.
#[derive(Default)]
pub(super) struct Shells {
    pub(super) points: Vec<Vec3>,
    /// Triangles by surface; surfaces share the nodes of their rims.
    pub(super) surfaces: Vec<Vec<[u32; 3]>>,
    /// Closed shells by their surfaces.
    pub(super) loops: Vec<Vec<u32>>,
    pub(super) volumes: Vec<Filled>,
}

/// A volume that gmsh fills.
pub(super) struct Filled {
    /// The outer shell first, then those of holes.
    pub(super) loops: Vec<u32>,
    /// Where gmsh is to put a node.
    pub(super) centre: Option<Vec3>,
    /// Index of the body, [`NO_BODY`] in the mortar.
    pub(super) owner: u32,
}

impl Shells {
    /// Adds a closed surface with nodes of its own; its shell.
    pub(super) fn closed(&mut self, surface: &Triangles) -> u32 {
        let first = self.points.len() as u32;
        self.points.extend(&surface.points);
        let triangles = surface.triangles.iter().map(|triangle| triangle.map(|node| first + node)).collect();
        let surface = self.surface(triangles);
        self.shell(vec![surface])
    }

    /// Adds a surface; its index.
    pub(super) fn surface(&mut self, triangles: Vec<[u32; 3]>) -> u32 {
        self.surfaces.push(triangles);
        self.surfaces.len() as u32 - 1
    }

    /// Adds a shell of `surfaces`; its index.
    pub(super) fn shell(&mut self, surfaces: Vec<u32>) -> u32 {
        self.loops.push(surfaces);
        self.loops.len() as u32 - 1
    }

    /// The nodes that each surface is the first to have, ascending.
    pub(super) fn own_nodes(&self) -> Vec<Vec<u32>> {
        let mut owner = vec![None; self.points.len()];
        for (surface, triangles) in self.surfaces.iter().enumerate() {
            triangles.as_flattened().iter().for_each(|&node| {
                owner[node as usize].get_or_insert(surface);
            });
        }
        let mut own = vec![Vec::new(); self.surfaces.len()];
        // The cap of a void has no surface at the box's faces, and its nodes there have none.
        (0..)
            .zip(owner)
            .filter_map(|(node, owner)| Some((node, owner?)))
            .for_each(|(node, owner)| own[owner].push(node));
        own
    }
}

/// A closed surface.
#[derive(Default)]
struct Part {
    /// Its triangles by the surface that they belong to.
    sheets: BTreeMap<Option<usize>, Vec<[u32; 3]>>,
}

/// The parts of the surface that `sheets` make, their triangles counter-clockwise from outside or all from inside; the one
/// with the most triangles first.
///
/// # Errors
/// Says where the surface is open.
fn parts(
    sheets: impl Iterator<Item = (Option<usize>, Vec<[u32; 3]>)>,
    points: &[Vec3],
) -> Result<Vec<Part>, Untriangulated> {
    let of_sheet = |(sheet, triangles): (Option<usize>, Vec<[u32; 3]>)| triangles.into_iter().map(move |t| (sheet, t));
    let triangles: Vec<(Option<usize>, [u32; 3])> = sheets.flat_map(of_sheet).collect();
    let mut sides: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * triangles.len());
    for (index, (_, [a, b, c])) in (0..).zip(&triangles) {
        sides.extend([[a, b], [b, c], [c, a]].map(|[a, b]| ([*a.min(b), *a.max(b)], index)));
    }
    sides.sort_unstable();
    let mut root: Vec<u32> = (0..triangles.len() as u32).collect();
    for pair in sides.chunk_by(|a, b| a.0 == b.0) {
        let [(_, a), (_, b)] = *pair else {
            return Err(Untriangulated::new("the surface for gmsh is open", &points[pair[0].0[0] as usize]));
        };
        join(&mut root, a, b);
    }
    let mut parts: BTreeMap<u32, Part> = BTreeMap::new();
    for (index, (sheet, triangle)) in (0..).zip(triangles) {
        let part = parts.entry(find(&mut root, index)).or_default();
        part.sheets.entry(sheet).or_default().push(triangle);
    }
    let mut parts: Vec<Part> = parts.into_values().collect();
    parts.sort_by_key(|part| std::cmp::Reverse(part.triangles().count()));
    Ok(parts)
}

/// The index of the part around `position`, which lies in one: the first where no other holds it.
fn around(parts: &[Part], position: &Vec3, points: &[Vec3]) -> usize {
    let holds = |part: &Part| part.winding(position, points) > 0.5;
    (1..parts.len()).find(|&index| holds(&parts[index])).unwrap_or(0)
}

impl Part {
    fn triangles(&self) -> impl Iterator<Item = &[u32; 3]> {
        self.sheets.values().flatten()
    }

    /// How often the surface goes around `position`: its solid angle over that of a sphere (van Oosterom and Strackee 1983).
    fn winding(&self, position: &Vec3, points: &[Vec3]) -> f64 {
        let aabb = Aabb::around(self.triangles().flatten().map(|&node| &points[node as usize]));
        if !aabb.intersects(&Aabb { min: *position, max: *position }) {
            return 0.0;
        }
        let angle = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|node| points[node as usize] - position);
            let [x, y, z] = [a.norm(), b.norm(), c.norm()];
            2.0 * libm::atan2(a.dot(&b.cross(&c)), x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y)
        };
        self.triangles().map(angle).sum::<f64>().abs() / (4.0 * std::f64::consts::PI)
    }
}
