//! After the cut: interface nodes slide along their body onto its edges and corners, where that brings back volume.
//!
//! The triangles between nodes on a convex surface lie inside it, so the cut loses the volume over them, most at edges
//! and corners; nodes with small angles around them are smoothed; what is still too small after some rounds of both is left to
//! the [`repair`](super::repair).
//!
//! Nodes go in patches, eight colours of them, such that patches of one colour share no tetrahedron. The patches of a colour are
//! worked on at the same time, each with its own copy of the nodes it moves; the driver puts the copies back once all are done. So
//! the result does not depend on the number of threads.

use super::boundary::Boundary;
use super::nodes::{Exact, PeriodicPairs, Role, near_surface, relabel, release, roles};
use super::repair::repair;
use super::smoothing::{is_poor, smoothed, snapped};
use super::surface::{Surface, volume_deficits};
use crate::location::Locator;
use crate::tet::{Incidence, Star, TetMesh};
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::parallel;
use meso_concrete::stop;

/// Rounds of sliding and smoothing.
const ROUNDS: usize = 5;
/// Cells that lie between interface nodes alone get the owner of their centroid before these rounds.
const RELABELLED: [usize; 2] = [2, 4];
/// Edge of a patch, in elements; more than twice the longest edge of a tetrahedron, so that colours stay apart.
const PATCH: f64 = 6.0;

/// Fits `mesh`, with elements of about `size` mm, to the surfaces; returns how many nodes that belong on a surface lie off it.
pub(super) fn fit(
    mesh: &mut TetMesh,
    surfaces: &[Surface],
    locator: &Locator,
    domain: &Aabb,
    size: f64,
    boundary: &Boundary,
) -> usize {
    let mut roles_now = roles(mesh, domain, boundary);
    let active = near_surface(mesh, &roles_now);
    let incidence = Incidence::of(&mesh.cells, &active);
    let exact = Exact { surfaces, boundary, size };
    let mut sweeps = Sweeps::new(Patches::new(mesh, &active, domain, size * PATCH), mesh.points.len());
    for round in 0..ROUNDS {
        stop::point();
        if RELABELLED.contains(&round) {
            relabel(mesh, locator);
            let before = std::mem::replace(&mut roles_now, roles(mesh, domain, boundary));
            let changed = (0..).zip(roles_now.iter().zip(&before)).filter(|(_, (now, before))| now != before);
            changed.for_each(|(node, _)| sweeps.waiting[node] = ALL);
        }
        let deficits = volume_deficits(mesh, surfaces);
        let state = State { exact: &exact, incidence: &incidence, roles: &roles_now, deficits: &deficits };
        sweeps.sweep(mesh, state, |turn, node| turn.slide(node));
        sweeps.sweep(mesh, state, |turn, node| turn.smooth(node, round));
    }
    let pairs = PeriodicPairs::of(&mesh.points, domain, boundary.repeats);
    release(&mut roles_now, mesh, &pairs, domain);
    repair(&exact, mesh, incidence, roles_now, &pairs)
}

/// The steps that a node waits for, as bits.
const SLIDE: u8 = 1;
const SMOOTH: u8 = 2;
const ALL: u8 = SLIDE | SMOOTH;

/// All that a move is judged by; it stays as it is while the patches of a colour are worked on.
#[derive(Clone, Copy)]
struct State<'a> {
    exact: &'a Exact<'a>,
    incidence: &'a Incidence,
    roles: &'a [Role],
    /// How much every body lacks of its volume, -1 to 1.
    deficits: &'a [f64],
}

/// The driver: which nodes are still to be looked at, and by which step.
struct Sweeps {
    patches: Patches,
    waiting: Vec<u8>,
}

impl Sweeps {
    fn new(patches: Patches, nodes: usize) -> Self {
        Self { patches, waiting: vec![ALL; nodes] }
    }

    /// Takes one step at every node, colour by colour, and applies the result.
    fn sweep(&mut self, mesh: &mut TetMesh, state: State, step: impl Fn(&mut Turn, u32) + Sync) {
        for colour in 0..self.patches.colours.len() {
            let done: Vec<Done> = {
                let before = &*mesh;
                let of_patch = |&patch: &u32| {
                    let mut turn = Turn::new(state, before, &self.patches, patch, &self.waiting);
                    self.patches.nodes[patch as usize].iter().for_each(|&node| step(&mut turn, node));
                    turn.done
                };
                parallel::map_each(&self.patches.colours[colour], of_patch)
            };
            for (&patch, done) in self.patches.colours[colour].iter().zip(done) {
                for ((&node, point), waiting) in
                    self.patches.nodes[patch as usize].iter().zip(done.points).zip(done.waiting)
                {
                    (mesh.points[node as usize], self.waiting[node as usize]) = (point, waiting);
                }
                done.woken.into_iter().for_each(|node| self.waiting[node as usize] = ALL);
            }
        }
    }
}

/// The results of a patch's turn.
struct Done {
    /// Number of the patch's own nodes.
    points: Vec<Vec3>,
    waiting: Vec<u8>,
    /// Nodes of other patches around which something has changed.
    woken: Vec<u32>,
}

