//! The linear tetrahedron (C3D4): its shape functions.

use meso_collision::math::{Mat3, Vec3};
use meso_mesh::Mesh;

/// Corners of a cell of `mesh`.
pub(crate) fn corners(mesh: &Mesh, cell: u32) -> [Vec3; 4] {
    let nodes = mesh.cell(cell as usize);
    [0, 1, 2, 3].map(|corner| mesh.points[nodes[corner] as usize])
}

/// Gradients of the shape functions of the second to the fourth node, 1/mm, and the volume, mm3.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    /// One row per node.
    pub(crate) gradients: [Vec3; 3],
    /// Negative where the nodes are out of order.
    pub(crate) volume: f64,
}

impl Shape {
    /// Gradients and volume of the tetrahedron with these corners.
    pub(crate) fn of(corners: &[Vec3; 4]) -> Self {
        let [a, b, c] = [1, 2, 3].map(|i| corners[i] - corners[0]);
        let six = a.dot(&b.cross(&c));
        Self { gradients: [b.cross(&c) / six, c.cross(&a) / six, a.cross(&b) / six], volume: six / 6.0 }
    }

    /// Gradients of all four nodes, 1/mm.
    pub(crate) fn all_gradients(&self) -> [Vec3; 4] {
        let [b, c, d] = self.gradients;
        [-(b + c + d), b, c, d]
    }

    /// sum g_a g_a^T over all four nodes, 1/mm2.
    pub(crate) fn metric(&self) -> Mat3 {
        self.all_gradients().iter().map(|g| g * g.transpose()).sum()
    }
}
