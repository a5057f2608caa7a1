//! The `mesocrete` command as a function, so that the binary and the Python package run the same code.
//!
//! stdout carries data only; progress and messages go to stderr. Arguments (`commands`) become a spec, options and
//! `outputs`; then the core works; then files appear whole or not at all.

mod commands;
mod failure;
mod formats;
#[cfg_attr(not(feature = "gpu"), path = "no_gpu.rs")]
mod gpu;
mod inputs;
mod interrupt;
mod outputs;
mod own_folder;
mod progress;
mod room;
mod stderr;
mod threads;

use clap::Parser;
use commands::{Cli, Command};
use failure::Failure;
use meso_concrete::printable;
use std::ffi::OsString;
use std::io::{ErrorKind, Write};
use std::panic::AssertUnwindSafe;
use std::path::Path;

/// The Python package around the command: it does the work of this name that a request in JSON asks for, and returns the exit
/// code, or says why it cannot.
pub type Python<'a> = dyn Fn(&str, &str) -> Result<u8, String> + Sync + 'a;

/// Runs the command with `args` (the program's name first) and returns its exit code.
pub fn run(args: impl IntoIterator<Item = OsString>) -> u8 {
    run_in(args, None)
}

/// Runs the command within the Python package, which does some work for it; see [`run`].
pub fn run_in(args: impl IntoIterator<Item = OsString>, python: Option<&Python<'_>>) -> u8 {
    let cli = match Cli::try_parse_from(args) {
        Ok(cli) => cli,
        Err(error) => return usage(&error),
    };
    failure::hush_panics();
    interrupt::install();
    std::panic::catch_unwind(AssertUnwindSafe(|| dispatch(cli.command, python)))
        .unwrap_or(Err(Failure::Bug))
        .unwrap_or_else(|failure| failure.print())
}

/// Reads `args` and refuses flags that are wrong with any file, as every command does before its work. It opens no file, runs no
/// program and prints no error.
///
/// # Errors
/// The message of wrong usage.
#[doc(hidden)]
pub fn validate(args: impl IntoIterator<Item = OsString>) -> Result<(), String> {
    let cli = match Cli::try_parse_from(args) {
        Ok(cli) => cli,
        // Help and version are no errors.
        Err(error) => return if error.use_stderr() { Err(error.to_string()) } else { Ok(()) },
    };
    cli.command.unread().map_err(|failure| failure.message().to_owned())
}

/// Reads a STUDY.toml that names no other file, and plans it, as `mesocrete study` does before its work: the files that each
/// case would write. It opens no file and runs no program.
///
/// # Errors
/// The message about an invalid study.
#[doc(hidden)]
pub fn validate_study(text: &str) -> Result<Vec<Vec<std::path::PathBuf>>, String> {
    commands::study::unread(text).map_err(|failure| failure.message().to_owned())
}

fn dispatch(command: Command, python: Option<&Python<'_>>) -> Result<u8, Failure> {
    match command {
        Command::Pack(args) => commands::pack::run(&args),
        Command::Mesh(args) => commands::mesh::run(&args),
        Command::Solve(args) => commands::solve::run(&args),
        Command::Devices(args) => commands::devices::run(&args),
        Command::Study(args) => commands::study::run(&args, python),
        Command::Dataset(args) => commands::dataset::run(&args, python),
        Command::Fit(args) => commands::fit::run(&args),
        Command::Check(args) => commands::check::run(&args),
        Command::Report(args) => commands::report::run(&args),
        Command::Convert(args) => commands::convert::run(&args),
        Command::Image(args) => commands::image::run(&args),
        Command::Import(args) => commands::import::run(&args),
        Command::Effective(args) => commands::effective::run(&args),
        Command::Init(args) => commands::init::run(&args),
        Command::Schema(args) => commands::schema::run(&args),
        Command::Completions(args) => commands::completions::run(&args),
        Command::Man(args) => commands::completions::man(&args),
        Command::Recipes => commands::recipes::run(),
    }
}

/// Help and version go to stdout and are no failure, unless they cannot be written; any other error is wrong usage.
fn usage(error: &clap::Error) -> u8 {
    let text = error.render().to_string();
    if error.use_stderr() && text.lines().any(|line| printable(line) != line) {
        // Words of the command line may be names of strangers' files.
        text.lines().for_each(stderr::line);
        return failure::USAGE;
    }
    let printed = error.print().and_then(|()| std::io::stdout().flush());
    match printed {
        _ if error.use_stderr() => failure::USAGE,
        Err(unwritten) if unwritten.kind() != ErrorKind::BrokenPipe => {
            Failure::file(Path::new("standard output"), &unwritten).print()
        }
        _ => 0,
    }
}
