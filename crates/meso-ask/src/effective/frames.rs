//! The frames of a test that a property is asked of, and what the test says of them.

use super::PhaseTables;
use crate::{AskError, Giver};
use meso_concrete::{Phase, PhaseNames};
use meso_core::mesh::Mesh;
use meso_effective::{At, Cracked};
use meso_solve::results::{Moment, Snapshot, Unread};
use meso_solve::{PhaseResult, Response};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt::{self, Display, Formatter};

const WANTED: &str = "peak, last, all, the number of a frame from 1, or a strain below 1, as in 0.002";

/// Which frames of a test.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum FramePick {
    /// The one of the largest stress.
    #[default]
    Peak,
    /// The last one.
    Last,
    /// Each.
    All,
    /// The one of this number, from 1.
    Number(u32),
    /// The nearest one to this strain.
    Strain(f64),
}

/// Whether a number is a strain, and not the number of a frame.
fn is_strain(number: &f64) -> bool {
    *number > 0.0 && *number < 1.0
}

impl FramePick {
    /// Reads a flag.
    ///
    /// # Errors
    /// What it must be.
    pub fn read(text: &str) -> Result<Self, String> {
        let number = || text.parse().ok().filter(|number| *number > 0).map(Self::Number);
        let strain = || text.parse().ok().filter(is_strain).map(Self::Strain);
        let named = match text {
            "peak" => Some(Self::Peak),
            "last" => Some(Self::Last),
            "all" => Some(Self::All),
            _ => None,
        };
        named.or_else(number).or_else(strain).ok_or_else(|| format!("it must be {WANTED}"))
    }
}

impl Display for FramePick {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Peak => out.write_str("peak"),
            Self::Last => out.write_str("last"),
            Self::All => out.write_str("all"),
            Self::Number(number) => number.fmt(out),
            Self::Strain(strain) => strain.fmt(out),
        }
    }
}

impl Serialize for FramePick {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Number(number) => to.serialize_u32(*number),
            Self::Strain(strain) => to.serialize_f64(*strain),
            named => to.collect_str(named),
        }
    }
}

impl<'de> Deserialize<'de> for FramePick {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_any(WordOrNumber)
    }
}

struct WordOrNumber;

impl Visitor<'_> for WordOrNumber {
    type Value = FramePick;

    fn expecting(&self, out: &mut Formatter<'_>) -> fmt::Result {
        out.write_str(WANTED)
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<FramePick, E> {
        FramePick::read(text).map_err(|_| E::invalid_value(Unexpected::Str(text), &self))
    }

    fn visit_i64<E: de::Error>(self, number: i64) -> Result<FramePick, E> {
        FramePick::read(&number.to_string()).map_err(|_| E::invalid_value(Unexpected::Signed(number), &self))
    }

    fn visit_u64<E: de::Error>(self, number: u64) -> Result<FramePick, E> {
        FramePick::read(&number.to_string()).map_err(|_| E::invalid_value(Unexpected::Unsigned(number), &self))
    }

    fn visit_f64<E: de::Error>(self, strain: f64) -> Result<FramePick, E> {
        if is_strain(&strain) {
            Ok(FramePick::Strain(strain))
        } else {
            Err(E::invalid_value(Unexpected::Float(strain), &self))
        }
    }
}

impl JsonSchema for FramePick {
    fn schema_name() -> Cow<'static, str> {
        "FramePick".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": ["string", "number"] })
    }
}

/// What a test says of its frames: a part of `result.json`.
#[derive(Clone, Debug, Deserialize)]
pub struct RunRecord {
    elements: usize,
    cohesive_elements: usize,
    #[serde(default)]
    peak_mpa: Option<f64>,
    frames: Vec<Moment>,
    phases: Vec<PhaseResult>,
}

/// Stress of a frame over the peak's, below which it is not the peak's.
const NEAR: f64 = 0.98;
/// A strain over the largest one that still names its frame.
const SLACK: f64 = 1.001;
/// Share of voids that is rounding.
const ROUNDING: f64 = 1e-6;

impl RunRecord {
    /// Of a test in memory, with its frames.
    pub fn of(response: &Response, frames: Vec<Moment>) -> Self {
        let result = &response.result;
        Self {
            elements: result.elements,
            cohesive_elements: result.cohesive_elements,
            peak_mpa: Some(result.figures.peak_mpa),
            frames,
            phases: result.phases.clone(),
        }
    }

