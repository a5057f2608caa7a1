//! Supports and loads of a mesh as a test puts them together, and a deck writes them.

use crate::error::{TEST, TrialError};
use crate::nodes;
use crate::sample::Sample;
use crate::trial::{Control, Drive, Rig, Rule, SupportSpec, Test, Turn, TurnOf, word};
use meso_collision::math::Aabb;
use meso_concrete::specimen::Specimen;
use meso_mesh::cells::Sides;
use meso_mesh::materials::LawName;

/// Supports and loads of a mesh, and their path in time.
#[derive(Clone, Debug, PartialEq)]
pub struct Loads {
    /// Name of the test.
    pub test: String,
    /// Plates, strips and rollers.
    pub supports: Vec<RigidSupport>,
    /// Pressures on outer faces.
    pub pressures: Vec<Pressure>,
    /// Linear strains by the numbers of phases, which grow before the path begins; 3 is no phase of a mesh.
    pub strains: Option<[f64; 5]>,
    /// Places where the path turns, mm, its end last; none of a test that moves no support.
    pub path_mm: Vec<f64>,
    /// Axis along which the supports move: 0, 1 or 2.
    pub axis: usize,
    /// Path over this is the strain, mm.
    pub length_mm: f64,
    /// Force over this is the stress, mm2.
    pub section_mm2: f64,
    /// Whether the path presses the specimen.
    pub presses: bool,
    /// Time in which loads grow before the path begins, s; 0 without such loads.
    pub lead_s: f64,
    /// Time of the path, s.
    pub duration_s: f64,
    /// Time increment that mass scaling keeps, s.
    pub time_increment_s: f64,
    /// Whether all phases are elastic, so that statics give the answer.
    pub is_elastic: bool,
}

/// A rigid support of some nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidSupport {
    /// Its name.
    pub name: String,
    /// Axis of its side: 0, 1 or 2.
    pub axis: usize,
    /// Whether its side is the upper one across the axis.
    pub is_upper: bool,
    /// The mesh's nodes under it.
    pub nodes: Vec<u32>,
    /// Its action on the nodes.
    pub hold: Hold,
    /// Its way along the axis for each mm of the path.
    pub moves: f64,
    /// Force that presses it on the specimen when the path begins, N; 0 for none.
    pub force_n: f64,
    /// Its force over the force of the test; `None` where it follows the path.
    pub force_ratio: Option<f64>,
    /// Whether it is a strip beside the middle, which the specimen turns on.
    pub is_beside: bool,
    /// What moves it in real time, once the loads have grown.
    pub motion: Option<Motion>,
}

impl RigidSupport {
    /// Whether a plate has its force while loads grow, and the path afterwards; the lower one of a pair stays where it is.
    pub fn is_pressed(&self) -> bool {
        self.force_n != 0.0 && self.is_upper
    }
}

/// What moves a support of a deck in real time. Speeds are positive towards the specimen; those over time are rows of s and mm/s.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// Its speed.
    Speed(Vec<[f64; 2]>),
    /// The end of a bar: the force Z (2 v_i - v).
    Bar {
        /// Z, N s/mm.
        impedance: f64,
        /// Mass that the end has, since an explicit step needs some, tonne.
        mass_t: f64,
        /// Particle speed v_i of the wave that comes; empty where none does.
        wave: Vec<[f64; 2]>,
    },
    /// A rigid mass that strikes.
    Mass {
        /// Its mass, tonne.
        mass_t: f64,
        /// Its speed, mm/s.
        speed_mm_per_s: f64,
    },
}

/// Action of a support on its nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hold {
    /// It presses and rubs with this coefficient of friction.
    Plate(f64),
    /// It is glued on.
    Glued,
}

/// A pressure on outer faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Pressure {
    /// Its name.
    pub name: String,
    /// Cells, and the number of the face of each.
    pub faces: Vec<(u32, usize)>,
    /// The pressure when the path begins, MPa.
    pub mpa: f64,
}

