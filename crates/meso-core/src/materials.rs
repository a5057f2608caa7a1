//! Material values that decks carry: the serde view of `[materials]`.
//!
//! The defaults are illustrative, in the middle of what mesoscale studies of concrete use; they are nobody's measured
//! concrete, and the method paper's own Table 3 is not available.

use crate::mesh::Phase;
use serde::{Deserialize, Serialize};

/// Values of the three phases.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Materials {
    /// Aggregate cores.
    pub aggregate: Elastic,
    /// Interfacial transition zone.
    pub itz: Elastic,
    /// Mortar.
    pub mortar: Elastic,
}

/// Isotropic linear elasticity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Elastic {
    /// Young's modulus, MPa.
    pub youngs_modulus_mpa: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Density, tonne/mm3.
    pub density_t_per_mm3: f64,
}

impl Default for Materials {
    fn default() -> Self {
        Self {
            aggregate: Elastic { youngs_modulus_mpa: 70_000.0, poisson_ratio: 0.2, density_t_per_mm3: 2.7e-9 },
            itz: Elastic { youngs_modulus_mpa: 20_000.0, poisson_ratio: 0.2, density_t_per_mm3: 2.2e-9 },
            mortar: Elastic { youngs_modulus_mpa: 26_000.0, poisson_ratio: 0.2, density_t_per_mm3: 2.2e-9 },
        }
    }
}

impl Elastic {
    /// Speed of dilatational waves, mm/s: sqrt(E (1 - nu) / (rho (1 + nu) (1 - 2 nu))).
    pub fn wave_speed_mm_per_s(&self) -> f64 {
        let (e, nu, rho) = (self.youngs_modulus_mpa, self.poisson_ratio, self.density_t_per_mm3);
        (e * (1.0 - nu) / (rho * (1.0 + nu) * (1.0 - 2.0 * nu))).sqrt()
    }
}

impl Materials {
    /// The elastic values of `phase`.
    pub fn elastic(&self, phase: Phase) -> &Elastic {
        match phase {
            Phase::Mortar => &self.mortar,
            Phase::Itz => &self.itz,
            Phase::Aggregate => &self.aggregate,
        }
    }
}
