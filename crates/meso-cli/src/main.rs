//! The `mesocrete` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(meso_cli::run(std::env::args_os()))
}
