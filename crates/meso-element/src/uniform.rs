//! Elements of uniform strain, small displacements: tetrahedra (C3D4), and the patches of edges (see `patches`).
//!
//! With the gradients g_a of the shape functions, strain = sym(sum u_a g_a) and the nodal forces are V stress g_a. The
//! gradients add up to zero, so that of the first node is left out, and displacements are taken relative to it.

use crate::lanes::{LANES, Lanes, Octet, Vectors};
use crate::law::Tensor;
use meso_collision::math::Vec3;

/// Eight elements of `N` nodes beside the first one.
#[derive(Clone, Copy, Debug)]
pub struct Uniform<const N: usize> {
    /// The first node's number within the block.
    first: [u16; LANES],
    /// The other nodes' numbers within the block, node by node.
    others: [[u16; LANES]; N],
    /// x, y, z of the others' gradients, 1/mm.
    gradients: [[Octet; 3]; N],
    /// mm3; 0 in lanes that are empty.
    pub volume: Octet,
    /// Width of a crack band, mm.
    pub width: Octet,
}

/// Eight tetrahedra.
pub type Tets = Uniform<3>;

impl<const N: usize> Default for Uniform<N> {
    fn default() -> Self {
        Self {
            first: [0; LANES],
            others: [[0; LANES]; N],
            gradients: [[Octet::default(); 3]; N],
            volume: Octet::default(),
            width: Octet::default(),
        }
    }
}

impl<const N: usize> Uniform<N> {
    /// Puts an element into `lane`: its nodes, and the gradients of all but the first. Where it has fewer than `N + 1`,
    /// the first one fills the places without weight.
    pub fn set(&mut self, lane: usize, nodes: &[u16], gradients: &[Vec3], volume: f64, width: f64) {
        self.first[lane] = nodes[0];
        for place in 0..N {
            self.others[place][lane] = *nodes.get(place + 1).unwrap_or(&nodes[0]);
            let gradient = gradients.get(place).copied().unwrap_or_default();
            (0..3).for_each(|axis| self.gradients[place][axis].0[lane] = gradient[axis] as f32);
        }
        self.volume.0[lane] = volume as f32;
        self.width.0[lane] = width as f32;
    }

    /// The eight elements as words: nodes of the others, two to a word, then of the first; x, y, z of the others' gradients;
    /// volumes; widths. Eight lanes each.
    pub fn words(&self, out: &mut Vec<u32>) {
        for at in self.others.iter().chain([&self.first]) {
            out.extend(at.chunks_exact(2).map(|pair| u32::from(pair[0]) | u32::from(pair[1]) << 16));
        }
        let numbers = self.gradients.iter().flatten().chain([&self.volume, &self.width]);
        out.extend(numbers.flat_map(|eight| eight.0.map(f32::to_bits)));
    }

    /// Strains of the displacements `u`.
    #[inline(always)]
    pub fn strain<L: Lanes>(&self, u: &Vectors) -> Tensor<L> {
        let origin = L::gather(u, &self.first);
        let mut h = [[L::splat(0.0); 3]; 3];
        for node in 0..N {
            let moved = L::gather(u, &self.others[node]);
            let [a, b, c] = &self.gradients[node];
            let g = [L::load(a), L::load(b), L::load(c)];
            for i in 0..3 {
                let relative = moved[i] - origin[i];
                for j in 0..3 {
                    h[i][j] = relative.mul_add(g[j], h[i][j]);
                }
            }
        }
        [h[0][0], h[1][1], h[2][2], h[0][1] + h[1][0], h[1][2] + h[2][1], h[0][2] + h[2][0]]
    }

    /// Adds the forces with which the elements resist.
    #[inline(always)]
    pub fn resist<L: Lanes>(&self, stress: &Tensor<L>, forces: &mut Vectors) {
        let volume = L::load(&self.volume);
        let mut weighted = *stress;
        for s in &mut weighted {
            *s = *s * volume;
        }
        let [xx, yy, zz, xy, yz, zx] = weighted;
        let mut rest = [L::splat(0.0); 3];
        for node in 0..N {
            let [a, b, c] = &self.gradients[node];
            let (a, b, c) = (L::load(a), L::load(b), L::load(c));
            let force = [
                xx.mul_add(a, xy.mul_add(b, zx * c)),
                xy.mul_add(a, yy.mul_add(b, yz * c)),
                zx.mul_add(a, yz.mul_add(b, zz * c)),
            ];
            for i in 0..3 {
                rest[i] = rest[i] - force[i];
            }
            L::scatter(forces, &self.others[node], force);
        }
        L::scatter(forces, &self.first, rest);
    }
}
