//! The angles of a lattice's layer, and then its volume.
//!
//! The inner ends of rails and the nodes inside the bodies are smoothed. Where that does not help, a rail collapses, at last with
//! those around it: the layer has no thickness there. Cells below 2 degrees are worked at, and no others: a layer of 0.1 mm on
//! elements of 2 mm has angles of some 3 degrees of its own.
//!
//! A rail collapses when its inner end is contracted onto the outer one, and the cells that hold both are gone. It is an edge
//! of one of the three tetrahedra of each prism around it, and of no other cell, so that neighbours still match. Where the
//! collapse of one rail alone would turn a neighbour over, a group of them may collapse: it begins with the rails of one poor
//! cell. Where their collapse leaves cells as poor as those that it mends, the rails of these join the group, for [`WAVES`]
//! times: with all rails around gone the body's cells are nearly the old ones, none of which was poor.
//!
//! Smoothing looks for the largest angle, and may move a node farther than the layer is thick. So inner ends then go nearer to
//! their targets, as far as that leaves no angle too small ([`give_back`]). At last all inner ends move by one
//! share of their rails, which brings the layers' volume to the exact one ([`balance`]).

use super::approach::nearer;
use super::periodic::{Faces, Flat};
use super::prisms::{Layer, RailEnds};
use crate::cells::Phase;
use crate::tet::{
    Constraint, Improver, Incidence, Star, TetMesh, ascending, cos2_of, directions, improve as improve_cells,
    min_dihedral_cos2, smoothed, volume,
};
use meso_collision::math::Vec3;
use meso_concrete::parallel;
use meso_concrete::stop;

/// Rounds of smoothing and collapsing rails.
const ROUNDS: usize = 5;
/// Rounds of collapsing rails in groups, and smoothing.
const LAST_ROUNDS: usize = 3;
/// Turns of smoothing in a round; each one looks only at the cells that the one before left.
const TURNS: usize = 8;
/// Lengths of the steps tried, in elements.
const STEPS: [f64; 4] = [0.2, 0.07, 0.025, 0.008];
/// Rounds; each one makes up for the nodes that could not go in the one before.
const BALANCES: usize = 3;
/// The share tried to measure its effect.
const TRIED: f64 = 0.1;
/// The largest share that a node goes in a round.
const MOST: f64 = 0.1;
/// The layers' volume is right when less than this share of it is missing.
const CLOSE: f64 = 1e-4;
/// Rounds in which inner ends go back towards their targets.
const BACK: usize = 4;
/// Cells added up together.
const RUN: usize = 1 << 12;

/// The counts of changes for the angles.
pub(crate) struct Improved {
    /// Inner ends that left the exact offset.
    pub(crate) shifted: usize,
    /// Rails that collapsed.
    pub(crate) collapsed: usize,
    /// Rails that collapsed though their inner ends had not stopped short before.
    pub(crate) thinned: usize,
}

/// Works on a mesh with elements of about `size` mm and this `layer`, whose exact volume is `exact_mm3` where it is known.
pub(crate) fn improve(
    mesh: &mut TetMesh,
    phase: &mut Vec<Phase>,
    periodic: [bool; 3],
    layer: &Layer,
    exact_mm3: Option<f64>,
    size: f64,
) -> Improved {
    let movable = Movable::new(mesh, phase, periodic, layer);
    let mut suspects: Vec<u32> = mesh.numbers().collect();
    let mut smoothing = Smoothing { mesh, phase, movable: &movable, size, shifted: Vec::new() };
    for _ in 0..ROUNDS {
        if suspects.is_empty() {
            break;
        }
        suspects = improve_cells(&mut smoothing, suspects, TURNS);
        let poor = smoothing.poor(&suspects);
        collapse(smoothing.mesh, &movable, &poor);
        suspects.retain(|&cell| !smoothing.mesh.is_removed(cell));
    }
    for _ in 0..LAST_ROUNDS {
        let poor = smoothing.poor(&suspects);
        if poor.is_empty() {
            break;
        }
        collapse_groups(smoothing.mesh, &movable, &poor, &mut suspects);
        suspects.retain(|&cell| !smoothing.mesh.is_removed(cell));
        suspects = improve_cells(&mut smoothing, ascending(suspects), TURNS);
    }
    let moved = smoothing.shifted;
    let mut shifted = vec![false; mesh.points.len()];
    moved.iter().for_each(|node| shifted[*node as usize] = true);
    give_back(mesh, &movable, layer);
    if let Some(exact) = exact_mm3 {
        balance(mesh, phase, &movable, exact);
    }
    let mut kept = mesh.drop_removed().into_iter();
    phase.retain(|_| kept.next() == Some(true));
    let mut there = vec![false; mesh.points.len()];
    mesh.cells.as_flattened().iter().for_each(|&node| there[node as usize] = true);
    mesh.drop_lone_nodes();
    let (left, collapsed): (Vec<&RailEnds>, Vec<&RailEnds>) =
        layer.rails.iter().partition(|rail| there[rail.inner as usize]);
    Improved {
        shifted: left.iter().filter(|rail| shifted[rail.inner as usize]).count(),
        collapsed: collapsed.len(),
        thinned: collapsed.iter().filter(|rail| !rail.is_short).count(),
    }
}

