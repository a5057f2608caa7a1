//! A block of elements: its displacements in, its share of the nodes' forces out.
//!
//! Some 2,048 neighbours along a space-filling curve with node numbers of their own, so that a block's nodes stay in the
//! cache and a connectivity fits u16. Displacements are taken relative to the block's first node, in f64, before they
//! become f32. Elements of one phase go together, eight at a time; their forces add up in their order.

pub mod matter;
pub mod probe;

use crate::bending::Bending;
use crate::block::matter::{LawTask, Matter};
use crate::face::{Cohesion, CohesionValues, Faces, REMEMBERED};
use crate::hex::{BoxShape, Hexes, per_bound};
use crate::lanes::{LANES, Lanes, Octet, Task, Vectors, vectors};
use crate::law::{Hooke, Law, PointResponse, Tensor};
use crate::real::Real;
use crate::uniform::{Tets, Uniform};
use meso_collision::prefetch::prefetch;
use meso_concrete::PhaseNames;
use meso_mesh::Phase;
pub use meso_trial::{PHASES, STRAINS};

/// Elements of a block.
pub const BLOCK: usize = 2048;

/// Eights between the one at work and the one that is fetched. A mesh of 1.06 million tetrahedra, which no cache holds,
/// then takes 0.83 of its time (`benches/results/fetching.csv`); 1 gains half of that, 3 to 6 no more.
const AHEAD: usize = 2;

/// A lane without an element.
pub const EMPTY: u32 = u32::MAX;

/// Elements of one kind and phase.
#[derive(Clone, Debug)]
pub enum Batch {
    /// C3D4.
    Tets(Vec<Tets>),
    /// Patches of 4 to 8 nodes.
    Patches8(Vec<Uniform<7>>),
    /// Patches of 9 nodes.
    Patches9(Vec<Uniform<8>>),
    /// Patches of 10 to 12 nodes.
    Patches12(Vec<Uniform<11>>),
    /// C3D8R, and C3D8I where the matter is unbreakable.
    Hexes(Vec<Hexes>),
    /// Cohesive faces of tetrahedra.
    Triangles(Vec<Faces<3>>),
    /// Cohesive faces of boxes.
    Quads(Vec<Faces<4>>),
}

impl Batch {
    /// Registers of memory that eight elements have.
    pub fn remembered(&self, matter: &Matter) -> usize {
        match self {
            Self::Triangles(_) => 3 * REMEMBERED,
            Self::Quads(_) => 4 * REMEMBERED,
            _ => matter.remembered(),
        }
    }

    /// Bytes that they hold.
    fn bytes(&self) -> usize {
        match self {
            Self::Tets(cells) => size_of_val(&**cells),
            Self::Patches8(cells) => size_of_val(&**cells),
            Self::Patches9(cells) => size_of_val(&**cells),
            Self::Patches12(cells) => size_of_val(&**cells),
            Self::Hexes(cells) => size_of_val(&**cells),
            Self::Triangles(cells) => size_of_val(&**cells),
            Self::Quads(cells) => size_of_val(&**cells),
        }
    }

    /// Whether they are patches, not cells or faces of the mesh.
    pub fn are_patches(&self) -> bool {
        matches!(self, Self::Patches8(_) | Self::Patches9(_) | Self::Patches12(_))
    }
}

/// Elements of one phase within a block.
#[derive(Clone, Debug)]
pub struct Group {
    /// Their phase; that of cohesive faces is the ITZ.
    pub phase: Phase,
    /// Place of their material in [`Common::matter`].
    pub matter: u16,
    /// Number of their strain without stress in [`Free`]: their phase, plus [`PHASES`] below the layer.
    pub free: u8,
    /// In eights.
    pub cells: Batch,
    /// State of their law, one run of registers per eight elements.
    pub memory: Vec<Octet>,
    /// The mesh's number of the cell in every lane, or [`EMPTY`]; cohesive faces and patches have their own numbers.
    pub numbers: Vec<u32>,
    /// Energy spent so far, mJ.
    pub dissipated: f64,
    /// Stored in hourglass modes now, and lost from them so far, mJ.
    pub hourglass: [f64; 2],
}

