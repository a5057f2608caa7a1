//! Neighbour list: which bodies may touch, listed by both bodies of a pair and kept up to date.

use super::bodies::{Bodies, Fixed};
use super::cell_list::{CellList, starts};
use super::contact::{V, add_scaled, cross};
use super::contact_cache::{BLOCK, Block, CachedTouch, Gaps, PairLook, Scratch};
use meso_concrete::parallel;
use rayon::prelude::*;
use std::ops::Range;

/// The pairs: each stands with the body of the finer level of size, or of the lower number in one level, its *first*.
pub(super) struct NeighbourList {
    /// By first body, [`BLOCK`] bodies in each.
    blocks: Vec<Block>,
    /// By second body, `stretch` bodies in each.
    firsts: Vec<Firsts>,
    stretch: usize,
    /// Where pairs are searched.
    cells: Option<CellList>,
}

/// A body's pairs are listed for about this many sweeps.
const LIST_SWEEPS: f32 = 4.0;

/// The whole list is rebuilt when more than one body in this many is beyond its limit.
const FEW: usize = 3;

/// The bodies are indexed in at most this many stretches, none shorter than `LEAST_STRETCH`: each searches all
/// blocks.
const STRETCHES: usize = 64;
const LEAST_STRETCH: usize = 1024;

/// For some neighbouring bodies, the first bodies of the pairs whose second they are: `bodies[starts[k]..starts[k +
/// 1]]` of the k-th.
struct Firsts {
    starts: Vec<u32>,
    bodies: Vec<u32>,
}

/// Sum of the displacements that a body's contacts ask for.
#[derive(Default)]
pub(super) struct Push {
    pub(super) shift: V,
    pub(super) twist: V,
    pub(super) contacts: usize,
}

impl NeighbourList {
    pub(super) fn none() -> Self {
        Self { blocks: Vec::new(), firsts: Vec::new(), stretch: LEAST_STRETCH, cells: None }
    }

    /// Finds the pairs that may be contacts now and for some sweeps. A body may move at least `least` mm before its own
    /// are searched again. Pairs that stay listed keep their known gaps and contacts.
    pub(super) fn cover(&mut self, bodies: &mut Bodies, want: f32, least: f32) {
        let mut gone = bodies.beyond_limits();
        if gone.is_empty() && self.cells.is_some() {
            return;
        }
        let all = self.cells.is_none() || gone.len() > bodies.len() / FEW;
        if all {
            gone = (0..bodies.len() as u32).collect();
        }
        let paths = all.then(|| bodies.start_again());
        let cells = self.cells.take().filter(|cells| !all && !cells.stale(bodies)).unwrap_or_else(|| {
            bodies.wrap();
            CellList::new(bodies, want)
        });
        bodies.go_on(&gone, LIST_SWEEPS, least);
        match paths {
            Some(paths) => self.rebuild(bodies, &paths, &cells),
            None => self.add(bodies, &cells, &gone, want),
        }
        self.cells = Some(cells);
        self.index(bodies.len());
    }

    /// Rebuilds the list.
    fn rebuild(&mut self, bodies: &Bodies, paths: &[f32], cells: &CellList) {
        self.blocks.resize(bodies.len().div_ceil(BLOCK), Block::default());
        parallel::each_mut_with(&mut self.blocks, Scratch::default, |scratch, number, block| {
            block.renew((number * BLOCK) as u32, bodies, paths, cells, scratch);
        });
    }

    /// Lists the pairs of the bodies `gone` beyond their limits.
    fn add(&mut self, bodies: &Bodies, cells: &CellList, gone: &[u32], want: f32) {
        let mut pairs = parallel::flat_map(gone.len(), |k| cells.pairs(bodies, gone[k]));
        pairs.par_sort_unstable();
        pairs.dedup();
        parallel::each_mut_with(&mut self.blocks, Scratch::default, |scratch, number, block| {
            let first = (number * BLOCK) as u32;
            let from = |body: u32| pairs.partition_point(|pair| pair.0 < body);
            let pairs = &pairs[from(first)..from(first + BLOCK as u32)];
            if !pairs.is_empty() {
                block.add(first, bodies, pairs, want, scratch);
            }
        });
    }

