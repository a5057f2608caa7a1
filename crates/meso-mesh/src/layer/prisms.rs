//! The prisms between interface triangles and their offsets, cut into the layer's tetrahedra; and how far these open, so that no
//! tetrahedron turns over: nodes are untangled, then they step back, and go as far forward again as they can
//! ([`approach`](mod@super::approach)).
//!
//! Untangling: the flat tetrahedra that a mesher leaves under a surface stand on nodes that go to different faces' offsets, and
//! small faces' projections come out of order: a few microns turn such a cell over, and a few set it right. Each node of a bad
//! cell takes the displacement that gains the cell its volume with the least moves; a node of several cells takes the mean. (In packings
//! of 30 mm at 1.2, 2 and 3 mm some 80 triangles of 12,900 come out of order, and all are set right in 30 rounds; nodes
//! that step back instead, 0.4 mm at one of them, made most of the layer's error.)
//!
//! Backtracking: all nodes start with their whole displacement. The nodes of a bad tetrahedron keep [`STEP_BACK`] of it, and
//! after [`STEPS`] such steps none. The end is sure: with all nodes at their old positions the body's cells are the old ones,
//! and a layer cell is left out with its rail. So are the cells of rails that had no length from the start.

use super::by_node;
use super::periodic::PeriodicConstraint;
use crate::cells::Phase;
use crate::cells::{Copies, InterfaceFace};
use crate::tet::{TetMesh, volume};
use meso_collision::math::Vec3;
use meso_concrete::parallel;
use meso_concrete::stop;
use rayon::prelude::*;

/// The prism between an interface triangle and its offset. Diagonals start at the lowest image class, so neighbours match,
/// and so do the opposite faces of a periodic box.
pub(super) fn prism(
    mesh: &TetMesh,
    face: &InterfaceFace,
    copies: &Copies,
    constraint: &PeriodicConstraint,
) -> [LayerCell; 3] {
    stop::point();
    let owner = mesh.owner[face.cell as usize];
    let [a, b, c, _] = face.nodes;
    let p = |node: u32| -> Vec3 { mesh.position(node) };
    let area = (p(b) - p(a)).cross(&(p(c) - p(a))).norm() / 2.0;
    let mut rails = [a, b, c].map(|node| [copies.of(owner, node), node]);
    let rank = |node: u32| (constraint.class(node), node);
    let turns = [(a, b), (b, c), (a, c)].iter().filter(|(first, second)| rank(*first) > rank(*second)).count();
    rails.sort_unstable_by_key(|rail| rank(rail[1]));
    let [[a, d], [b, e], [c, f]] = rails;
    [([a, b, c, f], rails[2]), ([a, e, b, f], rails[1]), ([a, d, e, f], rails[0])].map(|(nodes, rail)| {
        let [i, j, k, l] = nodes;
        // Positive when the rails are in an even order, since the face is counter-clockwise from outside.
        let nodes = if turns % 2 == 0 { nodes } else { [j, i, k, l] };
        LayerCell { nodes, rail, owner, area }
    })
}

/// A node is short of its target where more than this share of its way is left.
const SHORT: f64 = 0.05;

/// Adds the layer's cells, and takes back the copies that are `pinched`, with the cells on their rails; the rails that are left.
pub(super) fn append(
    mesh: &mut TetMesh,
    phase: &mut Vec<Phase>,
    layer: &[LayerCell],
    copies: &Copies,
    targets: &[Vec3],
    pinched: &[bool],
) -> Vec<RailEnds> {
    let mut rails = Vec::new();
    for cell in layer.iter().filter(|cell| !pinched[cell.rail[0] as usize]) {
        mesh.push(cell.nodes, cell.owner);
        phase.push(Phase::Itz);
    }
    let mut number: Vec<u32> = (0..mesh.points.len() as u32).collect();
    let mut next = (mesh.points.len() - copies.iter().len()) as u32;
    for (_, outer, copy) in copies.iter() {
        if pinched[copy as usize] {
            number[copy as usize] = outer;
        } else {
            let ([from, at], target) = ([outer, copy].map(|node| mesh.position(node)), targets[copy as usize]);
            let is_short = (target - at).norm() > SHORT * (target - from).norm();
            mesh.points[next as usize] = at;
            number[copy as usize] = next;
            rails.push(RailEnds { inner: next, outer, target, is_short });
            next += 1;
        }
    }
    mesh.points.truncate(next as usize);
    parallel::each_short_mut(mesh.cells.as_flattened_mut(), |_, node| *node = number[*node as usize]);
    rails
}

/// The layer as it was made.
pub(crate) struct Layer {
    /// Aggregates too small for their thickness.
    pub(crate) thinned_aggregates: usize,
    /// Interface nodes that did not move: there the layer has no thickness.
    pub(crate) pinched_nodes: usize,
    pub(super) rails: Vec<RailEnds>,
    /// The caps of the bodies, a bit for each of the [`SIDES`](crate::cells::SIDES).
    pub(super) caps: Vec<u8>,
}

