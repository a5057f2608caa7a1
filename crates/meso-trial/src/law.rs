//! Names of the material laws.

use serde::{Deserialize, Serialize};

/// The law of mortar and ITZ; aggregates and fibres are elastic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum LawName {
    /// Linear elasticity.
    Elastic,
    /// Concrete damaged plasticity, as in the decks.
    Cdp,
    /// CDPM2, with the parameters of its paper beside those of `[materials]`.
    Cdpm2,
    /// Mortar between grains: cracks by the signs of stress, and crushing that leaves friction.
    Meso,
}
