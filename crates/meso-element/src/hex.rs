//! C3D8R: the box with one integration point, small displacements, and stiffness against its hourglass modes.
//!
//! The eight displacements along an axis are a mean, three gradients and four hourglass modes, orthogonal and with
//! entries of 1 and -1 (Flanagan and Belytschko 1981): a Walsh-Hadamard transform takes one to the other in 24 sums. An
//! hourglass mode m resists with k m, k = c (4/3) E h / 64 times the remaining share of the stiffness: h the edge of the cube of
//! equal volume, c the hourglass factor.
//!
//! So it is for mortar and ITZ; boxes that never break bend instead (see `bending`).
//!
//! A softening material bears no more than its strength, so there the forces of all modes M have a bound b: their energy is
//! k b^2 (sqrt(1 + M^2 / b^2) - 1), and the force k m / sqrt(1 + M^2 / b^2). Without it, crushed boxes keep a strength that
//! no law gave them.

use crate::lanes::{Lanes, Octet, Places, Vectors};
use crate::law::Tensor;

/// Corners of `CellKind::Hexahedron` by their signs: bit 0 is set at the upper x, bit 1 at the upper y, bit 2 at the upper z.
const BY_SIGNS: [usize; 8] = [0, 1, 3, 2, 4, 5, 7, 6];
/// The modes of an axis, as sets of the same bits: gradients along x, y, z.
const GRADIENTS: [usize; 3] = [0b001, 0b010, 0b100];
/// Hourglass modes.
const HOURGLASS: [usize; 4] = [0b011, 0b110, 0b101, 0b111];

/// Eight boxes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hexes {
    /// Node numbers within the block, node by node.
    pub at: [Places; 8],
    /// 1, or 0 in lanes that are empty.
    pub used: Octet,
}

/// Data that all boxes of a mesh share.
#[derive(Clone, Copy, Debug)]
pub struct BoxShape {
    /// Edges, mm.
    pub edges: [f64; 3],
}

impl BoxShape {
    /// mm3.
    pub fn volume(&self) -> f64 {
        self.edges.iter().product()
    }

    /// Edge of the cube of equal volume, mm.
    pub fn edge(&self) -> f64 {
        libm::cbrt(self.volume())
    }
}

/// Hourglass amplitudes of the three displacements.
pub type Hourglass<L> = [[L; 4]; 3];

/// Corners without and with every bit.
const PAIRS: [[(usize, usize); 4]; 3] =
    [[(0, 1), (2, 3), (4, 5), (6, 7)], [(0, 2), (1, 3), (4, 6), (5, 7)], [(0, 4), (1, 5), (2, 6), (3, 7)]];

// Loops with fixed ends instead of closures: a call that is not inlined here costs ten times the time.

/// From values at the corners to modes.
#[inline(always)]
fn analyse<L: Lanes>(v: &mut [L; 8]) {
    for pairs in &PAIRS {
        for &(low, high) in pairs {
            (v[low], v[high]) = (v[high] + v[low], v[high] - v[low]);
        }
    }
}

/// From modes to values at the corners.
#[inline(always)]
fn compose<L: Lanes>(v: &mut [L; 8]) {
    for pairs in &PAIRS {
        for &(low, high) in pairs {
            (v[low], v[high]) = (v[low] - v[high], v[low] + v[high]);
        }
    }
}

impl Hexes {
    /// Puts a box into `lane`.
    pub fn set(&mut self, lane: usize, at: [u16; 8], used: bool) {
        for (place, node) in self.at.iter_mut().zip(at) {
            place.set(lane, node);
        }
        self.used.0[lane] = f32::from(u8::from(used));
    }

