//! Supports, loads, turns and gauges of a test, as a user writes them.

use crate::error::TEST;
use crate::trial::drive::Drive;
use meso_concrete::{OutOfRange, PhysicalRange};
use serde::{Deserialize, Serialize};

/// A side of the specimen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Lower side across x.
    XMin,
    /// Upper side across x.
    XMax,
    /// Lower side across y.
    YMin,
    /// Upper side across y.
    YMax,
    /// Lower side across z.
    ZMin,
    /// Upper side across z.
    ZMax,
    /// Whole surface without the two sides across z. Only `pressure` can act on it.
    Mantle,
}

impl Side {
    /// Its number among the sides of a mesh; the mantle has none.
    pub fn bit(self) -> Option<usize> {
        (self != Self::Mantle).then_some(self as usize)
    }
}

/// An axis of the specimen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Along {
    /// Along x.
    X,
    /// Along y.
    Y,
    /// Along z.
    Z,
}

/// The action of a support on the nodes that it meets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// A rigid plate presses and rubs; the specimen may lift off.
    #[default]
    Plate,
    /// A rigid plate is glued on.
    Glued,
    /// Dead forces press on the faces.
    Pressure,
}

/// A strip across a side: a roller, or the strip of a splitting test.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Strip {
    /// Axis along which its width and its place are measured.
    pub axis: Along,
    /// Its centre, mm from the middle of the specimen.
    #[cfg_attr(feature = "schema", schemars(range(min = -1e4, max = 1e4)))]
    pub at_mm: f64,
    /// Its width, mm; at least one and a half elements are taken.
    #[cfg_attr(feature = "schema", schemars(range(min = 1e-3, max = 1e4)))]
    pub width_mm: f64,
    /// Its length across that axis, mm, from its middle on the middle of the side; absent, it crosses the whole side.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1e-3, max = 1e4)))]
    pub length_mm: Option<f64>,
}

impl Strip {
    /// A strip across a whole side.
    pub fn new(axis: Along, at_mm: f64, width_mm: f64) -> Self {
        Self { axis, at_mm, width_mm, length_mm: None }
    }

    /// Its ends along an axis of its side, mm from the middle; both of its measures are `least` mm at least.
    pub fn ends_mm(&self, axis: usize, least: f64) -> [f64; 2] {
        let [at, size] = if self.axis as usize == axis {
            [self.at_mm, self.width_mm]
        } else {
            [0.0, self.length_mm.unwrap_or(f64::MAX)]
        };
        [at - 0.5 * size.max(least), at + 0.5 * size.max(least)]
    }
}

/// A support or a load of a specimen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SupportSpec {
    /// Its name, which its column of `curve.csv` has.
    pub name: String,
    /// The side that it acts on.
    pub on: Side,
    /// The part of the side; absent, it is the whole side.
    #[serde(default)]
    pub strip: Option<Strip>,
    /// Plate, glued or pressure.
    #[serde(default)]
    pub rule: Rule,
    /// Coulomb's coefficient of a plate.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 10.0)))]
    pub friction: f64,
    /// Its way along the axis of its side for each mm of the test's path; 0 keeps it at rest.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(range(min = -1.0, max = 1.0)))]
    pub moves: f64,
    /// Pressure, or the mean stress that a servo gives a plate before the path begins, MPa. It grows to this value before
    /// the path begins.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(range(min = -1000.0, max = 1000.0)))]
    pub pressure_mpa: f64,
    /// Mean stress that a servo gives a plate over the stress of the test.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 10.0)))]
    pub stress_ratio: Option<f64>,
    /// What moves a plate in real time; the test has no path then: `{ kind = "speed" }`, `"bar"` or `"mass"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive: Option<Drive>,
}

/// Ends of the columns of a support: its force, its speed towards the specimen, and the stresses of the waves that run in its
/// bar to the specimen and from it.
pub const OF_SUPPORTS: [&str; 4] = ["_n", "_m_per_s", "_in_mpa", "_out_mpa"];

/// Columns of a test in real time between two plates: the rate of strain, and the stress of the lower one less that of the upper
/// one over their mean.
pub const OF_PLATES: [&str; 2] = ["rate_per_s", "equilibrium"];

/// Supports of a test, at most.
pub const MOST_SUPPORTS: usize = 8;

/// Widest strip and longest span, mm.
pub(super) const WIDEST_MM: f64 = 1e4;

/// Checks a name that a column of `curve.csv` has.
fn column(key: &str, name: &str) -> Result<(), OutOfRange> {
    let met = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    TEST.require(key, name, met, "it must be letters, digits and _: a column has it")
}

