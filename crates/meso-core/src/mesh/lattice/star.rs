//! The tetrahedra around one node: what a move of the node does to them.

use super::Tetrahedra;
use super::places::Places;
use crate::math::Vec3;

/// For every node the tetrahedra around it, as indices.
pub(in crate::mesh) struct Stars {
    start: Vec<u32>,
    end: Vec<u32>,
    cells: Vec<u32>,
}

impl Stars {
    /// The stars of the nodes that `wanted` marks; the others' are empty.
    pub(in crate::mesh) fn new(mesh: &[[u32; 4]], wanted: &[bool]) -> Self {
        let mut start = vec![0_u32; wanted.len() + 1];
        let corners = || mesh.iter().flatten().filter(|&&node| wanted[node as usize]);
        corners().for_each(|&node| start[node as usize + 1] += 1);
        (1..start.len()).for_each(|i| start[i] += start[i - 1]);
        let mut next = start[..wanted.len()].to_vec();
        let mut cells = vec![0; corners().count()];
        for (index, cell) in mesh.iter().enumerate() {
            for &node in cell.iter().filter(|&&node| wanted[node as usize]) {
                cells[next[node as usize] as usize] = index as u32;
                next[node as usize] += 1;
            }
        }
        start.truncate(wanted.len());
        Self { start, end: next, cells }
    }

    pub(in crate::mesh) fn cells(&self, node: u32) -> &[u32] {
        &self.cells[self.start[node as usize] as usize..self.end[node as usize] as usize]
    }

    /// Takes a tetrahedron out of the stars of its nodes.
    pub(super) fn leave_out(&mut self, cell: u32, nodes: &[u32; 4]) {
        for &node in nodes {
            let (start, end) = (self.start[node as usize] as usize, self.end[node as usize] as usize);
            if let Some(at) = self.cells[start..end].iter().position(|&other| other == cell) {
                self.cells.copy_within(start + at + 1..end, start + at);
                self.end[node as usize] -= 1;
            }
        }
    }

    /// Gives what `node` has to `into`, too, and leaves it nothing.
    pub(super) fn join(&mut self, node: u32, into: u32) {
        let all = [self.cells(node), self.cells(into)].concat();
        self.start[into as usize] = self.cells.len() as u32;
        self.cells.extend(all);
        self.end[into as usize] = self.cells.len() as u32;
        self.end[node as usize] = self.start[node as usize];
    }

    /// Cells `gone` give way to `new` ones in the stars of their nodes.
    pub(super) fn exchange(&mut self, gone: &[(u32, [u32; 4])], new: &[(u32, [u32; 4])]) {
        let mut nodes: Vec<u32> = gone.iter().chain(new).flat_map(|(_, nodes)| *nodes).collect();
        nodes.sort_unstable();
        nodes.dedup();
        // The others have no stars here.
        nodes.retain(|&node| !self.cells(node).is_empty());
        for node in nodes {
            let stays = |cell: &&u32| gone.iter().all(|(other, _)| other != *cell);
            let mut cells: Vec<u32> = self.cells(node).iter().filter(stays).copied().collect();
            cells.extend(new.iter().filter(|(_, nodes)| nodes.contains(&node)).map(|(cell, _)| cell));
            self.start[node as usize] = self.cells.len() as u32;
            self.cells.extend(cells);
            self.end[node as usize] = self.cells.len() as u32;
        }
    }
}

/// The star of one node: its tetrahedra as the opposite faces (a, b, c), with positive volume over the node.
pub(in crate::mesh) struct Star {
    pub(super) centre: Vec3,
    faces: Vec<([Vec3; 3], u32)>,
}

impl Star {
    pub(super) fn new(mesh: &Tetrahedra, stars: &Stars, node: u32, places: &Places) -> Self {
        let cells = stars.cells(node).iter();
        Self::of_cells(node, cells.map(|&cell| (mesh.cells[cell as usize], mesh.grain[cell as usize])), |n| {
            places.get(n)
        })
    }

    /// The star of `node` from its cells and their labels.
    pub(in crate::mesh) fn of_cells(
        node: u32,
        cells: impl Iterator<Item = ([u32; 4], u32)>,
        place: impl Fn(u32) -> Vec3,
    ) -> Self {
        let face = |(nodes, label): ([u32; 4], u32)| {
            let at = nodes.iter().position(|&n| n == node).expect("a star's cells hold its node");
            // Even permutations that bring the node to the front.
            let [i, j, k] = [[1, 2, 3], [0, 3, 2], [3, 0, 1], [2, 1, 0]][at];
            ([nodes[i], nodes[j], nodes[k]].map(&place), label)
        };
        Self { centre: place(node), faces: cells.map(face).collect() }
    }

    /// With the cells of an image of the node, which is `way` from it.
    pub(super) fn with_image(mut self, image: Self, way: &Vec3) -> Self {
        self.faces.extend(image.faces.into_iter().map(|(face, label)| (face.map(|p| p - way), label)));
        self
    }

