//! Properties, and the value of each phase.

use crate::moduli::PhaseModuli;
use crate::surfaces::ByPhase;
use meso_concrete::{OutOfRange, Ranges};
use serde::{Deserialize, Serialize};

/// A property that relates a flux to a gradient.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Property {
    /// Diffusion, of chloride or moisture; values are relative to the mortar's.
    #[default]
    Diffusivity,
    /// Conduction of heat, W/(m K).
    Conductivity,
}

/// Value of each phase, in one unit; mortar must conduct.
pub type PhaseValues = ByPhase<f64>;

/// Values of a phases file: one table for each property, in which omitted phases keep the defaults of [`PhaseValues::of_property`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Phases {
    /// Diffusivities, relative to any of them.
    pub diffusivity: GivenValues,
    /// Conductivities, W/(m K).
    pub conductivity: GivenValues,
    /// Elastic constants.
    pub stiffness: PhaseModuli,
}

/// Values that a phases file states; an omitted ITZ has the mortar's.
pub type GivenValues = ByPhase<Option<f64>>;

impl Phases {
    /// The values for `property`.
    pub fn values(&self, property: Property) -> PhaseValues {
        let GivenValues { mortar, aggregate, itz, void, fibre } = match property {
            Property::Diffusivity => self.diffusivity,
            Property::Conductivity => self.conductivity,
        };
        let usual = PhaseValues::of_property(property);
        let mortar = mortar.unwrap_or(usual.mortar);
        PhaseValues {
            mortar,
            aggregate: aggregate.unwrap_or(usual.aggregate),
            itz: itz.unwrap_or(mortar),
            void: void.unwrap_or(usual.void),
            fibre: fibre.unwrap_or(usual.fibre),
        }
    }
}

/// Values whose squares and quotients floating point holds.
pub(crate) const SIZES: std::ops::RangeInclusive<f64> = 1e-30..=1e30;
/// Largest ratio of a phase's value to the mortar's.
const CONTRAST: f64 = 1e4;

impl PhaseValues {
    /// Illustrative values: impermeable aggregates and an ITZ like mortar; quartzite in dry mortar, air, steel.
    pub fn of_property(property: Property) -> Self {
        match property {
            Property::Diffusivity => Self { mortar: 1.0, aggregate: 0.0, itz: 1.0, void: 0.0, fibre: 0.0 },
            Property::Conductivity => Self { mortar: 1.5, aggregate: 3.0, itz: 1.5, void: 0.025, fibre: 50.0 },
        }
    }

    /// Refuses values that are negative or too far from the mortar's.
    ///
    /// # Errors
    /// The first value out of its range.
    pub fn validate(&self, property: Property) -> Result<(), OutOfRange> {
        let ranges = Ranges(match property {
            Property::Diffusivity => "diffusivity",
            Property::Conductivity => "conductivity",
        });
        let is_met = SIZES.contains(&self.mortar);
        ranges.require(
            "mortar",
            self.mortar,
            is_met,
            format!("it must be {:e} to {:e}", SIZES.start(), SIZES.end()),
        )?;
        let Self { mortar, aggregate, itz, void, fibre } = *self;
        for (name, value) in [("aggregate", aggregate), ("itz", itz), ("void", void), ("fibre", fibre)] {
            let met = value >= 0.0 && value <= CONTRAST * mortar;
            ranges.require(
                name,
                value,
                met,
                format!("it must be 0 to {}, 10000 times the mortar's", CONTRAST * mortar),
            )?;
        }
        Ok(())
    }
}
