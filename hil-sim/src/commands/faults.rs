//! `faults`: the fault campaign.

use miette::IntoDiagnostic;

use super::progress::Progress;
use crate::campaign;
use crate::cli::FaultsArgs;

/// Runs the campaign; `false` where a cell falls short.
pub fn faults(args: &FaultsArgs) -> miette::Result<bool> {
    let progress = Progress::counting("fault campaign", "cells");
    let campaign =
        campaign::run(args.only, args.seed, &|done, planned| progress.show(done, planned));
    drop(progress);
    let campaign = campaign.into_diagnostic()?;
    if args.json {
        println!("{}", serde_json::to_string(&campaign.json()).into_diagnostic()?);
    } else {
        print!("{}", campaign::table(&campaign));
    }
    Ok(campaign.passed() == campaign.cells.len())
}
