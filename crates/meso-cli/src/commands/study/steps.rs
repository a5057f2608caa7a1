//! The steps of each case: pack, write, mesh, solve, effective properties. Flags in a study are the commands' own.

use super::{beside, flag_files};
use crate::commands::{effective, mesh, solve};
use crate::failure::{Failure, INTERRUPTED, SHORT};
use crate::outputs::{Target, Unit};
use crate::progress::Watch;
use crate::{interrupt, stderr, threads};
use clap::Parser;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use meso_ask::{Giver, Options as _, Over};
use meso_core::formats::{Format, SurfaceOptions};
use meso_core::{Model, Silent, Spec};
use meso_effective::results::FIGURES;
use meso_study::{Case, CaseOutcome, Keep, NameError, Names, RECORD, of_effective, of_packing, of_summary};
use serde_json::{Map, Value};
use std::error::Error as _;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// Where a study has an option of packings.
fn of_packings(key: &str) -> String {
    let own = match key {
        "seed" | "fraction" => key.to_owned(),
        _ => format!("placement.{key}"),
    };
    let flag = ["min_gap_mm", "time_limit_s"].contains(&key).then(|| Giver::Flags.option(key) + ", or ");
    format!("{}{own} in its spec or in [over]", flag.unwrap_or_default())
}

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

#[derive(Parser)]
#[command(name = "[effective]", no_binary_name = true, disable_help_flag = true)]
struct EffectiveLine {
    #[command(flatten)]
    args: effective::Args,
}

/// Flags of the study's own command line that its steps take.
pub(super) struct Given {
    pub(super) threads: Option<u16>,
    /// The program gmsh. A file never names a program.
    pub(super) gmsh: Option<PathBuf>,
    /// Who gave the options of a section.
    pub(super) giver: fn(&'static str) -> Giver<'static>,
}

/// The steps of one case.
pub(super) struct Steps {
    /// Files of the packing.
    outputs: Vec<(PathBuf, Format)>,
    keep: Keep,
    mesh: Option<mesh::Args>,
    solve: Option<solve::Args>,
    effective: Option<effective::Args>,
    threads: Option<u16>,
}

impl Steps {
    /// The steps of `case`, whose files go to `folder`. Unknown flags, and names that two steps use, are usage errors. It
    /// opens no file and runs no program.
    pub(super) fn new(
        case: &Case,
        (outputs, keep): (&[String], Keep),
        folder: &Path,
        study: &Path,
        given: &Given,
    ) -> Result<Self, Failure> {
        let mut common = vec!["--force".to_owned(), "--quiet".to_owned()];
        common.extend(given.threads.map(|threads| format!("--threads={threads}")));
        let gmsh: Vec<String> = given.gmsh.iter().map(|program| format!("--gmsh={}", program.display())).collect();
        let line = |section: &str, first: [&Path; 3], takes_output: bool| {
            let flags = case.task[section].as_object()?;
            let [model, flag, value] = first.map(|word| word.to_string_lossy().into_owned());
            let words = words(section, flags, takes_output.then_some(folder), study);
            let gmsh = if section == "effective" { Vec::new() } else { gmsh.clone() };
            Some(words.map(|words| [vec![model, flag, value], common.clone(), gmsh, words].concat()))
        };
        let (model, summary) = (folder.join(keep.model()), folder.join(MESH_SUMMARY));
        let mesh_line = line("mesh", [&model, Path::new("--summary-json"), &summary], true).transpose()?;
        let solve_line = line("solve", [&model, Path::new("-o"), folder], false).transpose()?;
        let effective_line = line("effective", [&model, Path::new("-o"), folder], false).transpose()?;
        let mesh = mesh_line.map(|line| -> Result<_, Failure> {
            let mut line = MeshLine::try_parse_from(line).map_err(|error| wrong_flag("mesh", &error))?;
            line.args.given_by((given.giver)("mesh"));
            line.args.validate().map(|()| line.args)
        });
        let solve = solve_line.map(|line| -> Result<_, Failure> {
            let mut line = SolveLine::try_parse_from(line).map_err(|error| wrong_flag("solve", &error))?;
            line.args.given_by((given.giver)("solve"));
            case.task.get("test").map_or(Ok(()), |test| line.args.set_test(test))?;
            line.args.validate_alone().map(|()| line.args)
        });
        let effective = effective_line.map(|line| -> Result<_, Failure> {
            let mut line = EffectiveLine::try_parse_from(line).map_err(|error| wrong_flag("effective", &error))?;
            line.args.giver = (given.giver)("effective");
            line.args.validate().map(|()| line.args)
        });
        let (mesh, solve, effective) = (mesh.transpose()?, solve.transpose()?, effective.transpose()?);
        claim((outputs, keep), mesh.as_ref(), solve.is_some(), effective.as_ref())?;
        let outputs = outputs.iter().map(|name| packing_file(folder, name)).collect::<Result<_, _>>()?;
        Ok(Self { outputs, keep, mesh, solve, effective, threads: given.threads })
    }

