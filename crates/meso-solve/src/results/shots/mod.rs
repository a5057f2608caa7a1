//! Moments that a page shows: the peak, 80 % after it, and the end, each as small as a page can hold.
//!
//! Nobody knows the peak before the stress has fallen. So a shot is taken at the first row below the largest stress so far, and
//! again after each later rise. The specimen's fields are dropped at once: a shot has pictures and surfaces only.

mod body;
mod cracks;

pub(super) use body::Body;

use super::section::picture;
use super::snapshot::{Moment, Snapshot};
use crate::march::{Frame, Row};
use cracks::Cracks;
use meso_collision::math::Aabb;
use meso_mesh::Mesh;
use meso_view::embedded::base64;
use serde::{Deserialize, Serialize};
use std::cell::{OnceCell, RefCell};
use std::io;

/// A row below this share of the largest stress is one after the peak.
const AFTER: f64 = 0.995;
/// A rise by this factor over the stress of the last shot is another peak.
const HIGHER: f64 = 1.01;
/// Share of the peak at which the second shot is taken.
const FALLEN: f64 = 0.8;

/// A moment as a page shows it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Shot {
    /// When.
    pub moment: Moment,
    /// Damage across x, y and z through the middle: PNG in base64, with width and height in pixels.
    pub(super) sections: Vec<(String, [usize; 2])>,
    /// Displacements of the body's corners, in base64.
    pub(super) moved: String,
    /// The displacement that 32,767 stands for, mm.
    pub(super) most_mm: f32,
    /// The surfaces of the cracks, if any is open.
    pub(super) cracks: Option<Cracks>,
}

/// The fields of a shot.
pub(super) struct Fields<'a> {
    damage: &'a [f32],
    opening_mm: &'a [f32],
    displacement: &'a [[f32; 3]],
}

impl Shot {
    /// The end of a test.
    pub(super) fn of(mesh: &Mesh, body: &Body, end: &Snapshot) -> io::Result<Self> {
        let Snapshot { damage, opening_mm, displacement, .. } = end;
        Self::new(mesh, body, end.moment, &Fields { damage, opening_mm, displacement })
    }

    fn new(mesh: &Mesh, body: &Body, moment: Moment, fields: &Fields) -> io::Result<Self> {
        let aabb = Aabb::around(&mesh.points);
        let middle = (aabb.min + aabb.max) / 2.0;
        let section = |axis: usize| {
            let picture = picture(mesh, fields.damage, axis, middle[axis]);
            Ok((base64(&picture.png()?), [picture.width, picture.height]))
        };
        let moved = fields.displacement.iter().flatten();
        let most_mm = moved.fold(0.0_f32, |most, u| most.max(u.abs())).max(f32::MIN_POSITIVE);
        let of_body = body.nodes().map(|node| fields.displacement[node as usize]);
        Ok(Self {
            moment,
            sections: (0..3).map(section).collect::<io::Result<_>>()?,
            moved: packed(of_body, most_mm),
            most_mm,
            cracks: Cracks::of(mesh, fields.opening_mm, fields.displacement, most_mm),
        })
    }
}

/// Displacements as two bytes an axis, in base64.
fn packed(moved: impl Iterator<Item = [f32; 3]>, most_mm: f32) -> String {
    let bytes = moved.flatten().flat_map(|u| ((32_767.0 * u / most_mm).round() as i16).to_le_bytes());
    base64(&bytes.collect::<Vec<u8>>())
}

/// Places over the longest side of the mesh, as two bytes an axis.
fn place(point: &meso_collision::math::Vec3, aabb: &Aabb) -> [u16; 3] {
    let share = (point - aabb.min) / aabb.size().max();
    [0, 1, 2].map(|axis| (65_535.0 * share[axis]).round() as u16)
}

/// Takes the shots of a running test.
#[derive(Default)]
pub struct Shooting {
    taken: RefCell<ShotFile>,
    body: OnceCell<Body>,
}

