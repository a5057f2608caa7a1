//! Grains as they lie in a box: every image that reaches into it, cut at its periodic faces and between its slabs.
//!
//! Cut points lie on a lattice on which moving them by whole periods is exact, and both sides of a face take them from
//! the same edges in the same direction. So the face that two pieces share is the same, bit for bit.

use super::slabs::Slabs;
use crate::cells::NO_BODY;
use crate::error::MeshError;
use crate::triangulation::snap;
use meso_collision::geometry::Polyhedron;
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::aggregate::Aggregate;
use meso_concrete::parallel;
use meso_concrete::specimen::{Period, Surface};
use std::collections::BTreeMap;

/// Edges shorter than this do not come out of gmsh as they went in, mm.
const SHORTEST_MM: f64 = 1e-6;

/// Finds the index of a body among all that are in the specimen, images included.
pub(super) struct BodyIndex {
    /// By id, and by the periods from the body as it was placed.
    by_steps: BTreeMap<(u32, [i32; 3]), u32>,
}

impl BodyIndex {
    /// The index of `bodies`, which are images of the `placed` ones.
    pub(super) fn new(placed: &[Aggregate], bodies: &[Aggregate], period: &Period) -> Self {
        let corner = |body: &Aggregate| body.body.vertices()[0];
        let home: BTreeMap<u32, Vec3> = placed.iter().map(|body| (body.id, corner(body))).collect();
        let steps = |body: &Aggregate| {
            let shift = corner(body) - home.get(&body.id).copied().unwrap_or_else(|| corner(body));
            period.steps(&shift)
        };
        Self { by_steps: (0..).zip(bodies).map(|(index, body)| ((body.id, steps(body)), index)).collect() }
    }

    /// The image of the body `id` that is `steps` periods from where it was placed.
    pub(super) fn of(&self, id: u32, steps: [i32; 3]) -> u32 {
        self.by_steps.get(&(id, steps)).copied().unwrap_or(NO_BODY)
    }
}

/// The part of a body's image inside the box; a whole body where nothing cuts it.
pub(super) struct Piece {
    /// Index of the body as it was placed.
    pub(super) placed: usize,
    /// Index of the image among all bodies in the specimen.
    pub(super) body: u32,
    /// How many periods the image is away.
    pub(super) steps: [i32; 3],
    pub(super) points: Vec<Vec3>,
    /// The remaining parts of the body's own facets, counter-clockwise from outside.
    pub(super) facets: Vec<Vec<u32>>,
    /// Where faces of the box cut it, counter-clockwise from outside: axis, whether it is the upper face, corners.
    pub(super) caps: Vec<(usize, bool, Vec<u32>)>,
}

impl Piece {
    /// The corners of its caps on the lower or `upper` face across `axis`, counter-clockwise from outside.
    pub(super) fn loops(&self, axis: usize, upper: bool) -> impl Iterator<Item = Vec<Vec3>> {
        let here = self.caps.iter().filter(move |cap| (cap.0, cap.1) == (axis, upper));
        here.map(|cap| cap.2.iter().map(|&corner| self.points[corner as usize]).collect())
    }

    /// A point inside.
    pub(super) fn centre(&self) -> Vec3 {
        self.points.iter().sum::<Vec3>() / self.points.len() as f64
    }
}

/// The bodies to cut, and the planes that cut them.
#[derive(Clone, Copy)]
pub(super) struct Cuts<'a> {
    pub(super) placed: &'a [Aggregate],
    pub(super) bodies: &'a BodyIndex,
    /// How the specimen repeats itself, and its box.
    pub(super) period: &'a Period,
    pub(super) domain: &'a Aabb,
    pub(super) slabs: &'a Slabs,
    /// Size of the elements, mm.
    pub(super) size: f64,
}

