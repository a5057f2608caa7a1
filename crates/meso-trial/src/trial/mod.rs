//! Options of a test: the serde view of `mesocrete solve`, of a TEST.toml and of `mesh.solve(...)`.

mod conflict;
mod dispersion;
mod drive;
mod expansion;
mod fast;
mod load;
mod named;
mod recipes;
mod setup;
mod tables;

pub use drive::{Drive, Speed};
pub use expansion::{Below, Course, Expansion, PHASES, STRAINS};
pub use load::{Along, Gauge, MOST_SUPPORTS, OF_PLATES, OF_SUPPORTS, Rule, Side, Strip, SupportSpec, Turn, TurnOf};
pub use named::Rig;
pub use setup::Setup;
pub use setup::word;

use crate::error::{TEST, TrialError};
use crate::sample::Geometry;
use meso_concrete::{OutOfRange, PhysicalRange, written};
use meso_mesh::CellKind;
use meso_mesh::materials::LawName;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::f64::consts::PI;

/// A test of a specimen. Whatever is absent takes its default from the mesh and the kind of test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Test {
    /// The named test, which gives supports, gauges and history unless they are given.
    pub kind: TestKind,
    /// Friction between plates and specimen; in tension the plates are glued on [default: 0.1; 0.5 in splitting]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 10.0)))]
    pub friction: Option<f64>,
    /// Strain at the end [default: by the test; 0.005 in compression, 0.0005 in tension]
    #[cfg_attr(feature = "schema", schemars(range(min = 1e-12, max = 0.1)))]
    pub strain: Option<f64>,
    /// Time of the test at the plates' full speed, s; short ones are not quasi-static [default: by the height and the strain]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub duration_s: Option<f64>,
    /// Time step that mass scaling keeps, s [default: by the element size]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub time_step_s: Option<f64>,
    /// Plates that slow down while the specimen breaks, follow the crack mouth or the lateral strain, or keep their speed as in
    /// a deck [default: servo; steady in real time]
    pub control: Option<Control>,
    /// Share of the time in which the plates gain their speed.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.01, max = 1.0)))]
    pub ramp: f64,
    /// Rows of the curve, at most, and as densely where the servo adds steps.
    #[cfg_attr(feature = "schema", schemars(range(min = 10, max = 1_000_000)))]
    pub rows: u32,
    /// Frames of all fields, evenly over the strain (where the path turns, the time), 0 for none
    #[cfg_attr(feature = "schema", schemars(range(min = 0, max = 10_000)))]
    pub frames: u32,
    /// The law of mortar and ITZ: meso is that of mortar between grains, cdp the twin of a deck, cdpm2 for comparison
    pub law: LawName,
    /// Let the strengths of mortar and ITZ grow with the rate of strain, by the first branch of fib Model Code 2010, 5.1.11 (in real
    /// time, with the law meso).
    pub rate_effect: bool,
    /// Let the specimen begin with the speeds of a uniform strain between two opposite plates that have a speed from the first
    /// moment, so that they send no wave.
    pub starts_moving: bool,
    /// Smooth the strains of tetrahedra, so that peaks hardly depend on their size [default: edges; none for voxels]
    pub smoothing: Option<Smoothing>,
    /// Stiffness of hourglass modes over the true one, 0 to 1 (hexahedra of mortar and ITZ).
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 1.0)))]
    pub hourglass: f64,
    /// Cohesive faces.
    pub interface: Interface,
    /// Lateral pressure of a triaxial test, MPa, negative in tension; 5 where absent. Of a test between bars: on the mantle, or on
    /// the ends of a split specimen; none where absent.
    #[cfg_attr(feature = "schema", schemars(range(min = -100.0, max = 1000.0)))]
    pub pressure_mpa: Option<f64>,
    /// Lateral over axial stress of a biaxial test; 1 where absent.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 10.0)))]
    pub stress_ratio: Option<f64>,
    /// Width of the strips of a splitting test, or of a beam's rollers, mm.
    #[cfg_attr(feature = "schema", schemars(range(min = 1e-3, max = 1e4)))]
    pub strip_mm: Option<f64>,
    /// Distance of a beam's rollers, mm.
    #[cfg_attr(feature = "schema", schemars(range(min = 1e-3, max = 1e4)))]
    pub span_mm: Option<f64>,
    /// Strains of the phases that have no stress; they grow before the path begins. An expansion test without them has 1e-4 in
    /// the aggregates.
    pub expansion: Option<Expansion>,
    /// Speed of the striker, the falling mass or the plate of a test in real time, m/s [default: 8; spall 1, drop 3]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 100.0)))]
    pub speed_m_per_s: Option<f64>,
    /// Length of the pulse of a Hopkinson or spall test at half of its height, s [default: 1e-4; spall 4e-5]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 1.0)))]
    pub pulse_s: Option<f64>,
    /// Time in which the pulse or the plate's speed rises, s: a pulse shaper's [default: 2e-5; spall 5e-6, impact 1e-5]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 1.0)))]
    pub rise_s: Option<f64>,
    /// Mass that falls, kg [default: 1]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 1e6)))]
    pub mass_kg: Option<f64>,
    /// Supports and loads; those of the named test where none are given.
    pub supports: Vec<SupportSpec>,
    /// Places at which the path turns; straight on to `strain` where none are given.
    pub turns: Vec<Turn>,
    /// A CSV file with turns instead, beside the TEST.toml: a column named strain, stress_mpa or opening_mm, a row for each
    /// turn.
    pub history: Option<String>,
    /// Gauges, each a column of the curve; those of the named test where none are given.
    pub gauges: Vec<Gauge>,
}

