//! Conditions at the walls of a specimen.

use meso_concrete::specimen::Specimen;
use meso_concrete::{OutOfRange, Ranges};
use serde::{Deserialize, Serialize};

/// Conditions at walls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Boundary {
    /// Given potentials at both ends of the gradient, and insulated sides.
    #[default]
    Fixed,
    /// The potential of a uniform gradient at all walls: the upper estimate of a small specimen.
    UniformGradient,
    /// A uniform flux through all walls: the lower estimate of a small specimen.
    UniformFlux,
}

impl Boundary {
    /// The name of the conditions.
    pub fn name(self) -> &'static str {
        ["fixed", "uniform-gradient", "uniform-flux"][self as usize]
    }

    /// Refuses the conditions that a division into voxels does not have; tetrahedra have all.
    ///
    /// # Errors
    /// Uniform conditions of voxels.
    pub fn accept_for(self, tetrahedra: bool) -> Result<(), OutOfRange> {
        let accepted = "voxels have fixed; take the method lattice";
        Ranges("effective").require("boundary", self.name(), tetrahedra || self == Self::Fixed, accepted)
    }

    /// Refuses uniform conditions for a specimen that has a side without a flat wall.
    pub(crate) fn accept(self, specimen: &Specimen) -> Result<(), OutOfRange> {
        let is_walled = specimen.container().is_box() && (0..3).all(|axis| specimen.period().along(axis).is_none());
        let accepted = "the specimen must be a cube, a box or a prism that has walls on all sides";
        Ranges("effective").require("boundary", self.name(), self == Self::Fixed || is_walled, accepted)
    }
}
