//! The inner ends of a lattice's rails: on the offsets of the mesh's own triangles.
//!
//! A lattice has no nodes along most edges of a body, so that its triangles cut across them. The offsets of the body's own faces
//! would make such a prism too thin, by the cosine of half the angle between the faces. Therefore a node goes to the point whose
//! distances to the planes of all triangles around it are the thickness: least squares, weighted by area. Every prism then has the
//! thickness asked for, whatever the body's shape, and where a gap is closed, too.
//!
//! Chords make the surface smaller than the body's, and the layers with it. So all displacements are scaled until the layers have
//! their exact volume ([`scale`]). Bodies with dents have no rays along which their inner nodes make room: these follow their
//! neighbours ([`relax`]). Layers that are thick beside an element are put in order along the offset first ([`settle`]).

use super::offset::{RadialOffset, RadialOffsets};
use super::periodic::PeriodicConstraint;
use super::prisms::LayerCell;
use crate::cells::{Copies, InterfaceFace};
use crate::tet::{TetMesh, volume};
use meso_collision::math::{Mat3, Vec3};
use meso_concrete::parallel;
use meso_concrete::stop;

/// Moves the targets of the copies of interface nodes onto the offsets of the `faces` around them.
pub(super) fn project(
    mesh: &TetMesh,
    faces: &[InterfaceFace],
    copies: &Copies,
    offsets: &RadialOffsets,
    constraint: &PeriodicConstraint,
    targets: &mut [Vec3],
) {
    let stars = stars(mesh, faces, copies, constraint);
    let leads = copies.iter().filter(|(.., copy)| constraint.leads(*copy) && !constraint.is_pinned(*copy));
    for (body, _, copy) in leads {
        stop::point();
        let radial = offsets.get(body, constraint.flat(copy));
        let star = &stars[(copy - copies.first()) as usize];
        let displaced = radial.and_then(|radial| Some((radial, star.displacement(radial.thickness)?)));
        if let Some((radial, displacement)) = displaced {
            let x = mesh.position(copy);
            // Few triangles meet a cap, and those between nodes in it and close to it are steep.
            targets[copy as usize] = radial.along_cap(&x, x + displacement, constraint.flat(copy));
        }
    }
    constraint.spread(targets);
}

/// Damps a step where the triangles hardly decide on it, as a share of their area: a sliver that would vanish in the offset does
/// not pull its nodes across each other.
const DAMPING: f64 = 0.05;
/// Steps, each of which leaves a twentieth of the error on plane triangles, and a third at edges of 40 degrees.
const STEPS: usize = 4;

/// The triangles around a node, by their unit normals n and their doubled areas w.
#[derive(Clone, Default)]
struct TriangleStar {
    /// Sum of w n n'.
    squares: Mat3,
    /// Sum of w n.
    normals: Vec3,
}

impl TriangleStar {
    /// The displacement to the offsets of all triangles by `thickness` mm; `None` without triangles.
    fn displacement(&self, thickness: f64) -> Option<Vec3> {
        let damped = self.squares + Mat3::identity() * (DAMPING * self.squares.trace());
        let inverse = damped.try_inverse()?;
        let closer = |u: Vec3, _| u - inverse * (self.normals * thickness + self.squares * u);
        Some((0..STEPS).fold(Vec3::zeros(), closer))
    }
}

/// The triangles around every copy, its images' among them at the one that leads.
fn stars(
    mesh: &TetMesh,
    faces: &[InterfaceFace],
    copies: &Copies,
    constraint: &PeriodicConstraint,
) -> Vec<TriangleStar> {
    let mut stars = vec![TriangleStar::default(); copies.iter().len()];
    for face in faces {
        let nodes = [0, 1, 2].map(|i| face.nodes[i]);
        let [a, b, c] = nodes.map(|node| mesh.position(node));
        let normal = (b - a).cross(&(c - a));
        for node in nodes {
            let copy = constraint.lead(copies.of(mesh.owner[face.cell as usize], node));
            let slope = constraint.flat(copy).along(&normal);
            let star = &mut stars[(copy - copies.first()) as usize];
            star.squares += slope * (slope / normal.norm()).transpose();
            star.normals += slope;
        }
    }
    stars
}

/// Layers above this share of an element settle. Thinner ones have smaller errors without: 2.0 % at half an element, and 2.3 %
/// at two thirds, where they would have 3.7 and 3.6 % (a scanned stone); random stones have 11 % at two thirds without.
pub(super) const THICK: f64 = 0.6;
/// Rounds of [`settle`] over the square of the thickness in elements, since displacements spread by an element a round.
const ROUNDS: f64 = 4.0;
/// Steps to the depth in a round: along an edge of the offset each one goes to one of its faces.
const DEPTH_STEPS: usize = 6;