/// A named test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum TestKind {
    /// Between plates that move towards each other, press and rub.
    Compression,
    /// Between plates that move apart, glued on.
    Tension,
    /// Pressed across strips on two opposite sides.
    Splitting,
    /// A beam on two rollers, pressed by a third.
    Bending,
    /// A beam on two rollers, pressed by two more at its third points.
    FourPoint,
    /// Pressure on all sides, then plates.
    Triaxial,
    /// Two pairs of plates in a ratio of stresses.
    Biaxial,
    /// Plates that press, and turn.
    Cyclic,
    /// Phases that swell or shrink, without a support.
    Expansion,
    /// A double-notched prism, glued to the left half of the upper side and the right half of the lower side, which move past
    /// each other.
    Shear,
    /// Pressed between two steel bars by a pulse that a striker sends along one of them.
    Hopkinson,
    /// Split across strips between two such bars.
    HopkinsonSplitting,
    /// A pulse comes along a steel bar, and its reflection from the free end tears the specimen.
    Spall,
    /// A beam on rollers, or a specimen on a base, that a falling mass strikes.
    Drop,
    /// Pressed by a plate of constant speed.
    Impact,
}

/// How the plates keep their speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Control {
    /// They slow down while the specimen breaks.
    Servo,
    /// The crack mouth opens no faster than in a sound specimen.
    CrackMouth,
    /// The specimen widens no faster than a sound one.
    LateralStrain,
    /// Whatever happens, as in a deck.
    Steady,
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
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 10.0)))]
    pub friction: f64,
}