/// Neighbours, and the nodes they have.
#[derive(Clone, Debug)]
pub struct Block {
    /// Numbers of the nodes, ascending.
    pub nodes: Vec<u32>,
    /// One group per phase and kind.
    pub groups: Vec<Group>,
}

impl Block {
    /// Bytes that it holds.
    pub fn bytes(&self) -> usize {
        let of = |group: &Group| group.cells.bytes() + size_of_val(&*group.memory) + size_of_val(&*group.numbers);
        size_of_val(&*self.nodes) + self.groups.iter().map(of).sum::<usize>()
    }
}

/// Memory that a thread works in.
pub struct Scratch {
    /// Displacements relative to the block's first node, mm.
    pub u: Box<Vectors>,
    /// N.
    pub forces: Box<Vectors>,
}

impl Default for Scratch {
    /// Zeros.
    fn default() -> Self {
        Self { u: vectors(), forces: vectors() }
    }
}

impl Scratch {
    /// Takes in the displacements of `block`'s nodes, less those of the strain that all phases have without stress.
    #[inline(always)]
    pub fn take_in<L: Lanes>(&mut self, block: &Block, displacement: &[[f64; 3]], free: Option<&Free>) {
        let first = block.nodes[0] as usize;
        let origin = displacement[first];
        // Loops, since a closure would be compiled without the instruction set.
        if let Some(Free { ground, places, .. }) = free {
            for (own, &node) in self.u.iter_mut().zip(&block.nodes) {
                let (u, place) = (&displacement[node as usize], &places[node as usize]);
                for k in 0..3 {
                    own[k] = (u[k] - origin[k] - ground * (place[k] - places[first][k])) as f32;
                }
            }
        } else {
            let from = [origin[0], origin[1], origin[2], 0.0];
            for (own, &node) in self.u.iter_mut().zip(&block.nodes) {
                *own = L::relative(&displacement[node as usize], &from);
            }
        }
        self.forces[..block.nodes.len()].fill([0.0; 4]);
    }
}

/// Data that all elements share.
#[derive(Clone, Debug)]
pub struct Common {
    /// By phase, as a number, and then stones that break.
    pub matter: Vec<Matter>,
    /// Place of the stone of every body in `matter`; empty where no stone breaks.
    pub stones: Vec<u16>,
    /// Shape of all hexahedra.
    pub shape: BoxShape,
    /// Values of cohesive faces.
    pub cohesion: Option<CohesionValues>,
    /// Share of the stiffness that hourglass modes meet.
    pub hourglass: f64,
    /// Width of crack bands in hexahedra, mm.
    pub band_mm: f64,
    /// Strains that phases have now without stress; none in tests without expansion.
    pub free: Option<Free>,
}

/// Linear strains that phases have without stress.
///
/// The mortar's strain is subtracted from displacements in f64, before they become f32. A body that expands evenly then has
/// no stress, where differences of rounded strains left 1e-5 of Young's modulus times the strain.
#[derive(Clone, Debug)]
pub struct Free {
    /// Strain of the mortar.
    ground: f64,
    /// Strain of each phase, then of each phase below the layer, less the mortar's.
    over: [f64; STRAINS],
    /// Places of the nodes by the engine's numbers, mm.
    places: Vec<[f64; 3]>,
}

impl Free {
    /// No strain yet.
    pub fn new(places: Vec<[f64; 3]>) -> Self {
        Self { ground: 0.0, over: [0.0; STRAINS], places }
    }

    /// Places of the nodes by the engine's numbers, mm.
    pub fn places(&self) -> &[[f64; 3]] {
        &self.places
    }

    /// Strain of the mortar, then all strains less the mortar's.
    pub fn strains(&self) -> [f64; 1 + STRAINS] {
        std::array::from_fn(|place| if place == 0 { self.ground } else { self.over[place - 1] })
    }

    /// Sets the strains of all phases, then of all phases below the layer.
    pub fn set(&mut self, strains: [f64; STRAINS]) {
        self.ground = strains[Phase::Mortar.index()];
        self.over = strains.map(|strain| strain - self.ground);
    }
}

