//! `docs/scenarios.md` against the table of kinds of fault; its example and the README's, run as they stand.

use firmware::controller::Core;
use hil_sim::faults::{self, SPECS};
use hil_sim::outcome::Outcome;
use hil_sim::run::{self, Options, Software, kept_of};
use hil_sim::scenario::Scenario;
use hil_sim::session::Session;

use crate::markdown::{Document, compare, conclude, document};

const DOCUMENT: Document = document!("scenarios.md");
const README: &str = include_str!("../../README.md");

/// Rows of the command line's table, which is made of [`SPECS`]: name, targets, effect and severity.
fn expected() -> Vec<String> {
    let table = faults::table();
    let mut rows: Vec<[String; 4]> = Vec::new();
    for line in table.lines() {
        let text = line.trim();
        if !line.starts_with("   ") {
            let (name, targets) = text.split_once(char::is_whitespace).expect("name and targets");
            let targets = targets.trim().to_owned();
            rows.push([format!("`{name}`"), targets, "-".to_owned(), String::new()]);
            continue;
        }
        let Some([_, _, severity, what]) = rows.last_mut() else { continue };
        match text.strip_prefix("severity: ") {
            Some(text) => *severity = sizeless(text),
            None => text.clone_into(what),
        }
    }
    assert_eq!(
        rows.len(),
        SPECS.len(),
        "the command line's table has another form than this reads"
    );
    rows.iter().map(|cells| format!("| {} |", cells.join(" | "))).collect()
}

/// A severity's text, without the sizes of memory that change with every parameter.
fn sizeless(text: &str) -> String {
    let Some((head, rest)) = text.split_once("number of the bit, a whole number from 0 to ") else {
        return text.to_owned();
    };
    let last =
        if rest.contains("smaller place") { "the last one of the place" } else { "the last one" };
    let default = rest.split_once(", ").map_or("", |(_, default)| default);
    format!("{head}number of the bit, a whole number from 0 to {last}, {default}")
}

#[test]
fn the_table_of_kinds_is_that_of_the_code() {
    let rows = DOCUMENT.rows("## Kinds");
    let written: Vec<_> = rows.iter().map(|row| format!("| {} |", row.cells.join(" | "))).collect();
    conclude(&compare(DOCUMENT.name, "row", &written, &expected()));
}

/// The first block of TOML below a heading.
fn example<'a>(text: &'a str, heading: &str) -> &'a str {
    let below = text.split_once(&format!("\n{heading}\n")).expect("the heading").1;
    let block = below.split_once("```toml\n").expect("a block").1;
    block.split_once("```").expect("its end").0
}

fn parsed(text: &str) -> Scenario {
    Scenario::parse("example.toml", text).unwrap_or_else(|error| panic!("{error:?}"))
}

fn outcome(scenario: &Scenario) -> Outcome {
    let options = Options { keep_rows: false, progress: &|_, _| {} };
    run::run(scenario, options).expect("a good configuration")
}

#[test]
fn the_example_runs_and_ends_as_it_expects() {
    let scenario = parsed(example(DOCUMENT.text, "## An example"));
    assert_eq!(scenario.faults.len(), 2);
    let outcome = outcome(&scenario);
    assert!(outcome.is_good(), "{:?} {:?}", outcome.faults, outcome.broken_limits);
}

#[test]
fn its_twin_tolerates_two_lost_frames_and_not_three() {
    let mut scenario = parsed(example(DOCUMENT.text, "## An example"));
    scenario.expect = None;
    scenario.faults.truncate(1);
    let faults_after = |for_s: f64| {
        let mut scenario = scenario.clone();
        (scenario.faults[0].for_s, scenario.faults[0].severity) = (Some(for_s), 1.0);
        outcome(&scenario).faults
    };
    assert_eq!(faults_after(0.001), [] as [&str; 0]);
    assert_eq!(faults_after(0.0015), ["TorqueAdcLost"]);
}

#[test]
fn the_readmes_example_has_every_key_and_is_accepted() {
    let scenario = parsed(example(README, "## Write a scenario"));
    assert!(scenario.expect.is_some() && !scenario.faults.is_empty());
    let session = Session::new(&scenario, false);
    let mut core = Box::new(Core::new());
    let wired = Software::new(kept_of(&scenario), &session.bench(), session.retained(), &mut core);
    assert!(wired.is_ok());
}
