//! Strains that phases have without stress: their courses over time, and the layer that has them.

use crate::error::TEST;
use crate::sample::Sample;
use crate::test::load::{Side, WIDEST_MM};
use crate::test::{LEAST_STRAIN, Test};
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::OutOfRange;
use serde::{Deserialize, Serialize};

/// Strains that phases have without stress; they grow before the path begins.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Expansion {
    /// Linear strain of the mortar; shrinkage is negative.
    pub mortar: Course,
    /// Linear strain of the ITZ; absent, the mortar's.
    pub itz: Option<Course>,
    /// Linear strain of the aggregates.
    pub aggregate: Course,
    /// Linear strain of the fibres.
    pub fibre: Course,
    /// Depth of the layer below the surface that has these strains, mm; absent, the whole specimen has them.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1e-3, max = 1e4)))]
    pub layer_mm: Option<f64>,
    /// The sides that the layer lies on; the whole surface where none are given.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub layer_on: Vec<Side>,
}

/// Course of a strain over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "it must be a linear strain, or rows of a time and a strain: [[28, -2e-4], [90, -4e-4]]")]
pub enum Course {
    /// It grows smoothly to this value.
    To(#[cfg_attr(feature = "schema", schemars(range(min = -0.02, max = 0.02)))] f64),
    /// It is 0 at the time 0, and passes these times, in any unit, and strains; the last time of all phases ends the growth.
    Through(Vec<[f64; 2]>),
}

impl From<f64> for Course {
    fn from(strain: f64) -> Self {
        Self::To(strain)
    }
}

impl Default for Course {
    fn default() -> Self {
        Self::To(0.0)
    }
}

impl Course {
    /// Strain at the end.
    fn last(&self) -> f64 {
        match self {
            Self::To(strain) => *strain,
            Self::Through(rows) => rows.last().map_or(0.0, |row| row[1]),
        }
    }

    /// Time of its last row; 0 without rows.
    fn end(&self) -> f64 {
        match self {
            Self::To(_) => 0.0,
            Self::Through(rows) => rows.last().map_or(0.0, |row| row[0]),
        }
    }

    /// Strain at `time`, or at a `share` of the growth where it has no rows.
    fn at(&self, time: f64, share: f64) -> f64 {
        match self {
            Self::To(strain) => share * strain,
            Self::Through(rows) => through(rows, time),
        }
    }

    /// Strains that it passes.
    fn strains(&self) -> Vec<f64> {
        match self {
            Self::To(strain) => vec![*strain],
            Self::Through(rows) => rows.iter().map(|row| row[1]).collect(),
        }
    }

    /// Its last strain, and the time of that where it has rows; none without a strain.
    fn words(&self) -> Option<String> {
        let strain = format!("{:e}", self.last());
        let is_none = self.strains().iter().all(|&strain| strain == 0.0);
        let timed = |rows: &Vec<[f64; 2]>| format!("{strain} at {} in {} rows", self.end(), rows.len());
        match self {
            _ if is_none => None,
            Self::To(_) => Some(strain),
            Self::Through(rows) => Some(timed(rows)),
        }
    }