impl Common {
    /// Place of the material of a cell with this phase and owner.
    pub fn place(&self, phase: Phase, owner: u32) -> u16 {
        let stone = if phase == Phase::Aggregate { self.stones.get(owner as usize) } else { None };
        stone.copied().unwrap_or(phase.number().into())
    }

    /// Strain of a [`Group::free`] without stress, less the one that [`Scratch::take_in`] subtracts.
    #[inline(always)]
    pub(crate) fn over<R: Real>(&self, number: u8) -> Option<R> {
        self.free.as_ref().map(|free| R::splat(free.over[usize::from(number)]))
    }

    /// Widest bands of cracking and crushing that dissipate their energy in every material of one of the `phases`, mm.
    pub fn widest_mm(&self, phase: Phase, phases: &PhaseNames) -> [f64; 2] {
        let stones = if phase == Phase::Aggregate { &self.matter[phases.count()..] } else { &[] };
        let all = std::iter::once(&self.matter[phase.index()]).chain(stones);
        all.map(Matter::widest_mm).fold([f64::INFINITY; 2], |[a, b], [c, d]| [a.min(c), b.min(d)])
    }
}

/// A step of one block.
pub struct Pass<'a> {
    /// Its elements.
    pub block: &'a mut Block,
    /// Materials and shapes.
    pub common: &'a Common,
    /// Displacements of all nodes, mm.
    pub displacement: &'a [[f64; 3]],
    /// Where the nodes' forces go, N.
    pub out: &'a mut [[f32; 4]],
    /// Memory to work in.
    pub scratch: &'a mut Scratch,
}

impl Task for Pass<'_> {
    /// Energy spent in the step, mJ.
    type Output = f64;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f64 {
        let Self { block, common, displacement, out, scratch } = self;
        scratch.take_in::<L>(block, displacement, common.free.as_ref());
        let Scratch { u, forces } = scratch;
        let mut in_all = 0.0;
        for group in &mut block.groups {
            let Group { matter, free, cells, memory, dissipated, hourglass, .. } = group;
            let matter = &common.matter[usize::from(*matter)];
            let free = common.over(*free);
            let spent = match cells {
                Batch::Tets(cells) => uniform::<L, 3>(cells, matter, (memory, free), u, forces),
                Batch::Patches8(cells) => uniform::<L, 7>(cells, matter, (memory, free), u, forces),
                Batch::Patches9(cells) => uniform::<L, 8>(cells, matter, (memory, free), u, forces),
                Batch::Patches12(cells) => uniform::<L, 11>(cells, matter, (memory, free), u, forces),
                Batch::Hexes(cells) if matter.is_unbreakable => {
                    bend::<L>(cells, matter, (&common.shape, free), u, forces);
                    0.0
                }
                Batch::Hexes(cells) => {
                    let stiffness = matter.hourglass_stiffness(common.hourglass, &common.shape);
                    let task = HexTask { cells, memory, u, forces, common, stiffness, free };
                    let [spent, stored, lost] = matter.law::<L, _>(task);
                    *hourglass = [stored, hourglass[1] + lost];
                    in_all += lost;
                    spent
                }
                Batch::Triangles(faces) => cohesive::<L, 3>(faces, common, memory, u, forces),
                Batch::Quads(faces) => cohesive::<L, 4>(faces, common, memory, u, forces),
            };
            *dissipated += spent;
            in_all += spent;
        }
        out.copy_from_slice(&scratch.forces[..out.len()]);
        in_all
    }
}

#[inline(always)]
fn cohesive<L: Lanes, const N: usize>(
    faces: &[Faces<N>],
    common: &Common,
    memory: &mut [Octet],
    u: &Vectors,
    forces: &mut Vectors,
) -> f64 {
    let Some(values) = &common.cohesion else { return 0.0 };
    let cohesion = Cohesion::<L>::new(values);
    let mut spent = L::splat(0.0);
    for (faces, memory) in faces.iter().zip(memory.chunks_exact_mut(N * REMEMBERED)) {
        spent = spent + faces.resist(&cohesion, memory, u, forces);
    }
    spent.eight().sum()
}

/// Every law's history begins with the plastic strain.
const PLASTIC: usize = 6;

