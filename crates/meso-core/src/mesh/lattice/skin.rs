//! Nodes on the specimen's own surface: on its flat sides, where the lattice ends, and on its [`Outline`].

use super::outline::Outline;
use super::star::Star;
use crate::math::Vec3;

/// What holds the nodes on the specimen's surface.
pub(super) struct Skin<'a> {
    /// The surface where it is not the lattice's box, and which nodes lie on it.
    pub(super) outline: Option<(&'a Outline<'a>, Vec<bool>)>,
    /// The axes along which the specimen repeats itself: nodes on the sides across these stay where they are.
    pub(super) repeats: [bool; 3],
}

impl Skin<'_> {
    /// What holds node number `node`, which lies on the box's sides across `axes`.
    pub(super) fn hold(&self, node: usize, axes: [bool; 3]) -> Option<Hold> {
        let outer = self.outline.as_ref().is_some_and(|(_, outer)| outer[node]);
        (outer || axes.contains(&true)).then_some(Hold { axes, outer })
    }

    /// Whether a node held like this stays where it is.
    pub(super) fn fixes(&self, hold: Hold) -> bool {
        (0..3).any(|axis| hold.axes[axis] && self.repeats[axis])
    }

    /// Whether the specimen ends at a side across one of `axes`.
    pub(super) fn ends(&self, axes: [bool; 3]) -> bool {
        (0..3).any(|axis| axes[axis] && !self.repeats[axis])
    }
}

/// Which coordinates a node keeps, since it lies on a flat side across that axis, and whether it lies on the outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Hold {
    pub(super) axes: [bool; 3],
    pub(super) outer: bool,
}

/// How far from a moved node the outline is looked for, in elements.
const REACH: f64 = 0.3;
/// A node off the outline looks for it this far, in elements.
const RETURN: f64 = 0.6;
/// How far away edges of the outline are looked for, in elements.
const EDGE: f64 = 0.7;
/// Least gain of six times the volume where a node takes an edge in, in elements' cubes.
const LEAST: f64 = 1e-6;
/// A node that moves on the outline stays on its side of an edge: sine of the most that it may rise.
const RISE: f64 = 0.05;

/// A node's way along the specimen's surface.
#[derive(Clone, Copy)]
pub(super) struct Slope {
    axes: [bool; 3],
    /// Out of the specimen, without what the flat sides forbid; `None` for a node that has not to keep to the outline.
    outwards: Option<Vec3>,
}

impl Slope {
    pub(super) fn of(star: &Star, hold: Hold) -> Self {
        let free = Self { axes: hold.axes, outwards: None };
        // What all of the star's tetrahedra gain by a move is what the specimen gains.
        let outwards = free.allowed(&star.gain(|_| 1.0)).try_normalize(0.0).filter(|_| hold.outer);
        Self { outwards, ..free }
    }

    /// Let off the outline, but not off the flat sides.
    pub(super) fn released(self) -> Self {
        Self { outwards: None, ..self }
    }

    /// `x` after the part of `step` that the surface allows, with elements of `size` mm.
    pub(super) fn after(&self, skin: &Skin, x: &Vec3, step: &Vec3, size: f64) -> Option<Vec3> {
        let place = x + self.allowed(step);
        match (&self.outwards, &skin.outline) {
            (Some(outwards), Some((outline, _))) => outline.along(&place, outwards, REACH * size),
            _ => Some(place),
        }
    }

    /// Whether a move leaves the outline's faces for an edge, or an edge for a face.
    pub(super) fn rises(&self, step: &Vec3) -> bool {
        self.outwards.is_some_and(|outwards| outwards.dot(step).abs() > RISE * step.norm())
    }

    /// Places that bring the specimen's volume nearer, with what they bring: onto the outline for a node off it, else
    /// onto its edges.
    pub(super) fn places(&self, skin: &Skin, star: &Star, size: f64) -> Vec<(f64, Vec3)> {
        let x = &star.centre;
        let (Some(outwards), Some((outline, _))) = (&self.outwards, &skin.outline) else { return Vec::new() };
        if !outline.has(x, outwards) {
            return outline.along(x, outwards, RETURN * size).map(|place| (0.0, place)).into_iter().collect();
        }
        let gain = star.gain(|_| 1.0);
        let mut places = Vec::new();
        outline.edges_near(x, EDGE * size, |place, stands_out| {
            let step = place - x;
            let gained = stands_out * gain.dot(&step);
            let leaves = (0..3).any(|axis| self.axes[axis] && step[axis].abs() > 1e-9 * size);
            if gained > LEAST * size * size * size && !leaves {
                places.push((gained, x + self.allowed(&step)));
            }
        });
        places
    }

    fn allowed(&self, step: &Vec3) -> Vec3 {
        Vec3::from_fn(|axis, _| if self.axes[axis] { 0.0 } else { step[axis] })
    }
}
