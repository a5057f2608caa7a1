//! Options of a test: the serde view of `mesocrete solve` and `mesh.solve(...)`.

use crate::error::{SolveError, TEST};
use crate::lanes::InstructionSet;
use meso_concrete::OutOfRange;
use meso_mesh::CellKind;
use serde::{Deserialize, Serialize};

/// A test between rigid plates. Whatever is absent takes its default from the mesh and the kind of test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Test {
    /// Compression or tension.
    pub kind: TestKind,
    /// Coulomb's coefficient between plates and specimen; in tension the plates are glued on.
    pub friction: f64,
    /// Mean axial strain at the end; 0.005 in compression, 0.0005 in tension.
    pub strain: Option<f64>,
    /// Time of the whole test at the plates' full speed, s.
    pub duration_s: Option<f64>,
    /// Time step that mass scaling keeps, s.
    pub time_step_s: Option<f64>,
    /// How the plates keep their speed.
    pub control: Control,
    /// Share of the time in which the plates gain their speed.
    pub ramp: f64,
    /// Rows of the curve, at most, and as densely where the servo adds steps.
    pub rows: u32,
    /// Frames that the observer gets, evenly over the time, and as densely where the servo adds steps; 0 for none.
    pub frames: u32,
    /// The law of mortar and ITZ.
    pub law: LawName,
    /// Strain smoothing; absent, tetrahedra are smoothed over edges, and boxes are not.
    pub smoothing: Option<Smoothing>,
    /// Stiffness of hourglass modes over the true one, 0 to 1 (hexahedra of mortar and ITZ).
    pub hourglass: f64,
    /// Cohesive faces.
    pub interface: Interface,
    /// The instruction set; absent, the machine's best. The results are the same bytes.
    pub instruction_set: Option<InstructionSet>,
}

/// Which way the plates move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum TestKind {
    /// Towards each other, between plates that press and rub.
    Compression,
    /// Apart, glued on.
    Tension,
}

/// How the plates keep their speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Control {
    /// They slow down while the specimen breaks.
    Servo,
    /// Whatever happens, as in a deck.
    Steady,
}

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

/// Where strains belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Smoothing {
    /// Elements, as in a deck.
    None,
    /// Edges of tetrahedra: those around an edge share their mean strain, so that peaks hardly depend on their size.
    Edges,
}

/// Properties of cohesive faces beside `[materials]`, which a deck cannot have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Interface {
    /// Coulomb's coefficient in a crack.
    pub friction: f64,
}

impl Default for Test {
    fn default() -> Self {
        Self {
            kind: TestKind::Compression,
            friction: 0.1,
            strain: None,
            duration_s: None,
            time_step_s: None,
            control: Control::Servo,
            ramp: 0.3,
            rows: 400,
            frames: 0,
            law: LawName::Cdp,
            smoothing: None,
            hourglass: 0.02,
            interface: Interface::default(),
            instruction_set: None,
        }
    }
}

impl Default for Interface {
    /// Illustrative: as in cracks of mortar.
    fn default() -> Self {
        Self { friction: 0.6 }
    }
}

/// Time to 0.5 % of strain per height in compression, s/mm. A cube of 24 mm in elements of 2.5 mm had peaks of 35.7, 35.1,
/// 34.9, 34.7 and 34.6 MPa at 10, 16, 24, 48 and 80e-6, and kinetic over internal energies of 1.2, 0.49, 0.25, 0.06 and
/// 0.02 % after the ramp.
const COMPRESSION_PACE: f64 = 24e-6;
/// Time to 0.5 % of strain per height in tension, s/mm, where strength and strain at the peak are less by an order of magnitude.
const TENSION_PACE: f64 = 160e-6;
/// Least time per height, s/mm: 30 times a sound wave's way. A cylinder of 40 mm that is pressed by 0.02, 0.05, 0.1 and
/// 0.2 % had kinetic energies of 54, 5.8, 1.4 and 0.4 % of the internal one without it
/// (`benches/results/short_tests.csv`).
const LEAST_PACE: f64 = 8e-6;
/// Least strain of a test. Elements compute in single precision: from 2e-4 to 1e-30 a cube's modulus agrees within 3e-7, at
/// 1e-300 it is off by 70 %.
const LEAST_STRAIN: f64 = 1e-12;
/// Time step per element size, s/mm.
const STEP_PER_MM: f64 = 1e-7;

