//! An encoder that gets stuck is told wherever the watch motion is, whether the arm rests or only its joint does.

use hil_sim::faults::{Injection, Kind, Target};
use hil_sim::outcome::Adaptation;
use hil_sim::run::{self, Options};
use hil_sim::scenario::Scenario;
use hil_sim::session::Event;
use shared::arm::JOINTS;
use shared::fault::Fault;

/// A round of the watch motion, s.
const ROUND_S: f64 = 0.1;
/// How far the tip may be off by then, m; a stuck encoder's bound is 5 mm.
const TIP_M: f64 = 2e-3;

/// Time from the fault, `at_s` after the start, to its detection, s, and the highest error of the tip, m.
fn detection(scenario: &Scenario, joint: usize, at_s: f64) -> (f64, f64) {
    let mut scenario = scenario.clone();
    scenario.faults = vec![Injection::new(Kind::StuckEncoder, Target::Encoder(joint), at_s)];
    let options = Options { keep_rows: false, progress: &|_, _| () };
    let outcome = run::run(&scenario, options).expect("a configuration in range");
    let time = |of: &dyn Fn(&Event) -> bool| {
        let found = outcome.happenings.iter().find(|one| of(&one.event));
        found.unwrap_or_else(|| panic!("encoder {} at {at_s} s: {outcome:?}", joint + 1)).true_s
    };
    let stuck = Event::Fault(Fault::EncoderStuck, 1 << joint);
    let began_s = time(&|event| matches!(event, Event::Began(_)));
    (time(&|event| *event == stuck) - began_s, outcome.metrics.e_max_m)
}

fn scenario() -> Scenario {
    Scenario { duration_s: 2.0, ..Scenario::load("paper").expect("a shipped scenario") }
}

fn is_told_within_a_round(scenario: &Scenario, joint: usize) {
    for phase in 0..10 {
        let (s, m) = detection(scenario, joint, 0.5 + ROUND_S * f64::from(phase) / 10.0);
        assert!(s < ROUND_S && m < TIP_M, "encoder {}, {phase}: {s} s, {m:e} m", joint + 1);
    }
}

#[test]
fn at_rest() {
    for adaptation in [Adaptation::Inertia, Adaptation::Paper, Adaptation::None] {
        let mut scenario = scenario();
        scenario.trajectory.amplitude = [0.0; JOINTS];
        scenario.controller.adaptation = adaptation;
        (0..JOINTS).for_each(|joint| is_told_within_a_round(&scenario, joint));
    }
}

#[test]
fn at_a_joint_that_stands_while_others_move() {
    for joint in 0..JOINTS {
        let mut scenario = scenario();
        scenario.trajectory.amplitude = scenario.trajectory.amplitude.map(|a| 0.1 * a);
        scenario.trajectory.amplitude[joint] = 0.0;
        is_told_within_a_round(&scenario, joint);
    }
}

#[test]
fn where_a_path_begins_too_slowly_to_tell_at_once() {
    let paper = Scenario::load("paper").expect("a shipped scenario");
    for joint in 0..JOINTS {
        for at_s in [0.0, 0.02, 0.05, 0.1, 9.7, 9.8] {
            let (s, m) = detection(&paper, joint, at_s);
            assert!(s < 0.25 && m < TIP_M, "encoder {}, {at_s}: {s} s, {m:e} m", joint + 1);
        }
    }
}
