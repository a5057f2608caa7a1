//! `mesocrete check`: the exact, independent check of a saved model.

use super::shared::Threads;
use crate::failure::{Failure, RUN};
use crate::outputs::{Target, Unit};
use crate::progress::{Watch, of_model};
use crate::stderr::flag;
use crate::{inputs, stderr};
use meso_concrete::thousands;
use meso_core::Model;
use meso_core::check::{Check, Finding};
use meso_core::watch::Stage;
use serde::Serialize;
use std::io::{self, Write};
use std::path::PathBuf;

/// Findings listed one by one; the rest is counted.
const LISTED: usize = 20;

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// A saved model (.json or .json.gz); `-` is standard input
    model: PathBuf,
    /// Write the findings as JSON instead of a table
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    threads: Threads,
    /// Print only the table, the findings, warnings and errors
    #[arg(short, long)]
    quiet: bool,
}

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    let mut watch = Watch::of_files(args.quiet, &of_model(Stage::Prove, 0.5));
    let model = inputs::model(&args.model, &watch)?;
    let found = args.threads.run(|| Check::of(&model, &watch))?;
    watch.finish();
    Unit::default()
        .fill(&Target::Stdout, false, |out| if args.json { json(&found, out) } else { table(&model, &found, out) })?;
    if found.is_sound() {
        return Ok(0);
    }
    let name = args.model.display();
    stderr::line(format!("error: {name}: {} of its promises are not kept", thousands(found.findings.len())));
    Ok(RUN)
}

#[derive(Serialize)]
struct Json<'a> {
    sound: bool,
    #[serde(flatten)]
    check: &'a Check,
}

fn json(check: &Check, out: &mut dyn Write) -> io::Result<()> {
    serde_json::to_writer_pretty(&mut *out, &Json { sound: check.is_sound(), check })?;
    writeln!(out)
}

/// Figures of the table, and the findings that count among them.
type Row = (&'static str, fn(&Finding) -> bool);

fn table(model: &Model, check: &Check, out: &mut dyn Write) -> io::Result<()> {
    let gap = model.spec.placement.min_gap_mm;
    let mut rows: Vec<Row> = vec![
        ("overlapping pairs", |f| matches!(f, Finding::Overlap { .. })),
        ("pairs nearer than the gap", |f| matches!(f, Finding::Gap { .. })),
        ("aggregates outside the specimen", |f| matches!(f, Finding::Outside { .. })),
        ("aggregates not closed and convex", |f| matches!(f, Finding::NotConvex { .. })),
        ("aggregates without a sound ITZ", |f| matches!(f, Finding::Itz { .. })),
        ("aggregates outside their class", |f| matches!(f, Finding::Size { .. })),
        ("bodies that the seed does not give", |f| matches!(f, Finding::NotTaken { .. })),
        ("figures of the report that differ", |f| matches!(f, Finding::Report { .. })),
    ];
    writeln!(out, "{:34} {:>12}", "aggregates", thousands(check.aggregates))?;
    if !model.inclusions.is_empty() {
        writeln!(out, "{:34} {:>12}", "voids and fibres", thousands(model.inclusions.len()))?;
        rows.push(("voids and fibres of a wrong size", |f| matches!(f, Finding::Shape { .. })));
    }
    writeln!(out, "{:34} {:>12.6}", "fraction", check.fraction)?;
    writeln!(out, "{:34} {:>12}", "pairs put to the exact test", thousands(check.pairs_tested as usize))?;
    writeln!(out, "{:34} {gap:>12}", "gap asked between aggregates, mm")?;
    for (name, of_kind) in rows {
        let count = check.findings.iter().filter(|finding| of_kind(finding)).count();
        writeln!(out, "{name:34} {:>12}", thousands(count))?;
    }
    check.findings.iter().take(LISTED).try_for_each(|finding| writeln!(out, "  {finding}"))?;
    if check.findings.len() > LISTED {
        let (more, json) = (thousands(check.findings.len() - LISTED), flag("json"));
        writeln!(out, "  and {more} more; {json} lists all")?;
    }
    writeln!(out, "not checked:")?;
    check.not_checked.iter().try_for_each(|what| writeln!(out, "  {what}"))?;
    writeln!(out, "{}", if check.is_sound() { "sound: every promise that was checked is kept" } else { "NOT sound" })
}
