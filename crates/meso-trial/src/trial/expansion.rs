//! Strains that phases have without stress: their courses over time, and the layer that has them.

use crate::error::TEST;
use crate::sample::Sample;
use crate::trial::load::{Side, WIDEST_MM};
use crate::trial::{LEAST_STRAIN, Test};
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::{OutOfRange, PhaseNames, PhysicalRange};
use meso_mesh::{Mesh, Phase};
use serde::{Deserialize, Serialize};

/// Numbers of phases, one beyond the largest; 3 is no phase of a mesh.
pub const PHASES: usize = Phase::ALL.len();
/// Number of strains: one for each phase, then one for each phase below the layer at the surface.
pub const STRAINS: usize = 2 * PHASES;

/// Strains that phases have without stress; they grow before the path begins.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Expansion {
    /// Linear strain of the mortar; shrinkage is negative.
    pub mortar: Course,
    /// Linear strain of the ITZ; absent, the mortar's.
    pub itz: Option<Course>,
    /// Linear strain of the aggregates, those of a phase of their own included.
    pub aggregate: Course,
    /// Linear strain of the fibres.
    pub fibre: Course,
    /// Depth of the layer at the surface that has these strains, mm; absent, the whole specimen has them.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1e-3, max = 1e4)))]
    pub layer_mm: Option<f64>,
    /// The sides that the layer lies on; the whole surface where none are given.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub layer_on: Vec<Side>,
    /// Strains below the layer; absent, there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub below: Option<Below>,
}

/// Strains that phases have without stress below the layer at the surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Below {
    /// Linear strain of the mortar; shrinkage is negative.
    pub mortar: Course,
    /// Linear strain of the ITZ; absent, the mortar's.
    pub itz: Option<Course>,
    /// Linear strain of the aggregates, those of a phase of their own included.
    pub aggregate: Course,
    /// Linear strain of the fibres.
    pub fibre: Course,
}

/// Course of a strain over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(
    untagged,
    expecting = "it must be a linear strain, rows of a time and a strain: [[28, -2e-4], [90, -4e-4]], or a CSV file"
)]
pub enum Course {
    /// It grows smoothly to this value.
    To(#[cfg_attr(feature = "schema", schemars(range(min = -0.005, max = 0.02)))] f64),
    /// It is 0 at the time 0, and passes these times, in any unit, and strains; the last time of all phases ends the growth.
    Through(Vec<[f64; 2]>),
    /// A CSV file with the rows: columns named time and strain. It lies beside the TEST.toml.
    Table(String),
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
            Self::Table(_) => 0.0,
        }
    }

    /// Time of its last row; 0 without rows.
    fn end(&self) -> f64 {
        match self {
            Self::To(_) | Self::Table(_) => 0.0,
            Self::Through(rows) => rows.last().map_or(0.0, |row| row[0]),
        }
    }

    /// Strain at `time`, or at a `share` of the growth where it has no rows.
    fn at(&self, time: f64, share: f64) -> f64 {
        match self {
            Self::To(strain) => share * strain,
            Self::Through(rows) => through(rows, time),
            Self::Table(_) => 0.0,
        }
    }

    /// Strains that it passes.
    fn strains(&self) -> Vec<f64> {
        match self {
            Self::To(strain) => vec![*strain],
            Self::Through(rows) => rows.iter().map(|row| row[1]).collect(),
            Self::Table(_) => Vec::new(),
        }
    }

    /// Its last strain, and the time of that where it has rows; none without a strain.
    fn words(&self) -> Option<String> {
        let strain = format!("{:e}", self.last());
        let is_none = self.strains().iter().all(|&strain| strain == 0.0);
        match self {
            Self::Table(name) => Some(name.clone()),
            _ if is_none => None,
            Self::To(_) => Some(strain),
            Self::Through(rows) => Some(format!("{strain} at {} in {} rows", self.end(), rows.len())),
        }
    }

    fn validate(&self, key: &str) -> Result<(), OutOfRange> {
        for strain in self.strains() {
            unfit_strain(strain).map_or(Ok(()), |why| Err(TEST.error(key, strain, why)))?;
        }
        let rows = match self {
            Self::To(_) => return Ok(()),
            Self::Table(name) => {
                return Err(TEST.error(key, name, "only a TEST.toml and Python read a table; give the rows"));
            }
            Self::Through(rows) => rows,
        };
        let mut before = 0.0;
        for &[time, _] in rows {
            unfit_time(before, time).map_or(Ok(()), |why| Err(TEST.error(key, time, why)))?;
            before = time;
        }
        TEST.require(key, "[]", !rows.is_empty(), "give at least one row of a time and a strain")
    }
}

/// The reason why no phase has this strain.
pub(super) fn unfit_strain(strain: f64) -> Option<String> {
    let is_seen = strain == 0.0 || strain.abs() >= LEAST_STRAIN;
    let free = PhysicalRange::FREE_STRAIN;
    match free.has(strain) {
        false => Some(free.refusal(strain)),
        true if is_seen => None,
        true => Some("it must be 0, or 1e-12 at least: single precision carries no less".to_owned()),
    }
}

