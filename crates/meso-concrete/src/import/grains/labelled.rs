//! Connected grains of a label volume: voxels of one label, or of one phase, that share faces.

use crate::import::volume::Volume;

/// Which labels are grains.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Roles {
    /// Labels of the mortar. All others are grains where `aggregate` is empty.
    pub mortar: Vec<i64>,
    /// Labels that are the aggregates' phase together, such as core and ITZ; all others are then mortar.
    pub aggregate: Vec<i64>,
}

/// One connected grain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LabelledGrain {
    /// Its label; the first one where several are a phase.
    pub label: i64,
    /// How many voxels it has.
    pub voxels: usize,
    /// First voxel along x, y, z.
    pub from: [usize; 3],
    /// One past the last voxel along x, y, z.
    pub to: [usize; 3],
}

/// A volume cut into grains.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LabelledGrains {
    /// Voxels along x, y, z.
    pub counts: [usize; 3],
    /// Number of the grain of every voxel, from 1; 0 in the mortar, dropped grains included.
    pub of: Vec<u32>,
    /// The grains by label, then from the largest.
    pub grains: Vec<LabelledGrain>,
    /// How many were dropped as too small, and their voxels together.
    pub dropped: [usize; 2],
}

impl Roles {
    /// The value of each label of a volume that voxels of one grain share; 0 for the mortar.
    fn values(&self, labels: &[i64]) -> Vec<u32> {
        let own = (1..).zip(labels);
        let value = |(number, label): (u32, &i64)| match self.aggregate.as_slice() {
            [] if self.mortar.contains(label) => 0,
            [] => number,
            phase if phase.contains(label) => 1,
            _ => 0,
        };
        own.map(value).collect()
    }
}

impl LabelledGrains {
    /// Cuts a volume into grains of `least` voxels or more.
    pub fn of(volume: &Volume<u16>, roles: &Roles, least: usize) -> Self {
        let values = roles.values(&volume.labels);
        let roots = roots(volume, &values);
        let mut parts = Self { counts: volume.counts, of: roots, grains: Vec::new(), dropped: [0; 2] };
        parts.number(volume, least);
        parts
    }

