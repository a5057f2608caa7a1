//! After the cut: interface nodes slide along their grain onto its edges and corners, where that brings back volume.
//!
//! The triangles between nodes on a convex surface lie inside it, so the cut loses what lies over them, most at edges
//! and corners ([`slide`]); nodes with sharp angles move to better them ([`smooth`]), and what is still too sharp after
//! some rounds of both is looked at by itself ([`finish`](super::finish)). Nodes go in patches, eight colours of them, such that patches
//! of one colour share no tetrahedron: the result does not depend on the number of threads.

use super::balance::lacks;
use super::finish::{Finish, finish};
use super::places::Places;
use super::roles::{Role, near_surface, relabel, roles};
use super::skin::Skin;
use super::star::{Star, Stars, sharpness};
use super::surface::Surface;
use super::twins::{self, Twins};
use super::{Tetrahedra, slide, smooth};
use crate::math::{Aabb, Vec3};
use crate::mesh::grains::Locator;
use crate::stop;
use rayon::prelude::*;

/// The smallest dihedral angle a move may leave, degrees.
pub(super) const GUARD_DEG: f64 = 10.0;
/// Rounds of sliding and smoothing.
const ROUNDS: usize = 5;
/// Cells that lie between interface nodes alone get the grain of their centroid before these rounds.
const RELABELLED: [usize; 2] = [2, 4];
/// Edge of a patch, in elements; more than twice the longest edge of a tetrahedron, so that colours stay apart.
const PATCH: f64 = 6.0;

/// All that a move of a node is judged by.
pub(super) struct Fit<'a> {
    pub(super) mesh: &'a Tetrahedra,
    pub(super) surfaces: &'a [Surface],
    pub(super) stars: &'a Stars,
    pub(super) places: &'a Places,
    pub(super) roles: &'a [Role],
    /// Images of nodes that move with them.
    pub(super) twins: &'a Twins,
    /// What every grain lacks of its volume, -1 to 1.
    pub(super) lacks: &'a [f64],
    /// Of the elements, mm.
    pub(super) size: f64,
    pub(super) skin: &'a Skin<'a>,
}

/// Fits `mesh`, with elements of about `size` mm, to the surfaces; returns how many nodes that belong on a surface lie off it.
pub(super) fn fit(
    mesh: &mut Tetrahedra,
    surfaces: &[Surface],
    locator: &Locator,
    domain: &Aabb,
    size: f64,
    skin: &Skin,
) -> usize {
    let mut roles_now = roles(mesh, domain, skin);
    let active = near_surface(mesh, &roles_now);
    let mut stars = Stars::new(&mesh.cells, &active);
    let colours = patches(mesh, &active, domain, size * PATCH);
    let places = Places::new(&mesh.points);
    for round in 0..ROUNDS {
        if RELABELLED.contains(&round) {
            relabel(mesh, &places, locator);
            let before = std::mem::replace(&mut roles_now, roles(mesh, domain, skin));
            let changed = (0..).zip(roles_now.iter().zip(&before)).filter(|(_, (now, before))| now != before);
            changed.for_each(|(node, _)| places.wake(node));
        }
        let lacks = lacks(mesh, &places, surfaces);
        let (stars, roles, twins, lacks) = (&stars, &roles_now, &Twins::default(), &lacks);
        let fit = Fit { mesh, surfaces, stars, places: &places, roles, twins, lacks, size, skin };
        for patches in &colours {
            patches.par_iter().for_each(|nodes| nodes.iter().for_each(|&node| fit.slide(node)));
        }
        for patches in &colours {
            patches.par_iter().for_each(|nodes| nodes.iter().for_each(|&node| fit.smooth(node, round)));
        }
    }
    let (stars, roles, twins) = (&mut stars, &mut roles_now, Twins::of(&mesh.points, domain, skin.repeats));
    twins::let_go(roles, mesh, &twins, domain);
    let (off, merged) = finish(Finish { mesh, surfaces, stars, places: &places, roles, twins: &twins, size, skin });
    mesh.points = places.into_points();
    merged.leave_out(mesh);
    off
}

