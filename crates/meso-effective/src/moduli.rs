//! Elastic constants of the phases.

use crate::surfaces::ByPhase;
use meso_concrete::aggregate::Aggregate;
use meso_concrete::{OutOfRange, Phase, PhaseNames, PhysicalRange, Ranges};
use serde::{Deserialize, Serialize};

/// Constants of an isotropic phase.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Moduli {
    /// Young's modulus, MPa.
    pub youngs_modulus_mpa: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Strain without stress, equal in all directions: shrinkage is negative.
    pub eigenstrain: f64,
}

/// Constants that a phases file states.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GivenModuli {
    /// Young's modulus, MPa.
    pub youngs_modulus_mpa: Option<f64>,
    /// Poisson's ratio.
    pub poisson_ratio: Option<f64>,
    /// Strain without stress.
    pub eigenstrain: Option<f64>,
}

/// The table `[stiffness]` of a phases file, one table for each phase.
pub type PhaseModuli = ByPhase<GivenModuli>;

/// Largest ratio of a phase's modulus to the mortar's.
const CONTRAST: f64 = 1e4;
/// Largest ratio of Poisson: trilinear voxels lock near 0.5.
const INCOMPRESSIBLE: f64 = 0.49;

/// Constants by [`Phase::index`].
pub(crate) type Table = Vec<Moduli>;

/// Refuses the strain of a phase that a packing has not.
pub(crate) fn accept_strains(table: &Table, bodies: &[Aggregate], names: &PhaseNames) -> Result<(), OutOfRange> {
    let has = |phase: Phase| match phase {
        Phase::Mortar => true,
        Phase::Itz => bodies.iter().any(|body| body.itz_thickness_mm > 0.0),
        _ => bodies.iter().any(|body| body.layers().any(|(_, layer)| layer == phase)),
    };
    let there: Vec<&str> = names.all().filter(|phase| has(*phase)).map(|phase| names.name(phase)).collect();
    let of_mortar = table[Phase::Mortar.index()].eigenstrain;
    // An ITZ without thickness is mortar, which may have its strain.
    let is_met = |phase: Phase, strain: f64| has(phase) || phase == Phase::Itz && strain == of_mortar;
    let strain =
        |(phase, moduli): (Phase, &Moduli)| (names.name(phase), is_met(phase, moduli.eigenstrain), moduli.eigenstrain);
    let strains = names.all().zip(table).map(strain);
    refuse_absent(strains, &there.join(", "))
}

/// Refuses the first strain, by its name, of a phase that is not there; `there` lists those that are.
pub(crate) fn refuse_absent<'a>(
    mut strains: impl Iterator<Item = (&'a str, bool, f64)>,
    there: &str,
) -> Result<(), OutOfRange> {
    match strains.find(|(_, is_there, strain)| !is_there && *strain != 0.0) {
        None => Ok(()),
        Some((name, _, strain)) => {
            let accepted = format!("the specimen has no such phase, it has {there}; leave it out");
            Ranges("stiffness").require(format!("{name}.eigenstrain"), strain, false, accepted)
        }
    }
}

impl PhaseModuli {
    /// Constants of all phases of a packing.
    ///
    /// # Errors
    /// The first constant out of its range, and other phases than the packing's own.
    pub(crate) fn table(&self, names: &PhaseNames) -> Result<Table, OutOfRange> {
        let ranges = Ranges("stiffness");
        names.suit(&self.own, ranges, "{ youngs_modulus_mpa = 60000, poisson_ratio = 0.2 }")?;
        for (name, given) in &self.own {
            let is_met = given.youngs_modulus_mpa.is_some() && given.poisson_ratio.is_some();
            let why = "give youngs_modulus_mpa and poisson_ratio: a phase of one's own has no usual values";
            ranges.require(name, "incomplete", is_met, why)?;
        }
        let table: Table = names.all().map(|phase| self.of(phase, names).or(Moduli::usual(phase))).collect();
        let mortar = table[0].youngs_modulus_mpa;
        ranges.positive("mortar.youngs_modulus_mpa", mortar)?;
        names.all().try_for_each(|phase| table[phase.index()].validate(names.name(phase), mortar))?;
        Ok(table)
    }

    /// Refuses constants out of their ranges, and other phases than a packing's own.
    ///
    /// # Errors
    /// The first constant out of its range.
    pub fn validate(&self, names: &PhaseNames) -> Result<(), OutOfRange> {
        self.table(names).map(drop)
    }
}

impl GivenModuli {
    pub(crate) fn or(self, usual: Moduli) -> Moduli {
        Moduli {
            youngs_modulus_mpa: self.youngs_modulus_mpa.unwrap_or(usual.youngs_modulus_mpa),
            poisson_ratio: self.poisson_ratio.unwrap_or(usual.poisson_ratio),
            eigenstrain: self.eigenstrain.unwrap_or(0.0),
        }
    }
}

impl Moduli {
    /// A phase with the ratio of Poisson of concrete.
    pub(crate) fn alone(youngs_modulus_mpa: f64) -> Self {
        Self { youngs_modulus_mpa, poisson_ratio: 0.2, eigenstrain: 0.0 }
    }

    /// Illustrative constants, equal to the elastic ones of a test's materials.
    fn usual(phase: Phase) -> Self {
        let (youngs_modulus_mpa, poisson_ratio) = match phase {
            Phase::Mortar => (20_000.0, 0.2),
            Phase::Itz => (16_000.0, 0.2),
            Phase::Aggregate | Phase::Own(_) => (60_000.0, 0.2),
            Phase::Void => (0.0, 0.0),
            Phase::Fibre => (200_000.0, 0.3),
        };
        Self { youngs_modulus_mpa, poisson_ratio, eigenstrain: 0.0 }
    }

    /// Refuses constants out of their ranges, by the name of the phase, in mortar of a modulus.
    pub(crate) fn validate(&self, name: &str, mortar: f64) -> Result<(), OutOfRange> {
        let ranges = Ranges("stiffness");
        let (e, nu, strain) = (self.youngs_modulus_mpa, self.poisson_ratio, self.eigenstrain);
        let modulus = PhysicalRange::MODULUS_OF_A_PHASE;
        ranges.require(format!("{name}.youngs_modulus_mpa"), e, modulus.has(e), modulus.refusal(e))?;
        let most = CONTRAST * mortar;
        let accepted = format!("it must be 0 to {most} MPa, 10000 times the mortar's");
        ranges.require(format!("{name}.youngs_modulus_mpa"), e, e <= most, accepted)?;
        let accepted = format!("it must be above -1 and at most {INCOMPRESSIBLE}");
        ranges.require(format!("{name}.poisson_ratio"), nu, nu > -1.0 && nu <= INCOMPRESSIBLE, accepted)?;
        let free = PhysicalRange::FREE_STRAIN;
        ranges.require(format!("{name}.eigenstrain"), strain, free.has(strain), free.refusal(strain))
    }

    /// Bulk modulus, MPa.
    pub fn bulk(&self) -> f64 {
        self.youngs_modulus_mpa / (3.0 * (1.0 - 2.0 * self.poisson_ratio))
    }

    /// Shear modulus, MPa.
    pub fn shear(&self) -> f64 {
        self.youngs_modulus_mpa / (2.0 * (1.0 + self.poisson_ratio))
    }
}
