//! The nodes of a lattice: the surfaces they are fitted to, their freedom, and the nodes that move with them.
//!
//! Nodes on faces across which a box repeats itself are one with their images, and move with them. While all nodes move they stay
//! where the cut put them ([`Role::Fixed`]). During the repair they slide within the face, along the bodies that they lie on, together
//! with their images: both faces of a pair stay alike, and a move is judged by the cells behind all of them. Nodes on the rim of a
//! body's cap do so, too, without images.

use super::boundary::{Boundary, Hold};
use super::surface::Surface;
use crate::cells::NO_BODY;
use crate::cells::Owners;
use crate::cells::{NodeImages, Sides};
use crate::location::Locator;
use crate::tet::{Incidence, Star, TetMesh, ascending, centroid, directions};
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::parallel;
use meso_concrete::stop;

/// Surfaces that the nodes are fitted to.
pub(super) struct Exact<'a> {
    /// Surfaces of the bodies.
    pub(super) surfaces: &'a [Surface],
    /// Boundary of the specimen.
    pub(super) boundary: &'a Boundary<'a>,
    /// Size of the elements, mm.
    pub(super) size: f64,
}

/// The nodes of a mesh under repair, with all that a move of one is judged by.
pub(super) struct Nodes<'a> {
    pub(super) exact: &'a Exact<'a>,
    pub(super) mesh: &'a mut TetMesh,
    pub(super) incidence: &'a Incidence,
    pub(super) roles: &'a [Role],
    pub(super) pairs: &'a PeriodicPairs,
}

impl Nodes<'_> {
    pub(super) fn role(&self, node: u32) -> Role {
        self.roles[node as usize]
    }

    pub(super) fn position(&self, node: u32) -> Vec3 {
        self.mesh.position(node)
    }

    /// The cells of a node itself.
    pub(super) fn cells(&self, node: u32) -> &[u32] {
        self.incidence.cells(node)
    }

    pub(super) fn surface(&self, body: u32) -> &Surface {
        &self.exact.surfaces[body as usize]
    }

    /// The star of a node, with those of its images.
    pub(super) fn star(&self, node: u32) -> Star {
        let star = |node: u32| Star::of(self.mesh, node, self.cells(node));
        self.pairs.images(node).fold(star(node), |all, (image, shift)| all.with_image(&star(image), &shift))
    }

    /// The cells around a node and its images.
    pub(super) fn cells_around(&self, node: u32) -> impl Iterator<Item = u32> {
        self.pairs.class(node).flat_map(|(node, _)| self.cells(node)).copied()
    }

    /// The owners of the cells of a node itself, ascending.
    pub(super) fn owners(&self, node: u32) -> Vec<u32> {
        ascending(self.cells(node).iter().map(|&cell| self.mesh.owner[cell as usize]))
    }

    /// The nodes of `cells`, ascending.
    pub(super) fn of_cells(&self, cells: &[u32]) -> Vec<u32> {
        ascending(cells.iter().flat_map(|&cell| self.mesh.cell(cell)))
    }

    /// Moves the node and its images.
    pub(super) fn move_to(&mut self, node: u32, to: &Vec3) {
        self.mesh.points[node as usize] = *to;
        for (image, shift) in self.pairs.images(node) {
            let own = self.mesh.position(image);
            let image_position = Vec3::from_fn(|axis, _| if shift[axis] == 0.0 { to[axis] } else { own[axis] });
            self.mesh.points[image as usize] = image_position;
        }
    }
}

/// The periodic images of all nodes.
#[derive(Default)]
pub(super) struct PeriodicPairs {
    images: NodeImages,
    /// Size of the box, mm.
    size: Vec3,
}

impl PeriodicPairs {
    /// Finds the images of the nodes that lie on faces of `domain`, which they fill, across which it `repeats` itself.
    pub(super) fn of(points: &[Vec3], domain: &Aabb, repeats: [bool; 3]) -> Self {
        if repeats == [false; 3] {
            return Self::default();
        }
        Self { images: NodeImages::of(points, repeats, &Sides::of_points(points)), size: domain.size() }
    }

    /// The nodes that have images.
    pub(super) fn nodes(&self) -> impl Iterator<Item = u32> {
        self.images.nodes().filter(|&node| self.images(node).next().is_some())
    }

    /// The images of a node, with the shifts to them, mm.
    pub(super) fn images(&self, node: u32) -> impl Iterator<Item = (u32, Vec3)> {
        let class = self.images.class(node);
        let others = class.into_iter().flat_map(|(class, _)| self.images.at(class)).filter(move |other| *other != node);
        others.filter_map(move |image| {
            let [from, to] = [class?, self.images.class(image)?].map(|(_, along)| along);
            let steps = |axis: usize| f64::from(to >> axis & 1) - f64::from(from >> axis & 1);
            Some((image, Vec3::from_fn(|axis, _| steps(axis) * self.size[axis])))
        })
    }

