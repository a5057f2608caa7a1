//! Nodes: they sum the blocks' forces in the blocks' order, and move by central differences.

use crate::march::supports::Supports;
use crate::march::supports::contact::{Motion, Touched};
use meso_collision::math::{Aabb, Vec3};
use meso_element::block::Block;
use meso_element::lanes::{InstructionSet, Lanes, Task};
use meso_trial::MOST_SUPPORTS;
use rayon::prelude::*;
use std::iter::Peekable;
use std::slice::Iter;

/// Nodes per parallel task. Sums are added span by span, so that the number of threads cannot change them.
pub const SPAN: usize = 4096;

/// Nodes whose forces are summed before they move: they stay in the first cache.
const TOGETHER: usize = 128;

/// Displacements and velocities, by the engine's numbers.
#[derive(Clone, Debug)]
pub(crate) struct Nodes {
    /// At whole steps, mm.
    pub(crate) displacement: Vec<[f64; 3]>,
    /// At half steps, mm/s.
    pub(crate) velocity: Vec<[f64; 3]>,
    /// Lumped, tonne.
    pub(crate) mass: Vec<f64>,
    /// Place of each node's first share among the blocks' forces.
    first: Vec<u32>,
    /// Node and place of every other share, by node. Most nodes have none: a loop over a node's shares would end where no
    /// processor foresees it.
    more: Vec<[u32; 2]>,
}

/// Sums over nodes in a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    /// Forces of the supports on the specimen, each along its axis, N.
    pub(crate) supports: [f64; MOST_SUPPORTS],
    /// Work of the supports, of the elements' forces, and of friction, mJ.
    pub(crate) external: f64,
    /// See `external`.
    pub(crate) internal: f64,
    /// See `external`.
    pub(crate) friction: f64,
    /// Kinetic energy at the half step, mJ.
    pub(crate) kinetic: f64,
}

impl Sums {
    /// Adds up the rows of spans: forces of the supports, their work, friction, work of the elements' forces, and kinetic
    /// energy.
    pub(crate) fn of_rows(rows: &[f64], supports: usize) -> Self {
        let of_row = |row: &[f64]| {
            let (forces, energies) = row.split_at(supports);
            let &[external, friction, internal, kinetic] = energies else { return Self::default() };
            let mut sums = Self { external, friction, internal, kinetic, ..Self::default() };
            sums.supports[..supports].copy_from_slice(forces);
            sums
        };
        rows.chunks_exact(supports + 4).map(of_row).fold(Self::default(), |sums, row| sums.with(&row))
    }

    fn with(mut self, other: &Self) -> Self {
        self.supports.iter_mut().zip(&other.supports).for_each(|(own, force)| *own += force);
        self.external += other.external;
        self.internal += other.internal;
        self.friction += other.friction;
        self.kinetic += other.kinetic;
        self
    }
}

impl Nodes {
    /// At rest. The blocks' forces lie one block after the other, node by node.
    pub(crate) fn new(mass: Vec<f64>, blocks: &[Block]) -> Self {
        let (count, none) = (mass.len(), u32::MAX);
        let (mut first, mut more) = (vec![none; count], Vec::new());
        for (place, &node) in (0..).zip(blocks.iter().flat_map(|block| &block.nodes)) {
            match &mut first[node as usize] {
                first if *first == none => *first = place,
                _ => more.push([node, place]),
            }
        }
        assert!(!first.contains(&none), "every node belongs to an element");
        more.sort_unstable();
        let still = || vec![[0.0; 3]; count];
        Self { displacement: still(), velocity: still(), mass, first, more }
    }

    /// Back to the start.
    pub(crate) fn rest(&mut self) {
        self.displacement.fill([0.0; 3]);
        self.velocity.fill([0.0; 3]);
    }

    /// Bytes that they hold.
    pub(crate) fn bytes(&self) -> usize {
        let Self { displacement, velocity, mass, first, more } = self;
        2 * size_of_val(&**displacement).max(size_of_val(&**velocity))
            + size_of_val(&**mass)
            + size_of_val(&**first)
            + size_of_val(&**more)
    }

