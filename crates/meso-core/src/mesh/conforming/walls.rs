//! The faces of a box as triangles of a grid, opposite faces alike: moved along its axis, one lies node on node on the other.

use super::facets::Triangles;
use crate::math::{Aabb, Vec3};
use std::collections::BTreeMap;

/// The faces of `domain` with edges of about `size` mm, triangles counter-clockwise from outside.
pub(super) fn walls(domain: &Aabb, size: f64) -> Triangles {
    let counts = [0, 1, 2].map(|i| (domain.size()[i] / size).round().max(1.0) as usize);
    let mut walls = Triangles::default();
    let mut numbers = BTreeMap::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for upper in [false, true] {
            for (i, j) in (0..counts[u]).flat_map(|i| (0..counts[v]).map(move |j| (i, j))) {
                let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(di, dj)| {
                    let mut at = [0; 3];
                    (at[axis], at[u], at[v]) = (if upper { counts[axis] } else { 0 }, i + di, j + dj);
                    *numbers.entry(at).or_insert_with(|| {
                        walls.points.push(position(domain, counts, at));
                        walls.points.len() as u32 - 1
                    })
                });
                walls.triangles.extend(if upper { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
            }
        }
    }
    walls
}

fn position(domain: &Aabb, counts: [usize; 3], at: [usize; 3]) -> Vec3 {
    Vec3::from_fn(|axis, _| {
        if at[axis] == counts[axis] {
            domain.max[axis]
        } else {
            domain.min[axis] + domain.size()[axis] * at[axis] as f64 / counts[axis] as f64
        }
    })
}
