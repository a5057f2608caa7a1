//! Interface nodes slide along their grain to where the mesh has more of what it should have.

use super::fit::{Fit, GUARD_DEG};
use super::roles::Role;
use super::skin::Slope;
use super::star::{Star, sharpness_of};
use super::surface::Surface;
use crate::math::Vec3;
use crate::mesh::NO_AGGREGATE;

/// How far away edges and corners are looked for, in elements.
const REACH: f64 = 0.7;
/// Least gain of six times the volume, in elements' cubes.
const LEAST: f64 = 1e-6;
/// Steps along a face that are tried for grains that lack volume, in elements.
const STEPS: [f64; 2] = [0.4, 0.2];
/// At a closed gap, what a volume of another grain counts beside one of the grain that the node lies on: most of it is
/// gap. With this and [`LACKING`] the volumes of grains and mortar balance best (to 0.05 % at 2 mm).
const OTHERS: f64 = -0.5;
/// There, what a volume counts of a grain that lacks some.
const LACKING: f64 = 2.0;

/// Where the node goes: a surface's node that is off it, onto it; else to the place on the grain's edges and corners
/// that gains most. Angles above the guard stay above it, others get no worse.
pub(super) fn slide(fit: &Fit, star: &mut Star, role: Role) -> Option<Vec3> {
    let x = &star.centre;
    let mut places = Vec::new();
    match role {
        Role::Surface(grain) if fit.surfaces[grain as usize].has(x) => {
            let gain = star.gain(|label| f64::from(u8::from(label == grain)));
            gaining(fit, &fit.surfaces[grain as usize], x, &gain, &mut places);
            if fit.lacks[grain as usize] > 0.0 {
                along_face(fit, &fit.surfaces[grain as usize], x, &gain, &mut places);
            }
        }
        Role::Surface(grain) => returns(fit, &fit.surfaces[grain as usize], x, &mut places),
        Role::Contact => {
            let own = lies_on(fit, star)?;
            let gain = star.gain(|label| worth(fit, own, label));
            gaining(fit, &fit.surfaces[own as usize], x, &gain, &mut places);
        }
        Role::Skin(hold) => {
            places = Slope::of(star, hold).places(fit.skin, star, fit.size);
        }
        Role::Fixed | Role::Twin(_) | Role::Free => {}
    }
    if places.is_empty() {
        return None;
    }
    places.sort_by(|a, b| b.0.total_cmp(&a.0));
    let limit = sharpness_of(GUARD_DEG).max(star.sharpest_first());
    places.into_iter().map(|(_, place)| place).find(|place| star.worst(place, limit) <= limit)
}

/// What a volume of `label` counts where the node lies on the grain `own` and touches others.
fn worth(fit: &Fit, own: u32, label: u32) -> f64 {
    match label {
        NO_AGGREGATE => 0.0,
        _ if label == own => 1.0 + LACKING * fit.lacks[label as usize],
        _ => OTHERS + LACKING * fit.lacks[label as usize],
    }
}

/// The places on edges and corners that gain volume, with what they gain.
fn gaining(fit: &Fit, surface: &Surface, x: &Vec3, gain: &Vec3, places: &mut Vec<(f64, Vec3)>) {
    surface.features_near(x, REACH * fit.size, |place| add_gain(fit, x, gain, place, places));
}

/// Places on the same faces, in the direction that gains volume.
fn along_face(fit: &Fit, surface: &Surface, x: &Vec3, gain: &Vec3, places: &mut Vec<(f64, Vec3)>) {
    let Some(way) = gain.try_normalize(LEAST * fit.size * fit.size) else { return };
    for step in STEPS {
        if let Some(place) = surface.along_face(x, &(way * step * fit.size)) {
            add_gain(fit, x, gain, place, places);
        }
    }
}

fn add_gain(fit: &Fit, x: &Vec3, gain: &Vec3, place: Vec3, places: &mut Vec<(f64, Vec3)>) {
    let gained = gain.dot(&(place - x));
    if gained > LEAST * fit.size * fit.size * fit.size {
        places.push((gained, place));
    }
}

/// The places on the surface near a node that is off it, the nearest the best.
fn returns(fit: &Fit, surface: &Surface, x: &Vec3, places: &mut Vec<(f64, Vec3)>) {
    let mut add = |place: Vec3| places.push((-(place - x).norm_squared(), place));
    surface.feet_near(x, fit.size, &mut add);
    surface.features_near(x, fit.size, &mut add);
}

/// The one grain of the star on whose surface the node lies.
pub(super) fn lies_on(fit: &Fit, star: &Star) -> Option<u32> {
    let mut own = None;
    let mut last = NO_AGGREGATE;
    for grain in star.grains().filter(|grain| *grain != NO_AGGREGATE) {
        // The grains of neighbours in the list are mostly the same.
        if grain != last && own != Some(grain) && fit.surfaces[grain as usize].has(&star.centre) {
            if own.is_some() {
                return None;
            }
            own = Some(grain);
        }
        last = grain;
    }
    own
}
