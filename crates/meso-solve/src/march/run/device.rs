//! The seam to a device: a machine other than this processor that takes a run's steps, many at a time.
//!
//! [`Run::upload`] gives a run as plain data, [`Run::hand_to`] hands its steps to a [`Device`]. A device computes the bytes
//! that the processor would: rows, frames, checkpoints and the response are made here, of the state that it gives back.

pub use crate::march::nodes::SPAN;
pub use crate::march::supports::contact::Moved;
pub use meso_element::block::matter::LawTask;
pub use meso_element::block::{STRAINS, spent};
pub use meso_element::face::{Cohesion, CohesionValues};

use super::{Run, Since};
use crate::error::SolveError;
use crate::march::gauges::watched;
use crate::march::nodes::Sums;
use crate::march::servo::Servo;
use crate::march::supports::Supports;
use crate::march::supports::contact::{Contact, Face, Load, Motion};
use meso_element::block::{Batch, Block, Free, Group};
use meso_element::lanes::LANES;
use meso_element::real::Real;
use meso_element::uniform::Uniform;
use meso_mesh::CellKind;
use meso_trial::{Control, MOST_SUPPORTS, Rule};

/// Refuses meshes that devices cannot take. The command asks before it packs, and [`Run::upload`] again.
///
/// # Errors
/// Cells that devices have no code for, with a remedy.
pub fn accept(kind: CellKind) -> Result<(), SolveError> {
    if kind == CellKind::Hexahedron {
        let why = "voxels run on the processor only; take tetrahedra, or the device cpu";
        return Err(SolveError::Device(why.to_owned()));
    }
    Ok(())
}

/// A machine that has a run's data and takes its steps.
pub trait Device: Send + Sync {
    /// Lets the elements resist, as the first half of the next [`step`](Self::step). Gives the displacements of the
    /// [met](Upload::met) nodes, mm, and the velocities that they would have after the step without supports, mm/s.
    ///
    /// # Errors
    /// Says why the device failed.
    fn resist(&mut self) -> Result<&[[[f64; 3]; 2]], String>;

    /// Takes one step in which the supports move so, and phases have the strains of [`Free::strains`] without stress.
    ///
    /// # Errors
    /// Says why the device failed.
    fn step(&mut self, supports: &[Moved], free: [f64; 1 + STRAINS]) -> Result<StepSums<'_>, String>;

    /// Takes up to `most` steps, at least one. It ends after the first step with which the test is over, a row is due, or the
    /// energies are not sound; `most` steps at full speed reach no further than the next frame. Only [plain](Upload::is_plain) tests ask for it.
    ///
    /// # Errors
    /// Says why the device failed.
    fn advance(&mut self, scalars: &mut Scalars, most: u64) -> Result<(), String>;

    /// Energy that every group spent so far, mJ: block by block, group by group.
    ///
    /// # Errors
    /// Says why the device failed.
    fn dissipated(&mut self, groups: &mut [f64]) -> Result<(), String>;

    /// Displacements and velocities of all nodes.
    ///
    /// # Errors
    /// Says why the device failed.
    fn nodes(&mut self, displacement: &mut [[f64; 3]], velocity: &mut [[f64; 3]]) -> Result<(), String>;

    /// Registers of the elements' memory, from number `first` on: block by block, group by group, eight by eight.
    ///
    /// # Errors
    /// Says why the device failed.
    fn memory(&mut self, first: usize, registers: &mut [[f32; LANES]]) -> Result<(), String>;
}

/// The answer of a device to one step.
#[derive(Clone, Copy, Debug)]
pub struct StepSums<'a> {
    /// By span of [`SPAN`] nodes: forces of the supports, their work, friction, work of the elements' forces, kinetic energy.
    pub spans: &'a [f64],
    /// Energy that the elements spent, mJ.
    pub spent: f64,
    /// Displacements of the [watched](Upload::watched) nodes after the step, mm.
    pub watched: &'a [[f64; 3]],
}

/// Numbers that change from step to step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scalars {
    /// Steps taken.
    pub step: u64,
    /// Steps that the plates' way would have taken at full speed, and steps that the servo has added.
    pub progress: [f64; 2],
    /// Speed of the path and place on it, mm/s and mm.
    pub path: [f64; 2],
    /// The servo's pace, largest elastic energy, mean supply, elastic energy and its fall.
    pub servo: [f64; 5],
    /// Work of the plates, of the elements' forces and of friction; kinetic and spent energy, mJ.
    pub energies: [f64; 5],
    /// Sums since the last row.
    pub since_row: [f64; 4],
}

