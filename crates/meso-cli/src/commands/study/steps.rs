//! The steps of each case: pack, write, mesh, solve. Flags in a study are the commands' own.

use super::beside;
use crate::commands::{mesh, solve};
use crate::failure::{Failure, INTERRUPTED, RUN};
use crate::outputs::{Target, Unit};
use crate::progress::Watch;
use crate::{interrupt, threads};
use clap::Parser;
use meso_core::formats::{Format, SurfaceOptions};
use meso_core::{Model, Spec};
use meso_study::{Case, Failed, MODEL, of_packing, of_summary};
use serde_json::{Map, Value};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// The figures of a case's mesh, and of its test.
const MESH_SUMMARY: &str = "mesh.json";
const SOLVE_SUMMARY: &str = "result.json";

#[derive(Parser)]
#[command(name = "[mesh]", no_binary_name = true, disable_help_flag = true)]
struct MeshLine {
    #[command(flatten)]
    args: mesh::Args,
}

#[derive(Parser)]
#[command(name = "[solve]", no_binary_name = true, disable_help_flag = true)]
struct SolveLine {
    #[command(flatten)]
    args: solve::Args,
}

/// The steps of one case.
pub(super) struct Steps {
    /// Files of the packing.
    outputs: Vec<(PathBuf, Format)>,
    mesh: Option<mesh::Args>,
    solve: Option<solve::Args>,
    threads: Option<u16>,
}

impl Steps {
    /// The steps of `case`, whose files go to `folder`; flags that cannot be are named.
    pub(super) fn new(
        case: &Case,
        outputs: &[String],
        folder: &Path,
        study: &Path,
        threads: Option<u16>,
    ) -> Result<Self, Failure> {
        let packings = outputs.iter().map(|name| packing_file(folder, name)).collect::<Result<_, _>>()?;
        let model = folder.join(MODEL).to_string_lossy().into_owned();
        let mut common = vec!["--force".to_owned(), "--quiet".to_owned()];
        common.extend(threads.map(|threads| format!("--threads={threads}")));
        let mesh = case.task["mesh"].as_object().map(|flags| -> Result<_, Failure> {
            let summary = folder.join(MESH_SUMMARY).to_string_lossy().into_owned();
            let mut line = vec![model.clone(), "--summary-json".to_owned(), summary];
            line.extend(common.clone());
            line.extend(words("mesh", flags, Some(folder), study)?);
            let MeshLine { args } = MeshLine::try_parse_from(line).map_err(|error| wrong_flag("mesh", &error))?;
            args.check(&case.spec)?;
            Ok(args)
        });
        let solve = case.task["solve"].as_object().map(|flags| -> Result<_, Failure> {
            let mut line = vec![model.clone(), "-o".to_owned(), folder.to_string_lossy().into_owned()];
            line.extend(common.clone());
            line.extend(words("solve", flags, None, study)?);
            let SolveLine { args } = SolveLine::try_parse_from(line).map_err(|error| wrong_flag("solve", &error))?;
            args.check(&case.spec)?;
            Ok(args)
        });
        Ok(Self { outputs: packings, mesh: mesh.transpose()?, solve: solve.transpose()?, threads })
    }

    /// Does the case; its results, or the error that is kept. An interrupted case has neither: see [`interrupt::asked`].
    pub(super) fn run(&self, case: &Case, folder: &Path) -> Result<Map<String, Value>, Failed> {
        catch_unwind(AssertUnwindSafe(|| self.all(case, folder)))
            .unwrap_or(Err(Failure::Bug))
            .map_err(|failure| failure.message().to_owned())
    }

    fn all(&self, case: &Case, folder: &Path) -> Result<Map<String, Value>, Failure> {
        let model = threads::with(self.threads, || pack(&case.spec))??;
        if interrupt::asked() {
            return Ok(Map::new());
        }
        threads::with(self.threads, || self.write(&model, folder))??;
        let mut results = of_packing(&model.report);
        drop(model);
        if let Some(args) = &self.mesh {
            mesh::run(args)?;
            results.insert("mesh".to_owned(), summary(&folder.join(MESH_SUMMARY))?);
        }
        if let Some(args) = &self.solve {
            match solve::run(args)? {
                INTERRUPTED => return Ok(Map::new()),
                RUN => return Err(Failure::Run("the test diverged; result.json says when".to_owned())),
                _ => results.insert("solve".to_owned(), summary(&folder.join(SOLVE_SUMMARY))?),
            };
        }
        Ok(results)
    }

