//! Strains, stresses and forces of a trilinear voxel by modes.
//!
//! In a voxel the displacement is a sum of products of the coordinates -1 to 1: `u = sum over m of u_m x^m`, with one bit of
//! `m` for each axis. Derivatives lower a bit, and the products are orthogonal. So strains have seven modes, the energy is a
//! sum over them with the weights 1, 1/3 and 1/9, and the integration is exact.

use super::laminate::Material;

/// Strain or stress of a voxel by modes: components in the order xx, yy, zz, yz, zx, xy.
pub(super) type Modes = [[f64; 8]; 6];
/// Displacements or forces of a voxel's nodes along x, y, z; a node's number has one bit for each axis.
pub(super) type Nodes = [[f64; 8]; 3];

/// Rows of strain to which a derivative along `axis` of component `of` adds.
pub(super) const ROW: [[usize; 3]; 3] = [[0, 5, 4], [5, 1, 3], [4, 3, 2]];
/// Share of a mode in the energy.
pub(super) const WEIGHTS: [f64; 8] = [1.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 9.0, 1.0 / 3.0, 1.0 / 9.0, 1.0 / 9.0, 0.0];

/// Strain of a voxel by modes, of the displacements at its nodes.
#[inline]
pub(super) fn strain_of(nodes: &Nodes, spacing: [f64; 3]) -> Modes {
    let mut strain = [[0.0; 8]; 6];
    for (component, values) in nodes.iter().enumerate() {
        let modes = products(*values);
        for axis in 0..3 {
            let over = 0.25 / spacing[axis];
            let row = &mut strain[ROW[component][axis]];
            lower(axis).for_each(|mode| row[mode] += over * modes[mode | 1 << axis]);
        }
    }
    strain
}

/// Stress of a material by modes.
#[inline]
pub(super) fn stress_of(material: &Material, strain: &Modes) -> Modes {
    let mut stress = [[0.0; 8]; 6];
    let mut entries = material.stiffness.iter().map(|c| f64::from(*c));
    for i in 0..6 {
        for j in i..6 {
            let c = entries.next().unwrap_or_default();
            (0..8).for_each(|mode| stress[i][mode] += c * strain[j][mode]);
            if i != j {
                (0..8).for_each(|mode| stress[j][mode] += c * strain[i][mode]);
            }
        }
    }
    stress
}

/// Forces of the nodes of a voxel that stresses by modes leave: the transpose of [`strain_of`], times the volume.
#[inline]
pub(super) fn spread(stress: &Modes, spacing: [f64; 3]) -> Nodes {
    let volume: f64 = spacing.iter().product();
    [0, 1, 2].map(|component| {
        let mut modes = [0.0; 8];
        for axis in 0..3 {
            let over = 0.25 * volume / spacing[axis];
            let row = &stress[ROW[component][axis]];
            lower(axis).for_each(|mode| modes[mode | 1 << axis] += over * WEIGHTS[mode] * row[mode]);
        }
        transposed_products(modes)
    })
}

/// Modes without a bit for `axis`.
fn lower(axis: usize) -> impl Iterator<Item = usize> {
    (0..8).filter(move |mode| mode >> axis & 1 == 0)
}

/// Sums over the nodes, with the sign that each product of coordinates has there.
fn products(values: [f64; 8]) -> [f64; 8] {
    pairs(values, |a, b| (a + b, b - a))
}

/// The transpose of [`products`].
fn transposed_products(values: [f64; 8]) -> [f64; 8] {
    pairs(values, |a, b| (a - b, a + b))
}

#[inline]
fn pairs(mut values: [f64; 8], of: impl Fn(f64, f64) -> (f64, f64)) -> [f64; 8] {
    for bit in [1, 2, 4] {
        for low in (0..8).filter(|number| number & bit == 0) {
            (values[low], values[low | bit]) = of(values[low], values[low | bit]);
        }
    }
    values
}
