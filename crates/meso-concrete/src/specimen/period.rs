//! Periodic boxes: the axes, the periods, and the images near a face.

use crate::aggregate::grain::snap;
use meso_collision::math::{Aabb, Vec3};
use serde::de::{Deserializer, Error, Unexpected};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

/// The axes along which a box repeats itself; in a spec a list of their names, `["x", "y", "z"]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Periodic(pub [bool; 3]);

const NAMES: [&str; 3] = ["x", "y", "z"];

impl Periodic {
    /// Walls on all sides.
    pub const NONE: Self = Self([false; 3]);
    /// Periodic along all axes: no walls.
    pub const ALL: Self = Self([true; 3]);

    /// True where there are walls on all sides.
    #[inline]
    pub fn is_none(&self) -> bool {
        *self == Self::NONE
    }
}

impl Serialize for Periodic {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(NAMES.iter().zip(self.0).filter(|(_, periodic)| *periodic).map(|(name, _)| name))
    }
}

impl<'de> Deserialize<'de> for Periodic {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let names = Vec::<String>::deserialize(deserializer)?;
        let mut periodic = Self::NONE;
        for name in names {
            let axis = NAMES.iter().position(|known| *known == name);
            let axis = axis.ok_or_else(|| D::Error::invalid_value(Unexpected::Str(&name), &"\"x\", \"y\" or \"z\""))?;
            periodic.0[axis] = true;
        }
        Ok(periodic)
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for Periodic {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Periodic".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": "array", "items": { "type": "string", "enum": NAMES }, "uniqueItems": true })
    }
}

/// The lengths after which a box repeats itself, mm: 0 along the axes that have walls.
///
/// Periods are multiples of the grains' lattice, so that the images of grains are exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Period(Vec3);

impl Period {
    /// The period of a box of this size, which the lattice rounds by at most 5e-10 mm.
    pub fn new(size: &Vec3, periodic: Periodic) -> Self {
        let size = snap(size);
        Self(Vec3::from_fn(|i, _| if periodic.0[i] { size[i] } else { 0.0 }))
    }

    /// The period along `axis`, mm, where there is one.
    #[inline]
    pub fn along(&self, axis: usize) -> Option<f64> {
        (self.0[axis] > 0.0).then_some(self.0[axis])
    }

    /// True where there are walls on all sides.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.0 == Vec3::zeros()
    }

    /// The whole periods in a shift between images.
    #[inline]
    pub fn steps(&self, shift: &Vec3) -> [i32; 3] {
        [0, 1, 2].map(|axis| self.along(axis).map_or(0, |length| (shift[axis] / length).round() as i32))
    }

    /// The box with the sides of `periodic` along the periodic axes, and those of `walled` along the others.
    #[inline]
    pub fn mixed(&self, periodic: &Aabb, walled: &Aabb) -> Aabb {
        let side = |axis: usize| if self.along(axis).is_some() { periodic } else { walled };
        Aabb { min: Vec3::from_fn(|i, _| side(i).min[i]), max: Vec3::from_fn(|i, _| side(i).max[i]) }
    }

    /// `point` moved by whole periods into the box from the origin.
    #[inline]
    pub fn wrap(&self, point: &Vec3) -> Vec3 {
        Vec3::from_fn(|i, _| match self.along(i) {
            // A rounded quotient may be off by one in either direction.
            Some(length) => {
                let x = point[i] - (point[i] / length).floor() * length;
                if x < 0.0 {
                    x + length
                } else if x >= length {
                    x - length
                } else {
                    x
                }
            }
            None => point[i],
        })
    }

    /// The shortest of the displacements that differ from `x` by whole periods.
    #[inline(always)]
    pub fn nearest(&self, x: &Vec3) -> Vec3 {
        Vec3::from_fn(|i, _| if self.0[i] > 0.0 { x[i] - (x[i] / self.0[i]).round() * self.0[i] } else { x[i] })
    }

    /// The displacements by whole periods, no displacement among them, that bring the closed box `aabb` to `domain`.
    pub fn shifts(&self, aabb: &Aabb, domain: &Aabb) -> Vec<Vec3> {
        if self.is_none() {
            return vec![Vec3::zeros()];
        }
        let steps = [0, 1, 2].map(|i| match self.along(i) {
            Some(length) => {
                let low = ((domain.min[i] - aabb.max[i]) / length).ceil() as i64 - 1;
                let high = ((domain.max[i] - aabb.min[i]) / length).floor() as i64 + 1;
                let meets = |n: &i64| {
                    let shift = *n as f64 * length;
                    aabb.min[i] + shift <= domain.max[i] && aabb.max[i] + shift >= domain.min[i]
                };
                (low..=high).filter(meets).map(|n| n as f64 * length).collect()
            }
            None => vec![0.0],
        });
        let [x, y, z] = &steps;
        let columns = z.iter().flat_map(|&z| y.iter().map(move |&y| (y, z)));
        columns.flat_map(|(y, z)| x.iter().map(move |&x| Vec3::new(x, y, z))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrapped_points_lie_in_the_half_open_box_and_differ_by_whole_periods() {
        let period = Period::new(&Vec3::new(10.0, 20.0, 0.3), Periodic([true, true, false]));
        for x in [-10.0, -1e-18, 0.0, 9.999, 10.0, 25.0, 1e3] {
            let wrapped = period.wrap(&Vec3::new(x, x, x));
            assert!((0.0..10.0).contains(&wrapped.x) && (0.0..20.0).contains(&wrapped.y), "{x} became {wrapped}");
            assert_eq!(wrapped.z, x);
        }
        assert_eq!(period.wrap(&Vec3::new(-3.0, 47.0, 1.0)), Vec3::new(7.0, 7.0, 1.0));
    }

    #[test]
    fn the_nearest_image_is_at_most_half_a_period_away() {
        let period = Period::new(&Vec3::repeat(10.0), Periodic([true, false, true]));
        assert_eq!(period.nearest(&Vec3::new(7.0, 7.0, -16.0)), Vec3::new(-3.0, 7.0, 4.0));
    }

    #[test]
    fn images_are_those_whose_boxes_meet_the_domain() {
        let period = Period::new(&Vec3::repeat(10.0), Periodic([true, true, false]));
        let domain = Aabb { min: Vec3::zeros(), max: Vec3::repeat(10.0) };
        let corner = Aabb { min: Vec3::new(9.0, -1.0, 4.0), max: Vec3::new(11.0, 1.0, 6.0) };
        let mut shifts = period.shifts(&corner, &domain);
        shifts.sort_by(|a, b| (a.x, a.y).partial_cmp(&(b.x, b.y)).unwrap());
        assert_eq!(shifts, [[-10.0, 0.0], [-10.0, 10.0], [0.0, 0.0], [0.0, 10.0]].map(|[x, y]| Vec3::new(x, y, 0.0)));
        let touching = Aabb { min: Vec3::new(0.0, 4.0, 4.0), max: Vec3::new(1.0, 6.0, 6.0) };
        assert_eq!(period.shifts(&touching, &domain).len(), 2, "a touching image counts");
    }
}
