//! Supports and loads of a test, and the nodes that they meet.
//!
//! The plates of a compression test do half of the way each, so the specimen's middle rests: its kinetic energy is then a
//! quarter of that beside a plate at rest, and no wave runs from one plate alone.

pub(crate) mod contact;
mod driven;

use crate::error::SolveError;
use crate::march::supports::contact::{Contact, Face, Load, Motion, Moved};
use crate::march::supports::driven::Driven;
use meso_mesh::cells::Sides;
use meso_trial::Rig;
use meso_trial::Sample;
use meso_trial::nodes;
use meso_trial::{MOST_SUPPORTS, Rule, SupportSpec};

/// Mass of a plate with a servo over the mass of its nodes. Forces of a step move the plate in the next one, which is
/// stable where the plate is heavier than its nodes.
const PLATE_MASS: f64 = 5.0;
/// Damping of a plate with a servo over the critical damping of plate and specimen.
const PLATE_DAMPING: f64 = 0.5;

/// The supports of a test and their nodes.
#[derive(Clone, Debug)]
pub(crate) struct Supports {
    /// By node.
    pub(crate) contacts: Vec<Contact>,
    /// By node.
    pub(crate) loads: Vec<Load>,
    /// In the order of the test.
    pub(crate) all: Vec<Fixture>,
    /// -1 where the path presses the specimen, 1 where it pulls.
    pub(crate) sign: f64,
    /// Sizes of the specimen along x, y and z, mm.
    size_mm: [f64; 3],
    /// Path over this is the strain, mm.
    pub(crate) length_mm: f64,
    /// Force over this is the stress, mm2.
    pub(crate) section_mm2: f64,
    /// That section over the area that breaks.
    pub(crate) breaking_share: f64,
    /// Whether plates move in real time.
    pub(crate) is_driven: bool,
}

/// One support.
#[derive(Clone, Debug)]
pub(crate) struct Fixture {
    pub(crate) name: String,
    pub(crate) face: Face,
    /// Its way for each mm of the path.
    pub(crate) moves: f64,
    /// Pressure that it has when the path begins, MPa.
    pressure_mpa: f64,
    stress_ratio: Option<f64>,
    /// Whether its force counts at the lower (0) or the upper end (1) of the test.
    end: Option<usize>,
    /// Area that it presses on, mm2.
    area_mm2: f64,
    /// Mass and damping of a plate with a servo, tonne and tonne/s.
    inertia: [f64; 2],
    /// What moves it in real time.
    pub(crate) driven: Option<Driven>,
}

/// Place and speed that a servo gives to a plate, and its speed in the step before, mm and mm/s along its axis.
pub(crate) type Held = [f64; 3];

/// A moment of a test that the supports follow.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment {
    /// Place and mean speed of the path.
    pub(crate) travel: f64,
    pub(crate) mean_speed: f64,
    /// Share of the loads that acts before the path begins, 0 to 1.
    pub(crate) share: f64,
    /// Whether the path has not begun.
    pub(crate) leads: bool,
}

