//! The same seed gives the same log byte for byte, another seed another one.

use std::fs;

use hil_sim::report;
use hil_sim::run::{self, Options};
use hil_sim::scenario::{Disturbance, Scenario};

/// The log of a short lift.
fn log(seed: u64, disturbance: Option<Disturbance>) -> Vec<u8> {
    let mut scenario = Scenario::load("paper").expect("a shipped scenario");
    scenario.seed = seed;
    scenario.duration_s = 3.0;
    scenario.plant.disturbance = disturbance.unwrap_or(scenario.plant.disturbance);
    let options = Options { keep_rows: true, progress: &|_, _| () };
    let outcome = run::run(&scenario, options).expect("a configuration in range");
    assert_eq!(outcome.rows.len(), 6_001, "{:?}", outcome.broken_limits);
    let folder = tempfile::tempdir().expect("a temporary folder");
    report::write(folder.path(), &[outcome]).expect("a writable folder");
    fs::read(folder.path().join("log.csv")).expect("a log")
}

#[test]
fn same_seed_same_log_other_seed_other_log() {
    for disturbance in [None, Some(Disturbance::EachTick)] {
        let first = log(7, disturbance);
        // Not `assert_eq`: nobody wants to read two logs.
        assert!(first == log(7, disturbance), "two runs of one seed differ");
        assert!(first != log(8, disturbance), "the seed changes nothing");
    }
}
