//! Nodes: they sum the blocks' forces in the blocks' order, and move by central differences.

use crate::march::supports::Supports;
use crate::march::supports::contact::{Motion, Touched};
use meso_element::block::Block;
use meso_trial::MOST_SUPPORTS;
use rayon::prelude::*;

/// Nodes per parallel task. Sums are added span by span, so that the number of threads cannot change them.
pub const SPAN: usize = 4096;

/// Displacements and velocities, by the engine's numbers.
#[derive(Clone, Debug)]
pub(crate) struct Nodes {
    /// At whole steps, mm.
    pub(crate) displacement: Vec<[f64; 3]>,
    /// At half steps, mm/s.
    pub(crate) velocity: Vec<[f64; 3]>,
    /// Lumped, tonne.
    pub(crate) mass: Vec<f64>,
    /// Where each node's shares begin in `shares`.
    first: Vec<u32>,
    /// Indices into the blocks' forces.
    shares: Vec<u32>,
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
        let count = mass.len();
        let mut first = vec![0u32; count + 1];
        let all = || blocks.iter().flat_map(|block| &block.nodes);
        all().for_each(|&node| first[node as usize + 1] += 1);
        (0..count).for_each(|node| first[node + 1] += first[node]);
        let mut next = first.clone();
        let mut shares = vec![0; first[count] as usize];
        for (place, &node) in (0..).zip(all()) {
            let next = &mut next[node as usize];
            shares[*next as usize] = place;
            *next += 1;
        }
        let still = || vec![[0.0; 3]; count];
        Self { displacement: still(), velocity: still(), mass, first, shares }
    }

    /// Back to the start.
    pub(crate) fn rest(&mut self) {
        self.displacement.fill([0.0; 3]);
        self.velocity.fill([0.0; 3]);
    }

    /// Bytes that they hold.
    pub(crate) fn bytes(&self) -> usize {
        let Self { displacement, velocity, mass, first, shares } = self;
        2 * size_of_val(&**displacement).max(size_of_val(&**velocity))
            + size_of_val(&**mass)
            + size_of_val(&**first)
            + size_of_val(&**shares)
    }

    /// Where each node's shares begin, and their places among the blocks' forces.
    pub(crate) fn shares(&self) -> [&[u32]; 2] {
        [&self.first, &self.shares]
    }

    /// Number of the blocks' forces.
    pub(crate) fn places(&self) -> usize {
        self.shares.len()
    }

    /// Mass of a node, and its displacement and its velocity along `axis` after a step under the blocks' `forces` alone.
    pub(crate) fn free(&self, forces: &[[f32; 4]], dt: f64, (node, axis): (usize, usize)) -> [f64; 3] {
        let (m, u, v) = (self.mass[node], self.displacement[node][axis], self.velocity[node][axis]);
        let force = sum(forces, &self.shares[self.first[node] as usize..self.first[node + 1] as usize]);
        [m, u, v - dt / m * force[axis]]
    }

    /// Moves all nodes by a step under the blocks' `forces`.
    pub(crate) fn advance(&mut self, forces: &[[f32; 4]], supports: &Supports, motion: &Motion) -> Sums {
        let Self { displacement, velocity, mass, first, shares } = self;
        let spans = displacement.par_chunks_mut(SPAN).zip(velocity.par_chunks_mut(SPAN)).enumerate();
        let spans = spans.map(|(number, (u, v))| {
            let start = number * SPAN;
            let (mass, first) = (&mass[start..], &first[start..]);
            let span = Span { start, mass, first, shares, forces, supports, motion };
            span.advance(u, v)
        });
        let sums: Vec<Sums> = spans.collect();
        sums.iter().fold(Sums::default(), Sums::with)
    }
}

/// Consecutive nodes, and all that moves them.
struct Span<'a> {
    /// Number of its first node.
    start: usize,
    mass: &'a [f64],
    first: &'a [u32],
    shares: &'a [u32],
    forces: &'a [[f32; 4]],
    supports: &'a Supports,
    motion: &'a Motion,
}

impl Span<'_> {
    fn advance(&self, u: &mut [[f64; 3]], v: &mut [[f64; 3]]) -> Sums {
        let end = self.start + u.len();
        let mut contacts = self.supports.among(self.start, end).iter().peekable();
        let mut loads = self.supports.loads_among(self.start, end).iter().peekable();
        let (mut sums, dt) = (Sums::default(), self.motion.dt);
        for (i, (u, v)) in u.iter_mut().zip(v).enumerate() {
            let (force, m) = (self.force(i), self.mass[i]);
            let before = *v;
            let push = dt / m;
            (0..3).for_each(|k| v[k] -= force[k] * push);
            let mut load = None;
            while let Some(own) = loads.next_if(|load| load.node as usize == self.start + i) {
                let (pressure, sum) =
                    (self.motion.supports[own.support as usize].pressure, load.get_or_insert([0.0; 3]));
                (0..3).for_each(|k| sum[k] += pressure * own.force[k]);
            }
            if let Some(load) = load {
                (0..3).for_each(|k| v[k] += load[k] * push);
            }
            let mut touched: Option<Touched> = None;
            while let Some(contact) = contacts.next_if(|contact| contact.node as usize == self.start + i) {
                let support = contact.support as usize;
                let moved = (dt, &self.motion.supports[support]);
                let impact =
                    self.supports.all[support].face.meet(contact.gap, moved, m, u, v, touched.get_or_insert_default());
                sums.supports[support] += impact.force;
                let axis = self.supports.all[support].face.axis;
                // What a plate loses in an impact is not the specimen's.
                let work = 0.5 * dt * impact.force * (before[axis] + v[axis]);
                sums.external += if self.supports.is_driven { work } else { impact.work };
            }
            if let Some(touched) = touched {
                sums.friction += touched.friction(dt, &before, v);
            }
            if let Some(load) = load {
                sums.external += 0.5 * dt * (0..3).map(|k| load[k] * (before[k] + v[k])).sum::<f64>();
            }
            sums.internal += 0.5 * dt * (0..3).map(|k| force[k] * (before[k] + v[k])).sum::<f64>();
            sums.kinetic += 0.5 * m * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
            (0..3).for_each(|k| u[k] += dt * v[k]);
        }
        sums
    }

    /// Force with which the elements resist at a node, N.
    fn force(&self, i: usize) -> [f64; 3] {
        sum(self.forces, &self.shares[self.first[i] as usize..self.first[i + 1] as usize])
    }
}

/// Sum of a node's shares in their order.
fn sum(forces: &[[f32; 4]], shares: &[u32]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for &place in shares {
        let share = &forces[place as usize];
        (0..3).for_each(|k| sum[k] += f64::from(share[k]));
    }
    sum
}
