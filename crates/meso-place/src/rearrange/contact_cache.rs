//! Contact cache: known gaps and contacts of the pairs of some bodies.
//!
//! A separated pair costs 16 bytes: a gap and its axis, which prove for many sweeps that it is still apart. A
//! contact's further data is kept as long as the contact lasts.

use super::bodies::Bodies;
use super::cell_list::CellList;
use super::contact::{FoundContact, V, cross, direction_or_up, dot, gap_along, scale};
use meso_collision::simd::{Wide, widest};
use std::ops::Range;

/// Bodies whose pairs are kept, and rebuilt, together.
pub(super) const BLOCK: usize = 64;

#[derive(Clone, Default)]
pub(super) struct Block {
    /// End of every body's links.
    pub(super) ends: Vec<u32>,
    pub(super) links: Vec<CachedLink>,
    /// In the order of the links.
    touching: Vec<CachedTouch>,
}

/// A pair, from its first body.
#[derive(Clone, Copy)]
pub(super) struct CachedLink {
    /// The second body.
    pub(super) b: u32,
    /// Gap plus both path lengths when last computed. While this minus the current paths exceeds the wanted gap, the
    /// pair needs no query.
    clear: f32,
    /// Axis along which the gap was measured.
    axis: Axis,
    /// Number among those that touch, or [`APART`].
    slot: u16,
}

const APART: u16 = u16::MAX;

/// A contact, and the impulse along its normal that would open it.
#[derive(Clone, Copy)]
pub(super) struct CachedTouch {
    pub(super) contact: FoundContact,
    pub(super) impulse: f32,
}

/// Result of one pass over all pairs.
#[derive(Clone, Copy, Default)]
pub(super) struct PairLook {
    pub(super) energy: f64,
    pub(super) open_below: u32,
}

/// Gaps, mm.
#[derive(Clone, Copy)]
pub(super) struct Gaps {
    /// A pair with this gap is no contact.
    pub(super) want: f32,
    /// Gap that must be open at the end.
    pub(super) enough: f32,
}

/// [`Block::list`] on wide registers.
struct Renew<'a> {
    block: &'a mut Block,
    first: u32,
    bodies: &'a Bodies<'a>,
    paths: &'a [f32],
    cells: &'a CellList,
    scratch: &'a mut Scratch,
}

impl Wide for Renew<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.block.list(self.first, self.bodies, self.paths, self.cells, self.scratch);
    }
}

/// [`Block::see`] on wide registers.
struct LookAt<'a> {
    block: &'a mut Block,
    first: u32,
    bodies: &'a Bodies<'a>,
    gaps: Gaps,
    touching: &'a mut Vec<CachedTouch>,
}

impl Wide for LookAt<'_> {
    type Output = PairLook;

    #[inline(always)]
    fn run(self) -> PairLook {
        self.block.see(self.first, self.bodies, self.gaps, self.touching)
    }
}

/// Scratch memory of a thread.
#[derive(Default)]
pub(super) struct Scratch {
    found: Vec<u32>,
    list: Block,
}

impl Block {
    pub(super) fn range(&self, k: usize) -> Range<usize> {
        (if k == 0 { 0 } else { self.ends[k - 1] as usize })..self.ends[k] as usize
    }

    /// A range that holds the second bodies of all pairs here.
    pub(super) fn seconds(&self) -> Range<u32> {
        let numbers = || self.links.iter().map(|link| link.b);
        numbers().min().unwrap_or(0)..numbers().max().map_or(0, |last| last + 1)
    }

    pub(super) fn touch(&self, link: &CachedLink) -> Option<&CachedTouch> {
        self.touching.get(usize::from(link.slot))
    }

    /// Rebuilds the pairs of the bodies from `first` on; pairs that stay listed keep their known gaps and contacts.
    pub(super) fn renew(
        &mut self,
        first: u32,
        bodies: &Bodies,
        paths: &[f32],
        cells: &CellList,
        scratch: &mut Scratch,
    ) {
        widest(Renew { block: self, first, bodies, paths, cells, scratch });
    }

    #[inline(always)]
    fn list(&mut self, first: u32, bodies: &Bodies, paths: &[f32], cells: &CellList, scratch: &mut Scratch) {
        let (found, list) = (&mut scratch.found, &mut scratch.list);
        list.clear();
        for (k, a) in (first..bodies.len() as u32).take(BLOCK).enumerate() {
            cells.seconds(bodies, a, found);
            let old = if k < self.ends.len() { &self.links[self.range(k)] } else { &[] };
            for &b in &*found {
                let mut link = match old.binary_search_by_key(&b, |link| link.b) {
                    Ok(i) => old[i],
                    Err(_) => CachedLink::new(b, bodies.offset(a, b)),
                };
                link.clear -= paths[a as usize] + paths[b as usize];
                list.push(link, self.touch(&link));
            }
            list.end_body();
        }
        *self = list.clone();
    }

    /// Adds `pairs`, and drops those too far apart to matter.
    pub(super) fn add(
        &mut self,
        first: u32,
        bodies: &Bodies,
        mut pairs: &[(u32, u32)],
        want: f32,
        scratch: &mut Scratch,
    ) {
        let list = &mut scratch.list;
        list.clear();
        for (k, a) in (first..).take(self.ends.len()).enumerate() {
            let (own, others) = pairs.split_at(pairs.partition_point(|pair| pair.0 <= a));
            pairs = others;
            let mut fresh = own.iter().map(|pair| pair.1).peekable();
            for link in &self.links[self.range(k)] {
                while let Some(b) = fresh.next_if(|&b| b < link.b) {
                    list.push(CachedLink::new(b, bodies.offset(a, b)), None);
                }
                fresh.next_if_eq(&link.b);
                if !link.is_far(a, bodies, want) {
                    list.push(*link, self.touch(link));
                }
            }
            fresh.for_each(|b| list.push(CachedLink::new(b, bodies.offset(a, b)), None));
            list.end_body();
        }
        *self = list.clone();
    }

