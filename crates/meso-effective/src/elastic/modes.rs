//! Strains, stresses and forces of a trilinear voxel by modes.
//!
//! In a voxel the displacement is a sum of products of the coordinates -1 to 1: `u = sum over m of u_m x^m`, with one bit of
//! `m` for each axis. Derivatives lower a bit, and the products are orthogonal. So strains have seven modes, the energy is a
//! sum over them with the weights 1, 1/3 and 1/9, and the integration is exact.
//!
//! All is written once, for a voxel and for voxels side by side. Functions take a mode as a constant: what a mode does not
//! have takes no instructions.

use super::laminate::{Packed, packed};
use std::ops::{Add, Mul, Sub};

/// A number of a voxel, or those of voxels side by side.
pub(super) trait Number: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// The number of every voxel.
    fn all(value: f64) -> Self;
}

impl Number for f64 {
    fn all(value: f64) -> Self {
        value
    }
}

/// Strain or stress of a voxel by modes: components in the order xx, yy, zz, yz, zx, xy.
pub(super) type Modes<T> = [[T; 8]; 6];
/// Displacements or forces of a voxel's nodes along x, y, z; a node's number has one bit for each axis. Or their modes.
pub(super) type Nodes<T> = [[T; 8]; 3];

/// Rows of strain to which a derivative along `axis` of component `of` adds.
pub(super) const ROW: [[usize; 3]; 3] = [[0, 5, 4], [5, 1, 3], [4, 3, 2]];
/// The two axes of a row.
const AXES: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [1, 2], [2, 0], [0, 1]];
/// Share of a mode in the energy.
const WEIGHTS: [f64; 8] = [1.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 9.0, 1.0 / 3.0, 1.0 / 9.0, 1.0 / 9.0, 0.0];
/// Sums begin with it, since compilers drop what is added to it.
const NOTHING: f64 = -0.0;

