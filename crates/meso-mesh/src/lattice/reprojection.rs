//! Reprojection: interface nodes that lie off their body go back onto it, wherever they find a position there.
//!
//! Where a body comes close to the specimen's side the cut keeps its distance from that ([`crossing`](super::stencils)), and
//! the [`repair`](super::repair) lets nodes off their body. Once that is done, these nodes look for a position on the body: first
//! for one that leaves the angles as they should be, then for one at which the nodes around can make room for it. A node that
//! finds none goes as near as it may.
//!
//! At closed gaps a node may keep cells of a body that it does not lie on, when the cells of the one that it lies on have
//! gone to the mortar. These cells stand out of their body, or the mortar's into it: their label changes, and no angle.

use super::nodes::{Nodes, Role, paired_is_off, paired_positions, stays_on};
use super::smoothing::smooth;
use super::surface::Surface;
use crate::cells::NO_BODY;
use crate::tet::{INVERTED, Star, ascending, cos2_of, directions};
use meso_collision::math::Vec3;
use meso_concrete::parallel;
use meso_concrete::stop;

/// Turns of all nodes; each one profits from the room that the one before made.
const TURNS: usize = 2;
/// How far around the node positions on the body are looked for, in elements.
const REACHES: [f64; 4] = [0.15, 0.3, 0.5, 0.8];
/// At so many positions other nodes are asked to make room, those with the best cells: more of them free hardly any
/// node (24 in position of 4: 29 and 27 of 437 stay off in a 75 mm cube, at ten times the cost).
const ASKED: usize = 4;
/// Number of candidate positions for nodes with images, of which there are few, and which get no other cells.
const ASKED_WITH_IMAGES: usize = 24;
/// They lie this far apart, in elements.
const APART: f64 = 0.1;
/// Turns of the nodes that make room, and the largest share of the residual that each may leave.
const PUSHES: usize = 8;
const LEFT: f64 = 0.8;
/// Parts of the way to the nearest position that are tried where no position on the body will do.
const PARTS: [f64; 3] = [0.9, 0.6, 0.3];

/// Brings those of `suspects` back that are off; returns the ones that still are, ascending.
///
/// That leaves all angles above `least_deg`, or as they were.
pub(super) fn reproject(nodes: &mut Nodes, suspects: Vec<u32>, least_deg: f64) -> Vec<u32> {
    let mut off = ascending(parallel::pick(&suspects, |&node| is_off(nodes, node)));
    for _ in 0..TURNS {
        let before = off.len();
        off.retain(|&node| is_off(nodes, node) && !returns(nodes, node, cos2_of(least_deg)));
        if off.len() == before {
            break;
        }
    }
    off
}

/// Whether the node should lie on a body, and does not.
fn is_off(nodes: &Nodes, node: u32) -> bool {
    stop::point();
    let x = nodes.position(node);
    match nodes.role(node) {
        Role::Surface(body) => !nodes.surface(body).has(&x),
        Role::Contact => !bodies(&nodes.star(node), Role::Contact).iter().any(|&body| nodes.surface(body).has(&x)),
        Role::Paired(_) => paired_is_off(nodes, node, &x),
        Role::Fixed | Role::Boundary(_) | Role::Free => false,
    }
}

/// The bodies on which a node may lie.
fn bodies(star: &Star, role: Role) -> Vec<u32> {
    match role {
        Role::Surface(body) => vec![body],
        _ => {
            let mut bodies = ascending(star.owners());
            bodies.retain(|owner| *owner != NO_BODY);
            bodies
        }
    }
}

/// Whether the node finds a position on its body; if not, it goes as near as it may.
fn returns(nodes: &mut Nodes, node: u32, limit: f64) -> bool {
    let mut star = nodes.star(node);
    let limit = limit.max(star.worst_first());
    let x = star.centre;
    let on_body = |body: u32| positions(nodes.surface(body), &x, nodes.exact.size);
    let mut positions: Vec<Vec3> = match nodes.role(node) {
        Role::Paired(axes) => paired_positions(nodes, node, axes, &REACHES),
        role => bodies(&star, role).into_iter().flat_map(on_body).collect(),
    };
    positions.sort_by(|a, b| (a - x).norm_squared().total_cmp(&(b - x).norm_squared()));
    if let Some(position) = positions.iter().find(|position| star.worst(position, limit) <= limit) {
        nodes.move_to(node, position);
        return true;
    }
    let asked = if matches!(nodes.role(node), Role::Paired(_)) { ASKED_WITH_IMAGES } else { ASKED };
    let best = best_positions(&star, &positions, APART * nodes.exact.size, asked);
    if best.iter().any(|position| makes_room(nodes, node, position, limit)) {
        return true;
    }
    let nearer = |part: f64| positions.first().map(|foot| x + (foot - x) * part);
    let may = |position: &Vec3| star.worst(position, limit) <= limit && stays_on(nodes, node, position);
    if let Some(position) = PARTS.into_iter().filter_map(nearer).find(may) {
        nodes.move_to(node, &position);
    }
    false
}

/// Places on the surface around `x`: its own feet, those of points around it, and edges and corners.
fn positions(surface: &Surface, x: &Vec3, size: f64) -> Vec<Vec3> {
    let mut positions = Vec::new();
    surface.feet_near(x, size, |foot| positions.push(foot));
    surface.features_near(x, size, |position| positions.push(position));
    for reach in REACHES {
        for direction in directions() {
            surface.feet_near(&(x + direction * (reach * size)), size, |foot| positions.push(foot));
        }
    }
    positions
}