    fn validate(&self, phase: &str) -> Result<(), OutOfRange> {
        let key = format!("expansion.{phase}");
        for strain in self.strains() {
            TEST.require(&*key, strain, (-0.02..=0.02).contains(&strain), "it must be -0.02 to 0.02")?;
            let is_seen = strain == 0.0 || strain.abs() >= LEAST_STRAIN;
            let why = "it must be 0, or 1e-12 at least: single precision carries no less";
            TEST.require(&*key, strain, is_seen, why)?;
        }
        let Self::Through(rows) = self else { return Ok(()) };
        let times: Vec<f64> = std::iter::once(0.0).chain(rows.iter().map(|row| row[0])).collect();
        let why = "times must be finite, above 0 and ascend; the strain is 0 at the time 0";
        let is_ascending = |pair: &[f64]| pair[0] < pair[1] && pair[1].is_finite();
        let wrong = times.windows(2).find(|pair| !is_ascending(pair)).map(|pair| pair[1]);
        wrong.map_or(Ok(()), |time| Err(TEST.error(&*key, time, why)))?;
        TEST.require(key, "[]", !rows.is_empty(), "give at least one row of a time and a strain")
    }
}

/// Value at `x` of the curve from (0, 0) through `rows`, without overshoot and with level ends (Fritsch and Butland 1984).
fn through(rows: &[[f64; 2]], x: f64) -> f64 {
    let row = |place: usize| if place == 0 { [0.0; 2] } else { rows[place - 1] };
    let Some(next) = (1..=rows.len()).find(|&place| x < row(place)[0]) else { return row(rows.len())[1] };
    let secant = |place: usize| (row(place)[1] - row(place - 1)[1]) / (row(place)[0] - row(place - 1)[0]);
    let slope = |place: usize| {
        if place == 0 || place == rows.len() {
            return 0.0;
        }
        let [a, b] = [secant(place), secant(place + 1)];
        if a * b > 0.0 { 2.0 * a * b / (a + b) } else { 0.0 }
    };
    let ([x0, y0], [x1, y1]) = (row(next - 1), row(next));
    let (h, s) = (x1 - x0, (x - x0) / (x1 - x0));
    let bent = slope(next - 1) * (1.0 - s) - slope(next) * s;
    y0 + (y1 - y0) * s * s * (3.0 - 2.0 * s) + h * s * (1.0 - s) * bent
}

impl Expansion {
    /// Courses by the numbers of phases.
    fn courses(&self) -> [(&'static str, Option<&Course>); 5] {
        let itz = self.itz.as_ref().unwrap_or(&self.mortar);
        [
            ("mortar", Some(&self.mortar)),
            ("itz", Some(itz)),
            ("aggregate", Some(&self.aggregate)),
            ("", None),
            ("fibre", Some(&self.fibre)),
        ]
    }

    /// Strains by the numbers of phases at shares of the time and of the growth that are over; 3 is no phase of a mesh.
    pub(crate) fn at(&self, past: f64, share: f64) -> [f64; 5] {
        let courses = self.courses();
        let end = courses.iter().filter_map(|(_, course)| *course).map(Course::end).fold(0.0, f64::max);
        courses.map(|(_, course)| course.map_or(0.0, |course| course.at(past * end, share)))
    }

    /// The largest strain of any phase at any time.
    pub(crate) fn most(&self) -> f64 {
        let strains = self.courses().into_iter().filter_map(|(_, course)| course).flat_map(Course::strains);
        strains.fold(0.0, |most, strain| most.max(strain.abs()))
    }

    /// Whether all strains grow together in the whole specimen.
    pub(crate) fn is_plain(&self) -> bool {
        self.layer_mm.is_none() && self.courses().iter().all(|(_, course)| !matches!(course, Some(Course::Through(_))))
    }

    /// Checks every value against its range.
    pub(crate) fn validate(&self) -> Result<(), OutOfRange> {
        for (phase, course) in self.courses() {
            course.map_or(Ok(()), |course| course.validate(phase))?;
        }
        let depth = self.layer_mm.unwrap_or(1.0);
        TEST.require("expansion.layer_mm", depth, (1e-3..=WIDEST_MM).contains(&depth), "it must be 1e-3 to 1e4")?;
        let has_layer = self.layer_mm.is_some() || self.layer_on.is_empty();
        let why = "sides have a layer only with layer_mm, its depth; give that, too";
        TEST.require("expansion.layer_on", self.layer_on.len(), has_layer, why)
    }

    /// Its strains that are not 0, with their phases.
    pub fn words(&self) -> String {
        let itz = ("itz", self.itz.as_ref());
        let of = self.courses().map(|(phase, course)| if phase == "itz" { itz } else { (phase, course) });
        let parts: Vec<String> =
            of.into_iter().filter_map(|(phase, course)| Some(format!("{phase} {}", course?.words()?))).collect();
        let layer = self.layer_mm.map(|depth| format!(" in a layer of {depth} mm")).unwrap_or_default();
        if parts.is_empty() { "0".to_owned() } else { parts.join(", ") + &layer }
    }

    /// By cell of the mesh, whether it lies below the layer that has the strains; empty where there is no layer.
    ///
    /// # Errors
    /// A layer without a cell.
    pub(crate) fn below_the_layer(&self, sample: &Sample) -> Result<Vec<bool>, OutOfRange> {
        let Some(depth) = self.layer_mm else { return Ok(Vec::new()) };
        let mesh = sample.mesh;
        let bounds = Aabb::around(&mesh.points);
        let centre =
            |cell: &[u32]| cell.iter().map(|&node| mesh.points[node as usize]).sum::<Vec3>() / cell.len() as f64;
        let below: Vec<bool> = mesh.cells().map(|cell| self.depth_mm(sample, &bounds, &centre(cell)) > depth).collect();
        let why =
            format!("no element's centre lies in the layer; take elements of {} mm, or a deeper layer", 2.0 * depth);
        TEST.require("expansion.layer_mm", depth, below.iter().any(|below| !below), why)?;
        Ok(below)
    }

    /// Distance of a point from the sides that the layer lies on, mm.
    fn depth_mm(&self, sample: &Sample, bounds: &Aabb, point: &Vec3) -> f64 {
        if self.layer_on.is_empty() {
            return sample.container.depth(point);
        }
        let to = |side: &Side| match side.bit() {
            Some(bit) if bit % 2 == 0 => point[bit / 2] - bounds.min[bit / 2],
            Some(bit) => bounds.max[bit / 2] - point[bit / 2],
            // Halfway between the ends, these are as far as they can be.
            None => sample.container.depth(&Vec3::new(point.x, point.y, 0.5 * (bounds.min.z + bounds.max.z))),
        };
        self.layer_on.iter().map(to).fold(f64::INFINITY, f64::min)
    }
}

impl Test {
    /// Refuses strains that a deck cannot have: its one amplitude drives all of them.
    pub(crate) fn suits_amplitude(&self) -> Result<(), OutOfRange> {
        let is_plain = self.expansion().is_none_or(|expansion| expansion.is_plain());
        let why =
            "a deck's strains grow together in whole phases; give numbers without layer_mm, or take mesocrete solve";
        TEST.require("expansion", self.expansion().unwrap_or_default().words(), is_plain, why)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_course_passes_its_rows_without_overshoot_and_stays_at_the_last_one() {
        let rows = [[10.0, 1e-4], [20.0, 1e-4], [60.0, 5e-4], [100.0, 4e-4]];
        for [time, strain] in rows {
            assert_eq!(through(&rows, time), strain);
        }
        assert_eq!([through(&rows, 0.0), through(&rows, 15.0), through(&rows, 200.0)], [0.0, 1e-4, 4e-4]);
        let all: Vec<f64> = (0..=1000).map(|i| through(&rows, 0.1 * f64::from(i))).collect();
        assert!(all.iter().all(|strain| (0.0..=5e-4).contains(strain)));
        // No step is far above the steepest secant.
        assert!(all.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 3e-6), "{all:?}");
    }

