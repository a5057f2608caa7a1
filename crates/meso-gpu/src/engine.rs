//! A run on a device: its tables in the device's memory, and its steps.

use crate::devices::open;
use crate::host::{Buffer, Host, Kernel};
use crate::name::DeviceName;
use crate::source::Laws;
use crate::tables::{LANES, Tables, accept};
use bytemuck::{cast_slice, cast_slice_mut};
use meso_solve::device::{Action, Device, Moved, Rules, STRAINS, Scalars, StepSums, Touch, Upload};
use std::time::{Duration, Instant};

/// Numbers of the kernels' `state` before those of the supports, three each, and the strains without stress; the place of its flag that a batch
/// has ended.
const STATE: usize = 23;
const HALT: usize = 19;
/// Numbers of the kernels' `rules` before those of the supports.
const RULES: usize = 15;
/// Bits of a support at a node: it is the node's last one; it is a load.
const LAST: u32 = 256;
const LOAD: u32 = 512;
/// Threads of a group for nodes and for sums, as the kernels' source has them.
const NODES: usize = 256;
const SUMS: usize = 256;
/// Memory that a group may share on every card of CUDA without asking for more, bytes.
const NEAR_BYTES: usize = 48 << 10;
/// Bytes beyond the memory's end that kernels may fetch ahead.
const AHEAD: usize = 4 * LANES * LANES;
/// Longest batch of steps: whoever stops a test waits no longer.
const BATCH: Duration = Duration::from_millis(250);

/// A run on a device.
pub(crate) struct Engine {
    host: Box<dyn Host>,
    /// Kernels of a step, with their groups and threads: the first lets the elements resist.
    steps: Vec<(Kernel, usize, usize)>,
    /// What gives the motion ahead of the supports' of the met nodes, its buffer, and its last answer.
    meets: Option<((Kernel, usize, usize), Buffer)>,
    ahead: Vec<[[f64; 3]; 2]>,
    /// Whether the elements have resisted in the step that comes next.
    has_resisted: bool,
    begin: Kernel,
    state: Buffer,
    sums: Buffer,
    /// Sums of a step, and displacements of the watched nodes.
    answer: Vec<f64>,
    watched: usize,
    u: Buffer,
    v: Buffer,
    memory: Buffer,
    dissipated: Buffer,
    /// Mean length of a step so far.
    pace: Option<Duration>,
    /// Bytes on the device.
    pub(crate) bytes: usize,
}

/// Buffers, counted.
struct Store<'a> {
    host: &'a mut dyn Host,
    bytes: usize,
}

impl Store<'_> {
    fn empty(&mut self, bytes: usize) -> Result<Buffer, String> {
        self.bytes += bytes;
        self.host.buffer(bytes)
    }

    fn of<T: bytemuck::NoUninit>(&mut self, values: &[T]) -> Result<Buffer, String> {
        let buffer = self.empty(size_of_val(values))?;
        self.host.write(buffer, 0, cast_slice(values))?;
        Ok(buffer)
    }
}

impl Engine {
    /// Puts a run onto a device.
    pub(crate) fn new(upload: &Upload, device: &DeviceName) -> Result<Self, String> {
        Self::on(open(device)?, upload, device.threads)
    }