/// Moves the nodes of poor cells; mortar is not the layer's.
struct Smoothing<'a> {
    mesh: &'a mut TetMesh,
    phase: &'a [Phase],
    movable: &'a Movable,
    size: f64,
    /// Nodes that moved.
    shifted: Vec<u32>,
}

impl Improver for Smoothing<'_> {
    fn is_poor(&self, cell: u32) -> bool {
        stop::point();
        self.phase[cell as usize] != Phase::Mortar
            && !self.mesh.is_removed(cell)
            && self.mesh.cos2(cell) > self.movable.limit
    }

    fn round(&mut self, poor: &[u32]) -> Vec<u32> {
        let nodes = self.movable.nodes(self.mesh, poor);
        let incidence = Incidence::around(&self.mesh.cells, self.mesh.points.len(), nodes.iter().copied());
        for &node in &nodes {
            if let Some(position) = self.better(node, &incidence) {
                let moved = Mover(self.movable, node).moved(&position);
                self.shifted.extend(moved.iter().map(|(node, _)| *node));
                apply(self.mesh, moved);
            }
        }
        nodes.iter().flat_map(|&node| incidence.cells(node)).chain(poor).copied().collect()
    }
}

impl Smoothing<'_> {
    fn poor(&self, cells: &[u32]) -> Vec<u32> {
        parallel::pick(cells, |&cell| self.is_poor(cell))
    }

    /// The best position around a node, with its images; `None` where it is there already, or none of their cells is poor.
    fn better(&self, node: u32, incidence: &Incidence) -> Option<Vec3> {
        let (x, mover) = (self.mesh.position(node), Mover(self.movable, node));
        let mut stars = Stars::of(self.mesh, self.movable, incidence, node);
        let before = stars.worst_first(-1.0);
        if before <= self.movable.limit {
            return None;
        }
        let steps = STEPS.map(|step| step * self.size);
        let position = smoothed(&mover, &x, steps, before, |x, limit| stars.worst(self.movable, x, limit));
        position.filter(|position| *position != x)
    }
}

fn apply(mesh: &mut TetMesh, moved: Vec<(u32, Vec3)>) {
    moved.into_iter().for_each(|(node, position)| mesh.points[node as usize] = position);
}

/// The stars of a node and of its images.
struct Stars(Vec<(u32, Star)>);

impl Stars {
    fn of(mesh: &TetMesh, movable: &Movable, incidence: &Incidence, node: u32) -> Self {
        let images = movable.faces.images(node).into_iter();
        Self(images.map(|image| (image, Star::of(mesh, image, incidence.cells(image)))).collect())
    }

    fn worst_first(&mut self, least: f64) -> f64 {
        self.0.iter_mut().map(|(_, star)| star.worst_first()).fold(least, f64::max)
    }

    /// Whether the node may go to `x`: no cell is poor there, or poorer than the worst now.
    fn allow(&mut self, movable: &Movable, x: &Vec3) -> bool {
        let is_within = |stars: &Self, limit: f64| stars.worst(movable, x, limit) <= limit;
        is_within(self, movable.limit) || {
            let worst = self.worst_first(-1.0);
            worst > movable.limit && is_within(self, worst)
        }
    }

