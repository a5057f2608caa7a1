//! Distances of all voxels of a box to the nearest of some voxels.
//!
//! Squared distances are the lower envelope of parabolas, one axis after the other: Felzenszwalb and Huttenlocher, Theory of
//! Computing 8 (2012), 415.

/// A box of voxels, x fastest.
pub(super) struct Voxels {
    pub(super) counts: [usize; 3],
    /// Edges of a voxel, mm.
    pub(super) spacing_mm: [f64; 3],
}

impl Voxels {
    /// Distances between middles, mm; infinite where no voxel `is_in`.
    pub(super) fn distances(&self, is_in: impl Fn(usize) -> bool) -> Vec<f64> {
        let all = self.counts.iter().product();
        let mut squares: Vec<f64> = (0..all).map(|voxel| if is_in(voxel) { 0.0 } else { f64::INFINITY }).collect();
        let mut step = 1;
        for axis in 0..3 {
            let count = self.counts[axis];
            let mut line = SquaredRow::default();
            for first in (0..all).filter(|voxel| voxel / step % count == 0) {
                line.take((0..count).map(|k| squares[first + k * step]), self.spacing_mm[axis]);
                (0..count).for_each(|k| squares[first + k * step] = line.found[k]);
            }
            step *= count;
        }
        squares.into_iter().map(f64::sqrt).collect()
    }
}

/// A row of squared distances.
#[derive(Default)]
struct SquaredRow {
    given: Vec<f64>,
    found: Vec<f64>,
    /// Places of the parabolas in the envelope, and where each begins.
    lowest: Vec<(usize, f64)>,
}

impl SquaredRow {
    fn take(&mut self, given: impl Iterator<Item = f64>, spacing: f64) {
        self.given.clear();
        self.given.extend(given);
        self.lowest.clear();
        let at = |k: usize| k as f64 * spacing;
        for (k, own) in self.given.iter().enumerate().filter(|(_, own)| own.is_finite()) {
            let mut from = f64::NEG_INFINITY;
            while let Some(&(last, begins)) = self.lowest.last() {
                let (x, y) = (at(k), at(last));
                from = ((own + x * x) - (self.given[last] + y * y)) / (2.0 * (x - y));
                if from > begins {
                    break;
                }
                self.lowest.pop();
                from = f64::NEG_INFINITY;
            }
            self.lowest.push((k, from));
        }
        self.found.clear();
        let mut part = 0;
        for k in 0..self.given.len() {
            while part + 1 < self.lowest.len() && self.lowest[part + 1].1 < at(k) {
                part += 1;
            }
            let square = |&(place, _): &(usize, f64)| (at(k) - at(place)).powi(2) + self.given[place];
            self.found.push(self.lowest.get(part).map_or(f64::INFINITY, square));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_to_the_nearest_voxel() {
        let voxels = Voxels { counts: [7, 5, 6], spacing_mm: [0.5, 1.0, 2.0] };
        let is_in = |voxel: usize| voxel * 7919 % 61 == 3;
        let at = |voxel: usize| [voxel % 7, voxel / 7 % 5, voxel / 35].map(|x| x as f64);
        let chosen: Vec<usize> = (0..210).filter(|voxel| is_in(*voxel)).collect();
        assert_eq!(chosen.len(), 3);
        for (voxel, found) in voxels.distances(is_in).into_iter().enumerate() {
            let square = |other: &usize| {
                (0..3).map(|a| ((at(voxel)[a] - at(*other)[a]) * voxels.spacing_mm[a]).powi(2)).sum::<f64>()
            };
            let right = chosen.iter().map(square).fold(f64::INFINITY, f64::min).sqrt();
            assert!((found - right).abs() < 1e-12, "{voxel}: {found} {right}");
        }
        assert!(voxels.distances(|_| false).iter().all(|found| found.is_infinite()));
    }
}