/// Numbers that a run keeps.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Length of a step, s.
    pub dt: f64,
    /// Steps at full speed.
    pub steps: u64,
    /// Steps between rows.
    pub stride: u64,
    /// Speed of the path after its ramp, mm/s, and the ramp's length, s.
    pub ramp: [f64; 2],
    /// Thresholds and lags of the servo; none where the plates keep their speed.
    pub servo: Option<[f64; 7]>,
    /// Kinetic energy of the specimen at a plate's speed, mJ, and the share of work beyond which a test runs away.
    pub sound: [f64; 2],
}

/// A run as plain data.
pub struct Upload<'a>(&'a Run<'a>);

/// A support at a node.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// The node.
    pub node: u32,
    /// Number of the support.
    pub support: u32,
    /// Its action.
    pub action: Action,
}

/// Action of a support on a node.
#[derive(Clone, Copy, Debug)]
pub enum Action {
    /// A plate may meet it, this far from it before the test, mm.
    Plate(f64),
    /// A load pushes it, with this force at a pressure of 1 MPa, N.
    Load([f64; 3]),
}

/// A device with the nodes whose displacements a run reads after every step.
pub(super) struct Remote {
    device: Box<dyn Device>,
    watched: Vec<u32>,
    /// Motion of the nodes under supports that answer, ahead of this step's supports, and by node its place there.
    ahead: Vec<[[f64; 3]; 2]>,
    place: Vec<u32>,
}

impl Remote {
    /// Lets the elements resist, and brings back the motion of the nodes under supports that answer.
    pub(super) fn resist(&mut self) -> Result<(), String> {
        self.ahead.clear();
        self.ahead.extend_from_slice(self.device.resist()?);
        Ok(())
    }

    /// Displacement and velocity along `axis` of a node under a support that answers, after a step without supports.
    pub(super) fn free(&self, node: usize, axis: usize) -> [f64; 2] {
        self.ahead[self.place[node] as usize].map(|values| values[axis])
    }
}

/// Elements of one phase and kind within a block.
pub struct Elements<'a>(&'a Group);

