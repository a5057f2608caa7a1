//! Material values that decks carry: the serde view of `[materials]`.
//!
//! The defaults are chosen for the paper's concrete of 35 MPa: they are nobody's measured values, and the method paper's own
//! Table 3 is not available. docs/materials.md has the source of each, docs/measured/validation.md the tests that they meet. The ITZ's strength as 0.5 to 0.9 of the mortar's is the paper's
//! range (Sec. 3.1).

mod cdpm2;
mod concrete;
mod mortar;
mod own;
mod ranges;
mod rock;
mod scatter;
mod stone;

pub use cdpm2::Cdpm2Parameters;
pub use concrete::{Mix, Sourced};
pub use mortar::{LawName, MortarStrength};
pub use own::OwnMaterial;
pub use ranges::MATERIALS;
#[doc(hidden)]
pub use ranges::{DENSITY, MODULUS};
pub use rock::{Rock, RockValues};
pub use scatter::{Covariance, Scatter, ScatteredPhase, StrengthDistribution, StrengthField};
pub use stone::{Stone, StoneKind};

use crate::cells::{CellKind, Mesh, Phase};
use meso_concrete::PhaseNames;
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;

/// Values of the phases.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(
    rename = "Materials",
    extend("additionalProperties" = own::schema())
))]
#[serde(default, deny_unknown_fields, remote = "Self")]
pub struct Materials {
    /// Aggregate cores.
    #[serde(deserialize_with = "aggregate")]
    pub aggregate: Elastic,
    /// Interfacial transition zone.
    #[serde(deserialize_with = "itz")]
    pub itz: Elastic,
    /// Mortar.
    #[serde(deserialize_with = "mortar")]
    pub mortar: Elastic,
    /// Fibres, which stay elastic: steel.
    #[serde(deserialize_with = "fibre")]
    pub fibre: Elastic,
    /// Values of the specimen's own phases by their names: `[materials.NAME]`.
    #[serde(skip)]
    pub own: BTreeMap<String, OwnMaterial>,
    /// Strength of the aggregates in a test; absent, they stay elastic, as they do in decks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub aggregate_strength: Option<Stone>,
    /// Scatter of the strengths of mortar and ITZ over the specimen in a test; absent, each phase has one strength, as in decks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scatter: Option<Scatter>,
    /// Strength of the mortar.
    pub mortar_strength: MortarStrength,
    /// Strengths and energies of the ITZ over those of the mortar, 0.5 to 0.9 in the literature.
    pub itz_strength_ratio: f64,
    /// Thickness that gives a cohesive ITZ its stiffness E / t, mm.
    pub cohesive_thickness_mm: f64,
    /// Fracture energy of a cohesive ITZ in sliding over that in opening, 1 or more.
    pub cohesive_shear_energy_ratio: f64,
    /// Exponent of Benzeggagh and Kenane's mixed-mode fracture energy of a cohesive ITZ.
    pub cohesive_mode_power: f64,
    /// Yield surface and flow of the damaged plasticity.
    pub plasticity: Plasticity,
    /// Crushing and confinement of the solver's law `meso`, which decks do not have.
    pub meso: Mesoscale,
    /// Parameters of the solver's law CDPM2 beside the strengths.
    pub cdpm2: Cdpm2Parameters,
}

/// Isotropic linear elasticity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Elastic {
    /// Young's modulus, MPa.
    pub youngs_modulus_mpa: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Density, tonne/mm3.
    pub density_t_per_mm3: f64,
}

/// Parameters of the uniaxial curves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strength {
    /// Compressive strength, MPa.
    pub compressive_mpa: f64,
    /// Strain at the compressive strength.
    pub peak_strain: f64,
    /// Tensile strength, MPa.
    pub tensile_mpa: f64,
    /// Fracture energy in tension, N/mm.
    pub fracture_energy_n_per_mm: f64,
    /// Energy of crushing beyond the peak, N/mm.
    pub crushing_energy_n_per_mm: f64,
}