    /// The number of pairs of grains with voxels that share a face.
    pub fn touching_pairs(&self) -> usize {
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for (axis, step) in self.steps().into_iter().enumerate() {
            for (voxel, (&a, &b)) in self.of.iter().zip(&self.of[step..]).enumerate() {
                let is_new = a != b && a > 0 && b > 0 && pairs.last() != Some(&(a.min(b), a.max(b)));
                if is_new && self.at(voxel)[axis] + 1 < self.counts[axis] {
                    pairs.push((a.min(b), a.max(b)));
                }
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        pairs.len()
    }

    /// Distances of a voxel's next ones along x, y, z.
    pub(super) fn steps(&self) -> [usize; 3] {
        [1, self.counts[0], self.counts[0] * self.counts[1]]
    }

    /// Place of a voxel along x, y, z.
    pub(super) fn at(&self, voxel: usize) -> [usize; 3] {
        let [nx, ny, _] = self.counts;
        [voxel % nx, voxel / nx % ny, voxel / (nx * ny)]
    }

    /// Replaces roots by the numbers of the grains.
    fn number(&mut self, volume: &Volume<u16>, least: usize) {
        let mut sizes = vec![0_u32; self.of.len()];
        self.of.iter().filter(|root| **root != MORTAR).for_each(|root| sizes[*root as usize] += 1);
        let mut kept = Vec::new();
        for (root, size) in (0..).zip(&sizes).filter(|(_, size)| **size > 0) {
            if (*size as usize) < least {
                self.dropped = [self.dropped[0] + 1, self.dropped[1] + *size as usize];
            } else {
                kept.push((volume.labels[usize::from(volume.of[root as usize])], *size as usize, root));
            }
        }
        kept.sort_unstable_by_key(|&(label, size, root)| (label, usize::MAX - size, root));
        let mut numbers = sizes;
        numbers.fill(0);
        (1..).zip(&kept).for_each(|(number, &(_, _, root))| numbers[root as usize] = number);
        let part = |&(label, voxels, _)| LabelledGrain { label, voxels, from: [usize::MAX; 3], to: [0; 3] };
        self.grains = kept.iter().map(part).collect();
        let [nx, ny, _] = self.counts;
        for (row, voxels) in self.of.chunks_exact_mut(nx).enumerate() {
            for (x, voxel) in voxels.iter_mut().enumerate() {
                *voxel = if *voxel == MORTAR { 0 } else { numbers[*voxel as usize] };
                if *voxel > 0 {
                    self.grains[*voxel as usize - 1].take([x, row % ny, row / ny]);
                }
            }
        }
    }
}

impl LabelledGrain {
    fn take(&mut self, at: [usize; 3]) {
        for (axis, at) in at.into_iter().enumerate() {
            self.from[axis] = self.from[axis].min(at);
            self.to[axis] = self.to[axis].max(at + 1);
        }
    }
}

/// Root of a voxel that is no grain's.
const MORTAR: u32 = u32::MAX;

/// For every voxel the first voxel of its grain.
fn roots(volume: &Volume<u16>, values: &[u32]) -> Vec<u32> {
    let [nx, ny, _] = volume.counts;
    let value = |voxel: usize| values[usize::from(volume.of[voxel])];
    let mut lower: Vec<u32> = Vec::with_capacity(volume.of.len());
    for voxel in 0..volume.of.len() {
        let own = value(voxel);
        lower.push(if own == 0 { MORTAR } else { voxel as u32 });
        let (x, y) = (voxel % nx, voxel / nx % ny);
        let before = [(x > 0, 1), (y > 0, nx), (voxel >= nx * ny, nx * ny)];
        for (_, step) in before.into_iter().filter(|(is_there, _)| own > 0 && *is_there) {
            if value(voxel - step) == own {
                join(&mut lower, voxel as u32, (voxel - step) as u32);
            }
        }
    }
    // Roots come first, so one pass flattens the trees.
    for voxel in 0..lower.len() {
        if lower[voxel] != MORTAR {
            lower[voxel] = lower[lower[voxel] as usize];
        }
    }
    lower
}

fn join(lower: &mut [u32], a: u32, b: u32) {
    let [a, b] = [a, b].map(|voxel| root(lower, voxel));
    lower[a.max(b) as usize] = a.min(b);
}

fn root(lower: &mut [u32], mut voxel: u32) -> u32 {
    while lower[voxel as usize] != voxel {
        // Path halving, so that the next walk is shorter.
        lower[voxel as usize] = lower[lower[voxel as usize] as usize];
        voxel = lower[voxel as usize];
    }
    voxel
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(labels: &[i64], least: usize) -> LabelledGrains {
        let volume = Volume::new([4, 2, 2], None, labels.iter().copied()).unwrap();
        LabelledGrains::of(&volume, &Roles { mortar: vec![0], aggregate: Vec::new() }, least)
    }

    #[test]
    fn voxels_that_share_an_edge_alone_are_two_grains() {
        let grains = cut(&[5, 0, 7, 7, 0, 5, 7, 0, 0, 5, 9, 0, 0, 0, 9, 0], 1);
        assert_eq!(grains.of, [1, 0, 4, 4, 0, 2, 4, 0, 0, 3, 5, 0, 0, 0, 5, 0]);
        assert_eq!(grains.grains.iter().map(|grain| grain.label).collect::<Vec<_>>(), [5, 5, 5, 7, 9]);
    }

    #[test]
    fn grains_below_the_least_size_are_mortar() {
        let grains = cut(&[5, 0, 7, 7, 5, 0, 7, 0, 0, 0, 9, 0, 0, 0, 9, 0], 3);
        assert_eq!((grains.grains.len(), grains.dropped), (1, [2, 4]));
        assert_eq!((grains.grains[0].label, grains.grains[0].from, grains.grains[0].to), (7, [2, 0, 0], [4, 2, 1]));
        let all = cut(&[5, 0, 7, 7, 5, 0, 7, 0, 0, 0, 9, 0, 0, 0, 9, 0], 1);
        assert_eq!((all.grains.len(), all.touching_pairs()), (3, 1));
    }
}
