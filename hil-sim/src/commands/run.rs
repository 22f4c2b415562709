//! `run`, and the main job without arguments: the paper's Table 3.

use std::path::{Path, PathBuf};

use miette::IntoDiagnostic;

use super::progress::Progress;
use crate::cli::{Choice, RunArgs};
use crate::outcome::{Adaptation, Law, Metrics, Outcome};
use crate::report;
use crate::run::{self, Options};
use crate::scenario::Scenario;

/// The controllers that Table 3 sets side by side.
const TABLE_3: [(Law, Adaptation); 3] = [
    (Law::Backstepping, Adaptation::Inertia),
    (Law::Backstepping, Adaptation::Paper),
    (Law::Pd, Adaptation::None),
];

/// Runs `paper` with three controllers, prints Table 3 and writes the report.
pub fn table3() -> miette::Result<bool> {
    let mut scenario = Scenario::load("paper")?;
    let mut outcomes = Vec::new();
    for (law, adaptation) in TABLE_3 {
        (scenario.controller.law, scenario.controller.adaptation) = (law, adaptation);
        outcomes.push(one(&scenario, true)?);
    }
    say!("{}", report::table3(&outcomes));
    for outcome in &outcomes {
        print_verdict(outcome);
    }
    let page = report::write(&default_folder(&scenario), &outcomes).into_diagnostic()?;
    say!("Report: {}", page.display());
    Ok(outcomes.iter().all(Outcome::is_good))
}

/// Runs one scenario with the options of the command line.
pub fn run(args: &RunArgs) -> miette::Result<bool> {
    let scenario = overridden(&args.choice)?;
    let outcome = one(&scenario, !args.no_output)?;
    // What cannot be printed is written all the same.
    let printed = if args.json {
        super::print_json(&outcome)
    } else {
        print_outcome(&outcome);
        Ok(())
    };
    if !args.no_output {
        let folder = args.out.clone().unwrap_or_else(|| default_folder(&scenario));
        let page = report::write(&folder, std::slice::from_ref(&outcome)).into_diagnostic()?;
        if !args.json {
            say!("Report: {}", page.display());
            if outcome.evidence.is_some() {
                say!("Evidence: {}", folder.join("evidence.csv").display());
            }
        }
    }
    printed?;
    Ok(outcome.is_good())
}

/// The scenario with what the command line overrides.
pub fn overridden(args: &Choice) -> miette::Result<Scenario> {
    let mut scenario = Scenario::load(&args.scenario)?;
    let controller = &mut scenario.controller;
    controller.law = args.law.unwrap_or(controller.law);
    let adapts = matches!(args.adaptation, Some(Adaptation::Inertia | Adaptation::Paper));
    if controller.law == Law::Pd && adapts {
        miette::bail!("--adaptation is for --law backstepping; the PD adapts nothing");
    }
    controller.adaptation = args.adaptation.unwrap_or(controller.adaptation);
    scenario.tick_hz = args.tick_hz.unwrap_or(scenario.tick_hz);
    scenario.seed = args.seed.unwrap_or(scenario.seed);
    Ok(scenario)
}

fn one(scenario: &Scenario, keep_rows: bool) -> miette::Result<Outcome> {
    let progress = Progress::new(&scenario.name);
    let options = Options { keep_rows, progress: &|done, planned| progress.show(done, planned) };
    run::run(scenario, options).into_diagnostic()
}

/// Where a run's files go unless told otherwise.
pub fn default_folder(scenario: &Scenario) -> PathBuf {
    Path::new("out").join(&scenario.name)
}

/// Prints metrics and verdict.
pub fn print_outcome(outcome: &Outcome) {
    let m = &outcome.metrics;
    say!("{} with {} at {} Hz", outcome.scenario, outcome.label(), outcome.tick_hz);
    let [x, y, z, rse, rho, e_max] =
        [m.rms_m[0], m.rms_m[1], m.rms_m[2], m.rse_m, m.rho_s, m.e_max_m].map(Metrics::figure);
    say!("  RMS x, y, z  {x}  {y}  {z} m");
    say!("  RSE          {rse} m");
    say!("  rho          {rho} s");
    say!("  e_max        {e_max} m");
    say!("  v_max        {} m/s", Metrics::speed(m.v_max_m_s));
    say!("  {} ticks, {:.0} times real time", outcome.ticks, outcome.realtime_factor);
    print_happenings(outcome);
    print_verdict(outcome);
}

/// Prints what happened, since the trajectory's start if there was one.
fn print_happenings(outcome: &Outcome) {
    if !outcome.happenings.is_empty() {
        let since = if outcome.start_s.is_some() { "the trajectory's start" } else { "power-up" };
        say!("  faults, s since {since} (seed {}):", outcome.seed);
    }
    for happening in &outcome.happenings {
        let t_s = happening.true_s - outcome.start_s.unwrap_or(0.0);
        say!("  {t_s:10.4}  {}", happening.event);
    }
}

fn print_verdict(outcome: &Outcome) {
    for fault in &outcome.faults {
        let expected = if Some(fault) == outcome.expected.as_ref() { ", as expected" } else { "" };
        say!("FAULT {}: {fault}, mode {}{expected}", outcome.label(), outcome.mode);
    }
    for limit in &outcome.broken_limits {
        say!("LIMIT {}: {limit}", outcome.label());
    }
}
