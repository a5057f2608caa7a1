//! The move of one node: onto the features of its body, and to larger angles.

use super::boundary::BoundaryTrack;
use super::nodes::{Exact, Nodes, Role, paired_after};
use super::surface::{Foothold, Surface};
use crate::cells::NO_BODY;
use crate::tet::{self, Constraint, Star, best_position, cos2_of, directions};
use meso_collision::math::Vec3;
use meso_concrete::stop;

/// The smallest dihedral angle that a move may leave, degrees.
pub(super) const GUARD_DEG: f64 = 10.0;
/// How far away edges and corners are looked for, in elements.
const FEATURE_REACH: f64 = 0.7;
/// Least gain of six times the volume, in elements' cubes.
const LEAST: f64 = 1e-6;
/// Steps along a face that are tried for bodies that lack volume, in elements.
const FACE_STEPS: [f64; 2] = [0.4, 0.2];
/// At a closed gap, how much a volume of another body counts beside one of the body that the node lies on: most of it is
/// gap. With this and [`DEFICIT`] the volumes of bodies and mortar balance best (to 0.05 % at 2 mm).
const OTHERS: f64 = -0.5;
/// There, how much a volume counts of a body that lacks some.
const DEFICIT: f64 = 2.0;
/// Nodes whose worst angle is below this are smoothed, degrees.
const POOR_DEG: f64 = 22.0;
/// Measures of one cell differ by less, whatever the order of its corners.
const ROUNDING: f64 = 1e-4;
/// Least gain in the worst cell's measure that is worth a move.
const GAIN: f64 = 2e-3;
/// First step along an axis, in elements; shorter by round.
const SMOOTHING_REACH: f64 = 0.15;

/// Feature snapping: a surface's node that is off it goes onto it, another to the position on its body's edges and corners that
/// gains most volume. Angles above the guard stay above it, others get no worse. `deficits` are the bodies', -1 to 1.
pub(super) fn snapped(exact: &Exact, deficits: &[f64], star: &mut Star, role: Role) -> Option<Vec3> {
    let x = &star.centre;
    let surface = |body: u32| &exact.surfaces[body as usize];
    let mut positions = Vec::new();
    match role {
        Role::Surface(body) if surface(body).has(x) => {
            let gain = star.gain(|owner| f64::from(u8::from(owner == body)));
            gaining(exact, surface(body), x, &gain, &mut positions);
            if deficits[body as usize] > 0.0 {
                along_face(exact, surface(body), x, &gain, &mut positions);
            }
        }
        Role::Surface(body) => returning(exact, surface(body), x, &mut positions),
        Role::Contact => {
            let own = body_under(exact, star)?;
            let gain = star.gain(|owner| worth(deficits, own, owner));
            gaining(exact, surface(own), x, &gain, &mut positions);
        }
        Role::Boundary(hold) => {
            positions = BoundaryTrack::of(star, hold).positions(exact.boundary, star, exact.size);
        }
        Role::Fixed | Role::Paired(_) | Role::Free => {}
    }
    if positions.is_empty() {
        return None;
    }
    positions.sort_by(|a, b| b.0.total_cmp(&a.0));
    let limit = cos2_of(GUARD_DEG).max(star.worst_first());
    positions.into_iter().map(|(_, position)| position).find(|position| star.worst(position, limit) <= limit)
}

/// How much a volume of `owner` counts where the node lies on the body `own` and touches others.
fn worth(deficits: &[f64], own: u32, owner: u32) -> f64 {
    match owner {
        NO_BODY => 0.0,
        _ if owner == own => 1.0 + DEFICIT * deficits[owner as usize],
        _ => OTHERS + DEFICIT * deficits[owner as usize],
    }
}

/// The positions on edges and corners that gain volume, with the gain.
fn gaining(exact: &Exact, surface: &Surface, x: &Vec3, gain: &Vec3, positions: &mut Vec<(f64, Vec3)>) {
    let reach = FEATURE_REACH * exact.size;
    surface.features_near(x, reach, |position| add_gain(exact, x, gain, position, positions));
}

/// Positions on the same faces, in the direction that gains volume.
fn along_face(exact: &Exact, surface: &Surface, x: &Vec3, gain: &Vec3, positions: &mut Vec<(f64, Vec3)>) {
    let Some(direction) = gain.try_normalize(LEAST * exact.size * exact.size) else { return };
    let foothold = surface.foothold(x);
    for step in FACE_STEPS {
        if let Some(position) = foothold.after(&(direction * step * exact.size)) {
            add_gain(exact, x, gain, position, positions);
        }
    }
}

fn add_gain(exact: &Exact, x: &Vec3, gain: &Vec3, position: Vec3, positions: &mut Vec<(f64, Vec3)>) {
    let gained = gain.dot(&(position - x));
    if gained > LEAST * exact.size * exact.size * exact.size {
        positions.push((gained, position));
    }
}

/// The positions on the surface near a node that is off it, the nearest the best.
fn returning(exact: &Exact, surface: &Surface, x: &Vec3, positions: &mut Vec<(f64, Vec3)>) {
    let mut add = |position: Vec3| positions.push((-(position - x).norm_squared(), position));
    surface.feet_near(x, exact.size, &mut add);
    surface.features_near(x, exact.size, &mut add);
}

/// The one body of the star on whose surface the node lies.
fn body_under(exact: &Exact, star: &Star) -> Option<u32> {
    let mut own = None;
    let mut last = NO_BODY;
    for body in star.owners().filter(|owner| *owner != NO_BODY) {
        // The owners of neighbours in the list are mostly the same.
        if body != last && own != Some(body) && exact.surfaces[body as usize].has(&star.centre) {
            if own.is_some() {
                return None;
            }
            own = Some(body);
        }
        last = body;
    }
    own
}

