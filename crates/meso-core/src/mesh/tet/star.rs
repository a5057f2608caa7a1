//! The star of one node: what a move of the node does to the tetrahedra around it.

use super::tetrahedra::TetMesh;
use super::tetrahedra::min_dihedral_cos2;
use crate::math::Vec3;

/// The tetrahedra around one node as the opposite faces (a, b, c), with positive volume over the node, and their owners.
pub(in crate::mesh) struct Star {
    pub(in crate::mesh) centre: Vec3,
    faces: Vec<([Vec3; 3], u32)>,
}

impl Star {
    /// The star of `node` in a mesh, from the numbers of its cells.
    pub(in crate::mesh) fn of(mesh: &TetMesh, node: u32, cells: &[u32]) -> Self {
        Self::of_cells(node, cells.iter().map(|&cell| mesh.owned(cell)), |node| mesh.position(node))
    }

    /// The star of `node` from its cells with their owners; `position` finds their corners.
    pub(in crate::mesh) fn of_cells(
        node: u32,
        cells: impl Iterator<Item = ([u32; 4], u32)>,
        position: impl Fn(u32) -> Vec3,
    ) -> Self {
        let face = |(nodes, owner): ([u32; 4], u32)| {
            let at = nodes.iter().position(|&n| n == node).expect("a star's cells hold its node");
            // Even permutations that bring the node to the front.
            let [i, j, k] = [[1, 2, 3], [0, 3, 2], [3, 0, 1], [2, 1, 0]][at];
            ([nodes[i], nodes[j], nodes[k]].map(&position), owner)
        };
        Self { centre: position(node), faces: cells.map(face).collect() }
    }

    /// With the cells of a periodic image of the node, `shift` mm away.
    pub(in crate::mesh) fn with_image(mut self, image: Self, shift: &Vec3) -> Self {
        self.faces.extend(image.faces.into_iter().map(|(face, owner)| (face.map(|p| p - shift), owner)));
        self
    }

    /// [`min_dihedral_cos2`] of the worst tetrahedron with the node at `x`. The search ends at the first above `limit`.
    pub(in crate::mesh) fn worst(&self, x: &Vec3, limit: f64) -> f64 {
        let mut worst: f64 = -1.0;
        for ([a, b, c], _) in &self.faces {
            worst = worst.max(min_dihedral_cos2([*x, *a, *b, *c]));
            if worst > limit {
                break;
            }
        }
        worst
    }

    /// [`worst`](Self::worst) of the node's own position; the worst tetrahedron comes first from now on, where searches
    /// with a limit end soonest.
    pub(in crate::mesh) fn worst_first(&mut self) -> f64 {
        let x = self.centre;
        let (mut worst, mut at) = (-1.0, 0);
        for (i, ([a, b, c], _)) in self.faces.iter().enumerate() {
            let cos2 = min_dihedral_cos2([x, *a, *b, *c]);
            if cos2 > worst {
                (worst, at) = (cos2, i);
            }
        }
        self.faces.swap(0, at);
        worst
    }

    /// What a move of the node by a unit vector gains of six times the volume of the star's tetrahedra, each counted as
    /// often as `weight` of its owner says: volumes are linear in the node's position.
    pub(in crate::mesh) fn gain(&self, weight: impl Fn(u32) -> f64) -> Vec3 {
        -self.faces.iter().map(|([a, b, c], owner)| (b - a).cross(&(c - a)) * weight(*owner)).sum::<Vec3>()
    }

    /// The owners of the star's tetrahedra; each as often as it occurs.
    pub(in crate::mesh) fn owners(&self) -> impl Iterator<Item = u32> + '_ {
        self.faces.iter().map(|(_, owner)| *owner)
    }

    /// Mean of the surrounding nodes, each as often as it occurs.
    pub(in crate::mesh) fn mean(&self) -> Vec3 {
        let sum: Vec3 = self.faces.iter().flat_map(|(face, _)| face).sum();
        sum / (3 * self.faces.len()) as f64
    }
}