/// The steps, as [`Places::take_turn`] counts them.
const SLIDE: usize = 0;
const SMOOTH: usize = 1;

impl Fit<'_> {
    fn slide(&self, node: u32) {
        stop::point();
        let role = self.roles[node as usize];
        if matches!(role, Role::Fixed | Role::Free) || !self.places.take_turn(node, SLIDE) {
            return;
        }
        let mut star = self.star(node);
        if let Some(to) = slide::slide(self, &mut star, role) {
            self.go(node, &to);
        }
    }

    fn smooth(&self, node: u32, round: usize) {
        stop::point();
        let role = self.roles[node as usize];
        if role == Role::Fixed || !self.places.take_turn(node, SMOOTH) {
            return;
        }
        let mut star = self.star(node);
        let before = star.sharpest_first();
        if !smooth::is_poor(role, before) {
            return;
        }
        match smooth::smooth(self, &star, role, before, round) {
            Some(to) => self.go(node, &to),
            // The next round tries shorter steps.
            None => self.places.wait(node, SMOOTH),
        }
    }

    /// The star of a node, with those of its images.
    pub(super) fn star(&self, node: u32) -> Star {
        let star = |node: u32| Star::new(self.mesh, self.stars, node, self.places);
        self.twins.images(node).fold(star(node), |all, (image, way)| all.with_image(star(image), &way))
    }

    /// The tetrahedra around a node and its images.
    pub(super) fn cells_around(&self, node: u32) -> impl Iterator<Item = u32> {
        self.twins.class(node).flat_map(|(node, _)| self.stars.cells(node)).copied()
    }

    /// Nodes and grain of a tetrahedron.
    pub(super) fn cell(&self, cell: u32) -> ([u32; 4], u32) {
        (self.mesh.cells[cell as usize], self.mesh.grain[cell as usize])
    }

    /// Of a tetrahedron as it stands.
    pub(super) fn sharpness(&self, cell: u32) -> f64 {
        stop::point();
        sharpness(self.mesh.cells[cell as usize].map(|node| self.places.get(node)))
    }

    /// Moves the node and its images; all around them are to be looked at again.
    pub(super) fn go(&self, node: u32, to: &Vec3) {
        self.go_alone(node, to);
        for (image, way) in self.twins.images(node) {
            let side = self.places.get(image);
            self.go_alone(image, &Vec3::from_fn(|axis, _| if way[axis] == 0.0 { to[axis] } else { side[axis] }));
        }
    }

    fn go_alone(&self, node: u32, to: &Vec3) {
        self.places.set(node, to);
        for &cell in self.stars.cells(node) {
            self.mesh.cells[cell as usize].iter().for_each(|&near| self.places.wake(near));
        }
    }
}

/// The active nodes by patch, the patches by colour; nodes ascending.
fn patches(mesh: &Tetrahedra, active: &[bool], domain: &Aabb, edge: f64) -> [Vec<Vec<u32>>; 8] {
    let counts = [0, 1, 2].map(|i| (domain.size()[i] / edge).floor().max(1.0) as usize);
    let mut blocks = vec![Vec::new(); counts.iter().product()];
    for (node, point) in (0..).zip(&mesh.points).filter(|(node, _)| active[*node as usize]) {
        let [i, j, k] = [0, 1, 2].map(|a| {
            let share = (point[a] - domain.min[a]) / domain.size()[a];
            ((share * counts[a] as f64) as usize).min(counts[a] - 1)
        });
        blocks[(k * counts[1] + j) * counts[0] + i].push(node);
    }
    let mut colours: [Vec<Vec<u32>>; 8] = Default::default();
    for (b, nodes) in blocks.into_iter().enumerate().filter(|(_, nodes)| !nodes.is_empty()) {
        let [i, j, k] = [b % counts[0], b / counts[0] % counts[1], b / (counts[0] * counts[1])];
        colours[i % 2 + 2 * (j % 2) + 4 * (k % 2)].push(nodes);
    }
    colours
}
