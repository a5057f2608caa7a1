//! `mesocrete completions` and `mesocrete man`: completions for shells, and manual pages.

use super::Cli;
use crate::failure::Failure;
use crate::outputs::{Target, Unit};
use crate::stderr;
use clap::CommandFactory;
use clap_complete::Shell;
use std::path::PathBuf;

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// Which shell
    #[arg(value_enum)]
    shell: Shell,
}

#[derive(clap::Args, Debug)]
pub(crate) struct ManArgs {
    /// Folder of the pages: mesocrete.1, mesocrete-pack.1, ...; it is made if it does not exist
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Replace pages that are there already
    #[arg(short, long)]
    force: bool,
}

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "mesocrete", &mut script);
    Unit::default().fill(&Target::Stdout, false, |out| out.write_all(&script))?;
    Ok(0)
}

/// One page for the command and one for each of its subcommands.
pub(crate) fn man(args: &ManArgs) -> Result<u8, Failure> {
    let mut unit = Unit::default();
    let mut command = Cli::command();
    command.build();
    let own = command.get_subcommands().filter(|sub| sub.get_name() != "help").cloned();
    let pages: Vec<clap::Command> = own.collect();
    let count = 1 + pages.len();
    std::fs::create_dir_all(&args.folder).map_err(|error| Failure::file(&args.folder, &error))?;
    for page in std::iter::once(command).chain(pages) {
        let name = page.get_display_name().unwrap_or_else(|| page.get_name()).to_owned();
        let target = Target::new(&args.folder.join(format!("{name}.1")), args.force)?;
        unit.fill(&target, args.force, |out| clap_mangen::Man::new(page).render(&mut &mut *out))?;
    }
    unit.commit()?;
    stderr::line(format!("wrote {count} pages to {0}; read one: man {0}/mesocrete.1", args.folder.display()));
    Ok(0)
}