/// Calls a function with each mode of strains, and arguments.
macro_rules! each_mode {
    ($of:ident $arguments:tt) => {
        each_mode!(@ $of $arguments 0 1 2 3 4 5 6)
    };
    (@ $of:ident $arguments:tt $($mode:literal)*) => {
        $(each_mode!(# $of $arguments $mode);)*
    };
    (# $of:ident ($($argument:expr),*) $mode:literal) => {
        $of::<_, $mode>($($argument),*)
    };
}

/// Whether strains of a row have a mode.
#[inline(always)]
const fn has(row: usize, mode: usize) -> bool {
    let [b, c] = AXES[row];
    mode >> b & 1 == 0 || mode >> c & 1 == 0
}

/// Strain of a voxel by modes, of the modes of its displacements.
#[inline(always)]
pub(super) fn strain_of<T: Number>(of: &Nodes<T>, spacing: [f64; 3]) -> Modes<T> {
    let mut strain = [[T::all(0.0); 8]; 6];
    let over = spacing.map(|spacing| T::all(0.25 / spacing));
    each_mode!(derive(of, &over, &mut strain));
    strain
}

#[inline(always)]
fn derive<T: Number, const M: usize>(of: &Nodes<T>, over: &[T; 3], strain: &mut Modes<T>) {
    for row in 0..6 {
        let [b, c] = AXES[row];
        let mut sum = T::all(NOTHING);
        if M >> c & 1 == 0 {
            sum = sum + of[b][M | 1 << c] * over[c];
        }
        if b != c && M >> b & 1 == 0 {
            sum = sum + of[c][M | 1 << b] * over[b];
        }
        if has(row, M) {
            strain[row][M] = sum;
        }
    }
}

/// Stress by modes of a material with a stiffness.
#[inline(always)]
pub(super) fn stress_of<T: Number>(stiffness: &[T; 21], strain: &Modes<T>) -> Modes<T> {
    let mut stress = [[T::all(0.0); 8]; 6];
    each_mode!(laminate(stiffness, strain, &mut stress));
    stress
}

#[inline(always)]
fn laminate<T: Number, const M: usize>(stiffness: &[T; 21], strain: &Modes<T>, stress: &mut Modes<T>) {
    for i in 0..6 {
        let mut sum = T::all(NOTHING);
        for j in 0..6 {
            if has(j, M) {
                sum = sum + stiffness[packed(i, j)] * strain[j][M];
            }
        }
        if has(i, M) {
            stress[i][M] = sum;
        }
    }
}

/// Constants of a material whose stiffness is the same along all three axes: across, along less across, shear.
pub(super) type Cubic<T> = [T; 3];

/// The constants, if the stiffness has no others.
pub(super) fn cubic(stiffness: &Packed) -> Option<Cubic<f64>> {
    let [along, across, shear] = [(0, 0), (0, 1), (3, 3)].map(|(i, j)| stiffness[packed(i, j)]);
    let is_like = |(i, j): (usize, usize)| {
        let like = match (i == j, i < 3, j < 3) {
            (true, true, _) => along,
            (true, false, _) => shear,
            (false, true, true) => across,
            _ => 0.0,
        };
        stiffness[packed(i, j)] == like
    };
    let is_cubic = (0..36).all(|at| is_like((at / 6, at % 6)));
    is_cubic.then(|| [f64::from(across), f64::from(along) - f64::from(across), f64::from(shear)])
}

/// Stress by modes of a material with three constants.
#[inline(always)]
pub(super) fn stress_of_cubic<T: Number>(constants: &Cubic<T>, strain: &Modes<T>) -> Modes<T> {
    let mut stress = [[T::all(0.0); 8]; 6];
    each_mode!(by_three(constants, strain, &mut stress));
    stress
}

#[inline(always)]
fn by_three<T: Number, const M: usize>([across, more, shear]: &Cubic<T>, strain: &Modes<T>, stress: &mut Modes<T>) {
    let mut volume = T::all(NOTHING);
    for (row, strain) in strain.iter().enumerate() {
        if row < 3 && has(row, M) {
            volume = volume + strain[M];
        }
    }
    let all = *across * volume;
    for row in 0..3 {
        if has(row, M) {
            stress[row][M] = all + *more * strain[row][M];
        }
        if has(row + 3, M) {
            stress[row + 3][M] = *shear * strain[row + 3][M];
        }
    }
}

/// Modes of the forces that stresses by modes leave: the transpose of [`strain_of`], times the volume.
#[inline(always)]
pub(super) fn spread<T: Number>(stress: &Modes<T>, spacing: [f64; 3]) -> Nodes<T> {
    let mut forces = [[T::all(0.0); 8]; 3];
    let volume: f64 = spacing.iter().product();
    let over = spacing.map(|spacing| 0.25 * volume / spacing);
    each_mode!(force(stress, over, &mut forces));
    forces
}

/// Forces of the mode that all bits but those of `M` have.
#[inline(always)]
fn force<T: Number, const M: usize>(stress: &Modes<T>, over: [f64; 3], forces: &mut Nodes<T>) {
    let mode = 7 - M;
    for component in 0..3 {
        let mut sum = T::all(NOTHING);
        for axis in 0..3 {
            if mode >> axis & 1 == 1 {
                let lower = mode & !(1 << axis);
                sum = sum + stress[ROW[component][axis]][lower] * T::all(over[axis] * WEIGHTS[lower]);
            }
        }
        forces[component][mode] = sum;
    }
}

/// Energy of a voxel, twice, over its volume.
#[inline(always)]
pub(super) fn energy<T: Number>(strain: &Modes<T>, stress: &Modes<T>) -> T {
    let mut sum = T::all(NOTHING);
    each_mode!(add_energy(strain, stress, &mut sum));
    sum
}

#[inline(always)]
fn add_energy<T: Number, const M: usize>(strain: &Modes<T>, stress: &Modes<T>, sum: &mut T) {
    for row in 0..6 {
        if has(row, M) {
            *sum = *sum + strain[row][M] * stress[row][M] * T::all(WEIGHTS[M]);
        }
    }
}

/// Modes of displacements at nodes: sums over the nodes, with the sign that each product of coordinates has there.
pub(super) fn products(mut nodes: Nodes<f64>) -> Nodes<f64> {
    nodes.iter_mut().for_each(|values| (0..3).for_each(|axis| pairs(values, axis, |a, b| (a + b, b - a))));
    nodes
}

/// Forces at nodes of their modes: the transpose of [`products`].
pub(super) fn at_nodes(mut modes: Nodes<f64>) -> Nodes<f64> {
    modes.iter_mut().for_each(|values| (0..3).for_each(|axis| pairs(values, axis, |a, b| (a - b, a + b))));
    modes
}

fn pairs(values: &mut [f64; 8], axis: usize, of: impl Fn(f64, f64) -> (f64, f64)) {
    for low in (0..8).filter(|number| number >> axis & 1 == 0) {
        (values[low], values[low | 1 << axis]) = of(values[low], values[low | 1 << axis]);
    }
}