/// The shots so far, and what decides about further ones. A checkpoint keeps it.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct ShotFile {
    /// Largest stress so far, and at the last shot of a peak, MPa.
    most_mpa: f64,
    taken_mpa: f64,
    peak: Option<Shot>,
    fallen: Option<Shot>,
}

impl ShotFile {
    /// The shots, in the order of the test.
    pub fn shots(&self) -> impl Iterator<Item = (&'static str, &Shot)> {
        let named = [("peak", &self.peak), ("80 % after the peak", &self.fallen)];
        named.into_iter().filter_map(|(name, shot)| Some((name, shot.as_ref()?)))
    }

    fn is_after_peak(&self, stress_mpa: f64) -> bool {
        stress_mpa < AFTER * self.most_mpa && self.most_mpa > HIGHER * self.taken_mpa
    }

    fn has_fallen(&self, stress_mpa: f64) -> bool {
        stress_mpa <= FALLEN * self.most_mpa && self.fallen.is_none()
    }
}

impl Shooting {
    /// Continues after the shots of a run before this one.
    pub fn after(taken: ShotFile) -> Self {
        Self { taken: RefCell::new(taken), body: OnceCell::new() }
    }

    /// Whether to take a shot after `row`; for [`Observer::wants`](crate::Observer::wants).
    pub fn wants(&self, row: &Row) -> bool {
        let mut taken = self.taken.borrow_mut();
        taken.most_mpa = taken.most_mpa.max(row.stress_mpa);
        let stress = row.stress_mpa;
        row.dissipated > 0.0 && (taken.is_after_peak(stress) || taken.has_fallen(stress))
    }

    /// Takes a shot; for [`Observer::moment`](crate::Observer::moment). A shot that fails is left out.
    pub fn take(&self, frame: &Frame) {
        let mut taken = self.taken.borrow_mut();
        let body = self.body.get_or_init(|| Body::of(frame.mesh()));
        let cells = frame.cells(|point| [point.damage, point.opening_mm]);
        let (damage, opening_mm): (Vec<f32>, Vec<f32>) =
            cells.iter().map(|[damage, opening]| (*damage, *opening)).unzip();
        let displacement = frame.displacement();
        let fields = Fields { damage: &damage, opening_mm: &opening_mm, displacement: &displacement };
        let Ok(shot) = Shot::new(frame.mesh(), body, Moment::of(frame), &fields) else { return };
        let stress = frame.stress_mpa();
        if taken.is_after_peak(stress) {
            (taken.peak, taken.fallen, taken.taken_mpa) = (Some(shot.clone()), None, taken.most_mpa);
        }
        if taken.has_fallen(stress) {
            taken.fallen = Some(shot);
        }
    }

    /// The shots so far.
    pub fn taken(&self) -> ShotFile {
        self.taken.borrow().clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shots_are_wanted_after_the_peak_and_at_80_percent() {
        let shooting = Shooting::default();
        let wants = |stress_mpa| shooting.wants(&Row { stress_mpa, dissipated: 1.0, ..Row::default() });
        assert_eq!([10.0, 20.0, 30.0, 29.95].map(wants), [false; 4]);
        assert!(wants(29.8), "after the peak");
        // A shot of the peak.
        {
            let mut taken = shooting.taken.borrow_mut();
            taken.taken_mpa = taken.most_mpa;
        }
        assert_eq!([29.0, 25.0, 24.1].map(wants), [false; 3]);
        assert!(wants(24.0), "80 %");
        // A higher peak counts anew.
        assert_eq!([31.0, 30.9].map(wants), [false; 2]);
        assert!(wants(30.5));
    }

    #[test]
    fn an_elastic_test_has_no_moment_but_its_end() {
        let row = |stress_mpa| Row { stress_mpa, ..Row::default() };
        let shooting = Shooting::default();
        assert!(![1.0, 3.0, 2.0].into_iter().any(|stress| shooting.wants(&row(stress))));
    }
}