    /// The node's own place.
    pub(in crate::mesh) fn centre(&self) -> Vec3 {
        self.centre
    }

    /// [`sharpness`] of the sharpest tetrahedron with the node at `x`. The search ends at the first above `limit`.
    pub(in crate::mesh) fn worst(&self, x: &Vec3, limit: f64) -> f64 {
        let mut worst: f64 = -1.0;
        for ([a, b, c], _) in &self.faces {
            worst = worst.max(sharpness([*x, *a, *b, *c]));
            if worst > limit {
                break;
            }
        }
        worst
    }

    /// [`worst`](Self::worst) of the node's own place; the sharpest tetrahedron comes first from now on, where searches
    /// with a limit end soonest.
    pub(in crate::mesh) fn sharpest_first(&mut self) -> f64 {
        let x = self.centre;
        let (mut worst, mut at) = (-1.0, 0);
        for (i, ([a, b, c], _)) in self.faces.iter().enumerate() {
            let sharpness = sharpness([x, *a, *b, *c]);
            if sharpness > worst {
                (worst, at) = (sharpness, i);
            }
        }
        self.faces.swap(0, at);
        worst
    }

    /// What a move of the node by a unit vector gains of six times the volume of the star's tetrahedra, each counted as
    /// often as `weight` of its grain says: volumes are linear in the node's place.
    pub(super) fn gain(&self, weight: impl Fn(u32) -> f64) -> Vec3 {
        -self.faces.iter().map(|([a, b, c], grain)| (b - a).cross(&(c - a)) * weight(*grain)).sum::<Vec3>()
    }

    /// The grains of the star's tetrahedra, and the mortar's mark; each as often as it occurs.
    pub(super) fn grains(&self) -> impl Iterator<Item = u32> + '_ {
        self.faces.iter().map(|(_, grain)| *grain)
    }

    /// Mean of the surrounding nodes, each as often as it occurs.
    pub(super) fn mean(&self) -> Vec3 {
        let sum: Vec3 = self.faces.iter().flat_map(|(face, _)| face).sum();
        sum / (3 * self.faces.len()) as f64
    }
}

/// How sharp a tetrahedron's smallest dihedral angle is: its cosine times the cosine's size, so that no root is needed;
/// 2 where the tetrahedron has no positive volume.
pub(in crate::mesh) fn sharpness([a, b, c, d]: [Vec3; 4]) -> f64 {
    let (u, v, w) = (b - a, c - a, d - a);
    let (vw, wu, uv) = (v.cross(&w), w.cross(&u), u.cross(&v));
    if vw.dot(&u) <= 0.0 {
        return 2.0;
    }
    // Face vectors; over a closed surface they sum to nothing.
    let faces = [-vw, -wu, -uv, vw + wu + uv];
    let inverse = faces.map(|face| 1.0 / face.norm_squared());
    let mut worst: f64 = -1.0;
    for i in 0..4 {
        for j in 0..i {
            let product = -faces[i].dot(&faces[j]);
            worst = worst.max(product * product.abs() * (inverse[i] * inverse[j]));
        }
    }
    worst
}

/// The [`sharpness`] of an angle, degrees.
pub(in crate::mesh) fn sharpness_of(degrees: f64) -> f64 {
    let cosine = libm::cos(degrees.to_radians());
    cosine * cosine.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_that_give_way_leave_the_stars_of_their_nodes_and_others_come_in() {
        // An edge from 3 to 4 in the place of the triangle of 0, 1 and 2; node 2 has no star.
        let (old, new) = ([[0, 1, 2, 3], [0, 2, 1, 4]], [[0, 1, 4, 3], [1, 2, 4, 3], [2, 0, 4, 3]]);
        let mut stars = Stars::new(&old, &[true, true, false, true, true]);
        let numbered = |first: u32, cells: &[[u32; 4]]| (first..).zip(cells.iter().copied()).collect::<Vec<_>>();
        stars.exchange(&numbered(0, &old), &numbered(2, &new));
        assert_eq!(
            [0, 1, 2, 3, 4].map(|node| stars.cells(node).to_vec()),
            [vec![2, 4], vec![2, 3], vec![], vec![2, 3, 4], vec![2, 3, 4]]
        );
    }

    #[test]
    fn sharpness_orders_tetrahedra_as_their_smallest_angle_does() {
        // At the edge from a to b the faces meet at `angle`; the other angles are larger.
        for angle in [5.0_f64, 20.0, 40.0] {
            let (sin, cos) = (libm::sin(angle.to_radians()), libm::cos(angle.to_radians()));
            let p = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.5, cos, sin]].map(Vec3::from);
            assert!((sharpness(p) - sharpness_of(angle)).abs() < 1e-12, "{angle}");
            assert_eq!(sharpness([p[1], p[0], p[2], p[3]]), 2.0);
        }
    }
}