/// Whether the cells around a node are poor, the worst being `cos2`; closed gaps move only for angles below the guard.
pub(super) fn is_poor(role: Role, cos2: f64) -> bool {
    cos2 > poor(role)
}

/// The measure below which a cell is not poor, whatever its precision and the order of its corners.
pub(super) fn clearly_fine(role: Role) -> f64 {
    poor(role) - ROUNDING
}

/// The measure below which a cell is above the guard, whatever its precision and the order of its corners.
pub(super) fn surely_guarded() -> f64 {
    cos2_of(GUARD_DEG) - ROUNDING
}

/// The measure above which the cells around a node are poor.
fn poor(role: Role) -> f64 {
    cos2_of(if role == Role::Contact { GUARD_DEG } else { POOR_DEG })
}

/// Smoothing: a position that betters the worst cell, which is `before`; surface nodes stay on their face and lose no volume.
pub(super) fn smoothed(exact: &Exact, star: &Star, role: Role, before: f64, round: usize) -> Option<Vec3> {
    let gain = match role {
        Role::Surface(body) => star.gain(|owner| f64::from(u8::from(owner == body))),
        _ => Vec3::zeros(),
    };
    let track = Track::of(exact, star, role);
    let reach = SMOOTHING_REACH * exact.size / (1 + round) as f64;
    let towards = (star.mean() - star.centre) * 0.5;
    let around = (0..6).map(|i| Vec3::from_fn(|axis, _| if axis == i / 2 { [reach, -reach][i % 2] } else { 0.0 }));
    let reached = std::iter::once(towards).chain(around).filter_map(|step| track.after(exact, &star.centre, &step));
    let allowed = reached.filter(|position| {
        let step = position - star.centre;
        let loses = gain.dot(&step) < 0.0;
        !loses && !track.rises(&step)
    });
    best_position(before - GAIN, allowed, |x, limit| star.worst(x, limit)).map(|(_, position)| position)
}

/// Constraint of a node that moves by itself.
pub(super) enum Track<'a> {
    /// It stays where it is.
    Still,
    /// The faces it lies on of a body.
    Along(Foothold<'a>),
    /// The specimen's own surface.
    Boundary(BoundaryTrack),
    /// Nothing.
    Anywhere,
}

impl<'a> Track<'a> {
    /// The track of a node by its role; those with images have none of their own.
    pub(super) fn of(exact: &Exact<'a>, star: &Star, role: Role) -> Self {
        let along = |body: u32| Self::Along(exact.surfaces[body as usize].foothold(&star.centre));
        match role {
            Role::Fixed | Role::Paired(_) => Self::Still,
            Role::Free => Self::Anywhere,
            Role::Boundary(hold) => Self::Boundary(BoundaryTrack::of(star, hold)),
            Role::Surface(body) if exact.surfaces[body as usize].has(&star.centre) => along(body),
            Role::Surface(_) => Self::Anywhere,
            Role::Contact => body_under(exact, star).map_or(Self::Anywhere, along),
        }
    }

    /// The node's own position `x` after the part of `step` that the track allows.
    pub(super) fn after(&self, exact: &Exact, x: &Vec3, step: &Vec3) -> Option<Vec3> {
        match self {
            Self::Still => None,
            Self::Along(foothold) => foothold.after(step),
            Self::Boundary(track) => track.after(exact.boundary, x, step, exact.size),
            Self::Anywhere => Some(x + step),
        }
    }

    /// The track of a node that is let off all surfaces but the specimen's flat sides.
    pub(super) fn released(self) -> Self {
        match self {
            Self::Boundary(track) => Self::Boundary(track.released()),
            _ => Self::Anywhere,
        }
    }

    /// Whether a move crosses an edge of the specimen's surface.
    fn rises(&self, step: &Vec3) -> bool {
        matches!(self, Self::Boundary(track) if track.rises(step))
    }
}

/// Lengths of the steps tried, in elements.
const STEPS: [f64; 4] = [0.3, 0.1, 0.03, 0.01];

/// Constraint of a node of a mesh under repair.
enum Keeps<'a> {
    Track(&'a Exact<'a>, Track<'a>),
    /// The sides across these axes, together with the images of this node.
    Paired(&'a Nodes<'a>, u32, [bool; 3]),
}

impl Constraint for Keeps<'_> {
    /// Steps are in elements.
    fn reachable(&self, x: &Vec3, step: f64) -> Vec<Vec3> {
        let after = |direction: Vec3| match self {
            Self::Track(exact, track) => track.after(exact, x, &(direction * step * exact.size)),
            Self::Paired(nodes, node, axes) => {
                paired_after(nodes, *node, *axes, &(direction * step * nodes.exact.size))
            }
        };
        directions().filter_map(after).collect()
    }
}

/// Moves the node to the best position around it, `released` from its surface or not; false where it is there already.
pub(super) fn smooth(nodes: &mut Nodes, node: u32, released: bool) -> bool {
    stop::point();
    let position = better(nodes, node, released);
    position.iter().for_each(|position| nodes.move_to(node, position));
    position.is_some()
}

fn better(nodes: &Nodes, node: u32, released: bool) -> Option<Vec3> {
    let role = nodes.role(node);
    if role == Role::Fixed || nodes.cells(node).is_empty() {
        return None;
    }
    let mut star = nodes.star(node);
    let keeps = match role {
        Role::Paired(axes) => Keeps::Paired(nodes, node, axes),
        _ => {
            let track = Track::of(nodes.exact, &star, role);
            Keeps::Track(nodes.exact, if released { track.released() } else { track })
        }
    };
    let before = star.worst_first();
    tet::smoothed(&keeps, &star.centre, STEPS, before, |x, limit| star.worst(x, limit))
}
