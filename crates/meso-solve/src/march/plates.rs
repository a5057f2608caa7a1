//! Two rigid plates: they press and rub, or they are glued on.
//!
//! Each does half of the way, so the specimen's middle rests: its kinetic energy is then a quarter of that beside a
//! plate at rest, and no wave runs from one plate alone.
//!
//! No penalty: a node is first moved as if free; where it would pass into a plate, it is put onto it, and the impulse
//! that this takes is the plate's. Friction takes away as much of its sliding as Coulomb's cone allows.

use crate::error::SolveError;
use crate::test::{Test, TestKind};
use meso_collision::math::Aabb;
use meso_mesh::Mesh;
use meso_mesh::cells::Sides;

/// A node that can meet a plate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    /// The engine's number.
    pub(crate) node: u32,
    /// 0 for the lower plate, 1 for the upper one.
    pub(crate) plate: usize,
    /// From the node to the plate before the test, mm.
    pub(crate) gap: f64,
}

/// The plates and the nodes that can meet them.
#[derive(Clone, Debug)]
pub(crate) struct Plates {
    /// By node.
    pub(crate) contacts: Vec<Contact>,
    kind: TestKind,
    friction: f64,
    /// Speed of the upper plate against the lower one once the ramp is over, upwards, mm/s.
    speed: f64,
    /// Length of the ramp, s.
    ramp_s: f64,
}

/// A step of the upper plate, upwards; the lower one does the opposite.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    /// Length of the step, s.
    pub(crate) dt: f64,
    /// Where the plate is at the end of the step, mm from its start.
    pub(crate) travel: f64,
    /// Mean of this step and the one before, mm/s: forces at whole steps do their work along it.
    pub(crate) mean_speed: f64,
}

/// The action of a plate on a node in a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Impact {
    /// Force of the plate on the node along z, N.
    pub(crate) force: f64,
    /// Work of the force, mJ.
    pub(crate) work: f64,
    /// Lost in friction, mJ.
    pub(crate) friction: f64,
}

impl Plates {
    /// Plates of a test that lasts `duration_s`; `number` gives the engine's numbers of the mesh's nodes.
    ///
    /// # Errors
    /// Where no face of the specimen looks up or down.
    pub(crate) fn new(mesh: &Mesh, number: &[u32], test: &Test, duration_s: f64) -> Result<Self, SolveError> {
        let sides = Sides::of(mesh);
        let aabb = Aabb::around(&mesh.points);
        let mut contacts = Vec::new();
        for (plate, (bit, z)) in [(4, aabb.min.z), (5, aabb.max.z)].into_iter().enumerate() {
            if sides.faces()[bit].is_empty() {
                let side = ["lower", "upper"][plate];
                let why = format!("no face points to its {side} plate; take a specimen with plane faces across z");
                return Err(SolveError::mesh(why));
            }
            let contact = |node: u32| {
                let gap = (mesh.points[node as usize].z - z).abs();
                Contact { node: number[node as usize], plate, gap }
            };
            contacts.extend(sides.members(bit).map(contact));
        }
        contacts.sort_by_key(|contact| (contact.node, contact.plate));
        contacts.dedup_by_key(|contact| contact.node);
        let ramp_s = test.ramp * duration_s;
        let sign = if test.kind == TestKind::Compression { -1.0 } else { 1.0 };
        let speed = sign * test.strain() * aabb.size().z / (duration_s - 0.5 * ramp_s);
        Ok(Self { contacts, kind: test.kind, friction: test.friction, speed, ramp_s })
    }

    /// Whether the plates are glued on, their friction, and their full speed with the length of the ramp to it, mm/s and s.
    pub(crate) fn rule(&self) -> (bool, f64, [f64; 2]) {
        (self.kind == TestKind::Tension, self.friction, [self.speed, self.ramp_s])
    }

    /// Speed of the upper plate against the lower one at time `t`, mm/s upwards: 3 s^2 - 2 s^3 along the ramp, then constant.
    pub(crate) fn speed(&self, t: f64) -> f64 {
        let s = (t / self.ramp_s).min(1.0);
        self.speed * s * s * (3.0 - 2.0 * s)
    }

    /// Share that each plate takes of the way or speed between the two.
    pub(crate) fn share(between: f64) -> f64 {
        0.5 * between
    }

    /// The contacts of nodes from `first` to before `end`.
    pub(crate) fn among(&self, first: usize, end: usize) -> &[Contact] {
        let at = |node: usize| self.contacts.partition_point(|contact| (contact.node as usize) < node);
        &self.contacts[at(first)..at(end)]
    }