impl Run<'_> {
    /// The run as plain data.
    ///
    /// # Errors
    /// See [`accept`].
    pub fn upload(&self) -> Result<Upload<'_>, SolveError> {
        accept(self.sample.mesh.kind)?;
        Ok(Upload(self))
    }

    /// Hands all further steps to `device`, which was made of the [`upload`](Self::upload) of this state.
    pub fn hand_to(&mut self, device: Box<dyn Device>) {
        let mut place = vec![0; self.nodes.mass.len()];
        (0..).zip(self.supports.met()).for_each(|(own, node)| place[node as usize] = own);
        self.device = Some(Remote { device, watched: watched(&self.gauges), ahead: Vec::new(), place });
    }

    /// Takes one step, or on a device those of a plain test that lead to the next event.
    pub(crate) fn proceed(&mut self) -> Result<(), String> {
        let (mut scalars, most) = (self.scalars(), self.until_event());
        match &mut self.device {
            Some(remote) if !self.test.has_extra() => {
                let done = remote.device.advance(&mut scalars, most);
                self.take(&scalars);
                done
            }
            _ => self.advance(),
        }
    }

    /// Takes one step on the device.
    pub(super) fn step_there(&mut self, motion: &Motion) -> Result<(Sums, f64), String> {
        let Some(Remote { device, watched, .. }) = &mut self.device else {
            return Err("there is no device".to_owned());
        };
        let supports = self.supports.all.len();
        let free = self.common.free.as_ref().map(Free::strains).unwrap_or_default();
        let taken = device.step(&motion.supports[..supports], free)?;
        for (&node, u) in watched.iter().zip(taken.watched) {
            self.nodes.displacement[node as usize] = *u;
        }
        Ok((Sums::of_rows(taken.spans, supports), taken.spent))
    }

    /// Steps at full speed to the next row or frame, or to the end.
    fn until_event(&self) -> u64 {
        let (taken, steps) = (self.state.progress, self.outline.steps as f64);
        let to_next = |period: f64| ((taken / period).floor() + 1.0) * period - taken;
        let left = to_next(self.outline.stride as f64).min(self.until_frame()).min(steps - taken);
        left.ceil().max(1.0) as u64
    }

    /// Steps at full speed to the next frame, or fewer where the path's speed still grows.
    fn until_frame(&self) -> f64 {
        let (frames, share) = (f64::from(self.test.frames), self.frame_share());
        let to_next = ((share * frames).floor() + 1.0) / frames - share;
        let Run { path, outline, .. } = self;
        let steps =
            if path.gone(0.0).is_some() { path.limit_mm / (path.speed * outline.dt) } else { outline.steps as f64 };
        if frames > 0.0 { to_next * steps } else { f64::INFINITY }
    }

    /// Brings back the energies of the groups, for a row.
    pub(crate) fn bring_back_energies(&mut self) -> Result<(), String> {
        let Some(Remote { device, .. }) = &mut self.device else { return Ok(()) };
        let mut groups: Vec<&mut Group> = self.blocks.iter_mut().flat_map(|block| &mut block.groups).collect();
        let mut energies = vec![0.0; groups.len()];
        device.dissipated(&mut energies)?;
        groups.iter_mut().zip(energies).for_each(|(group, energy)| group.dissipated = energy);
        Ok(())
    }

    /// Brings back all fields, for a frame, a checkpoint or the end.
    pub(crate) fn bring_back(&mut self) -> Result<(), String> {
        self.bring_back_energies()?;
        let Some(Remote { device, .. }) = &mut self.device else { return Ok(()) };
        device.nodes(&mut self.nodes.displacement, &mut self.nodes.velocity)?;
        let mut first = 0;
        for block in &mut self.blocks {
            let count: usize = block.groups.iter().map(|group| group.memory.len()).sum();
            let mut registers = vec![[0.0; LANES]; count];
            device.memory(first, &mut registers)?;
            let memory = block.groups.iter_mut().flat_map(|group| &mut group.memory);
            memory.zip(registers).for_each(|(eight, register)| eight.0 = register);
            first += count;
        }
        Ok(())
    }

    fn scalars(&self) -> Scalars {
        let [_, progress, added, speed, travel, energies @ ..] = self.state.numbers();
        let since = &self.state.since_row;
        Scalars {
            step: self.state.step,
            progress: [progress, added],
            path: [speed, travel],
            servo: self.state.servo.values(),
            energies,
            since_row: [since.forces[0], since.forces[1], since.travel, since.count],
        }
    }

    fn take(&mut self, scalars: &Scalars) {
        let Scalars { step, progress: [progress, added], path: [speed, travel], servo, energies, since_row } = *scalars;
        let [external, internal, friction, kinetic, spent] = energies;
        let [bottom, top, way, count] = since_row;
        let mut forces = [0.0; MOST_SUPPORTS];
        forces[..2].copy_from_slice(&[bottom, top]);
        let (state, time) = (&mut self.state, step as f64 * self.outline.dt);
        state.take([time, progress, added, speed, travel, external, internal, friction, kinetic, spent]);
        (state.step, state.servo) = (step, Servo::from_values(servo));
        state.since_row = Since { forces, travel: way, count, ..Since::default() };
    }
}