    #[inline(always)]
    fn push(&mut self, mut link: CachedLink, touch: Option<&CachedTouch>) {
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

    /// Updates every contact; `touching` is a thread's scratch list.
    pub(super) fn look(
        &mut self,
        first: u32,
        bodies: &Bodies,
        gaps: Gaps,
        touching: &mut Vec<CachedTouch>,
    ) -> PairLook {
        widest(LookAt { block: self, first, bodies, gaps, touching })
    }

    #[inline(always)]
    fn see(&mut self, first: u32, bodies: &Bodies, gaps: Gaps, touching: &mut Vec<CachedTouch>) -> PairLook {
        let mut look = PairLook::default();
        touching.clear();
        for (k, a) in (first..).take(self.ends.len()).enumerate() {
            let range = self.range(k);
            for link in &mut self.links[range] {
                let known = self.touching.get(usize::from(link.slot)).map(|touch| touch.contact);
                let Some(contact) = link.look(a, bodies, known, gaps.want) else { continue };
                let short = gaps.want - contact.gap;
                look.energy += f64::from(short) * f64::from(short);
                look.open_below += u32::from(contact.gap < gaps.enough);
                // Contacts beyond the range of the numbers, a thousand per body, wait until others have opened.
                link.slot = u16::try_from(touching.len()).unwrap_or(APART);
                touching.push(CachedTouch { contact, impulse: short / ease(&contact, bodies, a, link.b) });
            }
        }
        // A copy has no spare capacity: the contacts of the first sweeps are the peak of memory.
        self.touching = touching.clone();
        look
    }
}

impl CachedLink {
    /// With a first guess of its axis, due for a query.
    #[inline(always)]
    fn new(b: u32, offset: V) -> Self {
        Self { b, clear: f32::NEG_INFINITY, axis: Axis::new(direction_or_up(offset)), slot: APART }
    }

    /// True when the pair cannot become a contact before one body exceeds its limit.
    fn is_far(&self, a: u32, bodies: &Bodies, want: f32) -> bool {
        let gap = self.clear - bodies.path(a) - bodies.path(self.b);
        self.slot == APART && gap > want + bodies.margin(a) + bodies.margin(self.b)
    }

    /// The contact, if the pair of `a` and this lacks any of the wanted gap; starts from the known one.
    #[inline(always)]
    fn look(&mut self, a: u32, bodies: &Bodies, known: Option<FoundContact>, want: f32) -> Option<FoundContact> {
        let b = self.b;
        let paths = bodies.path(a) + bodies.path(b);
        if self.slot == APART && self.clear - paths > want {
            return None;
        }
        self.slot = APART;
        let mut contact = FoundContact::towards(self.axis.direction());
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
        // Where surfaces with dents touch, the axis alone is that of the hulls.
        let surfaces = bodies.surfaces(a, b);
        if surfaces.is_some() {
            contact.normal = self.axis.direction();
        }
        // A ball is its centre with a rim: the query is about what is within the rims.
        let rims = bodies.rim(a) + bodies.rim(b);
        contact.gap = if known.is_none() || surfaces.is_some() {
            gap_along(&p, &q, x, contact.normal)
        } else {
            contact.gap + rims
        };
        if contact.gap - rims < want {
            contact.refresh(&p, &q, x, bodies.middle_offset(a, b, x));
            self.axis = Axis::new(contact.normal);
        }
        if let Some(surfaces) = surfaces.filter(|_| contact.gap - rims < want) {
            let at = [(a, p), (b, q)].map(|(body, points)| (bodies.state[body as usize].rotation, points));
            surfaces.refine([a, b], at, x, want + rims, &mut contact);
        }
        contact.gap -= rims;
        self.clear = contact.gap + paths;
        (contact.gap < want).then_some(contact)
    }
}

/// Gap opened by a unit impulse. A body that a wall holds yields less, so that the other does its part: otherwise a
/// small grain between a wall and a large one took the whole push, and stayed put for a hundred sweeps.
#[inline(always)]
fn ease(contact: &FoundContact, bodies: &Bodies, a: u32, b: u32) -> f32 {
    let normal = contact.normal;
    let of = |body: u32, at: V, away: V| {
        let (fixed, lever) = (&bodies.fixed[body as usize], cross(at, normal));
        let free = (1.0 - bodies.state[body as usize].held_against(away)).max(LEAST_FREE);
        fixed.inverse_mass * free + dot(lever, lever) * fixed.inverse_inertia
    };
    of(a, contact.on_a, scale(normal, -1.0)) + of(b, contact.on_b, normal)
}

/// Share of its movement that a body held by walls keeps, so that impulses stay bounded.
const LEAST_FREE: f32 = 0.25;

/// A direction, to a thousandth. The gap along any direction is a lower bound of the pair's gap.
#[derive(Clone, Copy)]
struct Axis([i16; 3]);

impl Axis {
    #[inline(always)]
    fn new(v: V) -> Self {
        let short = |x: f32| (x * f32::from(i16::MAX)) as i16;
        Self([short(v[0]), short(v[1]), short(v[2])])
    }

    /// The vector scaled to unit length.
    #[inline(always)]
    fn direction(self) -> V {
        direction_or_up([f32::from(self.0[0]), f32::from(self.0[1]), f32::from(self.0[2])])
    }
}
