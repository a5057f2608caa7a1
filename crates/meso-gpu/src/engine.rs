//! A run on a device: its tables in the device's memory, and its steps.

use crate::devices::open;
use crate::host::{Buffer, Host, Kernel};
use crate::name::DeviceName;
use crate::source::Laws;
use crate::tables::{LANES, Tables};
use bytemuck::{cast_slice, cast_slice_mut};
use meso_solve::device::{Device, Rules, Scalars, Upload};
use std::time::{Duration, Instant};

/// Numbers of the kernels' `state`, and of its flag that a batch has ended.
const STATE: usize = 23;
const HALT: usize = 17;
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
    steps: [(Kernel, usize, usize); 4],
    begin: Kernel,
    state: Buffer,
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
        let laws = Laws::of(upload);
        let (tables, threads) = fitting(upload, &laws, device.threads);
        let mut host = open(device)?;
        host.compile(&laws.source(&tables, threads))?;
        let mut store = Store { host: &mut *host, bytes: 0 };
        let [u, v] = upload.motion();
        let (u, v) = (store.of(u.as_flattened())?, store.of(v.as_flattened())?);
        let (data, memory) = fields(upload, &tables, &mut store)?;
        let nodes = upload.mass().len();
        let (contact, gaps) = contacts(upload);
        let spans = tables.span_contacts.len() - 1;
        let sizes = [nodes as u32, upload.blocks() as u32, spans as u32, gaps.len() as u32];
        let (sizes, rules) = (store.of(&sizes)?, store.of(&rules(&upload.rules()))?);
        let state = store.empty(8 * STATE)?;
        let shares = store.empty(16 * tables.places.len())?;
        let (spent, work) = (store.empty(8 * upload.blocks())?, store.empty(16 * nodes)?);
        let (met, span_sums) = (store.empty(32 * gaps.len())?, store.empty(8 * (6 * spans + 1))?);
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
        ];
        let [first, places] = upload.shares();
        let (first, places, mass) = (store.of(first)?, store.of(places)?, store.of(upload.mass())?);
        let (contact, gaps) = (store.of(&contact)?, store.of(&gaps)?);
        let moving = [sizes, rules, state, first, places, shares, mass, u, v, contact, gaps, work, met];
        let summing = [sizes, state, work, met, store.of(&tables.span_contacts)?, spent, span_sums];
        let bytes = store.bytes;
        let steps = [
            (host.kernel("elements", &elements)?, upload.blocks(), threads),
            (host.kernel("nodes", &moving)?, nodes.div_ceil(NODES), NODES),
            (host.kernel("sums", &summing)?, spans + 1, SUMS),
            (host.kernel("scalars", &[sizes, rules, span_sums, state])?, 1, 64),
        ];
        let begin = host.kernel("begin", &[rules, state])?;
        Ok(Self { host, steps, begin, state, u, v, memory, dissipated, pace: None, bytes })
    }
}

/// Tables for groups of `threads`, or of fewer where a group would share too much memory.
fn fitting(upload: &Upload, laws: &Laws, mut threads: usize) -> (Tables, usize) {
    loop {
        let tables = Tables::of(upload, &laws.of_phase, threads);
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

/// By node: 0, or twice the number of its contact, from 1, and 1 more on the upper plate; the contacts' gaps.
fn contacts(upload: &Upload) -> (Vec<u32>, Vec<f64>) {
    let (mut of_node, mut gaps) = (vec![0; upload.mass().len()], Vec::new());
    for (node, plate, gap) in upload.contacts() {
        gaps.push(gap);
        of_node[node as usize] = 2 * gaps.len() as u32 + plate as u32;
    }
    (of_node, gaps)
}

/// Numbers that stay, in the kernels' order.
fn rules(rules: &Rules) -> [f64; 20] {
    let [speed, ramp_s] = rules.ramp;
    let [plate_energy, runaway] = rules.sound;
    let flag = |holds: bool| f64::from(u8::from(holds));
    let mut all = [0.0; 20];
    all[..11].copy_from_slice(&[
        rules.dt,
        rules.steps as f64,
        rules.stride as f64,
        rules.frames as f64,
        rules.friction,
        speed,
        ramp_s,
        plate_energy,
        runaway,
        flag(rules.is_tension),
        flag(rules.servo.is_some()),
    ]);
    all[11..].copy_from_slice(&rules.servo.unwrap_or_default());
    all
}

fn state_of(scalars: &Scalars) -> [f64; STATE] {
    let Scalars { step, progress, plate, servo, energies, since_row } = scalars;
    let mut state = [0.0; STATE];
    let numbers =
        [*step as f64].into_iter().chain(*progress).chain(*plate).chain(*servo).chain(*energies).chain(*since_row);
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
        plate: [speed, travel],
        servo: [pace, most, supply],
        energies: [external, internal, friction, kinetic, spent],
        since_row: [a, b, c, d],
    }
}

impl Device for Engine {
    fn advance(&mut self, scalars: &mut Scalars, most: u64) -> Result<(), String> {
        // The first batch is one step, which also says how long a step takes.
        let fitting = self.pace.map_or(1, |pace| (BATCH.as_nanos() / pace.as_nanos().max(1)) as u64);
        let (steps, begun) = (most.min(fitting).max(1), Instant::now());
        let mut state = state_of(scalars);
        self.host.write(self.state, 0, cast_slice(&state))?;
        self.host.launch(self.begin, 1, 1)?;
        for _ in 0..steps {
            for (kernel, groups, threads) in self.steps {
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
