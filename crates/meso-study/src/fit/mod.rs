//! The mortar with which a specimen's curve meets a measured one.
//!
//! Points of a fit are studies over the seeds, whose cases stay in one folder. A fit that is resumed takes the same points
//! again, and finds their cases done, and so do processes that share it: each learns from the records of all. A front
//! [begins](FitRun::begin), does the cases of a [`plan`](FitRun::plan), and gives their records to [`learn`](FitRun::learn),
//! until no plan is left.

mod calibration;
mod curve;
mod materials;

pub use calibration::{Calibration, Estimate, Target};
pub use curve::curve;
pub use materials::PARAMETERS;

use crate::record::reopen_failed;
use crate::run::{WORK, alone};
use crate::steps::{commit, file_error, fill};
use crate::{Axis, CURVE, Case, Keep, NamedFiles, Plan, Planning, Record, RunError, Status, Steps, digest};
use meso_ask::files::Reader;
use meso_ask::{AskError, FitAsk, Given};
use meso_core::Spec;
use meso_core::materials::{LawName, Materials};
use meso_core::spec::Files;
use meso_files::lock::{Held, join_after};
use meso_files::whole::{Keeper, Unit};
use meso_solve::Test;
use serde_json::{Map, Value, json};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Strain at the end of a test over that of the measured curve.
const BEYOND: f64 = 1.15;
/// Digits of the hash in the name of a point's materials.
const SHORT_HASH: usize = 16;
/// Relative error beyond which a curve says little about a parameter.
const LOOSE: f64 = 0.5;
/// Names of the results.
pub const RESULTS: [&str; 2] = ["materials.toml", "fit.json"];
/// Folder of the cases in that of a fit.
const CASES: &str = "cases";

/// The points of a measured curve, strain and stress in MPa, of a specimen of a height, mm.
pub type Measured<'a> = dyn Fn(f64) -> Result<Vec<[f64; 2]>, String> + 'a;

/// A fit at work.
pub struct FitRun {
    ask: Given<FitAsk>,
    /// The materials that it starts from.
    base: Materials,
    /// The spec's tree, with the gap and the time of the fit.
    spec: Value,
    target: Target,
    seeds: Vec<u64>,
    /// Options of every test, beside its materials.
    test: Map<String, Value>,
    /// Points that are tested next.
    points: Vec<Vec<f64>>,
    start: Vec<f64>,
    calibration: Option<Calibration>,
    steps: u32,
    /// Every point so far with the figures of its curves.
    history: Vec<Value>,
    out: PathBuf,
}