    /// The worst of all with the node at `x` and its images with it.
    fn worst(&self, movable: &Movable, x: &Vec3, limit: f64) -> f64 {
        self.0.iter().map(|(image, star)| star.worst(&movable.faces.put(*image, x), limit)).fold(-1.0, f64::max)
    }
}

/// Moves the inner ends that are not at their targets nearer to these, as far as that leaves no angle too small.
fn give_back(mesh: &mut TetMesh, movable: &Movable, layer: &Layer) {
    // All images at once, when their first comes up.
    let is_away = |rail: &&RailEnds| {
        let RailEnds { inner, target, .. } = rail;
        mesh.position(*inner) != *target && movable.faces.images(*inner)[0] == *inner && movable.are_inner_ends(*inner)
    };
    let away: Vec<&RailEnds> = layer.rails.iter().filter(is_away).collect();
    let images = away.iter().flat_map(|rail| movable.faces.images(rail.inner));
    let incidence = Incidence::around(&mesh.cells, mesh.points.len(), images);
    for _ in 0..BACK {
        for &RailEnds { inner, target, .. } in away.iter().filter(|rail| !incidence.cells(rail.inner).is_empty()) {
            let mut stars = Stars::of(mesh, movable, &incidence, *inner);
            let (x, flat) = (mesh.position(*inner), movable.faces.flat(*inner));
            if let Some(position) = nearer(&x, target, |step| flat.along(step), |x| stars.allow(movable, x)) {
                apply(mesh, Mover(movable, *inner).moved(&position));
            }
        }
    }
}

/// Moves the inner ends of rails, with their images, until the layers of `mesh` have `exact` mm3.
fn balance(mesh: &mut TetMesh, phase: &[Phase], movable: &Movable, exact: f64) {
    let all = 0..mesh.points.len() as u32;
    let nodes: Vec<u32> = all.filter(|&node| movable.are_inner_ends(node)).collect();
    let incidence = Incidence::around(&mesh.cells, mesh.points.len(), nodes.iter().copied());
    let ends =
        |mesh: &TetMesh, node: u32| [node, movable.outer_end(node).unwrap_or(node)].map(|end| mesh.position(end));
    for _ in 0..BALANCES {
        let before = layer_volume(mesh, phase, &mesh.points);
        if (before - exact).abs() < CLOSE * exact {
            return;
        }
        let mut tried = mesh.points.clone();
        for &node in &nodes {
            let [inner, outer] = ends(mesh, node);
            tried[node as usize] = inner + (outer - inner) * TRIED;
        }
        let lost = (before - layer_volume(mesh, phase, &tried)) / TRIED;
        let share = if lost > 0.0 { ((before - exact) / lost).clamp(-MOST, MOST) } else { 0.0 };
        // All images at once, when their first comes up.
        let is_first = |node: u32| movable.faces.images(node)[0] == node && !incidence.cells(node).is_empty();
        for &node in nodes.iter().filter(|node| is_first(**node)) {
            let [inner, outer] = ends(mesh, node);
            let position = inner + movable.faces.flat(node).along(&(outer - inner)) * share;
            if Stars::of(mesh, movable, &incidence, node).allow(movable, &position) {
                apply(mesh, Mover(movable, node).moved(&position));
            }
        }
    }
}

/// The volume of the layers with the nodes at `points`, mm3; the same on any number of threads.
fn layer_volume(mesh: &TetMesh, phase: &[Phase], points: &[Vec3]) -> f64 {
    let of_run = |(cells, phases): &(&[[u32; 4]], &[Phase])| -> f64 {
        let itz = cells.iter().zip(*phases).filter(|(cell, phase)| **phase == Phase::Itz && cell[0] != u32::MAX);
        itz.map(|(cell, _)| volume(cell.map(|node| points[node as usize]))).sum()
    };
    let runs: Vec<_> = mesh.cells.chunks(RUN).zip(phase.chunks(RUN)).collect();
    parallel::map_each(&runs, of_run).into_iter().sum()
}

/// Cells with a smaller dihedral angle are poor, degrees.
const POOR_DEG: f64 = 2.0;
/// How often a group grows.
const WAVES: usize = 4;

