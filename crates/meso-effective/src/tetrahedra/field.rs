//! Fluxes and stresses of a mesh, for viewers.

use crate::elastic::OF_VTK;
use meso_mesh::Mesh;
use meso_view::vtk::Still;
use meso_view::vtk::mesh::{Field, write_fields};
use std::io::{self, Write};
use std::sync::Arc;

/// Potential and flux, or stress, of every cell of a mesh.
pub struct MeshField {
    /// Component of the gradient, 0 to 2 for x, y, z, or of the strain, 0 to 5 for xx, yy, zz, yz, zx, xy.
    pub component: usize,
    /// Potential at every node; empty for stresses.
    pub potential: Vec<f32>,
    /// Fluxes x, y, z of the cells, or their stresses xx, yy, zz, xy, yz, xz, MPa.
    pub values: Vec<f32>,
    /// The mesh of all fields.
    pub mesh: Arc<Mesh>,
}

/// Values at the nodes and in the cells of a mesh.
pub(super) struct CellValues {
    pub(super) component: usize,
    pub(super) potential: Vec<f32>,
    pub(super) values: Vec<f32>,
}

impl CellValues {
    /// Stresses in the order of this crate.
    pub(super) fn of_stress(component: usize, stress: Vec<[f32; 6]>) -> Self {
        let values = stress.into_iter().flat_map(|stress| OF_VTK.map(|row| stress[row])).collect();
        Self { component, potential: Vec::new(), values }
    }
}

impl MeshField {
    /// The fields of a mesh.
    pub(super) fn all(mesh: Mesh, fields: Vec<CellValues>) -> Vec<Self> {
        let mesh = Arc::new(mesh);
        let field = |CellValues { component, potential, values }| {
            let mesh = Arc::clone(&mesh);
            Self { component, potential, values, mesh }
        };
        fields.into_iter().map(field).collect()
    }

    /// Number of values of a cell: 3 for a flux, 6 for a stress.
    pub(crate) fn components(&self) -> usize {
        self.values.len() / self.mesh.cell_count().max(1)
    }

    /// Writes a VTK grid (`.vtu`) for ParaView and PyVista.
    ///
    /// # Errors
    /// Fails with the errors of `out`.
    pub fn write_vtu(&self, out: impl Write) -> io::Result<()> {
        let components = self.components();
        let name = if components == 3 { "flux" } else { "stress" };
        let potential = Field { name: "potential", components: 1, values: &self.potential };
        let points = if self.potential.is_empty() { &[][..] } else { &[potential] };
        let cells = &[Field { name, components, values: &self.values }];
        write_fields(&self.mesh, points, cells, &mut Still::default(), out)
    }
}
