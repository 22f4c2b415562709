//! `docs/supervisor.md` against the supervisor: diagram, modes, exits, pin levels.

use firmware::config::Config;
use firmware::controller::{Core, Retained};
use firmware::path::{Line, Motion, Path};
use firmware::planner::{Order, Planner};
use firmware::supervisor::{Cause, Exit, Follower, Levels, Mode, TRANSITIONS, Timing};
use hil_sim::scenario::Scenario;
use shared::arm::{JOINTS, REFERENCE};
use shared::command::Command;
use shared::fault::{Fault, Mode as ModeCode};

use firmware::monitor::Finding;

use crate::markdown::{Document, compare, conclude, document};

const DOCUMENT: Document = document!("supervisor.md");

#[test]
fn the_diagram_is_the_transition_table() {
    let lines = DOCUMENT.lines().map(|(_, line)| line);
    let diagram = lines.skip_while(|l| *l != "```mermaid").skip(2).take_while(|l| *l != "```");
    let written: Vec<_> = diagram.map(|line| line.trim().to_owned()).collect();
    let start = format!("[*] --> {}", Mode::RESET.code().name());
    let arrow = |(from, exit, to): &(ModeCode, Exit, ModeCode)| {
        format!("{} --> {}: {exit:?}", from.name(), to.name())
    };
    let expected: Vec<_> = [start].into_iter().chain(TRANSITIONS.iter().map(arrow)).collect();
    conclude(&compare(DOCUMENT.name, "line", &written, &expected));
}

#[test]
fn every_mode_has_its_row() {
    let rows = DOCUMENT.rows("## Modes");
    let written: Vec<_> = rows.iter().map(|row| row.cells[..2].join(" ")).collect();
    let expected: Vec<_> =
        ModeCode::ALL.iter().map(|mode| format!("{} {}", *mode as u8, mode.name())).collect();
    conclude(&compare(DOCUMENT.name, "mode", &written, &expected));
}

#[test]
fn every_exit_has_its_row() {
    let rows = DOCUMENT.rows("## Exits");
    let written: Vec<_> = rows.iter().map(|row| row.cells[0].to_owned()).collect();
    let mut expected: Vec<_> = TRANSITIONS.iter().map(|(_, exit, _)| format!("{exit:?}")).collect();
    expected.sort();
    expected.dedup();
    conclude(&compare(DOCUMENT.name, "exit", &written, &expected));
}

/// A trajectory of the reference arm.
fn motion(config: &Config) -> Motion {
    let scenario = Scenario::load("paper").expect("a shipped scenario");
    let trajectory = hil_sim::path::Path::of(&scenario).command(&REFERENCE);
    let mut order = Order::Arm;
    Planner::new(config).plan(&Command::Start(trajectory), &[0; JOINTS], &mut order);
    match order {
        Order::Start(motion) => motion,
        other => panic!("{other:?}"),
    }
}

/// Every row of the table of pins, by the mode that it is of.
fn modes(config: &Config, timing: &Timing) -> Vec<(&'static str, Mode)> {
    let (pose, codes) = ([0; JOINTS], [0; JOINTS]);
    let cause = Cause { finding: Finding::new(Fault::OperatorStop), isolated: 0, cut: false };
    let follower = Follower::from_rest(&timing.pace);
    let (line, motion) = (Line::default(), motion(config));
    let boot = |ticks| Mode::Boot { ticks, complaint: Fault::None };
    let arming = |ticks| Mode::Arming { ticks, open: 0, pose, began: pose };
    let lowering = |ticks| Mode::Lowering { ticks, pose, motion: None, cause };
    vec![
        ("Boot, first 2 ms", boot(timing.reset - 1)),
        ("Boot, later", boot(timing.reset)),
        ("Standby", Mode::Standby { codes }),
        ("Arming, first 20 ms", arming(timing.preload - 1)),
        ("Arming, later", arming(timing.preload)),
        ("Holding", Mode::Holding { pose }),
        ("Moving", Mode::Moving(motion)),
        ("Jogging", Mode::Jogging { line, follower, quiet: 0 }),
        ("Stopping", Mode::Stopping { path: Path::Line(line), follower, cause }),
        ("BrakeHold", Mode::BrakeHold { pose, ticks: 0, closed: 0, cause }),
        ("TorqueOff", Mode::TorqueOff { ticks: 0, cause }),
        ("Latched", Mode::Latched { codes, cause }),
        ("Lowering, first 20 ms", lowering(timing.preload - 1)),
        ("Lowering, later", lowering(timing.preload)),
    ]
}

/// A row's cells, as the pins' levels have them.
fn told(name: &str, levels: Levels) -> String {
    let all = |bits: u8, yes: &'static str, no: &'static str| match bits {
        0b1111 => yes,
        0 => no,
        _ => "some",
    };
    let sto = if levels.sto { "on" } else { "off" };
    let converters = if levels.converters { "running" } else { "in reset" };
    let (drives, brakes) = (all(levels.drives, "on", "off"), all(levels.release, "open", "set"));
    [name, sto, drives, brakes, converters].join(" | ")
}

#[test]
fn pins_do_what_their_table_says() {
    let config = Config::default();
    let mut core = Box::new(Core::new());
    core.configure(&config, config.crc(), &Retained::default()).expect("a good configuration");
    let timing = core.memory().thresholds.timing;
    let modes = modes(&config, &timing);
    let told_of = |code: &ModeCode| modes.iter().any(|(_, mode)| mode.code() == *code);
    assert!(ModeCode::ALL.iter().all(told_of), "this test leaves a mode out");
    let rows = DOCUMENT.rows("## What each pin does");
    let written: Vec<_> = rows.iter().map(|row| row.cells.join(" | ")).collect();
    let expected: Vec<_> =
        modes.iter().map(|(name, mode)| told(name, mode.levels(&timing))).collect();
    conclude(&compare(DOCUMENT.name, "row", &written, &expected));
}

#[test]
fn isolated_joints_lose_torque_and_brake_release() {
    let finding = Finding::of_joint(Fault::DriveLost, 1);
    let cause = Cause { finding, isolated: 0b0010, cut: false };
    let mut core = Box::new(Core::new());
    let config = Config::default();
    core.configure(&config, config.crc(), &Retained::default()).expect("a good configuration");
    let timing = core.memory().thresholds.timing;
    let follower = Follower::from_rest(&timing.pace);
    let stopping = Mode::Stopping { path: Path::Line(Line::default()), follower, cause };
    let pose = [0; JOINTS];
    let hold = Mode::BrakeHold { pose, ticks: 0, closed: 0, cause };
    let lowering = Mode::Lowering { ticks: timing.preload, pose, motion: None, cause };
    let bits = |mode: Mode| {
        let levels = mode.levels(&timing);
        (levels.drives, levels.release)
    };
    assert_eq!(bits(stopping), (0b1101, 0b1101));
    assert_eq!(bits(hold), (0b1101, 0));
    assert_eq!(bits(lowering), (0b1101, 0b1101));
}
