//! A run in flat tables, as the kernels read them.
//!
//! A group of threads takes a block of the engine in rounds: each round takes as many elements as there are threads, leaves
//! their forces in shared memory, and adds these to the block's nodes in the engine's order. So blocks, sums and bytes are the
//! engine's, and shared memory does not grow with the block.

use meso_solve::device::{Action, Elements, SPAN, Upload};
use rayon::prelude::*;

/// Elements side by side in the engine.
pub(crate) const LANES: usize = 8;
/// Words of an eight's record: data, memory, parameters, nodes and law.
type Eight = [u32; 4];

/// Tables of a run.
#[derive(Default)]
pub(crate) struct Tables {
    /// By block: first place, places, first round, rounds, first eight, eights, first energy, energies.
    pub(crate) blocks: Vec<[u32; 8]>,
    /// Node of every place.
    pub(crate) places: Vec<u32>,
    /// Where an eight's data and memory begin, the parameters of its law; its other nodes, law, strain and first slot in its round.
    pub(crate) eights: Vec<Eight>,
    /// By round: first entry, entries and the block's first eight in the upper half, first slot, first segment; one more at the
    /// end.
    pub(crate) rounds: Vec<[u32; 4]>,
    /// Places that a round adds to, and where their slots begin in the round's; one more at the end of a round.
    pub(crate) entries: Vec<u32>,
    /// Forces in shared memory, in the order of their sum.
    pub(crate) slots: Vec<u16>,
    /// Eights of a round whose energies go to one group of the block: energy, first eight, eights.
    pub(crate) segments: Vec<u32>,
    /// The engine's group of every energy.
    pub(crate) energies: Vec<u32>,
    /// Energy that each group of the engine has spent so far, mJ.
    pub(crate) dissipated: Vec<f64>,
    /// First support at a node of every span of nodes; one more at the end.
    pub(crate) span_touches: Vec<u32>,
    /// Number of supports, most of them at one node, and whether loads are among them.
    pub(crate) supports: usize,
    pub(crate) most_touches: usize,
    pub(crate) has_loads: bool,
    /// Whether supports move in real time.
    pub(crate) is_driven: bool,
    /// Whether phases have strains without stress.
    pub(crate) expands: bool,
    /// Words of the eights' data and of their memory, by block; one more at the end.
    pub(crate) data: Vec<u64>,
    pub(crate) memory: Vec<u64>,
    /// Most places of a block, most slots of a round, most energies of a block.
    pub(crate) most_places: usize,
    pub(crate) most_slots: usize,
    pub(crate) most_energies: usize,
    /// Numbers of other nodes that elements have.
    pub(crate) kinds: Vec<usize>,
}

/// A material's law by number, and where its parameters begin.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct OwnLaw {
    pub(crate) law: u32,
    pub(crate) params: u32,
    pub(crate) remembered: usize,
}

/// Tables of one block, numbered from 0.
#[derive(Default)]
struct Part {
    eights: Vec<Eight>,
    rounds: Vec<[u32; 4]>,
    entries: Vec<u32>,
    slots: Vec<u16>,
    segments: Vec<u32>,
    /// Numbers of the block's groups that spend.
    energies: Vec<u32>,
    dissipated: Vec<f64>,
    data: u64,
    memory: u64,
    kinds: Vec<usize>,
    most_slots: usize,
}

/// Refuses runs whose elements have more words than a number of 32 bits counts: some 600 million smoothed tetrahedra.
pub(crate) fn accept(upload: &Upload) -> Result<(), String> {
    let elements = (0..upload.blocks()).flat_map(|block| upload.elements_of(block));
    let words: u64 = elements.map(|own| own.eights() as u64 * words_of(own.others()) as u64).sum();
    if words > u64::from(u32::MAX) {
        return Err(format!("its elements would have {words} words, and it takes 4 G; take larger elements"));
    }
    Ok(())
}

