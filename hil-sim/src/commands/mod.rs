//! What the commands of the command line do.

/// Prints a line. Whoever reads may have had enough of it, as `head` has: no reason to fail.
macro_rules! say {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout(), $($text)*);
    }};
}

mod faults;
mod model;
mod pil;
mod progress;
mod run;

use std::io::Write as _;

use comfy_table::{Table, presets};
use miette::{Context as _, IntoDiagnostic as _};
use serde::Serialize;

use crate::cli::{Cli, Command};
use crate::scenario::Scenario;

/// Carries out a command; `false` where a run ended in a fault or broke its limits.
///
/// # Errors
/// Bad input, or output that could not be written; it prints as one clear message.
pub fn execute(cli: &Cli) -> miette::Result<bool> {
    match &cli.command {
        None => run::table3(),
        Some(Command::Run(args)) => run::run(args),
        Some(Command::Pil(args)) => pil::pil(args),
        Some(Command::Faults(args)) => faults::faults(args),
        Some(Command::List) => {
            list();
            Ok(true)
        }
        Some(Command::Model(args)) => model::model(args),
    }
}

/// Prints a value for a program, which would not notice that it is missing.
fn print_json(value: &impl Serialize) -> miette::Result<()> {
    let text = serde_json::to_string(value).into_diagnostic()?;
    writeln!(std::io::stdout(), "{text}")
        .into_diagnostic()
        .wrap_err("the JSON could not be written to the standard output")
}

fn list() {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    for (name, summary) in Scenario::shipped() {
        table.add_row([name, &summary]);
    }
    say!("{}", table.trim_fmt());
}
