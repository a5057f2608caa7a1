//! Nodes under supports: rigid plates that press and rub, plates that are glued on, and dead forces.
//!
//! No penalty: a node is first moved as if free; where it would pass into a plate, it is put onto it, and the impulse
//! that this takes is the plate's. Friction takes away as much of its sliding as Coulomb's cone allows.

use meso_trial::{MOST_SUPPORTS, Rule};

/// A node that can meet a plate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    /// The engine's number.
    pub(crate) node: u32,
    /// Number of the support.
    pub(crate) support: u32,
    /// From the node to the plate before the test, mm.
    pub(crate) gap: f64,
}

/// A node that a pressure acts on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Load {
    /// The engine's number.
    pub(crate) node: u32,
    /// Number of the support.
    pub(crate) support: u32,
    /// Force at a pressure of 1 MPa, N.
    pub(crate) force: [f64; 3],
}

/// The side of a plate that meets nodes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face {
    /// The axis that it is across: 0, 1 or 2.
    pub(crate) axis: usize,
    /// 1 where the specimen is above it, else -1.
    pub(crate) inward: f64,
    pub(crate) rule: Rule,
    pub(crate) friction: f64,
}

/// A step of one support along its axis.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moved {
    /// Where a plate is at the end of the step, mm from its start.
    pub travel: f64,
    /// Mean of this step and the one before, mm/s: forces at whole steps do their work along it.
    pub mean_speed: f64,
    /// Pressure of a load, MPa.
    pub pressure: f64,
}

/// A step of all supports.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    /// Length of the step, s.
    pub(crate) dt: f64,
    pub(crate) supports: [Moved; MOST_SUPPORTS],
}

/// The action of a plate on a node in a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PlateAction {
    /// Force of the plate on the node along its axis, N.
    pub(crate) force: f64,
    /// Work of the force, mJ.
    pub(crate) work: f64,
}

/// What the plates before did to a node in a step: a node at an edge may meet two.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Touched {
    /// The axes along which a plate has set its velocity; another plate does not rub it along them.
    held: [bool; 3],
    /// Sum of the plates' forces across their axes, N.
    rubbed: [f64; 3],
}

impl Touched {
    /// Energy lost in friction, mJ, where the node had the velocity `before` the step and `v` after it.
    pub(crate) fn friction(&self, dt: f64, before: &[f64; 3], v: &[f64; 3]) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|k: usize| self.rubbed[k] * (0.5 * (v[k] + before[k])));
        -dt * (x + y + z)
    }
}

impl Face {
    /// Corrects the velocity `v` that a node of mass `m` with the displacement `u` would have without the plate, `gap` mm
    /// from it before the test; `touched` holds the plates that it met before in this step.
    pub(crate) fn meet(
        &self,
        gap: f64,
        (dt, moved): (f64, &Moved),
        m: f64,
        u: &[f64; 3],
        v: &mut [f64; 3],
        touched: &mut Touched,
    ) -> PlateAction {
        let &Self { axis: a, inward, .. } = self;
        let [b, c] = ACROSS[a];
        let free = *v;
        if self.rule == Rule::Glued {
            v[a] = (moved.travel - u[a]) / dt;
            (v[b], v[c]) = (-u[b] / dt, -u[c] / dt);
        } else {
            // On the plate, the displacement makes good the gap.
            let on_plate = moved.travel - inward * gap;
            if (u[a] + dt * v[a] - on_plate) * inward >= 0.0 {
                return PlateAction::default();
            }
            v[a] = (on_plate - u[a]) / dt;
            rub([b, c], v, self.friction * (v[a] - free[a]).abs(), &touched.held);
        }
        let force = [a, b, c].map(|i: usize| m * (v[i] - free[i]) / dt);
        touched.held[a] = true;
        (touched.rubbed[b], touched.rubbed[c]) = (touched.rubbed[b] + force[1], touched.rubbed[c] + force[2]);
        PlateAction { force: force[0], work: force[0] * moved.mean_speed * dt }
    }
}