/// Pressure on a side; tension is negative.
const PRESSURE: PhysicalRange =
    PhysicalRange { least: -1000.0, most: 1000.0, unit: "MPa", others: PhysicalRange::STRESSES };

impl SupportSpec {
    /// Checks every value against its range.
    pub fn validate(&self) -> Result<(), OutOfRange> {
        let named = |key: &str| format!("supports.{}.{key}", self.name);
        column("supports.name", &self.name)?;
        TEST.require(named("friction"), self.friction, (0.0..=10.0).contains(&self.friction), "it must be 0 to 10")?;
        let (moves, is_seen) = (self.moves.abs(), self.moves == 0.0 || self.moves.abs() >= 1e-6);
        TEST.require(named("moves"), self.moves, moves <= 1.0 && is_seen, "it must be 0, or 1e-6 to 1 either way")?;
        if let Some(ratio) = self.stress_ratio {
            TEST.require(named("stress_ratio"), ratio, (0.0..=10.0).contains(&ratio), "it must be 0 to 10")?;
        }
        if let Some(Strip { at_mm, width_mm, length_mm, .. }) = self.strip {
            TEST.require(named("strip.at_mm"), at_mm, at_mm.abs() <= WIDEST_MM, "it must be -1e4 to 1e4")?;
            for (key, value) in [("strip.width_mm", width_mm), ("strip.length_mm", length_mm.unwrap_or(width_mm))] {
                TEST.require(named(key), value, (1e-3..=WIDEST_MM).contains(&value), "it must be 1e-3 to 1e4")?;
            }
        }
        let pressure = self.pressure_mpa;
        TEST.require(named("pressure_mpa"), pressure, PRESSURE.has(pressure), PRESSURE.refusal(pressure))?;
        self.validate_drive()?;
        self.validate_effects()?;
        let on_faces = self.rule == Rule::Pressure || self.on != Side::Mantle;
        TEST.require(named("on"), "mantle", on_faces, "only a pressure acts on the mantle; take one of the six sides")
    }

    /// Refuses keys without effect under its rule.
    fn validate_effects(&self) -> Result<(), OutOfRange> {
        let named = |key: &str| format!("supports.{}.{key}", self.name);
        let (is_plate, presses) = (self.rule == Rule::Plate, self.rule == Rule::Pressure);
        let free = "only a plate rubs; leave it out, or take rule = \"plate\"";
        TEST.require(named("friction"), self.friction, is_plate || self.friction == 0.0, free)?;
        let dead = "a pressure follows no path; leave it out, or take rule = \"plate\"";
        TEST.require(named("moves"), self.moves, !presses || self.moves == 0.0, dead)?;
        let (ratio, has_ratio) = (self.stress_ratio.unwrap_or_default(), self.stress_ratio.is_some());
        TEST.require(named("stress_ratio"), ratio, !presses || !has_ratio, dead)?;
        let both = "a plate follows a stress or the path; leave moves out, or stress_ratio";
        TEST.require(named("moves"), self.moves, !has_ratio || self.moves == 0.0, both)?;
        let pulls = "a plate cannot pull; take 0 or more, or rule = \"glued\"";
        TEST.require(named("pressure_mpa"), self.pressure_mpa, !is_plate || self.pressure_mpa >= 0.0, pulls)?;
        let is_whole = self.strip.is_none() || !presses && !has_ratio && self.pressure_mpa == 0.0;
        let whole =
            "a pressure and a servo act on a whole side; leave the strip out, or the pressure and the stress ratio";
        TEST.require(named("strip"), "given", is_whole, whole)
    }

    /// Finds out whether its strip lies on a specimen of this size.
    pub fn suits(&self, size_mm: &[f64; 3]) -> Result<(), OutOfRange> {
        let Some(Strip { axis, at_mm, width_mm, length_mm }) = self.strip else { return Ok(()) };
        let across = (0..3).filter(|&k| k != axis as usize && Some(k) != self.on.bit().map(|bit| bit / 2));
        let side = across.map(|k| size_mm[k]).fold(f64::INFINITY, f64::min);
        let key = format!("supports.{}.strip.length_mm", self.name);
        let why = format!("the side is {side} mm long there; leave it out for a strip across the whole side");
        TEST.require(key, length_mm.unwrap_or_default(), length_mm.is_none_or(|length| length <= side), why)?;
        let half = 0.5 * size_mm[axis as usize];
        let why = format!("the strip lies beside the specimen, which reaches from {} to {half} mm", -half);
        let key = format!("supports.{}.strip.at_mm", self.name);
        TEST.require(key, at_mm, at_mm.abs() < half + 0.5 * width_mm, why)
    }
}