    /// Refuses flags that the packing of `spec` cannot be meshed or tested with, and a missing gmsh.
    pub(super) fn check(&self, spec: &Spec) -> Result<(), Failure> {
        self.mesh.as_ref().map_or(Ok(()), |mesh| mesh.check(spec))?;
        self.effective.as_ref().map_or(Ok(()), |effective| effective.check(spec))?;
        self.solve.as_ref().map_or(Ok(()), |solve| solve.check(spec))
    }

    /// The files that the flags name, for the packing and its mesh.
    pub(super) fn files(&self) -> Vec<PathBuf> {
        let packings = self.outputs.iter().map(|(path, _)| path.clone());
        packings.chain(self.mesh.iter().flat_map(|mesh| mesh.outputs().to_owned())).collect()
    }

    /// Does the case: its results or the error that is kept, and its warnings. An interrupted case has none of them: see
    /// [`interrupt::asked`].
    pub(super) fn run(&self, case: &Case, folder: &Path) -> CaseOutcome {
        let work = || catch_unwind(AssertUnwindSafe(|| self.all(case, folder))).unwrap_or(Err(Failure::Bug));
        let (ended, said) = stderr::of(&case.folder, work);
        let ended = ended.map_err(|failure| failure.message().to_owned());
        // A test with errors ends as others do: its figures are in the folder, and its case has failed.
        let results = match said.errors.is_empty() {
            true => ended,
            false => Err(said.errors.join("; ")),
        };
        CaseOutcome { results, warnings: said.warnings }
    }

    fn all(&self, case: &Case, folder: &Path) -> Result<Map<String, Value>, Failure> {
        let model = threads::with(self.threads, || pack(&self.with_room(&case.spec)?))??;
        if interrupt::asked() {
            return Ok(Map::new());
        }
        threads::with(self.threads, || self.write(&model, folder))??;
        let mut results = of_packing(&model.report);
        drop(model);
        if let Some(args) = &self.mesh {
            if mesh::run(args)? == SHORT {
                let message =
                    "a phase is more than 1 % off its exact volume, which [mesh] strict refuses; mesh.json has it";
                return Err(Failure::Run(message.to_owned()));
            }
            results.insert("mesh".to_owned(), summary(&folder.join(MESH_SUMMARY))?);
        }
        if let Some(args) = &self.solve {
            let code = solve::run(args)?;
            if code == INTERRUPTED {
                return Ok(Map::new());
            }
            let result = read(&folder.join(SOLVE_SUMMARY))?;
            // The errors of a test that came to its end are among its results.
            if code != 0 && result["ended"] != "completed" {
                return Err(Failure::Run("the test has no valid end; result.json says why".to_owned()));
            }
            results.insert("solve".to_owned(), of_summary(&result));
        }
        if let Some(args) = &self.effective {
            effective::run(args)?;
            results.insert("effective".to_owned(), of_effective(&read(&folder.join(FIGURES))?));
        }
        self.keep.tidy(folder).map_err(|error| Failure::file(folder, &error))?;
        Ok(results)
    }

    /// The spec of a case, with the gaps that its mesh and its test need.
    fn with_room(&self, spec: &Spec) -> Result<Spec, Failure> {
        let mut spec = spec.clone();
        self.mesh.as_ref().map_or(Ok(()), |mesh| mesh.leave_room(&mut spec))?;
        self.solve.as_ref().map_or(Ok(()), |solve| solve.leave_room(&mut spec, &Silent))?;
        Ok(spec)
    }

