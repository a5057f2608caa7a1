//! Parts of a network that carry a flux: from one given end to the other, or around a period.

use super::Links;
use crate::grid::End;

/// Periods that the way to a voxel has crossed along each axis.
type Shift = [i16; 3];

/// A part of a network: whether it reaches the given ends, and the axes around whose period it leads.
#[derive(Clone, Copy, Default)]
struct Part {
    reaches: [bool; 2],
    around: [bool; 3],
}

impl Links {
    /// Removes the links of parts that carry no flux, and notes the axes along which another does. A pocket would have a potential
    /// without a scale.
    pub(crate) fn keep_carriers(&mut self, ends: [End; 3]) {
        let is_fixed = ends[2] == End::Fixed;
        let voxels: usize = self.counts.iter().product();
        let mut shifts: Vec<Option<Shift>> = vec![None; voxels];
        let (mut part, mut carries) = (Vec::new(), [false; 3]);
        for first in 0..voxels {
            if shifts[first].is_some() {
                continue;
            }
            let found = self.flood(first, &mut shifts, &mut part);
            let carried = if is_fixed { [false, false, found.reaches == [true; 2]] } else { found.around };
            (0..3).for_each(|axis| carries[axis] |= carried[axis]);
            if carried == [false; 3] {
                part.iter().for_each(|voxel| self.remove(*voxel));
            }
        }
        self.carries = carries;
    }

    /// Collects the part of a voxel.
    fn flood(&self, first: usize, shifts: &mut [Option<Shift>], part: &mut Vec<usize>) -> Part {
        let mut found = Part::default();
        part.clear();
        part.push(first);
        shifts[first] = Some([0; 3]);
        let mut next = 0;
        while let Some(&voxel) = part.get(next) {
            next += 1;
            let own = shifts[voxel].unwrap_or_default();
            for side in 0..6 {
                let (link, beside, period) = self.side(voxel, side);
                if self.across[side / 2][link] <= 0.0 {
                    continue;
                }
                let Some(beside) = beside else {
                    found.reaches[side % 2] = true;
                    continue;
                };
                let mut to = own;
                to[side / 2] = to[side / 2].wrapping_add(period);
                match shifts[beside] {
                    None => {
                        shifts[beside] = Some(to);
                        part.push(beside);
                    }
                    Some(known) => (0..3).for_each(|axis| found.around[axis] |= known[axis] != to[axis]),
                }
            }
        }
        found
    }

    /// The link on a side of a voxel, the voxel beyond it, and the periods that it crosses; sides 0 and 1 are below and above along x.
    fn side(&self, voxel: usize, side: usize) -> (usize, Option<usize>, i16) {
        let (axis, is_above) = (side / 2, side % 2 == 1);
        let step = [1, self.counts[0], self.counts[0] * self.counts[1]][axis];
        let (place, around) = (voxel / step % self.counts[axis], step * self.counts[axis]);
        let is_last = place + 1 == self.counts[axis];
        let is_open = axis == 2 && !self.wraps;
        match is_above {
            true if !is_last => (voxel + step, Some(voxel + step), 0),
            true if is_open => (voxel + step, None, 0),
            true if axis == 2 => (voxel + step, Some(voxel + step - around), 1),
            true => (voxel + step - around, Some(voxel + step - around), 1),
            false if place > 0 => (voxel, Some(voxel - step), 0),
            false if is_open => (voxel, None, 0),
            false => (voxel, Some(voxel + around - step), -1),
        }
    }

    /// Whether a link leads upwards from a voxel along any axis.
    pub(crate) fn above(&self, voxel: usize) -> bool {
        [1, 3, 5].into_iter().any(|side| self.across[side / 2][self.side(voxel, side).0] > 0.0)
    }

    fn remove(&mut self, voxel: usize) {
        for side in 0..6 {
            let (link, _, _) = self.side(voxel, side);
            self.across[side / 2][link] = 0.0;
        }
        // The layer above the last one repeats the first one in a period.
        let layer = self.counts[0] * self.counts[1];
        if self.wraps && voxel < layer {
            self.across[2][voxel + layer * self.counts[2]] = 0.0;
        }
        if self.wraps && voxel >= layer * (self.counts[2] - 1) {
            self.across[2][voxel - layer * (self.counts[2] - 1)] = 0.0;
        }
    }
}
