//! The work of `mesocrete fit`: points of the fit are studies over the seeds, whose cases stay in one folder.
//!
//! A fit that is resumed takes the same points again, and finds their cases done.

use super::curve;
use super::flags::Args;
use super::materials::{self, PARAMETERS};
use crate::commands::{meshing, names, study};
use crate::failure::{Failure, INTERRUPTED};
use crate::outputs::{Target, Unit};
use crate::{inputs, interrupt, stderr};
use meso_core::Silent;
use meso_core::materials::Materials;
use meso_study::fit::{Calibration, Estimate, Target as Measured};
use meso_study::{Status, digest};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

/// Strain at the end of a test over that of the measured curve.
const BEYOND: f64 = 1.15;
/// Digits of the hash in the name of a point's materials.
const SHORT_HASH: usize = 16;

/// A fit at work.
struct Work<'a> {
    args: &'a Args,
    base: Materials,
    target: Measured,
    /// Flags of every test, beside its materials.
    flags: Map<String, Value>,
    spec: PathBuf,
    seeds: Vec<u64>,
    /// Every point so far with the figures of its curves.
    history: Vec<Value>,
}

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    let spec = inputs::spec(&args.spec, &Silent, None)?;
    let height_mm = spec.specimen.aabb().size().z;
    let measured = curve::read(&args.curve, height_mm)?;
    let wrong = |message: String| Failure::Usage(format!("{}: {message}", args.curve.display()));
    let target = Measured::new(&measured, height_mm).map_err(wrong)?;
    let base = meshing::materials(args.materials.as_deref())?;
    let last = measured.iter().fold(0.0_f64, |last, point| last.max(point[0]));
    let mut flags = Map::from_iter([
        ("friction".to_owned(), json!(args.friction)),
        ("strain".to_owned(), json!(args.strain.unwrap_or(BEYOND * last))),
        ("frames".to_owned(), json!(0)),
        ("accept-phase-error".to_owned(), json!(args.accept_phase_error)),
    ]);
    flags.extend(args.law.map(|law| ("law".to_owned(), json!(names::of(&law)))));
    flags.extend(args.element_size_mm.map(|size| ("element-size-mm".to_owned(), json!(size))));
    let seeds = (0..u64::from(args.seeds)).map(|number| spec.seed + number).collect();
    let spec = std::path::absolute(&args.spec).map_err(|error| Failure::file(&args.spec, &error))?;
    let mut work = Work { args, base, target, flags, spec, seeds, history: Vec::new() };
    let Some(fit) = work.fit()? else {
        stderr::line("stopped; the same command goes on with the next test");
        return Ok(INTERRUPTED);
    };
    work.finish(&fit)
}

