//! The timing budget of a tick, on the emulated board's image: `budget.toml` says what each stage may cost.

use hil_sim::scenario::Scenario;
use tests::board::{self, LINK, STAGES};
use tests::trace::Cost;

#[test]
fn every_stage_is_priced() {
    let image = board::open("mps2-an386");
    let scenario = Scenario::load("paper").expect("a shipped scenario");
    let trace = board::trace(&image, &board::plugin(), &scenario);
    for (i, (name, _)) in STAGES.iter().enumerate() {
        let spread = trace.spread(|stage| stage == i, |cost: &Cost| cost.plain);
        println!("{name:26} {:6} {:8.0} {:6}", spread.min, spread.mean, spread.max);
        assert!(spread.max > 0, "{name} has no instructions");
    }
    let whole = trace.spread(|stage| stage != LINK, |cost| cost.plain);
    println!("{:26} {:6} {:8.0} {:6}", "whole tick", whole.min, whole.mean, whole.max);
}