/// Fastest waves in rocks, mm/s. The end of a bar has the mass that its impedance stops while such a wave passes an element.
const FASTEST_WAVE: f64 = 5e6;
/// Time of a jump of a speed in the table of a deck over the duration.
const JUMP: f64 = 1e-4;

impl Loads {
    /// Whether supports move in real time, without a path.
    pub fn is_fast(&self) -> bool {
        self.supports.iter().any(|support| support.motion.is_some())
    }
}

/// Distance of a node from the plane of its side, over the specimen's size, beyond which the side is round.
const ROUND: f64 = 1e-6;

impl Test {
    /// Supports and loads on `sample`, for a deck whose plates keep their speed.
    ///
    /// Times are the engine's: the path takes [`duration_s`](Self::duration_s), and the increment is
    /// [`time_step_s`](Self::time_step_s).
    ///
    /// # Errors
    /// A control or a turn that such plates cannot follow, with a remedy; supports that meet no node.
    pub fn loads(&self, sample: &Sample) -> Result<Loads, TrialError> {
        self.validate()?;
        self.suits_amplitude()?;
        self.expansion().map_or(Ok(()), |expansion| expansion.suits(sample.mesh))?;
        let geometry = sample.geometry();
        let rig = self.rig(&geometry)?;
        let sides = Sides::of(sample.mesh);
        let mut path_mm = self.path_mm(rig.length_mm)?;
        let (mut supports, mut members) = (Vec::new(), Vec::new());
        for (place, support) in (0..).zip(&rig.supports).filter(|(_, support)| support.rule != Rule::Pressure) {
            let rigid = self.support(sample, &sides, &rig, support)?;
            members.extend(rigid.nodes.iter().map(|&node| (node, place)));
            supports.push(rigid);
        }
        rig.agree(members)?;
        let pressed = rig.supports.iter().filter(|support| support.rule == Rule::Pressure);
        let pressures: Vec<Pressure> =
            pressed.map(|support| pressure(sample, &sides, support)).collect::<Result<_, _>>()?;
        // Plates in a ratio of forces share the path as their forces do.
        let size_mm = geometry.size_mm;
        let shared =
            |support: &RigidSupport| support.force_ratio.unwrap_or(0.0) * size_mm[support.axis] / rig.length_mm;
        let shares: f64 = supports.iter().filter(|support| support.is_upper).map(shared).sum();
        path_mm.iter_mut().for_each(|place| *place *= 1.0 + shares);
        let is_cohesive = !sample.mesh.cohesive.is_empty();
        let is_pressed = supports.iter().any(|support| support.force_n != 0.0) || !pressures.is_empty();
        let way = |end: bool| {
            let own = supports.iter().filter(|support| support.axis == rig.axis && support.is_upper == end);
            own.map(|support| support.moves).sum::<f64>()
        };
        Ok(Loads {
            test: word(&self.kind),
            presses: way(true) - way(false) <= 0.0,
            supports,
            pressures,
            strains: self.expansion().map(|expansion| expansion.at_end()),
            path_mm,
            axis: rig.axis,
            length_mm: rig.length_mm,
            section_mm2: rig.section_mm2,
            lead_s: self.lead_s(&geometry, is_pressed),
            duration_s: self.duration_s(&geometry),
            time_increment_s: self.time_step_s(sample.element_size_mm, is_cohesive),
            is_elastic: self.law == LawName::Elastic,
        })
    }

    /// Finds out whether a specimen can have the test, and a deck its path, before there is a mesh.
    ///
    /// # Errors
    /// See [`suits`](Self::suits) and [`loads`](Self::loads).
    pub fn suits_deck(&self, specimen: &Specimen) -> Result<(), TrialError> {
        self.suits(specimen)?;
        self.followed()
    }

    /// Finds out whether plates of a deck, which keep their speed, can follow the path.
    ///
    /// # Errors
    /// A control, a turn or strains that they cannot follow, with a remedy.
    pub fn followed(&self) -> Result<(), TrialError> {
        self.suits_amplitude()?;
        self.path_mm(1.0).map(drop)
    }

