//! Boxes: exact, with walls on the sides that do not repeat themselves.

use super::container::{Container, Surface};
use super::{Period, Periodic};
use meso_collision::math::{Aabb, Vec3};

/// A box from the origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cuboid {
    max: Vec3,
    walls: [bool; 3],
}

impl Cuboid {
    /// Edge lengths in mm; periodic ones are rounded to the grains' lattice (see [`Period`]).
    pub(super) fn new(size: [f64; 3], periodic: Periodic) -> Self {
        let (size, walls) = (Vec3::from(size), periodic.0.map(|periodic| !periodic));
        let period = Period::new(&size, periodic);
        Self { max: Vec3::from_fn(|i, _| period.along(i).unwrap_or(size[i])), walls }
    }

    fn walls(&self) -> impl Iterator<Item = usize> {
        (0..3).filter(|&i| self.walls[i])
    }
}

impl Container for Cuboid {
    fn aabb(&self) -> Aabb {
        Aabb { min: Vec3::zeros(), max: self.max }
    }

    fn volume(&self) -> f64 {
        self.max.product()
    }

    fn width(&self) -> f64 {
        self.walls().map(|i| self.max[i]).fold(f64::INFINITY, f64::min)
    }

    fn holds(&self, body: &[Vec3], centre: &Vec3, gap: f64) -> bool {
        body.iter().all(|v| {
            let point = v + centre;
            self.walls().all(|i| point[i] >= gap && point[i] <= self.max[i] - gap)
        })
    }

    fn depth(&self, point: &Vec3) -> f64 {
        self.walls().map(|i| point[i].min(self.max[i] - point[i])).fold(f64::INFINITY, f64::min)
    }

    fn is_box(&self) -> bool {
        true
    }

    fn surface(&self) -> Surface {
        Surface::cuboid(&Vec3::zeros(), &self.max)
    }
}

impl Surface {
    /// The six faces of a box.
    pub(super) fn cuboid(min: &Vec3, max: &Vec3) -> Self {
        let corner = |i: usize| Vec3::from_fn(|axis, _| if i >> axis & 1 == 1 { max[axis] } else { min[axis] });
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        Self { points: (0..8).map(corner).collect(), faces: faces.map(Vec::from).to_vec() }
    }
}
