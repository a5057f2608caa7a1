//! The division of a specimen, and the solutions on it.

use crate::solutions::Solutions;
use serde::Serialize;

/// The division of a specimen into voxels or tetrahedra, and the solutions on it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Resolution {
    /// Conditions at the ends of x, y, z: `periodic`; at walls `fixed` along the gradient and insulated across it, or for
    /// stiffness `uniform-strain`.
    pub boundary: [&'static str; 3],
    /// Voxels along x, y, z.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub voxels: Option<[usize; 3]>,
    /// Edges of a voxel, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub voxel_size_mm: Option<[f64; 3]>,
    /// Number of tetrahedra.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub elements: Option<usize>,
    /// Edge of the tetrahedra, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub element_size_mm: Option<f64>,
    /// Iterations of each solution on the fine voxels or tetrahedra.
    pub iterations: Vec<usize>,
    /// Largest error of the equations, over the result.
    pub solver_error: f64,
}

impl Resolution {
    /// Voxels of a box.
    pub(crate) fn of_voxels(boundary: [&'static str; 3], counts: [usize; 3], spacing: [f64; 3]) -> Self {
        Self { voxels: Some(counts), voxel_size_mm: Some(spacing), ..Self::new(boundary) }
    }

    /// Tetrahedra of a mesh from elsewhere.
    pub(crate) fn of_mesh(boundary: [&'static str; 3], count: usize) -> Self {
        Self { elements: Some(count), ..Self::new(boundary) }
    }

    /// Tetrahedra of a specimen.
    pub(crate) fn of_tetrahedra(boundary: [&'static str; 3], count: usize, size: f64) -> Self {
        Self { elements: Some(count), element_size_mm: Some(size), ..Self::new(boundary) }
    }

    fn new(boundary: [&'static str; 3]) -> Self {
        let (voxels, voxel_size_mm, elements, element_size_mm) = (None, None, None, None);
        Self { boundary, voxels, voxel_size_mm, elements, element_size_mm, iterations: Vec::new(), solver_error: 0.0 }
    }

    /// With the solutions on the fine voxels or tetrahedra.
    pub(crate) fn solved<const N: usize>(self, of: &Solutions<N>) -> Self {
        Self { iterations: of.iterations(), solver_error: of.error(), ..self }
    }

    /// The remedy of a large error.
    pub(crate) fn remedy(&self) -> &'static str {
        if self.voxels.is_some() { "halve the voxel size" } else { "halve the element size" }
    }
}