    /// Of the text of a `result.json`.
    ///
    /// # Errors
    /// Another file.
    pub fn read(text: &str) -> Result<Self, String> {
        serde_json::from_str(text).map_err(|error| format!("it is no result of `mesocrete solve`: {error}"))
    }

    /// The frames that are asked for, in their order.
    ///
    /// # Errors
    /// A test without frames, or without such a one, and one whose cracks its frames lack.
    pub fn choose(&self, pick: FramePick, giver: Giver<'_>) -> Result<Vec<Moment>, AskError> {
        let refused =
            |accepted: String| Err(AskError::Usage(format!("{} is {pick}; {accepted}", giver.option("frame"))));
        if self.cohesive_elements > 0 {
            let itz = giver.option("itz");
            let why = "the ITZ of the test is cohesive faces, and its frames have no openings of them";
            return Err(AskError::Usage(format!("{why}; solve it with {itz} solid, smeared or none")));
        }
        let (Some(first), Some(last)) = (self.frames.first(), self.frames.last()) else {
            return refused(format!("the test has no frames; solve it again with {} 20", giver.option("frames")));
        };
        let nearest = |off: &dyn Fn(&Moment) -> f64| {
            // The first of equal ones.
            self.frames.iter().fold(first, |best, other| if off(other) < off(best) { other } else { best })
        };
        Ok(match pick {
            FramePick::All => self.frames.clone(),
            FramePick::Last => vec![*last],
            FramePick::Peak => vec![*nearest(&|frame| -frame.stress_mpa)],
            FramePick::Number(number) => match self.frames.iter().find(|frame| frame.number == number) {
                Some(frame) => vec![*frame],
                None => return refused(format!("the test has frames {} to {}", first.number, last.number)),
            },
            FramePick::Strain(strain) => {
                let most = self.frames.iter().map(|frame| frame.strain).fold(0.0, f64::max);
                if strain > SLACK * most {
                    return refused(format!("the frames reach a strain of {most:.5}"));
                }
                vec![*nearest(&|frame| (frame.strain - strain).abs())]
            }
        })
    }

    /// The values of the phases; elastic constants that are not given are those of the test.
    pub fn values(&self, mut values: PhaseTables) -> PhaseTables {
        if let PhaseTables::Packing(phases) = &mut values {
            let names = self.names();
            for phase in self.phases.iter().filter(|phase| phase.youngs_modulus_mpa > 0.0) {
                if names.find(&phase.name).is_some() {
                    phases.stiffness.own.entry(phase.name.clone()).or_default();
                }
                if let Some(moduli) = phases.stiffness.phase_mut(&phase.name) {
                    moduli.youngs_modulus_mpa.get_or_insert(phase.youngs_modulus_mpa);
                    moduli.poisson_ratio.get_or_insert(phase.poisson_ratio);
                }
            }
        }
        values
    }

    /// Doubt about a frame that stands for the peak.
    pub fn doubt(&self, pick: FramePick, frame: &Moment, giver: Giver<'_>) -> Option<String> {
        let share = frame.stress_mpa / self.peak_mpa?;
        (pick == FramePick::Peak && share < NEAR).then(|| {
            let (number, more) = (frame.number, giver.option("frames"));
            let percent = 100.0 * share;
            format!("frame {number}, the nearest to the peak, has {percent:.0} % of its stress; solve with more {more}")
        })
    }

    /// Reads a frame's file.
    ///
    /// # Errors
    /// A file that is no frame of this test, or that was changed.
    pub fn frame(&self, moment: Moment, bytes: &[u8]) -> Result<(Mesh, Snapshot), String> {
        let (mesh, snapshot) = Snapshot::read(moment, bytes).map_err(|error| match error {
            Unread::Missing(_) => format!("{error}; solve the test again with this version"),
            Unread::Foreign | Unread::Damaged(_) => format!("{error}; solve the test again"),
        })?;
        let (found, expected) = (mesh.cell_count(), self.elements);
        if found != expected {
            return Err(format!("it has {found} cells, and those of this test have {expected}; solve the test again"));
        }
        let phases = self.names();
        if mesh.phase.iter().any(|phase| phase.index() >= phases.count()) {
            return Err("it has phases that the results of this test do not name; solve the test again".to_owned());
        }
        if !snapshot.is_of_its_moment() {
            let why = match moment.seal {
                Some(_) => "it is a frame of another test, or it was changed; solve the test again",
                None => "the results of this test have no seal of it; solve the test again with this version",
            };
            return Err(why.to_owned());
        }
        Ok((Mesh { phases, ..mesh }, snapshot))
    }

