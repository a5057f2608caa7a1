//! Tetrahedra outside of the specimen are left out.

use super::Tetrahedra;
use super::snap::OUTSIDE;
use rayon::prelude::*;

/// Leaves out what is outside, and the nodes that only it has; returns for every node left whether it had such cells: it
/// lies on the specimen's own surface.
pub(super) fn trim(mesh: &mut Tetrahedra) -> Vec<bool> {
    const LONE: u32 = u32::MAX;
    let mut number = vec![LONE; mesh.points.len()];
    let mut outside = vec![false; mesh.points.len()];
    for (cell, &grain) in mesh.cells.iter().zip(&mesh.grain) {
        for &node in cell {
            if grain == OUTSIDE { outside[node as usize] = true } else { number[node as usize] = 0 }
        }
    }
    let mut grains = mesh.grain.iter();
    mesh.cells.retain(|_| grains.next() != Some(&OUTSIDE));
    mesh.grain.retain(|grain| *grain != OUTSIDE);
    for (count, number) in (0..).zip(number.iter_mut().filter(|number| **number != LONE)) {
        *number = count;
    }
    let kept = |of: &mut std::slice::Iter<u32>| of.next() != Some(&LONE);
    let mut old = number.iter();
    mesh.points.retain(|_| kept(&mut old));
    let mut old = number.iter();
    outside.retain(|_| kept(&mut old));
    mesh.cells.par_iter_mut().flatten().for_each(|node| *node = number[*node as usize]);
    outside
}
