//! C3D4: the tetrahedron of constant strain, small displacements.
//!
//! With the gradients g_a of the shape functions, strain = sym(sum u_a g_a) and the nodal forces are V stress g_a. The
//! gradients add up to zero, so three of them are kept, and displacements are taken relative to the first node.

use crate::lanes::{Eight, LANES, Lanes, Vectors};
use crate::law::Tensor;
use meso_core::math::{Mat3, Vec3};

/// Gradients of the shape functions of the second to the fourth node, 1/mm, and the volume, mm3.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    /// One row per node.
    pub(crate) gradients: [Vec3; 3],
    /// Negative where the nodes are out of order.
    pub(crate) volume: f64,
}

impl Shape {
    /// Of the tetrahedron with these corners.
    pub(crate) fn of(corners: &[Vec3; 4]) -> Self {
        let [a, b, c] = [1, 2, 3].map(|i| corners[i] - corners[0]);
        let six = a.dot(&b.cross(&c));
        Self { gradients: [b.cross(&c) / six, c.cross(&a) / six, a.cross(&b) / six], volume: six / 6.0 }
    }

    /// sum g_a g_a^T over all four nodes, 1/mm2.
    pub(crate) fn metric(&self) -> Mat3 {
        let first = -(self.gradients[0] + self.gradients[1] + self.gradients[2]);
        self.gradients.iter().fold(first * first.transpose(), |sum, g| sum + g * g.transpose())
    }
}

/// Eight tetrahedra.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tets {
    /// Node numbers within the block, node by node.
    pub(crate) at: [[u16; LANES]; 4],
    /// x, y, z of the second to the fourth node's gradient, 1/mm.
    pub(crate) gradients: [[Eight; 3]; 3],
    /// mm3; 0 in lanes that are empty.
    pub(crate) volume: Eight,
    /// Width of a crack band, mm.
    pub(crate) width: Eight,
}

impl Tets {
    /// Puts a tetrahedron into `lane`.
    pub(crate) fn set(&mut self, lane: usize, at: [u16; 4], shape: &Shape, width: f64) {
        for (place, node) in self.at.iter_mut().zip(at) {
            place[lane] = node;
        }
        for (rows, gradient) in self.gradients.iter_mut().zip(&shape.gradients) {
            (0..3).for_each(|axis| rows[axis].0[lane] = gradient[axis] as f32);
        }
        self.volume.0[lane] = shape.volume as f32;
        self.width.0[lane] = width as f32;
    }

    /// Strains of the displacements `u`.
    #[inline(always)]
    pub(crate) fn strain<L: Lanes>(&self, u: &Vectors) -> Tensor<L> {
        let origin = L::gather(u, &self.at[0]);
        let mut h = [[L::splat(0.0); 3]; 3];
        for node in 0..3 {
            let moved = L::gather(u, &self.at[node + 1]);
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
    pub(crate) fn resist<L: Lanes>(&self, stress: &Tensor<L>, forces: &mut Vectors) {
        let volume = L::load(&self.volume);
        let mut weighted = *stress;
        for s in &mut weighted {
            *s = *s * volume;
        }
        let [xx, yy, zz, xy, yz, zx] = weighted;
        let mut rest = [L::splat(0.0); 3];
        for node in 0..3 {
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
            L::scatter(forces, &self.at[node + 1], force);
        }
        L::scatter(forces, &self.at[0], rest);
    }
}
