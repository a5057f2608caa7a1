//! Input of an assembly.

use meso_element::block::{Common, PHASES};
use meso_mesh::Phase;
use meso_mesh::materials::StrengthField;
use meso_trial::Sample;
use meso_trial::Smoothing;

/// A mesh and the choices that its elements depend on.
pub(crate) struct BlockParts<'a> {
    pub(crate) sample: &'a Sample<'a>,
    pub(crate) common: &'a Common,
    /// Time step, s.
    pub(crate) dt: f64,
    /// Smoothing of tetrahedra.
    pub(crate) smoothing: Smoothing,
    /// By cell, whether it lies below the layer at the surface; empty where there is no layer.
    pub(crate) below: &'a [bool],
    /// Factors of the strengths; none where they do not scatter.
    pub(crate) strengths: Option<&'a StrengthField>,
}

impl BlockParts<'_> {
    /// Number of the strain without stress of an element made of some cells: the layer has those with half of them in it.
    pub(crate) fn free(&self, phase: Phase, cells: &[u32]) -> u8 {
        let below = cells.iter().filter(|&&cell| self.below.get(cell as usize) == Some(&true)).count();
        // All aggregates have one strain.
        let phase = if phase.is_aggregate() { Phase::Aggregate } else { phase };
        if 2 * below > cells.len() { PHASES as u8 + phase.number() } else { phase.number() }
    }
}