impl Test {
    /// Strain at the end.
    pub fn strain(&self) -> f64 {
        self.strain.unwrap_or(match self.kind {
            TestKind::Compression => 0.005,
            TestKind::Tension => 0.0005,
        })
    }

    /// Time of the whole test on a specimen of this height, s.
    pub fn duration_s(&self, height_mm: f64) -> f64 {
        let pace = match self.kind {
            TestKind::Compression => COMPRESSION_PACE,
            TestKind::Tension => TENSION_PACE,
        };
        self.duration_s.unwrap_or_else(|| (pace * height_mm * self.strain() / 0.005).max(LEAST_PACE * height_mm))
    }

    /// Time step asked for, s; half the default with cohesive faces, which are stiff.
    pub fn time_step_s(&self, element_size_mm: f64, is_cohesive: bool) -> f64 {
        let share = if is_cohesive { 0.5 } else { 1.0 };
        self.time_step_s.unwrap_or(share * STEP_PER_MM * element_size_mm)
    }

    /// Steps of the test at full speed on a specimen of this height, and the length of each, s.
    ///
    /// # Errors
    /// Fewer than 10 steps, and more than 1e9: names the value that makes it so.
    pub fn steps(&self, height_mm: f64, element_size_mm: f64, is_cohesive: bool) -> Result<(u64, f64), SolveError> {
        let duration = self.duration_s(height_mm);
        let step = self.time_step_s(element_size_mm, is_cohesive);
        let steps = (duration / step).ceil();
        if (10.0..=1e9).contains(&steps) {
            return Ok((steps as u64, duration / steps));
        }
        let (key, value) = match self.duration_s {
            Some(duration) if self.time_step_s.is_none() => ("duration_s", duration),
            _ => ("time_step_s", step),
        };
        let accepted = format!("{duration:.3e} s in steps of {step:.3e} s are {steps} steps; they must be 10 to 1e9");
        Err(TEST.error(key, value, accepted).into())
    }

    /// Strain smoothing of a mesh with cells of this `kind`.
    pub(crate) fn smoothing(&self, kind: CellKind) -> Smoothing {
        let usual = if kind == CellKind::Hexahedron { Smoothing::None } else { Smoothing::Edges };
        self.smoothing.unwrap_or(usual)
    }

    /// Checks every value against its range.
    ///
    /// # Errors
    /// The first value out of its range, with the accepted range.
    pub fn validate(&self) -> Result<(), OutOfRange> {
        let strain = self.strain();
        TEST.require(
            "strain",
            strain,
            (LEAST_STRAIN..=0.1).contains(&strain),
            "it must be 1e-12 to 0.1: strains are small, and single precision carries no smaller ones; the test gives the sign",
        )?;
        TEST.require("friction", self.friction, (0.0..=10.0).contains(&self.friction), "it must be 0 to 10")?;
        TEST.require("ramp", self.ramp, (0.01..=1.0).contains(&self.ramp), "it must be 0.01 to 1")?;
        let hourglass = self.hourglass;
        TEST.require(
            "hourglass",
            hourglass,
            (0.0..=1.0).contains(&hourglass),
            "it must be 0 to 1; 0.02 to 0.05 adds no strength",
        )?;
        for (key, value) in [("duration_s", self.duration_s), ("time_step_s", self.time_step_s)] {
            value.map_or(Ok(()), |value| TEST.positive(key, value))?;
        }
        TEST.require("rows", self.rows, (10..=1_000_000).contains(&self.rows), "it must be 10 to 1000000")?;
        TEST.require("frames", self.frames, self.frames <= 10_000, "it must be at most 10000")?;
        self.interface.validate()
    }
}

impl Interface {
    fn validate(&self) -> Result<(), OutOfRange> {
        let friction = self.friction;
        TEST.require("interface.friction", friction, (0.0..=10.0).contains(&friction), "it must be 0 to 10")
    }
}
