//! Flash, RAM and stack against their baseline and limits.

use std::collections::BTreeMap;

use serde::Deserialize;
use tests::board;
use tests::size::Sizes;

use crate::BOARDS;
use crate::stack::worst_case_bytes;

/// `sizes.toml`: one entry a board, bytes.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Baseline {
    /// Why it is no smaller.
    reason: String,
    text: u32,
    rodata: u32,
    static_ram: u32,
    stack: u32,
    limits: Limits,
}

/// What it may never exceed, bytes.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Limits {
    /// Code and constants.
    flash: u32,
    static_ram: u32,
    stack: u32,
}

/// Growth that needs no reason, per cent.
const FREE_GROWTH_PERCENT: u32 = 2;

fn baselines() -> BTreeMap<String, Baseline> {
    toml::from_str(include_str!("../sizes.toml")).expect("sizes.toml")
}

/// What is too large, by name.
fn complaints(baseline: &Baseline, sizes: &Sizes, stack: u32) -> Vec<String> {
    let grown = [
        ("text", sizes.text, baseline.text),
        ("rodata", sizes.rodata, baseline.rodata),
        ("static_ram", sizes.static_ram, baseline.static_ram),
        ("stack", stack, baseline.stack),
    ];
    let grown = grown.into_iter().filter(|(_, now, before)| {
        100 * (now.saturating_sub(*before)) > FREE_GROWTH_PERCENT * before
    });
    let grown = grown.map(|(what, now, before)| {
        format!("{what} grew from {before} to {now}; if it must, say why in tests/sizes.toml")
    });
    let limits = &baseline.limits;
    let over = [
        ("flash", sizes.text + sizes.rodata, limits.flash),
        ("static RAM", sizes.static_ram, limits.static_ram),
        ("stack", stack, limits.stack),
    ];
    let over = over.into_iter().filter(|(_, now, limit)| now > limit);
    grown.chain(over.map(|(what, now, limit)| format!("{what} is {now}, limit {limit}"))).collect()
}

#[test]
fn the_images_are_no_larger_than_their_baseline() {
    let baselines = baselines();
    let mut all = Vec::new();
    for name in BOARDS {
        let image = board::open(name);
        let sizes = Sizes::of(&image.path).expect("sizes");
        let stack = worst_case_bytes(&image).expect("a bound");
        let Sizes { text, rodata, static_ram } = sizes;
        println!("[{name}]\ntext = {text}\nrodata = {rodata}");
        println!("static_ram = {static_ram}\nstack = {stack}\n");
        let found = complaints(&baselines[name], &sizes, stack);
        all.extend(found.into_iter().map(|complaint| format!("{name}: {complaint}")));
    }
    assert!(all.is_empty(), "{all:#?}");
}

#[test]
fn every_baseline_has_its_reason() {
    assert!(baselines().values().all(|baseline| baseline.reason.len() > 20));
}

#[test]
fn growth_and_excess_are_found() {
    let limits = || Limits { flash: 1_600, static_ram: 400, stack: 300 };
    let (text, rodata, static_ram, stack) = (1_000, 500, 400, 300);
    let baseline =
        Baseline { reason: String::new(), text, rodata, static_ram, stack, limits: limits() };
    let found = |text, rodata, static_ram, stack| {
        complaints(&baseline, &Sizes { text, rodata, static_ram }, stack).len()
    };
    assert_eq!(found(1_000, 500, 400, 300), 0);
    assert_eq!(found(1_020, 510, 10, 10), 0);
    assert_eq!(found(1_021, 500, 400, 300), 1);
    assert_eq!(found(1_000, 511, 400, 300), 1);
    assert_eq!(found(1_000, 500, 401, 301), 2);
    // Both grown and over the limit of their sum; static RAM likewise.
    assert_eq!(found(1_100, 501, 409, 300), 4);
}
