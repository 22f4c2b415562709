//! How well each shipped scenario is tracked, at every offered rate and by every controller.

use hil_sim::metrics::Meter;
use hil_sim::outcome::{Adaptation, Law, Outcome};
use hil_sim::path::Path;
use hil_sim::run::{self, Options, config_of};
use hil_sim::scenario::Scenario;
use shared::arm::REFERENCE;
use shared::command::Command;
use shared::fault::Mode;
use tests::rig::Rig;

const RATES_HZ: [u32; 4] = [1_000, 2_000, 4_000, 8_000];

/// A run that came to its end without a fault or a refusal.
fn outcome(name: &str, change: impl Fn(&mut Scenario)) -> Outcome {
    let mut scenario = Scenario::load(name).expect("a shipped scenario");
    change(&mut scenario);
    let options = Options { keep_rows: false, progress: &|_, _| () };
    let outcome = run::run(&scenario, options).expect("a configuration in range");
    let (tick_hz, law) = (outcome.tick_hz, outcome.label());
    assert_eq!(outcome.faults, [""; 0], "{name} at {tick_hz} Hz, {law}");
    assert_eq!(outcome.mode, "Moving", "{name} at {tick_hz} Hz, {law}");
    assert_eq!(outcome.metrics.v_max_m_s.to_string()[..5], *"0.227", "{name}");
    outcome
}

fn at(tick_hz: u32) -> impl Fn(&mut Scenario) {
    move |scenario| scenario.tick_hz = tick_hz
}

#[test]
fn every_shipped_scenario_keeps_its_bounds() {
    let bounds = [
        ("paper", 2.7e-7, 1.0e-6),
        ("velocity-mismatch", 1e-6, 1e-3),
        ("payload", 2e-6, 1e-3),
        ("coarse-encoders", 6e-6, 3e-5),
        ("noisy-bus", 3.2e-7, 2e-6),
    ];
    let well = |name: &&str| Scenario::load(name).is_ok_and(|scenario| scenario.expect.is_none());
    let shipped: Vec<&str> = Scenario::shipped().map(|(name, _)| name).filter(well).collect();
    assert_eq!(shipped, bounds.map(|(name, _, _)| name));
    for (name, rse_m, e_max_m) in bounds {
        let outcome = outcome(name, |_| ());
        let m = outcome.metrics;
        assert!(
            outcome.is_good() && outcome.tick_hz == 2_000,
            "{name}: {:?}",
            outcome.broken_limits
        );
        assert!(m.rse_m <= rse_m && m.e_max_m <= e_max_m, "{name}: {m:?}");
    }
}

#[test]
fn a_shipped_scenario_that_has_to_stop_stops_as_it_has_to() {
    let mut some = false;
    for (name, _) in Scenario::shipped() {
        let scenario = Scenario::load(name).expect("a shipped scenario");
        let options = Options { keep_rows: false, progress: &|_, _| () };
        if scenario.expect.is_some() {
            let outcome = run::run(&scenario, options).expect("a configuration in range");
            assert!(outcome.is_good(), "{name}: {:?}", outcome.broken_limits);
            assert_eq!(outcome.mode, "Latched", "{name}");
            some = true;
        }
    }
    assert!(some, "no shipped scenario has to stop");
}

#[test]
fn adaptation_carries_the_payload_at_every_rate_and_pd_does_not() {
    for tick_hz in RATES_HZ {
        let adaptive = outcome("payload", at(tick_hz)).metrics.rse_m;
        assert!(adaptive < 2e-6, "{adaptive:e} m at {tick_hz} Hz");
        let pd = outcome("payload", |scenario| {
            scenario.tick_hz = tick_hz;
            scenario.controller.law = Law::Pd;
        });
        assert!(pd.metrics.rse_m > 5e-4, "PD {:e} m at {tick_hz} Hz", pd.metrics.rse_m);
    }
}

#[test]
fn latch_skew_costs_nothing_at_any_rate() {
    for tick_hz in RATES_HZ {
        let rse_m = outcome("paper", |scenario| {
            scenario.tick_hz = tick_hz;
            scenario.encoders.skew_s = 10e-6;
        });
        assert!(rse_m.metrics.rse_m <= 3e-7, "{:e} m at {tick_hz} Hz", rse_m.metrics.rse_m);
    }
}

/// Mean tip error of the paper's lift with 10 us of skew when the controller believes in these offsets, m.
fn rse_with_latch_offsets(offset_s: impl Fn(f32) -> f32) -> f64 {
    let scenario = Scenario::load("paper").expect("a shipped scenario");
    let mut config = config_of(&scenario);
    for joint in &mut config.joints {
        joint.latch_offset_s = offset_s(joint.latch_offset_s);
    }
    let mut rig = Rig::new(&config, scenario.encoders.skew_s);
    let path = Path::of(&scenario);
    rig.until(Mode::Standby, 0.5);
    rig.tick(Some(Command::Arm));
    rig.until(Mode::Holding, 1.0);
    (0..1_000).for_each(|_| _ = rig.tick(None));
    rig.plant.start_disturbance();
    let mut command = Some(Command::Start(path.command(&REFERENCE)));
    let mut meter = Meter::default();
    for k in 0..=20_000 {
        let desired = path.at(f64::from(k) / f64::from(scenario.tick_hz));
        let (tip, wanted) = (rig.plant.tip().position_m, path.tip(&desired));
        meter.add(
            &std::array::from_fn(|axis| tip[axis] - wanted.position_m[axis]),
            wanted.speed_m_s,
        );
        let record = rig.tick(command.take());
        assert_eq!((record.mode, record.phase), (Mode::Moving as u8, k));
    }
    meter.metrics().rse_m
}

#[test]
fn latch_skew_that_the_controller_does_not_know_is_seen() {
    let known = rse_with_latch_offsets(|offset| offset);
    let unknown = rse_with_latch_offsets(|_| 0.0);
    assert!(known <= 2.7e-7, "{known:e} m");
    assert!(unknown > 5.0 * known, "{unknown:e} m without, {known:e} m with the offsets");
}

#[test]
fn adaptations_rank_as_expected() {
    let rse_m =
        |adaptation| outcome("paper", |s| s.controller.adaptation = adaptation).metrics.rse_m;
    let [inertia, paper, none] =
        [Adaptation::Inertia, Adaptation::Paper, Adaptation::None].map(rse_m);
    assert!(2.0 * inertia < paper && 2.0 * paper < none, "{inertia:e}, {paper:e}, {none:e} m");
}
