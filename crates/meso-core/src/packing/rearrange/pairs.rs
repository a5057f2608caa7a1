//! Which bodies may touch, and what is known of their contact.
//!
//! A pair costs 16 bytes while it is apart: how far, and along which axis, which is enough to tell for many sweeps that
//! it still is. What a contact needs beyond that is kept as long as it lasts.

use super::bodies::{Bodies, Fixed};
use super::cells::{Cells, starts};
use super::contact::{Contact, V, add_scaled, cross, direction_or_up, dot, gap_along, scale};
use crate::wide::{Wide, widest};
use rayon::prelude::*;
use std::ops::Range;

/// The pairs: each stands with the body of the finer level of size, or of the lower number in one level, its *first*.
pub(super) struct Pairs {
    /// By first body, [`BLOCK`] bodies in each.
    blocks: Vec<Block>,
    /// By second body, `stretch` bodies in each.
    firsts: Vec<Firsts>,
    stretch: usize,
    /// Where pairs are looked for.
    cells: Option<Cells>,
}

/// The list of a body's pairs is made to last about this many sweeps.
const LIST_SWEEPS: f32 = 4.0;

/// All pairs are listed anew when more than one body in so many has gone beyond its limit.
const FEW: usize = 3;

/// Bodies whose pairs are kept together, and made anew together.
const BLOCK: usize = 64;

/// The bodies are indexed in so many stretches at the most, and no shorter ones than this: each looks through all blocks.
const STRETCHES: usize = 64;
const LEAST_STRETCH: usize = 1024;

/// For some neighbouring bodies, the first bodies of the pairs whose second they are: `bodies[starts[k]..starts[k + 1]]` of
/// the k-th.
struct Firsts {
    starts: Vec<u32>,
    bodies: Vec<u32>,
}

#[derive(Clone, Default)]
struct Block {
    /// Where the links of every body end.
    ends: Vec<u32>,
    links: Vec<Link>,
    /// In the order of the links.
    touching: Vec<Touch>,
}

/// A pair, from its first body.
#[derive(Clone, Copy)]
struct Link {
    /// The second body.
    b: u32,
    /// Gap plus both path lengths when it was last computed: while this less the paths exceeds what counts as a contact,
    /// the pair needs no look.
    clear: f32,
    /// Where the gap was last seen.
    axis: Axis,
    /// Number among those that touch, or [`APART`].
    slot: u16,
}

const APART: u16 = u16::MAX;

/// A contact, and the impulse along its normal that would open it.
#[derive(Clone, Copy)]
pub(super) struct Touch {
    pub(super) contact: Contact,
    impulse: f32,
}

/// What one look at all pairs found.
#[derive(Clone, Copy, Default)]
pub(super) struct Look {
    pub(super) energy: f64,
    pub(super) open_below: u32,
}

/// Gaps, mm.
#[derive(Clone, Copy)]
pub(super) struct Gaps {
    /// What makes a pair no contact.
    pub(super) want: f32,
    /// What must be open when it ends.
    pub(super) enough: f32,
}

/// Sum of what the contacts of a body ask for.
#[derive(Default)]
pub(super) struct Push {
    pub(super) shift: V,
    pub(super) twist: V,
    pub(super) contacts: usize,
}

impl Pairs {
    pub(super) fn none() -> Self {
        Self { blocks: Vec::new(), firsts: Vec::new(), stretch: LEAST_STRETCH, cells: None }
    }