impl Supports {
    /// Supports of `rig`; `number` gives the engine's numbers of the mesh's nodes, and `mass` their mass.
    ///
    /// # Errors
    /// No face of the specimen looks to a support, no node lies under a strip, or two supports contradict each other.
    pub(crate) fn new(sample: &Sample, rig: Rig, number: &[u32], mass: &[f64], e_mpa: f64) -> Result<Self, SolveError> {
        let sides = Sides::of(sample.mesh);
        let (mut contacts, mut loads) = (Vec::new(), Vec::new());
        let mut all = Vec::with_capacity(rig.supports.len());
        for (place, support) in (0..).zip(&rig.supports) {
            let mut fixture = Fixture::new(support, rig.axis);
            if support.rule == Rule::Pressure {
                let forces = nodes::forces(sample.mesh, &sides, support)?.into_iter();
                loads.extend(forces.map(|(node, force)| Load { node: number[node as usize], support: place, force }));
                fixture.area_mm2 = nodes::pressed_mm2(sample.mesh, &sides, support)?;
            } else {
                let under = nodes::under(sample, &sides, support)?.into_iter();
                let contact = |(node, gap)| Contact { node: number[node as usize], support: place, gap };
                let own: Vec<Contact> = under.map(contact).collect();
                fixture.area_mm2 = nodes::area_mm2(sample.mesh, &sides, support);
                let heavy = PLATE_MASS * own.iter().map(|contact| mass[contact.node as usize]).sum::<f64>();
                let stiffness = e_mpa * fixture.area_mm2 / rig.length_mm;
                fixture.inertia = [heavy, 2.0 * PLATE_DAMPING * (stiffness * heavy).sqrt()];
                contacts.extend(own);
            }
            all.push(fixture);
        }
        let members = contacts.iter().map(|contact| (contact.node, contact.support)).collect();
        rig.agree(members)?;
        let axis = |contact: &Contact| all[contact.support as usize].face.axis;
        contacts.sort_by_key(|contact| (contact.node, contact.support));
        contacts.dedup_by(|a, b| a.node == b.node && axis(a) == axis(b));
        loads.sort_by_key(|load| (load.node, load.support));
        for (place, fixture) in (0..).zip(&mut all) {
            if let Some(driven) = &mut fixture.driven {
                let own = contacts.iter().filter(|contact| contact.support == place);
                driven.stand_on(fixture.area_mm2, own.copied().collect());
            }
        }
        let way = |end| all.iter().filter(|fixture| fixture.end == Some(end)).map(Fixture::way).sum::<f64>();
        let sign = if way(1) - way(0) > 0.0 { 1.0 } else { -1.0 };
        let Rig { length_mm, section_mm2, breaking_mm2, .. } = rig;
        let is_driven = all.iter().any(|fixture| fixture.driven.is_some());
        let breaking_share = section_mm2 / breaking_mm2;
        let size_mm = sample.geometry().size_mm;
        Ok(Self { contacts, loads, all, sign, size_mm, length_mm, section_mm2, breaking_share, is_driven })
    }

    /// Sum of the `forces` at the lower and at the upper end, N along the axis.
    pub(crate) fn at_ends(&self, forces: &[f64; MOST_SUPPORTS]) -> [f64; 2] {
        let mut ends = [0.0; 2];
        for (fixture, force) in self.all.iter().zip(forces) {
            if let Some(end) = fixture.end {
                ends[end] += force;
            }
        }
        ends
    }

    /// Stress of the lower and of the upper end under such forces, MPa, positive in the test's sense.
    pub(crate) fn stresses(&self, [bottom, top]: [f64; 2], count: f64) -> [f64; 2] {
        let stress = |force: f64| self.sign * force / count / self.section_mm2;
        [stress(-bottom), stress(top)]
    }

    /// Whether plates stand on both ends.
    pub(crate) fn has_two_ends(&self) -> bool {
        let has = |end| self.all.iter().any(|fixture| fixture.end == Some(end));
        has(0) && has(1)
    }

    /// Mean of the stresses of both ends, or the stress of the one that the test has.
    pub(crate) fn mean(&self, [bottom, top]: [f64; 2]) -> f64 {
        let is_one = self.is_driven && !self.has_two_ends();
        if is_one { bottom + top } else { 0.5 * (top + bottom) }
    }

    /// Stress in a step with these forces, MPa.
    pub(crate) fn stress(&self, forces: &[f64; MOST_SUPPORTS]) -> f64 {
        self.mean(self.stresses(self.at_ends(forces), 1.0))
    }

    /// A step of all supports.
    pub(crate) fn motion(&self, dt: f64, moment: &Moment, held: &[Held; MOST_SUPPORTS]) -> Motion {
        let mut supports = [Moved::default(); MOST_SUPPORTS];
        for ((fixture, moved), [at, speed, before]) in self.all.iter().zip(&mut supports).zip(held) {
            *moved = Moved {
                travel: fixture.moves * moment.travel + at,
                mean_speed: fixture.moves * moment.mean_speed + 0.5 * (speed + before),
                pressure: fixture.pressure_mpa * moment.share,
            };
        }
        Motion { dt, supports }
    }