    /// Places where the path turns, mm.
    fn path_mm(&self, length_mm: f64) -> Result<Vec<f64>, TrialError> {
        if let Some(control) = self.control.filter(|control| *control != Control::Steady) {
            let why = "a deck's plates keep their speed; take \"steady\", or leave it out";
            return Err(TEST.error("control", word(&control), why).into());
        }
        if self.is_fast() {
            let rate = "laws of a deck here have no rate; leave it out, or take mesocrete solve";
            TEST.require("rate_effect", true, !self.rate_effect, rate)?;
            let still = "specimens of a deck begin at rest; leave it out, or take mesocrete solve";
            TEST.require("starts_moving", true, !self.starts_moving, still)?;
            let statics = "a deck of this law is static; take another law, or mesocrete solve";
            TEST.require("law", word(&self.law), self.law != LawName::Elastic, statics)?;
            let strikes = self.supports.iter().any(|support| matches!(support.drive, Some(Drive::Mass { .. })));
            let waits = strikes && self.supports.iter().any(|support| support.rule == Rule::Pressure);
            let at_once =
                "a mass of a deck strikes while the pressure grows; leave the pressure out, or take mesocrete solve";
            TEST.require("supports.drive.kind", "mass", !waits, at_once)?;
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
        rig: &Rig,
        support: &SupportSpec,
    ) -> Result<RigidSupport, TrialError> {
        let nodes: Vec<u32> = nodes::under(sample, sides, support)?.into_iter().map(|(node, _)| node).collect();
        let bit = support.on.bit().unwrap_or_default();
        let (axis, is_upper) = (bit / 2, bit % 2 == 1);
        let (points, aabb) = (&sample.mesh.points, Aabb::around(&sample.mesh.points));
        let plane = if is_upper { aabb.max } else { aabb.min }[axis];
        let is_round =
            nodes.iter().any(|&node| (points[node as usize][axis] - plane).abs() > ROUND * aabb.size()[axis]);
        // A strip takes the shape of a round side; a flat one would meet a line of nodes.
        let is_glued = support.rule == Rule::Glued || support.strip.is_some() && is_round;
        let area_mm2 = nodes::area_mm2(sample.mesh, sides, support);
        let jump_s = JUMP * self.duration_s(&sample.geometry());
        Ok(RigidSupport {
            name: support.name.clone(),
            axis,
            is_upper,
            nodes,
            hold: if is_glued { Hold::Glued } else { Hold::Plate(support.friction) },
            moves: support.moves,
            force_n: support.pressure_mpa * area_mm2,
            force_ratio: support.stress_ratio.map(|ratio| ratio * area_mm2 / rig.section_mm2),
            is_beside: !is_glued && support.strip.is_some_and(|strip| strip.at_mm != 0.0),
            motion: support.drive.as_ref().map(|drive| motion(drive, sample, area_mm2, jump_s)),
        })
    }
}

/// The motion of a support on an area of the specimen.
fn motion(drive: &Drive, sample: &Sample, on_mm2: f64, jump_s: f64) -> Motion {
    match drive {
        Drive::Speed { speed_m_per_s } => Motion::Speed(speed_m_per_s.rows(jump_s)),
        Drive::Bar { youngs_modulus_mpa, density_t_per_mm3, area_mm2, .. } => {
            let impedance = area_mm2.unwrap_or(on_mm2) * (youngs_modulus_mpa * density_t_per_mm3).sqrt();
            let mass_t = impedance * sample.element_size_mm / FASTEST_WAVE;
            let wave = if drive.fastest() == 0.0 { Vec::new() } else { drive.arrived(on_mm2).rows(jump_s) };
            Motion::Bar { impedance, mass_t, wave }
        }
        Drive::Mass { mass_kg, speed_m_per_s } => {
            Motion::Mass { mass_t: 1e-3 * mass_kg, speed_mm_per_s: 1e3 * speed_m_per_s }
        }
    }
}

fn pressure(sample: &Sample, sides: &Sides, support: &SupportSpec) -> Result<Pressure, TrialError> {
    let faces = nodes::pressed_faces(sample.mesh, sides, support)?;
    Ok(Pressure { name: support.name.clone(), faces, mpa: support.pressure_mpa })
}