/// All pieces of the placed bodies, by slab and body.
///
/// # Errors
/// Where a face, an edge or a corner of the box, or a plane between slabs, grazes a body.
pub(super) fn pieces(cuts: Cuts) -> Result<Vec<Vec<Piece>>, MeshError> {
    let Cuts { placed, bodies, period, domain, slabs, .. } = cuts;
    let open = period.mixed(domain, &Aabb::everywhere());
    let of_body = |index: usize| -> Result<Vec<(usize, Piece)>, MeshError> {
        let aggregate = &placed[index];
        let shifts = period.shifts(&aggregate.body.aabb(), &open);
        let cut = |shift: &Vec3| Shape::new(&aggregate.body).within(&open.moved(&-shift)).map(|shape| (shape, *shift));
        let divided = |(shape, shift): (Shape, Vec3)| {
            let parts = shape.divided(slabs, shift[slabs.axis]);
            parts.into_iter().map(move |(slab, part)| (slab, part.piece(index, shift, period)))
        };
        let pieces = shifts.iter().filter_map(cut).flat_map(divided);
        let named = |piece: Piece| Piece { body: bodies.of(aggregate.id, piece.steps), ..piece };
        pieces.map(|(slab, piece)| Ok((slab, sound(named(piece), aggregate)?))).collect()
    };
    let mut by_slab: Vec<Vec<Piece>> = (0..=slabs.positions.len()).map(|_| Vec::new()).collect();
    for of_body in parallel::try_map(placed.len(), of_body)? {
        of_body.into_iter().for_each(|(slab, piece)| by_slab[slab].push(piece));
    }
    Ok(by_slab)
}

/// The parts of a specimen's surface in `slabs`, and where the planes cut it.
pub(super) fn walls(surface: Surface, slabs: &Slabs, period: &Period) -> Vec<Piece> {
    let polygons = surface.faces.into_iter().map(|face| (face, None)).collect();
    let whole = Shape { points: surface.points, polygons };
    let parts = whole.divided(slabs, 0.0).into_iter();
    parts.map(|(_, part)| part.piece(0, Vec3::zeros(), period)).collect()
}

/// Refuses pieces that have edges without length.
fn sound(piece: Piece, aggregate: &Aggregate) -> Result<Piece, MeshError> {
    let polygons = piece.facets.iter().chain(piece.caps.iter().map(|cap| &cap.2));
    let mut edges = polygons.flat_map(|face| (0..face.len()).map(|k| [face[k], face[(k + 1) % face.len()]]));
    let short = edges.find_map(|ends| {
        let [a, b] = ends.map(|i| piece.points[i as usize]);
        ((b - a).norm() < SHORTEST_MM).then_some(a)
    });
    match short {
        Some(at) => Err(MeshError::Grazed { aggregate: aggregate.id, at: at.into() }),
        None => Ok(piece),
    }
}

/// The kind of a polygon of a cut body: a facet, or the cut at a face of the box.
type Side = Option<(usize, bool)>;

/// A body by its convex polygons; in slabs it may be any.
#[derive(Clone)]
struct Shape {
    points: Vec<Vec3>,
    polygons: Vec<(Vec<u32>, Side)>,
}

impl Shape {
    fn new(body: &Polyhedron) -> Self {
        let polygons = body.faces().map(|face| (face.to_vec(), None)).collect();
        Self { points: body.vertices().to_vec(), polygons }
    }

    /// The part inside `domain`, where there is one.
    fn within(mut self, domain: &Aabb) -> Option<Self> {
        for axis in 0..3 {
            for (upper, position) in [(false, domain.min[axis]), (true, domain.max[axis])] {
                self.cut(axis, position, upper);
                if self.polygons.is_empty() {
                    return None;
                }
            }
        }
        Some(self)
    }

    /// The parts in slabs that are moved back by `shift`. The face that two of them share is cut from the same edges.
    fn divided(self, slabs: &Slabs, shift: f64) -> Vec<(usize, Self)> {
        let (mut parts, mut rest) = (Vec::new(), self);
        for (slab, position) in slabs.positions.iter().enumerate() {
            let mut below = rest.clone();
            below.cut(slabs.axis, position - shift, true);
            rest.cut(slabs.axis, position - shift, false);
            parts.push((slab, below));
        }
        parts.push((slabs.positions.len(), rest));
        parts.retain(|(_, part)| !part.polygons.is_empty());
        parts
    }

