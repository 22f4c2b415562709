//! What the hardware does whatever the firmware does.

use hil_sim::faults::{Injection, Kind, Target};
use hil_sim::session::Event;
use shared::fault::{Fault, Mode};

use super::rig::{TICK_S, lift, rest, run, run_on};

const OPEN: Event = Event::Chain { closed: false };

#[test]
fn hang_loses_torque_within_the_watchdogs_timeout_and_the_brakes_catch_the_arm() {
    for at_s in [0.5, 0.5005, 0.501, 0.5015] {
        let run = run(&lift(&[Injection::new(Kind::Hang, Target::Only, at_s)]));
        let open_s = run.time_of(OPEN).expect("the watchdog trips") - at_s;
        assert!((6e-3..=8.6e-3 + TICK_S).contains(&open_s), "{open_s}");
        let before = run.since(at_s).iter().take_while(|f| f.chain_closed).last().expect("a step");
        assert!(before.pins.sto && before.torque[1] != 0.0);
        let after = run.since(at_s + open_s);
        assert!(after.iter().all(|f| f.torque == [0.0; 4] && f.pins.sto && !f.ticked));
        let held = run.since(at_s + open_s + 0.3);
        assert!(held.iter().all(|f| f.qd == [0.0; 4]), "the brakes hold");
    }
}

#[test]
fn early_kick_opens_the_chain_at_once_and_for_good() {
    let run = run_on(&lift(&[Injection::new(Kind::EarlyKick, Target::Only, 0.5)]), 0.5, &[]);
    let open_s = run.time_of(OPEN).expect("the watchdog trips");
    assert!((0.5..0.5 + 2.5e-3).contains(&open_s), "{open_s}");
    assert!(run.since(open_s).iter().all(|f| !f.chain_closed && f.torque == [0.0; 4]));
}

#[test]
fn pressed_stop_opens_the_chain_after_half_a_second_and_its_release_closes_it() {
    let pressed = Injection { for_s: Some(0.8), ..Injection::new(Kind::EStop, Target::Only, 0.2) };
    let run = run_on(&rest(&[pressed]), 1.0, &[]);
    assert_eq!(run.mode_at_end(), Some(Mode::Latched));
    let (reported_s, fault, _) = run.first_fault().expect("a stop");
    assert_eq!(fault, Fault::EmergencyStop);
    assert!(reported_s - 0.2 < 1.5 * TICK_S, "{reported_s}");
    let open = |t_s: f64| !run.since(t_s)[0].chain_closed;
    assert_eq!([0.69, 0.702, 0.99, 1.002].map(open), [false, true, true, false]);
}

#[test]
fn stop_that_the_firmware_never_sees_is_the_relays_business() {
    let faults = [Kind::Hang, Kind::EStop].map(|kind| Injection::new(kind, Target::Only, 0.5));
    let run = run(&lift(&faults));
    assert!(run.first_fault().is_none());
    assert!(run.since(1.01).iter().all(|f| !f.chain_closed));
}

#[test]
fn without_faults_the_chain_closes_in_boot_and_stays_closed() {
    let run = run(&lift(&[]));
    let closed = run.tape.frames.iter().map(|f| f.chain_closed).collect::<Vec<_>>();
    let first = closed.iter().position(|closed| *closed).expect("it closes");
    assert!((0.005..0.02).contains(&(first as f64 * TICK_S)), "step {first}");
    assert!(closed[first..].iter().all(|closed| *closed));
    assert!(run.tape.frames[..first].iter().all(|f| f.torque == [0.0; 4]));
}
