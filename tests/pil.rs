//! Processor in the loop: the image agrees bit for bit with the software, differences are named by tick and field,
//! and an emulator that is lost is told as such.

use std::path::Path;
use std::process::Command;

use firmware::config::Config;
use firmware::controller::Core;
use hil_sim::outcome::{Adaptation, Law};
use hil_sim::pil::{self, Difference, Emulator, EmulatorError, PilError, Verdict};
use hil_sim::run::{Software, config_of};
use hil_sim::scenario::Scenario;
use hil_sim::session::Session;
use shared::telemetry::Record;
use tests::board;
use tests::image::Image;
use tests::variant;

const CONTROLLERS: [(Law, Adaptation); 4] = [
    (Law::Backstepping, Adaptation::Inertia),
    (Law::Backstepping, Adaptation::Paper),
    (Law::Backstepping, Adaptation::None),
    (Law::Pd, Adaptation::None),
];

fn image() -> Image {
    board::open("mps2-an386")
}

fn load(name: &str, (law, adaptation): (Law, Adaptation)) -> Scenario {
    let mut scenario = Scenario::load(name).expect("a shipped scenario");
    (scenario.controller.law, scenario.controller.adaptation) = (law, adaptation);
    scenario
}

/// The controller in software, wired to `session`'s bench.
fn software<'m>(config: &Config, session: &Session, core: &'m mut Core) -> Software<'m> {
    Software::new(config, &session.bench(), session.retained(), core).expect("a controller")
}

/// The ordinary image, wired to `session`'s bench.
fn emulated(scenario: &Scenario, session: &Session) -> Emulator {
    let config = config_of(scenario);
    Emulator::start(&image().path, &config, session.retained(), session.bench()).expect("a board")
}

fn compared(scenario: &Scenario, image: &Path) -> Verdict {
    pil::run(scenario, image, &|_, _| ()).expect("a comparison")
}

/// The difference that the image with this defect shows on `paper`.
fn difference(defect: &str) -> Difference {
    let path = variant::build(defect).expect("a variant");
    compared(&load("paper", CONTROLLERS[0]), &path).difference.expect("a difference")
}

fn agrees(name: &str, controller: (Law, Adaptation)) {
    let verdict = compared(&load(name, controller), &image().path);
    assert!(verdict.difference.is_none(), "{}", verdict.difference.expect("just seen"));
    assert!(verdict.outcome.ticks > 20_000, "only {} ticks", verdict.outcome.ticks);
}

#[test]
fn inertia_weighted_agrees() {
    agrees("paper", CONTROLLERS[0]);
}

#[test]
fn constant_psi_agrees() {
    agrees("paper", CONTROLLERS[1]);
}

#[test]
fn fixed_gain_agrees() {
    agrees("paper", CONTROLLERS[2]);
}

#[test]
fn pd_agrees() {
    agrees("paper", CONTROLLERS[3]);
}

#[test]
fn a_payload_agrees() {
    agrees("payload", CONTROLLERS[0]);
}

/// Flipped bits take the same way through both builds: refused samples, and the stop where there are too many.
#[test]
fn a_faulted_bus_agrees() {
    agrees("noisy-bus", CONTROLLERS[0]);
    let mut scenario = load("noisy-bus", CONTROLLERS[0]);
    scenario.bus.error_share = 0.4;
    let verdict = compared(&scenario, &image().path);
    assert_eq!(verdict.difference, None);
    assert_eq!(verdict.outcome.mode, "Latched");
    assert_eq!(verdict.outcome.faults.len(), 1);
}

#[test]
fn coefficients_agree_for_every_scenario_and_controller() {
    let each = Scenario::shipped().flat_map(|(name, _)| CONTROLLERS.map(|c| load(name, c)));
    for scenario in each {
        let session = Session::new(&scenario, false);
        let mut core = Core::new();
        let software = software(&config_of(&scenario), &session, &mut core);
        let board = emulated(&scenario, &session);
        assert!(board.coefficients().len() > 100);
        assert!(board.coefficients() == software.parameter_bytes(), "{}", scenario.name);
        board.stop().expect("an end");
    }
}

fn one_ulp_up(config: &mut Config) {
    let k1 = &mut config.gains.k1[0];
    *k1 = f32::from_bits(k1.to_bits() + 1);
}

