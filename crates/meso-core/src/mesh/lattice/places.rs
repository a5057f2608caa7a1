//! Node positions that several threads move at once, each thread its own nodes.
//!
//! Coordinates are kept as the bits of atomics, read and written without order: nodes that move at the same time share
//! no tetrahedron, so that nobody reads what another writes.

use crate::math::Vec3;
use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};

/// Positions of all nodes, and which steps are to look at which of them.
pub(super) struct Places {
    points: Vec<[AtomicU64; 3]>,
    waiting: Vec<AtomicU8>,
}

impl Places {
    /// All nodes are to be looked at.
    pub(super) fn new(points: &[Vec3]) -> Self {
        let bits = |p: &Vec3| [p.x, p.y, p.z].map(|x| AtomicU64::new(x.to_bits()));
        Self {
            points: points.iter().map(bits).collect(),
            waiting: points.iter().map(|_| AtomicU8::new(u8::MAX)).collect(),
        }
    }

    pub(super) fn get(&self, node: u32) -> Vec3 {
        let [x, y, z] = &self.points[node as usize];
        let load = |bits: &AtomicU64| f64::from_bits(bits.load(Ordering::Relaxed));
        Vec3::new(load(x), load(y), load(z))
    }

    pub(super) fn set(&self, node: u32, to: &Vec3) {
        for (bits, x) in self.points[node as usize].iter().zip(to.iter()) {
            bits.store(x.to_bits(), Ordering::Relaxed);
        }
    }

    /// Whether anything around the node has changed since it was last asked about by this step.
    pub(super) fn take_turn(&self, node: u32, step: usize) -> bool {
        self.waiting[node as usize].fetch_and(!(1 << step), Ordering::Relaxed) >> step & 1 == 1
    }

    /// The node is to be looked at again by this step.
    pub(super) fn wait(&self, node: u32, step: usize) {
        self.waiting[node as usize].fetch_or(1 << step, Ordering::Relaxed);
    }

    /// Something around the node has changed.
    pub(super) fn wake(&self, node: u32) {
        self.waiting[node as usize].store(u8::MAX, Ordering::Relaxed);
    }

    pub(super) fn into_points(self) -> Vec<Vec3> {
        let point = |bits: [AtomicU64; 3]| Vec3::from(bits.map(|x| f64::from_bits(x.into_inner())));
        self.points.into_iter().map(point).collect()
    }
}
