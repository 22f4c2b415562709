//! `faults`: the fault campaign.

use std::path::Path;

use miette::IntoDiagnostic;

use super::progress::Progress;
use crate::campaign::{self, Options};
use crate::cli::FaultsArgs;
use crate::report;

/// Where the report of the whole campaign goes; that of one row does not take its place.
const FOLDER: &str = "out/faults";

/// Runs the campaign; `false` where a cell falls short.
pub fn faults(args: &FaultsArgs) -> miette::Result<bool> {
    let progress = Progress::counting("fault campaign", "cells");
    let options = Options { only: args.only, seed: args.seed, image: args.image.clone() };
    let campaign = campaign::run(&options, &|done, planned| progress.show(done, planned));
    drop(progress);
    let campaign = campaign.into_diagnostic()?;
    let folder = args.only.map_or(FOLDER.into(), |row| format!("{FOLDER}-{row}"));
    let page = report::write_campaign(Path::new(&folder), &campaign).into_diagnostic()?;
    if args.json {
        super::print_json(&campaign.json())?;
    } else {
        say!("{}", campaign::table(&campaign).trim_end());
        say!("Report: {}", page.display());
    }
    Ok(campaign.passed() == campaign.cells.len())
}
