//! Supports and loads of a test as a deck has them.

use super::nodes;
use crate::error::{SolveError, TEST};
use crate::sample::Sample;
use crate::test::load::{Rule, SupportSpec, Turn, TurnOf};
use crate::test::named::Plan;
use crate::test::{Control, Test, word};
use meso_collision::math::Aabb;
use meso_concrete::specimen::Specimen;
use meso_element::LawName;
use meso_mesh::cells::Sides;
use meso_mesh::loads::{Hold, Loads, Pressure, RigidSupport};

/// Distance of a node from the plane of its side, over the specimen's size, beyond which the side is round.
const ROUND: f64 = 1e-6;

impl Test {
    /// Supports and loads on `sample`, for a deck whose plates keep their speed.
    ///
    /// `time_increment_s` is the deck's own; where the test has no step, it also stretches the time, so that waves cross the
    /// specimen as often as in the engine.
    ///
    /// # Errors
    /// A control or a turn that such plates cannot follow, with a remedy; supports that meet no node.
    pub fn loads(&self, sample: &Sample, time_increment_s: f64) -> Result<Loads, SolveError> {
        self.validate()?;
        self.suits_amplitude()?;
        let geometry = sample.geometry();
        let plan = self.plan(&geometry)?;
        let sides = Sides::of(sample.mesh);
        let mut path_mm = self.path_mm(plan.length_mm)?;
        let rigid = plan.supports.iter().filter(|support| support.rule != Rule::Pressure);
        let supports: Vec<RigidSupport> =
            rigid.map(|support| self.support(sample, &sides, &plan, support)).collect::<Result<_, _>>()?;
        let pressed = plan.supports.iter().filter(|support| support.rule == Rule::Pressure);
        let pressures: Vec<Pressure> =
            pressed.map(|support| pressure(sample, &sides, support)).collect::<Result<_, _>>()?;
        // Plates in a ratio of forces share the path as their forces do.
        let size_mm = geometry.size_mm;
        let shared =
            |support: &RigidSupport| support.force_ratio.unwrap_or(0.0) * size_mm[support.axis] / plan.length_mm;
        let shares: f64 = supports.iter().filter(|support| support.is_upper).map(shared).sum();
        path_mm.iter_mut().for_each(|place| *place *= 1.0 + shares);
        let is_cohesive = !sample.mesh.cohesive.is_empty();
        let own = Self { time_step_s: None, ..self.clone() }.time_step_s(sample.element_size_mm, is_cohesive);
        let time_increment_s = self.time_step_s.unwrap_or(time_increment_s);
        let stretch = if self.duration_s.is_some() { 1.0 } else { (time_increment_s / own).max(1.0) };
        let is_pressed = supports.iter().any(|support| support.force_n != 0.0) || !pressures.is_empty();
        let way = |end: bool| {
            let own = supports.iter().filter(|support| support.axis == plan.axis && support.is_upper == end);
            own.map(|support| support.moves).sum::<f64>()
        };
        Ok(Loads {
            test: word(&self.kind),
            presses: way(true) - way(false) <= 0.0,
            supports,
            pressures,
            strains: self.expansion().map(|expansion| expansion.at_end()),
            path_mm,
            axis: plan.axis,
            length_mm: plan.length_mm,
            section_mm2: plan.section_mm2,
            lead_s: self.lead_s(&geometry, is_pressed) * stretch,
            duration_s: self.duration_s(&geometry) * stretch,
            time_increment_s,
            is_elastic: self.law == LawName::Elastic,
        })
    }

    /// Finds out whether a specimen can have the test, and a deck its path, before there is a mesh.
    ///
    /// # Errors
    /// See [`suits`](Self::suits) and [`loads`](Self::loads).
    pub fn suits_deck(&self, specimen: &Specimen) -> Result<(), SolveError> {
        self.suits(specimen)?;
        self.suits_amplitude()?;
        self.path_mm(1.0).map(drop)
    }

    /// Places where the path turns, mm.
    fn path_mm(&self, length_mm: f64) -> Result<Vec<f64>, SolveError> {
        if matches!(self.control, Control::CrackMouth | Control::LateralStrain) {
            let why = "a deck's plates keep their speed and follow no gauge; take \"steady\", or mesocrete solve";
            return Err(TEST.error("control", word(&self.control), why).into());
        }
        if !self.has_path() {
            return Ok(Vec::new());
        }
        let turns = self.turns();
        let place = |turn: &Turn| match turn.of {
            TurnOf::Strain => Ok(turn.at * length_mm),
            TurnOf::Stress | TurnOf::Opening => {
                let why = "a deck's plates cannot turn at a stress or an opening; give turns of a strain, as in \
                           turns = [{ at = 0.002 }, { at = 0.001 }, { at = 0.005 }], or take mesocrete solve";
                Err(TEST.error("turns.at", turn.at, why))
            }
        };
        if turns.is_empty() {
            return Ok(vec![self.strain() * length_mm]);
        }
        Ok(turns.iter().map(place).collect::<Result<_, _>>()?)
    }

    fn support(
        &self,
        sample: &Sample,
        sides: &Sides,
        plan: &Plan,
        support: &SupportSpec,
    ) -> Result<RigidSupport, SolveError> {
        let numbers: Vec<u32> = (0..sample.mesh.points.len() as u32).collect();
        let nodes: Vec<u32> =
            nodes::contacts(sample, sides, support, 0, &numbers)?.iter().map(|contact| contact.node).collect();
        let bit = support.on.bit().unwrap_or_default();
        let (axis, is_upper) = (bit / 2, bit % 2 == 1);
        let (points, aabb) = (&sample.mesh.points, Aabb::around(&sample.mesh.points));
        let plane = if is_upper { aabb.max } else { aabb.min }[axis];
        let is_round =
            nodes.iter().any(|&node| (points[node as usize][axis] - plane).abs() > ROUND * aabb.size()[axis]);
        // A strip takes the shape of a round side; a flat one would meet a line of nodes.
        let is_glued = support.rule == Rule::Glued || support.strip.is_some() && is_round;
        let area_mm2 = nodes::area_mm2(sample.mesh, sides, support);
        Ok(RigidSupport {
            name: support.name.clone(),
            axis,
            is_upper,
            nodes,
            hold: if is_glued { Hold::Glued } else { Hold::Plate(support.friction) },
            moves: support.moves,
            force_n: support.pressure_mpa * area_mm2,
            force_ratio: support.stress_ratio.map(|ratio| ratio * area_mm2 / plan.section_mm2),
            is_beside: !is_glued && support.strip.is_some_and(|strip| strip.at_mm != 0.0),
        })
    }
}

fn pressure(sample: &Sample, sides: &Sides, support: &SupportSpec) -> Result<Pressure, SolveError> {
    let faces = nodes::pressed_faces(sample.mesh, sides, support)?;
    Ok(Pressure { name: support.name.clone(), faces, mpa: support.pressure_mpa })
}
