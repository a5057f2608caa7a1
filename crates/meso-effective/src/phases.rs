//! Properties, and the value of each phase.

use crate::moduli::PhaseModuli;
use crate::surfaces::ByPhase;
use meso_concrete::aggregate::Aggregate;
use meso_concrete::{OutOfRange, Phase, PhaseNames, Ranges};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A property that relates a flux to a gradient.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Property {
    /// Diffusion, of chloride or moisture; values are relative to the mortar's.
    #[default]
    Diffusivity,
    /// Conduction of heat, W/(m K).
    Conductivity,
    /// Flow of water under pressure, mm2.
    Permeability,
}

impl Property {
    /// All properties.
    pub const ALL: [Self; 3] = [Self::Diffusivity, Self::Conductivity, Self::Permeability];
}

/// Value of each phase, in one unit; mortar must conduct.
pub type PhaseValues = ByPhase<f64>;

/// Values of a phases file: one table for each property, in which omitted phases keep the defaults of [`PhaseValues::of_property`].
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Phases {
    /// Diffusivities, relative to any of them.
    pub diffusivity: GivenValues,
    /// Conductivities, W/(m K).
    pub conductivity: GivenValues,
    /// Permeabilities, mm2.
    pub permeability: GivenValues,
    /// Elastic constants.
    pub stiffness: PhaseModuli,
}

/// Values that a phases file states; an omitted ITZ has the mortar's.
pub type GivenValues = ByPhase<Option<f64>>;

impl Phases {
    /// The values for `property`.
    pub fn values(&self, property: Property) -> PhaseValues {
        let GivenValues { mortar, aggregate, itz, void, fibre, own } = match property {
            Property::Diffusivity => &self.diffusivity,
            Property::Conductivity => &self.conductivity,
            Property::Permeability => &self.permeability,
        };
        let usual = PhaseValues::of_property(property);
        let mortar = mortar.unwrap_or(usual.mortar);
        PhaseValues {
            mortar,
            aggregate: aggregate.unwrap_or(usual.aggregate),
            itz: itz.unwrap_or(mortar),
            void: void.unwrap_or(usual.void),
            fibre: fibre.unwrap_or(usual.fibre),
            own: own.iter().filter_map(|(name, value)| Some((name.clone(), (*value)?))).collect(),
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
            Property::Diffusivity => Self { mortar: 1.0, itz: 1.0, ..Self::default() },
            Property::Conductivity => {
                Self { mortar: 1.5, aggregate: 3.0, itz: 1.5, void: 0.025, fibre: 50.0, own: BTreeMap::new() }
            }
            // 1e-17 m2.
            Property::Permeability => Self { mortar: 1e-11, itz: 1e-11, ..Self::default() },
        }
    }

    /// Values of all phases of the aggregates.
    pub(crate) fn of_aggregates(&self, names: &PhaseNames) -> Vec<f64> {
        names.all().filter(|phase| phase.is_aggregate()).map(|phase| self.of(phase, names)).collect()
    }

    /// Refuses a shell that nothing passes: what it encloses would count.
    ///
    /// # Errors
    /// The first such shell.
    pub(crate) fn validate_shells(
        &self,
        property: Property,
        bodies: &[Aggregate],
        names: &PhaseNames,
    ) -> Result<(), OutOfRange> {
        for shell in bodies.iter().flat_map(|body| &body.shells) {
            let (phase, why) =
                (Phase::Own(shell.own), "a shell lets something pass: give it a small value, as 1e-4 of the mortar's");
            Ranges(property.name()).require(names.name(phase), 0, self.of(phase, names) > 0.0, why)?;
        }
        Ok(())
    }

    /// Refuses values that are negative or too far from the mortar's, and other phases than a packing's own.
    ///
    /// # Errors
    /// The first value out of its range.
    pub fn validate(&self, property: Property, names: &PhaseNames) -> Result<(), OutOfRange> {
        let ranges = Ranges(property.name());
        names.suit(&self.own, ranges, &self.aggregate.to_string())?;
        let is_met = SIZES.contains(&self.mortar);
        ranges.require(
            "mortar",
            self.mortar,
            is_met,
            format!("it must be {:e} to {:e}", SIZES.start(), SIZES.end()),
        )?;
        let Self { mortar, aggregate, itz, void, fibre, ref own } = *self;
        let common = [("aggregate", aggregate), ("itz", itz), ("void", void), ("fibre", fibre)];
        let own = own.iter().map(|(name, value)| (name.as_str(), *value));
        for (name, value) in common.into_iter().chain(own) {
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
