//! Nodes on faces across which a box repeats itself: they are one with their images, and move with them.
//!
//! While all nodes move they stay where the cut put them ([`Role::Fixed`]). At the end of the fit they slide within the face,
//! along the grains that they lie on, together with their images: both faces of a pair stay alike, and a move is judged by the
//! cells behind all of them.

use super::Tetrahedra;
use super::fit::Fit;
use super::mend::ways;
use super::roles::Role;
use super::skin::Skin;
use super::surface::Surface;
use crate::math::{Aabb, Vec3};
use crate::mesh::NO_AGGREGATE;

/// Images are this close to where they should be, in sizes of the box.
const SLACK: f64 = 1e-9;
/// Along this way, to which no face or lattice line is square, few nodes are as far as another.
const ALONG: Vec3 = Vec3::new(1.0, 1.414, 1.731);

/// The images of all nodes.
#[derive(Default)]
pub(super) struct Twins {
    /// A node, an image of it, and the way from the one to the other; by node.
    pairs: Vec<(u32, u32, Vec3)>,
}

impl Twins {
    /// Those of the nodes that lie on faces of `domain` across which it `repeats` itself.
    pub(super) fn of(points: &[Vec3], domain: &Aabb, repeats: [bool; 3]) -> Self {
        let slack = SLACK * domain.size().max();
        let upper = |p: &Vec3| [0, 1, 2].map(|axis| repeats[axis] && p[axis] >= domain.max[axis]);
        let lower = |p: &Vec3| [0, 1, 2].map(|axis| repeats[axis] && p[axis] <= domain.min[axis]);
        // Where a node's image on no upper face is.
        let home = |p: &Vec3| {
            let upper = upper(p);
            Vec3::from_fn(|axis, _| if upper[axis] { domain.min[axis] } else { p[axis] })
        };
        let on_face = (0..).zip(points).filter(|(_, p)| lower(p).contains(&true) || upper(p).contains(&true));
        let mut nodes: Vec<(f64, Vec3, u32)> = on_face.map(|(node, p)| (home(p).dot(&ALONG), home(p), node)).collect();
        nodes.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
        let mut pairs = Vec::new();
        for (at, (along, place, node)) in nodes.iter().enumerate() {
            let near = nodes[at + 1..].iter().take_while(|(other, ..)| *other <= along + slack * ALONG.sum());
            for (.., other) in near.filter(|(_, other, _)| (other - place).amax() <= slack) {
                let way = |from: u32, to: u32| {
                    let (from, to) = (upper(&points[from as usize]), upper(&points[to as usize]));
                    let steps = |axis: usize| f64::from(u8::from(to[axis])) - f64::from(u8::from(from[axis]));
                    Vec3::from_fn(|axis, _| steps(axis) * domain.size()[axis])
                };
                pairs.push((*node, *other, way(*node, *other)));
                pairs.push((*other, *node, way(*other, *node)));
            }
        }
        pairs.sort_by_key(|pair| (pair.0, pair.1));
        Self { pairs }
    }

    /// The images of a node, with the ways to them, mm.
    pub(super) fn images(&self, node: u32) -> impl Iterator<Item = (u32, Vec3)> {
        let start = self.pairs.partition_point(|pair| pair.0 < node);
        self.pairs[start..].iter().take_while(move |pair| pair.0 == node).map(|pair| (pair.1, pair.2))
    }

    /// The node itself, then its images.
    pub(super) fn class(&self, node: u32) -> impl Iterator<Item = (u32, Vec3)> {
        std::iter::once((node, Vec3::zeros())).chain(self.images(node))
    }
}

/// Lets nodes that stayed where they are, and have images, move with these.
pub(super) fn let_go(roles: &mut [Role], mesh: &Tetrahedra, twins: &Twins, domain: &Aabb) {
    for &(node, ..) in &twins.pairs {
        let p = &mesh.points[node as usize];
        roles[node as usize] = Role::Twin([0, 1, 2].map(|i| p[i] <= domain.min[i] || p[i] >= domain.max[i]));
    }
}

