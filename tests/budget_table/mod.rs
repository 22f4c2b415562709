//! `budget.toml`, and what was measured against it.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Deserialize;
use tests::board::{LINK, STAGES};
use tests::trace::{Cost, Trace};

/// The budget file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budget {
    clock_mhz: f64,
    growth_percent: f64,
    stage: BTreeMap<String, Allowance>,
}

/// What a stage may cost in its worst tick.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Allowance {
    /// Modelled cycles, plain variant.
    cycles: u64,
    /// Instructions as last measured.
    instructions: u64,
}

/// Name of the sum of all stages in the file.
const WHOLE: &str = "whole tick";
/// Name of what no stage claims.
const OTHER: &str = "other";

impl Budget {
    /// Reads the file beside the tests.
    pub fn load() -> Self {
        toml::from_str(include_str!("../budget.toml")).expect("budget.toml is well formed")
    }
}

/// Costs of one stage over all ticks of all cases.
#[derive(Clone, Debug, Default)]
struct Row {
    ticks: u64,
    sum: u64,
    min: Option<u64>,
    worst: Cost,
    /// Case and tick of the worst one.
    place: String,
}

impl Row {
    fn add(&mut self, cost: Cost, place: impl Fn() -> String) {
        self.ticks += 1;
        self.sum += cost.plain;
        self.min = Some(self.min.map_or(cost.plain, |min| min.min(cost.plain)));
        if cost.plain > self.worst.plain {
            self.place = place();
        }
        self.worst.plain = self.worst.plain.max(cost.plain);
        self.worst.pessimistic = self.worst.pessimistic.max(cost.pessimistic);
        self.worst.instructions = self.worst.instructions.max(cost.instructions);
    }
}

/// Costs of all stages; the last row is the whole tick.
#[derive(Debug, Default)]
pub struct Table {
    rows: BTreeMap<usize, Row>,
    /// The worst whole tick, stage by stage.
    worst: Vec<Cost>,
}

/// Stages in the order of the tick, what no stage claims, and the whole; the link is none of them.
fn names() -> impl Iterator<Item = (usize, &'static str)> {
    let staged = STAGES.iter().map(|(name, _)| *name).enumerate().skip(LINK + 1);
    staged.chain([(STAGES.len(), OTHER), (STAGES.len() + 1, WHOLE)])
}

impl Table {
    /// Adds every tick of a case.
    pub fn add(&mut self, case: &str, trace: &Trace) {
        for (n, tick) in trace.ticks.iter().enumerate() {
            let place = || format!("{case}, tick {n}");
            let mut whole = Cost::default();
            for (stage, cost) in tick.iter().enumerate().filter(|(stage, _)| *stage != LINK) {
                self.rows.entry(stage).or_default().add(*cost, place);
                whole = whole + *cost;
            }
            let row = self.rows.entry(STAGES.len() + 1).or_default();
            if whole.plain > row.worst.plain {
                self.worst = tick.clone();
            }
            row.add(whole, place);
        }
    }

    /// The table as text.
    pub fn render(&self, budget: &Budget) -> String {
        let mut text = format!(
            "{:24} {:>6} {:>7} {:>6} {:>7} {:>9} {:>12} {:>12}  worst tick\n",
            "stage, modelled cycles",
            "min",
            "mean",
            "worst",
            "budget",
            "headroom",
            "pessimistic",
            "instructions"
        );
        for (i, name) in names() {
            let row = &self.rows[&i];
            let allowed = budget.stage.get(name).map_or(0, |a| a.cycles);
            let headroom = 100.0 * (1.0 - row.worst.plain as f64 / allowed as f64);
            let _ = writeln!(
                text,
                "{name:24} {:6} {:7.0} {:6} {allowed:7} {headroom:7.1} % {:12} {:12}  {}",
                row.min.unwrap_or(0),
                row.sum as f64 / row.ticks as f64,
                row.worst.plain,
                row.worst.pessimistic,
                row.worst.instructions,
                row.place,
            );
        }
        text + &self.split() + &self.times(budget)
    }

    /// What the worst tick is made of.
    fn split(&self) -> String {
        let stages = names().filter_map(|(i, name)| Some((name, self.worst.get(i)?.plain)));
        let stages: Vec<_> = stages.map(|(name, cycles)| format!("{name} {cycles}")).collect();
        format!("The worst tick by stages: {}.\n", stages.join(", "))
    }

    /// The worst tick in micro-seconds and per cent of a tick.
    fn times(&self, budget: &Budget) -> String {
        let worst = self.rows[&(STAGES.len() + 1)].worst;
        let us = |cycles: u64| cycles as f64 / budget.clock_mhz;
        let (plain, pessimistic) = (us(worst.plain), us(worst.pessimistic));
        let mut text = format!(
            "At {} MHz the worst tick computes {plain:.1} us (pessimistic {pessimistic:.1} us):",
            budget.clock_mhz
        );
        for khz in [1.0, 2.0, 4.0, 8.0] {
            let _ = write!(text, " {:.1} % at {khz} kHz,", 0.1 * plain * khz);
        }
        text + " wire time apart."
    }

    /// Each broken budget as a sentence.
    pub fn broken(&self, budget: &Budget) -> Vec<String> {
        let mut broken = Vec::new();
        for (i, name) in names() {
            let Some(allowed) = budget.stage.get(name) else {
                broken.push(format!("{name}: not in budget.toml"));
                continue;
            };
            let worst = &self.rows[&i].worst;
            if worst.plain > allowed.cycles {
                broken.push(format!("{name}: {} cycles, {} allowed", worst.plain, allowed.cycles));
            }
            let most = allowed.instructions as f64 * (1.0 + budget.growth_percent / 100.0);
            if worst.instructions as f64 > most {
                broken.push(format!(
                    "{name}: {} instructions, {} at the last change of budget.toml; a growth of more than {} % wants its reason there",
                    worst.instructions, allowed.instructions, budget.growth_percent
                ));
            }
        }
        broken
    }
}