/// The reason why this time of a row cannot follow the time `before`.
pub(super) fn unfit_time(before: f64, time: f64) -> Option<&'static str> {
    let is_later = before < time && time.is_finite();
    (!is_later).then_some("times must be finite, above 0 and ascend; the strain is 0 at the time 0")
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

/// Courses by the numbers of phases, as they were given; 3 is no phase of a mesh.
type Zone<'a> = [Option<&'a Course>; PHASES];

impl Expansion {
    /// Courses in the layer or the whole specimen, then below the layer.
    fn zones(&self) -> [Zone<'_>; 2] {
        let own = [Some(&self.mortar), self.itz.as_ref(), Some(&self.aggregate), None, Some(&self.fibre)];
        let below = self.below.as_ref().map_or([None; PHASES], |Below { mortar, itz, aggregate, fibre }| {
            [Some(mortar), itz.as_ref(), Some(aggregate), None, Some(fibre)]
        });
        [own, below]
    }

    /// All courses that were given, with their keys.
    pub(super) fn courses_mut(&mut self) -> Vec<(&'static str, &mut Course)> {
        let mut all = vec![
            ("expansion.mortar", &mut self.mortar),
            ("expansion.aggregate", &mut self.aggregate),
            ("expansion.fibre", &mut self.fibre),
        ];
        all.extend(self.itz.as_mut().map(|itz| ("expansion.itz", itz)));
        if let Some(Below { mortar, itz, aggregate, fibre }) = &mut self.below {
            all.extend([
                ("expansion.below.mortar", mortar),
                ("expansion.below.aggregate", aggregate),
                ("expansion.below.fibre", fibre),
            ]);
            all.extend(itz.as_mut().map(|itz| ("expansion.below.itz", itz)));
        }
        all
    }

    /// All courses that were given.
    pub(super) fn courses(&self) -> impl Iterator<Item = &Course> {
        self.zones().into_iter().flatten().flatten()
    }

    /// Strains of the phases in the layer, then below it, at shares of the time and of the growth that are over.
    pub fn at(&self, past: f64, share: f64) -> [f64; STRAINS] {
        let time = past * self.courses().map(Course::end).fold(0.0, f64::max);
        // The ITZ follows the mortar unless it has its own course.
        let zones = self.zones().map(|[mortar, itz, rest @ ..]| [mortar, itz.or(mortar), rest[0], rest[1], rest[2]]);
        let course = |number: usize| zones[number / PHASES][number % PHASES];
        std::array::from_fn(|number| course(number).map_or(0.0, |course| course.at(time, share)))
    }

    /// Strains of the phases at the end, in the layer or the whole specimen.
    pub fn at_end(&self) -> [f64; PHASES] {
        let [mortar, itz, aggregate, none, fibre, ..] = self.at(1.0, 1.0);
        [mortar, itz, aggregate, none, fibre]
    }

    /// The largest strain of any phase at any time.
    pub fn most(&self) -> f64 {
        self.courses().flat_map(Course::strains).fold(0.0, |most, strain| most.max(strain.abs()))
    }

    /// Whether all strains grow together in the whole specimen.
    pub fn is_plain(&self) -> bool {
        self.layer_mm.is_none() && self.courses().all(|course| matches!(course, Course::To(_)))
    }

    /// Checks every value against its range.
    pub fn validate(&self) -> Result<(), OutOfRange> {
        self.clone().courses_mut().into_iter().try_for_each(|(key, course)| course.validate(key))?;
        let depth = self.layer_mm.unwrap_or(1.0);
        TEST.require("expansion.layer_mm", depth, (1e-3..=WIDEST_MM).contains(&depth), "it must be 1e-3 to 1e4")?;
        let has_layer = self.layer_mm.is_some() || self.layer_on.is_empty();
        let why = "sides have a layer only with layer_mm, its depth; give that, too";
        TEST.require("expansion.layer_on", self.layer_on.len(), has_layer, why)?;
        let has_layer = self.layer_mm.is_some() || self.below.is_none();
        let why = "strains lie below a layer only with layer_mm, its depth; give that, too";
        TEST.require("expansion.below", self.words(), has_layer, why)?;
        let why = "no phase has a strain; give one, as mortar = -3e-4, or leave the table out";
        TEST.require("expansion", self.words(), self.most() > 0.0, why)
    }

    /// Refuses strains of an ITZ or of fibres that the mesh does not have.
    ///
    /// # Errors
    /// Names the first of them.
    pub fn suits(&self, mesh: &Mesh) -> Result<(), OutOfRange> {
        self.suits_phases("the mesh has no element of that phase", |phase| mesh.phase.contains(&phase))
    }

