//! The script of a Slurm array that does a study, to be edited.

use super::Args;
use crate::failure::Failure;
use crate::inputs;
use crate::outputs::{Target, Unit};
use crate::stderr::flag;
use meso_gmsh::Gmsh;
use meso_study::{Plan, StudyFile, StudyLayout};
use std::path::Path;

/// Memory of a process beside what its case asks for, bytes.
const BESIDE: f64 = 3e8;

/// Prints the script of an array of so many tasks, at most one a case.
pub(super) fn print(tasks: u32, plan: &Plan, file: &StudyFile, gmsh: &Gmsh, args: &Args) -> Result<u8, Failure> {
    args.named_file("slurm")?;
    let tasks = (tasks as usize).min(plan.cases.len());
    let mut most = 0.0_f64;
    for case in &plan.cases {
        most = most.max(file.steps(case, &inputs::text)?.memory(&case.spec, gmsh));
    }
    let jobs = args.jobs.unwrap_or(1);
    let threads = u32::from(args.threads.unwrap_or(1)) * u32::from(jobs);
    // The estimates are of arrays; allocators take a fifth more.
    let megabytes = ((1.2 * most + BESIDE) * f64::from(jobs) / 1e8).ceil() * 100.0;
    let command = args.command();
    let name = shell(&args.study.file_stem().unwrap_or_default().to_string_lossy());
    let text = format!(
        "#!/bin/bash
# {cases} cases by {tasks} tasks. Edit the time; see docs/clusters.md. Afterwards, or at any time: {again} {collect}
# Without Slurm: parallel -q -j 2 {command} {shard} {{}}/{tasks} ::: $(seq {tasks})
#SBATCH --job-name={name}
#SBATCH --array=1-{tasks}
#SBATCH --cpus-per-task={threads}
#SBATCH --mem={megabytes}M
#SBATCH --time=1-00:00:00
#SBATCH --requeue
#SBATCH --open-mode=append
exec {command} {shard} \"$SLURM_ARRAY_TASK_ID/{tasks}\"
",
        cases = plan.cases.len(),
        again = args.folder_command(),
        collect = flag("collect"),
        shard = flag("shard"),
    );
    Unit::default().fill(&Target::Stdout, false, |out| out.write_all(text.as_bytes()))?;
    Ok(0)
}

impl Args {
    /// The command of a task, with the options of this one.
    fn command(&self) -> String {
        let mut words = self.folder_command();
        let mut add = |key: &str, value: Option<String>| {
            words.extend(value.map(|value| format!(" {} {value}", flag(key))));
        };
        add("threads", Some(self.threads.unwrap_or(1).to_string()));
        add("jobs", self.jobs.map(|jobs| jobs.to_string()));
        add("min_gap_mm", self.min_gap_mm.map(|gap| gap.to_string()));
        add("time_limit_s", self.time_limit.map(|seconds| seconds.to_string()));
        add("gmsh", self.gmsh.as_deref().map(path));
        add(
            "layout",
            self.layout.filter(|layout| *layout == StudyLayout::Table).map(|layout| layout.name().to_owned()),
        );
        add("retry_failed", self.retry_failed.then(String::new));
        words.trim_end().to_owned()
    }

    fn folder_command(&self) -> String {
        format!("mesocrete study {} -o {}", path(&self.study), path(&self.output))
    }
}

fn path(path: &Path) -> String {
    shell(&path.to_string_lossy())
}

/// A word of a shell.
fn shell(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./+".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}