impl FitRun {
    /// The fit of a spec's tree, whose files `files` reads, from the materials `base`; `measured` is the name of a curve, and
    /// gives its points for a specimen of a height, mm; `out` is the folder of the fit.
    ///
    /// # Errors
    /// Options that are out of their range, a curve that is none of concrete, and a spec that cannot be.
    pub fn new(
        ask: Given<FitAsk>,
        mut spec: Value,
        files: &mut dyn Files,
        (name, measured): (&str, &Measured<'_>),
        base: Materials,
        out: &Path,
    ) -> Result<Self, AskError> {
        ask.accept()?;
        let options = &ask.options;
        crate::place(&mut spec, &[("min_gap_mm", options.min_gap_mm), ("time_limit_s", options.time_limit_s)]);
        let whole = Spec::from_value_with(&spec, files).map_err(|error| AskError::Usage(error.to_string()))?;
        let height_mm = whole.specimen.aabb().size().z;
        let wrong = |why: String| AskError::Usage(format!("{name}: {why}"));
        let curve = measured(height_mm).map_err(wrong)?;
        let target = Target::new(&curve, height_mm).map_err(wrong)?;
        let last = curve.iter().fold(0.0_f64, |last, point| last.max(point[0]));
        let last_seed = whole.seed.checked_add(u64::from(options.seeds - 1)).ok_or_else(|| {
            let (seed, most) = (whole.seed, u64::MAX);
            AskError::Usage(format!("seed is {seed}, and the packings take successive ones; {most} is the largest"))
        })?;
        let mut test = Map::from_iter([
            ("friction".to_owned(), json!(options.friction.unwrap_or_else(|| Test::default().friction()))),
            ("strain".to_owned(), json!(options.strain.unwrap_or(BEYOND * last))),
            ("frames".to_owned(), json!(0)),
            ("accept-phase-error".to_owned(), json!(options.accept_phase_error)),
        ]);
        test.extend(options.law.map(|law| ("law".to_owned(), json!(law))));
        test.extend(options.element_size_mm.map(|size| ("element-size-mm".to_owned(), json!(size))));
        let law = options.law.unwrap_or_else(|| Test::default().law);
        let start = materials::feasible(&base, &materials::values(&base.mortar_strength.of(law)));
        let (points, seeds) = (Calibration::points(&start), (whole.seed..=last_seed).collect());
        let (calibration, steps, history, out) = (None, 0, Vec::new(), out.to_owned());
        Ok(Self { ask, base, spec, target, seeds, test, points, start, calibration, steps, history, out })
    }

    /// Begins the work in the folder of the fit, which is there. Processes with the same fit share its tests; one that begins
    /// alone opens those that failed again.
    ///
    /// # Errors
    /// [`RunError::Lock`] where a process does other work in the folder.
    pub fn begin(&self) -> Result<Held, RunError> {
        Ok(join_after(&self.out, &self.work(), || reopen_failed(&self.cases()))?)
    }

    /// A name of what is asked, for processes that share the work.
    fn work(&self) -> String {
        let Self { base, spec, target, seeds, test, start, .. } = self;
        let asked = json!([base, spec, target.values(), seeds, test, start, self.ask.options.steps]);
        digest(asked.to_string().as_bytes())[..WORK].to_owned()
    }

    /// The folder of the cases.
    pub fn cases(&self) -> PathBuf {
        self.out.join(CASES)
    }

    fn law(&self) -> LawName {
        self.ask.options.law.unwrap_or_else(|| Test::default().law)
    }

    /// A case with the materials that the fit starts from: whatever it cannot have, no test can have.
    ///
    /// # Errors
    /// A spec that cannot be.
    pub fn first(&self, files: &mut dyn Files) -> Result<Plan, AskError> {
        let mut test = self.test.clone();
        test.insert("materials".to_owned(), serde_json::to_value(&self.base).unwrap_or_default());
        let axes = [Axis::new("seed", vec![self.seeds[0].into()])];
        self.planned(&axes, &test, files)
    }

    /// The cases of the points that are tested next, whose materials are written; `None` once the fit is over.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn plan<K: Keeper>(&self, keeper: K, files: &mut dyn Files) -> Result<Option<Plan>, AskError> {
        if self.points.is_empty() {
            return Ok(None);
        }
        let folder = self.out.join("materials");
        std::fs::create_dir_all(&folder).map_err(|error| file_error(&folder, &error))?;
        let mut unit = Unit::new(keeper);
        for point in &self.points {
            let (name, text) = self.file(point);
            fill(&mut unit, &self.out.join(name), |out| out.write_all(text.as_bytes()))?;
        }
        commit(unit)?;
        let names = self.points.iter().map(|point| self.file(point).0.into()).collect();
        let seeds = self.seeds.iter().map(|seed| (*seed).into()).collect();
        let axes = [Axis::new("seed", seeds), Axis::new("solve.materials", names)];
        self.planned(&axes, &self.test, files).map(Some)
    }

    fn planned(&self, axes: &[Axis], test: &Map<String, Value>, files: &mut dyn Files) -> Result<Plan, AskError> {
        let task = json!({ "outputs": [], "solve": test });
        let mut named = Named(NamedFiles::beside(&self.out));
        let plan = Plan::new_while(&self.spec, axes, &task, files, &mut named);
        let planned = plan.map_err(|error| AskError::Usage(error.to_string()))?;
        Ok(Plan { work: Some(self.work()), ..planned })
    }

    /// Steps of a case.
    ///
    /// # Errors
    /// See [`Steps::of`].
    pub fn steps(&self, case: &Case, read: &Reader<'_>) -> Result<Steps, AskError> {
        let giver = self.ask.giver();
        Steps::of(&case.task, Keep::Json, &self.out, &|_| giver, read)
    }

    /// The materials of a point: the name of their file in the folder, and its text.
    fn file(&self, point: &[f64]) -> (String, String) {
        let text = materials::file(&materials::at(&self.base, self.law(), point), "A point of a fit.");
        (format!("materials/{}.toml", &digest(text.as_bytes())[..SHORT_HASH]), text)
    }

    /// Takes in the records of the cases of a plan; returns a line about the fit.
    ///
    /// # Errors
    /// A case that failed, and a curve that is not the one of its test.
    pub fn learn(&mut self, records: &[Record]) -> Result<String, AskError> {
        let cases = self.cases();
        if let Some(record) = records.iter().find(|record| record.status == Status::Failed) {
            let error = record.error.as_deref().unwrap_or_default();
            return Err(AskError::Run(format!("{} failed: {error}", cases.join(&record.case).display())));
        }
        let mut all: Vec<Vec<Vec<f64>>> = Vec::new();
        for point in &self.points {
            let file = self.file(point).0;
            let curves: Vec<_> =
                self.seeds.iter().map(|seed| curve_of(records, &cases, *seed, &file)).collect::<Result<_, _>>()?;
            let figures: Vec<Vec<f64>> = curves.iter().map(|curve| self.target.of(curve)).collect();
            self.history.push(json!({ "parameters": point, "materials": file, "figures": figures }));
            all.push(curves.iter().map(|curve| self.target.residuals(curve)).collect());
        }
        let point = std::mem::take(&mut self.points).swap_remove(0);
        let calibration = match &mut self.calibration {
            None => self.calibration.insert(Calibration::new(&self.start, &all)),
            Some(calibration) => {
                calibration.learn(&point, &all[0]);
                self.steps += 1;
                calibration
            }
        };
        let next = calibration.next().filter(|_| self.steps < self.ask.options.steps);
        self.points.extend(next.map(|point| materials::feasible(&self.base, &point)));
        let values: Vec<String> = PARAMETERS.iter().zip(&point).map(|(key, x)| format!("{key} {x:.4}")).collect();
        Ok(format!("{}: misfit of the best so far {:.2}", values.join(", "), calibration.misfit()))
    }