    /// Refuses strains of an ITZ or of fibres, where `has` says that they are not there.
    ///
    /// # Errors
    /// Names the first of them; `reason` says why they are not there.
    pub fn suits_phases(&self, reason: &str, has: impl Fn(Phase) -> bool) -> Result<(), OutOfRange> {
        for zone in self.zones() {
            for phase in [Phase::Itz, Phase::Fibre] {
                let number = phase.index();
                let strains = zone[number].and_then(Course::words).filter(|_| !has(phase));
                let (key, why) = (PhaseNames::COMMON.name(phase), format!("{reason}; leave it out"));
                strains.map_or(Ok(()), |strains| Err(TEST.error(format!("expansion.{key}"), strains, why)))?;
            }
        }
        Ok(())
    }

    /// Its strains that are not 0, with their phases.
    pub fn words(&self) -> String {
        let [own, below] = self.zones().map(|zone| {
            let part = |(phase, course): (&str, Option<&Course>)| Some(format!("{phase} {}", course?.words()?));
            PhaseNames::COMMON
                .all()
                .map(|phase| PhaseNames::COMMON.name(phase))
                .zip(zone)
                .filter_map(part)
                .collect::<Vec<_>>()
                .join(", ")
        });
        let layer = self.layer_mm.map(|depth| format!(" in a layer of {depth} mm")).unwrap_or_default();
        let own = (!own.is_empty()).then_some(own + &layer);
        let below = (!below.is_empty()).then(|| format!("{below} below the layer"));
        let all: Vec<String> = own.into_iter().chain(below).collect();
        if all.is_empty() { "0".to_owned() } else { all.join(", ") }
    }

    /// By cell of the mesh, whether it lies below the layer; empty where there is no layer.
    ///
    /// # Errors
    /// A layer without a cell.
    pub fn below_the_layer(&self, sample: &Sample) -> Result<Vec<bool>, OutOfRange> {
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
    pub fn suits_amplitude(&self) -> Result<(), OutOfRange> {
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
            layer_mm: Some(2.0),
            below: Some(Below {
                itz: Some(2e-5.into()),
                aggregate: Course::Through(vec![[240.0, 4e-4]]),
                ..Below::default()
            }),
            ..Expansion::default()
        };
        let of_aggregate = |time: f64| through(&[[60.0, 1e-4], [120.0, 3e-4]], time);
        assert_eq!(expansion.at(0.0, 0.0), [0.0; STRAINS]);
        let at = expansion.at(0.125, 0.5);
        assert_eq!(at[..PHASES], [-2e-4, -2e-4, of_aggregate(30.0), 0.0, 5e-6]);
        assert_eq!(at[PHASES..], [0.0, 1e-5, through(&[[240.0, 4e-4]], 30.0), 0.0, 0.0]);
        assert_eq!(expansion.at(1.0, 1.0), [-2e-4, -2e-4, 3e-4, 0.0, 1e-5, 0.0, 2e-5, 4e-4, 0.0, 0.0]);
        let words = "mortar -2e-4 at 30 in 1 rows, aggregate 3e-4 at 120 in 2 rows, fibre 1e-5 in a layer of 2 mm, \
                     itz 2e-5, aggregate 4e-4 at 240 in 1 rows below the layer";
        assert_eq!(expansion.words(), words);
    }

    #[test]
    fn courses_and_layers_that_mean_nothing_are_refused() {
        let of = |mortar: Course| Expansion { mortar, ..Expansion::default() };
        let rows = |rows: &[[f64; 2]]| of(Course::Through(rows.to_vec()));
        for (expansion, text) in [
            (of(0.03.into()), "test.expansion.mortar is 0.03"),
            (of((-0.02).into()), "test.expansion.mortar is -0.02; it must be -0.005 to 0.02: -0.02 % are -0.0002"),
            (of((-300.0).into()), "-300 microstrain are -0.0003"),
            (Expansion::default(), "test.expansion is 0; no phase has a strain"),
            (of(1e-15.into()), "or 1e-12 at least"),
            (rows(&[]), "at least one row"),
            (rows(&[[0.0, 1e-4]]), "above 0 and ascend"),
            (rows(&[[2.0, 1e-4], [1.0, 2e-4]]), "test.expansion.mortar is 1; times must"),
            (rows(&[[f64::INFINITY, 1e-4]]), "times must be finite"),
            (Expansion { layer_mm: Some(0.0), ..of(1e-4.into()) }, "test.expansion.layer_mm is 0"),
            (Expansion { layer_on: vec![Side::ZMax], ..of(1e-4.into()) }, "only with layer_mm"),
            (Expansion { below: Some(Below::default()), ..of(1e-4.into()) }, "test.expansion.below is"),
            (
                Expansion {
                    layer_mm: Some(1.0),
                    below: Some(Below { aggregate: 0.03.into(), ..Below::default() }),
                    ..of(0.0.into())
                },
                "test.expansion.below.aggregate is 0.03",
            ),
            (of(Course::Table("dry.csv".to_owned())), "test.expansion.mortar is dry.csv; only a TEST.toml"),
        ] {
            let error = expansion.validate().unwrap_err().to_string();
            assert!(error.contains(text), "{error}");
        }
    }
}