    /// Where each node's shares begin, and their places among the blocks' forces.
    pub(crate) fn shares(&self) -> [Vec<u32>; 2] {
        let (mut starts, mut places) = (vec![0], Vec::with_capacity(self.places()));
        let mut more = self.more.iter().peekable();
        for (node, &first) in (0..).zip(&self.first) {
            places.push(first);
            while let Some([_, place]) = more.next_if(|[other, _]| *other == node) {
                places.push(*place);
            }
            starts.push(places.len() as u32);
        }
        [starts, places]
    }

    /// Number of the blocks' forces.
    pub(crate) fn places(&self) -> usize {
        self.first.len() + self.more.len()
    }

    /// Gives nodes at these places the speeds of a uniform strain between both ends of an axis, and of the thinning with it.
    pub(crate) fn stretch(
        &mut self,
        places: impl Iterator<Item = Vec3>,
        around: &Aabb,
        (axis, [low, high]): (usize, [f64; 2]),
        ratio: f64,
    ) {
        let rate = (high - low) / around.size()[axis];
        let middle = 0.5 * (around.min + around.max);
        for (velocity, place) in self.velocity.iter_mut().zip(places) {
            *velocity = (-ratio * rate * (place - middle)).into();
            velocity[axis] = low + rate * (place - around.min)[axis];
        }
    }

    /// Kinetic energy, mJ.
    pub(crate) fn kinetic(&self) -> f64 {
        let of = |(mass, v): (&f64, &[f64; 3])| 0.5 * mass * v.iter().map(|v| v * v).sum::<f64>();
        self.mass.iter().zip(&self.velocity).map(of).sum()
    }

    /// Mass of a node, and its displacement and its velocity along `axis` after a step under the blocks' `forces` alone.
    pub(crate) fn free(&self, forces: &[[f32; 4]], dt: f64, (node, axis): (usize, usize)) -> [f64; 3] {
        let (m, u, v) = (self.mass[node], self.displacement[node][axis], self.velocity[node][axis]);
        let own = |[other, _]: &[u32; 2]| *other as usize;
        let from = self.more.partition_point(|share| own(share) < node);
        let more = self.more[from..].iter().take_while(|share| own(share) == node).map(|[_, place]| place);
        let mut force = [0.0; 3];
        std::iter::once(&self.first[node]).chain(more).for_each(|&place| add(&mut force, forces, place));
        [m, u, v - dt / m * force[axis]]
    }

    /// Moves all nodes by a step under the blocks' `forces`, with the instructions of `set`.
    pub(crate) fn advance(
        &mut self,
        set: InstructionSet,
        forces: &[[f32; 4]],
        supports: &Supports,
        motion: &Motion,
    ) -> Sums {
        let Self { displacement, velocity, mass, first, more } = self;
        let spans = displacement.par_chunks_mut(SPAN).zip(velocity.par_chunks_mut(SPAN)).enumerate();
        let spans = spans.map(|(number, (u, v))| {
            let start = number * SPAN;
            let (mass, first) = (&mass[start..], &first[start..]);
            let more = &more[more.partition_point(|&[node, _]| (node as usize) < start)..];
            set.run(Advance { span: NodeSpan { start, mass, first, more, forces, supports, motion }, u, v })
        });
        let sums: Vec<Sums> = spans.collect();
        sums.iter().fold(Sums::default(), Sums::with)
    }
}

/// Consecutive nodes, and all that moves them.
struct NodeSpan<'a> {
    /// Number of its first node.
    start: usize,
    mass: &'a [f64],
    first: &'a [u32],
    more: &'a [[u32; 2]],
    forces: &'a [[f32; 4]],
    supports: &'a Supports,
    motion: &'a Motion,
}

/// A step of a span: its displacements and velocities.
struct Advance<'a> {
    span: NodeSpan<'a>,
    u: &'a mut [[f64; 3]],
    v: &'a mut [[f64; 3]],
}

impl Task for Advance<'_> {
    type Output = Sums;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Sums {
        self.span.advance(self.u, self.v)
    }
}