impl Tables {
    /// Tables for groups of `threads`.
    pub(crate) fn of(upload: &Upload, laws: &[OwnLaw], threads: usize) -> Self {
        let mut all = Self { most_energies: 1, ..Self::default() };
        let numbers: Vec<usize> = (0..upload.blocks()).collect();
        for some in numbers.chunks(256) {
            let parts: Vec<Part> = some.par_iter().map(|&block| Part::of(upload, laws, threads, block)).collect();
            some.iter().zip(parts).for_each(|(&block, part)| all.add(upload, block, &part));
        }
        all.rounds.push([all.entries.len() as u32, 0, all.slots.len() as u32, all.segments.len() as u32]);
        all.slots.push(0);
        all.kinds.sort_unstable();
        let (touches, spans) = (upload.touches(), upload.mass().len().div_ceil(SPAN));
        let first = |span: usize| touches.partition_point(|touch| (touch.node as usize) < span * SPAN) as u32;
        all.span_touches = (0..=spans).map(first).collect();
        all.expands = !upload.places().is_empty();
        all.supports = upload.supports().count();
        all.most_touches = touches.chunk_by(|a, b| a.node == b.node).map(<[_]>::len).max().unwrap_or(0);
        all.is_driven = upload.is_driven();
        all.has_loads = touches.iter().any(|touch| matches!(touch.action, Action::Load(_)));
        all
    }

    /// Memory that a group of `threads` shares: two vectors a place, one a slot, two numbers a thread, eight an energy.
    pub(crate) fn near_bytes(&self, threads: usize) -> usize {
        4 * (6 * self.most_places + 3 * self.most_slots + 2 * threads + LANES * self.most_energies)
    }

    fn add(&mut self, upload: &Upload, block: usize, part: &Part) {
        let nodes = upload.nodes_of(block);
        let at = |list: usize| u32::try_from(list).expect("tables have fewer than 4 G entries");
        self.blocks.push([
            at(self.places.len()),
            at(nodes.len()),
            at(self.rounds.len()),
            at(part.rounds.len()),
            at(self.eights.len()),
            at(part.eights.len()),
            at(self.energies.len()),
            at(part.energies.len()),
        ]);
        let (entry, slot, segment) = (at(self.entries.len()), at(self.slots.len()), at(self.segments.len()));
        let (data, memory) = (self.data.last().copied().unwrap_or(0), self.memory.last().copied().unwrap_or(0));
        if block == 0 {
            (self.data, self.memory) = (vec![0], vec![0]);
        }
        let word = |x: u64| u32::try_from(x).expect("fields have fewer than 4 G words");
        self.eights.extend(part.eights.iter().map(|[d, m, p, n]| [word(data) + d, word(memory) + m, *p, *n]));
        self.rounds.extend(part.rounds.iter().map(|[e, n, s, g]| [entry + e, *n, slot + s, segment + g]));
        let group = at(self.dissipated.len());
        self.energies.extend(part.energies.iter().map(|own| group + own));
        self.places.extend(nodes);
        self.entries.extend(&part.entries);
        self.slots.extend(&part.slots);
        self.segments.extend(&part.segments);
        self.dissipated.extend(&part.dissipated);
        self.data.push(data + part.data);
        self.memory.push(memory + part.memory);
        self.most_places = self.most_places.max(nodes.len());
        self.most_energies = self.most_energies.max(part.energies.len());
        self.most_slots = self.most_slots.max(part.most_slots);
        for &kind in &part.kinds {
            if !self.kinds.contains(&kind) {
                self.kinds.push(kind);
            }
        }
    }
}

/// Words of an eight with some other nodes.
pub(crate) const fn words_of(others: usize) -> usize {
    4 * (others + 1) + 24 + 12 * others
}

impl Part {
    fn of(upload: &Upload, laws: &[OwnLaw], threads: usize, block: usize) -> Self {
        let mut part = Self::default();
        let mut words = Vec::new();
        for (group, elements) in (0..).zip(upload.elements_of(block)) {
            let law = elements.material().map_or_else(|| laws.last(), |material| laws.get(material));
            part.add(&elements, law.expect("every material has a law"), group);
            elements.words(&mut words);
        }
        part.sum(&words, upload.nodes_of(block).len(), threads);
        part
    }

