//! Connected grains of a label volume: voxels of one label, or of one phase, that share faces.

use crate::import::volume::Volume;
use std::collections::{BTreeMap, BTreeSet};

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
    pub fn values(&self, labels: &[i64]) -> Vec<u32> {
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
        let roots = roots(volume.counts, |voxel| values[usize::from(volume.of[voxel])]);
        let mut parts = Self { counts: volume.counts, of: roots, grains: Vec::new(), dropped: [0; 2] };
        parts.number(volume, least);
        parts
    }

    /// Pairs of grains with voxels that share a face, by their numbers from 1.
    pub fn touching_pairs(&self) -> Vec<(u32, u32)> {
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
        pairs
    }

    /// For every grain the number, from 1, of the one that surrounds it: its voxels have faces with that one alone, and none
    /// with the mortar or a wall.
    pub fn surrounded(&self) -> Vec<Option<u32>> {
        // The only neighbour so far: none is 0, several or the mortar are NONE.
        let mut around = vec![0_u32; self.grains.len() + 1];
        let mut meet = |grain: u32, other: u32| {
            let own = &mut around[grain as usize];
            *own = if other != 0 && (*own == 0 || *own == other) { other } else { NONE };
        };
        for (axis, step) in self.steps().into_iter().enumerate() {
            for (voxel, (&a, &b)) in self.of.iter().zip(&self.of[step..]).enumerate() {
                if a != b && self.at(voxel)[axis] + 1 < self.counts[axis] {
                    meet(a, b);
                    meet(b, a);
                }
            }
        }
        let outer = |(grain, other): (&LabelledGrain, &u32)| {
            let is_at_a_wall = (0..3).any(|axis| grain.from[axis] == 0 || grain.to[axis] == self.counts[axis]);
            (!is_at_a_wall && *other != NONE && *other > 0).then_some(*other)
        };
        self.grains.iter().zip(&around[1..]).map(outer).collect()
    }

    /// Gives every grain its hollows, mortar that it encloses alone, in parts whose voxels share faces: the number of grains
    /// that had some, and the voxels of these together.
    pub fn fill_hollows(&mut self) -> [usize; 2] {
        let roots = roots(self.counts, |voxel| u32::from(self.of[voxel] == 0));
        let [nx, ny, nz] = self.counts;
        let mut is_open = vec![false; roots.len()];
        for (row, voxels) in roots.chunks_exact(nx).enumerate() {
            let (y, z) = (row % ny, row / ny);
            let is_on_a_face = y == 0 || y + 1 == ny || z == 0 || z + 1 == nz;
            let open = voxels.iter().step_by(if is_on_a_face { 1 } else { (nx - 1).max(1) });
            open.filter(|root| **root != NONE).for_each(|root| is_open[*root as usize] = true);
        }
        let mortar = (0..).zip(&roots).filter(|(_, root)| **root != NONE && !is_open[**root as usize]);
        let mut enclosed: BTreeMap<u32, (Vec<usize>, BTreeSet<u32>)> = BTreeMap::new();
        for (voxel, root) in mortar {
            let (voxels, around) = enclosed.entry(*root).or_default();
            voxels.push(voxel);
            let next = self.steps().into_iter().flat_map(|step| [voxel - step, voxel + step]);
            around.extend(next.map(|next| self.of[next]).filter(|grain| *grain > 0));
        }
        let (mut filled, mut count) = (BTreeSet::new(), 0);
        for (voxels, around) in enclosed.into_values().filter(|(_, around)| around.len() == 1) {
            for grain in around {
                voxels.iter().for_each(|voxel| self.of[*voxel] = grain);
                self.grains[grain as usize - 1].voxels += voxels.len();
                filled.insert(grain);
            }
            count += voxels.len();
        }
        [filled.len(), count]
    }

    /// Distances of a voxel's next ones along x, y, z.
    pub(super) fn steps(&self) -> [usize; 3] {
        [1, self.counts[0], self.counts[0] * self.counts[1]]
    }

    /// Place of a voxel along x, y, z.
    pub fn at(&self, voxel: usize) -> [usize; 3] {
        let [nx, ny, _] = self.counts;
        [voxel % nx, voxel / nx % ny, voxel / (nx * ny)]
    }

    /// Replaces roots by the numbers of the grains.
    fn number(&mut self, volume: &Volume<u16>, least: usize) {
        let mut sizes = vec![0_u32; self.of.len()];
        self.of.iter().filter(|root| **root != NONE).for_each(|root| sizes[*root as usize] += 1);
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
                *voxel = if *voxel == NONE { 0 } else { numbers[*voxel as usize] };
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

/// Root of a voxel of no part.
const NONE: u32 = u32::MAX;

/// For every voxel the first one of its part, whose voxels share faces and a value; those of the value 0 are in none.
fn roots([nx, ny, nz]: [usize; 3], value: impl Fn(usize) -> u32) -> Vec<u32> {
    let count = nx * ny * nz;
    let mut lower: Vec<u32> = Vec::with_capacity(count);
    for voxel in 0..count {
        let own = value(voxel);
        lower.push(if own == 0 { NONE } else { voxel as u32 });
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
        if lower[voxel] != NONE {
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
        assert_eq!((all.grains.len(), all.touching_pairs().len()), (3, 1));
        assert_eq!(all.surrounded(), [None; 3]);
    }

    #[test]
    fn mortar_that_one_grain_encloses_is_its_hollow() {
        // Five cubes of 5 voxels in a row; each is one grain, or two, around its inner 3 x 3 x 3 voxels.
        let label = |voxel: usize| {
            let [x, y, z] = [voxel % 25, voxel / 25 % 5, voxel / 125];
            let is_inner = |t: usize| (1..4).contains(&t);
            match (x / 5, is_inner(x % 5) && is_inner(y) && is_inner(z)) {
                // The second one is open at a face, the fourth one is two grains, the last one has a wall within.
                (1, true) => 0,
                (1, false) if z == 4 && y == 2 => 0,
                (3, false) if z < 2 => 9,
                (4, true) if x % 5 == 2 => 5,
                (_, true) => 0,
                (cube, false) => 1 + cube as i64,
            }
        };
        let volume = Volume::new([25, 5, 5], None, (0..625).map(label)).unwrap();
        let mut grains = LabelledGrains::of(&volume, &Roles { mortar: vec![0], aggregate: Vec::new() }, 1);
        let before = grains.of.iter().filter(|grain| **grain == 0).count();
        assert_eq!((grains.grains.len(), grains.fill_hollows()), (6, [3, 27 + 27 + 18]));
        let voxels: Vec<usize> = grains.grains.iter().map(|grain| grain.voxels).collect();
        assert_eq!([voxels[0], voxels[2], voxels[4]], [125; 3]);
        assert_eq!(before - grains.of.iter().filter(|grain| **grain == 0).count(), 27 + 27 + 18);
        assert_eq!(cut(&[5, 0, 7, 7, 0, 5, 7, 0, 0, 5, 9, 0, 0, 0, 9, 0], 1).fill_hollows(), [0, 0]);
    }
}
