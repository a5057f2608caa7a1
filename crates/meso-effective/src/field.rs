//! Fluxes and stresses of a solution, for viewers.

use meso_mesh::Mesh;
use meso_view::vtk::Still;
use meso_view::vtk::mesh::{Field, write_fields};
use std::io::{self, BufWriter, Write};
use std::sync::Arc;

/// Names of strains and stresses in the order of this crate.
pub(crate) const COMPONENTS: [&str; 6] = ["xx", "yy", "zz", "yz", "zx", "xy"];
/// Components in VTK's order of a symmetric tensor: xx, yy, zz, xy, yz, xz.
const OF_VTK: [usize; 6] = [0, 1, 2, 5, 3, 4];

/// Potential and flux for a unit gradient along an axis, or stress for a unit of mean strain.
#[derive(Clone, Debug)]
pub struct PropertyField {
    /// Name of the property.
    pub what: &'static str,
    /// Component of the gradient, 0 to 2 for x, y, z, or of the strain, 0 to 5 for xx, yy, zz, yz, zx, xy.
    pub component: usize,
    /// Cells of the values.
    pub cells: FieldCells,
    /// Potential at the voxels' centres, x fastest, or at the nodes of tetrahedra; empty for stresses.
    pub potential: Vec<f32>,
    /// Fluxes x, y, z of the cells, or their mean stresses xx, yy, zz, xy, yz, xz, MPa.
    pub values: Vec<f32>,
}

/// Cells that a field has values in.
#[derive(Clone, Debug)]
pub enum FieldCells {
    /// Voxels of a box.
    Voxels {
        /// Voxels along x, y, z.
        counts: [usize; 3],
        /// Lower corner, mm.
        origin_mm: [f64; 3],
        /// Edges of a voxel, mm.
        spacing_mm: [f64; 3],
    },
    /// A mesh of all fields.
    Tetrahedra(Arc<Mesh>),
}

impl PropertyField {
    /// Stresses of cells, in the order of this crate, for the strain `component`.
    pub(crate) fn of_stress(component: usize, cells: FieldCells, mut stress: Vec<[f32; 6]>) -> Self {
        stress.iter_mut().for_each(|stress| *stress = OF_VTK.map(|row| stress[row]));
        Self { what: "stiffness", component, cells, potential: Vec::new(), values: stress.into_flattened() }
    }

    /// Whether the values are stresses, six a cell; a flux has three.
    pub(crate) fn is_stress(&self) -> bool {
        self.potential.is_empty()
    }

    /// Writes VTK image data (`.vti`) of voxels, or a VTK grid (`.vtu`) of tetrahedra, for ParaView and PyVista.
    ///
    /// # Errors
    /// Fails with the errors of `out`.
    pub fn write(&self, out: impl Write) -> io::Result<()> {
        let (name, components) = if self.is_stress() { ("stress", 6) } else { ("flux", 3) };
        let potential = Field { name: "potential", components: 1, values: &self.potential };
        let potential = if self.is_stress() { &[][..] } else { &[potential] };
        let values = Field { name, components, values: &self.values };
        match &self.cells {
            FieldCells::Tetrahedra(mesh) => write_fields(mesh, potential, &[values], &mut Still::default(), out),
            FieldCells::Voxels { counts, origin_mm, spacing_mm } => {
                let arrays = potential.iter().chain([&values]);
                write_vti((counts, origin_mm, spacing_mm), &arrays.collect::<Vec<_>>(), out)
            }
        }
    }
}

/// Writes arrays of voxels; viewers begin with the last.
fn write_vti(
    ([nx, ny, nz], [x, y, z], [dx, dy, dz]): (&[usize; 3], &[f64; 3], &[f64; 3]),
    arrays: &[&Field<'_>],
    out: impl Write,
) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    let extent = format!("0 {nx} 0 {ny} 0 {nz}");
    let active = if arrays.len() > 1 { "Scalars=\"potential\" Vectors=\"flux\"" } else { "Tensors=\"stress\"" };
    writeln!(out, "<?xml version=\"1.0\"?>")?;
    writeln!(out, "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">")?;
    writeln!(out, "<ImageData WholeExtent=\"{extent}\" Origin=\"{x} {y} {z}\" Spacing=\"{dx} {dy} {dz}\">")?;
    writeln!(out, "<Piece Extent=\"{extent}\">\n<CellData {active}>")?;
    let mut offset = 0;
    for Field { name, components, values } in arrays {
        writeln!(
            out,
            "<DataArray type=\"Float32\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" offset=\"{offset}\"/>"
        )?;
        offset += 8 + 4 * values.len();
    }
    write!(out, "</CellData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_")?;
    for Field { values, .. } in arrays {
        out.write_all(&(4 * values.len() as u64).to_le_bytes())?;
        values.iter().try_for_each(|value| out.write_all(&value.to_le_bytes()))?;
    }
    out.write_all(b"\n</AppendedData>\n</VTKFile>\n")?;
    out.flush()
}

/// Von Mises' stress of stresses xx, yy, zz, xy, yz, xz.
pub(crate) fn von_mises(stress: &[f32]) -> f32 {
    let [xx, yy, zz, xy, yz, xz] = std::array::from_fn(|i| stress[i]);
    let square = |a: f32| a * a;
    let normal = square(xx - yy) + square(yy - zz) + square(zz - xx);
    (normal / 2.0 + 3.0 * (square(xy) + square(yz) + square(xz))).sqrt()
}