    /// Adds the records of a group's eights. Until the rounds are made, a segment is energy, first eight, eights of a group.
    fn add(&mut self, elements: &Elements, law: &OwnLaw, group: u32) {
        let others = elements.others();
        self.kinds.push(others);
        self.dissipated.push(elements.dissipated());
        if law.remembered > 0 {
            self.segments.extend([self.energies.len() as u32, self.eights.len() as u32, elements.eights() as u32]);
            self.energies.push(group);
        }
        for _ in 0..elements.eights() {
            self.eights.push([
                self.data as u32,
                self.memory as u32,
                law.params,
                others as u32 | law.law << 8 | (elements.free() as u32) << 12,
            ]);
            self.data += words_of(others) as u64;
            self.memory += (LANES * law.remembered) as u64;
        }
    }

    /// Makes the rounds.
    fn sum(&mut self, words: &[u32], places: usize, threads: usize) {
        let groups: Vec<[u32; 3]> =
            std::mem::take(&mut self.segments).chunks_exact(3).map(|group| [group[0], group[1], group[2]]).collect();
        let mut of_place = vec![Vec::new(); places];
        let mut first = 0;
        while first < self.eights.len() {
            let (first_entry, first_slot) = (self.entries.len(), self.slots.len());
            let (mut end, mut used) = (first, 0);
            while let Some(eight) = self.eights.get_mut(end) {
                let others = (eight[3] & 255) as usize;
                if end - first == threads / LANES || used + padded(others) > MOST_SLOTS * threads {
                    break;
                }
                eight[3] |= (used as u32) << 16;
                slots_of(&words[eight[0] as usize..], others, used, &mut of_place);
                used += padded(others);
                end += 1;
            }
            self.most_slots = self.most_slots.max(used);
            for (place, slots) in of_place.iter_mut().enumerate().filter(|(_, slots)| !slots.is_empty()) {
                self.entries.push(place as u32 | ((self.slots.len() - first_slot) as u32) << 16);
                self.slots.append(slots);
            }
            let count = self.entries.len() - first_entry;
            self.entries.push(0xffff | ((self.slots.len() - first_slot) as u32) << 16);
            let counts = count as u32 | (first as u32) << 16;
            self.rounds.push([first_entry as u32, counts, first_slot as u32, self.segments.len() as u32]);
            for &[energy, start, eights] in &groups {
                let (from, to) = (start.max(first as u32), (start + eights).min(end as u32));
                if from < to {
                    self.segments.push(energy | (from - first as u32) << 16 | (to - from) << 24);
                }
            }
            first = end;
        }
    }
}

/// Most slots of a round for each thread: patches of 8 nodes fill a round, rounds of larger ones have fewer.
const MOST_SLOTS: usize = 9;

/// Slots of an eight: eight beyond a multiple of 32, so that four eights reach all banks of shared memory.
const fn padded(others: usize) -> usize {
    let least = LANES * (others + 1);
    least + (40 - least % 32) % 32
}

/// Adds the slots of an eight's forces to its places, in the order in which the engine adds them: the other nodes, then the
/// first one, lane by lane. Empty lanes add nothing, nor do places without a node of their own, which name the first one.
fn slots_of(words: &[u32], others: usize, first: usize, of_place: &mut [Vec<u16>]) {
    for place in 0..=others {
        for lane in 0..LANES {
            let at = |place: usize| words[4 * place + lane / 2] >> (16 * (lane % 2)) & 0xffff;
            let volume = f32::from_bits(words[4 * (others + 1) + lane]);
            if volume > 0.0 && (place == others || at(place) != at(others)) {
                of_place[at(place) as usize].push((first + LANES * place + lane) as u16);
            }
        }
    }
}