impl Default for Test {
    fn default() -> Self {
        Self {
            kind: TestKind::Compression,
            friction: None,
            strain: None,
            duration_s: None,
            time_step_s: None,
            control: None,
            ramp: 0.3,
            rows: 400,
            frames: 0,
            law: LawName::Meso,
            rate_effect: false,
            starts_moving: false,
            smoothing: None,
            hourglass: 0.02,
            interface: Interface::default(),
            pressure_mpa: None,
            stress_ratio: None,
            strip_mm: None,
            span_mm: None,
            speed_m_per_s: None,
            pulse_s: None,
            rise_s: None,
            mass_kg: None,
            expansion: None,
            supports: Vec::new(),
            turns: Vec::new(),
            history: None,
            gauges: Vec::new(),
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
/// Time to 0.5 % of strain per diameter in splitting, s/mm: a disc splits at a strain of about 0.1 %.
const SPLITTING_PACE: f64 = 120e-6;
/// Periods of a beam to a flexural strain of 0.2 %: its peak is at a tenth of it. Peaks of seven beams 24, 50 and 80 mm deep (no
/// notch, one of a quarter, of half, off the middle, four points) differ by 0.7 % at most from those of half the duration, which
/// differ by up to 1.9 % from a quarter's, and a beam with a notch of half its depth by 32 % from an eighth's
/// (`benches/results/bending_duration.csv`, `beams.csv`).
const BENDING_PERIODS: f64 = 64.0;
/// Speed of sound in a beam of concrete with some mass added, mm/s.
const SOUND: f64 = 2.5e6;
/// Time in which loads grow before the path begins, per size, s/mm: 40 periods of the slowest wave.
const LEAD_PACE: f64 = 48e-6;
/// Least strain of a test. Elements compute in single precision: from 2e-4 to 1e-30 a cube's modulus agrees within 3e-7, at
/// 1e-300 it is off by 70 %.
const LEAST_STRAIN: f64 = 1e-12;
/// Time step per element size, s/mm.
const STEP_PER_MM: f64 = 1e-7;

/// Lateral pressure of a test; tension is negative.
const LATERAL: PhysicalRange =
    PhysicalRange { least: -100.0, most: 1000.0, unit: "MPa", others: PhysicalRange::STRESSES };

impl Test {
    /// Strain at the end.
    pub fn strain(&self) -> f64 {
        let of_turn = |turn: &Turn| if turn.of == TurnOf::Strain { turn.at.abs() } else { 0.0 };
        let turned = self.turns().iter().map(of_turn).fold(0.0, f64::max);
        self.strain.unwrap_or(match self.kind {
            _ if turned > 0.0 => turned,
            TestKind::Compression | TestKind::Biaxial | TestKind::Cyclic | TestKind::Expansion => 0.005,
            TestKind::Triaxial => 0.01,
            TestKind::Tension => 0.0005,
            TestKind::Splitting => 0.0015,
            TestKind::Bending | TestKind::FourPoint => 0.006,
            TestKind::Shear => 0.002,
            _ => Self::LARGEST_STRAIN,
        })
    }

    /// Time of the whole path on a specimen of these measures, s.
    pub fn duration_s(&self, geometry: &Geometry) -> f64 {
        let [length_mm, _, height_mm] = geometry.size_mm;
        let paced = |pace: f64, size_mm: f64| (pace * size_mm * self.strain() / 0.005).max(LEAST_PACE * size_mm);
        self.duration_s.unwrap_or_else(|| match self.kind {
            TestKind::Tension => paced(TENSION_PACE, height_mm),
            TestKind::Splitting => paced(SPLITTING_PACE, length_mm),
            TestKind::Shear => paced(SPLITTING_PACE, height_mm),
            TestKind::Bending | TestKind::FourPoint => {
                BENDING_PERIODS * self.period_s(geometry) * (self.strain() / 0.002).max(0.25)
            }
            TestKind::Expansion => LEAST_PACE * height_mm,
            _ if self.kind.is_fast() => self.fast_duration_s(geometry),
            _ => paced(COMPRESSION_PACE, height_mm),
        })
    }

    /// Longest period of a beam between its rollers, s.
    fn period_s(&self, geometry: &Geometry) -> f64 {
        let (span, height) = (self.span_mm(geometry), geometry.size_mm[2] - geometry.notch_mm);
        2.0 * span * span / (PI * SOUND * height / 12.0_f64.sqrt())
    }

    /// Time step asked for, s; half the default with cohesive faces, which are stiff.
    pub fn time_step_s(&self, element_size_mm: f64, is_cohesive: bool) -> f64 {
        let share = if is_cohesive { 0.5 } else { 1.0 };
        self.time_step_s.unwrap_or(share * STEP_PER_MM * element_size_mm)
    }

    /// Steps of the path at full speed on a specimen of these measures, and the length of each, s.
    ///
    /// # Errors
    /// Fewer than 10 steps, and more than 1e9: names the value that makes it so.
    pub fn steps(
        &self,
        geometry: &Geometry,
        element_size_mm: f64,
        is_cohesive: bool,
    ) -> Result<(u64, f64), TrialError> {
        let duration = self.duration_s(geometry);
        let step = self.time_step_s(element_size_mm, is_cohesive);
        let steps = (duration / step).ceil();
        if (10.0..=1e9).contains(&steps) {
            return Ok((steps as u64, duration / steps));
        }
        let (key, value) = match self.duration_s {
            Some(duration) if self.time_step_s.is_none() => ("duration_s", duration),
            _ => ("time_step_s", step),
        };
        let many = written(steps);
        let accepted = format!("{duration:.3e} s in steps of {step:.3e} s are {many} steps; they must be 10 to 1e9");
        Err(TEST.error(key, value, accepted).into())
    }

    /// Time in which loads grow before the path begins, s; 0 without loads that do.
    pub fn lead_s(&self, geometry: &Geometry, is_pressed: bool) -> f64 {
        let has_lead = is_pressed || self.expansion().is_some();
        if has_lead { LEAD_PACE * geometry.size_mm.into_iter().fold(0.0, f64::max) } else { 0.0 }
    }

    /// Whether a path moves a support.
    pub fn has_path(&self) -> bool {
        !self.is_fast()
            && (self.kind != TestKind::Expansion || self.supports.iter().any(|support| support.moves != 0.0))
    }

    /// Whether plates of the named test rub, so that its friction has an effect.
    pub fn rubs(&self) -> bool {
        let is_glued = matches!(
            self.kind,
            TestKind::Tension | TestKind::Shear | TestKind::Expansion | TestKind::Spall | TestKind::Drop
        );
        !is_glued && !self.kind.is_beam() && self.supports.is_empty()
    }

    /// Strains of the phases that have no stress, if the test has any.
    pub fn expansion(&self) -> Option<Expansion> {
        let usual = Expansion { aggregate: named::SWELLING.into(), ..Expansion::default() };
        self.expansion.clone().or((self.kind == TestKind::Expansion).then_some(usual))
    }

    /// Places at which the path turns.
    pub fn turns(&self) -> Vec<Turn> {
        if self.kind == TestKind::Cyclic && self.turns.is_empty() {
            return named::cycles(self.strain.unwrap_or(0.005));
        }
        self.turns.clone()
    }

    /// How the plates keep their speed.
    pub fn control(&self) -> Control {
        self.control.unwrap_or(if self.is_fast() { Control::Steady } else { Control::Servo })
    }

    /// Gauges of the test, with the one that controls it.
    pub fn gauges(&self) -> Vec<Gauge> {
        let mut gauges = if self.gauges.is_empty() { named::gauges(self.kind) } else { self.gauges.clone() };
        if let Some(own) = self.control().gauge().filter(|own| gauges.iter().all(|gauge| !own.is_like(gauge))) {
            gauges.push(own);
        }
        gauges
    }

    /// Place of the gauge that controls the path, among all gauges.
    pub fn leader(&self) -> Option<usize> {
        self.control().gauge().and_then(|own| self.gauges().iter().position(|gauge| own.is_like(gauge)))
    }

    /// Whether the curve has columns of gauges and supports.
    pub fn has_extra(&self) -> bool {
        let is_plain = matches!(self.kind, TestKind::Compression | TestKind::Tension);
        !(is_plain
            && self.control().gauge().is_none()
            && self.expansion.is_none()
            && self.supports.is_empty()
            && self.gauges.is_empty()
            && self.turns.is_empty())
    }

    /// Strain smoothing of a mesh with cells of this `kind`.
    pub fn smoothing(&self, kind: CellKind) -> Smoothing {
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
        TEST.require("friction", self.friction(), (0.0..=10.0).contains(&self.friction()), "it must be 0 to 10")?;
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
        self.validate_kind()?;
        self.validate_loads()?;
        self.validate_named_fast()?;
        self.validate_fast()?;
        self.validate_turns()?;
        self.interface.validate()
    }
}

impl Test {
    /// Refuses values that the named test does not have.
    fn validate_kind(&self) -> Result<(), OutOfRange> {
        use TestKind::{Hopkinson, HopkinsonSplitting, Triaxial};
        let pressed = matches!(self.kind, Triaxial | Hopkinson | HopkinsonSplitting);
        let (split, bent) = (self.kind.splits(), self.kind.is_beam() || self.kind == TestKind::Drop);
        for (key, value, has, of) in [
            ("pressure_mpa", self.pressure_mpa, pressed, "triaxial, hopkinson and hopkinson-splitting"),
            ("stress_ratio", self.stress_ratio, self.kind == TestKind::Biaxial, "biaxial"),
            ("strip_mm", self.strip_mm, bent || split, "splitting, hopkinson-splitting, bending and drop"),
            ("span_mm", self.span_mm, bent, "bending and drop"),
        ] {
            let accepted = format!("only {of} tests take it; leave it out, or take that kind of test");
            TEST.require(key, value.unwrap_or_default(), has || value.is_none(), accepted)?;
        }
        let rubs = self.friction.is_none() || self.rubs();
        TEST.require("friction", self.friction.unwrap_or_default(), rubs, "only tests whose plates rub take it")?;
        let widens = self.control() != Control::LateralStrain || self.presses() || !self.supports.is_empty();
        TEST.require("control", word(&self.control()), widens, "only tests that press a specimen all through take it")
    }

    /// Whether plates of the named test press a specimen all through.
    fn presses(&self) -> bool {
        use TestKind::{Biaxial, Compression, Cyclic, Splitting, Triaxial};
        matches!(self.kind, Compression | Triaxial | Biaxial | Cyclic | Splitting)
    }

    fn validate_turns(&self) -> Result<(), OutOfRange> {
        let is_glued = matches!(self.kind, TestKind::Tension | TestKind::Shear) || !self.supports.is_empty();
        for turn in &self.turns {
            let Turn { at, of } = *turn;
            let is_seen = of != TurnOf::Strain || at == 0.0 || at.abs() >= LEAST_STRAIN;
            TEST.require(
                "turns.at",
                at,
                at.is_finite() && is_seen,
                "it must be a number, a strain 0 or 1e-12 at least",
            )?;
            let why = "plates that press cannot pull; take 0 or more";
            TEST.require("turns.at", at, is_glued || at >= 0.0, why)?;
            let strain = self.strain.filter(|_| of == TurnOf::Strain).unwrap_or(f64::INFINITY);
            let why = format!("the test goes no further than its strain, {strain}; raise that, or leave it out");
            TEST.require("turns.at", at, at.abs() <= strain, why)?;
        }
        Ok(())
    }

    fn validate_loads(&self) -> Result<(), OutOfRange> {
        let within = |key: &str, value: Option<f64>, least: f64, most: f64| {
            let met = value.is_none_or(|value| (least..=most).contains(&value));
            TEST.require(key, value.unwrap_or_default(), met, format!("it must be {least} to {most}"))
        };
        if let Some(pressure) = self.pressure_mpa {
            TEST.require("pressure_mpa", pressure, LATERAL.has(pressure), LATERAL.refusal(pressure))?;
        }
        within("stress_ratio", self.stress_ratio, 0.0, 10.0)?;
        for (key, value) in [("strip_mm", self.strip_mm), ("span_mm", self.span_mm)] {
            within(key, value, 1e-3, load::WIDEST_MM)?;
        }
        self.expansion.as_ref().map_or(Ok(()), Expansion::validate)?;
        if let Some(name) = &self.history {
            let why = "only a TEST.toml and Python read a table, and have no turns then; give the turns";
            return Err(TEST.error("history", name, why));
        }
        let (count, most) = (self.supports.len(), load::MOST_SUPPORTS);
        TEST.require("supports", count, count <= most, format!("at most {most} supports are taken"))?;
        self.supports.iter().try_for_each(SupportSpec::validate)?;
        conflict::validate(&self.supports)?;
        self.gauges.iter().try_for_each(Gauge::validate)?;
        let gauges = self.gauges.iter().map(|gauge| ("gauges.name", gauge.name()));
        let supports = self.supports.iter().map(|support| ("supports.name", &*support.name));
        let mut seen = HashSet::new();
        let twice = gauges.chain(supports).find(|(_, name)| !seen.insert(*name));
        twice.map_or(Ok(()), |(key, name)| Err(TEST.error(key, name, "names of gauges and supports must differ")))
    }
}

impl TestKind {
    /// Whether it bends a beam.
    pub fn is_beam(self) -> bool {
        matches!(self, Self::Bending | Self::FourPoint)
    }
}

impl Control {
    /// The gauge that controls the path.
    fn gauge(self) -> Option<Gauge> {
        match self {
            Self::Steady | Self::Servo => None,
            Self::CrackMouth => Some(Gauge::mouth()),
            Self::LateralStrain => Some(Gauge::LateralStrain { name: "lateral_strain".to_owned() }),
        }
    }
}

impl Interface {
    fn validate(&self) -> Result<(), OutOfRange> {
        let friction = self.friction;
        TEST.require("interface.friction", friction, (0.0..=10.0).contains(&friction), "it must be 0 to 10")
    }
}