impl Layer {
    /// Interface nodes that stopped short of their target, or did not move.
    pub(crate) fn short_nodes(&self) -> usize {
        self.pinched_nodes + self.rails.iter().filter(|rail| rail.is_short).count()
    }
}

/// The ends of a rail.
pub(super) struct RailEnds {
    pub(super) inner: u32,
    pub(super) outer: u32,
    /// Where the inner end was to go.
    pub(super) target: Vec3,
    /// The inner end stopped short of its target.
    pub(super) is_short: bool,
}

/// A tetrahedron of the layer; it holds both ends of one rail.
#[derive(Clone, Copy)]
pub(super) struct LayerCell {
    pub(super) nodes: [u32; 4],
    /// The copy that the body's cells have for the rail's outer end, and that end.
    pub(super) rail: [u32; 2],
    pub(super) owner: u32,
    /// Area of the interface triangle, mm2.
    pub(super) area: f64,
}

/// After each try the nodes of cells that are still bad leave their targets for those along the ray, which are in
/// order everywhere (in a 60 mm cube at 2 mm one more try frees all of 58,987 nodes, where 33 were stuck).
const TRIES: usize = 4;
/// Rounds of moves in each try.
const ROUNDS: usize = 30;
/// The volume aimed at, in least ones: moves of other nodes take some of it again.
const AIM: f64 = 1.6;
/// A node moves at most this share of the distance to its old position in one round.
const FARTHEST: f64 = 0.2;

/// Moves `targets` until no cell is bad, or until the tries are over; `on_rays` are those along the nodes' rays. Returns the
/// nodes of cells that still were bad in the last try.
pub(super) fn untangle(
    mesh: &TetMesh,
    layer: &[LayerCell],
    constraint: &PeriodicConstraint,
    on_rays: &[Vec3],
    targets: &mut [Vec3],
) -> Vec<u32> {
    let mut stuck = Vec::new();
    for _ in 0..TRIES {
        stuck = untangled(mesh, layer, constraint, targets);
        if stuck.is_empty() {
            break;
        }
        stuck.iter().for_each(|&node| targets[node as usize] = on_rays[node as usize]);
        constraint.spread(targets);
    }
    stuck
}

/// Moves `targets` until no cell is bad, or until the rounds are over; the nodes of cells that still are.
fn untangled(mesh: &TetMesh, layer: &[LayerCell], constraint: &PeriodicConstraint, targets: &mut [Vec3]) -> Vec<u32> {
    let mut stirred = vec![true; targets.len()];
    for _ in 0..ROUNDS {
        let mut moves = moves(mesh, layer, constraint, targets, &stirred);
        if moves.is_empty() {
            return Vec::new();
        }
        by_node(&mut moves);
        stirred.fill(false);
        for group in moves.chunk_by(|a, b| a.0 == b.0) {
            let node = group[0].0 as usize;
            let mean = group.iter().map(|(_, step)| *step).sum::<Vec3>() / group.len() as f64;
            let farthest = FARTHEST * (targets[node] - mesh.points[node]).norm();
            targets[node] += mean * (farthest / mean.norm()).min(1.0);
            stirred[node] = true;
        }
        constraint.spread(targets);
        constraint.share(&mut stirred);
    }
    moves(mesh, layer, constraint, targets, &stirred).into_iter().map(|(node, _)| node).collect()
}

/// Leads of the nodes of bad cells with the displacement that each should get; of the cells that have a `stirred` node.
fn moves(
    mesh: &TetMesh,
    layer: &[LayerCell],
    constraint: &PeriodicConstraint,
    targets: &[Vec3],
    stirred: &[bool],
) -> Vec<(u32, Vec3)> {
    let now = |nodes: [u32; 4]| nodes.map(|node| targets[node as usize]);
    let near = |nodes: &[u32; 4]| nodes.iter().any(|&node| stirred[node as usize]);
    let core = |nodes: &[u32; 4]| (*nodes, least_of_core(mesh.corners(*nodes), now(*nodes)));
    let layer_cell =
        |cell: &LayerCell| (cell.nodes, least_of_layer(cell, cell.rail.map(|node| targets[node as usize])));
    let is_bad = |(nodes, least): &([u32; 4], f64)| volume(now(*nodes)) <= *least;
    let bad_core = |cell: &[u32; 4]| near(cell).then(|| core(cell)).filter(is_bad);
    let bad_layer_cell = |cell: &LayerCell| near(&cell.nodes).then(|| layer_cell(cell)).filter(is_bad);
    let mut bad = parallel::flat_map(mesh.cells.len(), |cell| bad_core(&mesh.cells[cell]));
    bad.extend(parallel::flat_map(layer.len(), |cell| bad_layer_cell(&layer[cell])));
    let free = |node: u32| targets[node as usize] != mesh.points[node as usize];
    let led = |(node, step): (u32, Vec3)| (constraint.lead(node), step);
    parallel::flat_map(bad.len(), |cell| {
        let (nodes, least) = bad[cell];
        least_moves(nodes, now(nodes), AIM * least, free, constraint).into_iter().map(led)
    })
}

