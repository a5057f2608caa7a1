//! Dog-bones for tension tests: plates that narrow in round arcs to a neck in the middle of their length.
//!
//! The arcs are polygons with their corners on the arc, so that the specimen has planes alone and its volume is exact.

use super::box_minus_convex::BoxMinusConvex;
use super::profile::{self, Station};
use meso_collision::geometry::HullError;
use meso_collision::math::Vec3;

/// Chords lie within this of the arc, mm.
const SAGITTA: f64 = 0.005;

/// The lengths of a dog-bone, mm: length along x, width along y, thickness along z.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dogbone {
    pub(super) length: f64,
    pub(super) width: f64,
    pub(super) thickness: f64,
    /// The narrowest width.
    pub(super) neck: f64,
    /// Length of the straight part, where the width is the smallest, mm.
    pub(super) neck_length: f64,
    /// Radius of the arcs, which touch the neck's lines.
    pub(super) radius: f64,
}

impl Dogbone {
    /// How much the arcs rise on either side.
    fn rise(&self) -> f64 {
        (self.width - self.neck) / 2.0
    }

    /// The length of each arc along x.
    pub(super) fn run(&self) -> f64 {
        (self.rise() * (2.0 * self.radius - self.rise())).sqrt()
    }

    /// The container. Its lengths must be possible: a rise of at most the radius, arcs and neck within the length.
    pub(super) fn container(&self) -> Result<BoxMinusConvex, HullError> {
        let cheek = self.cheek();
        let station = |&(x, low): &(f64, f64)| Station { x, low, high: self.width - low };
        let ends = [(0.0, 0.0), (self.length, 0.0)];
        let mut line = vec![ends[0]];
        // Arcs that begin at an end have its corner themselves.
        line.extend(cheek.iter().filter(|point| !ends.contains(point)));
        line.push(ends[1]);
        let stations: Vec<Station> = line.iter().map(station).collect();
        let surface = profile::surface(&stations, self.thickness, false);
        let narrowest = self.length.min(self.neck).min(self.thickness);
        BoxMinusConvex::new(surface, narrowest, &[self.cutout(&cheek, false), self.cutout(&cheek, true)])
    }

    /// The lower line between the outer ends of the arcs: x, and height above the lowest line.
    fn cheek(&self) -> Vec<(f64, f64)> {
        let (rise, run) = (self.rise(), self.run());
        let angle = libm::acos(1.0 - rise / self.radius);
        let chord = 2.0 * libm::acos((1.0 - SAGITTA / self.radius).max(0.0));
        let count = (angle / chord).ceil().max(2.0) as u32;
        let middle = self.length / 2.0;
        let arc = (0..=count).map(|k| {
            // From the outer end, where the arc is steepest, to the neck.
            let turned = angle * (1.0 - f64::from(k) / f64::from(count));
            let (x, y) = (self.radius * libm::sin(turned), rise - self.radius * (1.0 - libm::cos(turned)));
            if k == 0 { (run, 0.0) } else { (x, y) }
        });
        let half: Vec<(f64, f64)> = arc.map(|(x, y)| (x + self.neck_length / 2.0, y)).collect();
        let mut line: Vec<(f64, f64)> = half.iter().map(|&(x, y)| (middle - x, y)).collect();
        line.extend(half.iter().rev().map(|&(x, y)| (middle + x, y)));
        line.dedup();
        line
    }

    /// The part removed below, or (mirrored) above: the cheek, extended beyond the box on all its free sides.
    fn cutout(&self, cheek: &[(f64, f64)], above: bool) -> Vec<Vec3> {
        let out = |x: f64| (x, -self.width);
        let ends = [out(cheek[0].0), out(cheek[cheek.len() - 1].0)];
        let corners = cheek.iter().copied().chain(ends).map(|(x, y)| (x, if above { self.width - y } else { y }));
        let thickness = [-self.thickness, 2.0 * self.thickness];
        corners.flat_map(|(x, y)| thickness.map(|z| Vec3::new(x, y, z))).collect()
    }
}
