//! A whole run over the link: its commands arrive, and its silence stops the arm.

use firmware::controller::Core;
use hil_sim::faults::{Injection, Kind, Target};
use hil_sim::run::{Software, kept_of};
use hil_sim::scenario::Scenario;
use hil_sim::session::{Event, Session};
use shared::fault::{Fault, Mode};
use shared::link::{Answer, Kind as FrameKind};

const TEXT: &str = "summary = \"a short motion\"\nduration_s = 1\nsettle_s = 0.1\n\
    [trajectory]\nprofile = \"quintic\"\namplitude = [0, 0.01, 0.02, -0.1]\n";

/// When the link is silent from 0.5 s after the start on, and how long a fault takes to be told, s.
fn run(faults: Vec<Injection>) -> (Vec<(f64, Event)>, Vec<Answer>) {
    let scenario = Scenario { faults, ..Scenario::parse("short.toml", TEXT).expect("in range") };
    let mut session = Session::new(&scenario, false);
    let mut core = Core::new();
    let (kept, bench, retained) = (kept_of(&scenario), session.bench(), session.retained());
    let mut software = Software::new(kept, &bench, retained, &mut core).expect("a controller");
    while !session.is_over() {
        let Ok(_) = session.tick(&mut software);
    }
    let start_s = session.start_s().expect("a start");
    let events = session.happenings().iter().map(|one| (one.true_s - start_s, one.event));
    let events = events.collect();
    let heard = session.console().heard();
    let answers = heard.iter().filter(|frame| frame.kind == FrameKind::Answer as u8);
    (events, answers.map(|frame| frame.payload()).collect())
}

#[test]
fn the_operators_commands_are_answered() {
    let (_, answers) = run(Vec::new());
    let counters: Vec<_> = answers.iter().map(|answer| (answer.kind, answer.reason)).collect();
    assert_eq!(counters, [(FrameKind::Command as u8, 0); 2], "arm and start");
}

#[test]
fn a_silent_link_stops_a_moving_arm_along_its_path() {
    let (events, _) = run(vec![Injection::new(Kind::LinkSilent, Target::Only, 0.5)]);
    let time_of = |wanted: fn(&Event) -> bool| {
        events.iter().find(|(_, event)| wanted(event)).map(|(t_s, _)| *t_s)
    };
    let lost_s = time_of(|e| matches!(e, Event::Fault(Fault::LinkLost, _))).expect("a fault");
    // The last heartbeat came up to 20 ms before, and the timeout is 250 ms.
    assert!((0.73..=0.752).contains(&lost_s), "{lost_s}");
    let stopping_s = time_of(|e| *e == Event::Mode(Mode::Stopping)).expect("SS1");
    assert!((stopping_s - lost_s).abs() < 1e-6);
    assert!(time_of(|e| *e == Event::Mode(Mode::Latched)).is_some());
}

#[test]
fn a_gap_shorter_than_the_timeout_is_none() {
    let gap = Injection { for_s: Some(0.2), ..Injection::new(Kind::LinkSilent, Target::Only, 0.5) };
    let (events, _) = run(vec![gap]);
    assert!(!events.iter().any(|(_, event)| matches!(event, Event::Fault(..))));
}
