//! Strokes, contacts and grips.

use super::*;
use shared::arm::REFERENCE;

const STILL: Joints = [0.0; 4];

/// Ticks at this rate until the feedback of joint 2 changes.
fn ticks_until(brakes: &mut Brakes, released: bool, hz: f64) -> u32 {
    (1..10_000)
        .find(|_| {
            brakes.advance(&[released; 4], 1.0 / hz, &STILL);
            brakes.released()[1] == released
        })
        .unwrap()
}

#[test]
fn opening_takes_150_ms_and_closing_100_ms_at_every_rate() {
    for hz in [1000.0, 2000.0, 4000.0, 8000.0] {
        let mut brakes = Brakes::closed(&REFERENCE.limits);
        assert_eq!(ticks_until(&mut brakes, true, hz), (0.150 * hz) as u32);
        assert_eq!(ticks_until(&mut brakes, false, hz), (0.100 * hz) as u32);
    }
}

#[test]
fn command_withdrawn_half_way_leaves_the_grip_as_it_was() {
    let mut brakes = Brakes::closed(&REFERENCE.limits);
    brakes.advance(&[true; 4], 0.149, &STILL);
    brakes.advance(&[false; 4], 0.010, &STILL);
    assert_eq!(brakes.locked(), [true; 4]);
    let mut brakes = Brakes::open(&REFERENCE.limits);
    brakes.advance(&[false; 4], 0.099, &STILL);
    brakes.advance(&[true; 4], 0.010, &STILL);
    assert_eq!(brakes.released(), [true; 4]);
}

#[test]
fn closing_on_motion_slides_against_it_with_one_and_a_half_times_the_limit() {
    let mut brakes = Brakes::open(&REFERENCE.limits);
    brakes.advance(&[false, false, false, true], 0.100, &[0.1, -0.1, 0.0, 0.1]);
    assert_eq!(brakes.drag(), [-45_000.0, 180_000.0, 0.0, 0.0]);
    assert_eq!(brakes.locked(), [false, false, true, false]);
}

#[test]
fn overloaded_brake_slides_in_the_direction_of_the_load() {
    let mut brakes = Brakes::closed(&REFERENCE.limits);
    brakes.break_away(&[44_999.0, 180_001.0, -105_001.0, 0.0]);
    assert_eq!(brakes.locked(), [true, false, false, true]);
    assert_eq!(brakes.drag(), [0.0, 180_000.0, -105_000.0, 0.0]);
}

fn faulty(mut brakes: Brakes, fault: BrakeFault) -> Brakes {
    brakes.set_fault(1, fault);
    brakes
}

#[test]
fn jammed_brake_stays_shut_and_its_contact_tells_unless_it_sticks() {
    let jammed = BrakeFault { jammed: true, ..BrakeFault::NONE };
    for (contact, told) in [(None, false), (Some(true), true)] {
        let fault = BrakeFault { contact, ..jammed };
        let mut brakes = faulty(Brakes::closed(&REFERENCE.limits), fault);
        brakes.advance(&[true; 4], 1.0, &STILL);
        assert_eq!(brakes.locked(), [false, true, false, false]);
        assert_eq!(brakes.released(), [true, told, true, true]);
    }
}

#[test]
fn jam_does_not_shut_an_open_brake_but_keeps_it_shut_once_it_was_set() {
    let jammed = BrakeFault { jammed: true, ..BrakeFault::NONE };
    let mut brakes = faulty(Brakes::open(&REFERENCE.limits), jammed);
    brakes.advance(&[true; 4], 1.0, &STILL);
    assert_eq!(brakes.released(), [true; 4]);
    brakes.advance(&[false; 4], 0.1, &STILL);
    brakes.advance(&[true; 4], 1.0, &STILL);
    assert_eq!(brakes.locked(), [false, true, false, false]);
}

#[test]
fn brake_that_is_stuck_open_never_sets() {
    let fault = BrakeFault { stuck_open: true, ..BrakeFault::NONE };
    let mut brakes = faulty(Brakes::open(&REFERENCE.limits), fault);
    brakes.advance(&[false; 4], 1.0, &STILL);
    assert_eq!(brakes.locked(), [true, false, true, true]);
    assert_eq!(brakes.released(), [false, true, false, false]);
}

#[test]
fn worn_brake_holds_and_drags_with_the_share_that_is_left() {
    let fault = BrakeFault { holding: 0.1, ..BrakeFault::NONE };
    let mut brakes = faulty(Brakes::closed(&REFERENCE.limits), fault);
    brakes.break_away(&[0.0, 17_999.0, 0.0, 0.0]);
    assert_eq!(brakes.locked(), [true; 4]);
    brakes.break_away(&[0.0, 18_001.0, 0.0, 0.0]);
    assert_eq!(brakes.locked(), [true, false, true, true]);
    assert_eq!(brakes.drag(), [0.0, 18_000.0, 0.0, 0.0]);
}

#[test]
fn first_of_two_stops_is_found_with_its_share() {
    let mut brakes = Brakes::open(&REFERENCE.limits);
    let before = [0.3, -0.2, 0.1, 0.0];
    brakes.advance(&[false; 4], 0.100, &before);
    assert_eq!(brakes.first_stop(&before, &[0.1, -0.1, 0.05, 0.0]), None);
    assert_eq!(brakes.first_stop(&before, &[-0.1, 0.2, 0.05, 0.0]), Some((1, 0.5)));
}