    /// Corrects the velocity `v` that a node of mass `m` with the displacement `u` would have without the plate; `before`
    /// is its velocity in the step before.
    pub(crate) fn meet(
        &self,
        contact: &Contact,
        motion: &Motion,
        m: f64,
        u: &[f64; 3],
        before: &[f64; 3],
        v: &mut [f64; 3],
    ) -> Impact {
        let Motion { dt, .. } = *motion;
        let inward = if contact.plate == 1 { -1.0 } else { 1.0 };
        let (travel, speed) = (-inward * motion.travel, -inward * motion.mean_speed);
        let free = *v;
        match self.kind {
            TestKind::Tension => *v = [-u[0] / dt, -u[1] / dt, (travel - u[2]) / dt],
            TestKind::Compression => {
                // On the plate, the displacement makes good the gap.
                let on_plate = travel - inward * contact.gap;
                if (u[2] + dt * v[2] - on_plate) * inward >= 0.0 {
                    return Impact::default();
                }
                v[2] = (on_plate - u[2]) / dt;
                self.rub(v, self.friction * (v[2] - free[2]).abs());
            }
        }
        let force = [0, 1, 2].map(|i: usize| m * (v[i] - free[i]) / dt);
        let mean = [0, 1, 2].map(|i: usize| 0.5 * (v[i] + before[i]));
        let friction = -dt * (force[0] * mean[0] + force[1] * mean[1]);
        Impact { force: force[2], work: force[2] * speed * dt, friction }
    }

    /// Takes up to `most` of the sliding speed away.
    fn rub(&self, v: &mut [f64; 3], most: f64) {
        let sliding = (v[0] * v[0] + v[1] * v[1]).sqrt();
        let kept = if sliding <= most { 0.0 } else { 1.0 - most / sliding };
        v[0] *= kept;
        v[1] *= kept;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UPPER: Contact = Contact { node: 0, plate: 1, gap: 0.0 };
    const MASS: f64 = 2.0;

    fn plates(friction: f64) -> Plates {
        Plates { contacts: Vec::new(), kind: TestKind::Compression, friction, speed: -8.0, ramp_s: 0.5 }
    }

    /// A node under the upper plate, which goes down by 0.01 mm in 0.001 s: its velocity `v` after the step, and the plate's
    /// action.
    fn pressed(friction: f64, mut v: [f64; 3]) -> ([f64; 3], Impact) {
        let (motion, before) = (Motion { dt: 1e-3, travel: -0.01, mean_speed: -10.0 }, v);
        let impact = plates(friction).meet(&UPPER, &motion, MASS, &[0.0; 3], &before, &mut v);
        (v, impact)
    }

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-12 * (1.0 + b.abs())
    }

    #[test]
    fn a_plate_pushes_and_never_pulls() {
        let faster = [0.3, -0.2, -10.5];
        let (v, impact) = pressed(0.5, faster);
        assert_eq!((v, impact.force, impact.work, impact.friction), (faster, 0.0, 0.0, 0.0));
        let (v, impact) = pressed(0.0, [0.3, -0.2, -4.0]);
        assert!(v[..2] == [0.3, -0.2] && near(v[2], -10.0), "{v:?}");
        // The change of momentum, and the work along the plate's own path.
        assert!(near(impact.force * 1e-3, MASS * -6.0) && near(impact.work, MASS * 60.0), "{impact:?}");
    }

    #[test]
    fn friction_takes_coulombs_share_of_the_push_or_all_sliding_and_spends_its_energy() {
        for (friction, left) in [(0.0, 1.0), (0.1, 1.0 - 0.6 / 5.0), (0.5, 0.4), (0.9, 0.0), (5.0, 0.0)] {
            let (v, impact) = pressed(friction, [3.0, 4.0, -4.0]);
            assert!(near(v[0], 3.0 * left) && near(v[1], 4.0 * left) && near(v[2], -10.0), "{friction}: {v:?}");
            assert!(near(impact.friction, 0.5 * MASS * 25.0 * (1.0 - left * left)), "{friction}: {impact:?}");
        }
    }

    #[test]
    fn the_ramp_begins_and_ends_without_a_jerk() {
        let speed = |t: f64| plates(0.0).speed(t);
        assert!([speed(0.0), speed(0.25), speed(0.5), speed(7.0)] == [0.0, -4.0, -8.0, -8.0]);
        assert!(speed(0.005) > -8.0 * 3e-4 && speed(0.495) < -8.0 * (1.0 - 3e-4));
    }
}
