//! Rocks that aggregates are made of: stiffness, density, strength, and their effect on a concrete's modulus.
//!
//! Factors of a concrete's modulus are those of fib Model Code 2010, Table 5.1-6 (EN 1992-1-1, 3.1.3(2), has the same). Ranges
//! of strength are those of "Some useful numbers on the engineering properties of materials", University of Texas, Austin,
//! GEOL 615; the middle of each range is taken. A value whose source says "remembered" was not read anywhere.

use super::Elastic;
use serde::{Deserialize, Serialize};

/// A kind of rock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Rock {
    /// Granite.
    Granite,
    /// Basalt.
    Basalt,
    /// Limestone.
    Limestone,
    /// Quartzite.
    Quartzite,
    /// Sandstone.
    Sandstone,
    /// Gneiss.
    Gneiss,
}

/// Values of a rock, with the source of its modulus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RockValues {
    /// Stiffness and density.
    pub elastic: Elastic,
    /// Source of the modulus.
    pub source: &'static str,
    /// Modulus of a concrete of this rock over one of quartzite, and its source.
    pub concrete: (f64, &'static str),
    /// Compressive strength: least and largest of the range, MPa.
    pub compressive_mpa: [f64; 2],
    /// Tensile strength: least and largest of the range, MPa.
    pub tensile_mpa: [f64; 2],
}

/// Source of a factor.
const CODE: &str = "fib Model Code 2010, Table 5.1-6";
const LIKE_QUARTZITE: &str = "as quartzite in fib Model Code 2010, Table 5.1-6";

impl Rock {
    /// All kinds.
    pub const ALL: [Self; 6] =
        [Self::Granite, Self::Basalt, Self::Limestone, Self::Quartzite, Self::Sandstone, Self::Gneiss];

    /// Its values.
    pub fn values(self) -> RockValues {
        let rock = |gpa: f64, poisson_ratio, density, source, concrete, compressive_mpa, tensile_mpa| RockValues {
            elastic: Elastic { youngs_modulus_mpa: 1000.0 * gpa, poisson_ratio, density_t_per_mm3: density },
            source,
            concrete,
            compressive_mpa,
            tensile_mpa,
        };
        match self {
            Self::Granite => {
                let source = "UCL, Earth Materials; GEOL 615 has 10 to 70 GPa";
                rock(50.0, 0.22, 2.65e-9, source, (1.0, LIKE_QUARTZITE), [100.0, 250.0], [7.0, 25.0])
            }
            Self::Basalt => {
                let source = "Schultz 1993, intact basalt at 20 degrees";
                rock(73.0, 0.25, 2.9e-9, source, (1.2, CODE), [100.0, 300.0], [10.0, 30.0])
            }
            Self::Limestone => {
                let source = "in the upper half of 15 to 55 GPa of GEOL 615";
                rock(45.0, 0.25, 2.6e-9, source, (0.9, CODE), [30.0, 250.0], [5.0, 25.0])
            }
            Self::Quartzite => {
                let source = "a little below the 71.7 GPa of pure quartz; remembered";
                rock(70.0, 0.15, 2.65e-9, source, (1.0, CODE), [150.0, 300.0], [10.0, 30.0])
            }
            Self::Sandstone => {
                let source = "UCL, Earth Materials; GEOL 615 has 1 to 20 GPa";
                rock(20.0, 0.25, 2.3e-9, source, (0.7, CODE), [20.0, 170.0], [4.0, 25.0])
            }
            Self::Gneiss => {
                let source = "in the upper half of 20 to 60 GPa; remembered";
                rock(50.0, 0.22, 2.7e-9, source, (1.0, LIKE_QUARTZITE), [50.0, 200.0], [5.0, 20.0])
            }
        }
    }
}