    /// Adds the forces of pressures in a step, which no plate carries, to those of all supports, N.
    pub(crate) fn add_pressures(&self, motion: &Motion, forces: &mut [f64; MOST_SUPPORTS]) {
        for ((fixture, moved), force) in self.all.iter().zip(&motion.supports).zip(forces) {
            if fixture.face.rule == Rule::Pressure {
                *force += fixture.face.inward * moved.pressure * fixture.area_mm2;
            }
        }
    }

    /// Whether loads grow before the path begins.
    pub(crate) fn lead(&self) -> bool {
        self.all.iter().any(|fixture| fixture.pressure_mpa != 0.0)
    }

    /// Moves the plates with a servo by a step, towards the force that each should have.
    pub(crate) fn follow(
        &self,
        dt: f64,
        moment: &Moment,
        forces: &[f64; MOST_SUPPORTS],
        held: &mut [Held; MOST_SUPPORTS],
    ) {
        let stress = self.stress(forces);
        for ((fixture, force), [at, speed, before]) in self.all.iter().zip(forces).zip(held) {
            *before = *speed;
            if fixture.driven.is_some() {
                continue;
            }
            let Some(pressure) = fixture.wanted(moment, stress) else {
                *speed = 0.0;
                continue;
            };
            let [mass, damping] = fixture.inertia;
            let wanted = fixture.face.inward * pressure * fixture.area_mm2;
            *speed += dt / mass * (wanted - force - damping * *speed);
            *at += dt * *speed;
        }
    }

    /// The contacts of nodes from `first` to before `end`.
    pub(crate) fn among(&self, first: usize, end: usize) -> &[Contact] {
        let at = |node: usize| self.contacts.partition_point(|contact| (contact.node as usize) < node);
        &self.contacts[at(first)..at(end)]
    }

    /// The loads on nodes from `first` to before `end`.
    pub(crate) fn loads_among(&self, first: usize, end: usize) -> &[Load] {
        let at = |node: usize| self.loads.partition_point(|load| (load.node as usize) < node);
        &self.loads[at(first)..at(end)]
    }
}

impl Fixture {
    /// A support of a test along `axis`; its nodes' share comes later.
    fn new(support: &SupportSpec, axis: usize) -> Self {
        let (own, is_upper) = support.on.bit().map_or((0, false), |bit| (bit / 2, bit % 2 == 1));
        let inward = if is_upper { -1.0 } else { 1.0 };
        let counts = support.rule != Rule::Pressure && own == axis && support.stress_ratio.is_none();
        Self {
            name: support.name.clone(),
            face: Face { axis: own, inward, rule: support.rule, friction: support.friction },
            moves: support.moves,
            pressure_mpa: support.pressure_mpa,
            stress_ratio: support.stress_ratio,
            end: counts.then_some(usize::from(is_upper)),
            area_mm2: 0.0,
            inertia: [1.0, 0.0],
            driven: support.drive.clone().map(Driven::of),
        }
    }

    /// Whether its speed hangs on the specimen's forces.
    pub(crate) fn answers(&self) -> bool {
        self.driven.as_ref().is_some_and(Driven::answers)
    }

    /// The speed of largest size that its drive gives, mm/s towards the specimen; 0 without a drive.
    fn fastest(&self) -> f64 {
        self.driven.as_ref().map_or(0.0, |driven| driven.fastest)
    }

    /// Its way for each mm of the path, or the sense in which it is driven.
    fn way(&self) -> f64 {
        if self.driven.is_some() { self.face.inward * self.fastest() } else { self.moves }
    }

    /// The pressure that a servo gives to it, MPa; none where it follows the path.
    fn wanted(&self, moment: &Moment, stress: f64) -> Option<f64> {
        if self.face.rule == Rule::Pressure {
            return None;
        }
        let lead = (self.pressure_mpa != 0.0 && moment.leads).then_some(self.pressure_mpa * moment.share);
        match self.stress_ratio {
            Some(ratio) => Some(self.pressure_mpa * moment.share + ratio * stress),
            None => lead,
        }
    }
}