/// Loads the law's history from an element's memory.
#[inline(always)]
pub fn history<L: Lanes, W: Law<L>>(memory: &[Octet]) -> W::History {
    let mut history = W::virgin();
    let states = history.as_ref().len();
    let memory = &memory[..states];
    #[allow(clippy::needless_range_loop, reason = "an indexed loop compiles to plain loads")]
    for i in 0..states {
        history.as_mut()[i] = L::load(&memory[i]);
    }
    history
}

/// Stress of a strain, and the energy per volume that it spends, N/mm2. The element's memory is updated: the law's history,
/// then the integrity, less 1, so that zeros are a sound element.
#[inline(always)]
fn answer<L: Lanes, W: Law<L>>(law: &W, strain: &Tensor<L>, memory: &mut [Octet], width: L) -> Answer<L> {
    if L::IS_FALLBACK { called(law, strain, memory, width) } else { inlined(law, strain, memory, width) }
}

/// [`inlined`] as one function a law: on machines that hardly exist, kernels of every shape share it.
#[inline(never)]
fn called<L: Lanes, W: Law<L>>(law: &W, strain: &Tensor<L>, memory: &mut [Octet], width: L) -> Answer<L> {
    inlined(law, strain, memory, width)
}

#[inline(always)]
fn inlined<L: Lanes, W: Law<L>>(law: &W, strain: &Tensor<L>, memory: &mut [Octet], width: L) -> Answer<L> {
    let one = L::splat(1.0);
    let mut history = history::<L, W>(memory);
    let states = history.as_ref().len();
    // The length is known, so that no loop over it becomes a call.
    let memory = &mut memory[..if states == 0 { 0 } else { states + 1 }];
    let response = law.stress(strain, &mut history, width);
    let stress = response.stress;
    if states == 0 {
        return Answer { stress, integrity: one, before: one, spent: L::splat(0.0) };
    }
    let (before, integrity) = (one + L::load(&memory[states]), response.integrity);
    let zero = L::splat(0.0);
    let (mut steps, mut moved) = ([zero; PLASTIC], (before - integrity).abs());
    #[allow(clippy::needless_range_loop, reason = "an indexed loop compiles to plain stores")]
    for i in W::RUNNING[0]..W::RUNNING[1] {
        history.as_ref()[i].store(&mut memory[i]);
    }
    for (i, own) in history.as_ref().iter().enumerate() {
        let step = *own - L::load(&memory[i]);
        moved = moved.max(step.abs());
        if i < PLASTIC {
            steps[i] = step;
        }
    }
    if !L::any(zero.lt(moved)) {
        return Answer { stress, integrity, before, spent: zero };
    }
    let spent = spent(&response, strain, history.as_ref(), &steps, before);
    #[allow(clippy::needless_range_loop, reason = "an indexed loop compiles to plain stores")]
    for i in 0..states {
        history.as_ref()[i].store(&mut memory[i]);
    }
    (integrity - one).store(&mut memory[states]);
    Answer { stress, integrity, before, spent }
}

/// Energy per volume that a step spends, N/mm2, by flow and by damage: `history` begins with the plastic strain after the
/// step, `steps` is its growth, `before` is the integrity before the step.
#[inline(always)]
pub fn spent<R: Real>(
    response: &PointResponse<R>,
    strain: &Tensor<R>,
    history: &[R],
    steps: &Tensor<R>,
    before: R,
) -> R {
    let PointResponse { stress, integrity } = *response;
    let [mut flowed, mut stored] = [R::splat(0.0); 2];
    for i in 0..PLASTIC {
        flowed = stress[i].mul_add(steps[i], flowed);
        stored = stress[i].mul_add(strain[i] - history[i], stored);
    }
    // The stored energy falls by the share by which the integrity fell.
    flowed + R::splat(0.5) * stored * (before - integrity) / integrity.max(R::splat(1e-6))
}

struct Answer<L> {
    stress: Tensor<L>,
    integrity: L,
    /// Integrity before the step.
    before: L,
    spent: L,
}

#[inline(always)]
fn uniform<L: Lanes, const N: usize>(
    cells: &[Uniform<N>],
    matter: &Matter,
    (memory, free): (&mut [Octet], Option<L>),
    u: &Vectors,
    forces: &mut Vectors,
) -> f64 {
    matter.law::<L, _>(UniformTask { cells, memory, u, forces, free })
}

