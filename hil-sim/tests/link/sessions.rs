//! Who is heard: repetitions, wrong keys, old sessions and several consoles.

use hil_sim::console::{Console, KEY};
use shared::command::Command;
use shared::fault::LinkRefusal;
use shared::link::{Frame, QueryKind};

use super::rig::{NOTHING, Rig, console};

/// Everything that one operator sent in a session, in order.
fn recorded(rig: &mut Rig, console: &mut Console) -> Vec<Frame> {
    let mut frames = vec![console.hello()];
    rig.greet(console);
    frames.extend([
        console.heartbeat(),
        console.command(&Command::Arm),
        console.command(&Command::Jog([0.01; 4])),
        console.command(&Command::SetGain { name: 0, values: [45.0; 4] }),
        console.query(QueryKind::State, 0),
        console.command(&Command::Clear),
        console.command(&Command::ConfirmPose),
    ]);
    for frame in &frames[1..] {
        assert_ne!(rig.send(&frame.to_wire()), NOTHING);
        rig.tick(0);
    }
    frames
}

#[test]
fn no_recorded_frame_has_an_effect_again() {
    let (mut rig, mut console) = (Rig::new(KEY, 1), console(1));
    let frames = recorded(&mut rig, &mut console);
    // Forwards twice, since the Hello opens a candidate, and backwards.
    for frame in frames.iter().chain(&frames).chain(frames.iter().rev()) {
        assert_eq!(rig.send(&frame.to_wire()), NOTHING, "{frame:?}");
    }
    let heartbeat = console.heartbeat();
    assert!(rig.send(&heartbeat.to_wire()).alive, "the operator is heard as before");
}

#[test]
fn no_recorded_frame_has_an_effect_after_another_boot() {
    let frames = recorded(&mut Rig::new(KEY, 1), &mut console(1));
    let mut rig = Rig::new(KEY, 2);
    for frame in frames.iter().chain(&frames) {
        assert_eq!(rig.send(&frame.to_wire()), NOTHING, "{frame:?}");
    }
}

/// The same challenge in the same boot makes another key, because the count of Hellos is part of it.
#[test]
fn no_recorded_frame_has_an_effect_in_a_session_with_the_same_challenge() {
    let (mut rig, mut first) = (Rig::new(KEY, 1), console(1));
    let frames = recorded(&mut rig, &mut first);
    rig.greet(&mut console(1));
    for frame in &frames {
        assert_eq!(rig.send(&frame.to_wire()), NOTHING, "{frame:?}");
    }
}

#[test]
fn a_stale_counter_is_refused_although_its_code_is_right() {
    let (mut rig, mut console) = Rig::in_session();
    let (early, late) = (console.heartbeat(), console.heartbeat());
    assert!(rig.send(&late.to_wire()).alive);
    rig.tick(0);
    for frame in [early, late] {
        assert_eq!(rig.send(&frame.to_wire()), NOTHING);
        let refused = (frame.kind, frame.counter, LinkRefusal::Stale as u8);
        assert_eq!(rig.answer_to(&mut console), refused);
    }
}

#[test]
fn another_key_opens_no_session_and_orders_nothing() {
    let (mut rig, mut console) = Rig::in_session();
    let mut other = Console::new([9; 32], [2; 16], 2_000);
    let hello = other.hello();
    assert_eq!(rig.send(&hello.to_wire()), NOTHING);
    assert_eq!(rig.answer_to(&mut console).2, LinkRefusal::BadCode as u8);
    let arm = other.command(&Command::Arm);
    assert_eq!(rig.send(&arm.to_wire()), NOTHING);
    assert_eq!(rig.answer_to(&mut console).2, LinkRefusal::BadCode as u8);
}

#[test]
fn a_repeated_hello_takes_nothing_over_but_another_operator_does() {
    let (mut rig, mut first) = Rig::in_session();
    let hello = first.hello();
    for _ in 0..3 {
        assert_eq!(rig.send(&hello.to_wire()), NOTHING);
    }
    let heartbeat = first.heartbeat();
    assert!(rig.send(&heartbeat.to_wire()).alive);
    rig.tick(0);
    let mut second = console(2);
    rig.greet(&mut second);
    let arm = first.command(&Command::Arm);
    assert_eq!(rig.send(&arm.to_wire()), NOTHING);
    assert_eq!(rig.answer_to(&mut second).2, LinkRefusal::BadCode as u8);
}

#[test]
fn a_console_greets_a_board_again_that_was_reset() {
    let (_, mut console) = Rig::in_session();
    let mut rig = Rig::new(KEY, 4);
    // A heartbeat that nobody knows, a Hello, a heartbeat.
    let mut alive = false;
    for _ in 0..3 {
        alive = rig.send(&console.speak(None)).alive;
        rig.heard_by(&mut console);
    }
    assert!(alive && console.is_in_session());
}
