//! A test from its first step to its last.
//!
//! Central differences: forces from displacements at a whole step, velocities at the half step after it. Blocks of
//! elements go in parallel, each into its own part of the forces; then runs of nodes go in parallel. Every sum has a fixed
//! order, so the bytes do not hang on the threads.

mod checkpoint;
pub mod device;

pub use checkpoint::checkpoint_note;

use crate::assemble::mass::SAFETY;
use crate::assemble::parts::BlockParts;
use crate::assemble::patches::Patches;
use crate::assemble::{Assembly, assemble, box_shape, stable_s};
use crate::error::{SolveError, TEST};
use crate::march::curve::{Extra, Row, validate_columns};
use crate::march::gauges::{Reader, Setter};
use crate::march::nodes::{Nodes, Sums};
use crate::march::path::{Leg, Path};
use crate::march::servo::{Follower, Servo};
use crate::march::supports::contact::Motion;
use crate::march::supports::{Held, Moment, Supports};
use meso_collision::math::Aabb;
use meso_concrete::{PhaseNames, exceeds};
use meso_element::LawName;
use meso_element::block::matter::{self, Matter};
use meso_element::block::{Block, Common, Free, Pass, Scratch};
use meso_element::face::CohesionValues;
use meso_element::lanes::InstructionSet;
use meso_mesh::figures::MassScaling;
use meso_mesh::materials::{MATERIALS, Materials, Scatter, StrengthField};
use meso_mesh::{CellKind, Phase};
use meso_trial::Sample;
use meso_trial::{Control, Setup, Smoothing, Test};
use meso_trial::{MOST_SUPPORTS, OF_PLATES, OF_SUPPORTS, TurnOf};
use rayon::prelude::*;
use std::cell::RefCell;

/// Kinetic energy above this share of the plates' work is no test any more but a runaway.
pub(super) const RUNAWAY: f64 = 4.0;
/// Strength of interfaces in an elastic test, MPa.
const UNBREAKABLE: f64 = 1e6;

/// A test, ready to go or on its way.
pub struct Run<'a> {
    pub(crate) sample: Sample<'a>,
    pub(crate) test: Test,
    pub(crate) common: Common,
    pub(crate) blocks: Vec<Block>,
    pub(crate) patches: Option<Patches>,
    pub(crate) nodes: Nodes,
    /// The mesh's number of every node of the engine.
    pub(crate) order: Vec<u32>,
    forces: Vec<[f32; 4]>,
    /// Energy that each block spent in the step, mJ.
    spent: Vec<f64>,
    pub(crate) supports: Supports,
    /// Record of the test for its results.
    pub(crate) setup: Setup,
    /// Scatter of the strengths, unless the test has none.
    pub(crate) scatter: Option<Scatter>,
    pub(crate) path: Path,
    pub(crate) gauges: Vec<Reader>,
    /// Place of the gauge that controls the path, among all.
    leader: Option<usize>,
    pub(crate) set: InstructionSet,
    pub(crate) outline: Outline,
    pub(crate) state: State,
    /// Takes the steps instead of this processor.
    device: Option<device::Remote>,
}

/// Decisions before the first step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    pub(crate) dt: f64,
    /// At the plates' full speed.
    pub(crate) steps: u64,
    /// Steps between rows.
    pub(crate) stride: u64,
    /// Mass without and with scaling, tonne.
    pub(crate) masses: [f64; 2],
    /// Longest step that would need no mass, s.
    pub(crate) stable_s: f64,
    /// Widest crack band by phase, mm.
    pub(crate) widest_mm: [f64; PhaseNames::ROOM],
}

/// State that changes from step to step, without that of blocks and nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct State {
    pub(crate) step: u64,
    pub(crate) time: f64,
    /// Steps that the plates' way would have taken at full speed.
    pub(crate) progress: f64,
    /// Steps that the servo has added.
    pub(crate) added: f64,
    /// Speed of the path in the last step, mm/s.
    pub(crate) speed: f64,
    pub(crate) servo: Servo,
    /// The gauge that the test is controlled by.
    pub(crate) follower: Follower,
    /// Place on the path, mm: of two plates, the way of one against the other in the test's sense.
    pub(crate) travel: f64,
    /// Where a path with turns is.
    pub(crate) leg: Leg,
    /// Places and speeds of the plates that a servo drives.
    pub(crate) held: [Held; MOST_SUPPORTS],
    /// Forces of the supports in the last step, N.
    pub(crate) forces: [f64; MOST_SUPPORTS],
    pub(crate) external: f64,
    pub(crate) internal: f64,
    pub(crate) friction: f64,
    pub(crate) kinetic: f64,
    /// Spent in cracks, crushing, plastic flow and lost hourglass modes, mJ.
    pub(crate) spent: f64,
    pub(crate) since_row: Since,
    pub(crate) rows: Vec<Row>,
    /// Further columns, row by row.
    pub(crate) extra: Vec<f64>,
}