/// Parameters of `*CONCRETE DAMAGED PLASTICITY`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Plasticity {
    /// Dilation angle, degrees.
    pub dilation_angle_deg: f64,
    /// Eccentricity of the flow potential.
    pub eccentricity: f64,
    /// Biaxial over uniaxial compressive strength.
    pub biaxial_ratio: f64,
    /// Ratio of the second invariants on the tensile and the compressive meridian, K_c.
    pub meridian_ratio: f64,
    /// Viscosity parameter, s (without effect in Abaqus/Explicit).
    pub viscosity_s: f64,
}

/// Parameters of the law `meso` beside the strengths.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Mesoscale {
    /// Biaxial over uniaxial compressive strength of the mortar.
    pub biaxial_ratio: f64,
    /// Ratio of the second invariants on the tensile and the compressive meridian at low pressure, K_c.
    pub meridian_ratio: f64,
    /// Bend of the meridians: friction falls to half at a least confinement of the strength over this.
    pub meridian_bend: f64,
    /// Dilation angle before cohesion is lost, degrees.
    pub dilation_angle_deg: f64,
    /// Growth of crushing strains with the least confinement over the strength.
    pub confined_ductility: f64,
    /// Least width of a band of crushing, mm.
    pub crushing_length_mm: f64,
}

const AGGREGATE: Elastic = Elastic { youngs_modulus_mpa: 60_000.0, poisson_ratio: 0.2, density_t_per_mm3: 2.7e-9 };
const ITZ: Elastic = Elastic { youngs_modulus_mpa: 16_000.0, poisson_ratio: 0.2, density_t_per_mm3: 2.2e-9 };
const MORTAR: Elastic = Elastic { youngs_modulus_mpa: 20_000.0, poisson_ratio: 0.2, density_t_per_mm3: 2.2e-9 };
const FIBRE: Elastic = Elastic { youngs_modulus_mpa: 200_000.0, poisson_ratio: 0.3, density_t_per_mm3: 7.85e-9 };

impl Default for Materials {
    fn default() -> Self {
        Self {
            aggregate: AGGREGATE,
            itz: ITZ,
            mortar: MORTAR,
            fibre: FIBRE,
            own: BTreeMap::new(),
            aggregate_strength: None,
            scatter: None,
            mortar_strength: MortarStrength::default(),
            itz_strength_ratio: 0.7,
            cohesive_thickness_mm: 0.1,
            cohesive_shear_energy_ratio: 10.0,
            cohesive_mode_power: 1.0,
            plasticity: Plasticity::default(),
            meso: Mesoscale::default(),
            cdpm2: Cdpm2Parameters::default(),
        }
    }
}

impl Default for Plasticity {
    /// Abaqus' own defaults but for a little viscosity, the dilation angle and K_c. Tests of one point have 0.64 to 0.80
    /// (Lubliner et al. 1989): mortar of such a K_c, or that dilates by 30 degrees, confines itself between stiff grains, and
    /// specimens do not soften as tests do (docs/measured/validation.md).
    fn default() -> Self {
        Self {
            dilation_angle_deg: 15.0,
            eccentricity: 0.1,
            biaxial_ratio: 1.16,
            meridian_ratio: 0.9,
            viscosity_s: 0.0005,
        }
    }
}

impl Default for Mesoscale {
    /// Coulomb's friction of mortars: a biaxial ratio of 1, and a K_c whose angle of 29 degrees is that of interfaces in
    /// mortar (tan 0.6, Carol, Lopez and Roa 2001; remembered). The bend and K_c leave concrete around its grains within 15 %
    /// of f + 4.1 p (Richart et al. 1928) at 5 and 10 MPa. Mortar dilates by a third of concrete, whose grains dilate it. A
    /// length of the largest grain's size, as bands of tests are 1 to 3 grains wide. The ductility is below the 30 of
    /// confined tests, which make cubes too strong between rough plates.
    fn default() -> Self {
        Self {
            biaxial_ratio: 1.0,
            meridian_ratio: 0.72,
            meridian_bend: 0.15,
            dilation_angle_deg: 5.0,
            confined_ductility: 3.0,
            crushing_length_mm: 15.0,
        }
    }
}