/// One patch while its nodes move, one after the other.
struct Turn<'a> {
    state: State<'a>,
    /// As it was before the turn.
    mesh: &'a TetMesh,
    patches: &'a Patches,
    patch: u32,
    done: Done,
}

impl<'a> Turn<'a> {
    fn new(state: State<'a>, mesh: &'a TetMesh, patches: &'a Patches, patch: u32, waiting: &[u8]) -> Self {
        let nodes = || patches.nodes[patch as usize].iter();
        let points = nodes().map(|&node| mesh.position(node)).collect();
        let waiting = nodes().map(|&node| waiting[node as usize]).collect();
        Self { state, mesh, patches, patch, done: Done { points, waiting, woken: Vec::new() } }
    }

    /// Snaps a node to its body's features, where that gains volume.
    fn slide(&mut self, node: u32) {
        stop::point();
        let role = self.state.roles[node as usize];
        if matches!(role, Role::Fixed | Role::Free) || !self.take(node, SLIDE) {
            return;
        }
        let mut star = self.star(node);
        if let Some(to) = snapped(self.state.exact, self.state.deficits, &mut star, role) {
            self.move_to(node, to);
        }
    }

    /// Smooths a node whose angles are poor.
    fn smooth(&mut self, node: u32, round: usize) {
        stop::point();
        let role = self.state.roles[node as usize];
        if role == Role::Fixed || !self.take(node, SMOOTH) {
            return;
        }
        let mut star = self.star(node);
        let before = star.worst_first();
        if !is_poor(role, before) {
            return;
        }
        match smoothed(self.state.exact, &star, role, before, round) {
            Some(to) => self.move_to(node, to),
            // The next round tries shorter steps.
            None => *self.waiting(node) |= SMOOTH,
        }
    }

    /// Whether anything around the node has changed since this step last looked at it.
    fn take(&mut self, node: u32, step: u8) -> bool {
        let waiting = self.waiting(node);
        let is_waiting = *waiting & step != 0;
        *waiting &= !step;
        is_waiting
    }

    fn waiting(&mut self, node: u32) -> &mut u8 {
        &mut self.done.waiting[self.patches.slot[node as usize] as usize]
    }

    fn is_own(&self, node: u32) -> bool {
        self.patches.of[node as usize] == self.patch
    }

    fn position(&self, node: u32) -> Vec3 {
        if self.is_own(node) {
            self.done.points[self.patches.slot[node as usize] as usize]
        } else {
            self.mesh.position(node)
        }
    }

    fn star(&self, node: u32) -> Star {
        let cells = self.state.incidence.cells(node).iter();
        Star::of_cells(node, cells.map(|&cell| self.mesh.owned(cell)), |node| self.position(node))
    }

    /// Moves the node; all around it are to be looked at again.
    fn move_to(&mut self, node: u32, to: Vec3) {
        self.done.points[self.patches.slot[node as usize] as usize] = to;
        for &cell in self.state.incidence.cells(node) {
            for near in self.mesh.cell(cell) {
                if self.is_own(near) {
                    *self.waiting(near) = ALL;
                } else {
                    self.done.woken.push(near);
                }
            }
        }
    }
}

/// The patch of a node that does not move.
const NO_PATCH: u32 = u32::MAX;

/// The nodes that move, by patch.
struct Patches {
    /// Ascending.
    nodes: Vec<Vec<u32>>,
    colours: [Vec<u32>; 8],
    /// The patch of every node, and its number there.
    of: Vec<u32>,
    slot: Vec<u32>,
}

impl Patches {
    /// The `active` nodes in patches of `edge` mm.
    fn new(mesh: &TetMesh, active: &[bool], domain: &Aabb, edge: f64) -> Self {
        let counts = [0, 1, 2].map(|i| (domain.size()[i] / edge).floor().max(1.0) as usize);
        let mut nodes = vec![Vec::new(); counts.iter().product()];
        let (mut of, mut slot) = (vec![NO_PATCH; active.len()], vec![0; active.len()]);
        for (node, point) in (0..).zip(&mesh.points).filter(|(node, _)| active[*node as usize]) {
            let [i, j, k] = [0, 1, 2].map(|a| {
                let share = (point[a] - domain.min[a]) / domain.size()[a];
                ((share * counts[a] as f64) as usize).min(counts[a] - 1)
            });
            let patch = (k * counts[1] + j) * counts[0] + i;
            (of[node as usize], slot[node as usize]) = (patch as u32, nodes[patch].len() as u32);
            nodes[patch].push(node);
        }
        let mut colours: [Vec<u32>; 8] = Default::default();
        for patch in (0..nodes.len()).filter(|&patch| !nodes[patch].is_empty()) {
            let [i, j, k] = [patch % counts[0], patch / counts[0] % counts[1], patch / (counts[0] * counts[1])];
            colours[i % 2 + 2 * (j % 2) + 4 * (k % 2)].push(patch as u32);
        }
        Self { nodes, colours, of, slot }
    }
}