    /// Strains at the centre, and the hourglass amplitudes, mm.
    #[inline(always)]
    pub fn strain<L: Lanes>(&self, u: &Vectors, shape: &BoxShape) -> (Tensor<L>, Hourglass<L>) {
        let mut modes = [[L::splat(0.0); 8]; 3];
        for signs in 0..8 {
            let moved = L::gather(u, &self.at[BY_SIGNS[signs]]);
            for axis in 0..3 {
                modes[axis][signs] = moved[axis];
            }
        }
        for axis in &mut modes {
            analyse(axis);
        }
        let (mut h, mut hourglass) = ([[L::splat(0.0); 3]; 3], [[L::splat(0.0); 4]; 3]);
        for i in 0..3 {
            for j in 0..3 {
                h[i][j] = modes[i][GRADIENTS[j]] * L::splat(0.25 / shape.edges[j]);
            }
            for j in 0..4 {
                hourglass[i][j] = modes[i][HOURGLASS[j]];
            }
        }
        ([h[0][0], h[1][1], h[2][2], h[0][1] + h[1][0], h[1][2] + h[2][1], h[0][2] + h[2][0]], hourglass)
    }

    /// Adds the forces with which the elements resist; `stiffness` is that of an hourglass mode, N/mm.
    #[inline(always)]
    pub fn resist<L: Lanes>(
        &self,
        stress: &Tensor<L>,
        hourglass: &Hourglass<L>,
        stiffness: L,
        shape: &BoxShape,
        forces: &mut Vectors,
    ) {
        let used = L::load(&self.used);
        let [xx, yy, zz, xy, yz, zx] = *stress;
        let rows = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
        let k = stiffness * used;
        let mut nodal = [[L::splat(0.0); 8]; 3];
        for i in 0..3 {
            for j in 0..3 {
                let area = L::splat(0.25 * shape.volume() / shape.edges[j]) * used;
                nodal[i][GRADIENTS[j]] = rows[i][j] * area;
            }
            for j in 0..4 {
                nodal[i][HOURGLASS[j]] = hourglass[i][j] * k;
            }
            compose(&mut nodal[i]);
        }
        for signs in 0..8 {
            L::scatter(forces, &self.at[BY_SIGNS[signs]], [nodal[0][signs], nodal[1][signs], nodal[2][signs]]);
        }
    }

    /// Twice the energy of the hourglass modes over their stiffness, mm2, and the share of the stiffness that their bound
    /// leaves; 0 in lanes that are empty. `per_bound` is 1 / b^2, per mm2, and 0 without a bound.
    #[inline(always)]
    pub fn bounded<L: Lanes>(&self, hourglass: &Hourglass<L>, per_bound: L) -> (L, L) {
        let mut sum = L::splat(0.0);
        for axis in hourglass {
            for mode in axis {
                sum = mode.mul_add(*mode, sum);
            }
        }
        let (one, used) = (L::splat(1.0), L::load(&self.used));
        let root = sum.mul_add(per_bound, one).sqrt();
        // b^2 (root - 1) = M^2 / (root + 1), without cancellation.
        ((sum + sum) / (root + one) * used, used / root)
    }
}

/// Amplitude beyond which the hourglass modes of softening elements hardly gain force, over the edge: a strain of 2.5e-4 at the
/// corners, twice that of the tensile strength. A cube of 24 mm of concrete in boxes of 1.5 mm held 4.9 % of its internal
/// energy in hourglass modes without a bound, 0.57 % with 0.002 and 0.30 % with 0.001, with peaks of 35.7, 34.9 and 34.7 MPa.
const BOUND: f64 = 0.001;

/// 1 / b^2 for boxes of this edge, per mm2.
pub fn per_bound(edge: f64) -> f64 {
    1.0 / (BOUND * edge).powi(2)
}

/// Stiffness of an hourglass mode, N/mm, of a box with this edge, Young's modulus and hourglass factor.
pub fn hourglass_stiffness(factor: f64, youngs_modulus_mpa: f64, edge: f64) -> f64 {
    factor * 4.0 / 3.0 * youngs_modulus_mpa * edge / 64.0
}
