//! Nodes by their positions, and the lattice that new ones lie on.

use super::Triangles;
use meso_collision::math::Vec3;
use meso_concrete::aggregate::grain::rounded_to;
use meso_concrete::stop;
use std::collections::BTreeMap;

/// New nodes are multiples of 2^-40 mm: so sums with bodies' coordinates and periods are exact up to 8 m.
const LATTICE_MM: f64 = 1.0 / (1u64 << 40) as f64;

/// Rounds to the lattice of new nodes.
pub(crate) fn snap(position: Vec3) -> Vec3 {
    rounded_to(LATTICE_MM, &position)
}

/// Nodes by their positions, bit for bit.
#[derive(Default)]
pub(crate) struct Nodes {
    pub(crate) points: Vec<Vec3>,
    numbers: BTreeMap<[u64; 3], u32>,
}

impl Nodes {
    /// The number of the node at `position`, a new one where there is none.
    pub(crate) fn at(&mut self, position: Vec3) -> u32 {
        stop::point();
        *self.numbers.entry(key(&position)).or_insert_with(|| {
            self.points.push(position);
            self.points.len() as u32 - 1
        })
    }

    /// The triangles of a surface on these nodes.
    pub(crate) fn triangles(&mut self, surface: &Triangles) -> Vec<[u32; 3]> {
        let number: Vec<u32> = surface.points.iter().map(|point| self.at(*point)).collect();
        surface.triangles.iter().map(|triangle| triangle.map(|node| number[node as usize])).collect()
    }
}

/// A position as a key for look-ups: -0 and 0 are one.
pub(crate) fn key(position: &Vec3) -> [u64; 3] {
    position.map(|x| (x + 0.0).to_bits()).into()
}