/// The elastic values of a phase that are given.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Given {
    youngs_modulus_mpa: Option<f64>,
    poisson_ratio: Option<f64>,
    density_t_per_mm3: Option<f64>,
}

/// Given values, and defaults for the rest.
fn over<'de, D: Deserializer<'de>>(usual: Elastic, deserializer: D) -> Result<Elastic, D::Error> {
    let given = Given::deserialize(deserializer)?;
    Ok(Elastic {
        youngs_modulus_mpa: given.youngs_modulus_mpa.unwrap_or(usual.youngs_modulus_mpa),
        poisson_ratio: given.poisson_ratio.unwrap_or(usual.poisson_ratio),
        density_t_per_mm3: given.density_t_per_mm3.unwrap_or(usual.density_t_per_mm3),
    })
}

fn aggregate<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Elastic, D::Error> {
    over(AGGREGATE, deserializer)
}

fn itz<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Elastic, D::Error> {
    over(ITZ, deserializer)
}

fn mortar<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Elastic, D::Error> {
    over(MORTAR, deserializer)
}

fn fibre<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Elastic, D::Error> {
    over(FIBRE, deserializer)
}

impl Elastic {
    /// Speed of dilatational waves, mm/s: sqrt(E (1 - nu) / (rho (1 + nu) (1 - 2 nu))).
    pub fn wave_speed_mm_per_s(&self) -> f64 {
        let (e, nu, rho) = (self.youngs_modulus_mpa, self.poisson_ratio, self.density_t_per_mm3);
        (e * (1.0 - nu) / (rho * (1.0 + nu) * (1.0 - 2.0 * nu))).sqrt()
    }
}

impl Strength {
    /// Compressive stress at which inelastic strain begins, over the strength, in decks and in our laws.
    pub const ELASTIC_LIMIT: f64 = 0.4;

    /// Strengths and energies times `ratio`, at the same peak strain.
    pub(crate) fn scaled(&self, ratio: f64) -> Self {
        Self {
            compressive_mpa: ratio * self.compressive_mpa,
            peak_strain: self.peak_strain,
            tensile_mpa: ratio * self.tensile_mpa,
            fracture_energy_n_per_mm: ratio * self.fracture_energy_n_per_mm,
            crushing_energy_n_per_mm: ratio * self.crushing_energy_n_per_mm,
        }
    }

    /// Cohesion of a Mohr-Coulomb material of these strengths, sqrt(f_c f_t) / 2, MPa.
    pub fn cohesion_mpa(&self) -> f64 {
        (self.compressive_mpa * self.tensile_mpa).sqrt() / 2.0
    }
}

impl Materials {
    /// Stiffness of a cohesive ITZ, E / t, N/mm3: one for opening and sliding, with which shares of the separation are
    /// shares of its energy.
    pub fn separation_stiffness(&self) -> f64 {
        self.itz.youngs_modulus_mpa / self.cohesive_thickness_mm
    }

    /// A cohesive ITZ must be thinner than this, mm: damage begins with f^2 / (2 K) stored, whichever way that is, and
    /// that must be less than its fracture energy in opening.
    pub fn cohesive_thickness_limit_mm(&self, law: LawName) -> f64 {
        let strength = self.itz_strength(law);
        let most = strength.tensile_mpa.max(strength.cohesion_mpa());
        2.0 * self.itz.youngs_modulus_mpa * strength.fracture_energy_n_per_mm / (most * most)
    }

    /// Longest stable time step of cohesive elements in explicit dynamics, s: the root of their mass per area over
    /// their stiffness (Abaqus' own estimate), t sqrt(rho / E) here.
    pub fn cohesive_time_step_s(&self) -> f64 {
        self.cohesive_thickness_mm * (self.itz.density_t_per_mm3 / self.itz.youngs_modulus_mpa).sqrt()
    }

    /// These values as `mesh` has them: a smeared ITZ is mortar of less strength, and as stiff as mortar.
    pub fn in_mesh(&self, mesh: &Mesh) -> Self {
        let itz = if mesh.has_smeared_itz() { self.mortar } else { self.itz };
        Self { itz, ..self.clone() }
    }