    #[test]
    fn phases_end_at_their_own_times_of_one_clock() {
        let expansion = Expansion {
            mortar: Course::Through(vec![[30.0, -2e-4]]),
            aggregate: Course::Through(vec![[60.0, 1e-4], [120.0, 3e-4]]),
            fibre: 1e-5.into(),
            ..Expansion::default()
        };
        assert_eq!(expansion.at(0.0, 0.0), [0.0; 5]);
        assert_eq!(expansion.at(0.25, 0.5), [-2e-4, -2e-4, through(&[[60.0, 1e-4], [120.0, 3e-4]], 30.0), 0.0, 5e-6]);
        assert_eq!(expansion.at(1.0, 1.0), [-2e-4, -2e-4, 3e-4, 0.0, 1e-5]);
        assert_eq!(expansion.words(), "mortar -2e-4 at 30 in 1 rows, aggregate 3e-4 at 120 in 2 rows, fibre 1e-5");
    }

    #[test]
    fn courses_and_layers_that_mean_nothing_are_refused() {
        let of = |mortar: Course| Expansion { mortar, ..Expansion::default() };
        let rows = |rows: &[[f64; 2]]| of(Course::Through(rows.to_vec()));
        for (expansion, text) in [
            (of(0.03.into()), "test.expansion.mortar is 0.03"),
            (of(1e-15.into()), "or 1e-12 at least"),
            (rows(&[]), "at least one row"),
            (rows(&[[0.0, 1e-4]]), "above 0 and ascend"),
            (rows(&[[2.0, 1e-4], [1.0, 2e-4]]), "test.expansion.mortar is 1; times must"),
            (rows(&[[f64::INFINITY, 1e-4]]), "times must be finite"),
            (Expansion { layer_mm: Some(0.0), ..of(1e-4.into()) }, "test.expansion.layer_mm is 0"),
            (Expansion { layer_on: vec![Side::ZMax], ..of(1e-4.into()) }, "only with layer_mm"),
        ] {
            let error = expansion.validate().unwrap_err().to_string();
            assert!(error.contains(text), "{error}");
        }
    }
}