    /// Puts a run onto an open device, whose groups of elements have so many threads.
    pub(crate) fn on(mut host: Box<dyn Host>, upload: &Upload, threads: usize) -> Result<Self, String> {
        accept(upload)?;
        let laws = Laws::of(upload);
        let (tables, threads) = fitting(upload, &laws, threads);
        host.compile(&laws.source(&tables, threads))?;
        let mut store = Store { host: &mut *host, bytes: 0 };
        let [u, v] = upload.motion();
        let (u, v) = (store.of(u.as_flattened())?, store.of(v.as_flattened())?);
        let (data, memory) = fields(upload, &tables, &mut store)?;
        let nodes = upload.mass().len();
        let (touches, watched, supports) = (upload.touches(), upload.watched(), tables.supports);
        let (touch, kinds, numbers) = touching(&touches, nodes);
        let spans = tables.span_touches.len() - 1;
        let sizes = [nodes, upload.blocks(), spans, touches.len(), watched.len()].map(|count| count as u32);
        let (sizes, rules) = (store.of(&sizes)?, store.of(&rules(&upload.rules(), upload.supports()))?);
        let state = store.of(&vec![0.0; STATE + 3 * supports + 1 + STRAINS])?;
        let shares = store.empty(16 * tables.places.len())?;
        let (spent, work) = (store.empty(8 * upload.blocks())?, store.empty(16 * nodes)?);
        let answer = vec![0.0; (supports + 4) * spans + 1 + 3 * watched.len()];
        let (met, sums) = (store.of(&vec![0.0; (supports + 2) * touches.len()])?, store.of(&answer)?);
        let dissipated = store.of(&tables.dissipated)?;
        let elements = [
            store.of(tables.blocks.as_flattened())?,
            store.of(&tables.places)?,
            store.of(tables.eights.as_flattened())?,
            data,
            memory,
            store.of(tables.rounds.as_flattened())?,
            store.of(&tables.entries)?,
            store.of(&tables.slots)?,
            store.of(&tables.segments)?,
            store.of(&tables.energies)?,
            store.of(&laws.params)?,
            u,
            shares,
            dissipated,
            spent,
            state,
            store.of(upload.places().as_flattened())?,
        ];
        let [first, places] = upload.shares();
        let (first, places, mass) = (store.of(&first)?, store.of(&places)?, store.of(upload.mass())?);
        let (touch, kinds, numbers) = (store.of(&touch)?, store.of(&kinds)?, store.of(&numbers)?);
        let met_nodes = upload.met();
        let ahead = vec![[[0.0; 3]; 2]; met_nodes.len()];
        let meeting = if met_nodes.is_empty() {
            None
        } else {
            let (which, answers) = (store.of(&met_nodes)?, store.of(ahead.as_flattened().as_flattened())?);
            let arguments =
                [store.of(&[met_nodes.len() as u32])?, rules, first, places, shares, mass, u, v, which, answers];
            Some((arguments, answers))
        };
        let moving = [sizes, rules, state, first, places, shares, mass, u, v, touch, kinds, numbers, work, met];
        let summing = [sizes, state, work, met, store.of(&tables.span_touches)?, spent, sums];
        let watching = [sizes, store.of(&watched)?, u, sums];
        let bytes = store.bytes;
        let mut steps = vec![
            (host.kernel("elements", &elements)?, upload.blocks(), threads),
            (host.kernel("nodes", &moving)?, nodes.div_ceil(NODES), NODES),
            (host.kernel("sums", &summing)?, spans + 1, SUMS),
        ];
        if upload.is_plain() {
            steps.push((host.kernel("scalars", &[sizes, rules, sums, state])?, 1, 64));
        } else if !watched.is_empty() {
            steps.push((host.kernel("watch", &watching)?, watched.len().div_ceil(NODES), NODES));
        }
        let groups = met_nodes.len().div_ceil(NODES);
        let meets = meeting
            .map(|(arguments, answers)| Ok::<_, String>(((host.kernel("ahead", &arguments)?, groups, NODES), answers)));
        let meets = meets.transpose()?;
        let begin = host.kernel("begin", &[rules, state])?;
        let watched = watched.len();
        Ok(Self {
            host,
            steps,
            meets,
            ahead,
            has_resisted: false,
            begin,
            state,
            sums,
            answer,
            watched,
            u,
            v,
            memory,
            dissipated,
            pace: None,
            bytes,
        })
    }
}

/// Tables for groups of `threads`, or of fewer where a group would share too much memory.
fn fitting(upload: &Upload, laws: &Laws, mut threads: usize) -> (Tables, usize) {
    loop {
        let tables = Tables::of(upload, &laws.of_material, threads);
        if tables.near_bytes(threads) <= NEAR_BYTES || threads <= 32 {
            return (tables, threads);
        }
        threads /= 2;
    }
}

/// The elements' data and memory, some blocks at a time.
fn fields(upload: &Upload, tables: &Tables, store: &mut Store) -> Result<(Buffer, Buffer), String> {
    let total = |words: &[u64]| 4 * words.last().copied().unwrap_or(0) as usize;
    let (data, memory) = (store.empty(total(&tables.data))?, store.empty(total(&tables.memory) + AHEAD)?);
    let numbers: Vec<usize> = (0..upload.blocks()).collect();
    for some in numbers.chunks(256) {
        let (mut words, mut registers) = (Vec::new(), Vec::new());
        for elements in some.iter().flat_map(|&block| upload.elements_of(block)) {
            elements.words(&mut words);
            registers.extend(elements.memory());
        }
        store.host.write(data, 4 * tables.data[some[0]] as usize, cast_slice(&words))?;
        store.host.write(memory, 4 * tables.memory[some[0]] as usize, cast_slice(registers.as_flattened()))?;
    }
    Ok((data, memory))
}

/// By node: 0, or the number of its first support, from 1. By support at a node: its number and bits; the gap to a plate, or the
/// force of a load.
fn touching(touches: &[Touch], nodes: usize) -> (Vec<u32>, Vec<u32>, Vec<f64>) {
    let (mut first, mut kinds, mut numbers) = (vec![0; nodes], Vec::new(), Vec::new());
    for own in touches.chunk_by(|a, b| a.node == b.node) {
        first[own[0].node as usize] = kinds.len() as u32 + 1;
        for touch in own {
            let (kind, values) = match touch.action {
                Action::Plate(gap) => (0, [gap, 0.0, 0.0]),
                Action::Load(force) => (LOAD, force),
            };
            kinds.push(touch.support | kind);
            numbers.extend(values);
        }
        kinds.iter_mut().last().into_iter().for_each(|kind| *kind |= LAST);
    }
    (first, kinds, numbers)
}

