//! The seam to a device: a machine other than this processor that takes a run's steps, many at a time.
//!
//! [`Run::upload`] gives a run as plain data, [`Run::hand_to`] hands its steps to a [`Device`]. A device computes the bytes
//! that the processor would: rows, frames, checkpoints and the response are made here, of the state that it gives back.

pub use crate::march::nodes::SPAN;
pub use meso_element::block::matter::LawTask;
pub use meso_element::block::spent;

use super::{Run, Since, State};
use crate::error::SolveError;
use crate::march::servo::Servo;
use crate::march::supports::MOST;
use crate::test::load::Rule;
use crate::test::{Control, Test};
use meso_element::block::{Batch, Block, Group};
use meso_element::lanes::LANES;
use meso_element::real::Real;
use meso_element::uniform::Uniform;
use meso_mesh::CellKind;

/// Refuses tests that devices cannot take yet, as far as the test's options and the mesh's kind tell; one function, which the
/// command asks before it packs, and [`Run::upload`] again.
///
/// # Errors
/// Names the first thing that devices have no code for.
pub fn accept(test: &Test, kind: CellKind, is_cohesive: bool) -> Result<(), SolveError> {
    let why = match () {
        () if test.has_extra() => "devices take compression and tension without gauges; take one, or the device cpu",
        () if kind == CellKind::Hexahedron => "voxels run on the processor only; take tetrahedra, or the device cpu",
        () if is_cohesive => "cohesive faces run on the processor only; take another ITZ, or the device cpu",
        () => return Ok(()),
    };
    Err(SolveError::Device(why.to_owned()))
}

/// A machine that has a run's data and takes its steps.
pub trait Device: Send + Sync {
    /// Takes up to `most` steps, at least one. It ends after the first step with which the test is over, a row or a frame is due,
    /// or the energies are not sound.
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

/// Numbers that change from step to step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scalars {
    /// Steps taken.
    pub step: u64,
    /// Steps that the plates' way would have taken at full speed, and steps that the servo has added.
    pub progress: [f64; 2],
    /// Speed and travel of the upper plate against the lower one, mm/s and mm.
    pub plate: [f64; 2],
    /// The servo's pace, largest elastic energy and mean supply.
    pub servo: [f64; 3],
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
    /// Frames of the test.
    pub frames: u64,
    /// Whether the plates are glued on.
    pub is_tension: bool,
    /// Coulomb's coefficient.
    pub friction: f64,
    /// Speed of the plates after their ramp, mm/s, and its length, s.
    pub ramp: [f64; 2],
    /// Thresholds and shares of the servo; none where the plates keep their speed.
    pub servo: Option<[f64; 9]>,
    /// Kinetic energy of the specimen at a plate's speed, mJ, and the share of work beyond which a test runs away.
    pub sound: [f64; 2],
}

/// A run as plain data.
pub struct Upload<'a>(&'a Run<'a>);

/// Elements of one phase and kind within a block.
pub struct Elements<'a>(&'a Group);