    /// The phases of the test.
    fn names(&self) -> PhaseNames {
        let is_common = |name: &str| Phase::ALL.into_iter().any(|phase| PhaseNames::COMMON.name(phase) == name);
        self.phases.iter().map(|phase| phase.name.clone()).filter(|name| !is_common(name)).collect()
    }

    /// A frame as a mesh with cracks.
    pub fn cracked<'a>(&self, mesh: &'a Mesh, frame: &'a Snapshot) -> Cracked<'a> {
        let Moment { number, strain, stress_mpa, .. } = frame.moment;
        let exact: Option<f64> = self.phases.iter().map(|phase| phase.exact_fraction).sum();
        // A test leaves voids out.
        let filled = exact.filter(|filled| *filled > 0.0 && *filled < 1.0 - ROUNDING).unwrap_or(1.0);
        Cracked {
            mesh,
            crack_strain: &frame.crack_strain,
            opening_mm: &frame.opening_mm,
            stiffness_left: &frame.stiffness_left,
            filled,
            at: At { frame: Some(number), strain: Some(strain), stress_mpa: Some(stress_mpa) },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(stresses: &[f64]) -> RunRecord {
        let frame = |(number, stress): (usize, &f64)| {
            let strain = 0.001 * (number + 1) as f64;
            Moment { number: number as u32 + 1, strain, stress_mpa: *stress, ..Moment::default() }
        };
        let frames = stresses.iter().enumerate().map(frame).collect();
        RunRecord { elements: 1, cohesive_elements: 0, peak_mpa: Some(40.0), frames, phases: Vec::new() }
    }

    #[test]
    fn frames_are_chosen_by_peak_end_number_and_strain() {
        let of = record(&[20.0, 36.0, 30.0]);
        let chosen = |text: &str| {
            let chosen = of.choose(FramePick::read(text).unwrap(), Giver::Flags);
            chosen.map(|frames| frames.iter().map(|frame| frame.number).collect::<Vec<_>>())
        };
        for (text, numbers) in
            [("peak", &[2][..]), ("last", &[3]), ("all", &[1, 2, 3]), ("1", &[1]), ("0.0026", &[3]), ("0.0015", &[1])]
        {
            assert_eq!(chosen(text), Ok(numbers.to_vec()), "{text}");
        }
        let refusal = |text: &str| chosen(text).unwrap_err().to_string();
        assert_eq!(refusal("4"), "--frame is 4; the test has frames 1 to 3");
        assert_eq!(refusal("0.02"), "--frame is 0.02; the frames reach a strain of 0.00300");
        let none = record(&[]).choose(FramePick::Peak, Giver::Keywords).unwrap_err().to_string();
        assert_eq!(none, "frame is peak; the test has no frames; solve it again with frames 20");
        let cohesive = RunRecord { cohesive_elements: 7, ..of.clone() };
        let cohesive = cohesive.choose(FramePick::Last, Giver::Flags).unwrap_err().to_string();
        assert!(cohesive.ends_with("solve it with --itz solid, smeared or none"), "{cohesive}");
        let doubt = of.doubt(FramePick::Peak, &of.frames[1], Giver::Flags);
        assert_eq!(
            doubt.as_deref(),
            Some("frame 2, the nearest to the peak, has 90 % of its stress; solve with more --frames")
        );
        assert_eq!(of.doubt(FramePick::Last, &of.frames[2], Giver::Flags), None);
    }

    #[test]
    fn a_frame_is_a_word_a_number_or_a_strain() {
        for wrong in ["", "0", "-1", "middle", "1.5", "nan", "-0.1"] {
            assert!(FramePick::read(wrong).is_err(), "{wrong}");
        }
        for (json, pick) in [
            ("\"peak\"", FramePick::Peak),
            ("\"all\"", FramePick::All),
            ("3", FramePick::Number(3)),
            ("0.002", FramePick::Strain(0.002)),
        ] {
            let read: FramePick = serde_json::from_str(json).unwrap();
            assert_eq!((read, serde_json::to_string(&read).unwrap().as_str()), (pick, json));
        }
        for wrong in ["-1", "0", "1.5", "null", "\"x\""] {
            assert!(serde_json::from_str::<FramePick>(wrong).is_err(), "{wrong}");
        }
    }
}