/// Numbers that stay, in the kernels' order.
fn rules(rules: &Rules, supports: impl Iterator<Item = [f64; 5]>) -> Vec<f64> {
    let ([speed, ramp_s], [plate_energy, runaway]) = (rules.ramp, rules.sound);
    let has_servo = f64::from(u8::from(rules.servo.is_some()));
    let counts = [rules.steps, rules.stride].map(|count| count as f64);
    let mut all = vec![rules.dt];
    all.extend(counts.into_iter().chain([speed, ramp_s, plate_energy, runaway, has_servo]));
    all.extend(rules.servo.unwrap_or_default());
    debug_assert_eq!(all.len(), RULES);
    all.extend(supports.flatten());
    all
}

fn state_of(scalars: &Scalars) -> [f64; STATE] {
    let Scalars { step, progress, path, servo, energies, since_row } = scalars;
    let mut state = [0.0; STATE];
    let numbers =
        [*step as f64].into_iter().chain(*progress).chain(*path).chain(*servo).chain(*energies).chain(*since_row);
    state.iter_mut().zip(numbers).for_each(|(own, x)| *own = x);
    state
}

fn scalars_of(state: &[f64; STATE]) -> Scalars {
    let [
        step,
        progress,
        held,
        speed,
        travel,
        pace,
        most,
        supply,
        stored,
        fall,
        external,
        internal,
        friction,
        kinetic,
        spent,
        a,
        b,
        c,
        d,
        ..,
    ] = *state;
    Scalars {
        step: step as u64,
        progress: [progress, held],
        path: [speed, travel],
        servo: [pace, most, supply, stored, fall],
        energies: [external, internal, friction, kinetic, spent],
        since_row: [a, b, c, d],
    }
}

impl Device for Engine {
    fn resist(&mut self) -> Result<&[[[f64; 3]; 2]], String> {
        let kernels = self.steps.first().into_iter().chain(self.meets.as_ref().map(|(kernel, _)| kernel));
        for &(kernel, groups, threads) in kernels {
            self.host.launch(kernel, groups, threads)?;
        }
        if let Some((_, answers)) = self.meets {
            self.host.read(answers, 0, cast_slice_mut(self.ahead.as_flattened_mut().as_flattened_mut()))?;
        }
        self.has_resisted = true;
        Ok(&self.ahead)
    }

    fn step(&mut self, supports: &[Moved], free: [f64; 1 + STRAINS]) -> Result<StepSums<'_>, String> {
        let moved = supports.iter().flat_map(|moved| [moved.travel, moved.mean_speed, moved.pressure]);
        let numbers: Vec<f64> = moved.chain(free).collect();
        self.host.write(self.state, 8 * STATE, cast_slice(&numbers))?;
        let taken = usize::from(std::mem::take(&mut self.has_resisted));
        for &(kernel, groups, threads) in &self.steps[taken..] {
            self.host.launch(kernel, groups, threads)?;
        }
        self.host.read(self.sums, 0, cast_slice_mut(&mut self.answer))?;
        let (sums, watched) = self.answer.split_at(self.answer.len() - 3 * self.watched);
        let (spans, spent) = sums.split_at(sums.len() - 1);
        Ok(StepSums { spans, spent: spent[0], watched: watched.as_chunks().0 })
    }

    fn advance(&mut self, scalars: &mut Scalars, most: u64) -> Result<(), String> {
        // The first batch is one step, which also says how long a step takes.
        let fitting = self.pace.map_or(1, |pace| (BATCH.as_nanos() / pace.as_nanos().max(1)) as u64);
        let (steps, begun) = (most.min(fitting).max(1), Instant::now());
        let mut state = state_of(scalars);
        self.host.write(self.state, 0, cast_slice(&state))?;
        self.host.launch(self.begin, 1, 1)?;
        for _ in 0..steps {
            for &(kernel, groups, threads) in &self.steps {
                self.host.launch(kernel, groups, threads)?;
            }
        }
        self.host.read(self.state, 0, cast_slice_mut(&mut state))?;
        debug_assert!(state[HALT] <= 1.0);
        let taken = scalars_of(&state);
        let count = (taken.step - scalars.step).max(1) as u32;
        self.pace = Some(begun.elapsed() / count);
        *scalars = taken;
        Ok(())
    }

    fn dissipated(&mut self, groups: &mut [f64]) -> Result<(), String> {
        self.host.read(self.dissipated, 0, cast_slice_mut(groups))
    }

    fn nodes(&mut self, displacement: &mut [[f64; 3]], velocity: &mut [[f64; 3]]) -> Result<(), String> {
        self.host.read(self.u, 0, cast_slice_mut(displacement.as_flattened_mut()))?;
        self.host.read(self.v, 0, cast_slice_mut(velocity.as_flattened_mut()))
    }

    fn memory(&mut self, first: usize, registers: &mut [[f32; LANES]]) -> Result<(), String> {
        self.host.read(self.memory, 4 * LANES * first, cast_slice_mut(registers.as_flattened_mut()))
    }
}
