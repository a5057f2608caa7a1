//! The faces across which a box repeats itself, and what keeps to them.

use crate::math::{Aabb, Vec3};

/// The faces that a node has to stay in: a bit per side, in the order of [`SIDES`](crate::mesh::sides::SIDES).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Flat(u8);

impl Flat {
    /// No face at all.
    pub(super) const SPACE: Self = Self(0);

    /// Those of the `sides` across which the box repeats itself.
    pub(super) fn of(sides: u8, periodic: [bool; 3]) -> Self {
        Self((0..3).filter(|axis| periodic[*axis]).fold(0, |bits, axis| bits | sides & 3 << (2 * axis)))
    }

    /// A coordinate that cannot change.
    pub(super) fn holds(self, axis: usize) -> bool {
        self.0 >> (2 * axis) & 3 != 0
    }

    /// The part of `way` that stays in the faces.
    pub(super) fn along(self, way: &Vec3) -> Vec3 {
        Vec3::from_fn(|axis, _| if self.holds(axis) { 0.0 } else { way[axis] })
    }

    /// `x` with the coordinates of the faces in `walls`.
    pub(super) fn put(self, x: &Vec3, walls: &Aabb) -> Vec3 {
        Vec3::from_fn(|axis, _| match self.0 >> (2 * axis) & 3 {
            0 => x[axis],
            1 => walls.min[axis],
            _ => walls.max[axis],
        })
    }

    /// Where a node comes to that goes from `x` to `image` and stays on its side of these faces: at most half of the way
    /// to each, and with nodes on one line across a face in the order they were in.
    pub(super) fn hold_off(self, x: &Vec3, image: &Vec3, walls: &Aabb) -> Vec3 {
        Vec3::from_fn(|axis, _| {
            let way = image[axis] - x[axis];
            let room = if way < 0.0 { x[axis] - walls.min[axis] } else { walls.max[axis] - x[axis] };
            let ahead = self.0 >> (2 * axis + usize::from(way > 0.0)) & 1 == 1;
            if ahead && room > 0.0 { x[axis] + way * (room / (room + 2.0 * way.abs())) } else { image[axis] }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_held_off_a_face_keeps_its_side_and_its_order() {
        let walls = Aabb { min: Vec3::zeros(), max: Vec3::repeat(10.0) };
        let flat = Flat::of(0b11_0001, [true, true, false]);
        let image = |x: f64| flat.hold_off(&Vec3::new(x, 5.0, 5.0), &Vec3::new(x - 0.4, 5.0, 4.0), &walls);
        let images: Vec<f64> = (1..100).map(|i| image(f64::from(i) * 0.05).x).collect();
        assert!(images[0] > 0.0 && images.is_sorted());
        assert!((images[98] - (4.95 - 0.4)).abs() < 0.06, "far from the face hardly anything changes");
        assert_eq!(image(3.0).z, 4.0, "the box does not repeat itself there");
        assert!(flat.holds(0) && !flat.holds(1) && !flat.holds(2));
    }
}