/// The least moves of the nodes that are `free` which together give the cell the volume `aim`, mm3, to first order.
fn least_moves(
    nodes: [u32; 4],
    [a, b, c, d]: [Vec3; 4],
    aim: f64,
    free: impl Fn(u32) -> bool,
    constraint: &PeriodicConstraint,
) -> Vec<(u32, Vec3)> {
    let gradients =
        [(c - b).cross(&(d - b)) * -1.0, (c - a).cross(&(d - a)), (d - a).cross(&(b - a)), (b - a).cross(&(c - a))];
    let moves = nodes.into_iter().zip(gradients).filter(|(node, _)| free(*node));
    let moves: Vec<(u32, Vec3)> = moves.map(|(node, step)| (node, constraint.flat(node).along(&step))).collect();
    // Volume is a sixth of node times gradient.
    let gain = 6.0 * (aim - volume([a, b, c, d])) / moves.iter().map(|(_, step)| step.norm_squared()).sum::<f64>();
    moves.into_iter().map(|(node, step)| (node, step * gain)).filter(|(_, step)| step.norm() > 0.0).collect()
}

/// Share of its displacement that a node keeps at each step back.
const STEP_BACK: f64 = 0.7;
/// Steps back before a node stays where it is: 0.7^10 is 3 %.
const STEPS: u8 = 10;

/// Steps back of every node.
struct StepsBack(Vec<u8>);

impl StepsBack {
    /// The node's position between the old one and its target.
    fn position(&self, node: u32, from: &Vec3, target: &Vec3) -> Vec3 {
        match self.0[node as usize] {
            0 => *target,
            STEPS => *from,
            steps => from + (target - from) * (0..steps).fold(1.0, |share, _| share * STEP_BACK),
        }
    }

    /// The node does not move.
    fn is_pinched(&self, node: u32) -> bool {
        self.0[node as usize] == STEPS
    }
}

/// Positions between `mesh`'s points and `targets` at which all its cells and `layer`'s keep a positive volume, but for those on
/// rails whose ends are one; tied nodes step back together.
pub(super) fn step_back(
    mesh: &TetMesh,
    targets: &[Vec3],
    layer: &[LayerCell],
    constraint: &PeriodicConstraint,
) -> Vec<Vec3> {
    let moves = |node: u32| targets[node as usize] != mesh.points[node as usize] && !constraint.is_pinned(node);
    let mut back = StepsBack((0..targets.len() as u32).map(|node| if moves(node) { 0 } else { STEPS }).collect());
    let moving = |cell: &[u32; 4]| cell.iter().any(|&node| moves(node));
    loop {
        let position = |node: u32| back.position(node, &mesh.points[node as usize], &targets[node as usize]);
        let worse = |cell: &[u32; 4]| {
            let (before, now) = (mesh.corners(*cell), cell.map(&position));
            let fine = volume(now) > least_of_core(before, now);
            !fine
        };
        let fallen = |cell: &LayerCell| {
            let least = least_of_layer(cell, cell.rail.map(position));
            let fine = back.is_pinched(cell.rail[0]) || volume(cell.nodes.map(position)) > least;
            !fine
        };
        let mut bad = parallel::pick(&mesh.cells, |cell| moving(cell) && worse(cell)).into_flattened();
        bad.extend(parallel::pick(layer, fallen).iter().flat_map(|cell| cell.nodes));
        bad.iter_mut().for_each(|node| *node = constraint.lead(*node));
        bad.par_sort_unstable();
        bad.dedup();
        bad.retain(|&node| !back.is_pinched(node));
        if bad.is_empty() {
            return parallel::map_short(targets.len(), |node| position(node as u32));
        }
        bad.iter().for_each(|&node| back.0[node as usize] += 1);
        constraint.share(&mut back.0);
    }
}

/// A cell of the aggregate may lose all but this share of its shape (volume over mean edge cubed).
const KEPT_SHAPE: f64 = 0.03;
/// A rail stands at least this high over its triangle, as a share of its length: 1 degree.
const UPRIGHT: f64 = 0.02;

/// The least volume of a cell of the aggregate that was at `before` and is at `now`, mm3.
pub(super) fn least_of_core(before: [Vec3; 4], now: [Vec3; 4]) -> f64 {
    KEPT_SHAPE * volume(before) * (size(now) / size(before))
}

/// The least volume of a cell of the layer whose rail ends at `rail`, mm3.
pub(super) fn least_of_layer(cell: &LayerCell, rail: [Vec3; 2]) -> f64 {
    UPRIGHT * cell.area * (rail[0] - rail[1]).norm() / 3.0
}

/// The cube of the edges' quadratic mean but for a factor, mm3.
pub(super) fn size(p: [Vec3; 4]) -> f64 {
    let squares: f64 = (0..4).map(|i| (0..i).map(|j| (p[i] - p[j]).norm_squared()).sum::<f64>()).sum();
    squares * squares.sqrt()
}
