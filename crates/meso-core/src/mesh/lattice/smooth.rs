//! Nodes with sharp angles around them move to better these.

use super::fit::{Fit, GUARD_DEG};
use super::roles::Role;
use super::skin::Slope;
use super::slide::lies_on;
use super::star::{Star, sharpness_of};
use super::twins;
use crate::math::Vec3;

/// Nodes whose worst angle is below this are moved to better it, degrees.
const POOR_DEG: f64 = 22.0;
/// Least gain in sharpness that is worth a move.
const GAIN: f64 = 2e-3;
/// First step along an axis, in elements; shorter by round.
const REACH: f64 = 0.15;

/// Whether the sharpness around a node is to be bettered; closed gaps move only for angles below the guard.
pub(super) fn is_poor(role: Role, sharpness: f64) -> bool {
    sharpness > sharpness_of(if role == Role::Contact { GUARD_DEG } else { POOR_DEG })
}

/// A place that betters the worst angle, whose sharpness is `before`; surface nodes stay on their face and lose no volume.
pub(super) fn smooth(fit: &Fit, star: &Star, role: Role, before: f64, round: usize) -> Option<Vec3> {
    let gain = match role {
        Role::Surface(grain) => star.gain(|label| f64::from(u8::from(label == grain))),
        _ => Vec3::zeros(),
    };
    let track = Track::of(fit, star, role);
    let reach = REACH * fit.size / (1 + round) as f64;
    let towards = (star.mean() - star.centre) * 0.5;
    let around = (0..6).map(|i| Vec3::from_fn(|axis, _| if axis == i / 2 { [reach, -reach][i % 2] } else { 0.0 }));
    let mut best = (before - GAIN, None);
    for step in std::iter::once(towards).chain(around) {
        let Some(place) = track.after(fit, &star.centre, &step) else { continue };
        if gain.dot(&(place - star.centre)) < 0.0 || track.rises(&(place - star.centre)) {
            continue;
        }
        let worst = star.worst(&place, best.0);
        if worst < best.0 {
            best = (worst, Some(place));
        }
    }
    best.1
}

/// What a node keeps to when it moves.
#[derive(Clone, Copy)]
pub(super) enum Track {
    /// Its place.
    Still,
    /// The faces it lies on of this grain.
    Along(u32),
    /// The specimen's own surface.
    Slope(Slope),
    /// The sides across these axes, together with the images of this node.
    Twin(u32, [bool; 3]),
    /// Nothing.
    Anywhere,
}

impl Track {
    /// The track of a node by its role.
    pub(super) fn of(fit: &Fit, star: &Star, role: Role) -> Self {
        match role {
            // Those with images have tracks of their own: the role does not tell which node it is.
            Role::Fixed | Role::Twin(_) => Self::Still,
            Role::Free => Self::Anywhere,
            Role::Skin(hold) => Self::Slope(Slope::of(star, hold)),
            Role::Surface(grain) if fit.surfaces[grain as usize].has(&star.centre) => Self::Along(grain),
            Role::Surface(_) => Self::Anywhere,
            Role::Contact => lies_on(fit, star).map_or(Self::Anywhere, Self::Along),
        }
    }

    /// `x` after the part of `step` that the track allows.
    pub(super) fn after(self, fit: &Fit, x: &Vec3, step: &Vec3) -> Option<Vec3> {
        match self {
            Self::Still => None,
            Self::Along(grain) => fit.surfaces[grain as usize].along_face(x, step),
            Self::Slope(slope) => slope.after(fit.skin, x, step, fit.size),
            Self::Twin(node, axes) => twins::after(fit, node, axes, step),
            Self::Anywhere => Some(x + step),
        }
    }

    /// The track of a node that is let off all surfaces but the specimen's flat sides; those with images stay on theirs.
    pub(super) fn released(self) -> Self {
        match self {
            Self::Slope(slope) => Self::Slope(slope.released()),
            Self::Twin(..) => self,
            _ => Self::Anywhere,
        }
    }

    /// Whether a move crosses an edge of the specimen's surface.
    fn rises(&self, step: &Vec3) -> bool {
        matches!(self, Self::Slope(slope) if slope.rises(step))
    }
}