    fn write(&self, model: &Model, folder: &Path) -> Result<(), Failure> {
        let mut unit = Unit::unforced();
        let format = if self.keep == Keep::JsonGz { Format::JsonGz } else { Format::Json };
        let saved = (folder.join(self.keep.model()), format);
        for (path, format) in std::iter::once(&saved).chain(&self.outputs) {
            let target = Target::new(path, true)?;
            unit.fill(&target, true, |out| format.write(model, SurfaceOptions::default(), out))?;
        }
        unit.commit()
    }
}

/// Refuses files that two steps would write under one name.
fn claim(
    (outputs, keep): (&[String], Keep),
    mesh: Option<&mesh::Args>,
    has_test: bool,
    effective: Option<&effective::Args>,
) -> Result<(), Failure> {
    let mut names = Names::default();
    let wrong = |error: NameError| Failure::Usage(error.to_string());
    let summary = mesh.map(|_| MESH_SUMMARY);
    let own = [keep.model(), RECORD].into_iter().chain(summary);
    own.into_iter().try_for_each(|name| names.claim("the study", name)).map_err(wrong)?;
    if has_test {
        solve::Args::claim("[solve]", &mut names).map_err(wrong)?;
    }
    let properties = effective.map_or_else(Vec::new, effective::Args::files);
    properties.iter().try_for_each(|name| names.claim("[effective]", name)).map_err(wrong)?;
    outputs.iter().try_for_each(|name| names.claim("outputs", name)).map_err(wrong)?;
    mesh.map_or(Ok(()), |mesh| mesh.claim("[mesh] output", &mut names))
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
    Ok((folder.join(name), format))
}

/// The words of a command line for the `flags` of a section; `output` goes to `folder`, if the section has an output.
fn words(
    section: &str,
    flags: &Map<String, Value>,
    folder: Option<&Path>,
    study: &Path,
) -> Result<Vec<String>, Failure> {
    let mut line = Vec::new();
    for (key, value) in flags {
        let flag = key.replace('_', "-");
        // Anything else may be more than one word: "gmsh=./program" would be a flag with its value.
        if !flag.bytes().all(|byte| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'-') {
            return Err(Failure::Usage(format!(
                "[{section}] {key:?} is not a flag; mesocrete {section} --help lists them"
            )));
        }
        if flag == "gmsh" {
            let message =
                format!("[{section}] gmsh names a program, which no file may do; remove it, and give --gmsh PROGRAM");
            return Err(Failure::Usage(message));
        }
        if ["force", "quiet", "threads", "summary-json", "resume", "help"].contains(&flag.as_str())
            || (flag == "output" && folder.is_none())
        {
            return Err(Failure::Usage(format!("[{section}] {key} is set by the study; remove it")));
        }
        if let Some(of_packings) = Over::key_of(&flag).filter(|_| section == "solve").map(of_packings) {
            let message = format!("[solve] {key} is of the packing, which the study makes; give {of_packings}");
            return Err(Failure::Usage(message));
        }
        if flag_files::is_hash(&flag) {
            continue;
        }
        let values = value.as_array().map_or(std::slice::from_ref(value), Vec::as_slice);
        for value in values {
            match (value, folder) {
                (Value::Bool(given), _) => line.extend(given.then(|| format!("--{flag}"))),
                (Value::String(name), Some(folder)) if flag == "output" => {
                    Names::default().claim("[mesh] output", name).map_err(|error| Failure::Usage(error.to_string()))?;
                    line.push(format!("--output={}", folder.join(name).display()));
                }
                (Value::String(file), _) if flag_files::is_file(&flag, file) => {
                    line.push(format!("--{flag}={}", beside(study, file).display()));
                }
                (Value::String(text), _) => line.push(format!("--{flag}={text}")),
                (value, _) => line.push(format!("--{flag}={value}")),
            }
        }
    }
    Ok(line)
}

/// A fault of a section's options, by their keys; others in clap's words, without the usage that follows.
fn wrong_flag(section: &str, error: &clap::Error) -> Failure {
    let of = |kind: ContextKind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.as_str()),
        _ => None,
    };
    let why = match error.get(ContextKind::ValidValue) {
        Some(ContextValue::Strings(names)) => Some(format!("it must be one of {}", names.join(", "))),
        _ => error.source().map(ToString::to_string),
    };
    let key = |flag: &str| Some(flag.strip_prefix("--")?.split([' ', '=']).next()?.replace('-', "_"));
    let key = of(ContextKind::InvalidArg).and_then(key);
    let meant = of(ContextKind::SuggestedArg).map(|meant| format!("did you mean {}? ", meant.trim_start_matches('-')));
    Failure::Usage(match (key, of(ContextKind::InvalidValue), why) {
        (Some(key), Some(value), Some(why)) => format!("[{section}] {key} is {value}; {why}"),
        (Some(key), None, None) if error.kind() == ErrorKind::UnknownArgument => format!(
            "[{section}] {key} is not known; {}mesocrete {section} --help lists the options",
            meant.unwrap_or_default()
        ),
        _ => {
            let text = error.to_string();
            let message = text.split("\n\n").next().unwrap_or(&text).replace('\n', " ");
            format!("[{section}] {}", message.trim_start_matches("error: "))
        }
    })
}

fn summary(path: &Path) -> Result<Value, Failure> {
    read(path).map(|summary| of_summary(&summary))
}

fn read(path: &Path) -> Result<Value, Failure> {
    let bytes = std::fs::read(path).map_err(|error| Failure::file(path, &error))?;
    serde_json::from_slice(&bytes).map_err(|error| Failure::Run(format!("{}: {error}", path.display())))
}
