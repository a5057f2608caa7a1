//! Fluxes through coupled links: those that the differences of potential along other links of the voxel drive.

use super::network::Network;
use super::stencil::Real;
use crate::links::{Corners, Links};
use std::ops::Range;

impl Links {
    /// Number of coupled voxels.
    pub(crate) fn coupled(&self) -> usize {
        self.corners.as_ref().map_or(0, |corners| corners.voxels.len())
    }

    /// Coupled voxels with links to layer `k`: those of the layers below, at and above it.
    fn coupled_near(&self, k: usize) -> [Range<usize>; 3] {
        let (nz, wraps) = (self.counts[2], self.wraps);
        let below = if k > 0 { Some(k - 1) } else { wraps.then_some(nz - 1) };
        let above = if k + 1 < nz { Some(k + 1) } else { wraps.then_some(0) };
        // A period of two layers has one neighbour on both sides.
        let below = below.filter(|below| *below != k);
        let above = above.filter(|above| *above != k && Some(*above) != below);
        [below, Some(k), above].map(|k| k.map_or(0..0, |k| self.coupled_in(k)))
    }

    /// Coupled voxels of layer `k`.
    pub(crate) fn coupled_in(&self, k: usize) -> Range<usize> {
        self.corners.as_ref().map_or(0..0, |corners| corners.starts[k]..corners.starts[k + 1])
    }

    /// Whether coupled links end in layer `k`.
    pub(super) fn is_coupled(&self, k: usize) -> bool {
        self.coupled_near(k).iter().any(|voxels| !voxels.is_empty())
    }

    /// Calls `add` with the coupled fluxes out of voxels of layer `k`, each with its place in the layer.
    pub(super) fn add_coupled<T: Real>(&self, k: usize, u: &[T], mut add: impl FnMut(usize, T)) {
        let layer = k * self.layer_len()..(k + 1) * self.layer_len();
        for number in self.coupled_near(k).into_iter().flatten() {
            self.coupled_out(number, u, [T::default(); 3], |voxel, flux| {
                if layer.contains(&voxel) {
                    add(voxel - layer.start, flux);
                }
            });
        }
    }

    /// Calls `add` with the voxels at the ends of the links of coupled voxel `number`, and the coupled flux out of each.
    pub(crate) fn coupled_out<T: Real>(&self, number: usize, u: &[T], given: [T; 3], mut add: impl FnMut(usize, T)) {
        let [_, fluxes] = self.coupled_fluxes(number, u, given);
        for (side, voxel, beside) in self.coupled_ends(number) {
            let flux = fluxes[side];
            let [out, into] = if side % 2 == 0 { [voxel, beside] } else { [beside, voxel] };
            add(out, flux);
            add(into, T::default() - flux);
        }
    }

    /// Sides of coupled voxel `number` that have a link, with the voxel and its neighbour.
    pub(crate) fn coupled_ends(&self, number: usize) -> impl Iterator<Item = (usize, usize, usize)> {
        let voxel = self.corners.as_ref().map(|corners| corners.voxels[number] as usize);
        let ends = voxel.into_iter().flat_map(|voxel| self.beside(voxel).map(|beside| (voxel, beside)));
        ends.enumerate().filter_map(|(side, (voxel, beside))| Some((side, voxel, beside?)))
    }

    /// Differences of potential along the links of coupled voxel `number`, `given` ones of each axis included, and the coupled
    /// fluxes through them.
    pub(crate) fn coupled_fluxes<T: Real>(&self, number: usize, u: &[T], given: [T; 3]) -> [[T; 6]; 2] {
        let Some(Corners { voxels, pairs, .. }) = &self.corners else { return [[T::default(); 6]; 2] };
        let voxel = voxels[number] as usize;
        let (own, beside) = (u[voxel], self.beside(voxel));
        let differences = std::array::from_fn(|side| {
            let other = beside[side].map_or(T::default(), |beside| u[beside]);
            given[side / 2] + if side % 2 == 0 { own - other } else { other - own }
        });
        [differences, fluxes(&pairs[number], differences)]
    }

    /// Voxels below and above a voxel along each axis; none beyond walls across z.
    fn beside(&self, number: usize) -> [Option<usize>; 6] {
        let steps = [1, self.counts[0], self.counts[0] * self.counts[1]];
        std::array::from_fn(|side| {
            let (axis, is_above) = (side / 2, side % 2 == 1);
            let (step, count) = (steps[axis], self.counts[axis]);
            let place = number / step % count;
            let is_last = if is_above { place + 1 == count } else { place == 0 };
            match (is_above, is_last) {
                (_, true) if axis == 2 && !self.wraps => None,
                (true, false) => Some(number + step),
                (true, true) => Some(number + step - step * count),
                (false, false) => Some(number - step),
                (false, true) => Some(number + step * count - step),
            }
        })
    }
}

/// Fluxes through the links below and above along each axis, by the differences along the other axes.
#[inline(always)]
fn fluxes<T: Real>(pairs: &[f32; 12], [a, b, c, d, e, f]: [T; 6]) -> [T; 6] {
    let p = pairs.map(T::from);
    [
        (p[0] * c + p[1] * d) + (p[4] * e + p[5] * f),
        (p[2] * c + p[3] * d) + (p[6] * e + p[7] * f),
        (p[0] * a + p[2] * b) + (p[8] * e + p[9] * f),
        (p[1] * a + p[3] * b) + (p[10] * e + p[11] * f),
        (p[4] * a + p[6] * b) + (p[8] * c + p[10] * d),
        (p[5] * a + p[7] * b) + (p[9] * c + p[11] * d),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The case: with two layers, the coupled fluxes of the other one counted twice.
    #[test]
    fn layers_of_any_period_add_each_coupled_flux_once() {
        for nz in [1, 2, 3, 4] {
            let counts = [3, 2, nz];
            let voxels: Vec<u32> = (0..6 * nz as u32).collect();
            let pairs = voxels.iter().map(|&voxel| std::array::from_fn(|i| (voxel as usize * 12 + i) as f32)).collect();
            let starts = (0..=nz).map(|k| 6 * k).collect();
            let corners = Some(Corners { starts, voxels, pairs });
            let links = Links { corners, ..Links::of(counts, true, Default::default()) };
            let u: Vec<f64> = (0..6 * nz).map(|voxel| ((voxel * voxel) % 7) as f64).collect();
            let (mut whole, mut by_layer) = (vec![0.0; u.len()], vec![0.0; u.len()]);
            (0..links.coupled())
                .for_each(|number| links.coupled_out(number, &u, [0.0; 3], |at, flux| whole[at] += flux));
            (0..nz).for_each(|k| links.add_coupled(k, &u, |at, flux| by_layer[6 * k + at] += flux));
            // Whole numbers: no sum rounds.
            assert_eq!(whole, by_layer, "{nz} layers");
        }
    }
}
