//! After the cut: interface nodes slide along their body onto its edges and corners, where that brings back volume.
//!
//! The triangles between nodes on a convex surface lie inside it, so the cut loses the volume over them, most at edges
//! and corners; nodes with small angles around them are smoothed; what is still too small after some rounds of both is left to
//! the [`repair`](super::repair).
//!
//! Nodes go in patches, eight colours of them, such that patches of one colour share no tetrahedron. The patches of a colour are
//! worked on at the same time: none reads a position that another one writes. So the result does not depend on the number of
//! threads.

use super::boundary::Boundary;
use super::nodes::{Exact, PeriodicPairs, Role, near_surface, relabel, release, roles};
use super::repair::repair;
use super::smoothing::{clearly_fine, is_poor, smoothed, snapped, surely_guarded};
use super::surface::{Surface, volume_deficits};
use crate::cells::Owners;
use crate::location::Locator;
use crate::planes::LANES;
use crate::tet::{Incidence, Star, TetMesh, eight_cos2};
use meso_collision::math::{Aabb, Vec3};
use meso_collision::prefetch::prefetch;
use meso_concrete::parallel;
use meso_concrete::stop;
use std::sync::atomic::{AtomicU8, AtomicU32, AtomicU64, Ordering::Relaxed};

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
    let exact = Exact { surfaces, boundary, size };
    let mut owners = Owners::of(mesh.by_body());
    let mut roles_now = roles(mesh, &owners, domain, &exact);
    let active = near_surface(mesh, &roles_now);
    let incidence = Incidence::of(&mesh.cells, &active);
    let sweeps = Sweeps::new(MovingPatches::new(mesh, &active, domain, size * PATCH), mesh);
    for round in 0..ROUNDS {
        stop::point();
        if RELABELLED.contains(&round) {
            relabel(mesh, &owners, locator);
            owners = Owners::of(mesh.by_body());
            let before = std::mem::replace(&mut roles_now, roles(mesh, &owners, domain, &exact));
            let changed = (0..).zip(roles_now.iter().zip(&before)).filter(|(_, (now, before))| now != before);
            changed.for_each(|(node, _)| sweeps.waiting[node].store(ALL, Relaxed));
        }
        let deficits = volume_deficits(mesh, surfaces);
        let state = State { exact: &exact, incidence: &incidence, roles: &roles_now, deficits: &deficits };
        sweeps.sweep(mesh, state, |turn, node| turn.slide(node));
        sweeps.sweep(mesh, state, |turn, node| turn.smooth(node, round));
        parallel::each_short_mut(&mut mesh.points, |node, point| *point = sweeps.points[node].position());
    }
    let suspects = sweeps.suspects();
    drop(sweeps);
    let pairs = PeriodicPairs::of(&mesh.points, domain, boundary.repeats);
    release(&mut roles_now, mesh, &pairs, domain, boundary);
    repair(&exact, mesh, suspects, incidence, roles_now, &pairs)
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
    patches: MovingPatches,
    points: Vec<Spot>,
    waiting: Vec<AtomicU8>,
    /// The smallest angle of every cell, as [`min_dihedral_cos2`], in single precision: a node whose cells are clearly
    /// fine needs no star.
    measures: Vec<AtomicU32>,
}

impl Sweeps {
    fn new(patches: MovingPatches, mesh: &TetMesh) -> Self {
        Self {
            patches,
            points: parallel::map_each(&mesh.points, Spot::at),
            waiting: mesh.points.iter().map(|_| AtomicU8::new(ALL)).collect(),
            measures: measures(mesh),
        }
    }

    /// The cells that may be below the guard, ascending.
    fn suspects(&self) -> Vec<u32> {
        let limit = surely_guarded() as f32;
        parallel::filter(self.measures.len(), |cell| f32::from_bits(self.measures[cell].load(Relaxed)) >= limit)
    }

    /// Takes one step at every node, colour by colour.
    fn sweep(&self, mesh: &TetMesh, state: State, step: impl Fn(&mut SwungNode, u32) + Sync) {
        for colour in &self.patches.colours {
            let turn = || SwungNode { state, mesh, sweeps: self, star: Star::default(), memory: Vec::new() };
            parallel::map_with(colour.len(), turn, |turn, i| {
                let nodes = &self.patches.nodes[colour[i] as usize];
                for (&node, next) in nodes.iter().zip(1..) {
                    nodes.get(next).iter().for_each(|&&next| turn.fetch(next));
                    step(turn, node);
                }
            });
        }
    }
}

/// The bits of every cell's measure.
fn measures(mesh: &TetMesh) -> Vec<AtomicU32> {
    let mut all: Vec<AtomicU32> = mesh.cells.iter().map(|_| AtomicU32::new(0)).collect();
    parallel::chunks_mut(&mut all, CHUNK, |chunk, measures| {
        let cells = &mesh.cells[chunk * CHUNK..];
        for (measures, cells) in measures.chunks_mut(LANES).zip(cells.chunks(LANES)) {
            let mut corners = [[1.0; LANES]; 12];
            for (lane, &cell) in cells.iter().enumerate() {
                let values = mesh.corners(cell).into_iter().flat_map(<[f64; 3]>::from);
                corners.iter_mut().zip(values).for_each(|(row, value)| row[lane] = value);
            }
            let found = eight_cos2(&corners);
            measures.iter_mut().zip(found).for_each(|(measure, found)| *measure.get_mut() = single(found));
        }
    });
    all
}

/// Cells that are measured in one go.
const CHUNK: usize = 1 << 12;

/// The bits of a measure in single precision.
fn single(measure: f64) -> u32 {
    (measure as f32).to_bits()
}