    /// Leaves the part below `position` where that is an upper face, above it otherwise.
    fn cut(&mut self, axis: usize, position: f64, upper: bool) {
        let mut new = Cut { axis, position, upper, points: &mut self.points, made: BTreeMap::new() };
        let mut rim = BTreeMap::new();
        self.polygons.retain_mut(|(corners, _)| {
            let (kept, edge) = new.polygon(corners);
            rim.extend(edge);
            *corners = kept;
            !corners.is_empty()
        });
        self.polygons.extend(loops(rim).into_iter().map(|cap| (cap, Some((axis, upper)))));
    }

    /// Moved by `shift`, with the points it uses.
    fn piece(self, placed: usize, shift: Vec3, period: &Period) -> Piece {
        let mut number = BTreeMap::new();
        let mut piece = Piece {
            placed,
            body: NO_BODY,
            steps: period.steps(&shift),
            points: Vec::new(),
            facets: Vec::new(),
            caps: Vec::new(),
        };
        for (corners, side) in self.polygons {
            let mut renumbered = |corner: u32| {
                *number.entry(corner).or_insert_with(|| {
                    piece.points.push(self.points[corner as usize] + shift);
                    piece.points.len() as u32 - 1
                })
            };
            let corners: Vec<u32> = corners.into_iter().map(&mut renumbered).collect();
            match side {
                None => piece.facets.push(corners),
                Some((axis, upper)) => piece.caps.push((axis, upper, corners)),
            }
        }
        piece
    }
}

/// The loops that `edges` make, from node to node: of a convex body one.
fn loops(mut edges: BTreeMap<u32, u32>) -> Vec<Vec<u32>> {
    let mut loops = Vec::new();
    while let Some((first, next)) = edges.pop_first() {
        let (mut nodes, mut at) = (vec![first], Some(next));
        while let Some(node) = at.filter(|node| *node != first) {
            nodes.push(node);
            at = edges.remove(&node);
        }
        loops.push(nodes);
    }
    loops
}

/// A body's points while a plane cuts it.
struct Cut<'a> {
    axis: usize,
    position: f64,
    upper: bool,
    points: &'a mut Vec<Vec3>,
    /// The new point of every edge that is cut, by its end below.
    made: BTreeMap<(u32, u32), u32>,
}

impl Cut<'_> {
    fn above(&self, point: u32) -> bool {
        self.points[point as usize][self.axis] >= self.position
    }

    /// The rest of a polygon, and the edge along which the plane cuts it, in the cap's direction.
    fn polygon(&mut self, corners: &[u32]) -> (Vec<u32>, Option<(u32, u32)>) {
        let (mut kept, mut out, mut back) = (Vec::with_capacity(corners.len() + 1), None, None);
        for (k, &corner) in corners.iter().enumerate() {
            let next = corners[(k + 1) % corners.len()];
            let [here, there] = [corner, next].map(|point| self.above(point) != self.upper);
            if here {
                kept.push(corner);
            }
            if here != there {
                let point = self.point(corner, next);
                kept.push(point);
                *(if here { &mut out } else { &mut back }) = Some(point);
            }
        }
        (kept, back.zip(out))
    }

    /// Where the plane cuts an edge; every edge is passed in both directions, and upwards counts.
    fn point(&mut self, a: u32, b: u32) -> u32 {
        let (low, high) = if self.above(a) { (b, a) } else { (a, b) };
        if let Some(&made) = self.made.get(&(low, high)) {
            return made;
        }
        let [from, to] = [low, high].map(|point| self.points[point as usize]);
        let share = (self.position - from[self.axis]) / (to[self.axis] - from[self.axis]);
        let mut point = snap(from + (to - from) * share);
        point[self.axis] = self.position;
        self.points.push(point);
        let number = self.points.len() as u32 - 1;
        self.made.insert((low, high), number);
        number
    }
}