    /// The node itself, then its images.
    pub(super) fn class(&self, node: u32) -> impl Iterator<Item = (u32, Vec3)> {
        std::iter::once((node, Vec3::zeros())).chain(self.images(node))
    }
}

/// Moves that a node may make.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// None: it lies on a side of a box that has to match the opposite one, or on the rim of a cap.
    Fixed,
    /// Freedom at the end of the fit: slide in the sides across these axes, together with its images.
    Paired([bool; 3]),
    /// Slide along a body it lies on, where a gap was closed between several bodies.
    Contact,
    /// Slide along the surface of this body.
    Surface(u32),
    /// Slide along the specimen's own surface.
    Boundary(Hold),
    /// Move freely: all its tetrahedra are of one body, or of the mortar.
    Free,
}

/// The roles of all nodes.
///
/// Nodes on sides that have to match opposite ones and on rims of caps stay where they are, others on flat sides slide in these.
pub(super) fn roles(mesh: &TetMesh, owners: &Owners, domain: &Aabb, exact: &Exact) -> Vec<Role> {
    let boundary = exact.boundary;
    let on_rim = |node: u32| {
        let body = owners.beside_mortar(node).filter(|_| owners.are_several(node));
        body.is_some_and(|body| exact.surfaces[body as usize].is_cut_at(&mesh.position(node)))
    };
    let role = |node: u32| match boundary.hold(node as usize, on_sides(domain, &mesh.position(node))) {
        Some(hold) if boundary.fixes(hold) || on_rim(node) => Role::Fixed,
        Some(hold) => Role::Boundary(hold),
        None if !owners.are_several(node) => Role::Free,
        None => owners.beside_mortar(node).map_or(Role::Contact, Role::Surface),
    };
    parallel::map(mesh.points.len(), |node| role(node as u32))
}

/// The axes across which `p` lies on a side of `domain`.
fn on_sides(domain: &Aabb, p: &Vec3) -> [bool; 3] {
    [0, 1, 2].map(|i| p[i] <= domain.min[i] || p[i] >= domain.max[i])
}

/// Gives the tetrahedra whose nodes all lie between materials the body of their centroid: no interface moves, but
/// the mortar gets gaps back that were closed, and a body what lies under its faces.
pub(super) fn relabel(mesh: &mut TetMesh, owners: &Owners, locator: &Locator) {
    let between = |node: &u32| owners.are_several(*node);
    let TetMesh { points, cells, owner } = mesh;
    parallel::each_short_mut(owner, |cell, owner| {
        let nodes = &cells[cell];
        if nodes.iter().all(between) {
            stop::point();
            *owner = locator.find(&centroid(*nodes, points)).map_or(NO_BODY, |(found, _)| found as u32);
        }
    });
}

/// Nodes on a surface, free ones that share a tetrahedron with them, and all on faces across which a box repeats itself.
pub(super) fn near_surface(mesh: &TetMesh, roles: &[Role]) -> Vec<bool> {
    let on = |node: u32| match roles[node as usize] {
        Role::Surface(_) | Role::Contact => true,
        Role::Boundary(hold) => hold.outer,
        Role::Fixed | Role::Paired(_) | Role::Free => false,
    };
    let mut active: Vec<bool> = (0..roles.len() as u32).map(on).collect();
    for cell in mesh.cells.iter().filter(|cell| cell.iter().any(|&node| on(node))) {
        let free = cell.iter().filter(|&&node| matches!(roles[node as usize], Role::Free | Role::Boundary(_)));
        free.for_each(|&node| active[node as usize] = true);
    }
    // Fixed nodes are moved at last, together with their images.
    active.iter_mut().zip(roles).filter(|(_, role)| **role == Role::Fixed).for_each(|(active, _)| *active = true);
    active
}

/// Lets nodes that stayed where they are move with their images; those on rims of caps have none.
pub(super) fn release(roles: &mut [Role], mesh: &TetMesh, pairs: &PeriodicPairs, domain: &Aabb, boundary: &Boundary) {
    let axes = |node: u32| on_sides(domain, &mesh.position(node));
    let repeats = |axes: [bool; 3]| (0..3).any(|axis| axes[axis] && boundary.repeats[axis]);
    let fixed = (0..).zip(roles.iter()).filter(|(_, role)| **role == Role::Fixed).map(|(node, _)| node);
    let on_rims: Vec<u32> = fixed.filter(|&node| !repeats(axes(node))).collect();
    for node in pairs.nodes().chain(on_rims) {
        roles[node as usize] = Role::Paired(axes(node));
    }
}