impl State {
    /// The numbers of a step: its time, its place on the path and the energies.
    pub(crate) fn numbers(&self) -> [f64; 10] {
        let Self { time, progress, added, speed, travel, external, internal, friction, kinetic, spent, .. } = *self;
        [time, progress, added, speed, travel, external, internal, friction, kinetic, spent]
    }

    /// Takes the [`numbers`](Self::numbers) of a step.
    pub(crate) fn take(&mut self, numbers: [f64; 10]) {
        let Self { time, progress, added, speed, travel, external, internal, friction, kinetic, spent, .. } = self;
        [*time, *progress, *added, *speed, *travel, *external, *internal, *friction, *kinetic, *spent] = numbers;
    }
}

/// Sums over the steps since the last row.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Since {
    pub(crate) forces: [f64; MOST_SUPPORTS],
    /// Of plates with a servo or a drive, mm/s.
    pub(crate) speeds: [f64; MOST_SUPPORTS],
    pub(crate) travel: f64,
    pub(crate) count: f64,
    /// One for each gauge.
    pub(crate) gauges: Vec<f64>,
}

thread_local! {
    /// Memory that a thread computes blocks in.
    pub(crate) static SCRATCH: RefCell<Scratch> = RefCell::new(Scratch::default());
}

/// A step of two digits that adds at most a fifth of the mass, where `dt` needs `factor` times of it: masses that are
/// added fall with the square of the step.
fn lighter_step(dt: f64, factor: f64) -> String {
    let step = dt * (0.2 / factor).sqrt();
    let unit = libm::exp10(libm::log10(step).floor() - 1.0);
    format!("{:.1e}", (step / unit).floor() * unit)
}