    /// The elastic values of one of the `phases`.
    pub fn elastic(&self, phase: Phase, phases: &PhaseNames) -> Elastic {
        match phase {
            Phase::Mortar => self.mortar,
            Phase::Itz => self.itz,
            // No cell is a void.
            Phase::Aggregate | Phase::Void => self.aggregate,
            Phase::Fibre => self.fibre,
            Phase::Own(_) => self.own(phase, phases),
        }
    }

    /// The strength of one of the `phases` as `law` has it; aggregates and fibres have none, those of [`Stone`] are the test's
    /// own.
    pub fn strength(&self, phase: Phase, phases: &PhaseNames, law: LawName) -> Option<Strength> {
        match phase {
            Phase::Aggregate | Phase::Void | Phase::Fibre => None,
            Phase::Own(_) => {
                let ratio = self.own.get(phases.name(phase))?.strength_ratio?;
                Some(self.mortar_strength.of(law).scaled(ratio))
            }
            Phase::Mortar => Some(self.mortar_strength.of(law)),
            Phase::Itz => Some(self.itz_strength(law)),
        }
    }

    /// The strength of the ITZ as `law` has it.
    pub fn itz_strength(&self, law: LawName) -> Strength {
        self.mortar_strength.of(law).scaled(self.itz_strength_ratio)
    }
}

/// More than 1, since stiff neighbours at a soft layer's sides make it stronger and tougher: 1.187 times as tough with the edge
/// itself, at 1.5, 2 and 3 mm.
const BOX: f64 = 1.19;
/// With the edge itself a band three elements wide spends 1.37 to 1.42 of its energy, and a single layer 0.98 to 1.01.
const TETRAHEDRON: f64 = 1.4;
/// For gmsh's tetrahedra: a band of 1.4 edges dissipates 0.90, 0.90 and 0.89 of its energy at 1.5, 2 and 3 mm.
const CONFORMING: f64 = 1.25;

/// Width of a crack band over [`regular_edge`] of a cell of `mesh`; second-order tetrahedra count as two in a row, as Abaqus
/// counts them. Cracking and crushing spend their energies over it, in decks and in our engine.
///
/// A weak layer in a mesh is made as wide as it must be to spend its fracture energy (docs/engine.md): 1.19 edges of a box,
/// 1.4 edges of the regular tetrahedron of the cell's volume in a lattice, 1.25 in a conforming mesh. The edge itself would
/// make three soft boxes 1.7 times, and a band of a lattice in which the crack chooses its way 1.37 to 1.42 times, as tough
/// as asked for.
pub fn band_factor(mesh: &Mesh) -> f64 {
    let tetrahedron = if mesh.notes.conforming { CONFORMING } else { TETRAHEDRON };
    match mesh.kind {
        CellKind::Hexahedron => BOX,
        CellKind::Tetrahedron => tetrahedron,
        CellKind::QuadraticTetrahedron => tetrahedron / 2.0,
    }
}

/// Edge of the cube, or of the regular tetrahedron, that has this volume, mm.
pub fn regular_edge(kind: CellKind, volume_mm3: f64) -> f64 {
    match kind {
        CellKind::Hexahedron => libm::cbrt(volume_mm3),
        _ => libm::cbrt(6.0 * std::f64::consts::SQRT_2 * volume_mm3),
    }
}

/// Width of the crack band in a cell of `mesh` with this volume, mm.
pub fn width_mm(mesh: &Mesh, volume_mm3: f64) -> f64 {
    band_factor(mesh) * regular_edge(mesh.kind, volume_mm3)
}

/// The length over which Abaqus spreads a crack in a cell of this volume, mm: the cube root, of second-order elements half.
pub fn characteristic_mm(kind: CellKind, volume_mm3: f64) -> f64 {
    let across = libm::cbrt(volume_mm3);
    if kind == CellKind::QuadraticTetrahedron { across / 2.0 } else { across }
}