/// A position that threads share: the bits of its coordinates.
struct Spot([AtomicU64; 3]);

impl Spot {
    fn at(position: &Vec3) -> Self {
        Self([0, 1, 2].map(|axis| AtomicU64::new(position[axis].to_bits())))
    }

    fn position(&self) -> Vec3 {
        Vec3::from_fn(|axis, _| f64::from_bits(self.0[axis].load(Relaxed)))
    }

    fn move_to(&self, to: &Vec3) {
        (0..3).for_each(|axis| self.0[axis].store(to[axis].to_bits(), Relaxed));
    }
}

/// Patches while their nodes move, one after the other.
struct SwungNode<'a> {
    state: State<'a>,
    /// Cells and owners; positions are those before the round.
    mesh: &'a TetMesh,
    sweeps: &'a Sweeps,
    /// The star of the latest node; its memory serves all nodes.
    star: Star,
    /// Memory for the measures of a star.
    memory: Vec<[f64; LANES]>,
}

impl SwungNode<'_> {
    /// Snaps a node to its body's features, where that gains volume.
    fn slide(&mut self, node: u32) {
        stop::point();
        let role = self.state.roles[node as usize];
        if matches!(role, Role::Fixed | Role::Free) || !self.take(node, SLIDE) {
            return;
        }
        self.look_at(node);
        if let Some(to) = snapped(self.state.exact, self.state.deficits, &mut self.star, role) {
            self.move_to(node, &to);
        }
    }

    /// Smooths a node whose angles are poor.
    fn smooth(&mut self, node: u32, round: usize) {
        stop::point();
        let role = self.state.roles[node as usize];
        if role == Role::Fixed || !self.take(node, SMOOTH) || self.cells_are_fine(node, role) {
            return;
        }
        self.look_at(node);
        let before = self.star.worst_first();
        if !is_poor(role, before) {
            return;
        }
        match smoothed(self.state.exact, &self.star, role, before, round) {
            Some(to) => self.move_to(node, &to),
            // The next round tries shorter steps.
            None => self.wakes(node, SMOOTH),
        }
    }

    /// Whether the cells around the node are so good that no rounding makes the node poor.
    fn cells_are_fine(&self, node: u32, role: Role) -> bool {
        let limit = clearly_fine(role) as f32;
        let measure = |&cell: &u32| f32::from_bits(self.sweeps.measures[cell as usize].load(Relaxed));
        self.state.incidence.cells(node).iter().all(|cell| measure(cell) < limit)
    }

    /// Whether anything around the node has changed since this step last looked at it.
    fn take(&self, node: u32, step: u8) -> bool {
        let waiting = &self.sweeps.waiting[node as usize];
        let steps = waiting.load(Relaxed);
        waiting.store(steps & !step, Relaxed);
        steps & step != 0
    }

    fn wakes(&self, node: u32, steps: u8) {
        self.sweeps.waiting[node as usize].fetch_or(steps, Relaxed);
    }

    /// Begins to bring the cells around a node near.
    fn fetch(&self, node: u32) {
        if self.sweeps.waiting[node as usize].load(Relaxed) != 0 {
            for &cell in self.state.incidence.cells(node) {
                prefetch(&self.mesh.cells[cell as usize..=cell as usize]);
                prefetch(&self.mesh.owner[cell as usize..=cell as usize]);
            }
        }
    }

    fn look_at(&mut self, node: u32) {
        let Self { state, mesh, sweeps, star, .. } = self;
        let cells = state.incidence.cells(node).iter().map(|&cell| mesh.owned(cell));
        star.refill(node, cells, |node| sweeps.points[node as usize].position());
    }

    /// Moves the node; all around it are to be looked at again.
    fn move_to(&mut self, node: u32, to: &Vec3) {
        let Self { state, mesh, sweeps, star, memory } = self;
        let cells = state.incidence.cells(node);
        sweeps.points[node as usize].move_to(to);
        star.each(to, memory, |number, measure| {
            let cell = cells[number];
            sweeps.measures[cell as usize].store(single(measure), Relaxed);
            mesh.cell(cell).into_iter().for_each(|near| sweeps.waiting[near as usize].store(ALL, Relaxed));
        });
    }
}

/// The nodes that move, by patch.
struct MovingPatches {
    /// Ascending.
    nodes: Vec<Vec<u32>>,
    colours: [Vec<u32>; 8],
}

impl MovingPatches {
    /// The `active` nodes in patches of `edge` mm.
    fn new(mesh: &TetMesh, active: &[bool], domain: &Aabb, edge: f64) -> Self {
        let counts = [0, 1, 2].map(|i| (domain.size()[i] / edge).floor().max(1.0) as usize);
        let mut nodes = vec![Vec::new(); counts.iter().product()];
        for (node, point) in (0..).zip(&mesh.points).filter(|(node, _)| active[*node as usize]) {
            let [i, j, k] = [0, 1, 2].map(|a| {
                let share = (point[a] - domain.min[a]) / domain.size()[a];
                ((share * counts[a] as f64) as usize).min(counts[a] - 1)
            });
            nodes[(k * counts[1] + j) * counts[0] + i].push(node);
        }
        let mut colours: [Vec<u32>; 8] = Default::default();
        for patch in (0..nodes.len()).filter(|&patch| !nodes[patch].is_empty()) {
            let [i, j, k] = [patch % counts[0], patch / counts[0] % counts[1], patch / (counts[0] * counts[1])];
            colours[i % 2 + 2 * (j % 2) + 4 * (k % 2)].push(patch as u32);
        }
        Self { nodes, colours }
    }
}