/// The nodes that may move, and how.
struct Movable {
    /// For every node the outer end of the rail whose inner end it is, or [`NO_RAIL`].
    outer: Vec<u32>,
    /// The nodes that stay: the mortar's, the outer ends of rails, and their images.
    fixed: Vec<bool>,
    /// Images on them move together, within these.
    faces: Faces,
    /// Cells above this are poor.
    limit: f64,
}

const NO_RAIL: u32 = u32::MAX;

impl Movable {
    fn new(mesh: &TetMesh, phase: &[Phase], periodic: [bool; 3], layer: &Layer) -> Self {
        let mut outer = vec![NO_RAIL; mesh.points.len()];
        let mut fixed = vec![false; mesh.points.len()];
        for rail in &layer.rails {
            outer[rail.inner as usize] = rail.outer;
            fixed[rail.outer as usize] = true;
        }
        for (cell, _) in mesh.cells.iter().zip(phase).filter(|(_, phase)| **phase == Phase::Mortar) {
            cell.iter().for_each(|&node| fixed[node as usize] = true);
        }
        let faces = Faces::of(mesh, periodic, &layer.caps);
        let stays =
            |node: u32| !faces.is_matched(node) || faces.images(node).iter().any(|&image| fixed[image as usize]);
        let on_faces: Vec<u32> =
            (0..fixed.len() as u32).filter(|&node| faces.flat(node) != Flat::SPACE && stays(node)).collect();
        on_faces.into_iter().for_each(|node| fixed[node as usize] = true);
        Self { outer, fixed, faces, limit: cos2_of(POOR_DEG) }
    }

    /// The outer end of the rail whose inner end `node` is.
    fn outer_end(&self, node: u32) -> Option<u32> {
        Some(self.outer[node as usize]).filter(|end| *end != NO_RAIL)
    }

    /// Whether a node and all of its images are inner ends.
    fn are_inner_ends(&self, node: u32) -> bool {
        self.faces.images(node).into_iter().all(|image| self.outer_end(image).is_some())
    }

    /// The nodes of `cells` that may move, and their images, ascending.
    fn nodes(&self, mesh: &TetMesh, cells: &[u32]) -> Vec<u32> {
        let all = cells.iter().flat_map(|&cell| mesh.cell(cell));
        let free = all.filter(|&node| !self.fixed[node as usize]);
        ascending(free.flat_map(|node| self.faces.images(node)))
    }

    /// The inner ends among these.
    fn inner_ends(&self, mesh: &TetMesh, cells: &[u32]) -> Vec<u32> {
        let mut nodes = self.nodes(mesh, cells);
        nodes.retain(|&node| self.are_inner_ends(node));
        nodes
    }
}

/// One node that may move.
struct Mover<'a>(&'a Movable, u32);

impl Constraint for Mover<'_> {
    /// Steps are in mm.
    fn reachable(&self, x: &Vec3, step: f64) -> Vec<Vec3> {
        let flat = self.0.faces.flat(self.1);
        directions().map(|direction| x + flat.along(&direction) * step).collect()
    }
}

impl Mover<'_> {
    /// The node and its images with their positions when it moves to `x`.
    fn moved(&self, x: &Vec3) -> Vec<(u32, Vec3)> {
        self.0.faces.images(self.1).into_iter().map(|image| (image, self.0.faces.put(image, x))).collect()
    }
}

/// Collapses the rails of the `poor` cells, with their images, where that leaves better ones.
fn collapse(mesh: &mut TetMesh, movable: &Movable, poor: &[u32]) {
    let nodes = movable.inner_ends(mesh, poor);
    let incidence = Incidence::around(&mesh.cells, mesh.points.len(), nodes.iter().copied());
    for &node in &nodes {
        let images = movable.faces.images(node);
        // All at once, when their first comes up.
        if images[0] != node {
            continue;
        }
        let rails: Vec<Rail> =
            images.iter().filter_map(|&image| Rail::new(mesh, movable, image, incidence.cells(image))).collect();
        let before = rails.iter().map(|rail| rail.before(mesh)).fold(-1.0, f64::max);
        let after = rails.iter().map(|rail| rail.after(mesh, before)).fold(-1.0, f64::max);
        if before > movable.limit && after < before {
            rails.iter().for_each(|rail| mesh.contract(rail.node, rail.end, &rail.cells));
        }
    }
}

