//! Stiffness and eigenstress of a voxel that interfaces cut: a laminate with the interface's normal.
//!
//! Strains along the interface and tractions across it are equal in all phases. With the normal `n`, phases of share `f`,
//! stiffness `C`, eigenstress `s`, acoustic tensor `A = n C n` and tractions `B = n C`:
//!
//! ```text
//! H = sum f A^-1,  G = sum f A^-1 B,  C' = sum f (C - B^T A^-1 B) + G^T H^-1 G
//! s' = sum f (s - B^T A^-1 n s) + G^T H^-1 sum f A^-1 n s
//! ```
//!
//! Strains and stresses are in the order xx, yy, zz, yz, zx, xy; shear strains are engineering strains.

use crate::moduli::Moduli;
use meso_collision::math::Vec3;

/// Symmetric stiffness, by rows from the diagonal on.
pub(super) type Packed = [f32; 21];
pub(super) type Matrix6 = [[f64; 6]; 6];

/// Place of an entry of a symmetric matrix.
#[inline(always)]
pub(super) const fn packed(i: usize, j: usize) -> usize {
    let (row, column) = if i < j { (i, j) } else { (j, i) };
    row * (11 - row) / 2 + column
}

/// Stiffness and eigenstress of a voxel.
#[derive(Clone, Copy)]
pub(super) struct Material {
    pub(super) stiffness: Packed,
    pub(super) eigenstress: [f32; 6],
}

/// Stiffness of a void over the mortar's: equations stay regular.
pub(super) const VOID: f64 = 1e-6;

impl Material {
    /// A phase alone.
    pub(super) fn pure(phase: &Moduli) -> Self {
        let (c, s) = (stiffness(phase), eigenstress(phase));
        Self::new(&c, [s, s, s, 0.0, 0.0, 0.0])
    }

    /// Phases in layers across `normal`, each with its share.
    pub(super) fn laminate(phases: &[(Moduli, f64)], normal: &Vec3) -> Self {
        let n = across(normal);
        let (mut c, mut s, mut h, mut g, mut e) = ([[0.0; 6]; 6], [0.0; 6], [[0.0; 3]; 3], [[0.0; 6]; 3], [0.0; 3]);
        for (phase, f) in phases {
            let own = stiffness(phase);
            let b: [[f64; 6]; 3] = n.map(|n| [0, 1, 2, 3, 4, 5].map(|j| (0..6).map(|i| n[i] * own[i][j]).sum()));
            let inverse = inverse_acoustic(phase, normal);
            let ab = inverse.map(|row| [0, 1, 2, 3, 4, 5].map(|j| (0..3).map(|i| row[i] * b[i][j]).sum::<f64>()));
            let stress = eigenstress(phase);
            let traction = [normal.x, normal.y, normal.z].map(|n| n * stress);
            for i in 0..6 {
                (0..6).for_each(|j| c[i][j] += f * (own[i][j] - (0..3).map(|a| b[a][i] * ab[a][j]).sum::<f64>()));
                let own = if i < 3 { stress } else { 0.0 };
                s[i] += f * (own - (0..3).map(|a| ab[a][i] * traction[a]).sum::<f64>());
            }
            for a in 0..3 {
                (0..3).for_each(|b| h[a][b] += f * inverse[a][b]);
                (0..6).for_each(|j| g[a][j] += f * ab[a][j]);
                e[a] += f * (0..3).map(|b| inverse[a][b] * traction[b]).sum::<f64>();
            }
        }
        let h = inverse3(&h);
        for i in 0..6 {
            let gh = [0, 1, 2].map(|b| (0..3).map(|a| g[a][i] * h[a][b]).sum::<f64>());
            (0..6).for_each(|j| c[i][j] += (0..3).map(|b| gh[b] * g[b][j]).sum::<f64>());
            s[i] += (0..3).map(|b| gh[b] * e[b]).sum::<f64>();
        }
        Self::new(&c, s)
    }

    fn new(c: &Matrix6, s: [f64; 6]) -> Self {
        let mut stiffness = [0.0; 21];
        let upper = (0..6).flat_map(|i| (i..6).map(move |j| (i, j)));
        stiffness.iter_mut().zip(upper).for_each(|(to, (i, j))| *to = c[i][j] as f32);
        Self { stiffness, eigenstress: s.map(|s| s as f32) }
    }
}

/// Tractions across a plane from a stress: `t = n s`.
fn across(n: &Vec3) -> [[f64; 6]; 3] {
    [[n.x, 0.0, 0.0, 0.0, n.z, n.y], [0.0, n.y, 0.0, n.z, 0.0, n.x], [0.0, 0.0, n.z, n.y, n.x, 0.0]]
}

pub(super) fn stiffness(phase: &Moduli) -> Matrix6 {
    let shear = phase.shear();
    let lame = phase.bulk() - 2.0 / 3.0 * shear;
    let mut c = [[0.0; 6]; 6];
    for i in 0..3 {
        (0..3).for_each(|j| c[i][j] = lame);
        c[i][i] += 2.0 * shear;
        c[i + 3][i + 3] = shear;
    }
    c
}

fn eigenstress(phase: &Moduli) -> f64 {
    3.0 * phase.bulk() * phase.eigenstrain
}

fn inverse_acoustic(phase: &Moduli, n: &Vec3) -> [[f64; 3]; 3] {
    let shear = phase.shear();
    let along = 1.0 / (phase.bulk() + 4.0 / 3.0 * shear);
    let entry = |a: usize, b: usize| n[a] * n[b] * (along - 1.0 / shear) + if a == b { 1.0 / shear } else { 0.0 };
    [0, 1, 2].map(|a| [0, 1, 2].map(|b| entry(a, b)))
}

fn inverse3(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let minor = |a: usize, b: usize| {
        let (i, j, k, l) = ((a + 1) % 3, (a + 2) % 3, (b + 1) % 3, (b + 2) % 3);
        m[i][k] * m[j][l] - m[i][l] * m[j][k]
    };
    let determinant: f64 = (0..3).map(|b| m[0][b] * minor(0, b)).sum();
    [0, 1, 2].map(|a| [0, 1, 2].map(|b| minor(b, a) / determinant))
}
