//! Flags that several commands have, with one meaning.

use super::values;
use crate::failure::Failure;
use crate::threads;
use meso_study::Share;

// A doc comment here would become the command's own description.
#[derive(clap::Args, Debug)]
pub(super) struct Threads {
    /// Number of threads; all cores when absent. It changes the time, never the result
    #[arg(long, value_name = "N", value_parser = values::threads, allow_negative_numbers = true)]
    threads: Option<u16>,
}

impl Threads {
    /// Runs `work` on as many threads as asked.
    pub(super) fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
        threads::with(self.threads, work)
    }
}

#[derive(clap::Args, Debug)]
pub(super) struct Writing {
    /// Replace files that are there already
    #[arg(short, long)]
    pub(super) force: bool,
    /// Print only warnings and errors
    #[arg(short, long)]
    pub(super) quiet: bool,
}

/// Reads `K/N`.
pub(crate) fn share(text: &str) -> Result<Share, String> {
    let wrong = || format!("{text} must be K/N, whole numbers with K from 1 to N, as 3/40");
    let (shard, of) = text.split_once('/').ok_or_else(wrong)?;
    let (shard, of) = (shard.parse().map_err(|_| wrong())?, of.parse().map_err(|_| wrong())?);
    if (1..=of).contains(&shard) { Ok(Share { shard, of }) } else { Err(wrong()) }
}