    /// Finds the pairs that may be contacts now and for some sweeps; a body may go at least `least` mm before its own are
    /// looked for again. What is known of a pair that was listed before is kept.
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
            Cells::new(bodies, want)
        });
        bodies.go_on(&gone, LIST_SWEEPS, least);
        match paths {
            Some(paths) => self.rebuild(bodies, &paths, &cells),
            None => self.add(bodies, &cells, &gone, want),
        }
        self.cells = Some(cells);
        self.index(bodies.len());
    }

    /// Lists all pairs anew.
    fn rebuild(&mut self, bodies: &Bodies, paths: &[f32], cells: &Cells) {
        self.blocks.resize(bodies.len().div_ceil(BLOCK), Block::default());
        self.blocks.par_iter_mut().enumerate().for_each_init(Scratch::default, |scratch, (number, block)| {
            widest(Renew { block, first: (number * BLOCK) as u32, bodies, paths, cells, scratch });
        });
    }

    /// Lists the pairs of the bodies `gone` beyond their limits.
    fn add(&mut self, bodies: &Bodies, cells: &Cells, gone: &[u32], want: f32) {
        let mut pairs: Vec<(u32, u32)> = gone.par_iter().flat_map_iter(|&body| cells.pairs(bodies, body)).collect();
        pairs.par_sort_unstable();
        pairs.dedup();
        self.blocks.par_iter_mut().enumerate().for_each_init(Scratch::default, |scratch, (number, block)| {
            let first = (number * BLOCK) as u32;
            let from = |body: u32| pairs.partition_point(|pair| pair.0 < body);
            let pairs = &pairs[from(first)..from(first + BLOCK as u32)];
            if !pairs.is_empty() {
                block.add(first, bodies, pairs, want, scratch);
            }
        });
    }

    fn index(&mut self, bodies: usize) {
        // Not both the old and the new at once.
        self.firsts = Vec::new();
        let Self { blocks, stretch, .. } = self;
        *stretch = bodies.div_ceil(STRETCHES).max(LEAST_STRETCH);
        let ranges: Vec<Range<u32>> = blocks.par_iter().map(Block::seconds).collect();
        let stretches = (0..bodies.div_ceil(*stretch)).into_par_iter().map(|number| {
            let start = number * *stretch;
            Firsts::of(start as u32..(start + *stretch).min(bodies) as u32, blocks, &ranges)
        });
        self.firsts = stretches.collect();
    }

    /// Brings every contact up to date.
    pub(super) fn look(&mut self, bodies: &Bodies, gaps: Gaps) -> Look {
        let blocks = self.blocks.par_iter_mut().enumerate();
        let looks: Vec<Look> = blocks
            .map_init(Vec::new, |touching, (number, block)| {
                widest(LookAt { block, first: (number * BLOCK) as u32, bodies, gaps, touching })
            })
            .collect();
        looks.iter().fold(Look::default(), |sum, look| Look {
            energy: sum.energy + look.energy,
            open_below: sum.open_below + look.open_below,
        })
    }

    /// The contacts of `body`; true where it is their first, which is pushed against the normal.
    pub(super) fn contacts(&self, body: u32) -> impl Iterator<Item = (&Touch, bool)> {
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
        for (Touch { contact, impulse }, first) in self.contacts(body) {
            let (impulse, at) = if first { (-impulse, contact.on_a) } else { (*impulse, contact.on_b) };
            push.shift = add_scaled(push.shift, contact.normal, impulse * fixed.inverse_mass);
            push.twist = add_scaled(push.twist, cross(at, contact.normal), impulse * fixed.inverse_inertia);
            push.contacts += 1;
        }
        push
    }
}

/// [`Block::renew`] on wide registers.
struct Renew<'a> {
    block: &'a mut Block,
    first: u32,
    bodies: &'a Bodies<'a>,
    paths: &'a [f32],
    cells: &'a Cells,
    scratch: &'a mut Scratch,
}

impl Wide for Renew<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.block.renew(self.first, self.bodies, self.paths, self.cells, self.scratch);
    }
}

/// [`Block::look`] on wide registers.
struct LookAt<'a> {
    block: &'a mut Block,
    first: u32,
    bodies: &'a Bodies<'a>,
    gaps: Gaps,
    /// What a thread makes lists in.
    touching: &'a mut Vec<Touch>,
}

impl Wide for LookAt<'_> {
    type Output = Look;

    #[inline(always)]
    fn run(self) -> Look {
        self.block.look(self.first, self.bodies, self.gaps, self.touching)
    }
}

