//! Ticks that come late, twice or not at all, and clocks that are off.

use hil_sim::faults::{Injection, Kind, Target};
use shared::fault::{Fault, Limit};

use super::rig::{Run, TICK_S, are_same, lift, rest, run};

/// Cycles of one tick.
const CYCLES: f64 = 84_000.0;

fn injected(kind: Kind, severity: f64) -> Run {
    run(&lift(&[Injection { severity, ..Injection::new(kind, Target::Only, 0.5) }]))
}

/// From tick to tick around the fault, periods, by true time and by the cycle counter; they have to agree.
fn periods(run: &Run) -> Vec<f64> {
    let ticked = run.tape.frames.iter().filter(|f| f.ticked).collect::<Vec<_>>();
    let from = ticked.len() - run.since(0.5).iter().filter(|f| f.ticked).count() - 2;
    let pairs = ticked.windows(2).zip(run.releases.windows(2)).skip(from).take(5);
    pairs
        .map(|(frames, releases)| {
            let true_s = frames[1].true_s - frames[0].true_s;
            let cycles = releases[1].cycles.wrapping_sub(releases[0].cycles);
            assert!(are_same(true_s, f64::from(cycles) / CYCLES * TICK_S), "{true_s} {cycles}");
            (true_s / TICK_S * 100.0).round() / 100.0
        })
        .collect()
}

#[test]
fn late_missing_and_doubled_ticks_come_when_they_should() {
    assert_eq!(periods(&injected(Kind::LateTick, 1.2)), [1.0, 1.2, 0.8, 1.0, 1.0]);
    assert_eq!(periods(&injected(Kind::LateTick, 5.0)), [1.0, 5.0, 1.0, 1.0, 1.0]);
    assert_eq!(periods(&injected(Kind::MissingTick, 0.0)), [1.0, 2.0, 1.0, 1.0, 1.0]);
    assert_eq!(periods(&injected(Kind::DoubleTick, 0.0)), [1.0, 1.0, 0.05, 0.95, 1.0]);
}

#[test]
fn a_single_irregular_tick_is_counted_and_leaves_the_lift_undisturbed() {
    for (kind, severity) in
        [(Kind::LateTick, 1.2), (Kind::MissingTick, 0.0), (Kind::DoubleTick, 0.0)]
    {
        let run = injected(kind, severity);
        assert!(run.first_fault().is_none(), "{kind}: {:?}", run.first_fault());
        assert!(run.end().record.irregular > 0, "{kind}");
        let expected = run.tape.frames.iter().filter(|f| f.ticked).count();
        assert_eq!(run.releases.len(), expected);
    }
}

#[test]
fn repeated_late_ticks_stop_the_arm() {
    let late = Injection::new(Kind::LateTick, Target::Only, 0.5);
    let run = run(&lift(&[Injection { for_s: Some(6.0 * TICK_S), ..late }]));
    assert_eq!(run.first_fault().map(|(_, fault, _)| fault), Some(Fault::TickLate));
}

#[test]
fn fast_clock_shortens_true_periods_and_is_told_by_the_converter() {
    let run = run(&rest(&[Injection::new(Kind::ClockOff, Target::Only, 0.2)]));
    let period_s = |frames: &[hil_sim::session::Frame]| frames[1].true_s - frames[0].true_s;
    assert!(are_same(period_s(run.since(0.1)), TICK_S));
    assert!(are_same(period_s(run.since(0.3)), TICK_S / 1.02));
    let drifts =
        |f: &&hil_sim::session::Frame| f.record.limits >> Limit::ClockDrift as u16 & 1 != 0;
    let told = run.tape.frames.iter().find(drifts).expect("it is told");
    let detect_s = told.true_s - run.since(0.2)[0].true_s;
    assert!((0.05..0.2).contains(&detect_s), "{detect_s}");
}

#[test]
fn counter_wraps_in_the_period_named_and_nothing_comes_of_it() {
    let run = run(&lift(&[Injection::new(Kind::CounterWrap, Target::Only, 0.5)]));
    let wraps = run.releases.windows(2).filter(|r| r[1].cycles < r[0].cycles).count();
    let at = run.releases.windows(2).position(|r| r[1].cycles < r[0].cycles);
    let named = run.tape.frames.len() - run.since(0.5).len();
    assert_eq!((wraps, at), (1, Some(named - 1)));
    assert_eq!((run.first_fault(), run.end().record.irregular), (None, 0));
}

#[test]
fn computing_time_is_reported_for_the_tick_named() {
    let run = injected(Kind::OverBudget, 0.6);
    let spent = run.releases.iter().map(|r| r.spent).filter(|spent| *spent != 2_000);
    assert_eq!(spent.collect::<Vec<_>>(), [50_400]);
}