impl Run<'_> {
    /// The run as plain data.
    ///
    /// # Errors
    /// See [`accept`].
    pub fn upload(&self) -> Result<Upload<'_>, SolveError> {
        let mesh = self.sample.mesh;
        accept(&self.test, mesh.kind, !mesh.cohesive.is_empty())?;
        if !self.common.stones.is_empty() {
            let why =
                "stone that breaks runs on the processor only; leave out aggregate_strength, or take --device cpu";
            return Err(SolveError::Device(why.to_owned()));
        }
        Ok(Upload(self))
    }

    /// Hands all further steps to `device`, which was made of the [`upload`](Self::upload) of this state.
    pub fn hand_to(&mut self, device: Box<dyn Device>) {
        self.device = Some(device);
    }

    /// Takes one step here, or on a device all that lead to the next event.
    pub(super) fn proceed(&mut self) -> Result<(), String> {
        let Some(mut device) = self.device.take() else {
            self.advance();
            return Ok(());
        };
        let mut scalars = self.scalars();
        let done = device.advance(&mut scalars, self.until_event());
        self.device = Some(device);
        self.take(&scalars);
        done
    }

    /// Steps at full speed to the next row or frame, or to the end.
    fn until_event(&self) -> u64 {
        let (taken, steps) = (self.state.progress, self.outline.steps as f64);
        let to_next = |period: f64| ((taken / period).floor() + 1.0) * period - taken;
        let frames = f64::from(self.test.frames);
        let to_frame = if frames > 0.0 { to_next(steps / frames) } else { f64::INFINITY };
        let left = to_next(self.outline.stride as f64).min(to_frame).min(steps - taken);
        left.ceil().max(1.0) as u64
    }

    /// Brings back the energies of the groups, for a row.
    pub(super) fn bring_back_energies(&mut self) -> Result<(), String> {
        let Some(device) = &mut self.device else { return Ok(()) };
        let mut groups: Vec<&mut Group> = self.blocks.iter_mut().flat_map(|block| &mut block.groups).collect();
        let mut energies = vec![0.0; groups.len()];
        device.dissipated(&mut energies)?;
        groups.iter_mut().zip(energies).for_each(|(group, energy)| group.dissipated = energy);
        Ok(())
    }

    /// Brings back all fields, for a frame, a checkpoint or the end.
    pub(super) fn bring_back(&mut self) -> Result<(), String> {
        self.bring_back_energies()?;
        let Some(device) = &mut self.device else { return Ok(()) };
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
        let State { step, progress, added, speed, travel, external, internal, friction, kinetic, spent, .. } =
            self.state;
        let (sign, since) = (self.supports.sign, &self.state.since_row);
        Scalars {
            step,
            progress: [progress, added],
            plate: [sign * speed, sign * travel],
            servo: self.state.servo.values(),
            energies: [external, internal, friction, kinetic, spent],
            since_row: [since.forces[0], since.forces[1], sign * since.travel, since.count],
        }
    }

    fn take(&mut self, scalars: &Scalars) {
        let Scalars { step, progress: [progress, added], plate: [speed, travel], servo, energies, since_row } =
            *scalars;
        let sign = self.supports.sign;
        let [external, internal, friction, kinetic, spent] = energies;
        let [bottom, top, way, count] = since_row;
        let mut forces = [0.0; MOST];
        forces[..2].copy_from_slice(&[bottom, top]);
        let since_row = Since { forces, travel: sign * way, count, gauges: Vec::new() };
        let (before, travel) = (std::mem::take(&mut self.state), sign * travel);
        let (time, servo) = (step as f64 * self.outline.dt, Servo::from_values(servo));
        self.state = State {
            step,
            time,
            progress,
            added,
            speed: sign * speed,
            servo,
            travel,
            external,
            internal,
            friction,
            kinetic,
            spent,
            since_row,
            ..before
        };
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
        let (face, sign) = (&run.supports.all[0].face, run.supports.sign);
        let (is_tension, friction, ramp) =
            (face.rule == Rule::Glued, face.friction, [sign * run.path.speed, run.path.ramp_s]);
        Rules {
            dt: outline.dt,
            steps: outline.steps,
            stride: outline.stride,
            frames: run.test.frames.into(),
            is_tension,
            friction,
            ramp,
            servo: (run.test.control == Control::Servo).then(|| Servo::rule(outline.steps as f64)),
            sound: [run.plate_energy(), super::drive::RUNAWAY],
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
    pub fn shares(&self) -> [&[u32]; 2] {
        self.0.nodes.shares()
    }

    /// Nodes that can meet a plate, ascending: the node, 0 for the lower plate or 1 for the upper one, and the gap, mm.
    pub fn contacts(&self) -> impl Iterator<Item = (u32, usize, f64)> {
        self.0.supports.contacts.iter().map(|contact| (contact.node, contact.support as usize, contact.gap))
    }

    /// Runs `task` with the law of a phase over any numbers.
    pub fn law<R: Real + 'static, T: LawTask<R>>(&self, phase: usize, task: T) -> T::Output {
        // A copy keeps no law prepared, so that the processor's lanes stay the first.
        self.0.common.matter[phase].clone().law(task)
    }
}

impl Elements<'_> {
    /// Number of their phase.
    pub fn phase(&self) -> usize {
        self.0.phase as usize
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
            Batch::Hexes(_) | Batch::Triangles(_) | Batch::Quads(_) => 0,
        }
    }

    /// All eights as words: the local numbers of the others and of the first node, node by node and two to a word; x, y, z of
    /// the others' gradients; volumes; widths.
    pub fn words(&self, out: &mut Vec<u32>) {
        fn all<const N: usize>(cells: &[Uniform<N>], out: &mut Vec<u32>) {
            cells.iter().for_each(|cells| cells.words(out));
        }
        match &self.0.cells {
            Batch::Tets(cells) => all(cells, out),
            Batch::Patches8(cells) => all(cells, out),
            Batch::Patches9(cells) => all(cells, out),
            Batch::Patches12(cells) => all(cells, out),
            Batch::Hexes(_) | Batch::Triangles(_) | Batch::Quads(_) => {}
        }
    }

    /// Registers of their memory.
    pub fn memory(&self) -> impl ExactSizeIterator<Item = [f32; LANES]> {
        self.0.memory.iter().map(|eight| eight.0)
    }
}
