//! The state of a block's elements, computed on demand.

use super::matter::LawTask;
use super::{Batch, Block, Common, EMPTY, Group, Scratch, history, without};
use crate::lanes::{LANES, Lanes, Octet, Task, Vectors};
use crate::law::{Law, Tensor};
use crate::uniform::Uniform;

/// The state of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// xx yy zz xy yz zx, MPa; tension is positive.
    pub stress: [f32; 6],
    /// 1 less the share of the stiffness that is left.
    pub damage: f32,
    /// Damage in tension, 0 to 1.
    pub tension: f32,
    /// Damage in compression, 0 to 1.
    pub compression: f32,
    /// Opening of its crack, mm.
    pub opening_mm: f32,
    /// Energy per volume that unloading would give back, N/mm2.
    pub stored: f32,
    /// Factor of its strengths over their mean.
    pub strength: f32,
    /// Share of its stiffness with which it unloads, 0 to 1.
    pub stiffness_left: f32,
    /// Width of its crack band, mm.
    pub width_mm: f32,
    /// Plastic strain, xx yy zz xy yz zx with engineering shears; 0 of a law without memory.
    pub plastic: [f32; 6],
}

/// The cell or patch of a point, by its number.
#[derive(Clone, Copy, Debug)]
pub enum Element {
    /// A cell of the mesh.
    Cell(u32),
    /// A patch of cells that share their mean strain.
    Patch(u32),
}

/// Asks the elements of a block.
pub struct Probe<'a> {
    /// Its elements.
    pub block: &'a Block,
    /// Materials and shapes.
    pub common: &'a Common,
    /// Displacements of all nodes, mm.
    pub displacement: &'a [[f64; 3]],
    /// Memory to work in.
    pub scratch: &'a mut Scratch,
}

impl Task for Probe<'_> {
    type Output = Vec<(Element, Point)>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self { block, common, displacement, scratch } = self;
        scratch.take_in::<L>(block, displacement, common.free.as_ref());
        let mut points = Vec::new();
        for group in &block.groups {
            let matter = &common.matter[usize::from(group.matter)];
            let strains = group_strains::<L>(group, common, &scratch.u);
            let (free, factor) = (common.over(group.free), matter.factor());
            points.extend(matter.law::<L, _>(GroupProbe { group, strains, free, factor }));
        }
        points
    }
}

struct GroupProbe<'a, L> {
    group: &'a Group,
    /// Strains and widths of crack bands, eight elements each.
    strains: Vec<(Tensor<L>, L)>,
    free: Option<L>,
    /// Register of the factor of the strengths.
    factor: Option<usize>,
}

impl<L: Lanes> LawTask<L> for GroupProbe<'_, L> {
    type Output = Vec<(Element, Point)>;

    #[inline(always)]
    fn run<W: Law<L>>(self, law: &W) -> Self::Output {
        let Self { group, strains, free, factor } = self;
        let remembered = group.memory.len() / strains.len().max(1);
        let element = if group.cells.are_patches() { Element::Patch } else { Element::Cell };
        let mut points = Vec::with_capacity(strains.len() * LANES);
        for (i, (strain, width)) in strains.iter().enumerate() {
            let memory = &group.memory[i * remembered..(i + 1) * remembered];
            let strength = factor.map_or_else(Octet::default, |place| memory[place]);
            let eight = answer(law, &without(*strain, free), *width, memory, &strength);
            let numbers = group.numbers[i * LANES..][..LANES].iter().zip(eight);
            points.extend(
                numbers.filter(|(number, _)| **number != EMPTY).map(|(&number, point)| (element(number), point)),
            );
        }
        points
    }
}

/// Strains and widths of crack bands; cohesive faces have none.
#[inline(always)]
fn group_strains<L: Lanes>(group: &Group, common: &Common, u: &Vectors) -> Vec<(Tensor<L>, L)> {
    match &group.cells {
        Batch::Tets(cells) => strains(cells, u),
        Batch::Patches8(cells) => strains(cells, u),
        Batch::Patches9(cells) => strains(cells, u),
        Batch::Patches12(cells) => strains(cells, u),
        Batch::Hexes(cells) => {
            cells.iter().map(|cells| (cells.strain(u, &common.shape).0, L::splat(common.band_mm))).collect()
        }
        Batch::Triangles(_) | Batch::Quads(_) => Vec::new(),
    }
}

#[inline(always)]
fn strains<L: Lanes, const N: usize>(cells: &[Uniform<N>], u: &Vectors) -> Vec<(Tensor<L>, L)> {
    cells.iter().map(|cells| (cells.strain(u), L::load(&cells.width))).collect()
}

#[inline(always)]
fn answer<L: Lanes, W: Law<L>>(
    law: &W,
    strain: &Tensor<L>,
    width: L,
    memory: &[Octet],
    strength: &Octet,
) -> [Point; LANES] {
    let mut history = history::<L, W>(memory);
    let response = law.stress(strain, &mut history, width);
    let state = law.state(strain, &history, width);
    let stress = eights(response.stress);
    // Laws lose stiffness or strength.
    let weakened = L::splat(0.0).lt(state.weakened);
    let damage = L::select(weakened, state.weakened, L::splat(1.0) - response.integrity);
    let [damage, tension, compression, opening, stored] =
        eights([damage, state.tension, state.compression, state.opening, state.stored]);
    let [left, width] = eights([response.integrity, width]);
    // Every history begins with the plastic strain.
    let plastic = match history.as_ref() {
        &[xx, yy, zz, xy, yz, zx, ..] => eights([xx, yy, zz, xy, yz, zx]),
        _ => [Octet::default(); 6],
    };
    std::array::from_fn(|lane| Point {
        stress: stress.map(|s| s.0[lane]),
        damage: damage.0[lane],
        tension: tension.0[lane],
        compression: compression.0[lane],
        opening_mm: opening.0[lane],
        stored: stored.0[lane],
        strength: 1.0 + strength.0[lane],
        stiffness_left: left.0[lane],
        width_mm: width.0[lane],
        plastic: plastic.map(|strain| strain.0[lane]),
    })
}

/// Registers in memory; a `map` over them would be a call.
#[inline(always)]
fn eights<L: Lanes, const N: usize>(registers: [L; N]) -> [Octet; N] {
    let mut eights = [Octet::default(); N];
    for (eight, register) in eights.iter_mut().zip(registers) {
        register.store(eight);
    }
    eights
}