impl NodeSpan<'_> {
    /// Flat loops over some nodes that stay in the first cache, which compilers turn into registers of several numbers; the few
    /// nodes with supports go one by one. No closures, which would be compiled without the instruction set.
    #[inline(always)]
    fn advance(&self, u: &mut [[f64; 3]], v: &mut [[f64; 3]]) -> Sums {
        let end = self.start + u.len();
        let mut contacts = self.supports.among(self.start, end).iter().peekable();
        let mut loads = self.supports.loads_among(self.start, end).iter().peekable();
        let (mut sums, dt, mut more) = (Sums::default(), self.motion.dt, self.more.iter().peekable());
        let [mut force, mut before, mut push, mut power] = [[[0.0; 3]; TOGETHER]; 4];
        let together = u.chunks_mut(TOGETHER).zip(v.chunks_mut(TOGETHER));
        for (start, (u, v)) in (0..).step_by(TOGETHER).zip(together) {
            let mass = &self.mass[start..start + u.len()];
            let [force, before, push, power] =
                [&mut force, &mut before, &mut push, &mut power].map(|some| &mut some[..u.len()]);
            self.resist(start, &mut more, force);
            before.copy_from_slice(v);
            for (push, m) in push.iter_mut().zip(mass) {
                *push = [dt / m; 3];
            }
            let pushed = force.as_flattened().iter().zip(push.as_flattened());
            for (v, (force, push)) in v.as_flattened_mut().iter_mut().zip(pushed) {
                *v -= force * push;
            }
            let first = self.start + start;
            let node_of = |node: u32| Some(node as usize - first).filter(|i| *i < mass.len());
            while let Some(i) = [contacts.peek().map(|own| own.node), loads.peek().map(|own| own.node)]
                .into_iter()
                .flatten()
                .min()
                .and_then(node_of)
            {
                let is_here = |node: u32| node as usize == first + i;
                let mut load = None;
                while let Some(own) = loads.next_if(|load| is_here(load.node)) {
                    let (pressure, sum) =
                        (self.motion.supports[own.support as usize].pressure, load.get_or_insert([0.0; 3]));
                    (0..3).for_each(|k| sum[k] += pressure * own.force[k]);
                }
                let (before, v) = (&before[i], &mut v[i]);
                if let Some(load) = load {
                    (0..3).for_each(|k| v[k] += load[k] * push[i][k]);
                }
                let mut touched: Option<Touched> = None;
                while let Some(contact) = contacts.next_if(|contact| is_here(contact.node)) {
                    let support = contact.support as usize;
                    let moved = (dt, &self.motion.supports[support]);
                    let face = &self.supports.all[support].face;
                    let impact = face.meet(contact.gap, moved, mass[i], &u[i], v, touched.get_or_insert_default());
                    sums.supports[support] += impact.force;
                    // What a plate loses in an impact is not the specimen's.
                    let work = 0.5 * dt * impact.force * (before[face.axis] + v[face.axis]);
                    sums.external += if self.supports.is_driven { work } else { impact.work };
                }
                if let Some(touched) = touched {
                    sums.friction += touched.friction(dt, before, v);
                }
                if let Some(load) = load {
                    sums.external += 0.5 * dt * (0..3).map(|k| load[k] * (before[k] + v[k])).sum::<f64>();
                }
            }
            let speeds = before.as_flattened().iter().zip(v.as_flattened());
            let powers = power.as_flattened_mut().iter_mut().zip(force.as_flattened()).zip(speeds);
            for ((power, force), (before, v)) in powers {
                *power = force * (before + v);
            }
            for ((power, v), m) in power.iter().zip(&*v).zip(mass) {
                sums.internal += 0.5 * dt * power.iter().sum::<f64>();
                sums.kinetic += 0.5 * m * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
            }
            for (u, v) in u.as_flattened_mut().iter_mut().zip(v.as_flattened()) {
                *u += dt * v;
            }
        }
        sums
    }

    /// Forces with which the elements resist at the nodes from `start`, N.
    #[inline(always)]
    fn resist(&self, start: usize, more: &mut Peekable<Iter<[u32; 2]>>, forces: &mut [[f64; 3]]) {
        for (force, &place) in forces.iter_mut().zip(&self.first[start..]) {
            *force = [0.0; 3];
            add(force, self.forces, place);
        }
        let start = self.start + start;
        while let Some(&[node, place]) = more.next_if(|[node, _]| (*node as usize) < start + forces.len()) {
            add(&mut forces[node as usize - start], self.forces, place);
        }
    }
}

/// Adds the share at a `place` of the blocks' `forces`.
#[inline(always)]
fn add(force: &mut [f64; 3], forces: &[[f32; 4]], place: u32) {
    let share = &forces[place as usize];
    for k in 0..3 {
        force[k] += f64::from(share[k]);
    }
}