impl<'a> Run<'a> {
    /// Prepares a test; nothing moves yet.
    ///
    /// # Errors
    /// Values out of range, laws that cannot have them, meshes without plates' faces or with cells of no volume: all
    /// before the first step, with the way out.
    pub fn new(sample: Sample<'a>, materials: &Materials, test: &Test) -> Result<Self, SolveError> {
        test.validate()?;
        validate_columns(test)?;
        sample.validate()?;
        validate_smoothing(&sample, test)?;
        matter::validate(materials, test.law)?;
        materials.suits(&sample.mesh.phases)?;
        let (mesh, geometry) = (sample.mesh, sample.geometry());
        let scatter = materials.scattered().filter(|_| test.law != LawName::Elastic).cloned();
        scatter.iter().try_for_each(|own| own.suits(sample.element_size_mm, !mesh.cohesive.is_empty()))?;
        let is_there = |own: &Scatter| own.has(Phase::Mortar) || mesh.phase.contains(&Phase::Itz);
        let why = r#"the mesh has no ITZ of cells; name "mortar", too"#;
        let is_met = scatter.as_ref().is_none_or(is_there);
        MATERIALS.require("scatter.phases", r#"["itz"]"#, is_met, why)?;
        let field = scatter.as_ref().map(Scatter::field);
        let strengths: Option<&StrengthField> = field.as_ref();
        let mut common = common(&sample, &materials.in_mesh(mesh), test)?;
        let rig = test.rig(&geometry)?;
        let smoothing = test.smoothing(mesh.kind);
        let expansion = test.expansion();
        expansion.as_ref().map_or(Ok(()), |expansion| expansion.suits(mesh))?;
        let below = expansion.map_or(Ok(Vec::new()), |expansion| expansion.below_the_layer(&sample))?;
        let (steps, dt) = if test.is_fast() {
            test.suits_waves(sample.element_size_mm, &materials.mortar)?;
            let parts =
                BlockParts { sample: &sample, common: &common, dt: 0.0, smoothing, below: &below, strengths: None };
            in_real_time(test, test.duration_s(&geometry), stable_s(&parts)?)?
        } else {
            test.steps(&geometry, sample.element_size_mm, !mesh.cohesive.is_empty())?
        };
        if test.rate_effect {
            common.matter.iter_mut().for_each(|matter| matter.rate(dt));
        }
        let Assembly { blocks, patches, nodes: order, mass, masses, stable_s, widest_mm } =
            assemble(&BlockParts { sample: &sample, common: &common, dt, smoothing, below: &below, strengths })?;
        if test.is_fast() && exceeds(masses[1], masses[0] * (1.0 + 1e-9)) {
            let why = "its cohesive faces need mass, and a test in real time adds none; take a solid ITZ";
            return Err(SolveError::mesh(why));
        }
        let factor = masses[1] / masses[0];
        let why = || {
            let fits = lighter_step(dt, factor);
            format!(
                "it needs {factor:.0} times the mass: inertia would carry this test; take {fits}, which adds at most 20 %, or check the units of the materials"
            )
        };
        TEST.require("time_step_s", dt, !exceeds(factor, MassScaling::MOST), why())?;
        let places = || order.iter().map(|&node| mesh.points[node as usize].into()).collect();
        common.free = test.expansion().map(|_| Free::new(places()));
        let mut number = vec![0; order.len()];
        (0..).zip(&order).for_each(|(new, &old)| number[old as usize] = new);
        let e_mpa = common.matter[Phase::Mortar.index()].elastic.youngs_modulus_mpa;
        let (length_mm, axis) = (rig.length_mm, rig.axis);
        let setup = Setup::of(test, &geometry, rig.supports.clone());
        let supports = Supports::new(&sample, rig, &number, &mass, e_mpa)?;
        let setter = Setter {
            sample: &sample,
            axis,
            sign: supports.sign,
            has_path: test.has_path() || test.is_fast(),
            number: &number,
            mass: &mass,
        };
        let (gauges, leader) = (setter.all(&test.gauges())?, test.leader());
        sample.validate_volume()?;
        let lone = mass.iter().filter(|mass| !mass.is_normal()).count();
        if lone > 0 {
            return Err(SolveError::mesh(format!("{lone} of its nodes belong to no cell; leave them out")));
        }
        let mut nodes = Nodes::new(mass, &blocks);
        let mut state = State::default();
        if test.starts_moving {
            let ratio = common.matter[Phase::Mortar.index()].elastic.poisson_ratio;
            let places = order.iter().map(|&node| mesh.points[node as usize]);
            nodes.stretch(places, &Aabb::around(&mesh.points), (axis, supports.first()), ratio);
            state.external = nodes.kinetic();
        }
        let forces = vec![[0.0; 4]; nodes.places()];
        let spent = vec![0.0; blocks.len()];
        let set = InstructionSet::best();
        let path = Path::new(test, length_mm, dt * steps as f64, test.lead_s(&geometry, supports.lead()));
        let steps = path.steps(steps, dt);
        let stride = (steps / u64::from(test.rows)).max(1);
        let outline = Outline { dt, steps, stride, masses, stable_s, widest_mm };
        let run = Self {
            sample,
            test: test.clone(),
            common,
            blocks,
            patches,
            nodes,
            order,
            forces,
            spent,
            supports,
            setup,
            scatter,
            path,
            gauges,
            leader,
            set,
            outline,
            state,
            device: None,
        };
        Ok(run)
    }

    /// Takes the steps with the instruction set `set` where this machine has it; the results are the same bytes.
    pub fn with_instructions(self, set: InstructionSet) -> Self {
        Self { set: set.or_best(), ..self }
    }

    /// Steps of the whole test at the plates' full speed; the servo adds some.
    pub fn steps(&self) -> u64 {
        self.outline.steps
    }

    /// s.
    pub fn time_step_s(&self) -> f64 {
        self.outline.dt
    }

    /// Faults of mesh and step that a strength must not be cited without, in a few words each.
    pub fn flags(&self) -> Vec<String> {
        let factor = self.mass_factor();
        let heavy = exceeds(factor, self.much_mass()).then(|| format!("{factor:.1} times the mass"));
        self.sample.flags().into_iter().chain(heavy).collect()
    }

    /// Mass of the test over the specimen's own.
    fn mass_factor(&self) -> f64 {
        self.outline.masses[1] / self.outline.masses[0]
    }

    /// Mass over the specimen's own that is worth a warning.
    fn much_mass(&self) -> f64 {
        MassScaling::much(self.test.time_step_s.is_some())
    }

    /// Warnings about the mesh, the step and the scatter, in sentences, known before the first step.
    pub fn doubts(&self) -> Vec<String> {
        let mut doubts = self.sample.doubts();
        let factor = self.mass_factor();
        if exceeds(factor, self.much_mass()) {
            let fits = lighter_step(self.outline.dt, factor);
            let step = self.outline.dt;
            doubts.push(format!(
                "the time step of {step:.3e} s needs {factor:.3} times the mass, whose inertia shows in the curve: take \
                 time_step_s = {fits}, which adds at most 20 %, or check the units of the materials"
            ));
        }
        let longest = Aabb::around(&self.sample.mesh.points).size().amax();
        doubts.extend(self.scatter.iter().filter_map(|own| own.doubt(self.sample.element_size_mm, longest)));
        doubts
    }

    /// Mass added over the specimen's own, percent.
    pub fn added_mass_percent(&self) -> f64 {
        100.0 * (self.mass_factor() - 1.0)
    }

    /// Scatter of the strengths of its mortar and ITZ, unless there is none.
    pub fn scatter(&self) -> Option<&Scatter> {
        self.scatter.as_ref()
    }

    /// Bytes that the engine holds, the mesh apart.
    pub fn bytes(&self) -> usize {
        let blocks: usize = self.blocks.iter().map(Block::bytes).sum();
        let patches = self.patches.as_ref().map_or(0, Patches::bytes);
        blocks + patches + self.nodes.bytes() + size_of_val(&*self.order) + size_of_val(&*self.forces)
    }

    /// Takes one step.
    pub(crate) fn advance(&mut self) -> Result<(), String> {
        self.expand();
        let Outline { dt, steps, .. } = self.outline;
        let steps = steps as f64;
        let is_followed = self.is_followed();
        let (pace, speed) = self.speed(steps);
        self.add_gauges();
        let state = &self.state;
        let is_driven = self.supports.is_driven;
        let now = state.progress * dt - self.path.lead_s;
        let resisted = self.supports.answer();
        if resisted {
            self.resist()?;
        }
        if is_driven {
            let Self { supports, nodes, forces, state, device, .. } = self;
            let free = |node, axis| match &*device {
                Some(remote) => {
                    let [u, v] = remote.free(node, axis);
                    [nodes.mass[node], u, v]
                }
                None => nodes.free(forces, dt, (node, axis)),
            };
            supports.drive((dt, now), free, &mut state.held);
        }
        let state = &self.state;
        let travel = if is_driven { self.supports.approach(&state.held) } else { state.travel + speed * dt };
        let (mean_speed, time) = (0.5 * (speed + state.speed), (state.progress + pace) * dt);
        let moment = Moment { travel, mean_speed, share: self.path.share(time), leads: time < self.path.lead_s };
        let motion = self.supports.motion(dt, &moment, &state.held);
        let (sums, spent) = self.step(&motion, resisted)?;
        let state = &mut self.state;
        let since = &mut state.since_row;
        since.forces.iter_mut().zip(&sums.supports).for_each(|(sum, force)| *sum += force);
        self.supports.add_pressures(&motion, &mut since.forces);
        since.speeds.iter_mut().zip(&state.held).for_each(|(sum, [_, speed, before])| *sum += 0.5 * (speed + before));
        since.travel += state.travel;
        since.count += 1.0;
        // A path with turns alone asks for the last forces, and a device that takes many steps does not give them.
        if !self.path.turns.is_empty() {
            state.forces = sums.supports;
        }
        self.supports.follow(dt, &moment, &sums.supports, &mut state.held);
        state.external += sums.external;
        state.internal += sums.internal;
        state.friction += sums.friction;
        state.kinetic = sums.kinetic;
        (state.travel, state.speed) = (travel, speed);
        state.step += 1;
        state.time = state.step as f64 * dt;
        state.progress += pace;
        state.added += 1.0 - pace;
        if !is_followed {
            state.servo.rest(state.external - state.friction - state.spent);
            return Ok(());
        }
        state.spent += spent;
        if self.test.control() != Control::Steady {
            self.hold_back([spent, sums.external - sums.friction], steps);
        }
        Ok(())
    }

    /// Lets the elements resist and the nodes move, here or on a device. Returns the sums over the nodes and the energy that the
    /// elements spent, mJ. `resisted`: the forces of this step are there.
    fn step(&mut self, motion: &Motion, resisted: bool) -> Result<(Sums, f64), String> {
        if self.device.is_some() {
            return self.step_there(motion);
        }
        if !resisted {
            self.resist()?;
        }
        let sums = self.nodes.advance(self.set, &self.forces, &self.supports, motion);
        Ok((sums, self.spent.iter().sum()))
    }

    /// Lets the servo follow a step in which cracks `spent` and the plates `supplied` energy.
    fn hold_back(&mut self, [spent, supplied]: [f64; 2], steps: f64) {
        let Self { state, path, leader, gauges, nodes, outline, .. } = self;
        let stored = state.external - state.friction - state.spent;
        let allows = leader.map(|gauge| {
            let (value, moved) = (gauges[gauge].read(&nodes.displacement), state.speed * outline.dt);
            let is_sound = path.begins(state.progress * outline.dt);
            state.follower.follow(value, [state.travel, moved], is_sound, steps)
        });
        state.servo.follow([stored, spent, supplied], allows, steps);
        if !path.turns.is_empty() {
            state.servo.give_back();
        }
    }

    /// Whether the servo counts a step: cracks of phases that grow spend no energy that the supports supplied.
    fn is_followed(&self) -> bool {
        let grows = self.common.free.is_some() && self.state.progress * self.outline.dt < self.path.lead_s;
        !grows && (self.test.has_path() || self.supports.is_driven)
    }

    /// Lets the phases expand to their strains at the present displacements.
    fn expand(&mut self) {
        if let (Some(expansion), Some(free)) = (self.test.expansion(), &mut self.common.free) {
            let time = self.state.progress * self.outline.dt;
            free.set(expansion.at((time / self.path.lead_s).min(1.0), self.path.share(time)));
        }
    }

    /// Pace and speed of the path in the next step.
    fn speed(&mut self, steps: f64) -> (f64, f64) {
        let Self { state, path, supports, outline, .. } = self;
        let (dt, pace) = (outline.dt, state.servo.pace);
        if path.turns.is_empty() || state.progress * dt < path.lead_s {
            // The last step goes no further than the test.
            let pace = pace.min(steps - state.progress);
            return (pace, pace * path.straight(state.progress * dt + 0.5 * pace * dt));
        }
        let (stress, travel) = (supports.stress(&state.forces), state.travel);
        let opening = || {
            self.gauges.iter().find(|gauge| gauge.is_mouth).map_or(0.0, |gauge| gauge.read(&self.nodes.displacement))
        };
        let reading = |of| match of {
            TurnOf::Strain => travel / path.length_mm,
            TurnOf::Stress => stress,
            TurnOf::Opening => opening(),
        };
        (pace, pace * path.turning(&mut state.leg, travel, pace * dt, reading))
    }

    /// Adds the gauges' values to the sums of the row.
    fn add_gauges(&mut self) {
        let Self { gauges, nodes, state, .. } = self;
        state.since_row.gauges.resize(gauges.len(), 0.0);
        for (sum, gauge) in state.since_row.gauges.iter_mut().zip(gauges).filter(|(_, gauge)| !gauge.is_momentum) {
            *sum += gauge.read(&nodes.displacement);
        }
    }

    /// Displacement of the first support along its axis, mm: pictures show the specimen against it.
    pub(crate) fn rest(&self) -> [f64; 3] {
        let mut rest = [0.0; 3];
        if let Some(first) = self.supports.all.first() {
            rest[first.face.axis] = first.moves * self.state.travel + self.state.held[0][0];
        }
        rest
    }

    /// Further columns of the curve; none where the test has the columns of every test alone.
    pub(crate) fn extra(&self) -> Extra {
        let forces = self.supports.all.iter().map(|fixture| format!("{}_n", fixture.name));
        let driven = self.supports.all.iter().filter_map(|fixture| Some((&fixture.name, fixture.driven.as_ref()?)));
        let moved = driven.flat_map(|(name, driven)| {
            let ends = if driven.waves(0.0, 0.0).is_some() { &OF_SUPPORTS[1..] } else { &OF_SUPPORTS[1..2] };
            ends.iter().map(move |end| format!("{name}{end}"))
        });
        let plates = OF_PLATES.iter().filter(|_| self.is_between_plates()).map(|&name| name.to_owned());
        let names = self.gauges.iter().map(|gauge| gauge.name.clone()).chain(forces).chain(moved).chain(plates);
        if !self.test.has_extra() {
            return Extra::default();
        }
        Extra { names: names.collect(), values: self.state.extra.clone() }
    }

    /// Whether two plates press or pull in real time.
    fn is_between_plates(&self) -> bool {
        self.supports.is_driven && self.supports.has_two_ends()
    }

    /// The elements' forces at the present displacements.
    fn resist(&mut self) -> Result<(), String> {
        if let Some(remote) = &mut self.device {
            return remote.resist();
        }
        let Self { blocks, forces, spent, common, nodes, set, .. } = self;
        let (displacement, set) = (&nodes.displacement[..], *set);
        let mut rest = &mut forces[..];
        let mut outs = Vec::with_capacity(blocks.len());
        for block in blocks.iter() {
            let (out, more) = rest.split_at_mut(block.nodes.len());
            outs.push(out);
            rest = more;
        }
        blocks.par_iter_mut().zip(outs).zip(spent).for_each(|((block, out), spent)| {
            SCRATCH.with_borrow_mut(|scratch| *spent = set.step(Pass { block, common, displacement, out, scratch }));
        });
        Ok(())
    }

    /// Adds a row of the curve from the steps since the last one, unless a value is NaN or infinite.
    pub(crate) fn add_row(&mut self) -> bool {
        let Since { forces, speeds, travel, count, mut gauges } = std::mem::take(&mut self.state.since_row);
        // A momentum is the way of its masses since the last row over the time, so its sum begins at the last row's end.
        self.state.since_row.gauges.resize(gauges.len(), 0.0);
        let parts = self.gauges.iter().zip(&mut gauges).zip(&mut self.state.since_row.gauges);
        for ((gauge, sum), next) in parts.filter(|((gauge, _), _)| gauge.is_momentum) {
            let now = gauge.read(&self.nodes.displacement);
            (*sum, *next) = ((*sum + now) / self.outline.dt, -now);
        }
        let [bottom, top] = self.supports.stresses(self.supports.at_ends(&forces), count);
        let groups = || self.blocks.iter().flat_map(|block| &block.groups);
        let state = &self.state;
        let row = Row {
            strain: travel / count / self.supports.length_mm,
            stress_mpa: self.supports.mean([bottom, top]),
            kinetic: state.kinetic,
            internal: state.internal,
            external: state.external,
            friction_work: state.friction,
            hourglass: groups().map(|group| group.hourglass[0] + group.hourglass[1]).sum(),
            dissipated: groups().map(|group| group.dissipated).sum(),
            stress_bottom_mpa: bottom,
            stress_top_mpa: top,
            time_s: state.time,
        };
        let is_sound = row.values().iter().all(|value| value.is_finite());
        if is_sound {
            self.state.rows.push(row);
            if self.test.has_extra() {
                let pressed = self.supports.all.iter().zip(&forces).map(|(fixture, force)| fixture.face.inward * force);
                self.state.extra.extend(gauges.iter().copied().chain(pressed).map(|sum| sum / count));
                for ((fixture, force), speed) in self.supports.all.iter().zip(&forces).zip(&speeds) {
                    let Some(driven) = &fixture.driven else { continue };
                    let [force, speed] = [force, speed].map(|sum| fixture.face.inward * sum / count);
                    self.state.extra.push(1e-3 * speed);
                    self.state.extra.extend(driven.waves(force, speed).into_iter().flatten());
                }
                if self.is_between_plates() {
                    let rate = self.supports.between(speeds.iter().copied()) / count / self.supports.length_mm;
                    let apart = if row.stress_mpa == 0.0 { 0.0 } else { (bottom - top) / row.stress_mpa };
                    self.state.extra.extend([rate, apart]);
                }
            }
        }
        is_sound
    }
}

/// Steps of a test in real time that lasts this long, and the length of each, s: the stable one, since no mass is added.
fn in_real_time(test: &Test, duration_s: f64, stable_s: f64) -> Result<(u64, f64), SolveError> {
    let most = SAFETY * stable_s;
    let asked = test.time_step_s.unwrap_or(most);
    let why = format!("a test in real time adds no mass; take {most:.3e} at most, or leave it out");
    TEST.require("time_step_s", asked, asked <= most * (1.0 + 1e-9), why)?;
    let steps = (duration_s / asked.min(most)).ceil();
    let why = format!("in steps of {asked:.3e} s these are {steps}; they must be 10 to 1e9");
    TEST.require("duration_s", duration_s, (10.0..=1e9).contains(&steps), why)?;
    Ok((steps as u64, duration_s / steps))
}

/// Boxes have no edges to smooth over.
fn validate_smoothing(sample: &Sample, test: &Test) -> Result<(), SolveError> {
    let kind = sample.mesh.kind;
    if kind == CellKind::Hexahedron && test.smoothing(kind) == Smoothing::Edges {
        return Err(SolveError::mesh("its boxes cannot be smoothed over edges; take tetrahedra, or no smoothing"));
    }
    Ok(())
}

/// Data that all elements share.
fn common(sample: &Sample, materials: &Materials, test: &Test) -> Result<Common, SolveError> {
    let shape = box_shape(sample.mesh)?;
    let cohesion = (!sample.mesh.cohesive.is_empty()).then(|| cohesion(materials, test)).transpose()?;
    let phases = &sample.mesh.phases;
    let matter = |phase| Matter::new(materials, phase, phases, test.law);
    // Places in the order of the phases' numbers; 3 is no phase of a mesh.
    let common = [Phase::Mortar, Phase::Itz, Phase::Aggregate, Phase::Aggregate, Phase::Fibre];
    let mut matter: Vec<Matter> = common.into_iter().chain(phases.own()).map(matter).collect();
    let scattered = materials.scattered().into_iter().flat_map(|own| Phase::SOLID.map(|phase| (phase, own)));
    for (phase, own) in scattered.filter(|(phase, own)| own.has(*phase)) {
        matter[phase.index()].scatter(own.most());
    }
    let mut stones = Vec::new();
    if let Some(stone) = materials.aggregate_strength.as_ref().filter(|_| test.law != LawName::Elastic) {
        stones = sample.mesh.id_of.iter().map(|&id| (phases.count() + stone.place(id)) as u16).collect();
        matter.extend(Matter::stones(materials, stone, test.law));
    }
    Ok(Common {
        matter,
        stones,
        shape,
        cohesion,
        hourglass: test.hourglass,
        band_mm: band_of_boxes(sample, test.law) * shape.edge(),
        free: None,
    })
}

/// Width of a crack band over the edge of a box. A crack that follows principal stresses keeps to one layer of boxes; the
/// stiff neighbours of a layer of damaged plasticity hinder its flow, so that it is tougher.
fn band_of_boxes(sample: &Sample, law: LawName) -> f64 {
    match law {
        LawName::Cdpm2 | LawName::Meso => 1.0,
        LawName::Elastic | LawName::Cdp => sample.band_factor,
    }
}

/// The values of cohesive faces, those of a deck but for the friction.
fn cohesion(materials: &Materials, test: &Test) -> Result<CohesionValues, SolveError> {
    let strength = materials.itz_strength(test.law);
    let (stiffness, friction) = (materials.separation_stiffness(), test.interface.friction);
    let opening = strength.fracture_energy_n_per_mm;
    let values = CohesionValues {
        stiffness,
        tensile: strength.tensile_mpa,
        shear: strength.cohesion_mpa(),
        energies: [opening, materials.cohesive_shear_energy_ratio * opening],
        exponent: materials.cohesive_mode_power,
        friction,
    };
    if test.law == LawName::Elastic {
        let energies = [UNBREAKABLE.powi(2); 2];
        return Ok(CohesionValues { tensile: UNBREAKABLE, shear: UNBREAKABLE, energies, ..values });
    }
    materials.validate_cohesive_softening(test.law)?;
    Ok(values)
}