struct UniformTask<'a, L, const N: usize> {
    cells: &'a [Uniform<N>],
    memory: &'a mut [Octet],
    u: &'a Vectors,
    forces: &'a mut Vectors,
    free: Option<L>,
}

impl<L: Lanes, const N: usize> LawTask<L> for UniformTask<'_, L, N> {
    type Output = f64;

    #[inline(always)]
    fn run<W: Law<L>>(self, law: &W) -> f64 {
        let remembered = self.memory.len() / self.cells.len().max(1);
        let (mut spent, mut rest) = (L::splat(0.0), self.memory);
        for (i, cells) in self.cells.iter().enumerate() {
            let memory;
            (memory, rest) = rest.split_at_mut(remembered);
            if let Some(ahead) = self.cells.get(i + AHEAD) {
                prefetch(std::slice::from_ref(ahead));
                prefetch(&rest[(AHEAD - 1) * remembered..][..remembered]);
            }
            let strain = without(cells.strain(self.u), self.free);
            let answer = answer(law, &strain, memory, L::load(&cells.width));
            spent = answer.spent.mul_add(L::load(&cells.volume), spent);
            cells.resist(&answer.stress, self.forces);
        }
        spent.eight().sum()
    }
}

/// The part of a strain that has stress.
#[inline(always)]
pub fn without<R: Real>(mut strain: Tensor<R>, free: Option<R>) -> Tensor<R> {
    if let Some(free) = free {
        (0..3).for_each(|i| strain[i] = strain[i] - free);
    }
    strain
}

/// Boxes that bend: C3D8I.
#[inline(always)]
fn bend<L: Lanes>(
    cells: &[Hexes],
    matter: &Matter,
    (shape, free): (&BoxShape, Option<L>),
    u: &Vectors,
    forces: &mut Vectors,
) {
    let (law, bending) = (Hooke::<L>::new(&matter.elastic), Bending::<L>::new(shape, &matter.elastic));
    for cells in cells {
        let (strain, amplitudes) = cells.strain(u, shape);
        let strain = without(strain, free);
        cells.resist(&law.of(&strain), &bending.forces(&amplitudes), L::splat(1.0), shape, forces);
    }
}

struct HexTask<'a, L> {
    cells: &'a [Hexes],
    memory: &'a mut [Octet],
    u: &'a Vectors,
    forces: &'a mut Vectors,
    common: &'a Common,
    stiffness: f64,
    free: Option<L>,
}

impl<L: Lanes> LawTask<L> for HexTask<'_, L> {
    type Output = [f64; 3];

    #[inline(always)]
    fn run<W: Law<L>>(self, law: &W) -> [f64; 3] {
        let remembered = self.memory.len() / self.cells.len().max(1);
        let (k, width) = (L::splat(self.stiffness), L::splat(self.common.band_mm));
        let shape = &self.common.shape;
        // A law without softening has no bound.
        let bound = L::splat(if remembered == 0 { 0.0 } else { per_bound(shape.edge()) });
        let [mut spent, mut stored, mut lost] = [L::splat(0.0); 3];
        for (i, cells) in self.cells.iter().enumerate() {
            let memory = &mut self.memory[i * remembered..(i + 1) * remembered];
            let (strain, hourglass) = cells.strain(self.u, shape);
            let strain = without(strain, self.free);
            let answer = answer(law, &strain, memory, width);
            spent = answer.spent.mul_add(L::load(&cells.used), spent);
            let (twice, left) = cells.bounded(&hourglass, bound);
            stored = answer.integrity.mul_add(twice, stored);
            lost = (answer.before - answer.integrity).mul_add(twice, lost);
            cells.resist(&answer.stress, &hourglass, k * answer.integrity * left, shape, self.forces);
        }
        let half = 0.5 * self.stiffness;
        [spent.eight().sum() * shape.volume(), stored.eight().sum() * half, lost.eight().sum() * half]
    }
}

/// Eights of elements that `count` elements take.
pub fn eights(count: usize) -> usize {
    count.div_ceil(LANES)
}
