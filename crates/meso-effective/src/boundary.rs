//! Conditions at the walls of a specimen.

use crate::error::EffectiveError;
use meso_concrete::specimen::Specimen;

/// Conditions at walls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
    /// Names of the conditions, in their order.
    pub const NAMES: [&str; 3] = ["fixed", "uniform-gradient", "uniform-flux"];

    /// The conditions of a name.
    pub fn named(name: &str) -> Option<Self> {
        [Self::Fixed, Self::UniformGradient, Self::UniformFlux].into_iter().find(|of| of.name() == name)
    }

    /// The name of the conditions.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// Refuses the conditions that voxels do not have.
    pub(crate) fn accept_in_voxels(self) -> Result<(), EffectiveError> {
        if self == Self::Fixed {
            Ok(())
        } else {
            Err(EffectiveError::Boundary(self.name(), "voxels have fixed; take the method lattice"))
        }
    }

    /// Refuses uniform conditions for a specimen that has a side without a flat wall.
    pub(crate) fn accept(self, specimen: &Specimen) -> Result<(), EffectiveError> {
        let is_walled = specimen.container().is_box() && (0..3).all(|axis| specimen.period().along(axis).is_none());
        if self == Self::Fixed || is_walled {
            return Ok(());
        }
        Err(EffectiveError::Boundary(
            self.name(),
            "the specimen must be a cube, a box or a prism that has walls on all sides",
        ))
    }
}
