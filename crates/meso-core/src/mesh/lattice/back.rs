//! Interface nodes that lie off their grain go back onto it, wherever they find a place there.
//!
//! Where a grain comes close to the specimen's side the cut keeps its distance from that ([`crossing`](super::cut)), and
//! [`mend`] lets nodes off their grain. Once that is done, these nodes look around for a place on the grain: first for one
//! that leaves the angles as they should be, then for one at which the nodes around can make room for it. What finds none
//! goes as near as it may ([`finish`](super::finish) tries other ways then).

use super::fit::Fit;
use super::mend::{better, ways};
use super::roles::Role;
use super::star::{Star, sharpness_of};
use super::surface::Surface;
use super::twins;
use crate::math::Vec3;
use crate::mesh::NO_AGGREGATE;
use rayon::prelude::*;

/// Turns of all nodes; each one profits from the room that the one before made.
const TURNS: usize = 2;
/// How far around the node places on the grain are looked for, in elements.
const REACHES: [f64; 4] = [0.15, 0.3, 0.5, 0.8];
/// At so many places other nodes are asked to make room, those with the bluntest cells: more of them free hardly any
/// node (24 in place of 4: 29 and 27 of 437 stay off in a 75 mm cube, at ten times the cost).
const ASKED: usize = 4;
/// The same for nodes with images, of which there are few, and which get no other cells.
const ASKED_WITH_IMAGES: usize = 24;
/// They lie this far apart, in elements.
const APART: f64 = 0.1;
/// Turns of the nodes that make room, and the most of what is lacking that each may leave.
const PUSHES: usize = 8;
const LEFT: f64 = 0.8;
/// Parts of the way to the nearest place that are tried where no place on the grain will do.
const PARTS: [f64; 3] = [0.9, 0.6, 0.3];

/// Brings those of `nodes` back that are off; returns the ones that still are, ascending.
///
/// That leaves all angles above `least_deg`, or as they were.
pub(super) fn back(fit: &Fit, nodes: Vec<u32>, least_deg: f64) -> Vec<u32> {
    let mut off: Vec<u32> = nodes.into_par_iter().filter(|&node| is_off(fit, node)).collect();
    off.sort_unstable();
    off.dedup();
    for _ in 0..TURNS {
        let before = off.len();
        off.retain(|&node| is_off(fit, node) && !returns(fit, node, sharpness_of(least_deg)));
        if off.len() == before {
            break;
        }
    }
    off
}

/// Whether the node should lie on a grain, and does not.
fn is_off(fit: &Fit, node: u32) -> bool {
    let x = fit.places.get(node);
    match fit.roles[node as usize] {
        Role::Surface(grain) => !fit.surfaces[grain as usize].has(&x),
        Role::Contact => !grains(&fit.star(node), Role::Contact).iter().any(|&g| fit.surfaces[g as usize].has(&x)),
        Role::Twin(_) => twins::is_off(fit, node, &x),
        Role::Fixed | Role::Skin(_) | Role::Free => false,
    }
}

/// The grains on which a node may lie.
fn grains(star: &Star, role: Role) -> Vec<u32> {
    match role {
        Role::Surface(grain) => vec![grain],
        _ => {
            let mut grains: Vec<u32> = star.grains().filter(|grain| *grain != NO_AGGREGATE).collect();
            grains.sort_unstable();
            grains.dedup();
            grains
        }
    }
}

/// Whether the node finds a place on its grain; if not, it goes as near as it may.
fn returns(fit: &Fit, node: u32, limit: f64) -> bool {
    let mut star = fit.star(node);
    let limit = limit.max(star.sharpest_first());
    let x = star.centre;
    let on_grain = |grain: u32| places(&fit.surfaces[grain as usize], &x, fit.size);
    let mut places: Vec<Vec3> = match fit.roles[node as usize] {
        Role::Twin(axes) => twins::places(fit, node, axes, &REACHES),
        role => grains(&star, role).into_iter().flat_map(on_grain).collect(),
    };
    places.sort_by(|a, b| (a - x).norm_squared().total_cmp(&(b - x).norm_squared()));
    if let Some(place) = places.iter().find(|place| star.worst(place, limit) <= limit) {
        fit.go(node, place);
        return true;
    }
    let asked = if matches!(fit.roles[node as usize], Role::Twin(_)) { ASKED_WITH_IMAGES } else { ASKED };
    if bluntest(&star, &places, APART * fit.size, asked).iter().any(|place| makes_room(fit, node, place, limit)) {
        return true;
    }
    let nearer = |part: f64| places.first().map(|foot| x + (foot - x) * part);
    let may = |place: &Vec3| star.worst(place, limit) <= limit && twins::keep(fit, node, place);
    if let Some(place) = PARTS.into_iter().filter_map(nearer).find(may) {
        fit.go(node, &place);
    }
    false
}

