//! The timing budget of a tick on the emulated board's image. `budget.toml` holds what each stage may cost;
//! `docs/timing.md` tells how the figures come about.

mod budget_table;

use std::collections::{BTreeMap, BTreeSet};

use budget_table::{Budget, Table};
use hil_sim::faults::{Injection, Kind, Place, Target};
use hil_sim::outcome::{Adaptation, Law};
use hil_sim::scenario::Scenario;
use tests::image::Image;
use tests::stage::{self, Stage};
use tests::trace::{Site, Trace};
use tests::{board, stack};

/// What is searched for the worst tick, 1 s of motion each: every law, profile and tick rate, a load, modes
/// from boot to the end, refused commands, a bus that errs now and then or until the controller gives up, and faults
/// that each monitor answers.
fn cases() -> Vec<(String, Scenario)> {
    let shipped = |name: &str| {
        let mut scenario = Scenario::load(name).expect("a shipped scenario");
        scenario.duration_s = 1.0;
        scenario.settle_s = 0.1;
        scenario.trajectory.amplitude = scenario.trajectory.amplitude.map(|a| 0.1 * a);
        if let Some(payload) = &mut scenario.plant.payload {
            payload.at_s = 0.5;
        }
        scenario
    };
    let with = |name: &str, what: &str, change: &dyn Fn(&mut Scenario)| {
        let mut scenario = shipped(name);
        change(&mut scenario);
        (format!("{name}, {what}"), scenario)
    };
    let broken = |what: &str, kind, target| {
        with("paper", what, &|s| s.faults = vec![Injection::new(kind, target, 0.5)])
    };
    let adapting = |adaptation| move |s: &mut Scenario| s.controller.adaptation = adaptation;
    vec![
        with("paper", "inertia", &|_| {}),
        with("paper", "paper's psi", &adapting(Adaptation::Paper)),
        with("paper", "no adaptation", &adapting(Adaptation::None)),
        with("paper", "PD", &|s| s.controller.law = Law::Pd),
        with("paper", "1 kHz", &|s| s.tick_hz = 1_000),
        with("paper", "8 kHz", &|s| s.tick_hz = 8_000),
        with("paper", "refused", &|s| s.trajectory.amplitude = [0.9, 0.0, 0.0, 0.0]),
        with("payload", "inertia", &|_| {}),
        with("payload", "paper's psi", &adapting(Adaptation::Paper)),
        with("velocity-mismatch", "inertia", &|_| {}),
        with("velocity-mismatch", "paper's psi", &adapting(Adaptation::Paper)),
        with("coarse-encoders", "inertia", &|_| {}),
        with("noisy-bus", "2 %", &|s| s.bus.error_share = 0.02),
        with("noisy-bus", "until safe", &|s| s.bus.error_share = 0.4),
        with("noisy-bus", "paper's psi", &adapting(Adaptation::Paper)),
        broken("a flipped parameter", Kind::Flip, Target::Place(Place::Arm)),
        broken("a flipped threshold", Kind::Flip, Target::Place(Place::Threshold)),
        broken("no encoders", Kind::Dead, Target::Encoders),
        broken("a stuck encoder", Kind::StuckEncoder, Target::Encoder(1)),
        broken("a drive without enable", Kind::EnableLost, Target::Joint(1)),
        broken("an inverted torque", Kind::TorqueInverted, Target::Joint(1)),
        broken("a late tick", Kind::LateTick, Target::Only),
        broken("an estimate that is no number", Kind::NonFinite, Target::Joint(1)),
        broken("an emergency stop", Kind::EStop, Target::Only),
    ]
}

#[test]
fn every_tick_keeps_its_budget() {
    let image = board::open("mps2-an386");
    let plugin = board::plugin();
    let mut table = Table::default();
    let mut sites = BTreeMap::new();
    for (name, scenario) in cases() {
        let trace = board::trace(&image, &plugin, &scenario);
        table.add(&name, &trace);
        add_sites(&mut sites, &trace);
    }
    let budget = Budget::load();
    println!("{}", table.render(&budget));
    println!("{}", untaken(&image, sites));
    let broken = table.broken(&budget);
    assert!(broken.is_empty(), "over budget:\n{}", broken.join("\n"));
}

/// A part that no function bears would leave its work to another stage.
#[test]
fn every_part_of_a_stage_names_code_of_the_image() {
    let image = board::open("mps2-an386");
    let parts = board::STAGES.iter().flat_map(|(_, parts)| *parts);
    let alone: Vec<Stage> = parts.map(|part| (*part, std::slice::from_ref(part))).collect();
    let found = stage::attribute(&image, &alone).expect("stages");
    let named: BTreeSet<_> = found.into_iter().filter_map(|(_, stage)| stage).collect();
    let idle: Vec<_> =
        (0..alone.len()).filter(|i| !named.contains(i)).map(|i| alone[i].0).collect();
    assert!(idle.is_empty(), "no function of the image is named {idle:?}");
}

fn add_sites(all: &mut BTreeMap<u32, Site>, trace: &Trace) {
    for (&at, site) in &trace.sites {
        let sum = all.entry(at).or_insert(Site { executed: 0, taken: 0 });
        sum.executed += site.executed;
        sum.taken += site.taken;
    }
}

/// Conditional branches of the tick that went one way only in all runs, by function.
fn untaken(image: &Image, sites: BTreeMap<u32, Site>) -> String {
    let trace = Trace { ticks: Vec::new(), sites, stdout: String::new() };
    let tick = image.function_named("tick").expect("the tick's symbol");
    let reached = stack::reachable(image, tick.start, &[]).expect("direct calls only");
    let mut lines = vec!["Branches of tick code that went one way only:".to_owned()];
    for start in reached {
        let function = &image.functions[&start];
        if function.name.contains("mps2_an386::link") {
            continue;
        }
        let found = trace.one_sided(image, function.start..function.end);
        if !found.is_empty() {
            let at: Vec<String> = found.iter().map(|(at, _)| format!("{at:#x}")).collect();
            lines.push(format!("  {}: {}", function.name, at.join(" ")));
        }
    }
    lines.join("\n")
}
