//! The work of `mesocrete fit`: points of the fit are studies over the seeds, whose cases stay in one folder.
//!
//! A fit that is resumed takes the same points again, and finds their cases done.

use super::curve;
use super::flags::Args;
use super::materials::{self, PARAMETERS};
use crate::commands::{meshing, names, study};
use crate::failure::{Failure, INTERRUPTED};
use crate::outputs::{Target, Unit};
use crate::own_folder::OwnFolder;
use crate::{inputs, interrupt, outputs, stderr};
use meso_concrete::printable;
use meso_core::Silent;
use meso_core::materials::{LawName, Materials};
use meso_solve::Test;
use meso_study::fit::{Calibration, Estimate, Target as Measured};
use meso_study::{CURVE, Status, digest};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

/// Strain at the end of a test over that of the measured curve.
const BEYOND: f64 = 1.15;
/// Digits of the hash in the name of a point's materials.
const SHORT_HASH: usize = 16;

/// Names of the results.
const RESULTS: [&str; 2] = ["materials.toml", "fit.json"];

/// A fit at work.
struct Work<'a> {
    args: &'a Args,
    base: Materials,
    target: Measured,
    /// Flags of every test, beside its materials.
    flags: Map<String, Value>,
    /// The spec's file, from the root.
    spec: String,
    seeds: Vec<u64>,
    /// Every point so far with the figures of its curves.
    history: Vec<Value>,
}

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    args.validate()?;
    let mut work = args.work()?;
    work.check()?;
    let _own = OwnFolder::open(&args.output)?;
    let targets = RESULTS.map(|name| Target::new(&args.output.join(name), args.writing.force));
    let [materials, report] = targets;
    let (materials, report) = (materials?, report?);
    let inputs = [Some(&args.curve), Some(&args.spec), args.materials.as_ref()];
    let inputs: Vec<&Path> = inputs.into_iter().flatten().map(PathBuf::as_path).collect();
    outputs::distinct(&[&materials, &report], &inputs)?;
    let Some(fit) = work.fit()? else {
        stderr::line("stopped; the same command goes on with the next test");
        return Ok(INTERRUPTED);
    };
    work.finish(&fit, &materials, &report)
}

impl Args {
    /// Refuses flags that are wrong with any file.
    fn validate(&self) -> Result<(), Failure> {
        if self.output == Path::new("-") {
            let message = "--output - is standard output, but a fit writes several files; name a folder";
            return Err(Failure::Usage(message.to_owned()));
        }
        for (flag, value) in [("--friction", Some(self.friction)), ("--strain", self.strain)] {
            if value.is_some_and(|value| !value.is_finite()) {
                return Err(Failure::Usage(format!("{flag} must be a finite number")));
            }
        }
        Ok(())
    }

    /// The law of every test.
    fn law(&self) -> LawName {
        self.law.unwrap_or_else(|| Test::default().law)
    }

    /// Reads the files.
    fn work(&self) -> Result<Work<'_>, Failure> {
        let spec = inputs::spec(&self.spec, &Silent, None)?;
        let height_mm = spec.specimen.aabb().size().z;
        let measured = curve::read(&self.curve, height_mm)?;
        let wrong = |message: String| Failure::Usage(format!("{}: {message}", self.curve.display()));
        let target = Measured::new(&measured, height_mm).map_err(wrong)?;
        let base = meshing::materials(self.materials.as_deref())?;
        let last = measured.iter().fold(0.0_f64, |last, point| last.max(point[0]));
        let strain = self.strain.unwrap_or(BEYOND * last);
        let last_seed = spec.seed.checked_add(u64::from(self.seeds - 1)).ok_or_else(|| {
            let (seed, most) = (spec.seed, u64::MAX);
            Failure::Usage(format!("seed is {seed}, and the packings take successive ones; {most} is the largest"))
        })?;
        let work = Work {
            args: self,
            base,
            target,
            flags: self.flags(strain),
            spec: from_root(&self.spec)?,
            seeds: (spec.seed..=last_seed).collect(),
            history: Vec::new(),
        };
        Ok(work)
    }

    /// A study of this fit, whose packings have its gap and time.
    fn study(&self, content: Value) -> Result<study::StudyFile, Failure> {
        let mut study = study::StudyFile::of_tree(content, &self.output.join("fit.toml"))?;
        study.place(&[("min_gap_mm", self.min_gap_mm), ("time_limit_s", self.time_limit)]);
        Ok(study)
    }

    /// Flags of every test.
    fn flags(&self, strain: f64) -> Map<String, Value> {
        let mut flags = Map::from_iter([
            ("friction".to_owned(), json!(self.friction)),
            ("strain".to_owned(), json!(strain)),
            ("frames".to_owned(), json!(0)),
            ("accept-phase-error".to_owned(), json!(self.accept_phase_error)),
        ]);
        flags.extend(self.law.map(|law| ("law".to_owned(), json!(names::of(&law)))));
        flags.extend(self.element_size_mm.map(|size| ("element-size-mm".to_owned(), json!(size))));
        flags
    }
}