/// Route two: the word of the coefficients that differs in software.
#[test]
fn a_coefficient_one_ulp_off_is_found_before_the_first_tick() {
    let scenario = load("paper", CONTROLLERS[0]);
    let [right, wrong] = [false, true].map(|is_wrong| {
        let mut config = config_of(&scenario);
        if is_wrong {
            one_ulp_up(&mut config);
        }
        let mut core = Core::new();
        software(&config, &Session::new(&scenario, false), &mut core).parameter_bytes()
    });
    let mut words = right.chunks_exact(4).zip(wrong.chunks_exact(4));
    let word = words.position(|(a, b)| a != b).expect("a difference");
    let found = difference("coefficient_one_ulp_off");
    assert_eq!((found.tick, found.place), (None, format!("coefficient word {word}")));
}

/// Records of `scenario` in software, with the gain one ulp off where `is_wrong`.
fn records(scenario: &Scenario, is_wrong: bool, ticks: usize) -> Vec<Record> {
    let mut config = config_of(scenario);
    if is_wrong {
        one_ulp_up(&mut config);
    }
    let mut session = Session::new(scenario, false);
    let mut core = Core::new();
    let mut software = software(&config, &session, &mut core);
    let tick = |_| {
        let Ok(record) = session.tick(&mut software);
        record
    };
    (0..ticks).map(tick).collect()
}

/// Route two: the same slip in software, whose estimate of the disturbance is the first to differ.
#[test]
fn a_law_one_ulp_off_is_found_at_its_first_tick() {
    let scenario = load("paper", CONTROLLERS[0]);
    let [right, wrong] = [false, true].map(|is_wrong| records(&scenario, is_wrong, 2_000));
    let mut pairs = right.iter().zip(&wrong);
    let first = pairs.position(|(a, b)| a.to_bytes() != b.to_bytes()).expect("a difference");
    let (a, b) = (&right[first], &wrong[first]);
    assert!(a.d_hat[0] != b.d_hat[0] && a.e1 == b.e1 && a.dac == b.dac);
    let found = difference("law_one_ulp_off");
    let place = "record, d_hat of joint 1".to_owned();
    assert_eq!((found.tick, found.place), (Some(first as u64), place));
}

/// The defect's own tick. How much of it shows depends on how well the model makes up for the refused sample.
#[test]
fn a_spoiled_sample_is_found_at_its_tick() {
    let found = difference("spoiled_sample");
    assert_eq!(found.tick, Some(2_000), "{}", found.place);
    assert!(["bus, Dac", "record, qd of joint 2"].contains(&&*found.place), "{}", found.place);
}

fn is_running(process: u32) -> bool {
    Path::new(&format!("/proc/{process}")).exists()
}

#[test]
fn a_killed_emulator_is_reported_and_leaves_no_process() {
    let scenario = load("paper", CONTROLLERS[0]);
    let mut session = Session::new(&scenario, false);
    let mut board = emulated(&scenario, &session);
    let process = board.process_id();
    for _ in 0..100 {
        session.tick(&mut board).expect("a tick");
    }
    assert!(is_running(process));
    let status = Command::new("kill").args(["-KILL", &process.to_string()]).status();
    assert!(status.expect("kill").success());
    // What the board had sent by then is still served.
    let error = (0..3).find_map(|_| session.tick(&mut board).err()).expect("an error");
    assert!(matches!(error, EmulatorError::Ended(_)), "{error}");
    let text = error.to_string();
    assert!(
        text.contains("ended in the middle of the run") && text.contains("signal: 9"),
        "{text}"
    );
    drop(board);
    assert!(!is_running(process));
}

#[test]
fn an_abandoned_emulator_leaves_no_process() {
    let scenario = load("paper", CONTROLLERS[0]);
    let session = Session::new(&scenario, false);
    let board = emulated(&scenario, &session);
    let process = board.process_id();
    assert!(is_running(process));
    drop(board);
    assert!(!is_running(process));
}

#[test]
fn a_missing_image_is_named() {
    let missing = Path::new("no/such/image");
    let error =
        pil::run(&load("paper", CONTROLLERS[0]), missing, &|_, _| ()).expect_err("no image");
    assert!(matches!(error, PilError::Emulator(EmulatorError::NoImage { .. })), "{error}");
    let text = error.to_string();
    assert!(text.contains("no/such/image") && text.contains("cargo firmware"), "{text}");
}