/// Moves the targets of thick layers along the offset until they are in order; `reach` is the thickest one's, in elements.
///
/// Below an edge the offsets of single nodes cross each other as far as the layer is thick, so that nearly all nodes of a
/// layer as thick as an element would stop short. Each node takes the mean displacement of the triangles around it, and
/// steps to the depth of the layer below the body's own surface.
pub(super) fn settle(
    mesh: &TetMesh,
    faces: &[InterfaceFace],
    copies: &Copies,
    offsets: &RadialOffsets,
    constraint: &PeriodicConstraint,
    reach: f64,
    targets: &mut [Vec3],
) {
    let offset_of = |body: u32, copy: u32| offsets.get(body, constraint.flat(copy)).filter(|offset| offset.settles);
    let leads = copies.iter().filter(|(.., copy)| constraint.leads(*copy) && !constraint.is_pinned(*copy));
    let settling: Vec<_> = leads.filter_map(|(body, _, copy)| Some((copy, offset_of(body, copy)?))).collect();
    let of_copies = |face: &InterfaceFace| [0, 1, 2].map(|i| copies.of(mesh.owner[face.cell as usize], face.nodes[i]));
    for _ in 0..(ROUNDS * reach * reach).ceil() as usize {
        let sums = sums_around(mesh, faces.iter().map(of_copies), |_| true, constraint, targets);
        let settled = |&(copy, offset): &(u32, &RadialOffset)| {
            stop::point();
            let ((sum, count), flat) = (sums[copy as usize], constraint.flat(copy));
            let mean = mesh.position(copy) + flat.along(&(sum / count));
            (0..DEPTH_STEPS).fold(mean, |x, _| x + flat.along(&offset.step_to_depth(&x)))
        };
        let moved = parallel::map_each(&settling, settled);
        settling.iter().zip(moved).for_each(|((copy, _), x)| targets[*copy as usize] = x);
        constraint.spread(targets);
    }
}

/// For every node that leads, the displacements of the corners of the `cells` around it and its images, summed up, and their
/// number; nodes that do not `count` take no part. Nothing without cells.
fn sums_around<const N: usize>(
    mesh: &TetMesh,
    cells: impl ExactSizeIterator<Item = [u32; N]>,
    count: impl Fn(u32) -> bool,
    constraint: &PeriodicConstraint,
    targets: &[Vec3],
) -> Vec<(Vec3, f64)> {
    let mut sums = vec![(Vec3::zeros(), 0.0); if cells.len() > 0 { targets.len() } else { 0 }];
    for cell in cells {
        let sum: Vec3 = cell.iter().map(|&node| targets[node as usize] - mesh.position(node)).sum();
        for &node in cell.iter().filter(|node| count(**node)) {
            let around = &mut sums[constraint.lead(node) as usize];
            *around = (around.0 + sum, around.1 + N as f64);
        }
    }
    sums
}

/// The largest change of a displacement for the sake of the volume.
const MOST: f64 = 0.1;

/// Scales the displacements of the copies, the nodes from `first` on, until the prisms of `layer` have `exact` mm3.
pub(super) fn scale(mesh: &TetMesh, layer: &[LayerCell], first: u32, exact: f64, targets: &mut [Vec3]) {
    let volumes = parallel::map_each(layer, |cell| volume(cell.nodes.map(|node| targets[node as usize])));
    let share = (exact / volumes.into_iter().sum::<f64>()).clamp(1.0 - MOST, 1.0 + MOST);
    let copies = mesh.points[first as usize..].iter();
    targets[first as usize..]
        .iter_mut()
        .zip(copies)
        .for_each(|(target, from)| *target = from + (*target - from) * share);
}

/// Sweeps of [`relax`]: a displacement goes as many elements deep.
const SWEEPS: f64 = 10.0;
/// Sweeps over the square of the thickness of layers that settle, in elements.
const DEEP_SWEEPS: f64 = 40.0;

/// Gives nodes within bodies with dents or with layers that settle, below `first`, the mean displacement of the cells around them;
/// `reach` is the thickest of these layers, in elements.
pub(super) fn relax(
    mesh: &TetMesh,
    owner: &[u32],
    first: u32,
    offsets: &RadialOffsets,
    constraint: &PeriodicConstraint,
    reach: f64,
    targets: &mut [Vec3],
) {
    let follows = |node: u32| {
        let radial = offsets.get(owner[node as usize], constraint.flat(node));
        node < first && !constraint.is_pinned(node) && radial.is_some_and(|radial| !radial.has_rays || radial.settles)
    };
    let follows = parallel::map_short(first as usize, |node| follows(node as u32));
    let is_free = |node: u32| follows.get(node as usize) == Some(&true);
    let cells = parallel::pick(&mesh.cells, |cell| cell.iter().any(|&node| is_free(node)));
    for _ in 0..(DEEP_SWEEPS * reach * reach).max(SWEEPS).ceil() as usize {
        let sums = sums_around(mesh, cells.iter().copied(), is_free, constraint, targets);
        for (node, (sum, count)) in (0..).zip(sums).filter(|(_, (_, count))| *count > 0.0) {
            targets[node as usize] = mesh.position(node) + constraint.flat(node).along(&(sum / count));
        }
        constraint.spread(targets);
    }
}
