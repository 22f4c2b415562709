//! `docs/thresholds.md` against the configuration's thresholds and the monitors' constants, and what other
//! documents quote of them.

use firmware::config::Config;
use firmware::controller::{Core, Retained};
use firmware::estimator::FRACTION_BITS;
use firmware::monitor::Thresholds;

use crate::markdown::{Document, Row, compare, conclude, document};
use crate::values::{Numbers as _, Values, complaint, constants, leading_numbers, quotes, safety};

const DOCUMENT: Document = document!("thresholds.md");

fn thresholds() -> Thresholds {
    let config = Config::default();
    let mut core = Box::new(Core::new());
    core.configure(&config, config.crc(), &Retained::default()).expect("a good configuration");
    core.memory().thresholds
}

fn name(row: &Row) -> &'static str {
    row.cells[0].trim_matches('`')
}

/// Compares a table's first two columns with names and values.
fn check(heading: &str, values: &Values) {
    let rows = DOCUMENT.rows(heading);
    let written: Vec<_> = rows.iter().map(|row| name(row).to_owned()).collect();
    let expected: Vec<_> = values.keys().map(|name| (*name).to_owned()).collect();
    let mut complaints = compare(DOCUMENT.name, "row", &written, &expected);
    complaints.extend(rows.iter().filter_map(|row| {
        let value = values.get(name(row))?;
        complaint(row.place, name(row), &leading_numbers(row.cells[1]), value)
    }));
    conclude(&complaints);
}

#[test]
fn the_configurations_table_has_every_field_with_its_value() {
    check("## In the configuration", &safety());
}

#[test]
fn the_supervisors_times_are_those_at_2_khz() {
    let timing = thresholds().timing;
    let times = [
        ("reset", timing.reset),
        ("settle", timing.settle),
        ("boot", timing.boot),
        ("calm", timing.calm),
        ("contacts", timing.contacts),
    ];
    let seconds = times.map(|(name, ticks)| (name, vec![ticks as f32 / 2_000.0]));
    check("## Times of the supervisor", &seconds.into());
}

#[test]
fn windows_are_what_the_configuration_makes_of_them() {
    let limits = thresholds().encoder;
    let stuck = limits.stuck >> FRACTION_BITS;
    let windows = [
        ("tight", limits.tight.numbers()),
        ("wide", limits.wide.numbers()),
        ("stuck", stuck.numbers()),
    ];
    check("## What becomes of them", &windows.into());
}

#[test]
fn the_monitors_table_has_the_constants_with_their_values() {
    let constants = constants();
    let mut complaints = Vec::new();
    for row in DOCUMENT.rows("## In the monitors") {
        let (name, file) = (name(&row), row.cells[2].trim_matches('`'));
        match constants.iter().find(|(f, n, _)| *f == file && *n == name) {
            None => complaints.push(format!("{}: no constant `{name}` in {file}", row.place)),
            Some((_, _, value)) => complaints.extend(complaint(
                row.place,
                name,
                &leading_numbers(row.cells[1]),
                &[*value],
            )),
        }
    }
    conclude(&complaints);
}

#[test]
fn every_plain_constant_of_the_monitors_has_a_row() {
    // Units and scales of words, which decide nothing.
    const SCALES: [&str; 1] = ["FULL_SCALE"];
    let rows = DOCUMENT.rows("## In the monitors");
    let written: Vec<_> = rows.iter().map(|row| name(row).to_owned()).collect();
    let monitors = constants()
        .into_iter()
        .filter(|(file, name, _)| file.starts_with("monitor/") && !SCALES.contains(name));
    let missing = monitors.filter(|(_, name, _)| !written.contains(&(*name).to_owned()));
    let complaints: Vec<_> = missing
        .map(|(file, name, value)| {
            format!("{}: no row for `{name}` = {value} of {file}", DOCUMENT.name)
        })
        .collect();
    conclude(&complaints);
}

#[test]
fn other_documents_quote_the_same_values() {
    let mut values = safety();
    values.extend(constants().into_iter().map(|(_, name, value)| (name, vec![value])));
    let documents = [document!("faults.md"), document!("supervisor.md")];
    let mut complaints = Vec::new();
    for (place, name, written) in documents.into_iter().flat_map(quotes) {
        match values.get(name) {
            Some(value) => complaints.extend(complaint(place, name, &written, value)),
            None => complaints.push(format!("{place}: no threshold is called `{name}`")),
        }
    }
    conclude(&complaints);
}