/// The bodies whose cells `node` has, and whether it has cells of several materials.
fn bodies_of(nodes: &Nodes, node: u32) -> (Vec<u32>, bool) {
    let mut owners = nodes.owners(node);
    let several = owners.len() > 1;
    owners.retain(|owner| *owner != NO_BODY);
    (owners, several)
}

/// Whether a node with images, or on the rim of a cap, lies on none of the bodies whose cells it has, were it at `x`.
pub(super) fn paired_is_off(nodes: &Nodes, node: u32, x: &Vec3) -> bool {
    let (bodies, several) = bodies_of(nodes, node);
    let ends = matches!(nodes.role(node), Role::Paired(axes) if nodes.exact.boundary.ends(axes));
    let at_side = ends && !bodies.iter().any(|&body| nodes.surface(body).is_cut_at(x));
    several && !at_side && !bodies.iter().any(|&body| nodes.surface(body).has(x))
}

/// Whether no image of `node` leaves its bodies when this goes from where it is to `position`.
pub(super) fn stays_on(nodes: &Nodes, node: u32, position: &Vec3) -> bool {
    let stays = |(image, shift): (u32, Vec3)| {
        !paired_is_off(nodes, image, &(position + shift)) || paired_is_off(nodes, image, &nodes.position(image))
    };
    nodes.pairs.class(node).all(stays)
}

/// Where `node` is after the part of `step` that its faces allow, and a body that it or an image lies on.
pub(super) fn paired_after(nodes: &Nodes, node: u32, axes: [bool; 3], step: &Vec3) -> Option<Vec3> {
    let x = nodes.position(node);
    let along = nodes.pairs.class(node).find_map(|(image, shift)| {
        let own = bodies_of(nodes, image).0.into_iter().find(|&body| nodes.surface(body).has(&(x + shift)));
        own.map(|body| (nodes.surface(body), shift))
    });
    let position = match along {
        Some((surface, shift)) => surface.along_face_within(&(x + shift), step, axes)? - shift,
        None => x + Vec3::from_fn(|axis, _| if axes[axis] { 0.0 } else { step[axis] }),
    };
    // Neither rounding nor the way there and back take it off the faces.
    let position = Vec3::from_fn(|axis, _| if axes[axis] { x[axis] } else { position[axis] });
    stays_on(nodes, node, &position).then_some(position)
}

/// Positions near the node, in its faces, on the bodies whose cells it has, that leave no image off its own: those nearest to
/// it, and to points so many elements around it.
pub(super) fn paired_positions(nodes: &Nodes, node: u32, axes: [bool; 3], reaches: &[f64]) -> Vec<Vec3> {
    let (x, size) = (nodes.position(node), nodes.exact.size);
    let around = reaches.iter().flat_map(|reach| directions().map(move |direction| direction * *reach * size));
    let within = |step: Vec3| x + Vec3::from_fn(|axis, _| if axes[axis] { 0.0 } else { step[axis] });
    let starts: Vec<Vec3> = std::iter::once(x).chain(around.map(within)).collect();
    let mut positions = Vec::new();
    for body in bodies_of(nodes, node).0 {
        let surface = nodes.surface(body);
        starts.iter().for_each(|start| surface.nearest_within(start, axes, size, |position| positions.push(position)));
    }
    positions.retain(|position| stays_on(nodes, node, position));
    positions
}

/// How many nodes on faces across which the box repeats itself, and on rims of caps, lie off all bodies whose cells they have.
pub(super) fn count_off(mesh: &TetMesh, surfaces: &[Surface], domain: &Aabb, boundary: &Boundary) -> usize {
    if boundary.repeats == [false; 3] && surfaces.iter().all(|surface| !surface.has_caps()) {
        return 0;
    }
    let owners = Owners::of(mesh.by_body());
    let axes = |node: u32| on_sides(domain, &mesh.position(node));
    let counts = |node: u32| owners.are_several(node) && axes(node).contains(&true);
    let is_on = |&(node, body): &(u32, u32)| {
        let (surface, x) = (&surfaces[body as usize], mesh.position(node));
        boundary.ends(axes(node)) && !surface.is_cut_at(&x) || surface.has(&x)
    };
    let at_nodes = owners.bodies(counts);
    at_nodes.chunk_by(|a, b| a.0 == b.0).filter(|bodies| !bodies.iter().any(is_on)).count()
}
