//! Elements of uniform strain, small displacements: tetrahedra (C3D4), and the patches of edges (see `patches`).
//!
//! With the gradients g_a of the shape functions, strain = sym(sum u_a g_a) and the nodal forces are V stress g_a. The
//! gradients add up to zero, so that of the first node is left out, and displacements are taken relative to it: forces are in
//! balance and a translation has no strain, whatever the gradients' digits. Outside of the cache a step waits for bytes, and
//! gradients are most of them, so they have 16 bits: each is within 1.7e-5 of the element's largest component.

use crate::lanes::{LANES, Lanes, Octet, Places, Short, Vectors};
use crate::law::Tensor;
use meso_collision::math::Vec3;

/// Eight elements of `N` nodes beside the first one.
#[derive(Clone, Copy, Debug)]
pub struct Uniform<const N: usize> {
    first: Places,
    others: [Node; N],
    /// A lane's unit of gradients, 1/mm.
    unit: Octet,
    /// mm3; 0 in lanes that are empty.
    pub volume: Octet,
    /// Width of a crack band, mm.
    pub width: Octet,
}

/// A node of eight elements: 64 bytes, so that loops over nodes have one address.
#[derive(Clone, Copy, Debug, Default)]
struct Node {
    at: Places,
    /// x, y, z of the gradient, in units of the lane.
    gradient: [Short; 3],
}

/// Units in the largest component of an element's gradients. It has many divisors, so that the simple ratios of lattices are
/// exact: all elements of one shape would else be too stiff or too soft alike.
const UNITS: f64 = 30_240.0;

/// Eight tetrahedra.
pub type Tets = Uniform<3>;

impl<const N: usize> Default for Uniform<N> {
    fn default() -> Self {
        Self {
            first: Places::default(),
            others: [Node::default(); N],
            unit: Octet::default(),
            volume: Octet::default(),
            width: Octet::default(),
        }
    }
}

impl<const N: usize> Uniform<N> {
    /// Puts an element into `lane`: its nodes, and the gradients of all but the first. Where it has fewer than `N + 1`,
    /// the first one fills the places without weight.
    pub fn set(&mut self, lane: usize, nodes: &[u16], gradients: &[Vec3], volume: f64, width: f64) {
        self.first.set(lane, nodes[0]);
        let largest = gradients.iter().map(Vec3::amax).fold(0.0, f64::max);
        let unit = (largest / UNITS) as f32;
        for (place, node) in self.others.iter_mut().enumerate() {
            node.at.set(lane, *nodes.get(place + 1).unwrap_or(&nodes[0]));
            let gradient = gradients.get(place).copied().unwrap_or_default() / f64::from(unit);
            (0..3).for_each(|axis| node.gradient[axis].0[lane] = gradient[axis].round_ties_even() as i16);
        }
        self.unit.0[lane] = unit;
        self.volume.0[lane] = volume as f32;
        self.width.0[lane] = width as f32;
    }

    /// The eight elements as words: nodes of the others, two to a word, then of the first; volumes; widths; units; x, y, z of
    /// the others' gradients, two to a word. Eight lanes each.
    pub fn words(&self, out: &mut Vec<u32>) {
        self.others.iter().map(|node| &node.at).chain([&self.first]).for_each(|at| out.extend(pairs(at.nodes())));
        out.extend([&self.volume, &self.width, &self.unit].into_iter().flat_map(|eight| eight.0.map(f32::to_bits)));
        self.others
            .iter()
            .flat_map(|node| &node.gradient)
            .for_each(|eight| out.extend(pairs(eight.0.map(i16::cast_unsigned))));
    }

    /// Strains of the displacements `u`.
    #[inline(always)]
    pub fn strain<L: Lanes>(&self, u: &Vectors) -> Tensor<L> {
        let origin = L::gather(u, &self.first);
        let mut h = [[L::splat(0.0); 3]; 3];
        for node in &self.others {
            let moved = L::gather(u, &node.at);
            let g = node.gradient.each_ref().map(L::load_short);
            for i in 0..3 {
                let relative = moved[i] - origin[i];
                for j in 0..3 {
                    h[i][j] = relative.mul_add(g[j], h[i][j]);
                }
            }
        }
        let unit = L::load(&self.unit);
        [h[0][0], h[1][1], h[2][2], h[0][1] + h[1][0], h[1][2] + h[2][1], h[0][2] + h[2][0]].map(|sum| sum * unit)
    }

    /// Adds the forces with which the elements resist.
    #[inline(always)]
    pub fn resist<L: Lanes>(&self, stress: &Tensor<L>, forces: &mut Vectors) {
        let weight = L::load(&self.volume) * L::load(&self.unit);
        let [xx, yy, zz, xy, yz, zx] = stress.map(|s| s * weight);
        let mut rest = [L::splat(0.0); 3];
        for node in &self.others {
            let [a, b, c] = node.gradient.each_ref().map(L::load_short);
            let force = [
                xx.mul_add(a, xy.mul_add(b, zx * c)),
                xy.mul_add(a, yy.mul_add(b, yz * c)),
                zx.mul_add(a, yz.mul_add(b, zz * c)),
            ];
            for i in 0..3 {
                rest[i] = rest[i] - force[i];
            }
            L::scatter(forces, &node.at, force);
        }
        L::scatter(forces, &self.first, rest);
    }
}

/// Eight numbers as four words.
pub(crate) fn pairs(eight: [u16; LANES]) -> impl Iterator<Item = u32> {
    (0..LANES / 2).map(move |pair| u32::from(eight[2 * pair]) | u32::from(eight[2 * pair + 1]) << 16)
}
