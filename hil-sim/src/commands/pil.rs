//! `pil`: the board's image against the same firmware run as software.

use miette::IntoDiagnostic;

use super::progress::Progress;
use super::run::{default_folder, overridden, print_outcome};
use crate::cli::PilArgs;
use crate::{pil, report};

/// Runs the comparison; `false` where the builds differ or the run is not good.
pub fn pil(args: &PilArgs) -> miette::Result<bool> {
    let scenario = overridden(&args.choice)?;
    let progress = Progress::new(&format!("{} on the emulated board", scenario.name));
    let verdict = pil::run(&scenario, &args.image, &|done, planned| progress.show(done, planned));
    drop(progress);
    let verdict = verdict.into_diagnostic()?;
    print_outcome(&verdict.outcome);
    say!("  board's stack: {} bytes used", verdict.stack_bytes);
    match &verdict.difference {
        None => say!("  bit for bit as in software, {} ticks", verdict.outcome.ticks),
        Some(difference) => say!("DIFFERENCE at {difference}"),
    }
    if !args.no_output {
        let folder = args.out.clone().unwrap_or_else(|| default_folder(&scenario));
        let evidence = report::write_evidence(&folder, &verdict.outcome).into_diagnostic()?;
        if let Some(path) = evidence {
            say!("Evidence: {}", path.display());
        }
    }
    Ok(verdict.difference.is_none() && verdict.outcome.is_good())
}