/// The axes across each axis, ascending.
pub(crate) const ACROSS: [[usize; 2]; 3] = [[1, 2], [0, 2], [0, 1]];

/// Takes up to `most` of the sliding speed along two axes away, as far as no plate holds the node along them.
fn rub(across: [usize; 2], v: &mut [f64; 3], most: f64, held: &[bool; 3]) {
    let [b, c] = across.map(|axis| if held[axis] { 0.0 } else { v[axis] });
    let sliding = (b * b + c * c).sqrt();
    let kept = if sliding <= most { 0.0 } else { 1.0 - most / sliding };
    for axis in across.into_iter().filter(|axis| !held[*axis]) {
        v[axis] *= kept;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MASS: f64 = 2.0;

    /// A node under the upper plate, which goes down by 0.01 mm in 0.001 s: its velocity `v` after the step, and the plate's
    /// action.
    fn pressed(friction: f64, mut v: [f64; 3]) -> ([f64; 3], PlateAction, f64) {
        let (moved, before) = (Moved { travel: -0.01, mean_speed: -10.0, pressure: 0.0 }, v);
        let upper = Face { axis: 2, inward: -1.0, rule: Rule::Plate, friction };
        let mut touched = Touched::default();
        let impact = upper.meet(0.0, (1e-3, &moved), MASS, &[0.0; 3], &mut v, &mut touched);
        (v, impact, touched.friction(1e-3, &before, &v))
    }

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-12 * (1.0 + b.abs())
    }

    #[test]
    fn a_plate_pushes_and_never_pulls() {
        let faster = [0.3, -0.2, -10.5];
        let (v, impact, friction) = pressed(0.5, faster);
        assert_eq!((v, impact.force, impact.work, friction), (faster, 0.0, 0.0, 0.0));
        let (v, impact, _) = pressed(0.0, [0.3, -0.2, -4.0]);
        assert!(v[..2] == [0.3, -0.2] && near(v[2], -10.0), "{v:?}");
        // The change of momentum, and the work along the plate's own path.
        assert!(near(impact.force * 1e-3, MASS * -6.0) && near(impact.work, MASS * 60.0), "{impact:?}");
    }

    #[test]
    fn friction_takes_coulombs_share_of_the_push_or_all_sliding_and_spends_its_energy() {
        for (friction, left) in [(0.0, 1.0), (0.1, 1.0 - 0.6 / 5.0), (0.5, 0.4), (0.9, 0.0), (5.0, 0.0)] {
            let (v, _, lost) = pressed(friction, [3.0, 4.0, -4.0]);
            assert!(near(v[0], 3.0 * left) && near(v[1], 4.0 * left) && near(v[2], -10.0), "{friction}: {v:?}");
            assert!(near(lost, 0.5 * MASS * 25.0 * (1.0 - left * left)), "{friction}: {lost}");
        }
    }

    #[test]
    fn a_plate_across_any_axis_acts_alike() {
        let upright = pressed(0.5, [3.0, 4.0, -4.0]);
        for (axis, turned) in [(0, [-4.0, 3.0, 4.0]), (1, [3.0, -4.0, 4.0])] {
            let (mut v, before) = (turned, turned);
            let face = Face { axis, inward: -1.0, rule: Rule::Plate, friction: 0.5 };
            let moved = Moved { travel: -0.01, mean_speed: -10.0, pressure: 0.0 };
            let mut touched = Touched::default();
            let impact = face.meet(0.0, (1e-3, &moved), MASS, &[0.0; 3], &mut v, &mut touched);
            let lost = touched.friction(1e-3, &before, &v);
            let [b, c] = ACROSS[axis];
            assert_eq!([v[b], v[c], v[axis]], upright.0, "{axis}");
            assert_eq!((impact.force, impact.work, lost), (upright.1.force, upright.1.work, upright.2));
        }
    }
}
