//! Record of a test in its results: loads, measures, turns, supports and gauges.

use crate::sample::Geometry;
use crate::trial::{Expansion, Gauge, SupportSpec, Test, TestKind, Turn, TurnOf};
use serde::{Deserialize, Serialize};

/// The loads and measures that a test has, its turns, supports and gauges; none of plain compression and tension.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Setup {
    /// Lateral pressure of a triaxial test, MPa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure_mpa: Option<f64>,
    /// Lateral over axial stress of a biaxial test.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stress_ratio: Option<f64>,
    /// Distance of a beam's rollers, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub span_mm: Option<f64>,
    /// Width of the strips of a splitting test, or of a beam's rollers, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strip_mm: Option<f64>,
    /// Linear strains of the phases without stress.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expansion: Option<Expansion>,
    /// Places at which the path turns.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub turns: Vec<Turn>,
    /// Whether strengths grew with the rate of strain, in a test in real time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_effect: Option<bool>,
    /// Whether it began with the speeds of a uniform strain.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub starts_moving: bool,
    /// Supports and loads.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub supports: Vec<SupportSpec>,
    /// Gauges, each a column of the curve.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gauges: Vec<Gauge>,
}

impl Setup {
    /// The record of a test with some `supports` on a specimen of this `geometry`.
    pub fn of(test: &Test, geometry: &Geometry, supports: Vec<SupportSpec>) -> Self {
        if !test.has_extra() {
            return Self::default();
        }
        let is = |kind| test.kind == kind && test.supports.is_empty();
        let is_beam = test.kind.is_beam() && test.supports.is_empty();
        let strip_mm = supports.iter().find_map(|support| support.strip).map(|strip| strip.width_mm);
        Self {
            pressure_mpa: is(TestKind::Triaxial).then(|| test.pressure_mpa()),
            stress_ratio: is(TestKind::Biaxial).then(|| test.stress_ratio()),
            span_mm: is_beam.then(|| test.span_mm(geometry)),
            strip_mm: strip_mm.filter(|_| is_beam || is(TestKind::Splitting)),
            expansion: test.expansion(),
            turns: test.turns(),
            rate_effect: test.is_fast().then_some(test.rate_effect),
            starts_moving: test.starts_moving,
            supports,
            gauges: test.gauges(),
        }
    }

    /// Names and values, in words, of all that it has.
    pub fn words(&self) -> Vec<(&'static str, String)> {
        let listed = |texts: Vec<String>| (!texts.is_empty()).then(|| texts.join(", "));
        let rows = [
            ("lateral pressure", self.pressure_mpa.map(|mpa| format!("{mpa} MPa"))),
            ("lateral over axial stress", self.stress_ratio.map(|ratio| ratio.to_string())),
            ("span", self.span_mm.map(|mm| format!("{mm:.1} mm"))),
            ("width of strips or rollers", self.strip_mm.map(|mm| format!("{mm:.2} mm"))),
            ("expansion", self.expansion.as_ref().map(Expansion::words)),
            ("turns", listed(self.turns.iter().map(Turn::words).collect())),
            ("strengths grow with the rate", self.rate_effect.map(|grow| if grow { "yes" } else { "no" }.to_owned())),
            ("starts moving", self.starts_moving.then(|| "yes".to_owned())),
            ("supports", listed(self.supports.iter().map(SupportSpec::words).collect())),
        ];
        rows.into_iter().filter_map(|(name, value)| Some((name, value?))).collect()
    }
}

impl Turn {
    fn words(&self) -> String {
        match self.of {
            TurnOf::Strain => format!("{}", self.at),
            TurnOf::Stress => format!("{} MPa", self.at),
            TurnOf::Opening => format!("{} mm", self.at),
        }
    }
}

impl SupportSpec {
    /// Its name, side and rule.
    fn words(&self) -> String {
        format!("{} ({}, {})", self.name, word(&self.on), word(&self.rule))
    }
}

/// The word that a spec or a flag has for a value.
pub fn word(value: &impl serde::Serialize) -> String {
    serde_json::to_value(value).ok().and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CUBE: Geometry =
        Geometry { size_mm: [40.0; 3], section_mm2: 1600.0, notch_mm: 0.0, upper_notch_mm: 0.0, notch_at_mm: 0.0 };

    /// The case: neither `result.json` nor the page of a triaxial test named its 5 MPa.
    #[test]
    fn the_record_of_a_test_has_its_loads_and_supports_and_plain_compression_has_none() {
        let of = |kind| {
            let test = Test { kind, ..Test::default() };
            Setup::of(&test, &CUBE, test.rig(&CUBE).unwrap().supports)
        };
        let confined = of(TestKind::Triaxial);
        assert_eq!((confined.pressure_mpa, confined.stress_ratio, confined.strip_mm), (Some(5.0), None, None));
        assert_eq!(confined.words()[0], ("lateral pressure", "5 MPa".to_owned()));
        let names: Vec<&str> = confined.supports.iter().map(|support| &*support.name).collect();
        assert_eq!(names, ["bottom", "top", "mantle"]);
        assert_eq!(of(TestKind::Biaxial).stress_ratio, Some(1.0));
        assert_eq!(of(TestKind::Splitting).strip_mm, Some(4.0));
        assert_eq!(of(TestKind::Cyclic).turns.len(), 9);
        assert_eq!(of(TestKind::Expansion).words()[0], ("expansion", "aggregate 1e-4".to_owned()));
        for kind in [TestKind::Compression, TestKind::Tension] {
            assert_eq!(of(kind), Setup::default());
        }
    }
}