/// A path from the root; a study's file has names in UTF-8 alone.
fn from_root(path: &Path) -> Result<String, Failure> {
    let path = std::path::absolute(path).map_err(|error| Failure::file(path, &error))?;
    let wrong = || Failure::Usage(format!("{} is not UTF-8; rename it", path.display()));
    path.to_str().map(str::to_owned).ok_or_else(wrong)
}

impl Work<'_> {
    /// Refuses flags and materials that no test can have, before a folder is made.
    fn check(&self) -> Result<(), Failure> {
        let mut flags = self.flags.clone();
        if let Some(file) = &self.args.materials {
            flags.insert("materials".to_owned(), json!(from_root(file)?));
        }
        let content = json!({ "spec": self.spec, "solve": flags, "over": { "seed": [self.seeds[0]] } });
        let study = self.args.study(content)?;
        study::check(&study, &self.args.output)
    }

    /// The whole fit; none where the user stopped it.
    fn fit(&mut self) -> Result<Option<Calibration>, Failure> {
        let start = materials::feasible(&self.base, &materials::values(&self.base.mortar_strength.of(self.args.law())));
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
        let study = self.args.study(content)?;
        let done = study::cases(&study, &out, self.args.jobs, self.args.threads, self.args.writing.quiet)?;
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
            let folder = out.join(&record.case);
            if !record.has_curve(&folder) {
                let name = folder.display();
                let message = format!("{name}/{CURVE} is not the curve of its test; remove {name}, and it runs again");
                return Err(Failure::Run(message));
            }
            curve::read(&folder.join(CURVE), 1.0)
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
        let text = materials::file(&materials::at(&self.base, self.args.law(), point), "A point of a fit.");
        let name = format!("materials/{}.toml", &digest(text.as_bytes())[..SHORT_HASH]);
        let folder = self.args.output.join("materials");
        std::fs::create_dir_all(&folder).map_err(|error| Failure::file(&folder, &error))?;
        let target = Target::new(&self.args.output.join(&name), true)?;
        let mut unit = Unit::default();
        unit.fill(&target, true, |out| out.write_all(text.as_bytes()))?;
        unit.commit()?;
        Ok(name)
    }

    /// One line about a point.
    fn tell(&self, fit: &Calibration, point: &[f64]) {
        if !self.args.writing.quiet {
            let values: Vec<String> = PARAMETERS.iter().zip(point).map(|(key, x)| format!("{key} {x:.4}")).collect();
            stderr::line(format!("{}: misfit of the best so far {:.2}", values.join(", "), fit.misfit()));
        }
    }

    /// Writes the results, both or neither.
    fn finish(&self, fit: &Calibration, materials: &Target, report: &Target) -> Result<u8, Failure> {
        let estimates = fit.estimates();
        let best: Vec<f64> = estimates.iter().map(|estimate| estimate.value).collect();
        let lines: Vec<String> = PARAMETERS.iter().zip(&estimates).map(|(key, of)| self.line(key, of)).collect();
        let title = format!("mesocrete fit {} {}", self.args.curve.display(), self.args.spec.display());
        let comment = format!("{}\n{}", printable(&title), lines.join("\n"));
        let text = materials::file(&materials::at(&self.base, self.args.law(), &best), &comment);
        let figures = self.report(fit, &estimates);
        let (mut unit, force) = (Unit::default(), self.args.writing.force);
        unit.fill(materials, force, |out| out.write_all(text.as_bytes()))?;
        unit.fill(report, force, |out| writeln!(out, "{figures:#}"))?;
        unit.commit()?;
        if !self.args.writing.quiet {
            lines.iter().for_each(stderr::line);
            outputs::wrote([materials, report]);
        }
        Ok(0)
    }

    /// The content of `fit.json`.
    fn report(&self, fit: &Calibration, estimates: &[Estimate]) -> Value {
        let estimate = |(key, of): (&&str, &Estimate)| {
            let entry = json!({ "value": of.value, "over_packings": of.over_packings, "of_curve": of.of_curve });
            ((*key).to_owned(), entry)
        };
        json!({
            "parameters": PARAMETERS.iter().zip(estimates).map(estimate).collect::<Map<_, _>>(),
            "misfit": fit.misfit(), "seeds": self.seeds, "names": PARAMETERS,
            "figures": self.target.names(), "measured": self.target.values(), "points": self.history,
        })
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