    fn index(&mut self, bodies: usize) {
        // The old index is freed before the new one is built.
        self.firsts = Vec::new();
        let Self { blocks, stretch, .. } = self;
        *stretch = bodies.div_ceil(STRETCHES).max(LEAST_STRETCH);
        let ranges = parallel::map_each(blocks, Block::seconds);
        self.firsts = parallel::map(bodies.div_ceil(*stretch), |number| {
            let start = number * *stretch;
            Firsts::of(start as u32..(start + *stretch).min(bodies) as u32, blocks, &ranges)
        });
    }

    /// Brings every contact up to date.
    pub(super) fn look(&mut self, bodies: &Bodies, gaps: Gaps) -> PairLook {
        let mut looks: Vec<_> = self.blocks.iter_mut().map(|block| (block, PairLook::default())).collect();
        parallel::each_mut_with(&mut looks, Vec::new, |touching, number, (block, look)| {
            *look = block.look((number * BLOCK) as u32, bodies, gaps, touching);
        });
        looks.iter().fold(PairLook::default(), |sum, (_, look)| PairLook {
            energy: sum.energy + look.energy,
            open_below: sum.open_below + look.open_below,
        })
    }

    /// The contacts of `body`; true where it is their first, which is pushed against the normal.
    pub(super) fn contacts(&self, body: u32) -> impl Iterator<Item = (&CachedTouch, bool)> {
        let block = &self.blocks[body as usize / BLOCK];
        let own = block.links[block.range(body as usize % BLOCK)].iter().filter_map(|link| block.touch(link));
        let others = self.firsts_of(body).iter().filter_map(move |&first| {
            let block = &self.blocks[first as usize / BLOCK];
            block.touch(block.links[block.range(first as usize % BLOCK)].iter().find(|link| link.b == body)?)
        });
        own.map(|touch| (touch, true)).chain(others.map(|touch| (touch, false)))
    }

    fn firsts_of(&self, body: u32) -> &[u32] {
        let (number, k) = (body as usize / self.stretch, body as usize % self.stretch);
        let Firsts { starts, bodies } = &self.firsts[number];
        &bodies[starts[k] as usize..starts[k + 1] as usize]
    }

    /// The movements and turns that the contacts of `body` ask for.
    pub(super) fn push(&self, fixed: &Fixed, body: u32) -> Push {
        let mut push = Push::default();
        for (CachedTouch { contact, impulse }, first) in self.contacts(body) {
            let (impulse, at) = if first { (-impulse, contact.on_a) } else { (*impulse, contact.on_b) };
            push.shift = add_scaled(push.shift, contact.normal, impulse * fixed.inverse_mass);
            push.twist = add_scaled(push.twist, cross(at, contact.normal), impulse * fixed.inverse_inertia);
            push.contacts += 1;
        }
        push
    }
}

impl Firsts {
    /// Gathers the pairs of `these` bodies from the `blocks`, given the range of second bodies of each block.
    fn of(these: Range<u32>, blocks: &[Block], ranges: &[Range<u32>]) -> Self {
        let near = |range: &Range<u32>| range.start < these.end && these.start < range.end;
        let near = || (0..).zip(blocks).zip(ranges).filter(|(_, range)| near(range)).map(|(block, _)| block);
        let index = |b: u32| these.contains(&b).then(|| (b - these.start) as usize);
        let seconds = near().flat_map(|(_, block)| &block.links).filter_map(|link| index(link.b));
        let mut starts = starts(these.len(), seconds.map(|k| k as u32));
        let mut bodies = vec![0; starts[these.len()] as usize];
        for (number, block) in near() {
            for k in 0..block.ends.len() {
                for next in block.links[block.range(k)].iter().filter_map(|link| index(link.b)) {
                    bodies[starts[next] as usize] = (number * BLOCK + k) as u32;
                    starts[next] += 1;
                }
            }
        }
        // Every start has moved to the next.
        starts.rotate_right(1);
        starts[0] = 0;
        Self { starts, bodies }
    }
}