    fn write(&self, model: &Model, folder: &Path) -> Result<(), Failure> {
        let mut unit = Unit::unforced();
        let saved = (folder.join(MODEL), Format::Json);
        for (path, format) in std::iter::once(&saved).chain(&self.outputs) {
            let target = Target::new(path, true)?;
            unit.fill(&target, true, |out| format.write(model, SurfaceOptions::default(), out))?;
        }
        unit.commit()
    }
}

fn pack(spec: &Spec) -> Result<Model, Failure> {
    let mut watch = Watch::start(true, &[]);
    let model = meso_core::pack(spec, &watch);
    watch.finish();
    model.map_err(|error| Failure::Usage(error.to_string()))
}

/// A file of the packing in the case's folder.
fn packing_file(folder: &Path, name: &str) -> Result<(PathBuf, Format), Failure> {
    let format = Format::from_path(Path::new(name)).ok_or_else(|| {
        let known = Format::ALL.map(|format| format!(".{}", format.extension())).join(", ");
        Failure::Usage(format!("outputs has {name:?}; it must end in one of {known}; meshes go to [mesh] output"))
    })?;
    Ok((inside(folder, "outputs", name)?, format))
}

/// A file's name in a case's folder, which it may not leave; `model.json` is there anyway.
fn inside(folder: &Path, key: &str, name: &str) -> Result<PathBuf, Failure> {
    let is_name = Path::new(name).file_name().is_some_and(|own| own == name);
    if !is_name || [MODEL, meso_study::RECORD, MESH_SUMMARY].contains(&name) {
        let message =
            format!("{key} has {name:?}; it must be the name of a file, and not one that the study writes itself");
        return Err(Failure::Usage(message));
    }
    Ok(folder.join(name))
}

/// The words of a command line for the `flags` of a section; `output` goes to `folder`, where there is one.
fn words(
    section: &str,
    flags: &Map<String, Value>,
    folder: Option<&Path>,
    study: &Path,
) -> Result<Vec<String>, Failure> {
    let mut line = Vec::new();
    for (key, value) in flags {
        let flag = key.replace('_', "-");
        if ["force", "quiet", "threads", "summary-json", "resume", "help"].contains(&flag.as_str())
            || (flag == "output" && folder.is_none())
        {
            return Err(Failure::Usage(format!("[{section}] {key} is set by the study; remove it")));
        }
        if flag == "materials-sha256" {
            continue;
        }
        let values = value.as_array().map_or(std::slice::from_ref(value), Vec::as_slice);
        for value in values {
            match (value, folder) {
                (Value::Bool(given), _) => line.extend(given.then(|| format!("--{flag}"))),
                (Value::String(name), Some(folder)) if flag == "output" => {
                    line.push(format!("--output={}", inside(folder, "[mesh] output", name)?.display()));
                }
                (Value::String(file), _) if flag == "materials" => {
                    line.push(format!("--materials={}", beside(study, file).display()));
                }
                (Value::String(text), _) => line.push(format!("--{flag}={text}")),
                (value, _) => line.push(format!("--{flag}={value}")),
            }
        }
    }
    Ok(line)
}

/// clap's message in a line, without the usage that follows.
fn wrong_flag(section: &str, error: &clap::Error) -> Failure {
    let text = error.to_string();
    let message = text.split("\n\n").next().unwrap_or(&text).replace('\n', " ");
    Failure::Usage(format!("[{section}] {}", message.trim_start_matches("error: ")))
}

fn summary(path: &Path) -> Result<Value, Failure> {
    let bytes = std::fs::read(path).map_err(|error| Failure::file(path, &error))?;
    let summary: Value =
        serde_json::from_slice(&bytes).map_err(|error| Failure::Run(format!("{}: {error}", path.display())))?;
    Ok(of_summary(&summary))
}