/// At most so many positions that leave the best cells, if none turns over, `apart` mm from each other.
fn best_positions(star: &Star, positions: &[Vec3], apart: f64, most: usize) -> Vec<Vec3> {
    let mut all: Vec<(f64, Vec3)> =
        positions.iter().map(|position| (star.worst(position, INVERTED), *position)).collect();
    all.retain(|(worst, _)| *worst < INVERTED);
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    chosen(all.into_iter().map(|(_, position)| position), apart, most)
}

/// At most so many positions around `node` on its bodies, `apart` mm from each other: those with the best cells first, then
/// the nearest, even where cells turn over.
pub(super) fn positions_apart(nodes: &Nodes, node: u32, apart: f64, most: usize) -> Vec<Vec3> {
    let star = nodes.star(node);
    let on_body = |body: u32| positions(nodes.surface(body), &star.centre, nodes.exact.size);
    let judged = |position: Vec3| (star.worst(&position, INVERTED), (position - star.centre).norm(), position);
    let mut all: Vec<(f64, f64, Vec3)> =
        bodies(&star, nodes.role(node)).into_iter().flat_map(on_body).map(judged).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    chosen(all.into_iter().map(|(.., position)| position), apart, most)
}

/// The first of `positions`, at most so many, that are `apart` from each other.
fn chosen(positions: impl Iterator<Item = Vec3>, apart: f64, most: usize) -> Vec<Vec3> {
    let mut chosen: Vec<Vec3> = Vec::new();
    for position in positions {
        if chosen.len() < most && chosen.iter().all(|other| (other - position).norm() > apart) {
            chosen.push(position);
        }
    }
    chosen
}

/// Puts the node at `position` and lets the nodes around make room for it; where that does not do, all go back.
fn makes_room(nodes: &mut Nodes, node: u32, position: &Vec3, limit: f64) -> bool {
    let mut moved = vec![(node, nodes.position(node))];
    nodes.move_to(node, position);
    let mut cells: Vec<u32> = nodes.cells_around(node).collect();
    let mut allowed = f64::INFINITY;
    for _ in 0..PUSHES {
        cells.retain(|&cell| nodes.mesh.cos2(cell) > limit);
        let lacking = cells.iter().map(|&cell| nodes.mesh.cos2(cell) - limit).fold(0.0, f64::max);
        if cells.is_empty() {
            return true;
        }
        if lacking > allowed {
            break;
        }
        allowed = LEFT * lacking;
        cells = push(nodes, node, &cells, &mut moved);
    }
    moved.into_iter().rev().for_each(|(node, from)| nodes.move_to(node, &from));
    false
}

/// Moves the nodes of `cells` to better positions, but for others that are off their body: they would go farther off. Notes
/// where they were in `moved`, and returns the cells around them.
fn push(nodes: &mut Nodes, node: u32, cells: &[u32], moved: &mut Vec<(u32, Vec3)>) -> Vec<u32> {
    let mut near = nodes.of_cells(cells);
    near.retain(|&other| other == node || !is_off(nodes, other));
    for &other in &near {
        let from = nodes.position(other);
        if smooth(nodes, other, false) {
            moved.push((other, from));
        }
    }
    let around = near.iter().flat_map(|&node| nodes.cells_around(node));
    ascending(around.chain(cells.iter().copied()))
}

/// Cells with the owner that they are to get, and the roles of their nodes after that.
pub(super) struct Relabelled {
    pub(super) cells: Vec<u32>,
    pub(super) owner: u32,
    pub(super) roles: Vec<(u32, Role)>,
}

/// A change of owners after which `node`, which lies off its bodies, has cells of one material, and no other node is off
/// that was not before. The mortar comes first.
pub(super) fn relabelled(nodes: &Nodes, node: u32) -> Option<Relabelled> {
    let lies_between = |node: u32| matches!(nodes.role(node), Role::Surface(_) | Role::Contact);
    if !lies_between(node) {
        return None;
    }
    nodes.owners(node).into_iter().rev().find_map(|owner| {
        let all = nodes.cells(node).iter().copied();
        let cells: Vec<u32> = all.filter(|&cell| nodes.mesh.owner[cell as usize] != owner).collect();
        let role = |&other: &u32| {
            let (now, then) = (nodes.owners(other), owners(nodes, other, &cells, owner));
            let fine = !lies_off(nodes, other, &then) || other != node && lies_off(nodes, other, &now);
            (lies_between(other) && fine).then_some((other, role_between(&then)))
        };
        let roles = nodes.of_cells(&cells).iter().map(role).collect::<Option<Vec<_>>>();
        roles.map(|roles| Relabelled { cells, owner, roles })
    })
}

/// The owners around a node once `changed` cells have `owner`, ascending.
fn owners(nodes: &Nodes, node: u32, changed: &[u32], owner: u32) -> Vec<u32> {
    let of = |cell: &u32| if changed.contains(cell) { owner } else { nodes.mesh.owner[*cell as usize] };
    ascending(nodes.cells(node).iter().map(of))
}

/// Whether a node between these owners' cells lies on none of the bodies.
fn lies_off(nodes: &Nodes, node: u32, owners: &[u32]) -> bool {
    let on = |owner: &u32| *owner != NO_BODY && nodes.surface(*owner).has(&nodes.position(node));
    owners.len() > 1 && !owners.iter().any(on)
}

fn role_between(owners: &[u32]) -> Role {
    match *owners {
        [_] => Role::Free,
        [body, NO_BODY] => Role::Surface(body),
        _ => Role::Contact,
    }
}