/// The inner end of a rail with the cells around it.
struct Rail {
    node: u32,
    /// The outer end.
    end: u32,
    /// Cells that go with the rail come first.
    cells: Vec<u32>,
    gone: usize,
}

impl Rail {
    fn new(mesh: &TetMesh, movable: &Movable, node: u32, cells: &[u32]) -> Option<Self> {
        let end = movable.outer_end(node)?;
        let there = cells.iter().filter(|&&cell| !mesh.is_removed(cell));
        let (mut cells, rest): (Vec<u32>, Vec<u32>) = there.partition(|&&cell| mesh.cell(cell).contains(&end));
        let gone = cells.len();
        cells.extend(rest);
        Some(Self { node, end, cells, gone })
    }

    fn before(&self, mesh: &TetMesh) -> f64 {
        Star::of(mesh, self.node, &self.cells).worst_first()
    }

    fn after(&self, mesh: &TetMesh, limit: f64) -> f64 {
        Star::of(mesh, self.node, &self.cells[self.gone..]).worst(&mesh.position(self.end), limit)
    }
}

/// Collapses groups of rails around the `poor` cells, with their images, where that leaves better ones, and adds the
/// cells around them to `suspects`.
fn collapse_groups(mesh: &mut TetMesh, movable: &Movable, poor: &[u32], suspects: &mut Vec<u32>) {
    let mut groups: Vec<Group> = poor.iter().map(|&cell| Group { nodes: movable.inner_ends(mesh, &[cell]) }).collect();
    for _ in 0..WAVES {
        let nodes = groups.iter().flat_map(|group| group.nodes.iter().copied());
        let incidence = Incidence::around(&mesh.cells, mesh.points.len(), nodes);
        groups.retain_mut(|group| group.grows(mesh, movable, &incidence, suspects));
    }
}

/// Inner ends of rails.
struct Group {
    nodes: Vec<u32>,
}

impl Group {
    /// Collapses, or grows by the rails of the cells that forbid it; whether it grew, to be tried again.
    fn grows(&mut self, mesh: &mut TetMesh, movable: &Movable, incidence: &Incidence, suspects: &mut Vec<u32>) -> bool {
        let mut cells = ascending(self.nodes.iter().flat_map(|&node| incidence.cells(node)).copied());
        cells.retain(|&cell| !mesh.is_removed(cell));
        // Another group may have taken some of them.
        self.nodes.retain(|node| cells.iter().any(|&cell| mesh.cell(cell).contains(node)));
        let before = mesh.worst(cells.iter().copied());
        if before <= movable.limit {
            return false;
        }
        let then = |cell: u32| self.collapsed(movable, mesh.cell(cell));
        let cos2 = |nodes: [u32; 4]| min_dihedral_cos2(mesh.corners(nodes));
        let forbids = |cell: &u32| then(*cell).is_some_and(|nodes| cos2(nodes) >= before);
        let forbidding: Vec<u32> = cells.iter().copied().filter(forbids).collect();
        if forbidding.is_empty() {
            let all: Vec<(u32, Option<[u32; 4]>)> = cells.iter().map(|&cell| (cell, then(cell))).collect();
            for (cell, nodes) in all {
                match nodes {
                    Some(nodes) => mesh.cells[cell as usize] = nodes,
                    None => mesh.remove(cell),
                }
            }
            suspects.extend(cells);
            return false;
        }
        let count = self.nodes.len();
        let more = movable.inner_ends(mesh, &forbidding);
        self.nodes = ascending(self.nodes.drain(..).chain(more));
        self.nodes.len() > count
    }

    /// The cell's nodes after the collapse; `None` where it is gone with a rail of its own.
    fn collapsed(&self, movable: &Movable, nodes: [u32; 4]) -> Option<[u32; 4]> {
        let ends = nodes.map(|node| match self.nodes.binary_search(&node) {
            Ok(_) => movable.outer[node as usize],
            Err(_) => node,
        });
        let twice = (0..4).any(|i| ends[..i].contains(&ends[i]));
        (!twice).then_some(ends)
    }
}
