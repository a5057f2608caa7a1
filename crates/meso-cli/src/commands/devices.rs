//! `mesocrete devices`: what `solve --device` can take, and whether it keeps the promise of the same bytes.

use crate::failure::{Failure, RUN};
use crate::outputs::{Target, Unit};
use crate::{gpu, stderr};

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// Run a small test on every device and on this processor, and compare their curves bit by bit
    #[arg(long)]
    check: bool,
}

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    let lines = gpu::lines(args.check)?;
    if lines.is_empty() {
        stderr::line(gpu::none());
    }
    Unit::default().fill(&Target::Stdout, false, |out| lines.iter().try_for_each(|line| writeln!(out, "{line}")))?;
    Ok(if lines.iter().any(|line| line.contains(gpu::FAILED)) { RUN } else { 0 })
}