/// A quantity that a turn is given in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum TurnOf {
    /// Strain of the test: the path over its length.
    #[default]
    Strain,
    /// Stress of the test, MPa.
    Stress,
    /// Opening of the crack mouth, mm.
    Opening,
}

/// A place at which the path turns.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Turn {
    /// The value at which it turns.
    pub at: f64,
    /// The quantity of the value.
    #[serde(default)]
    pub of: TurnOf,
}

/// A gauge: a column of `curve.csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case", tag = "kind", deny_unknown_fields)]
pub enum Gauge {
    /// Strain between two planes across an axis, from the mean displacements of the surface's nodes near them.
    Lvdt {
        /// Name of the column.
        name: String,
        /// The axis along which it measures.
        axis: Along,
        /// The lower plane, mm from the lower side.
        from_mm: f64,
        /// The upper plane, mm from the lower side.
        to_mm: f64,
    },
    /// Strain from the mean displacements of two opposite sides.
    Sides {
        /// Name of the column.
        name: String,
        /// The axis along which it measures.
        axis: Along,
    },
    /// Displacement of a side along its axis, mm, positive out of the specimen: its mean by area.
    Side {
        /// Name of the column.
        name: String,
        /// The side, not the mantle.
        on: Side,
    },
    /// Momentum along an axis of the part between two planes across it, N s, e.g. of what a pulse throws off.
    Part {
        /// Name of the column.
        name: String,
        /// The axis.
        axis: Along,
        /// The lower plane, mm from the lower side.
        from_mm: f64,
        /// The upper plane, mm from the lower side.
        to_mm: f64,
    },
    /// Lateral strain: the mean of both axes across the load, from the sides' nodes in the middle half of the height.
    LateralStrain {
        /// Name of the column.
        name: String,
    },
    /// Opening of the crack mouth at the lower side of a beam, mm.
    CrackMouth {
        /// Name of the column.
        name: String,
        /// Gauge length along the lower side, mm; absent, it is the notch's, or the depth of a beam without one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[cfg_attr(feature = "schema", schemars(range(min = 1e-3, max = 1e4)))]
        over_mm: Option<f64>,
    },
}

impl Gauge {
    /// The crack mouth of a beam, in the column `crack_mouth_mm`.
    pub(super) fn mouth() -> Self {
        Self::CrackMouth { name: "crack_mouth_mm".to_owned(), over_mm: None }
    }

    /// Whether another gauge is of its kind.
    pub fn is_like(&self, other: &Self) -> bool {
        std::mem::discriminant(self) == std::mem::discriminant(other)
    }

    /// Checks its name.
    pub fn validate(&self) -> Result<(), OutOfRange> {
        column("gauges.name", self.name())?;
        if let Self::Side { name, on: Side::Mantle } = self {
            let why = "it must be one of the six sides: the mantle has no axis";
            return Err(TEST.error(format!("gauges.{name}.on"), "mantle", why));
        }
        let met = OF_SUPPORTS.iter().all(|end| !self.name().ends_with(end));
        TEST.require(
            "gauges.name",
            self.name(),
            met,
            format!("it must not end in {}, as columns of supports do", OF_SUPPORTS.join(", ")),
        )
    }

    /// Finds out whether a specimen of this size has its planes.
    pub fn suits(&self, size_mm: &[f64; 3]) -> Result<(), OutOfRange> {
        if let Self::CrackMouth { name, over_mm: Some(over) } = self {
            let why = format!("the specimen is {} mm long; take a gauge that lies on it", size_mm[0]);
            return TEST.require(format!("gauges.{name}.over_mm"), *over, *over > 0.0 && *over < size_mm[0], why);
        }
        let (Self::Lvdt { name, axis, from_mm, to_mm } | Self::Part { name, axis, from_mm, to_mm }) = self else {
            return Ok(());
        };
        let size = size_mm[*axis as usize];
        if 0.0 <= *from_mm && from_mm < to_mm && *to_mm <= size {
            return Ok(());
        }
        let planes = format!("{from_mm} to {to_mm}");
        let why = format!("the specimen is {size} mm long there; take planes from 0 to {size} mm, the lower one first");
        Err(TEST.error(format!("gauges.{name}"), planes, why))
    }

    /// Name of its column.
    pub fn name(&self) -> &str {
        let (Self::Lvdt { name, .. }
        | Self::Sides { name, .. }
        | Self::Side { name, .. }
        | Self::Part { name, .. }
        | Self::LateralStrain { name }
        | Self::CrackMouth { name, .. }) = self;
        name
    }
}