/// Places on the surface around `x`: its own feet, those of points around it, and edges and corners.
fn places(surface: &Surface, x: &Vec3, size: f64) -> Vec<Vec3> {
    let mut places = Vec::new();
    surface.feet_near(x, size, |foot| places.push(foot));
    surface.features_near(x, size, |place| places.push(place));
    for reach in REACHES {
        for way in ways() {
            surface.feet_near(&(x + way * (reach * size)), size, |foot| places.push(foot));
        }
    }
    places
}

/// The sharpness of cells that turn over.
const TURNED: f64 = 2.0;

/// At most so many places that leave the bluntest cells, if none turns over, `apart` mm from each other.
fn bluntest(star: &Star, places: &[Vec3], apart: f64, most: usize) -> Vec<Vec3> {
    let mut all: Vec<(f64, Vec3)> = places.iter().map(|place| (star.worst(place, TURNED), *place)).collect();
    all.retain(|(worst, _)| *worst < TURNED);
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    chosen(all.into_iter().map(|(_, place)| place), apart, most)
}

/// At most so many places around `node` on its grains, `apart` mm from each other: those with the bluntest cells first, then
/// the nearest, even where cells turn over.
pub(super) fn places_apart(fit: &Fit, node: u32, apart: f64, most: usize) -> Vec<Vec3> {
    let star = fit.star(node);
    let on_grain = |grain: u32| places(&fit.surfaces[grain as usize], &star.centre, fit.size);
    let judged = |place: Vec3| (star.worst(&place, TURNED), (place - star.centre).norm(), place);
    let mut all: Vec<(f64, f64, Vec3)> =
        grains(&star, fit.roles[node as usize]).into_iter().flat_map(on_grain).map(judged).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    chosen(all.into_iter().map(|(.., place)| place), apart, most)
}

/// The first of `places`, at most so many, that are `apart` from each other.
fn chosen(places: impl Iterator<Item = Vec3>, apart: f64, most: usize) -> Vec<Vec3> {
    let mut chosen: Vec<Vec3> = Vec::new();
    for place in places {
        if chosen.len() < most && chosen.iter().all(|other| (other - place).norm() > apart) {
            chosen.push(place);
        }
    }
    chosen
}

/// Puts the node at `place` and lets the nodes around make room for it; where that does not do, all go back.
fn makes_room(fit: &Fit, node: u32, place: &Vec3, limit: f64) -> bool {
    let mut moved = vec![(node, fit.places.get(node))];
    fit.go(node, place);
    let mut cells: Vec<u32> = fit.cells_around(node).collect();
    let mut allowed = f64::INFINITY;
    for _ in 0..PUSHES {
        cells.retain(|&cell| fit.sharpness(cell) > limit);
        let lacking = cells.iter().map(|&cell| fit.sharpness(cell) - limit).fold(0.0, f64::max);
        if cells.is_empty() {
            return true;
        }
        if lacking > allowed {
            break;
        }
        allowed = LEFT * lacking;
        cells = push(fit, node, &cells, &mut moved);
    }
    moved.into_iter().rev().for_each(|(node, from)| fit.go(node, &from));
    false
}

/// Moves the nodes of `cells` to better places, but for others that are off their grain: they would go farther off. Notes
/// where they were in `moved`, and returns the cells around them.
fn push(fit: &Fit, node: u32, cells: &[u32], moved: &mut Vec<(u32, Vec3)>) -> Vec<u32> {
    let mut nodes: Vec<u32> = cells.iter().flat_map(|&cell| fit.mesh.cells[cell as usize]).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes.retain(|&other| other == node || !is_off(fit, other));
    for &other in &nodes {
        let from = fit.places.get(other);
        if better(fit, other, false) {
            moved.push((other, from));
        }
    }
    let mut around: Vec<u32> =
        nodes.iter().flat_map(|&node| fit.cells_around(node)).chain(cells.iter().copied()).collect();
    around.sort_unstable();
    around.dedup();
    around
}