impl Upload<'_> {
    /// Numbers that change from step to step.
    pub fn scalars(&self) -> Scalars {
        self.0.scalars()
    }

    /// Numbers that the run keeps.
    pub fn rules(&self) -> Rules {
        let (run, outline) = (self.0, self.0.outline);
        Rules {
            dt: outline.dt,
            steps: outline.steps,
            stride: outline.stride,
            ramp: [run.path.speed, run.path.ramp_s],
            servo: (run.test.control() == Control::Servo).then(|| Servo::rule(outline.steps as f64)),
            sound: [run.plate_energy(), super::RUNAWAY],
        }
    }

    /// Number of blocks.
    pub fn blocks(&self) -> usize {
        self.0.blocks.len()
    }

    /// Nodes of a block, ascending.
    pub fn nodes_of(&self, block: usize) -> &[u32] {
        &self.0.blocks[block].nodes
    }

    /// Elements of a block, in the order in which their forces add up.
    pub fn elements_of(&self, block: usize) -> impl Iterator<Item = Elements<'_>> {
        self.block(block).groups.iter().map(Elements)
    }

    fn block(&self, block: usize) -> &Block {
        &self.0.blocks[block]
    }

    /// Displacement and velocity of every node, mm and mm/s.
    pub fn motion(&self) -> [&[[f64; 3]]; 2] {
        [&self.0.nodes.displacement, &self.0.nodes.velocity]
    }

    /// Mass of every node, tonne.
    pub fn mass(&self) -> &[f64] {
        &self.0.nodes.mass
    }

    /// Where each node's shares begin, and their places among the blocks' forces.
    pub fn shares(&self) -> [Vec<u32>; 2] {
        self.0.nodes.shares()
    }

    /// Whether a device may take many steps at once: plates along one axis that a servo drives at most, without gauges.
    pub fn is_plain(&self) -> bool {
        !self.0.test.has_extra()
    }

    /// Whether the strengths of a material grow with the rate of strain, or scatter.
    pub fn are_scaled(&self) -> bool {
        self.0.common.matter.iter().any(|matter| matter.is_scaled())
    }

    /// Whether supports move in real time: their work is then that on the nodes, and not that along their own path.
    pub fn is_driven(&self) -> bool {
        self.0.supports.is_driven
    }

    /// By plate or load: its axis; 1 where the specimen is above it, else -1; whether it is glued on; its friction; its way for
    /// each mm of the path.
    pub fn supports(&self) -> impl Iterator<Item = [f64; 5]> {
        self.0.supports.all.iter().map(|fixture| {
            let Face { axis, inward, rule, friction } = fixture.face;
            [axis as f64, inward, f64::from(u8::from(rule == Rule::Glued)), friction, fixture.moves]
        })
    }

    /// Supports at nodes, by node: plates, then loads.
    pub fn touches(&self) -> Vec<Touch> {
        let Supports { contacts, loads, .. } = &self.0.supports;
        let plate = |own: &Contact| Touch { node: own.node, support: own.support, action: Action::Plate(own.gap) };
        let load = |own: &Load| Touch { node: own.node, support: own.support, action: Action::Load(own.force) };
        let mut all: Vec<Touch> = contacts.iter().map(plate).chain(loads.iter().map(load)).collect();
        all.sort_by_key(|touch| touch.node);
        all
    }

    /// Nodes whose displacements the run reads after every step.
    pub fn watched(&self) -> Vec<u32> {
        watched(&self.0.gauges)
    }

    /// Nodes under bars and masses, whose speed hangs on the forces of the step; ascending.
    pub fn met(&self) -> Vec<u32> {
        self.0.supports.met()
    }

    /// Places of all nodes, mm, where phases have strains without stress; else none.
    pub fn places(&self) -> &[[f64; 3]] {
        self.0.common.free.as_ref().map_or(&[], Free::places)
    }

    /// Number of materials.
    pub fn materials(&self) -> usize {
        self.0.common.matter.len()
    }

    /// Runs `task` with the law of a material over any numbers.
    pub fn law<R: Real + 'static, T: LawTask<R>>(&self, material: usize, task: T) -> T::Output {
        // A copy keeps no law prepared, so that the processor's lanes stay the first.
        self.0.common.matter[material].clone().law(task)
    }

    /// Values of cohesive faces; none of a mesh without them.
    pub fn cohesion(&self) -> Option<&CohesionValues> {
        self.0.common.cohesion.as_ref()
    }
}

impl Elements<'_> {
    /// Number of their strain among those of [`Free::strains`].
    pub fn free(&self) -> usize {
        self.0.free.into()
    }

    /// Number of their material; cohesive faces have none.
    pub fn material(&self) -> Option<usize> {
        (!matches!(self.0.cells, Batch::Triangles(_) | Batch::Quads(_))).then_some(self.0.matter.into())
    }

    /// Energy that they spent so far, mJ.
    pub fn dissipated(&self) -> f64 {
        self.0.dissipated
    }

    /// Number of eights.
    pub fn eights(&self) -> usize {
        self.0.numbers.len() / LANES
    }

    /// Nodes of each beside the first one.
    pub fn others(&self) -> usize {
        match &self.0.cells {
            Batch::Tets(_) => 3,
            Batch::Patches8(_) => 7,
            Batch::Patches9(_) => 8,
            Batch::Patches12(_) => 11,
            Batch::Triangles(_) => 5,
            Batch::Hexes(_) | Batch::Quads(_) => 0,
        }
    }

    /// All eights as words: see [`Uniform::words`], and [`Faces::words`](meso_element::face::Faces::words) for cohesive faces.
    pub fn words(&self, out: &mut Vec<u32>) {
        fn all<const N: usize>(cells: &[Uniform<N>], out: &mut Vec<u32>) {
            cells.iter().for_each(|cells| cells.words(out));
        }
        match &self.0.cells {
            Batch::Tets(cells) => all(cells, out),
            Batch::Patches8(cells) => all(cells, out),
            Batch::Patches9(cells) => all(cells, out),
            Batch::Patches12(cells) => all(cells, out),
            Batch::Triangles(faces) => faces.iter().for_each(|faces| faces.words(out)),
            Batch::Hexes(_) | Batch::Quads(_) => {}
        }
    }

    /// Registers of their memory.
    pub fn memory(&self) -> impl ExactSizeIterator<Item = [f32; LANES]> {
        self.0.memory.iter().map(|eight| eight.0)
    }
}