/// The grains whose cells `node` has, and whether it has cells of several materials.
fn grains(fit: &Fit, node: u32) -> (Vec<u32>, bool) {
    let mut labels: Vec<u32> = fit.stars.cells(node).iter().map(|&cell| fit.mesh.grain[cell as usize]).collect();
    labels.sort_unstable();
    labels.dedup();
    let several = labels.len() > 1;
    labels.retain(|label| *label != NO_AGGREGATE);
    (labels, several)
}

/// Whether a node with images lies on none of the grains whose cells it has, were it at `x`.
pub(super) fn is_off(fit: &Fit, node: u32, x: &Vec3) -> bool {
    let (grains, several) = grains(fit, node);
    let at_side = matches!(fit.roles[node as usize], Role::Twin(axes) if fit.skin.ends(axes));
    several && !at_side && !grains.iter().any(|&grain| fit.surfaces[grain as usize].has(x))
}

/// Whether no image of `node` leaves its grains when this goes from where it is to `place`.
pub(super) fn keep(fit: &Fit, node: u32, place: &Vec3) -> bool {
    let stays =
        |(image, way): (u32, Vec3)| !is_off(fit, image, &(place + way)) || is_off(fit, image, &fit.places.get(image));
    fit.twins.class(node).all(stays)
}

/// Where `node` is after the part of `step` that its faces allow, and a grain that it or an image lies on.
pub(super) fn after(fit: &Fit, node: u32, axes: [bool; 3], step: &Vec3) -> Option<Vec3> {
    let x = fit.places.get(node);
    let along = fit.twins.class(node).find_map(|(image, way)| {
        let surface = |grain: u32| &fit.surfaces[grain as usize];
        let own = grains(fit, image).0.into_iter().find(|&grain| surface(grain).has(&(x + way)));
        own.map(|grain| (surface(grain), way))
    });
    let place = match along {
        Some((surface, way)) => surface.along_face_within(&(x + way), step, axes)? - way,
        None => x + Vec3::from_fn(|axis, _| if axes[axis] { 0.0 } else { step[axis] }),
    };
    // Neither rounding nor the way there and back take it off the faces.
    let place = Vec3::from_fn(|axis, _| if axes[axis] { x[axis] } else { place[axis] });
    keep(fit, node, &place).then_some(place)
}

/// Places near the node, in its faces, on the grains whose cells it has, that leave no image off its own: those nearest to it,
/// and to points so many elements around it.
pub(super) fn places(fit: &Fit, node: u32, axes: [bool; 3], reaches: &[f64]) -> Vec<Vec3> {
    let x = fit.places.get(node);
    let around = reaches.iter().flat_map(|reach| ways().map(move |way| way * *reach * fit.size));
    let within = |step: Vec3| x + Vec3::from_fn(|axis, _| if axes[axis] { 0.0 } else { step[axis] });
    let starts: Vec<Vec3> = std::iter::once(x).chain(around.map(within)).collect();
    let mut places = Vec::new();
    for grain in grains(fit, node).0 {
        let surface = &fit.surfaces[grain as usize];
        starts.iter().for_each(|start| surface.places_within(start, axes, fit.size, |place| places.push(place)));
    }
    places.retain(|place| keep(fit, node, place));
    places
}

/// How many nodes on faces across which the box repeats itself lie off all grains whose cells they have.
pub(super) fn count_off(mesh: &Tetrahedra, surfaces: &[Surface], domain: &Aabb, skin: &Skin) -> usize {
    if skin.repeats == [false; 3] {
        return 0;
    }
    let axes = |p: &Vec3| [0, 1, 2].map(|i| p[i] <= domain.min[i] || p[i] >= domain.max[i]);
    let counts = |p: &Vec3| axes(p).contains(&true) && !skin.ends(axes(p));
    let mut owned: Vec<(u32, u32)> = Vec::new();
    for (cell, &grain) in mesh.cells.iter().zip(&mesh.grain) {
        owned.extend(cell.iter().filter(|&&node| counts(&mesh.points[node as usize])).map(|&node| (node, grain)));
    }
    owned.sort_unstable();
    owned.dedup();
    let is_off = |around: &&[(u32, u32)]| {
        let on = |&(node, grain): &(u32, u32)| {
            grain != NO_AGGREGATE && surfaces[grain as usize].has(&mesh.points[node as usize])
        };
        around.len() > 1 && !around.iter().any(on)
    };
    owned.chunk_by(|a, b| a.0 == b.0).filter(is_off).count()
}
