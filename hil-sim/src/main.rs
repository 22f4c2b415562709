//! Command line of the harness.

use std::process::ExitCode;

use clap::Parser;
use hil_sim::cli::Cli;
use hil_sim::commands;

fn main() -> ExitCode {
    let cli = Cli::parse();
    match commands::execute(&cli) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            eprintln!("{error:?}");
            ExitCode::from(2)
        }
    }
}
