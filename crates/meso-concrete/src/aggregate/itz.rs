//! The thickness of the interfacial transition zone, drawn per aggregate (Sec. 2.1, Fig. 2).

use serde::{Deserialize, Serialize};

/// Law of the ITZ thickness: uniform between two limits, per aggregate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Itz {
    /// Lower and upper limit of the thickness, mm. Both 0: the model has no ITZ.
    pub thickness_mm: [f64; 2],
}

impl Default for Itz {
    fn default() -> Self {
        Self { thickness_mm: [0.1, 0.5] }
    }
}
