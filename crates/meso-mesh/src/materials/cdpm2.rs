//! `[materials.cdpm2]`: parameters of the solver's law CDPM2 that the strengths do not give.

use super::{MATERIALS, Materials};
use meso_concrete::OutOfRange;
use serde::{Deserialize, Serialize};

/// Parameters of Grassl et al. 2013, which decks do not have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Cdpm2Parameters {
    /// Start of hardening over the strength, q_h0.
    pub initial_hardening: f64,
    /// Slope of q2 beyond the peak, H_p.
    pub hardening_modulus: f64,
    /// Plastic strain at the peak, over confinement: A_h, B_h, C_h, D_h.
    pub hardening_ductility: [f64; 4],
    /// Lateral over axial plastic strain in uniaxial compression, D_f.
    pub dilation: f64,
    /// Ductility of damage in uniaxial compression, A_s.
    pub softening_ductility: f64,
    /// Strain of the softening in compression on any width, e_fc; absent, it follows from the crushing energy.
    pub crushing_strain: Option<f64>,
}

impl Default for Cdpm2Parameters {
    /// Sec. 4 of the paper.
    fn default() -> Self {
        Self {
            initial_hardening: 0.3,
            hardening_modulus: 0.01,
            hardening_ductility: [0.08, 0.003, 2.0, 1e-6],
            dilation: 0.85,
            softening_ductility: 15.0,
            crushing_strain: None,
        }
    }
}

impl Materials {
    /// Checks the parameters of CDPM2 beside the strengths.
    ///
    /// # Errors
    /// Names the first value outside its range.
    pub fn validate_cdpm2(&self) -> Result<(), OutOfRange> {
        let given = &self.cdpm2;
        let [ah, bh, ch, dh] = given.hardening_ductility;
        for (key, value, met, accepted) in [
            ("initial_hardening", given.initial_hardening, (0.1, 0.9), "0.1 to 0.9; 0.3 is usual"),
            ("hardening_modulus", given.hardening_modulus, HARDENING.0, HARDENING.1),
            ("dilation", given.dilation, (0.55, 2.0), "0.55 to 2; 0.85 is usual"),
            ("softening_ductility", given.softening_ductility, (1.0, 100.0), "1 to 100; 15 is usual"),
            ("hardening_ductility[3]", dh, (1e-8, 1e-3), "1e-8 to 1e-3; 1e-6 is usual"),
            ("hardening_ductility[2]", ch, (0.1, 100.0), "0.1 to 100; 2 is usual"),
            ("hardening_ductility[1]", bh, (2.0 * dh, 0.1), "twice its last one to 0.1; 0.003 is usual"),
            ("hardening_ductility[0]", ah, (1.01 * bh, 1.0), "above its second one and at most 1; 0.08 is usual"),
            ("crushing_strain", given.crushing_strain.unwrap_or(1e-4), (1e-6, 1.0), "1e-6 to 1; 1e-4 is usual"),
        ] {
            let inside = value >= met.0 && value <= met.1;
            MATERIALS.require(format!("cdpm2.{key}"), value, inside, format!("it must be {accepted}"))?;
        }
        Ok(())
    }
}

/// Range of H_p. Compressive damage begins where the equivalent strain, of which each step counts the share of compression
/// among the principal stresses, exceeds that of the surface at the peak. Without hardening beyond the peak a point with
/// some lateral tension stays below it and never softens.
const HARDENING: ((f64, f64), &str) = ((0.01, 0.1), "0.01 to 0.1; 0.01 is usual, and with less nothing is crushed");