    /// The parameters at the best point, with their scatter; none before the first points are tested.
    pub fn estimates(&self) -> Vec<Estimate> {
        self.calibration.as_ref().map_or_else(Vec::new, Calibration::estimates)
    }

    /// The materials at the best point.
    pub fn materials(&self) -> Materials {
        let best: Vec<f64> = self.estimates().iter().map(|estimate| estimate.value).collect();
        materials::at(&self.base, self.law(), &best)
    }

    /// Writes the results, both or none: `materials.toml`, which begins with a title, and `fit.json`; `replace` says whether
    /// others may be there. Those of a process that shared the work are the same.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn save<K: Keeper + Copy>(&self, title: &str, replace: bool, keeper: K) -> Result<(), AskError> {
        let saved = alone(&self.out, &keeper, || self.save_alone(title, replace, keeper));
        saved.unwrap_or_else(|busy| Err(AskError::Run(busy.to_string())))
    }

    fn save_alone<K: Keeper>(&self, title: &str, replace: bool, keeper: K) -> Result<(), AskError> {
        let text = materials::file(&self.materials(), &format!("{title}\n{}", self.lines().join("\n")));
        let contents = [text, format!("{:#}\n", self.report())];
        let mut unit = Unit::new(keeper);
        for (name, content) in RESULTS.into_iter().zip(contents) {
            let path = self.out.join(name);
            let is_same = std::fs::read(&path).is_ok_and(|there| there == content.as_bytes());
            let filled = unit.fill(&path, replace || is_same, |out| out.write_all(content.as_bytes()));
            filled.map_err(|error| file_error(&path, &error))?;
        }
        commit(unit)
    }

    /// The content of `fit.json`.
    pub fn report(&self) -> Value {
        let estimate = |(key, of): (&&str, &Estimate)| {
            let entry = json!({ "value": of.value, "over_packings": of.over_packings, "of_curve": of.of_curve });
            ((*key).to_owned(), entry)
        };
        json!({
            "parameters": PARAMETERS.iter().zip(&self.estimates()).map(estimate).collect::<Map<_, _>>(),
            "misfit": self.calibration.as_ref().map(Calibration::misfit), "seeds": self.seeds, "names": PARAMETERS,
            "figures": self.target.names(), "measured": self.target.values(), "points": self.history,
        })
    }

    /// Every parameter with its scatter and error, a line each.
    pub fn lines(&self) -> Vec<String> {
        PARAMETERS.iter().zip(&self.estimates()).map(|(key, of)| self.line(key, of)).collect()
    }

    fn line(&self, key: &str, of: &Estimate) -> String {
        let Estimate { value, over_packings, of_curve } = *of;
        let scatter = if over_packings.is_nan() {
            "one packing".to_owned()
        } else {
            format!("scatter over {} packings {:.1} %", self.seeds.len(), 100.0 * over_packings)
        };
        let loose = if of_curve > LOOSE { ": the curve hardly depends on it" } else { "" };
        format!("{key} {value:.5}, {scatter}, error that the curve leaves {:.0} %{loose}", 100.0 * of_curve)
    }
}

/// The curve of the case with this seed and file of materials.
fn curve_of(records: &[Record], cases: &Path, seed: u64, file: &str) -> Result<Vec<[f64; 2]>, AskError> {
    let is_it = |values: &Map<String, Value>| {
        values.get("seed") == Some(&json!(seed)) && values.get("solve.materials") == Some(&json!(file))
    };
    let record = records.iter().find(|record| is_it(&record.values));
    let record = record.ok_or_else(|| AskError::Run(format!("seed {seed} has no test of {file}")))?;
    let folder = cases.join(&record.case);
    if !record.has_curve(&folder) {
        let name = folder.display();
        let message = format!("{name}/{CURVE} is not the curve of its test; remove {name}, and it runs again");
        return Err(AskError::Run(message));
    }
    let path = folder.join(CURVE);
    let bytes = std::fs::read(&path).map_err(|error| file_error(&path, &error))?;
    curve(&bytes, 1.0).map_err(|why| AskError::Run(format!("{}: {why}", path.display())))
}

/// Completes tasks with the hashes of their files.
struct Named<'a>(NamedFiles<'a>);

impl Planning for Named<'_> {
    fn complete(&mut self, task: &mut Value) -> Result<(), String> {
        self.0.complete(task)
    }
}