impl Firsts {
    /// Of `these` bodies, from the `blocks` and the range in which each has its second bodies.
    fn of(these: Range<u32>, blocks: &[Block], ranges: &[Range<u32>]) -> Self {
        let near = |range: &Range<u32>| range.start < these.end && these.start < range.end;
        let near = || (0..).zip(blocks).zip(ranges).filter(|(_, range)| near(range)).map(|(block, _)| block);
        let place = |b: u32| these.contains(&b).then(|| (b - these.start) as usize);
        let seconds = near().flat_map(|(_, block)| &block.links).filter_map(|link| place(link.b));
        let mut starts = starts(these.len(), seconds.map(|k| k as u32));
        let mut bodies = vec![0; starts[these.len()] as usize];
        for (number, block) in near() {
            for k in 0..block.ends.len() {
                for next in block.links[block.range(k)].iter().filter_map(|link| place(link.b)) {
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

/// What a thread makes blocks in.
#[derive(Default)]
struct Scratch {
    found: Vec<u32>,
    list: Block,
}

impl Block {
    fn range(&self, k: usize) -> Range<usize> {
        (if k == 0 { 0 } else { self.ends[k - 1] as usize })..self.ends[k] as usize
    }

    /// A range that holds the second bodies of all pairs here.
    fn seconds(&self) -> Range<u32> {
        let numbers = || self.links.iter().map(|link| link.b);
        numbers().min().unwrap_or(0)..numbers().max().map_or(0, |last| last + 1)
    }

    fn touch(&self, link: &Link) -> Option<&Touch> {
        self.touching.get(usize::from(link.slot))
    }

    /// Lists the pairs of the bodies from `first` on.
    #[inline(always)]
    fn renew(&mut self, first: u32, bodies: &Bodies, paths: &[f32], cells: &Cells, scratch: &mut Scratch) {
        let (found, list) = (&mut scratch.found, &mut scratch.list);
        list.clear();
        for (k, a) in (first..bodies.len() as u32).take(BLOCK).enumerate() {
            cells.seconds(bodies, a, found);
            let old = if k < self.ends.len() { &self.links[self.range(k)] } else { &[] };
            for &b in &*found {
                let mut link = match old.binary_search_by_key(&b, |link| link.b) {
                    Ok(i) => old[i],
                    Err(_) => Link::new(b, bodies.offset(a, b)),
                };
                link.clear -= paths[a as usize] + paths[b as usize];
                list.push(link, self.touch(&link));
            }
            list.end_body();
        }
        *self = list.clone();
    }

    /// Lists `pairs`, too, and drops those that have gone too far apart to matter.
    fn add(&mut self, first: u32, bodies: &Bodies, mut pairs: &[(u32, u32)], want: f32, scratch: &mut Scratch) {
        let list = &mut scratch.list;
        list.clear();
        for (k, a) in (first..).take(self.ends.len()).enumerate() {
            let (own, others) = pairs.split_at(pairs.partition_point(|pair| pair.0 <= a));
            pairs = others;
            let mut fresh = own.iter().map(|pair| pair.1).peekable();
            for link in &self.links[self.range(k)] {
                while let Some(b) = fresh.next_if(|&b| b < link.b) {
                    list.push(Link::new(b, bodies.offset(a, b)), None);
                }
                fresh.next_if_eq(&link.b);
                if !link.is_far(a, bodies, want) {
                    list.push(*link, self.touch(link));
                }
            }
            fresh.for_each(|b| list.push(Link::new(b, bodies.offset(a, b)), None));
            list.end_body();
        }
        *self = list.clone();
    }

    #[inline(always)]
    fn push(&mut self, mut link: Link, touch: Option<&Touch>) {
        link.slot = APART;
        if let Some(touch) = touch {
            link.slot = u16::try_from(self.touching.len()).unwrap_or(APART);
            self.touching.push(*touch);
        }
        self.links.push(link);
    }

    fn end_body(&mut self) {
        self.ends.push(self.links.len() as u32);
    }

    fn clear(&mut self) {
        self.ends.clear();
        self.links.clear();
        self.touching.clear();
    }

    #[inline(always)]
    fn look(&mut self, first: u32, bodies: &Bodies, gaps: Gaps, touching: &mut Vec<Touch>) -> Look {
        let mut look = Look::default();
        touching.clear();
        for (k, a) in (first..).take(self.ends.len()).enumerate() {
            let range = self.range(k);
            for link in &mut self.links[range] {
                let known = self.touching.get(usize::from(link.slot)).map(|touch| touch.contact);
                let Some(contact) = link.look(a, bodies, known, gaps.want) else { continue };
                let short = gaps.want - contact.gap;
                look.energy += f64::from(short) * f64::from(short);
                look.open_below += u32::from(contact.gap < gaps.enough);
                // Contacts that the numbers do not reach, a thousand a body, wait until others have opened.
                link.slot = u16::try_from(touching.len()).unwrap_or(APART);
                touching.push(Touch { contact, impulse: short / ease(&contact, bodies, a, link.b) });
            }
        }
        // A copy has no room to spare: the contacts of the first sweeps are the peak of memory.
        self.touching = touching.clone();
        look
    }
}

impl Link {
    /// With a first guess of its axis, and due for a look.
    #[inline(always)]
    fn new(b: u32, offset: V) -> Self {
        Self { b, clear: f32::NEG_INFINITY, axis: Axis::new(direction_or_up(offset)), slot: APART }
    }

    /// True when the pair can be no contact before one of them has gone beyond its limit.
    fn is_far(&self, a: u32, bodies: &Bodies, want: f32) -> bool {
        let gap = self.clear - bodies.path(a) - bodies.path(self.b);
        self.slot == APART && gap > want + bodies.margin(a) + bodies.margin(self.b)
    }

    /// The contact, if the pair of `a` and this lacks any of the wanted gap; started from what is known of it.
    #[inline(always)]
    fn look(&mut self, a: u32, bodies: &Bodies, known: Option<Contact>, want: f32) -> Option<Contact> {
        let b = self.b;
        let paths = bodies.path(a) + bodies.path(b);
        if self.slot == APART && self.clear - paths > want {
            return None;
        }
        self.slot = APART;
        let mut contact = Contact::towards(self.axis.direction());
        if let Some(known) = known {
            // A pair that was in contact most likely still is: its query, started from the old features, finds the gap.
            contact = known;
        } else {
            let box_gap = bodies.box_gap(a, b);
            if box_gap > want {
                self.clear = box_gap + paths;
                return None;
            }
        }
        let (p, q, x) = (bodies.points(a), bodies.points(b), bodies.offset(a, b));
        if known.is_none() {
            contact.gap = gap_along(&p, &q, x, contact.normal);
        }
        if contact.gap < want {
            contact.refresh(&p, &q, x, bodies.way_apart(a, b, x));
            self.axis = Axis::new(contact.normal);
        }
        self.clear = contact.gap + paths;
        (contact.gap < want).then_some(contact)
    }
}

/// What the pair opens for an impulse of one. A body that a wall holds gives way the less, so that the other does its part:
/// a small grain between a wall and a large one took the whole push, and stayed where it was for a hundred sweeps.
#[inline(always)]
fn ease(contact: &Contact, bodies: &Bodies, a: u32, b: u32) -> f32 {
    let normal = contact.normal;
    let of = |body: u32, at: V, away: V| {
        let (fixed, lever) = (&bodies.fixed[body as usize], cross(at, normal));
        let free = (1.0 - bodies.state[body as usize].held_against(away)).max(LEAST_FREE);
        fixed.inverse_mass * free + dot(lever, lever) * fixed.inverse_inertia
    };
    of(a, contact.on_a, scale(normal, -1.0)) + of(b, contact.on_b, normal)
}

/// Share of its movement that a body held by walls keeps: no impulse is without bound.
const LEAST_FREE: f32 = 0.25;

/// A direction, to a thousandth: the gap along any direction bounds that of the pair from below.
#[derive(Clone, Copy)]
struct Axis([i16; 3]);

impl Axis {
    #[inline(always)]
    fn new(v: V) -> Self {
        let short = |x: f32| (x * f32::from(i16::MAX)) as i16;
        Self([short(v[0]), short(v[1]), short(v[2])])
    }

    /// Of unit length.
    #[inline(always)]
    fn direction(self) -> V {
        direction_or_up([f32::from(self.0[0]), f32::from(self.0[1]), f32::from(self.0[2])])
    }
}