impl Work<'_> {
    /// The whole fit; none where the user stopped it.
    fn fit(&mut self) -> Result<Option<Calibration>, Failure> {
        let start = materials::feasible(&self.base, &materials::values(&self.base.mortar_strength));
        let points = Calibration::points(&start);
        let Some(residuals) = self.test(&points)? else { return Ok(None) };
        let mut fit = Calibration::new(&start, &residuals);
        self.tell(&fit, &points[0]);
        for _ in 0..self.args.steps {
            let Some(point) = fit.next() else { break };
            let point = materials::feasible(&self.base, &point);
            let Some(residuals) = self.test(std::slice::from_ref(&point))? else { return Ok(None) };
            fit.learn(&point, &residuals[0]);
            self.tell(&fit, &point);
        }
        Ok(Some(fit))
    }

    /// Residuals of every point and packing; none where the user stopped the tests.
    fn test(&mut self, points: &[Vec<f64>]) -> Result<Option<Vec<Vec<Vec<f64>>>>, Failure> {
        let files = points.iter().map(|point| self.keep(point)).collect::<Result<Vec<_>, _>>()?;
        let content = json!({
            "spec": self.spec, "solve": self.flags,
            "over": { "seed": self.seeds, "solve.materials": files },
        });
        let out = self.args.output.join("cases");
        let study = study::StudyFile::of_tree(content, &self.args.output.join("fit.toml"))?;
        let done = study::cases(&study, &out, self.args.jobs, self.args.threads, self.args.quiet)?;
        if interrupt::asked() {
            return Ok(None);
        }
        let records = done.records();
        if let Some(record) = records.iter().find(|record| record.status == Status::Failed) {
            let error = record.error.as_deref().unwrap_or_default();
            return Err(Failure::Run(format!("{} failed: {error}", out.join(&record.case).display())));
        }
        let curve_of = |seed: u64, file: &str| {
            let is_it = |values: &Map<String, Value>| {
                values.get("seed") == Some(&json!(seed)) && values.get("solve.materials") == Some(&json!(file))
            };
            let record = records.iter().find(|record| is_it(&record.values));
            let record = record.ok_or_else(|| Failure::Run(format!("seed {seed} has no test of {file}")))?;
            curve::read(&out.join(&record.case).join("curve.csv"), 1.0)
        };
        let mut all = Vec::new();
        for (point, file) in points.iter().zip(&files) {
            let curves = self.seeds.iter().map(|&seed| curve_of(seed, file)).collect::<Result<Vec<_>, _>>()?;
            let figures: Vec<Vec<f64>> = curves.iter().map(|curve| self.target.of(curve)).collect();
            self.history.push(json!({ "parameters": point, "materials": file, "figures": figures }));
            all.push(curves.iter().map(|curve| self.target.residuals(curve)).collect());
        }
        Ok(Some(all))
    }

    /// Writes the materials of a point, and returns the name of their file beside the study.
    fn keep(&self, point: &[f64]) -> Result<String, Failure> {
        let text = materials::toml(&materials::at(&self.base, point), "A point of a fit.");
        let name = format!("materials/{}.toml", &digest(text.as_bytes())[..SHORT_HASH]);
        let folder = self.args.output.join("materials");
        std::fs::create_dir_all(&folder).map_err(|error| Failure::file(&folder, &error))?;
        write(&self.args.output.join(&name), &text)?;
        Ok(name)
    }

    /// One line about a point.
    fn tell(&self, fit: &Calibration, point: &[f64]) {
        if !self.args.quiet {
            let values: Vec<String> = PARAMETERS.iter().zip(point).map(|(key, x)| format!("{key} {x:.4}")).collect();
            stderr::line(format!("{}: misfit of the best so far {:.2}", values.join(", "), fit.misfit()));
        }
    }

    fn finish(&self, fit: &Calibration) -> Result<u8, Failure> {
        let estimates = fit.estimates();
        let best: Vec<f64> = estimates.iter().map(|estimate| estimate.value).collect();
        let lines: Vec<String> = PARAMETERS.iter().zip(&estimates).map(|(key, of)| self.line(key, of)).collect();
        let title = format!("mesocrete fit {} {}", self.args.curve.display(), self.args.spec.display());
        let text = materials::toml(&materials::at(&self.base, &best), &format!("{title}\n{}", lines.join("\n")));
        write(&self.args.output.join("materials.toml"), &text)?;
        let estimate = |(key, of): (&&str, &Estimate)| {
            let entry = json!({ "value": of.value, "over_packings": of.over_packings, "of_curve": of.of_curve });
            ((*key).to_owned(), entry)
        };
        let report = json!({
            "parameters": PARAMETERS.iter().zip(&estimates).map(estimate).collect::<Map<_, _>>(),
            "misfit": fit.misfit(), "seeds": self.seeds, "names": PARAMETERS,
            "figures": self.target.names(), "measured": self.target.values(), "points": self.history,
        });
        let mut text = serde_json::to_string_pretty(&report).map_err(|error| Failure::Run(error.to_string()))?;
        text.push('\n');
        write(&self.args.output.join("fit.json"), &text)?;
        if !self.args.quiet {
            lines.iter().for_each(stderr::line);
            for name in ["materials.toml", "fit.json"] {
                stderr::line(format!("wrote {}", self.args.output.join(name).display()));
            }
        }
        Ok(0)
    }

    /// A parameter with its scatter and error.
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

/// Relative error beyond which a curve says little about a parameter.
const LOOSE: f64 = 0.5;

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    let target = Target::new(path, true)?;
    let mut unit = Unit::default();
    unit.fill(&target, true, |out| out.write_all(text.as_bytes()))?;
    unit.commit()
}
